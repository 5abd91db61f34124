//! The report's shading: full colour where the mirrored ray looks straight into the light, black where it looks away.
//!
//! Instead of each ray, the light is mirrored at each triangle, once: with unit `n` and `L`,
//! `cosine = (L·r)/|r| = (m·a)/|a|`, `m = L − 2(L·n)n`. That does not depend on which side `n` is on.

use super::{BlockRow, Rays, Shader, dot, pixel, write_row};
use crate::frame::MISS;
use crate::raw::{PlaneTile, streamed};
use crate::simd::{
    Bytes, Lanes, Select, SimdBase, SimdFloat, SimdInt, SimdMask, dispatch, lanes, load,
};
use crate::trace::tile::{BLOCKS, block_offset};
use crate::trace::{TILE, Tile};

/// The columns of a tile.
static COLUMNS: [f32; TILE] = {
    let mut columns = [0.0; TILE];
    let mut x = 0;
    while x < TILE {
        columns[x] = x as f32;
        x += 1;
    }
    columns
};

/// x and y of the pixels of a 4x4 block.
static LANE_X: [f32; 16] = [
    0., 1., 2., 3., 0., 1., 2., 3., 0., 1., 2., 3., 0., 1., 2., 3.,
];
static LANE_Y: [f32; 16] = [
    0., 0., 0., 0., 1., 1., 1., 1., 2., 2., 2., 2., 3., 3., 3., 3.,
];

/// Colours a tile by the mirror formula. `f32`, every operation rounded:
///
/// ```text
/// a       = (base + y·dy) + x·dx
/// cosine  = ((mx·ax + my·ay) + mz·az) / sqrt((ax·ax + ay·ay) + az·az)
/// shown   = (1 − cosine)·0.5, kept in 0..=1
/// channel = round_half_even(shown·C)
/// ```
pub fn mirror(shader: &Shader<'_>, tile: &Tile, out: &mut PlaneTile<'_, u32>) {
    dispatch!(shader.kernel, simd => match tile.whole {
        Some(whole) => mirror_whole(simd, shader, whole.id, out),
        None => mirror_tile(simd, shader, tile, out),
    });
}

/// Three numbers in all lanes.
#[inline(always)]
fn splat3<S: Lanes>(simd: S, [x, y, z]: [f32; 3]) -> [S::f32s; 3] {
    [
        S::f32s::splat(simd, x),
        S::f32s::splat(simd, y),
        S::f32s::splat(simd, z),
    ]
}

/// What columns `x` add to a direction: x·dx.
#[inline(always)]
fn of_columns<S: Lanes>(simd: S, rays: &Rays, x: S::f32s) -> [S::f32s; 3] {
    let [dx, dy, dz] = splat3(simd, rays.dx);
    [x * dx, x * dy, x * dz]
}

/// The directions of rows `y`, without what columns add: base + y·dy.
#[inline(always)]
fn of_rows<S: Lanes>(simd: S, rays: &Rays, y: S::f32s) -> [S::f32s; 3] {
    let [dx, dy, dz] = splat3(simd, rays.dy);
    let base = splat3(simd, rays.base);
    [base[0] + y * dx, base[1] + y * dy, base[2] + y * dz]
}

/// A tile that shows the triangle `id` everywhere: there is no order of blocks to follow, so it goes row by row.
#[inline(always)]
fn mirror_whole<S: Lanes>(simd: S, shader: &Shader<'_>, id: u32, out: &mut PlaneTile<'_, u32>) {
    let surface = Surface::new(simd, shader.world.mirror_records()[id as usize]);
    let mut columns = [splat3(simd, [0.0; 3]); TILE / 4];
    let columns = &mut columns[..TILE / lanes::<S>()];
    for (i, column) in columns.iter_mut().enumerate() {
        let x = load(simd, &COLUMNS, i * lanes::<S>()) + S::f32s::splat(simd, out.x() as f32);
        *column = of_columns(simd, &shader.rays, x);
    }
    let width = out.width();
    for row in 0..out.height() {
        let y = S::f32s::splat(simd, (out.y() + row) as f32);
        let row_part = of_rows(simd, &shader.rays, y);
        let mut pixels = [0u32; TILE];
        for (pixels, column) in pixels.chunks_exact_mut(lanes::<S>()).zip(columns.iter()) {
            let a = [
                row_part[0] + column[0],
                row_part[1] + column[1],
                row_part[2] + column[2],
            ];
            mirrored(simd, surface.m, surface.half_rgb, a).store_slice(pixels);
        }
        write_row(simd, out.row(row), &pixels[..width]);
    }
    streamed();
}

/// A tile of many triangles, by blocks of 4x4 pixels.
#[inline(always)]
fn mirror_tile<S: Lanes>(simd: S, shader: &Shader<'_>, tile: &Tile, out: &mut PlaneTile<'_, u32>) {
    let mut columns = [splat3(simd, [0.0; 3]); BLOCKS];
    let lane_x = load(simd, &LANE_X, 0);
    for (bx, column) in columns.iter_mut().enumerate() {
        // The four pixels of a column of blocks, again and again over the lanes.
        let x = lane_x + S::f32s::splat(simd, (out.x() + 4 * bx) as f32);
        *column = of_columns(simd, &shader.rays, x);
    }
    let mut rows: BlockRow = [[0; TILE]; 4];
    let nothing = S::u32s::splat(simd, 0);
    let mut known = (MISS, Surface::new(simd, [0.0; 4]));
    let width = out.width();
    for by in 0..out.height().div_ceil(4) {
        let touched = tile.touched_in_row(by);
        let mut first = 0;
        while first < 16 {
            let y = load(simd, &LANE_Y, first) + S::f32s::splat(simd, (out.y() + 4 * by) as f32);
            let row_part = of_rows(simd, &shader.rays, y);
            for four in 0..width.div_ceil(16) {
                macro_rules! unit {
                    ($i:expr) => {{
                        let bx = 4 * four + $i;
                        if touched >> (bx / 2) & 1 != 0 {
                            let column = &columns[bx];
                            let a = [
                                row_part[0] + column[0],
                                row_part[1] + column[1],
                                row_part[2] + column[2],
                            ];
                            let at = (block_offset(bx, by) & 0xff0) + first;
                            mirror_unit(simd, shader, tile, at, a, &mut known)
                        } else {
                            nothing
                        }
                    }};
                }
                let [p, q, r, s] = simd.in_rows([unit!(0), unit!(1), unit!(2), unit!(3)]);
                macro_rules! put {
                    ($pixels:expr, $i:expr) => {
                        let at = $i * lanes::<S>();
                        let column = 16 * four + at % 16;
                        let row = &mut rows[(first / 4 + at / 16) % 4];
                        $pixels.store_slice(&mut row[column..column + lanes::<S>()]);
                    };
                }
                put!(p, 0);
                put!(q, 1);
                put!(r, 2);
                put!(s, 3);
            }
            first += lanes::<S>();
        }
        for (y, row) in rows.iter().enumerate().take(out.height() - 4 * by) {
            write_row(simd, out.row(4 * by + y), &row[..width]);
        }
    }
    streamed();
}

/// A triangle in all lanes.
struct Surface<S: Lanes> {
    /// Where the light is mirrored to.
    m: [S::f32s; 3],
    /// Half the colour: see [`mirrored`].
    half_rgb: [S::f32s; 3],
}

impl<S: Lanes> Surface<S> {
    /// What a record of a triangle says.
    #[inline(always)]
    fn new(simd: S, [x, y, z, color]: [f32; 4]) -> Surface<S> {
        let half = |channel| 0.5 * f32::from(channel);
        let [_, r, g, b] = color.to_bits().to_be_bytes().map(half);
        Surface {
            m: splat3(simd, [x, y, z]),
            half_rgb: splat3(simd, [r, g, b]),
        }
    }
}

/// The pixels at memory places `at..` of the tile, as many as there are lanes; `a`: their rays' directions; `known`: the
/// last triangle that showed in all of some pixels like these, with its number: often the same one.
#[inline(always)]
fn mirror_unit<S: Lanes>(
    simd: S,
    shader: &Shader<'_>,
    tile: &Tile,
    at: usize,
    a: [S::f32s; 3],
    known: &mut (u32, Surface<S>),
) -> S::u32s {
    macro_rules! splat {
        ($x:expr) => {
            S::f32s::splat(simd, $x)
        };
    }
    let records = shader.world.mirror_records();
    let nothing = S::u32s::splat(simd, 0);
    let ids = S::u32s::from_slice(simd, &tile.id[at..at + lanes::<S>()]);
    let first = tile.id[at];
    if ids.simd_eq(S::u32s::splat(simd, first)).all_true() {
        // One triangle, or none: its colour is taken apart once.
        if first != known.0 {
            let Some(&record) = records.get(first as usize) else {
                return nothing;
            };
            *known = (first, Surface::new(simd, record));
        }
        if first == MISS {
            return nothing;
        }
        return mirrored(simd, known.1.m, known.1.half_rgb, a);
    }
    // Misses read some record and are blanked in the end.
    let hit = load(simd, &tile.z, at).simd_gt(splat!(0.0));
    let [x, y, z, c] = simd.gather4(records, &tile.id[at..at + lanes::<S>()]);
    let color: S::u32s = c.bitcast();
    macro_rules! channel {
        ($shift:expr) => {{
            let c: S::i32s = ((color >> $shift) & S::u32s::splat(simd, 255)).bitcast();
            c.to_float::<S::f32s>() * splat!(0.5)
        }};
    }
    let rgb = mirrored(simd, [x, y, z], [channel!(16), channel!(8), channel!(0)], a);
    hit.select(rgb, nothing)
}

/// The pixels whose rays have the directions `a`, where the light is mirrored to `m` and the colours are twice `half_rgb`,
/// each channel of 0..=255.
#[inline(always)]
fn mirrored<S: Lanes>(
    simd: S,
    m: [S::f32s; 3],
    half_rgb: [S::f32s; 3],
    a: [S::f32s; 3],
) -> S::u32s {
    macro_rules! splat {
        ($x:expr) => {
            S::f32s::splat(simd, $x)
        };
    }
    let length = ((a[0] * a[0] + a[1] * a[1]) + a[2] * a[2]).sqrt();
    let cosine = ((m[0] * a[0] + m[1] * a[1]) + m[2] * a[2]) / length;
    // Twice what is shown, of half the colour: to halve is exact, so the products are the same.
    let twice = (splat!(1.0) - cosine).max(splat!(0.0)).min(splat!(2.0));
    // With 2²³ added, which rounds to whole numbers, halves to even, the number is in the lowest bits, below those of the
    // exponent.
    macro_rules! channel {
        ($half:expr) => {
            (twice * $half + splat!(8_388_608.0)).bitcast::<S::u32s>()
        };
    }
    let pixels = channel!(half_rgb[0]) << 16 | channel!(half_rgb[1]) << 8 | channel!(half_rgb[2]);
    pixels & S::u32s::splat(simd, 0xff_ffff)
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
