//! From the hits of a tile to the plane of a whole picture's hits.

use crate::frame::{Hit, MISS};
use crate::raw::{PlaneTile, hit_words, stream, streamed};
use crate::simd::{Bytes, Kernel, Lanes, SimdBase, SimdMask, dispatch, lanes, load};
use crate::trace::tile::{BLOCKS, block_offset};
use crate::trace::{TILE, Tile};

/// Four rows of a tile's hits, as words: the triangle's number, then the bits of `t`, pixel by pixel.
type Rows = [[u32; 2 * TILE]; 4];

/// Four pixels without a hit.
const FOUR_MISSES: [u32; 8] = {
    let infinity = f32::INFINITY.to_bits();
    [
        MISS, infinity, MISS, infinity, MISS, infinity, MISS, infinity,
    ]
};

/// Writes a tile without hits.
pub fn write_misses(out: &mut PlaneTile<'_, Hit>) {
    let mut row = [0; 2 * TILE];
    for four in row.chunks_exact_mut(8) {
        four.copy_from_slice(&FOUR_MISSES);
    }
    for y in 0..out.height() {
        let to = hit_words(out.row(y));
        stream(to, &row[..to.len()]);
    }
    streamed();
}

/// Writes the hits of a tile, with the file's numbers.
pub fn write(
    kernel: Kernel,
    tile: &Tile,
    file_ids: &[u32],
    t_per_w: f32,
    out: &mut PlaneTile<'_, Hit>,
) {
    dispatch!(kernel, simd => write_tile(simd, tile, file_ids, t_per_w, out));
}

#[inline(always)]
fn write_tile<S: Lanes>(
    simd: S,
    tile: &Tile,
    file_ids: &[u32],
    t_per_w: f32,
    out: &mut PlaneTile<'_, Hit>,
) {
    let mut rows: Rows = [[0; 2 * TILE]; 4];
    let width = out.width();
    for by in 0..out.height().div_ceil(4) {
        block_row(simd, tile, by, file_ids, t_per_w, &mut rows);
        for (y, row) in rows.iter().enumerate().take(out.height() - 4 * by) {
            stream(hit_words(out.row(4 * by + y)), &row[..2 * width]);
        }
    }
    streamed();
}

#[inline(always)]
fn block_row<S: Lanes>(
    simd: S,
    tile: &Tile,
    by: usize,
    file_ids: &[u32],
    t_per_w: f32,
    rows: &mut Rows,
) {
    let one = S::f32s::splat(simd, 1.0);
    let t_per_w = S::f32s::splat(simd, t_per_w);
    let touched = tile.touched_in_row(by);
    for bx in 0..BLOCKS {
        if touched >> (bx / 2) & 1 == 0 {
            for row in rows.iter_mut() {
                row[8 * bx..8 * bx + 8].copy_from_slice(&FOUR_MISSES);
            }
            continue;
        }
        let at = block_offset(bx, by) & 0xff0;
        let ids = &tile.id[at..at + 16];
        let uniform = all_equal(simd, ids);
        let number = |id: u32| file_ids.get(id as usize).copied().unwrap_or(MISS);
        let mut numbers = [0; 16];
        if !uniform {
            for (to, &id) in numbers.iter_mut().zip(ids) {
                *to = number(id);
            }
        }
        let first = S::u32s::splat(simd, number(ids[0]));
        let mut s = 0;
        while s < 16 {
            let ids = if uniform {
                first
            } else {
                S::u32s::from_slice(simd, &numbers[s..s + lanes::<S>()])
            };
            // A miss has z = 0: 1/0 is the infinity that it shall show.
            let t = (one / load(simd, &tile.z, at + s)) * t_per_w;
            let t: S::u32s = t.bitcast();
            let (low, high) = (ids.zip_low(t), ids.zip_high(t));
            let mut words = [0u32; 32];
            low.store_slice(&mut words[..lanes::<S>()]);
            high.store_slice(&mut words[lanes::<S>()..2 * lanes::<S>()]);
            for (y, four) in words[..2 * lanes::<S>()].chunks_exact(8).enumerate() {
                rows[(s / 4 + y) & 3][8 * bx..8 * bx + 8].copy_from_slice(four);
            }
            s += lanes::<S>();
        }
    }
}

/// Whether the 16 numbers are the same.
#[inline(always)]
fn all_equal<S: Lanes>(simd: S, numbers: &[u32]) -> bool {
    let first = S::u32s::splat(simd, numbers[0]);
    let mut equal = true;
    let mut s = 0;
    while s < 16 {
        let numbers = S::u32s::from_slice(simd, &numbers[s..s + lanes::<S>()]);
        equal &= numbers.simd_eq(first).all_true();
        s += lanes::<S>();
    }
    equal
}
