//! The good tree: binned surface area heuristic, first over small cells of the Morton curve, then over triangles.
//!
//! Looking at every triangle on every level is what makes such trees slow to build. Far above the leaves a few
//! neighbouring triangles are as good as one: so the upper levels sort clusters of them, and only sets of about a
//! thousand triangles, which fit the first-level cache with everything they need, are sorted one by one. Nodes and
//! leaves are written at once, eight children at a time; there is no binary tree. Sources: Wald, "On fast
//! construction of SAH-based bounding volume hierarchies", 2007; Garanzha, Pantaleoni, McAllister, "Simpler and
//! faster HLBVH with work queues", 2011.

use rayon::prelude::*;

use super::binned::{Set, Split};
use super::emit::{Branch, Piece, Top, assemble};
use super::morton::{self, Key, Sorted};
use super::node::{MAX_LEAF, WIDTH};
use super::prim::Prim;
use super::{Bvh, PartRecords, prefetch_triangle};
use crate::raw::Pages;
use crate::scene::Triangle;
use crate::simd::{Kernel, Simd, dispatch};
use crate::watch::{Cancelled, Watch};

/// What leaves should be like.
#[derive(Clone, Copy, Debug)]
pub(super) struct LeafShape {
    /// Triangles at most, up to [`MAX_LEAF`].
    pub(super) most: usize,
    /// What one step through a node costs, in triangle tests.
    pub(super) node_cost: u32,
}

impl LeafShape {
    /// For tiles of rays: their kernels test 16 triangles nearly as fast as one.
    pub(super) const TILES: LeafShape = LeafShape {
        most: MAX_LEAF,
        node_cost: 8,
    };
    /// For rays that go alone or in small groups.
    pub(super) const RAYS: LeafShape = LeafShape {
        most: 8,
        node_cost: 4,
    };
}
/// Triangles of a cluster at most, but for those in one cell of the finest grid.
const CLUSTER: usize = 16;
/// Sets of at most this many triangles are sorted triangle by triangle.
const PART: usize = 1 << 10;
/// Sets of clusters with at most this many triangles are not cut.
const SMALL_PART: u32 = 64;
/// Ranges of keys that one thread clusters.
const CLUSTER_RANGE: usize = 1 << 14;
/// The children of nodes above more triangles than this are built by other threads if some are free.
const PARALLEL: u32 = 1 << 14;
/// Below this many nodes sets are halved without looking: it bounds the depth whatever the triangles are.
const MAX_DEPTH: usize = 24;
/// So many triangles ahead of their use their lines are asked for.
const AHEAD: usize = 16;

pub(super) fn build<R: Copy + Send + Sync>(
    triangles: &[Triangle],
    sorted: Sorted,
    shape: LeafShape,
    records: &PartRecords<R>,
    watch: Watch<'_>,
) -> Result<(Bvh, Pages<R>), Cancelled> {
    let bounds = sorted.bounds;
    let size = (bounds.max.as_dvec3() - bounds.min.as_dvec3()).max_element();
    let fine = Fine {
        triangles,
        shape,
        // Areas of very large or very small scenes would leave the range of f32.
        scale: ((1.0 / size) as f32).min(f32::MAX),
        watch,
    };
    let kernel = Kernel::best();
    let top = dispatch!(kernel, simd => fine.top_of_keys(simd, &sorted.keys))?;
    let room = sorted.spare.reused();
    drop(sorted.keys);
    let write = |piece: &mut Piece, parts: &[Vec<u32>]| {
        let mut rooms = (Vec::new(), Vec::new());
        for part in parts {
            watch.check()?;
            let root = dispatch!(kernel, simd => fine.part(simd, piece, part, &mut rooms));
            piece.finish_part(root);
        }
        Ok(())
    };
    assemble(triangles, bounds, top, Vec::len, write, records, room)
}

struct Fine<'a> {
    triangles: &'a [Triangle],
    shape: LeafShape,
    scale: f32,
    watch: Watch<'a>,
}

/// A set on its way to become a node or leaf.
struct Candidate<'a> {
    set: Set<'a>,
    area: f32,
    fate: Fate,
}

/// One to eight sets in an order. They stay where they are while the order changes: they are large.
struct Children<'a> {
    slots: [Option<Candidate<'a>>; WIDTH],
    /// The slots of the first `count`.
    order: [u8; WIDTH],
    count: usize,
}

impl<'a> Children<'a> {
    fn new(only: Candidate<'a>) -> Children<'a> {
        let mut slots = [const { None }; WIDTH];
        slots[0] = Some(only);
        Children {
            slots,
            order: [0; WIDTH],
            count: 1,
        }
    }

    fn slot(&mut self, place: usize) -> &mut Option<Candidate<'a>> {
        &mut self.slots[usize::from(self.order[place])]
    }

    /// Both sides of what was at `place`, in its place and behind it.
    fn put(&mut self, place: usize, [left, right]: [Candidate<'a>; 2]) {
        *self.slot(place) = Some(left);
        self.order.copy_within(place + 1..self.count, place + 2);
        self.order[place + 1] = self.count as u8;
        self.slots[self.count] = Some(right);
        self.count += 1;
    }

    /// All, in their order.
    fn into_sets(mut self) -> impl Iterator<Item = Candidate<'a>> {
        (0..self.count).filter_map(move |place| self.slot(place).take())
    }
}

/// What becomes of a set.
enum Fate {
    /// Not looked at yet.
    Unknown,
    /// It stays whole.
    Whole,
    /// It is cut, where no cut is better than another.
    Halves,
    /// It is cut.
    Cut(Split),
}

impl Fine<'_> {
    fn candidate<'a>(&self, set: Set<'a>) -> Candidate<'a> {
        Candidate {
            area: set.bounds.half_area(self.scale),
            set,
            fate: Fate::Unknown,
        }
    }

    /// The box of triangle `number`.
    #[inline(always)]
    fn prim(&self, number: u32) -> Prim {
        Prim::of(&self.triangles[number as usize].corners)
    }

    /// The top over all of `keys`.
    fn top_of_keys<S: Simd>(&self, simd: S, keys: &[Key]) -> Result<Top<Vec<u32>>, Cancelled> {
        if keys.len() <= PART {
            // No clusters: nothing is cut before it is a part.
            let numbers = keys.iter().map(|&key| morton::number(key)).collect();
            return Ok(Top::Part(numbers));
        }
        let mut prims = self.clusters(keys)?;
        let mut spare = vec![Prim::EMPTY; prims.len()];
        let all = self.candidate(Set::new(&mut prims, &mut spare));
        self.top(simd, keys, all, 0)
    }

    /// `keys` in clusters: the cells that just hold no more than [`CLUSTER`] triangles. Their number is the place of
    /// their first key.
    fn clusters(&self, keys: &[Key]) -> Result<Vec<Prim>, Cancelled> {
        let mut ranges = Vec::new();
        cells(keys, 0, CLUSTER_RANGE, &mut ranges);
        let clusters: Vec<Vec<Prim>> = ranges
            .into_par_iter()
            .map(|(start, keys)| {
                self.watch.check()?;
                let mut clusters = Vec::new();
                cells(keys, start, CLUSTER, &mut clusters);
                let cluster = |&(start, keys): &(usize, &[Key])| {
                    let mut bounds = Prim::EMPTY;
                    for (i, &key) in keys.iter().enumerate() {
                        let later = keys.get(i + AHEAD).map_or(0, |&k| morton::number(k));
                        prefetch_triangle(self.triangles, later);
                        bounds = bounds.join(&self.prim(morton::number(key)));
                    }
                    bounds.with(start as u32, keys.len() as u32)
                };
                Ok(clusters.iter().map(cluster).collect())
            })
            .collect::<Result<_, Cancelled>>()?;
        Ok(clusters.concat())
    }

    /// The top over a set of clusters.
    fn top<S: Simd>(
        &self,
        simd: S,
        keys: &[Key],
        whole: Candidate,
        depth: usize,
    ) -> Result<Top<Vec<u32>>, Cancelled> {
        if let [cluster] = &*whole.set.prims
            && cluster.weight() as usize > PART
        {
            return self.dense(simd, keys_of(keys, cluster), keys.len());
        }
        if whole.set.weight as usize <= PART {
            let clusters = whole.set.prims.iter();
            let keys = clusters.flat_map(|cluster| keys_of(keys, cluster));
            let numbers = keys.map(|&key| morton::number(key)).collect();
            return Ok(Top::Part(numbers));
        }
        self.watch.check()?;
        let parallel = whole.set.weight > PARALLEL;
        let children = self.open::<S, true>(simd, whole, depth);
        let top = |child| self.top(simd, keys, child, depth + 1);
        let children = if parallel {
            let sets: Vec<_> = children.into_sets().collect();
            sets.into_par_iter()
                .map(top)
                .collect::<Result<_, Cancelled>>()
        } else {
            children.into_sets().map(top).collect()
        };
        Ok(Top::Node(children?))
    }

    /// The top over one cell of the finest grid with many triangles, out of `of_all`: on a finer grid of its own, if
    /// that tells them apart.
    fn dense<S: Simd>(
        &self,
        simd: S,
        keys: &[Key],
        of_all: usize,
    ) -> Result<Top<Vec<u32>>, Cancelled> {
        if keys.len() < of_all {
            let sorted = morton::sort_again(self.triangles, keys);
            return self.top_of_keys(simd, &sorted.keys);
        }
        // Around one middle all the same: nothing but their sizes tells them apart.
        let mut sized: Vec<(f32, u32)> = keys
            .iter()
            .map(|&key| morton::number(key))
            .map(|number| (self.prim(number).half_area(self.scale), number))
            .collect();
        sized.sort_unstable_by(|(a, i), (b, j)| b.total_cmp(a).then(i.cmp(j)));
        let numbers: Vec<u32> = sized.into_iter().map(|(_, number)| number).collect();
        Ok(even(&numbers))
    }

    /// Writes a part; `rooms` are kept from one to the next.
    fn part<S: Simd>(
        &self,
        simd: S,
        piece: &mut Piece,
        numbers: &[u32],
        rooms: &mut (Vec<Prim>, Vec<Prim>),
    ) -> Branch {
        let (prims, spare) = rooms;
        prims.clear();
        for (i, &number) in numbers.iter().enumerate() {
            let later = numbers.get(i + AHEAD).map_or(0, |&n| n);
            prefetch_triangle(self.triangles, later);
            prims.push(self.prim(number).with(number, 1));
        }
        spare.resize(numbers.len(), Prim::EMPTY);
        let all = self.candidate(Set::new(prims, spare));
        self.branch(simd, piece, all, 0)
    }

    /// Writes everything in a set of triangles.
    fn branch<S: Simd>(
        &self,
        simd: S,
        piece: &mut Piece,
        mut whole: Candidate,
        depth: usize,
    ) -> Branch {
        if matches!(whole.fate, Fate::Unknown) {
            whole.fate = self.fate::<S, false>(simd, &whole.set, depth);
        }
        if matches!(whole.fate, Fate::Whole) {
            let mut numbers = [0; MAX_LEAF];
            for (number, prim) in numbers.iter_mut().zip(&*whole.set.prims) {
                *number = prim.number();
            }
            return piece.leaf(simd, &numbers[..whole.set.prims.len()], whole.set.bounds);
        }
        let me = piece.reserve_node();
        let bounds = whole.set.bounds;
        let children = self.open::<S, false>(simd, whole, depth);
        for (slot, child) in children.into_sets().enumerate() {
            let branch = self.branch(simd, piece, child, depth + 1);
            piece.set_child(me, slot, &branch);
        }
        Piece::branch(me, bounds)
    }

    /// Up to eight sets that together hold what `whole` holds, which is to be cut: cuts the one with the largest box
    /// again and again.
    fn open<'a, S: Simd, const CLUSTERS: bool>(
        &self,
        simd: S,
        whole: Candidate<'a>,
        depth: usize,
    ) -> Children<'a> {
        let mut children = Children::new(whole);
        while children.count < WIDTH {
            // The first of equals, so that the order is that of the cuts.
            let (mut largest, mut at) = (f32::NEG_INFINITY, None);
            for place in 0..children.count {
                if let Some(child) = children.slot(place)
                    && !matches!(child.fate, Fate::Whole)
                    && (at.is_none() || child.area > largest)
                {
                    (largest, at) = (child.area, Some(place));
                }
            }
            let Some(place) = at else { break };
            let slot = children.slot(place);
            if let Some(child) = slot
                && matches!(child.fate, Fate::Unknown)
            {
                child.fate = self.fate::<S, CLUSTERS>(simd, &child.set, depth);
                if matches!(child.fate, Fate::Whole) {
                    continue;
                }
            }
            let Some(Candidate { set, fate, .. }) = slot.take() else {
                break;
            };
            let sides = match fate {
                Fate::Cut(split) => simd.vectorize(
                    #[inline(always)]
                    || set.cut(simd, &split),
                ),
                _ => set.halve(),
            };
            children.put(place, sides.map(|side| self.candidate(side)));
        }
        children
    }

    fn fate<S: Simd, const CLUSTERS: bool>(&self, simd: S, set: &Set, depth: usize) -> Fate {
        let LeafShape { most, node_cost } = self.shape;
        let small = if CLUSTERS { SMALL_PART } else { node_cost };
        // No cut of so few is worth a node.
        if set.weight <= small || set.prims.len() == 1 {
            return Fate::Whole;
        }
        let may_stay = !CLUSTERS && set.prims.len() <= most;
        let split = (depth < MAX_DEPTH).then(|| {
            simd.vectorize(
                #[inline(always)]
                || set.best_split(simd, self.scale),
            )
        });
        let area = set.bounds.half_area(self.scale);
        match split.flatten() {
            Some(split)
                if !may_stay || node_cost as f32 * area + split.cost < area * set.weight as f32 =>
            {
                Fate::Cut(split)
            }
            _ if may_stay => Fate::Whole,
            _ => Fate::Halves,
        }
    }
}

/// Cuts `keys`, the first of which is number `start` of all, in cells with at most `most` triangles; cells of the
/// finest grid stay whole.
fn cells<'a>(keys: &'a [Key], start: usize, most: usize, out: &mut Vec<(usize, &'a [Key])>) {
    let of_one_cell = || morton::code(keys[0]) == morton::code(keys[keys.len() - 1]);
    if keys.len() <= most || of_one_cell() {
        out.push((start, keys));
    } else {
        let cut = morton::cut(keys);
        cells(&keys[..cut], start, most, out);
        cells(&keys[cut..], start + cut, most, out);
    }
}

/// The keys of a cluster.
fn keys_of<'a>(keys: &'a [Key], cluster: &Prim) -> &'a [Key] {
    let rest = &keys[cluster.number() as usize..];
    let weight = cluster.weight();
    if weight < Prim::MAX_WEIGHT {
        return &rest[..weight as usize];
    }
    let cell = morton::code(rest[0]);
    &rest[..rest.partition_point(|&key| morton::code(key) == cell)]
}

/// Parts of the same size.
fn even(numbers: &[u32]) -> Top<Vec<u32>> {
    if numbers.len() <= PART {
        return Top::Part(numbers.to_vec());
    }
    Top::Node(
        numbers
            .chunks(numbers.len().div_ceil(WIDTH))
            .map(even)
            .collect(),
    )
}
