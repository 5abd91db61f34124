//! From the hits of a tile to the plane of a whole picture's hits.

use crate::frame::{Hit, MISS};
use crate::raw::{PlaneTile, hit_words};
use crate::simd::{Bytes, Kernel, Lanes, SimdBase, SimdMask, dispatch, lanes, load};
use crate::trace::tile::{BLOCKS, block_offset};
use crate::trace::{TILE, Tile};

/// Four rows of a tile's hits, as words: the triangle's number, then the bits of `t`, pixel by pixel.
type Rows = [[u32; 2 * TILE]; 4];

/// Writes the hits of a tile, with the file's numbers.
pub fn write(
    kernel: Kernel,
    tile: &Tile,
    file_ids: &[u32],
    t_per_w: f32,
    out: &mut PlaneTile<'_, Hit>,
) {
    let mut rows: Rows = [[0; 2 * TILE]; 4];
    for by in 0..out.height().div_ceil(4) {
        dispatch!(kernel, simd => block_row(simd, tile, by, file_ids, t_per_w, &mut rows));
        let width = out.width();
        for (y, row) in rows.iter().enumerate().take(out.height() - 4 * by) {
            hit_words(out.row(4 * by + y)).copy_from_slice(&row[..2 * width]);
        }
    }
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
    for bx in 0..BLOCKS {
        let at = block_offset(bx, by) & 0xff0;
        let ids = file_numbers(simd, &tile.id[at..at + 16], file_ids);
        let mut s = 0;
        while s < 16 {
            let ids = S::u32s::from_slice(simd, &ids[s..s + lanes::<S>()]);
            // A miss has z = 0: 1/0 is the infinity that it shall show.
            let t = (one / load(simd, &tile.z, at + s)) * t_per_w;
            let t: S::u32s = t.bitcast();
            let mut words = [0u32; 32];
            ids.zip_low(t).store_slice(&mut words[..lanes::<S>()]);
            ids.zip_high(t)
                .store_slice(&mut words[lanes::<S>()..2 * lanes::<S>()]);
            for (y, four) in words[..2 * lanes::<S>()].chunks_exact(8).enumerate() {
                rows[s / 4 + y][8 * bx..8 * bx + 8].copy_from_slice(four);
            }
            s += lanes::<S>();
        }
    }
}

/// The file's numbers of the 16 pixels of a block.
#[inline(always)]
fn file_numbers<S: Lanes>(simd: S, ids: &[u32], file_ids: &[u32]) -> [u32; 16] {
    let number = |id: u32| file_ids.get(id as usize).copied().unwrap_or(MISS);
    let first = S::u32s::splat(simd, ids[0]);
    let mut uniform = true;
    let mut s = 0;
    while s < 16 {
        let ids = S::u32s::from_slice(simd, &ids[s..s + lanes::<S>()]);
        uniform &= ids.simd_eq(first).all_true();
        s += lanes::<S>();
    }
    if uniform {
        return [number(ids[0]); 16];
    }
    let mut numbers = [0; 16];
    for (to, &id) in numbers.iter_mut().zip(ids) {
        *to = number(id);
    }
    numbers
}
