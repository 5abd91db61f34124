//! The triangles of a leaf against a tile: lanes are triangles here.
//!
//! Each vertex is transformed once. Then every lane gets its triangle's screen box, and those whose box holds a
//! pixel's centre their edge functions. From there three ways lead to pixels, by size: at most 2x2 pixels (lanes
//! stay triangles), at most 2x2 blocks (pairs of block and triangle), larger (lanes become blocks).

use super::coverage::{Broadcast, Candidate, HIGH, LOW, SURE, Setup, cover, min3};
use super::depth::{NEAR, STEEP};
use super::exact::{self, PixelRay};
use super::space::{HALF, ROUNDOFF, TILE, TileSpace, Uvw};
use super::tile::{BLOCKS, TABLES, Tile, pixel_offset};
use crate::bvh::Leaf;
use crate::simd::{
    Bytes, Lanes, Select, SimdBase, SimdFloat, VertexScratch, bits, lanes, load, store,
};

/// Pixels that a screen box reaches beyond the exact outline: more than the rounding of u/w.
const BOX_MARGIN_PX: f32 = 1.0 / 256.0;

/// The kernels' error bounds hold for corners with |u| + |v| + 32|w| up to this (w is about 1 at most).
pub const TAME: f64 = 1e10;

/// Where a leaf's intermediate results live between leaves.
#[derive(Clone, Debug)]
pub struct Scratch {
    vertices: VertexScratch,
    setup: Setup,
    /// First and last column, first and last row of each lane's screen box, in pixels.
    boxes: [[i32; 16]; 4],
}

impl Scratch {
    /// Nothing yet.
    pub const NEW: Scratch = Scratch {
        vertices: VertexScratch::NEW,
        setup: Setup([[0.0; 16]; 16]),
        boxes: [[0; 16]; 4],
    };
}

/// What the leaves of one tile share.
#[derive(Clone, Copy, Debug)]
pub struct LeafContext<'a> {
    /// The tile's frame.
    pub space: &'a TileSpace,
    /// The file's number of each triangle in leaf order.
    pub file_ids: &'a [u32],
    /// Nothing beyond this distance can be seen.
    pub tile_far: f32,
    /// Rounding error that the edge functions allow for, see [`Guard`].
    pub guard: Guard,
}

/// How much rounding error an edge function allows for before it asks the exact test: `relative` times the size of
/// its terms, plus `absolute`.
#[derive(Clone, Copy, Debug)]
pub struct Guard {
    relative: f32,
    absolute: f32,
}

impl Guard {
    /// Seven operations are rounded on the way to an edge function's value; what is lost below the smallest `f32`
    /// is covered, too, given the limit [`TAME`].
    pub const ON: Guard = Guard {
        relative: 8.0 * ROUNDOFF,
        absolute: 1e-37,
    };

    /// Trusts every rounded sign. Meshes leak: for the test that shows it.
    pub const OFF: Guard = Guard {
        relative: 0.0,
        absolute: 0.0,
    };
}

/// A vector (u, v, w) a lane.
type Vec3s<S> = [<S as crate::simd::Simd>::f32s; 3];

#[inline(always)]
fn cross<S: Lanes>(a: Vec3s<S>, b: Vec3s<S>) -> Vec3s<S> {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

#[inline(always)]
fn sub<S: Lanes>(a: Vec3s<S>, b: Vec3s<S>) -> Vec3s<S> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn add<S: Lanes>(a: Vec3s<S>, b: Vec3s<S>) -> Vec3s<S> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// |u| + |v| + 32|w|: bounds every term of an edge function over the tile.
#[inline(always)]
fn size<S: Lanes>(simd: S, a: Vec3s<S>) -> S::f32s {
    (a[0].abs() + a[1].abs()) + a[2].abs() * S::f32s::splat(simd, TILE as f32 / 2.0)
}

/// Traces one leaf. Returns the 8x8 blocks in which it won a pixel, as bits, row by row.
#[inline(always)]
pub fn trace<S: Lanes, const COST: bool>(
    simd: S,
    context: &LeafContext<'_>,
    leaf: Leaf<'_>,
    scratch: &mut Scratch,
    tile: &mut Tile,
) -> u64 {
    let chunks = transform(simd, context.space, leaf, &mut scratch.vertices);
    let mut dirty = 0;
    let mut first = 0;
    while first < leaf.count() {
        dirty |= group::<S, COST>(simd, context, leaf, first, chunks, scratch, tile);
        first += lanes::<S>();
    }
    dirty
}

/// Transforms the leaf's vertices; how many times 16 there are.
#[inline(always)]
fn transform<S: Lanes>(
    simd: S,
    space: &TileSpace,
    leaf: Leaf<'_>,
    out: &mut VertexScratch,
) -> usize {
    macro_rules! splat {
        ($x:expr) => {
            S::f32s::splat(simd, $x)
        };
    }
    let eye = [
        splat!(space.eye.x),
        splat!(space.eye.y),
        splat!(space.eye.z),
    ];
    let one = splat!(1.0);
    let count = leaf.vertex_count();
    let mut at = 0;
    while at < count {
        let (chunk, lane) = (at / 16, at % 16);
        macro_rules! relative {
            ($axis:expr) => {{
                let words = &leaf.coordinate_bits(chunk, $axis)[lane..lane + lanes::<S>()];
                S::u32s::from_slice(simd, words).bitcast::<S::f32s>() - eye[$axis]
            }};
        }
        let q = [relative!(0), relative!(1), relative!(2)];
        macro_rules! row {
            ($k:expr) => {{
                let r = space.rows[$k];
                (splat!(r.x) * q[0] + splat!(r.y) * q[1]) + splat!(r.z) * q[2]
            }};
        }
        let w = row!(2);
        simd.put_vertices(out, at, [row!(0), row!(1), w, one / w]);
        at += lanes::<S>();
    }
    count.div_ceil(16)
}

/// Traces as many triangles of the leaf as there are lanes, from `first` on.
#[inline(always)]
fn group<S: Lanes, const COST: bool>(
    simd: S,
    context: &LeafContext<'_>,
    leaf: Leaf<'_>,
    first: usize,
    chunks: usize,
    scratch: &mut Scratch,
    tile: &mut Tile,
) -> u64 {
    macro_rules! splat {
        ($x:expr) => {
            S::f32s::splat(simd, $x)
        };
    }
    let left = leaf.count() - first;
    let valid = if left >= lanes::<S>() {
        u32::MAX >> (32 - lanes::<S>())
    } else {
        (1 << left) - 1
    };
    let [u0, v0, w0, i0] = simd.corners(&scratch.vertices, leaf.corner_words(0), first, chunks);
    let [u1, v1, w1, i1] = simd.corners(&scratch.vertices, leaf.corner_words(1), first, chunks);
    let [u2, v2, w2, i2] = simd.corners(&scratch.vertices, leaf.corner_words(2), first, chunks);

    // Screen boxes. A triangle that reaches behind the eye has none: its box is the whole tile.
    let near = splat!(NEAR);
    let (w_min, w_max) = (w0.min(w1.min(w2)), w0.max(w1.max(w2)));
    let in_front = w_min.simd_gt(near);
    let mut keep = w_max.simd_gt(near) & w_min.simd_le(splat!(context.tile_far));
    let mut low = [splat!(0.0); 2];
    let mut high = low;
    let screen = [[u0 * i0, u1 * i1, u2 * i2], [v0 * i0, v1 * i1, v2 * i2]];
    for k in 0..2 {
        let [a, b, c] = screen[k];
        let l = in_front.select(a.min(b.min(c)), splat!(-1e9)) + splat!(HALF - BOX_MARGIN_PX);
        let h = in_front.select(a.max(b.max(c)), splat!(1e9)) + splat!(HALF + BOX_MARGIN_PX);
        low[k] = l.max(splat!(0.0)).min(splat!(TILE as f32)).ceil();
        high[k] = h.max(splat!(-1.0)).min(splat!(TILE as f32 - 1.0)).floor();
        keep &= low[k].simd_le(high[k]);
    }
    let mut todo = bits::<S>(keep) & valid;
    if COST {
        count_tests::<S>(tile, &low, &high, todo);
    }
    if todo == 0 {
        return 0;
    }

    // Edge functions: p × q as (p − q) × (p + q) / 2, which loses nothing to cancellation.
    let corners = [[u0, v0, w0], [u1, v1, w1], [u2, v2, w2]];
    let [a, b, c] = corners;
    let sizes = [size(simd, a), size(simd, b), size(simd, c)];
    let edges = [sub::<S>(a, b), sub::<S>(b, c), sub::<S>(c, a)];
    let lengths = [
        size(simd, edges[0]),
        size(simd, edges[1]),
        size(simd, edges[2]),
    ];
    let normal = cross::<S>(edges[2], edges[0]);
    let determinant = (normal[0] * u0 + normal[1] * v0) + normal[2] * w0;

    // Which way round: beyond its rounding error, or exactly.
    let doubt = splat!(16.0 * ROUNDOFF / 32.0) * sizes[0] * lengths[2] * lengths[0] + splat!(1e-30);
    let mut sign = splat!(1.0).copysign(determinant);
    let unsure = bits::<S>(!determinant.abs().simd_gt(doubt)) & todo;
    if unsure != 0 {
        let mut signs = [0.0f32; 16];
        store::<S>(sign, &mut signs, 0);
        todo &= exact_signs(simd, leaf, first, &scratch.vertices, unsure, &mut signs);
        sign = load(simd, &signs, 0);
    }

    let mut k = edges;
    let mut errors = [splat!(0.0); 3];
    let mut reach = errors;
    for i in 0..3 {
        let j = (i + 1) % 3;
        let n = cross::<S>(edges[i], add::<S>(corners[i], corners[j]));
        let terms = lengths[i] * (sizes[i] + sizes[j]);
        let error = terms * splat!(context.guard.relative) + splat!(context.guard.absolute);
        reach[i] = n[0].abs() + n[1].abs();
        errors[i] = error;
        k[i] = [n[0] * sign, n[1] * sign, n[2] * sign + error];
    }
    let error = errors[0].max(errors[1].max(errors[2]));
    let sure = error + error;

    // 1/w, as in `Depth::of`.
    let inverse = splat!(1.0) / determinant;
    let z = [
        normal[0] * inverse,
        normal[1] * inverse,
        normal[2] * inverse,
    ];
    let z_low = in_front.select(i0.min(i1.min(i2)), splat!(1.0) / w_max);
    let z_high = in_front.select(i0.max(i1.max(i2)), splat!(f32::MAX));
    let usable = ((z[0].abs() + z[1].abs()) + z[2].abs()).simd_lt(splat!(STEEP));
    let zero = splat!(0.0);
    let depth = [
        usable.select(z[0], zero),
        usable.select(z[1], zero),
        usable.select(z[2], z_low),
    ];

    let job = Job {
        leaf,
        first,
        file_ids: context.file_ids,
    };
    let extent = [high[0] - low[0], high[1] - low[1]];
    let one = splat!(1.0);
    let micro = bits::<S>(extent[0].simd_le(one) & extent[1].simd_le(one)) & todo;
    let mut dirty = 0;
    if micro != 0 {
        todo &= !micro;
        let lanes = MicroLanes::<S> {
            edges: k,
            depth,
            z_low,
            z_high,
            sure,
            low,
            extent,
        };
        dirty |= micro_triangles(simd, &job, &lanes, micro, &scratch.vertices, tile);
        if todo == 0 {
            return dirty;
        }
    }

    let rows = k.into_iter().flatten().chain(depth);
    for (row, lanes) in scratch.setup.0.iter_mut().zip(rows) {
        store::<S>(lanes, row, 0);
    }
    store::<S>(z_low, &mut scratch.setup.0[LOW], 0);
    store::<S>(z_high, &mut scratch.setup.0[HIGH], 0);
    store::<S>(sure, &mut scratch.setup.0[SURE], 0);

    // Very long edges: their error would put whole rows of pixels in doubt.
    let coarse = error.simd_gt(min3::<S>(reach) * splat!(1.0 / 512.0));
    let coarse = bits::<S>(coarse) & todo;
    if coarse != 0 {
        let mut signs = [0.0f32; 16];
        store::<S>(sign, &mut signs, 0);
        let vertices = &scratch.vertices;
        todo &= refine(
            simd,
            leaf,
            first,
            vertices,
            coarse,
            &signs,
            &mut scratch.setup,
        );
        if todo == 0 {
            return dirty;
        }
    }

    // In blocks of 4x4.
    let quarter = splat!(0.25);
    let block_low = [(low[0] * quarter).floor(), (low[1] * quarter).floor()];
    let block_high = [(high[0] * quarter).floor(), (high[1] * quarter).floor()];
    let wide = [block_high[0] - block_low[0], block_high[1] - block_low[1]];
    for i in 0..2 {
        let to_int = |v: S::f32s, out: &mut [i32; 16]| {
            let v: S::i32s = v.to_int();
            v.store_slice(&mut out[..lanes::<S>()]);
        };
        to_int(block_low[i], &mut scratch.boxes[2 * i]);
        to_int(block_high[i], &mut scratch.boxes[2 * i + 1]);
    }
    let small = bits::<S>(wide[0].simd_le(one) & wide[1].simd_le(one)) & todo;
    if small != 0 {
        todo &= !small;
        let two_columns = bits::<S>(wide[0].simd_ge(one)) & small;
        let two_rows = bits::<S>(wide[1].simd_ge(one)) & small;
        let pairs = Pairs::<S>::of(
            simd,
            &scratch.setup,
            block_low,
            [small, two_columns, two_rows],
        );
        dirty |= small_triangles(simd, &job, pairs.0, scratch, tile);
    }
    while todo != 0 {
        let lane = todo.trailing_zeros() as usize & 15;
        todo &= todo - 1;
        dirty |= large_triangle(simd, &job, lane, scratch, tile);
    }
    dirty
}

/// The leaf at work.
#[derive(Clone, Copy)]
struct Job<'a> {
    leaf: Leaf<'a>,
    /// Place of lane 0's triangle in the leaf.
    first: usize,
    file_ids: &'a [u32],
}

impl<'a> Job<'a> {
    #[inline(always)]
    fn candidate(&self, lane: usize, vertices: &'a VertexScratch) -> Candidate<'a> {
        let place = self.first + lane;
        Candidate {
            id: self.leaf.first_id() + place as u32,
            place,
            leaf: self.leaf,
            vertices,
            file_ids: self.file_ids,
        }
    }
}

/// The corners, in the tile's frame, of the triangle at a place of a leaf.
fn corners_of<S: Lanes>(
    simd: S,
    leaf: Leaf<'_>,
    place: usize,
    vertices: &VertexScratch,
) -> [Uvw; 3] {
    [0, 1, 2].map(|corner| {
        let [u, v, w, _] = simd.vertex(vertices, leaf.vertex_of(corner, place));
        Uvw { u, v, w }
    })
}

/// Puts the exact orientation of the lanes `unsure` into `signs`; the lanes to keep: all but those seen edge-on.
#[cold]
#[inline(never)]
fn exact_signs<S: Lanes>(
    simd: S,
    leaf: Leaf<'_>,
    first: usize,
    vertices: &VertexScratch,
    unsure: u32,
    signs: &mut [f32; 16],
) -> u32 {
    let mut keep = u32::MAX;
    for (lane, sign) in signs.iter_mut().enumerate().take(lanes::<S>()) {
        if unsure >> lane & 1 != 0 {
            let [a, b, c] = corners_of(simd, leaf, first + lane, vertices);
            let exact = exact::orientation(a, b, c);
            *sign = exact.signum() as f32;
            keep &= !(u32::from(exact == 0.0) << lane);
        }
    }
    keep
}

/// Forms the edges of the lanes `coarse` anew from `f64`, in pixels: an edge's error is then a small part of a
/// pixel, whatever its length. Edges that do not cross the tile are settled here. The lanes to keep.
#[cold]
#[inline(never)]
fn refine<S: Lanes>(
    simd: S,
    leaf: Leaf<'_>,
    first: usize,
    vertices: &VertexScratch,
    coarse: u32,
    signs: &[f32; 16],
    setup: &mut Setup,
) -> u32 {
    let mut keep = u32::MAX;
    for lane in (0..lanes::<S>()).filter(|lane| coarse >> lane & 1 != 0) {
        let corners = corners_of(simd, leaf, first + lane, vertices);
        let mut sure = 0.0f32;
        for i in 0..3 {
            let edge = refined_edge(corners[i], corners[(i + 1) % 3], f64::from(signs[lane]));
            let ([u, v, w], error) = match edge {
                Edge::Outside => {
                    keep &= !(1 << lane);
                    continue;
                }
                Edge::Inside => ([0.0, 0.0, STEEP], 0.0),
                Edge::Crosses(k, error) => (k, error),
            };
            sure = sure.max(2.0 * error);
            setup.0[3 * i][lane] = u;
            setup.0[3 * i + 1][lane] = v;
            setup.0[3 * i + 2][lane] = w + error;
        }
        setup.0[SURE][lane] = sure;
    }
    keep
}

/// How an edge lies to a tile.
enum Edge {
    /// No pixel is on its inner side.
    Outside,
    /// All pixels are.
    Inside,
    /// Coefficients, without their error bound, and that bound.
    Crosses([f32; 3], f32),
}

/// The edge function of p and q from `f64`, scaled so that a unit is about a pixel.
fn refined_edge(p: Uvw, q: Uvw, sign: f64) -> Edge {
    let [pu, pv, pw] = [p.u, p.v, p.w].map(f64::from);
    let [qu, qv, qw] = [q.u, q.v, q.w].map(f64::from);
    // Products of two f32 are exact in f64; each difference is rounded once.
    let n = [pv * qw - pw * qv, pw * qu - pu * qw, pu * qv - pv * qu];
    let slope = n[0].abs() + n[1].abs();
    // 32 is more than the farthest pixel's 31.5: the difference covers all rounding.
    let beyond = n[2].abs() > slope * 32.0;
    if beyond {
        return if n[2] * sign > 0.0 {
            Edge::Inside
        } else {
            Edge::Outside
        };
    }
    if slope == 0.0 {
        // p and q are the same point on screen, or one of them is the eye: every pixel lies on the edge.
        return Edge::Inside;
    }
    let k = n.map(|n| (n * sign / slope) as f32);
    // One rounding of each coefficient, four of the sum, with |x'| and |y'| below 32 and |w| up to 32.
    Edge::Crosses(k, 16.0 * ROUNDOFF * 64.0)
}

/// Lanes for [`micro_triangles`].
struct MicroLanes<S: Lanes> {
    edges: [Vec3s<S>; 3],
    depth: Vec3s<S>,
    z_low: S::f32s,
    z_high: S::f32s,
    sure: S::f32s,
    /// First column and row of the box.
    low: [S::f32s; 2],
    /// Columns and rows less one.
    extent: [S::f32s; 2],
}

/// Triangles whose box holds at most 2x2 pixels' centres: four evaluations, then one loop over the hits of all.
#[inline(always)]
fn micro_triangles<S: Lanes>(
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
        hits &= settle(simd, job, doubts, &columns, &rows, vertices);
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

/// The bits of `doubts` (16 * pixel + lane) that are misses after all, cleared; all other bits set.
#[cold]
#[inline(never)]
fn settle<S: Lanes>(
    simd: S,
    job: &Job<'_>,
    doubts: u64,
    columns: &[i32; 16],
    rows: &[i32; 16],
    vertices: &VertexScratch,
) -> u64 {
    let mut keep = u64::MAX;
    let mut left = doubts;
    while left != 0 {
        let p = left.trailing_zeros() as usize;
        left &= left - 1;
        let lane = p & 15;
        let ray = PixelRay {
            x: (columns[lane] + (p >> 4 & 1) as i32) as f32 - HALF,
            y: (rows[lane] + (p >> 5) as i32) as f32 - HALF,
        };
        let corners = corners_of(simd, job.leaf, job.first + lane, vertices);
        keep &= !(u64::from(!exact::hits(&corners, ray)) << p);
    }
    keep
}

/// Pairs of a 4x4 block and a triangle that may meet: bit 16 * block + lane, blocks of the 2x2 in a row.
struct Pairs<S>(u64, std::marker::PhantomData<S>);

impl<S: Lanes> Pairs<S> {
    /// `small`: the lanes; of these, which reach into a second column and row of blocks.
    #[inline(always)]
    fn of(simd: S, setup: &Setup, block_low: [S::f32s; 2], which: [u32; 3]) -> Pairs<S> {
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
        let pairs = u64::from(touched!(at) & small)
            | u64::from(touched!(right_of) & two_columns) << 16
            | u64::from(touched!(below) & two_rows) << 32
            | u64::from(touched!(across) & two_columns & two_rows) << 48;
        Pairs(pairs, std::marker::PhantomData)
    }
}

/// Triangles whose box lies inside 2x2 blocks, as pairs of block and triangle.
#[inline(always)]
fn small_triangles<S: Lanes>(
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
fn large_triangle<S: Lanes>(
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

/// Counts a triangle test for every 4x4 block of a kept triangle's box.
fn count_tests<S: Lanes>(tile: &mut Tile, low: &[S::f32s; 2], high: &[S::f32s; 2], kept: u32) {
    for lane in (0..lanes::<S>()).filter(|lane| kept >> lane & 1 != 0) {
        let block = |v: S::f32s| v[lane] as usize / 4;
        for by in block(low[1])..=block(high[1]) {
            for bx in block(low[0])..=block(high[0]) {
                tile.cost[by * BLOCKS + bx] += 1;
            }
        }
    }
}
