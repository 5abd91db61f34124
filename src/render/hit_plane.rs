//! From the hits of a tile to the plane of a whole picture's hits.

use crate::frame::{Hit, MISS};
use crate::raw::{PlaneTile, hit_words, streamed};
use crate::simd::{Bytes, Kernel, Lanes, SimdBase, dispatch, lanes, load};
use crate::trace::tile::{BLOCKS, block_offset};
use crate::trace::{TILE, Tile};

/// Words of eight pixels' hits, number and bits of `t` in turn.
type Eight = [u32; 16];

/// Eight pixels without a hit.
const EIGHT_MISSES: Eight = {
    let mut words = [MISS; 16];
    let mut i = 1;
    while i < 16 {
        words[i] = f32::INFINITY.to_bits();
        i += 2;
    }
    words
};

/// A row of a tile's hits.
type Row = [Eight; TILE / 8];

/// Writes a tile without hits.
pub fn write_misses(kernel: Kernel, out: &mut PlaneTile<'_, Hit>) {
    dispatch!(kernel, simd => write_rows(simd, out, |_, _| ()));
}

/// Writes the hits of a tile, with the file's numbers.
pub fn write(
    kernel: Kernel,
    tile: &Tile,
    file_ids: &[u32],
    t_per_w: f32,
    out: &mut PlaneTile<'_, Hit>,
) {
    dispatch!(kernel, simd => write_rows(
        simd,
        out,
        #[inline(always)]
        |by, rows| block_row(simd, tile, by, file_ids, t_per_w, rows),
    ));
}

/// Writes the tile four rows at a time; `fill`: brings row `by` of blocks up to date, which are misses at first.
#[inline(always)]
fn write_rows<S: Lanes>(
    simd: S,
    out: &mut PlaneTile<'_, Hit>,
    mut fill: impl FnMut(usize, &mut [Row; 4]),
) {
    let mut rows = [[EIGHT_MISSES; TILE / 8]; 4];
    let width = out.width();
    for by in 0..out.height().div_ceil(4) {
        fill(by, &mut rows);
        for (y, row) in rows.iter().enumerate().take(out.height() - 4 * by) {
            let to = hit_words(out.row(4 * by + y));
            simd.stream(to, &row.as_flattened()[..2 * width]);
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
    rows: &mut [Row; 4],
) {
    let one = S::f32s::splat(simd, 1.0);
    let t_per_w = S::f32s::splat(simd, t_per_w);
    let touched = tile.touched_in_row(by);
    for pair in 0..BLOCKS / 2 {
        if touched >> pair & 1 == 0 {
            for row in rows.iter_mut() {
                row[pair] = EIGHT_MISSES;
            }
            continue;
        }
        // Two blocks side by side are neighbours in memory, too.
        let at = block_offset(2 * pair, by) & 0xfe0;
        let ids = &tile.id[at..at + 32];
        let mut eights = [EIGHT_MISSES; 4];
        let mut s = 0;
        while s < 16 {
            let of_block = |block: usize| {
                let first = 16 * block + s;
                // A miss has z = 0: 1/0 is the infinity that it shall show.
                let t = (one / load(simd, &tile.z, at + first)) * t_per_w;
                let ids = simd.look_up(file_ids, &ids[first..first + lanes::<S>()], MISS);
                (ids, t.bitcast())
            };
            let ((ids0, t0), (ids1, t1)) = (of_block(0), of_block(1));
            simd.put_pairs([ids0, ids1], [t0, t1], &mut eights[s / 4..]);
            s += lanes::<S>();
        }
        for (row, eight) in rows.iter_mut().zip(eights) {
            row[pair] = eight;
        }
    }
}
