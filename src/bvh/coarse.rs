//! The coarse tree: cells of an octree along the Morton curve, without a look at any surface.
//!
//! For a first picture of a large scene. Its boxes overlap more than those of [`super::fine`], so frames take longer;
//! what they show is the same to the bit. Source: Lauterbach et al., "Fast BVH construction on GPUs", 2009.

use std::ops::Range;

use super::emit::{Branch, Piece, Top, assemble};
use super::morton::{self, Key, Sorted};
use super::node::{MAX_LEAF, WIDTH};
use super::prim::Prim;
use super::{Bvh, PartRecords};
use crate::raw::prefetch;
use crate::scene::Triangle;
use crate::simd::{Kernel, Simd, dispatch};

/// Parts of at most this many triangles are written by one thread.
const PART: usize = 1 << 10;
/// So many triangles ahead of their use their lines are asked for.
const AHEAD: usize = 24;

pub(super) fn build<R: Copy + Send + Sync>(
    triangles: &[Triangle],
    sorted: &Sorted,
    records: &PartRecords<R>,
) -> (Bvh, Vec<R>) {
    let keys = &sorted.keys[..];
    let kernel = Kernel::best();
    let write = |piece: &mut Piece, parts: &[Range<usize>]| {
        let cells = Cells { triangles, keys };
        for part in parts {
            let root = dispatch!(kernel, simd => cells.branch(simd, piece, part.clone()));
            piece.finish_part(root);
        }
    };
    let top = top(keys, 0..keys.len());
    assemble(triangles, sorted.bounds, top, Range::len, write, records)
}

/// The ends of up to eight cells that make up `range`, opened largest first down to `least` triangles.
fn open(keys: &[Key], range: &Range<usize>, least: usize) -> ([usize; WIDTH + 1], usize) {
    let mut ends = [range.end; WIDTH + 1];
    ends[0] = range.start;
    let mut count = 1;
    while count < WIDTH {
        let (mut largest, mut at) = (0, 0);
        for i in 0..count {
            let len = ends[i + 1] - ends[i];
            if len > largest {
                (largest, at) = (len, i);
            }
        }
        if largest <= least {
            break;
        }
        let cut = ends[at] + morton::cut(&keys[ends[at]..ends[at + 1]]);
        ends.copy_within(at + 1..=count, at + 2);
        ends[at + 1] = cut;
        count += 1;
    }
    (ends, count)
}

fn top(keys: &[Key], range: Range<usize>) -> Top<Range<usize>> {
    if range.len() <= PART {
        return Top::Part(range);
    }
    let (ends, count) = open(keys, &range, MAX_LEAF);
    let cells = (0..count).map(|i| top(keys, ends[i]..ends[i + 1]));
    Top::Node(cells.collect())
}

struct Cells<'a> {
    triangles: &'a [Triangle],
    keys: &'a [Key],
}

impl Cells<'_> {
    /// Writes everything in `range`.
    fn branch<S: Simd>(&self, simd: S, piece: &mut Piece, range: Range<usize>) -> Branch {
        if range.len() <= MAX_LEAF {
            let ahead = self.keys.len().min(range.end + AHEAD);
            for &key in &self.keys[ahead.min(range.start + AHEAD)..ahead] {
                let number = morton::number(key) as usize;
                prefetch(self.triangles, number, 0);
                prefetch(self.triangles, number + 1, 0);
            }
            let mut numbers = [0; MAX_LEAF];
            let count = range.len();
            let mut bounds = Prim::EMPTY;
            for (number, &key) in numbers.iter_mut().zip(&self.keys[range]) {
                *number = morton::number(key);
                bounds = bounds.join(&Prim::of(&self.triangles[*number as usize].corners));
            }
            return piece.leaf(simd, &numbers[..count], bounds);
        }
        let me = piece.reserve_node();
        let (ends, count) = open(self.keys, &range, MAX_LEAF);
        let mut bounds = Prim::EMPTY;
        for i in 0..count {
            let branch = self.branch(simd, piece, ends[i]..ends[i + 1]);
            piece.set_child(me, i, &branch);
            bounds = bounds.join(&branch.bounds);
        }
        Piece::branch(me, bounds)
    }
}
