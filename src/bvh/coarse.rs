//! The coarse tree: cells of an octree along the Morton curve, without a look at any surface.
//!
//! For a first picture of a large scene. Its boxes overlap more than those of [`super::fine`], so frames take longer;
//! what they show is the same to the bit. Source: Lauterbach et al., "Fast BVH construction on GPUs", 2009.

use std::ops::Range;

use super::emit::{Branch, Piece, Top, assemble};
use super::morton::{self, Key, Sorted};
use super::node::{MAX_LEAF, WIDTH};
use super::prim::Prim;
use super::{Bvh, PartRecords, prefetch_triangle};
use crate::raw::Pages;
use crate::scene::Triangle;
use crate::simd::{Kernel, Simd, dispatch};
use crate::watch::{Cancelled, Watch};

/// Parts of at most this many triangles are written by one thread.
const PART: usize = 1 << 10;
/// So many triangles ahead of their use their lines are asked for.
const AHEAD: usize = 24;

pub(super) fn build<R: Copy + Send + Sync>(
    triangles: &[Triangle],
    sorted: Sorted,
    records: &PartRecords<R>,
    watch: Watch<'_>,
) -> Result<(Bvh, Pages<R>), Cancelled> {
    let keys = &sorted.keys[..];
    let kernel = Kernel::best();
    let write = |piece: &mut Piece, parts: &[Range<usize>]| {
        let cells = Cells { triangles, keys };
        for part in parts {
            watch.check()?;
            let root = dispatch!(kernel, simd => cells.branch(simd, piece, part.clone()));
            piece.finish_part(root);
        }
        Ok(())
    };
    let top = top(&Sparse::of(keys), 0..keys.len());
    assemble(
        triangles,
        sorted.bounds,
        top,
        Range::len,
        write,
        records,
        sorted.spare.reused(),
    )
}

/// Keys in order, and every sixty-fourth code by itself: to look for a place among all keys takes a line of memory
/// a step.
struct Sparse<'a> {
    keys: &'a [Key],
    codes: Vec<u32>,
}

impl Sparse<'_> {
    const STRIDE: usize = 64;

    fn of(keys: &[Key]) -> Sparse<'_> {
        let codes = keys.iter().step_by(Sparse::STRIDE);
        Sparse {
            keys,
            codes: codes.map(|&key| morton::code(key)).collect(),
        }
    }

    /// Where to cut `range`: as [`morton::cut`], counted from the first of all keys.
    fn cut(&self, range: Range<usize>) -> usize {
        let keys = &self.keys[range.clone()];
        let Some(bit) = morton::highest_difference(keys) else {
            return range.start + keys.len() / 2;
        };
        let before = |code: u32| code >> bit == morton::code(keys[0]) >> bit;
        // The sparse codes inside; those before the cut; the keys from the last of these to the next.
        let inside = range.start.div_ceil(Sparse::STRIDE)..range.end.div_ceil(Sparse::STRIDE);
        let count = self.codes[inside.clone()].partition_point(|&code| before(code));
        let next = (inside.start + count) * Sparse::STRIDE;
        let near = range.start.max(next.saturating_sub(Sparse::STRIDE))..range.end.min(next);
        near.start + self.keys[near].partition_point(|&key| before(morton::code(key)))
    }
}

/// The ends of up to eight cells that make up `range`, opened largest first down to `least` triangles. `cut` says
/// where to cut a range.
#[inline(always)]
fn open(
    range: &Range<usize>,
    least: usize,
    cut: impl Fn(Range<usize>) -> usize,
) -> ([usize; WIDTH + 1], usize) {
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
        let cut = cut(ends[at]..ends[at + 1]);
        ends.copy_within(at + 1..=count, at + 2);
        ends[at + 1] = cut;
        count += 1;
    }
    (ends, count)
}

fn top(keys: &Sparse, range: Range<usize>) -> Top<Range<usize>> {
    if range.len() <= PART {
        return Top::Part(range);
    }
    let (ends, count) = open(&range, MAX_LEAF, |range| keys.cut(range));
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
                prefetch_triangle(self.triangles, morton::number(key));
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
        let cut = |range: Range<usize>| range.start + morton::cut(&self.keys[range]);
        let (ends, count) = open(&range, MAX_LEAF, cut);
        let mut bounds = Prim::EMPTY;
        for i in 0..count {
            let branch = self.branch(simd, piece, ends[i]..ends[i + 1]);
            piece.set_child(me, i, &branch);
            bounds = bounds.join(&branch.bounds);
        }
        Piece::branch(me, bounds)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cuts_by_sparse_codes_are_those_by_all() {
        let mut code = 0u64;
        let keys: Vec<Key> = (0..1000)
            .map(|i| {
                // Runs of equal codes, some longer than the stride; steps of many sizes.
                code += if i % 200 < 130 { 0 } else { 1 << (i % 17) };
                code << 32 | i
            })
            .collect();
        let sparse = Sparse::of(&keys);
        for start in (0..1000).step_by(7) {
            for end in (start + 2..=1000).step_by(11) {
                let expected = start + morton::cut(&keys[start..end]);
                assert_eq!(sparse.cut(start..end), expected, "{start}..{end}");
            }
        }
    }
}
