//! The bounding volume hierarchy: 8-wide nodes over leaves of up to 16 triangles.
//!
//! A binary tree is split by the binned surface area heuristic ([`build`]), then collapsed to 8-wide nodes whose
//! leaves are little meshes of their own ([`node`], [`collapse`]): the triangles of a leaf share its vertices, so
//! that a kernel transforms each vertex once. Leaves are large because the kernels test 16 triangles about as
//! fast as 4. Every step gives the same bytes for any number of threads.

mod build;
mod collapse;
mod node;
mod stats;
mod validate;

use glam::Vec3;

pub use node::{Child, Leaf, Line, MAX_LEAF, MAX_LEAF_VERTICES, Node};
pub use stats::BvhStats;
pub use validate::Invalid;

use crate::geometry::{Aabb, is_degenerate};
use crate::scene::Triangle;

/// A tree over the triangles that have an area.
#[derive(Debug)]
pub struct Bvh {
    /// Interior nodes; the root is the first. Empty when there is no triangle.
    pub nodes: Vec<Node>,
    /// The leaves, see [`Leaf`].
    pub lines: Vec<Line>,
    /// The file's number of each triangle, in the order of the leaves.
    pub file_ids: Vec<u32>,
    /// The box of all triangles in the tree.
    pub bounds: Aabb,
}

impl Bvh {
    /// Builds the tree, in parallel on the current rayon pool. Degenerate triangles are left out.
    ///
    /// # Panics
    /// Beyond 2³² triangles or 2²⁷ lines of leaves (8 GiB).
    #[must_use]
    pub fn build(triangles: &[Triangle]) -> Bvh {
        let tree = build::build(triangles);
        collapse::collapse(triangles, tree)
    }

    /// The leaf that starts at line `first`.
    #[inline(always)]
    #[must_use]
    pub fn leaf(&self, first: usize) -> Leaf<'_> {
        Leaf::new(&self.lines[first..])
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

/// Which triangles a tree is built over: their numbers in the file, ascending.
fn solid(triangles: &[Triangle]) -> Vec<u32> {
    assert!(
        u32::try_from(triangles.len()).is_ok(),
        "triangle numbers are 32 bits wide"
    );
    (0u32..)
        .zip(triangles)
        .filter(|(_, t)| !is_degenerate(&t.corners))
        .map(|(i, _)| i)
        .collect()
}
