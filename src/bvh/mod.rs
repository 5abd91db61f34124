//! The bounding volume hierarchy: 8-wide nodes over leaves of up to 16 triangles.
//!
//! Leaves are little meshes of their own ([`node`]): their triangles share vertices, so that a kernel transforms
//! each vertex once. They are large because the kernels test 16 triangles about as fast as 4. There are two builders:
//! [`fine`] looks for cuts that make frames fast, [`coarse`] is there when the first picture must not wait. Both
//! start from the triangles in Morton order ([`morton`]), write nodes and leaves at once ([`emit`]) and give the same
//! bytes for any number of threads. What can never be seen is left out: triangles without an area, and copies of
//! others where they gather ([`copies`]).

mod binned;
mod coarse;
mod copies;
mod emit;
mod fine;
mod morton;
mod node;
mod pack;
mod prim;
mod radix;
mod stats;
mod validate;

use std::ops::Range;

use glam::Vec3;

use fine::LeafShape;
pub use node::{Child, Leaf, Line, MAX_LEAF, MAX_LEAF_VERTICES, Node};
pub use stats::BvhStats;
pub use validate::Invalid;

use crate::geometry::Aabb;
use crate::raw::{Pages, prefetch};
use crate::scene::Triangle;
use crate::watch::{Cancelled, Watch};

/// How much work goes into a tree. What is hit does not depend on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quality {
    /// Frames are as fast as they can be.
    Fine,
    /// The tree is there as soon as it can be.
    Coarse,
}

/// Appends one record for each of the triangles with these numbers.
pub type PartRecords<'a, R> = dyn Fn(&[u32], &mut Pages<R>) + Sync + 'a;

/// None.
const NO_RECORDS: &PartRecords<()> = &|_, _| {};

/// A tree over the triangles that have an area.
#[derive(Debug)]
pub struct Bvh {
    /// Interior nodes; the root is the first. Empty when there is no triangle.
    pub nodes: Pages<Node>,
    /// The leaves, see [`Leaf`].
    pub lines: Pages<Line>,
    /// The file's number of each triangle, in the order of the leaves.
    pub file_ids: Pages<u32>,
    /// The box of all triangles in the tree.
    pub bounds: Aabb,
    /// Triangles left out because one with a lower number has the very same corners.
    pub copies: usize,
}

/// Asks for the corners of triangle `number`: they may lie in two lines.
#[inline(always)]
fn prefetch_triangle(triangles: &[Triangle], number: u32) {
    prefetch(triangles, number as usize, 0);
    prefetch(triangles, number as usize + 1, 0);
}

impl Bvh {
    /// Builds the tree for fast frames, in parallel on the current rayon pool. Degenerate triangles are left out, and
    /// copies of others where many triangles share a place.
    ///
    /// # Panics
    /// Beyond 2³² triangles or 2²⁷ lines of leaves (8 GiB).
    #[must_use]
    pub fn build(triangles: &[Triangle]) -> Bvh {
        Bvh::with_quality(triangles, Quality::Fine)
    }

    /// Builds a tree in a fraction of the time, with which frames take longer.
    ///
    /// # Panics
    /// As [`Bvh::build`].
    #[must_use]
    pub fn build_coarse(triangles: &[Triangle]) -> Bvh {
        Bvh::with_quality(triangles, Quality::Coarse)
    }

    fn with_quality(triangles: &[Triangle], quality: Quality) -> Bvh {
        Bvh::build_with(triangles, quality, NO_RECORDS, Watch::NOBODY)
            .expect("nobody cancels")
            .0
    }

    /// Builds a tree for rays that go alone or in small groups: of leaves with at most 8 triangles. Copies stay.
    ///
    /// # Panics
    /// As [`Bvh::build`].
    #[must_use]
    pub fn build_for_rays(triangles: &[Triangle]) -> Bvh {
        Bvh::over(morton::sort_all(triangles), |sorted| {
            fine::build(
                triangles,
                sorted,
                LeafShape::RAYS,
                NO_RECORDS,
                Watch::NOBODY,
            )
        })
        .expect("nobody cancels")
        .0
    }

    /// Builds a tree, and something for every triangle in the order of the leaves: `records` makes it for one part of
    /// them after the other, while their triangles are still in the cache.
    ///
    /// # Errors
    /// [`Cancelled`] when `watch` says so; it is not told how far the tree is.
    ///
    /// # Panics
    /// As [`Bvh::build`].
    pub fn build_with<R: Copy + Send + Sync>(
        triangles: &[Triangle],
        quality: Quality,
        records: &PartRecords<R>,
        watch: Watch<'_>,
    ) -> Result<(Bvh, Pages<R>), Cancelled> {
        let mut sorted = morton::sort_all(triangles);
        watch.check()?;
        let mut copies = 0;
        if sorted.crowded {
            copies = copies::drop_copies(triangles, &mut sorted.keys);
        }
        let (bvh, records) = Bvh::over(sorted, |sorted| match quality {
            Quality::Fine => fine::build(triangles, sorted, LeafShape::TILES, records, watch),
            Quality::Coarse => coarse::build(triangles, sorted, records, watch),
        })?;
        Ok((Bvh { copies, ..bvh }, records))
    }

    /// Hands the triangles to `build`; without any there is nothing to build.
    fn over<R: Copy>(
        sorted: morton::Sorted,
        build: impl FnOnce(morton::Sorted) -> Result<(Bvh, Pages<R>), Cancelled>,
    ) -> Result<(Bvh, Pages<R>), Cancelled> {
        if !sorted.keys.is_empty() {
            return build(sorted);
        }
        let empty = Bvh {
            nodes: Pages::new(),
            lines: Pages::new(),
            file_ids: Pages::new(),
            bounds: Aabb::EMPTY,
            copies: 0,
        };
        Ok((empty, Pages::new()))
    }

    /// The leaf that starts at line `first`.
    #[inline(always)]
    #[must_use]
    pub fn leaf(&self, first: usize) -> Leaf<'_> {
        Leaf::new(&self.lines[first..])
    }

    /// Asks for all lines of a child, so that they are there when it is looked at.
    #[inline(always)]
    pub fn prefetch(&self, child: Child) {
        if child.is_leaf() {
            let fetch = |lines: Range<usize>| {
                for line in lines {
                    prefetch(&self.lines, child.index(), line);
                }
            };
            // Fixed lengths: the end of one loop over all of them is hard to predict.
            fetch(0..4);
            if child.chunks() > 1 {
                fetch(4..7);
            }
            if child.chunks() > 2 {
                fetch(7..10);
            }
        } else {
            for line in 0..size_of::<Node>() / 64 {
                prefetch(&self.nodes, child.index(), line);
            }
        }
    }

    /// All leaves, in the order of their lines.
    pub fn leaves(&self) -> impl Iterator<Item = Leaf<'_>> {
        let mut at = 0;
        std::iter::from_fn(move || {
            (at < self.lines.len()).then(|| {
                let leaf = self.leaf(at);
                at += leaf.line_count();
                leaf
            })
        })
    }

    /// The corners of every triangle in the order of the leaves: `file_ids` has their numbers.
    #[must_use]
    pub fn corners(&self) -> Vec<[Vec3; 3]> {
        let mut out = Vec::with_capacity(self.file_ids.len());
        for leaf in self.leaves() {
            out.extend((0..leaf.count()).map(|i| leaf.corners(i)));
        }
        out
    }
}
