//! The report's shading: full colour where the mirrored ray looks straight into the light, black where it looks away.
//!
//! Instead of each ray, the light is mirrored at each triangle, once: with unit `n` and `L`,
//! `cosine = (L·r)/|r| = (m·a)/|a|`, `m = L − 2(L·n)n`. That does not depend on which side `n` is on.

use super::{BlockRow, BlockRowPlace, Shader, dot, pixel};
use crate::simd::{
    Bytes, Lanes, Select, SimdBase, SimdFloat, SimdInt, SimdMask, dispatch, lanes, load,
};
use crate::trace::Tile;
use crate::trace::tile::{BLOCKS, block_offset};

/// x and y of the pixels of a 4x4 block.
static LANE_X: [f32; 16] = [
    0., 1., 2., 3., 0., 1., 2., 3., 0., 1., 2., 3., 0., 1., 2., 3.,
];
static LANE_Y: [f32; 16] = [
    0., 0., 0., 0., 1., 1., 1., 1., 2., 2., 2., 2., 3., 3., 3., 3.,
];

/// Colours a row of blocks by the mirror formula. `f32`, every operation rounded:
///
/// ```text
/// a       = (base + y·dy) + x·dx
/// cosine  = ((mx·ax + my·ay) + mz·az) / sqrt((ax·ax + ay·ay) + az·az)
/// channel = round_half_even((1 − cosine)·0.5·C), kept in 0..=255
/// ```
pub fn mirror(shader: &Shader<'_>, tile: &Tile, place: BlockRowPlace, rows: &mut BlockRow) {
    dispatch!(shader.kernel, simd => mirror_row(simd, shader, tile, place, rows));
}

#[inline(always)]
fn mirror_row<S: Lanes>(
    simd: S,
    shader: &Shader<'_>,
    tile: &Tile,
    place: BlockRowPlace,
    rows: &mut BlockRow,
) {
    for bx in 0..BLOCKS {
        let at = block_offset(bx, place.by);
        let pixels = mirror_block(simd, shader, tile, at, place.x + 4 * bx, place.y);
        for (row, four) in rows.iter_mut().zip(pixels.chunks_exact(4)) {
            row[4 * bx..4 * bx + 4].copy_from_slice(four);
        }
    }
}

/// The pixels of the 4x4 block at memory place `at` of the tile, whose first pixel is (`x`, `y`) of the picture.
#[inline(always)]
fn mirror_block<S: Lanes>(
    simd: S,
    shader: &Shader<'_>,
    tile: &Tile,
    at: usize,
    x: usize,
    y: usize,
) -> [u32; 16] {
    macro_rules! splat {
        ($x:expr) => {
            S::f32s::splat(simd, $x)
        };
    }
    let records = shader.world.mirror_records();
    let mut pixels = [0u32; 16];
    // Misses read the first record and are blanked in the end.
    let mut known = [0u32; 16];
    let (mut any_hit, mut uniform) = (false, true);
    let first = S::u32s::splat(simd, tile.id[at]);
    let (zero, nothing) = (splat!(0.0), S::u32s::splat(simd, 0));
    let mut s = 0;
    while s < 16 {
        let hit = load(simd, &tile.z, at + s).simd_gt(zero);
        let ids = S::u32s::from_slice(simd, &tile.id[at + s..at + s + lanes::<S>()]);
        any_hit |= hit.any_true();
        uniform &= ids.simd_eq(first).all_true();
        hit.select(ids, nothing)
            .store_slice(&mut known[s..s + lanes::<S>()]);
        s += lanes::<S>();
    }
    if !any_hit {
        return pixels;
    }
    let rays = &shader.rays;
    let mut s = 0;
    while s < 16 {
        let m = if uniform {
            let [x, y, z, c] = records[known[0] as usize];
            [splat!(x), splat!(y), splat!(z), splat!(c)]
        } else {
            simd.gather4(records, &known[s..s + lanes::<S>()])
        };
        let px = load(simd, &LANE_X, s) + splat!(x as f32);
        let py = load(simd, &LANE_Y, s) + splat!(y as f32);
        macro_rules! direction {
            ($k:expr) => {
                (splat!(rays.base[$k]) + py * splat!(rays.dy[$k])) + px * splat!(rays.dx[$k])
            };
        }
        let a = [direction!(0), direction!(1), direction!(2)];
        let length = ((a[0] * a[0] + a[1] * a[1]) + a[2] * a[2]).sqrt();
        let cosine = ((m[0] * a[0] + m[1] * a[1]) + m[2] * a[2]) / length;
        let shown = (splat!(1.0) - cosine) * splat!(0.5);
        let color: S::u32s = m[3].bitcast();
        macro_rules! channel {
            ($shift:expr) => {{
                let c: S::i32s = ((color >> $shift) & S::u32s::splat(simd, 255)).bitcast();
                let c: S::f32s = c.to_float();
                let c = (shown * c).round_ties_even().max(zero).min(splat!(255.0));
                let c: S::i32s = c.to_int();
                c.bitcast::<S::u32s>() << $shift
            }};
        }
        let rgb = channel!(16) | channel!(8) | channel!(0);
        let hit = load(simd, &tile.z, at + s).simd_gt(zero);
        hit.select(rgb, nothing)
            .store_slice(&mut pixels[s..s + lanes::<S>()]);
        s += lanes::<S>();
    }
    pixels
}

/// The formula that the report prints, `r = 3a − 2(a·n)n` for unit `n`: then `L·r = (3L − 2(L·n)n)·a` and
/// `|r|² = 9|a|² − 8(a·n)²`. `f32`, every operation rounded.
pub fn as_printed(shader: &Shader<'_>, normals: &[[f32; 4]], x: usize, y: usize, id: u32) -> u32 {
    let [nx, ny, nz, _] = normals[id as usize];
    let n = [nx, ny, nz];
    let l = shader.world.light().as_vec3().to_array();
    let a = shader.rays.at(x, y);
    let k = 2.0 * dot(l, n);
    let p = [0, 1, 2].map(|i| 3.0 * l[i] - k * n[i]);
    let an = dot(a, n);
    let length = (9.0 * dot(a, a) - 8.0 * (an * an)).sqrt();
    let shown = (1.0 - dot(p, a) / length) * 0.5;
    let color =
        crate::color::Rgb::from_packed(shader.world.mirror_records()[id as usize][3].to_bits());
    let level = |c: u8| shown * f32::from(c);
    pixel(level(color.r), level(color.g), level(color.b))
}
