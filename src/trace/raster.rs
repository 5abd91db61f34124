//! From edge functions to pixels, three ways by a triangle's size on screen.

use super::coverage::{Broadcast, Job, SURE, Scratch, Setup, cover, min3};
use super::doubt;
use super::space::HALF;
use super::tile::{BLOCKS, TABLES, Tile, pixel_offset};
use super::vec3s::{Vec3s, add, sub};
use crate::simd::{Lanes, SimdBase, SimdFloat, VertexScratch, bits, lanes, load, store};

/// Lanes for [`micro_triangles`].
pub struct MicroLanes<S: Lanes> {
    /// Edge functions, their error added.
    pub edges: [Vec3s<S>; 3],
    /// 1/w.
    pub depth: Vec3s<S>,
    /// Its smallest value.
    pub z_low: S::f32s,
    /// Its largest value.
    pub z_high: S::f32s,
    /// Twice the largest error of the edges.
    pub sure: S::f32s,
    /// First column and row of the box.
    pub low: [S::f32s; 2],
    /// Columns and rows less one.
    pub extent: [S::f32s; 2],
}

/// Triangles whose box holds at most 2x2 pixels' centres: four evaluations, then one loop over the hits of all.
#[inline(always)]
pub fn micro_triangles<S: Lanes>(
    simd: S,
    job: &Job<'_>,
    k: &MicroLanes<S>,
    micro: u32,
    vertices: &VertexScratch,
    tile: &mut Tile,
) -> u64 {
    macro_rules! splat {
        ($x:expr) => {
            S::f32s::splat(simd, $x)
        };
    }
    let one = splat!(1.0);
    let wide = bits::<S>(k.extent[0].simd_ge(one)) & micro;
    let tall = bits::<S>(k.extent[1].simd_ge(one)) & micro;
    let x0 = k.low[0] - splat!(HALF);
    let y0 = k.low[1] - splat!(HALF);
    let mut z = [[0.0f32; 16]; 4];
    // Bit 16 * pixel + lane.
    let (mut hits, mut doubts) = (0u64, 0u64);
    macro_rules! pixel {
        ($p:expr, $x:expr, $y:expr, $who:expr) => {{
            let (x, y) = ($x, $y);
            macro_rules! at {
                ($k:expr) => {
                    $k[0] * x + ($k[1] * y + $k[2])
                };
            }
            let inside = at!(k.edges[0]).min(at!(k.edges[1]).min(at!(k.edges[2])));
            let maybe = bits::<S>(inside.simd_ge(0.0)) & $who;
            let sure = bits::<S>(inside.simd_ge(k.sure));
            store::<S>(at!(k.depth).max(k.z_low).min(k.z_high), &mut z[$p], 0);
            hits |= u64::from(maybe) << (16 * $p);
            doubts |= u64::from(maybe & !sure) << (16 * $p);
        }};
    }
    pixel!(0, x0, y0, micro);
    if wide != 0 {
        pixel!(1, x0 + one, y0, wide);
    }
    if tall != 0 {
        pixel!(2, x0, y0 + one, tall);
        if wide != 0 {
            pixel!(3, x0 + one, y0 + one, wide & tall);
        }
    }
    if hits == 0 {
        return 0;
    }
    let mut columns = [0i32; 16];
    let mut rows = [0i32; 16];
    let (c, r): (S::i32s, S::i32s) = (k.low[0].to_int(), k.low[1].to_int());
    c.store_slice(&mut columns[..lanes::<S>()]);
    r.store_slice(&mut rows[..lanes::<S>()]);
    if doubts != 0 {
        hits &= doubt::settle(simd, job, doubts, &columns, &rows, vertices);
    }
    let mut dirty = 0u64;
    while hits != 0 {
        let p = hits.trailing_zeros() as usize;
        hits &= hits - 1;
        let lane = p & 15;
        let x = columns[lane] as usize + (p >> 4 & 1);
        let y = rows[lane] as usize + (p >> 5);
        let at = pixel_offset(x & 63, y & 63);
        let id = job.leaf.first_id() + (job.first + lane) as u32;
        let (z, old) = (z[p >> 4][lane], tile.z[at]);
        if z == old {
            dirty |= u64::from(tile.keep_nearer(at, z, id, job.file_ids)) << (at >> 6);
            continue;
        }
        let wins = z > old;
        tile.z[at] = if wins { z } else { old };
        tile.id[at] = if wins { id } else { tile.id[at] };
        dirty |= u64::from(wins) << (at >> 6);
    }
    dirty
}
/// Pairs of a 4x4 block and a triangle that may meet: bit 16 * block + lane, the blocks of the 2x2 in a row. `which`:
/// the lanes at work; of these, which reach into a second column and row of blocks.
#[inline(always)]
pub fn pairs_of<S: Lanes>(simd: S, setup: &Setup, block_low: [S::f32s; 2], which: [u32; 3]) -> u64 {
    macro_rules! splat {
        ($x:expr) => {
            S::f32s::splat(simd, $x)
        };
    }
    let [small, two_columns, two_rows] = which;
    let four = splat!(4.0);
    let centre = splat!(HALF - 1.5);
    let x = block_low[0] * four - centre;
    let y = block_low[1] * four - centre;
    let mut at = [splat!(0.0); 3];
    let mut right = at;
    let mut down = at;
    for i in 0..3 {
        macro_rules! row {
            ($j:expr) => {
                load(simd, &setup.0[3 * i + $j], 0)
            };
        }
        let (u, v, w) = (row!(0), row!(1), row!(2));
        let reach = (u.abs() + v.abs()) * splat!(1.51);
        at[i] = (u * x + (v * y + w)) + reach;
        right[i] = u * four;
        down[i] = v * four;
    }
    // The sums below are rounded more often than those of a pixel: allow for as much error again.
    let lowest = splat!(0.0) - load(simd, &setup.0[SURE], 0);
    macro_rules! touched {
        ($e:expr) => {
            bits::<S>(min3::<S>($e).simd_ge(lowest))
        };
    }
    let right_of = add::<S>(at, right);
    let below = add::<S>(at, down);
    let across = add::<S>(right_of, down);
    u64::from(touched!(at) & small)
        | u64::from(touched!(right_of) & two_columns) << 16
        | u64::from(touched!(below) & two_rows) << 32
        | u64::from(touched!(across) & two_columns & two_rows) << 48
}

/// Triangles whose box lies inside 2x2 blocks, as pairs of block and triangle.
#[inline(always)]
pub fn small_triangles<S: Lanes>(
    simd: S,
    job: &Job<'_>,
    pairs: u64,
    scratch: &Scratch,
    tile: &mut Tile,
) -> u64 {
    let mut left = pairs;
    let mut dirty = 0u64;
    while left != 0 {
        let p = left.trailing_zeros() as usize;
        left &= left - 1;
        let lane = p & 15;
        let bx = scratch.boxes[0][lane] as usize + (p >> 4 & 1);
        let by = scratch.boxes[2][lane] as usize + (p >> 5);
        let block = (by * BLOCKS + bx) & (BLOCKS * BLOCKS - 1);
        let who = job.candidate(lane, &scratch.vertices);
        let k = Broadcast::new(simd, &scratch.setup, lane, who.id);
        let won = cover::<S, false>(simd, tile, &k, block, &who);
        dirty |= u64::from(won) << (TABLES.offset[block] >> 6);
    }
    dirty
}

/// A triangle whose box is larger than 2x2 blocks.
#[inline(always)]
pub fn large_triangle<S: Lanes>(
    simd: S,
    job: &Job<'_>,
    lane: usize,
    scratch: &Scratch,
    tile: &mut Tile,
) -> u64 {
    let who = job.candidate(lane, &scratch.vertices);
    let k = Broadcast::new(simd, &scratch.setup, lane, who.id);
    let [x0, x1, y0, y1] = scratch.boxes.map(|row| row[lane] as usize & (BLOCKS - 1));
    let mut dirty = 0u64;
    if (x1 + 1 - x0) * (y1 + 1 - y0) <= 16 {
        for by in y0..=y1 {
            for bx in x0..=x1 {
                let block = by * BLOCKS + bx;
                let won = cover::<S, false>(simd, tile, &k, block, &who);
                dirty |= u64::from(won) << (TABLES.offset[block] >> 6);
            }
        }
        return dirty;
    }
    let reach = k.block_reach(simd);
    let sure = k.sure();
    let (lowest, highest) = (S::f32s::splat(simd, 0.0) - sure, sure + sure);
    let columns = (u32::MAX >> (31 - x1)) & !((1u32 << x0) - 1);
    let mut block = y0 * BLOCKS;
    while block < (y1 + 1) * BLOCKS {
        let x = load(simd, &TABLES.centre_x, block);
        let y = load(simd, &TABLES.centre_y, block);
        let e = k.edges_at(x, y);
        let most = min3::<S>(add::<S>(e, reach));
        let least = min3::<S>(sub::<S>(e, reach));
        let inside = u32::MAX >> (32 - lanes::<S>()) & columns >> (block % BLOCKS);
        let touched = bits::<S>(most.simd_ge(lowest)) & inside;
        let full = bits::<S>(least.simd_ge(highest)) & touched;
        let mut left = full;
        while left != 0 {
            let at = block + left.trailing_zeros() as usize;
            left &= left - 1;
            let won = cover::<S, true>(simd, tile, &k, at, &who);
            dirty |= u64::from(won) << (TABLES.offset[at & 255] >> 6);
        }
        let mut left = touched & !full;
        while left != 0 {
            let at = block + left.trailing_zeros() as usize;
            left &= left - 1;
            let won = cover::<S, false>(simd, tile, &k, at, &who);
            dirty |= u64::from(won) << (TABLES.offset[at & 255] >> 6);
        }
        block += lanes::<S>();
    }
    dirty
}
