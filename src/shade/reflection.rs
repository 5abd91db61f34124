//! The report's shading: full colour where the mirrored ray looks straight into the light, black where it looks away.
//!
//! Instead of each ray, the light is mirrored at each triangle, once: with unit `n` and `L`,
//! `cosine = (L·r)/|r| = (m·a)/|a|`, `m = L − 2(L·n)n`. That does not depend on which side `n` is on.

use super::{BlockRow, BlockRowPlace, Shader, dot, pixel};
use crate::simd::{Bytes, Lanes, Select, SimdBase, SimdFloat, SimdInt, dispatch, lanes, load};
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
        let mut pixels = [0u32; 16];
        let z = &tile.z[at..at + 16];
        if z.iter().any(|&z| z > 0.0) {
            mirror_block(
                simd,
                shader,
                tile,
                at,
                (place.x + 4 * bx, place.y),
                &mut pixels,
            );
        }
        for (row, four) in rows.iter_mut().zip(pixels.chunks_exact(4)) {
            row[4 * bx..4 * bx + 4].copy_from_slice(four);
        }
    }
}

#[inline(always)]
fn mirror_block<S: Lanes>(
    simd: S,
    shader: &Shader<'_>,
    tile: &Tile,
    at: usize,
    (x, y): (usize, usize),
    pixels: &mut [u32; 16],
) {
    macro_rules! splat {
        ($x:expr) => {
            S::f32s::splat(simd, $x)
        };
    }
    let records = shader.world.mirror_records();
    let ids: &[u32; 16] = tile.id[at..at + 16]
        .try_into()
        .expect("a block has 16 pixels");
    let uniform = ids.iter().all(|&id| id == ids[0]);
    let rays = &shader.rays;
    let zero = splat!(0.0);
    let mut s = 0;
    while s < 16 {
        let hit = load(simd, &tile.z, at + s).simd_gt(zero);
        let m = if uniform {
            let [x, y, z, c] = records[ids[0] as usize];
            [splat!(x), splat!(y), splat!(z), splat!(c)]
        } else {
            // Misses read some record and are blanked below.
            let mut known = *ids;
            known
                .iter_mut()
                .for_each(|id| *id = if *id == u32::MAX { 0 } else { *id });
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
                let c: S::f32s = ((color >> $shift) & S::u32s::splat(simd, 255)).to_float();
                let c = (shown * c).round_ties_even().max(zero).min(splat!(255.0));
                let c: S::u32s = c.to_int();
                c << $shift
            }};
        }
        let rgb = channel!(16) | channel!(8) | channel!(0);
        let out = hit.select(rgb, S::u32s::splat(simd, 0));
        out.store_slice(&mut pixels[s..s + lanes::<S>()]);
        s += lanes::<S>();
    }
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
