//! The binary tree: binned surface area heuristic.
//!
//! Source: Wald, "On fast construction of SAH-based bounding volume hierarchies", 2007. Subtrees are built in
//! parallel in memory laid out beforehand (a subtree over n triangles has at most 2n − 1 nodes), so neither the
//! tree nor its order depends on the threads.

use glam::{Vec4, Vec4Swizzles};
use rayon::prelude::*;

use super::{MAX_LEAF, solid};
use crate::geometry::Aabb;
use crate::scene::Triangle;

/// Bins of an axis; for ranges of few triangles, [`FEW_BINS`].
const BINS: usize = 16;
/// Bins for ranges below twice as many triangles as [`BINS`]: setting up more costs more than it finds.
const FEW_BINS: usize = 8;
/// At this size a range is not worth splitting.
const SMALL_LEAF: usize = 4;
/// What one step through a node costs, in triangle tests. The kernels test 16 triangles nearly as fast as one.
const NODE_COST: f32 = 8.0;
/// Ranges above this are built by another thread if one is free.
const PARALLEL_SPLIT: usize = 4096;
/// Ranges above this are binned and measured in pieces of this size.
const PARALLEL_BIN: usize = 1 << 16;

/// A triangle while the tree is built.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ref {
    /// Smallest coordinates; the fourth number is the low half of the triangle's number in the file.
    min: Vec4,
    /// Largest coordinates; the fourth is the high half. (As numbers, not as bits: small numbers' bits are denormal
    /// floats, and arithmetic that drags them along takes three times as long.)
    max: Vec4,
}

impl Ref {
    fn new(triangle: &Triangle, id: u32) -> Ref {
        let [a, b, c] = triangle.corners;
        Ref {
            min: a.min(b).min(c).extend((id & 0xffff) as f32),
            max: a.max(b).max(c).extend((id >> 16) as f32),
        }
    }

    pub(super) fn id(&self) -> u32 {
        (self.max.w as u32) << 16 | self.min.w as u32
    }

    /// Half of each bound first: the sum may be beyond the range of `f32`.
    fn centroid(&self) -> Vec4 {
        self.min * 0.5 + self.max * 0.5
    }
}

/// A box in four lanes; the fourth is meaningless.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    min: Vec4,
    max: Vec4,
}

impl Bounds {
    const EMPTY: Bounds = Bounds {
        min: Vec4::INFINITY,
        max: Vec4::NEG_INFINITY,
    };

    fn grow(&mut self, min: Vec4, max: Vec4) {
        self.min = self.min.min(min);
        self.max = self.max.max(max);
    }

    fn join(mut self, other: Bounds) -> Bounds {
        self.grow(other.min, other.max);
        self
    }

    fn aabb(&self) -> Aabb {
        Aabb {
            min: self.min.xyz(),
            max: self.max.xyz(),
        }
    }
}

/// The box of a range and the box of its centroids.
#[derive(Clone, Copy, Debug)]
struct Extent {
    bounds: Bounds,
    centroids: Bounds,
}

impl Extent {
    const EMPTY: Extent = Extent {
        bounds: Bounds::EMPTY,
        centroids: Bounds::EMPTY,
    };

    fn add(&mut self, r: &Ref) {
        let c = r.centroid();
        self.bounds.grow(r.min, r.max);
        self.centroids.grow(c, c);
    }

    fn join(self, other: Extent) -> Extent {
        Extent {
            bounds: self.bounds.join(other.bounds),
            centroids: self.centroids.join(other.centroids),
        }
    }

    fn of(refs: &[Ref]) -> Extent {
        let piece = |refs: &[Ref]| {
            let mut e = Extent::EMPTY;
            refs.iter().for_each(|r| e.add(r));
            e
        };
        if refs.len() <= PARALLEL_BIN {
            return piece(refs);
        }
        refs.par_chunks(PARALLEL_BIN)
            .map(piece)
            .reduce(|| Extent::EMPTY, Extent::join)
    }
}

/// A node of the binary tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct BinaryNode {
    pub(super) bounds: Aabb,
    /// Leaf: the first triangle's place in [`Tree::refs`]. Interior: how far behind this node its right child
    /// lies; the left one is the next node.
    pub(super) first_or_right: u32,
    /// Triangles below this node; interior nodes too.
    pub(super) count: u32,
    pub(super) is_leaf: bool,
}

impl BinaryNode {
    const UNUSED: BinaryNode = BinaryNode {
        bounds: Aabb::EMPTY,
        first_or_right: 0,
        count: 0,
        is_leaf: true,
    };
}

/// The binary tree: `nodes[0]` is the root (absent without triangles), leaves are ranges of `refs`.
pub(super) struct Tree {
    pub(super) nodes: Vec<BinaryNode>,
    pub(super) refs: Vec<Ref>,
    pub(super) bounds: Aabb,
}

pub(super) fn build(triangles: &[Triangle]) -> Tree {
    let mut refs: Vec<Ref> = solid(triangles)
        .into_par_iter()
        .map(|id| Ref::new(&triangles[id as usize], id))
        .collect();
    if refs.is_empty() {
        return Tree {
            nodes: Vec::new(),
            refs,
            bounds: Aabb::EMPTY,
        };
    }
    let extent = Extent::of(&refs);
    let bounds = extent.bounds.aabb();
    let size = (bounds.max.as_dvec3() - bounds.min.as_dvec3()).max_element();
    let builder = Builder {
        // Areas of very large or very small scenes would leave the range of f32.
        scale: Vec4::splat((1.0 / size) as f32),
    };
    let mut nodes = vec![BinaryNode::UNUSED; 2 * refs.len() - 1];
    builder.subtree(&mut nodes, &mut refs, 0, extent);
    Tree {
        nodes,
        refs,
        bounds,
    }
}

struct Builder {
    scale: Vec4,
}

/// Where to cut: ranges with a bin number of at most `last_left` along `axis` go left.
struct Split {
    axis: usize,
    last_left: usize,
    binning: Binning,
    /// Area times count, summed over both sides.
    cost: f32,
}

/// From centroids to bin numbers.
#[derive(Clone, Copy)]
struct Binning {
    origin: Vec4,
    factor: Vec4,
}

impl Binning {
    fn new(centroids: Bounds, bins: usize) -> Binning {
        let size = centroids.max - centroids.min;
        let factor = |d: f32| {
            // A little less than the last bin's number, so that the largest centroid stays below its upper end.
            let f = (bins - 1) as f32 * 0.9999 / d;
            if d > 0.0 && f.is_finite() { f } else { 0.0 }
        };
        Binning {
            origin: centroids.min,
            factor: Vec4::new(factor(size.x), factor(size.y), factor(size.z), 0.0),
        }
    }

    /// The bin on each axis, below [`BINS`]: the nearest of evenly spaced centres.
    #[inline(always)]
    fn bins_of(&self, r: &Ref) -> [usize; 3] {
        // Beyond 2²³ an f32 has no fraction: its low bits are the rounded number. Cheaper than a conversion.
        let b = (r.centroid() - self.origin) * self.factor + Vec4::splat(8_388_608.0);
        [b.x, b.y, b.z].map(|b| b.to_bits() as usize % BINS)
    }

    /// The bin on one axis.
    #[inline(always)]
    fn bin_of(&self, r: &Ref, axis: usize) -> usize {
        self.bins_of(r)[axis]
    }
}

#[derive(Clone, Copy)]
struct Bin {
    bounds: Bounds,
    count: u32,
}

/// The bins of three axes.
type Bins<const N: usize> = [[Bin; N]; 3];

fn bin_piece<const N: usize>(refs: &[Ref], binning: Binning) -> Bins<N> {
    let empty = Bin {
        bounds: Bounds::EMPTY,
        count: 0,
    };
    let mut bins = [[empty; N]; 3];
    for r in refs {
        for (row, i) in bins.iter_mut().zip(binning.bins_of(r)) {
            let bin = &mut row[i % N];
            bin.bounds.grow(r.min, r.max);
            bin.count += 1;
        }
    }
    bins
}

fn bin<const N: usize>(refs: &[Ref], binning: Binning) -> Bins<N> {
    if refs.len() <= PARALLEL_BIN {
        return bin_piece(refs, binning);
    }
    refs.par_chunks(PARALLEL_BIN)
        .map(|piece| bin_piece(piece, binning))
        .reduce_with(|mut a: Bins<N>, b| {
            for (a, b) in a.iter_mut().flatten().zip(b.iter().flatten()) {
                a.bounds = a.bounds.join(b.bounds);
                a.count += b.count;
            }
            a
        })
        .expect("a large range has pieces")
}

impl Builder {
    fn area(&self, bounds: &Bounds) -> f32 {
        let d = ((bounds.max - bounds.min) * self.scale).max(Vec4::ZERO);
        d.x * d.y + d.y * d.z + d.z * d.x
    }

    /// Builds the subtree over `refs`, whose first is number `first` of all, into `nodes` (2n − 1 places).
    fn subtree(&self, nodes: &mut [BinaryNode], refs: &mut [Ref], first: usize, extent: Extent) {
        let n = refs.len();
        let bounds = extent.bounds.aabb();
        let split = (n > SMALL_LEAF)
            .then(|| self.best_split(refs, extent))
            .flatten();
        let worth = |s: &Split| {
            let area = self.area(&extent.bounds);
            NODE_COST * area + s.cost < area * n as f32
        };
        if n <= SMALL_LEAF || (n <= MAX_LEAF && !split.as_ref().is_some_and(worth)) {
            nodes[0] = BinaryNode {
                bounds,
                first_or_right: first as u32,
                count: n as u32,
                is_leaf: true,
            };
            return;
        }
        let (middle, left, right) = match split {
            Some(split) => partition(refs, &split),
            // All centroids in one place: any half is as good as any other.
            None => {
                let (a, b) = refs.split_at(n / 2);
                (n / 2, Extent::of(a), Extent::of(b))
            }
        };
        nodes[0] = BinaryNode {
            bounds,
            first_or_right: 2 * middle as u32,
            count: n as u32,
            is_leaf: false,
        };
        let (left_nodes, right_nodes) = nodes[1..].split_at_mut(2 * middle - 1);
        let (left_refs, right_refs) = refs.split_at_mut(middle);
        let mut build_left = || self.subtree(left_nodes, left_refs, first, left);
        let mut build_right = || self.subtree(right_nodes, right_refs, first + middle, right);
        if n > PARALLEL_SPLIT {
            rayon::join(build_left, build_right);
        } else {
            build_left();
            build_right();
        }
    }

    /// The cheapest cut, or `None` when all centroids share a bin on every axis.
    fn best_split(&self, refs: &[Ref], extent: Extent) -> Option<Split> {
        if refs.len() < 2 * BINS {
            self.best_of_bins::<FEW_BINS>(refs, extent)
        } else {
            self.best_of_bins::<BINS>(refs, extent)
        }
    }

    /// The cheapest of the cuts between `N` bins on each axis.
    fn best_of_bins<const N: usize>(&self, refs: &[Ref], extent: Extent) -> Option<Split> {
        let binning = Binning::new(extent.centroids, N);
        let bins = bin::<N>(refs, binning);
        let (mut cost, mut axis, mut last_left) = (f32::INFINITY, 0, 0);
        for (this_axis, bins) in bins.iter().enumerate() {
            // What lies right of each cut, from the right.
            let mut right = [(0.0f32, 0u32); N];
            let (mut bounds, mut count) = (Bounds::EMPTY, 0);
            for i in (1..N).rev() {
                bounds = bounds.join(bins[i].bounds);
                count += bins[i].count;
                right[i - 1] = (self.area(&bounds) * count as f32, count);
            }
            let (mut bounds, mut count) = (Bounds::EMPTY, 0);
            for (i, bin) in bins[..N - 1].iter().enumerate() {
                bounds = bounds.join(bin.bounds);
                count += bin.count;
                let this_cost = self.area(&bounds) * count as f32 + right[i].0;
                if this_cost < cost && count > 0 && right[i].1 > 0 {
                    (cost, axis, last_left) = (this_cost, this_axis, i);
                }
            }
        }
        (cost < f32::INFINITY).then_some(Split {
            axis,
            last_left,
            binning,
            cost,
        })
    }
}

/// Reorders `refs` so that the left side comes first; its length and both extents.
fn partition(refs: &mut [Ref], split: &Split) -> (usize, Extent, Extent) {
    let (mut left, mut right) = (Extent::EMPTY, Extent::EMPTY);
    let goes_left = |r: &Ref| split.binning.bin_of(r, split.axis) <= split.last_left;
    let (mut i, mut j) = (0, refs.len());
    while i < j {
        if goes_left(&refs[i]) {
            left.add(&refs[i]);
            i += 1;
        } else {
            j -= 1;
            right.add(&refs[i]);
            refs.swap(i, j);
        }
    }
    (i, left, right)
}
