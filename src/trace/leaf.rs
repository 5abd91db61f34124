//! The triangles of a leaf against a tile: lanes are triangles here.
//!
//! Each vertex is transformed once. Then every lane gets its triangle's screen box, and those whose box holds a
//! pixel's centre their edge functions. From there three ways lead to pixels, by size: at most 4x4 pixels (lanes
//! stay triangles), at most 16x16 pixels (pairs of unit and triangle), larger (lanes become blocks).

use super::coverage::{DEPTH, EXTENT, HIGH, ID, Job, LOW, LOW_PIXEL, SURE, Scratch, min3};
use super::depth::{NEAR, STEEP};
use super::doubt;
use super::frustum::block_mask;
use super::probe::{Probe, StageTicks, Stopwatch};
use super::raster::{self, SPECK};
use super::space::{HALF, ROUNDOFF, TILE, TileSpace};
use super::tile::{BLOCKS, TABLES, Tile};
use super::vec3s::{add, cross, size, sub};
use crate::bvh::Leaf;
use crate::simd::{
    Bytes, LANE_NUMBERS, Lanes, Select, SimdBase, SimdFloat, SimdMask, VertexScratch, all_lanes,
    bits, lanes, load, store,
};

/// Pixels that a screen box reaches beyond the exact outline: more than the rounding of u/w.
const BOX_MARGIN_PX: f32 = 1.0 / 256.0;

/// The kernels' error bounds hold for corners with |u| + |v| + 32|w| up to this (w is about 1 at most).
pub const TAME: f64 = 1e10;

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
    /// More pairs of a small triangle and pixels were hidden in this tile than seen.
    pub overdrawn: bool,
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

/// Traces one leaf. Returns the 8x8 blocks in which it won a pixel, as bits, row by row.
#[inline(always)]
pub fn trace<S: Lanes, P: Probe>(
    simd: S,
    context: &LeafContext<'_>,
    leaf: Leaf<'_>,
    scratch: &mut Scratch,
    stages: &mut StageTicks,
    tile: &mut Tile,
) -> u64 {
    let mut watch = Stopwatch::start::<P>();
    let around = transform(simd, context.space, leaf, &mut scratch.vertices);
    scratch.leaves += 1;
    if around.is_hidden(simd, context, leaf, tile, &mut scratch.missed) {
        stages.setup += watch.lap::<P>();
        return 0;
    }
    let chunks = leaf.vertex_count().div_ceil(16);
    let mut sorted = Sorted::default();
    let mut first = 0;
    while first < leaf.count() {
        set_up::<S, P>(
            simd,
            context,
            leaf,
            first,
            chunks,
            scratch,
            tile,
            &mut sorted,
        );
        first += lanes::<S>();
    }
    stages.setup += watch.lap::<P>();
    let job = Job {
        leaf,
        file_ids: context.file_ids,
        overdrawn: context.overdrawn,
    };
    let mut dirty = 0;
    let mut left = sorted.specks;
    while left != 0 {
        let first = left.trailing_zeros() as usize & (16 - lanes::<S>());
        let specks = left >> first & all_lanes::<S>();
        left &= !(specks << first);
        dirty |= raster::specks(simd, &job, first, specks, scratch, tile);
    }
    if sorted.small != 0 {
        dirty |= raster::small_triangles(simd, &job, sorted.small, scratch, tile);
    }
    let mut left = sorted.large;
    if left != 0
        && tile.touched | dirty == 0
        && let Some(lane) = raster::first_whole(simd, &scratch.setup, left)
    {
        left &= !(1 << lane);
        let last = context.space.last.map(|last| usize::from(last) / 4);
        tile.take_whole(simd, scratch.setup.whole(lane, last));
        dirty = block_mask([0, last[0] as u32 / 2, 0, last[1] as u32 / 2]);
    }
    while left != 0 {
        let lane = left.trailing_zeros() as usize & 15;
        left &= left - 1;
        dirty |= raster::large_triangle(simd, &job, lane, scratch, tile);
    }
    stages.coverage += watch.lap::<P>();
    dirty
}

/// The triangles of a leaf that may cover pixels, as bits, by the way that leads to these.
#[derive(Clone, Copy, Debug, Default)]
struct Sorted {
    specks: u32,
    small: u32,
    large: u32,
}

/// What surrounds all of a leaf's vertices: least and most of each lane.
struct Around<S: Lanes> {
    /// Smallest u/w and v/w.
    low: [S::f32s; 2],
    /// Largest of them.
    high: [S::f32s; 2],
    /// Smallest w.
    w: S::f32s,
    /// Largest 1/w.
    inverse: S::f32s,
}

impl<S: Lanes> Around<S> {
    /// True when every pixel that the leaf can cover already holds something nearer than all of it, or when there is
    /// no such pixel: that is counted by `missed`.
    #[inline(always)]
    fn is_hidden(
        &self,
        simd: S,
        context: &LeafContext<'_>,
        leaf: Leaf<'_>,
        tile: &Tile,
        missed: &mut u32,
    ) -> bool {
        if self.w.reduce_min() <= NEAR {
            return false;
        }
        let nearest = self.inverse.reduce_max();
        let (mut low, mut high) = ([0.0; 2], [0.0; 2]);
        for k in 0..2 {
            low[k] = (self.low[k].reduce_min() + (HALF - BOX_MARGIN_PX))
                .ceil()
                .max(0.0);
            high[k] = (self.high[k].reduce_max() + (HALF + BOX_MARGIN_PX))
                .floor()
                .min(f32::from(context.space.last[k]));
            if low[k] > high[k] {
                *missed += 1;
                return true;
            }
        }
        match look_at_region(simd, tile, low, high, nearest) {
            Region::Open => false,
            Region::Hidden => true,
            Region::Tied => ties_lose(context.file_ids, leaf, tile, low, high, nearest),
        }
    }
}

/// What the pixels of a region hold, beside the 1/w of something behind them.
enum Region {
    /// Some hold something farther.
    Open,
    /// Some hold something as far, none something farther.
    Tied,
    /// All hold something nearer.
    Hidden,
}

/// The pixels from `low` to `high` (column and row, whole numbers) beside 1/w `nearest`.
#[inline(always)]
fn look_at_region<S: Lanes>(
    simd: S,
    tile: &Tile,
    low: [f32; 2],
    high: [f32; 2],
    nearest: f32,
) -> Region {
    let nearest = S::f32s::splat(simd, nearest);
    let mut found = Region::Hidden;
    macro_rules! pixel {
        ($v:expr) => {
            S::f32s::splat(simd, $v - HALF)
        };
    }
    let [x0, y0] = [pixel!(low[0]), pixel!(low[1])];
    let [x1, y1] = [pixel!(high[0]), pixel!(high[1])];
    for by in low[1] as usize / 4..=high[1] as usize / 4 {
        for bx in low[0] as usize / 4..=high[0] as usize / 4 {
            let at = TABLES.block(bx, by);
            let mut i = 0;
            while i < 16 {
                let z = load(simd, &tile.z, at + i);
                let open = z.simd_le(nearest);
                if open.any_true() {
                    let (x, y) = (
                        load(simd, &TABLES.x[bx % BLOCKS], i),
                        load(simd, &TABLES.y[by % BLOCKS], i),
                    );
                    let inside = x.simd_ge(x0) & x.simd_le(x1) & y.simd_ge(y0) & y.simd_le(y1);
                    if (z.simd_lt(nearest) & inside).any_true() {
                        return Region::Open;
                    }
                    if (open & inside).any_true() {
                        found = Region::Tied;
                    }
                }
                i += lanes::<S>();
            }
        }
    }
    found
}

/// True when the pixels of a region that hold something exactly as far as a leaf's nearest vertex hold a lower number
/// of the file than all of the leaf's. So it goes where many triangles lie in one plane across the view.
#[cold]
#[inline(never)]
fn ties_lose(
    file_ids: &[u32],
    leaf: Leaf<'_>,
    tile: &Tile,
    low: [f32; 2],
    high: [f32; 2],
    nearest: f32,
) -> bool {
    let first = leaf.first_id() as usize;
    let lowest = file_ids[first..first + leaf.count()].iter().min();
    (low[1] as usize..=high[1] as usize).all(|y| {
        (low[0] as usize..=high[0] as usize).all(|x| {
            let at = TABLES.pixel(x, y);
            tile.z[at] != nearest || Some(&file_ids[tile.id[at] as usize]) < lowest
        })
    })
}

/// Transforms the leaf's vertices.
#[inline(always)]
fn transform<S: Lanes>(
    simd: S,
    space: &TileSpace,
    leaf: Leaf<'_>,
    out: &mut VertexScratch,
) -> Around<S> {
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
    let mut around = Around::<S> {
        low: [splat!(f32::MAX); 2],
        high: [splat!(f32::MIN); 2],
        w: splat!(f32::MAX),
        inverse: splat!(f32::MIN),
    };
    let mut at = 0;
    // Lanes beyond the last vertex hold it again.
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
        let (u, v, w) = (row!(0), row!(1), row!(2));
        let inverse = one / w;
        let (x, y) = (u * inverse, v * inverse);
        around.low = [around.low[0].min(x), around.low[1].min(y)];
        around.high = [around.high[0].max(x), around.high[1].max(y)];
        around.w = around.w.min(w);
        around.inverse = around.inverse.max(inverse);
        simd.put_vertices(out, at, [u, v, w, inverse]);
        at += lanes::<S>();
    }
    around
}

/// Sets up as many triangles of the leaf as there are lanes, from `first` on.
#[inline(always)]
#[expect(
    clippy::too_many_arguments,
    reason = "inlined into its one caller: only a name for the body of its loop"
)]
fn set_up<S: Lanes, P: Probe>(
    simd: S,
    context: &LeafContext<'_>,
    leaf: Leaf<'_>,
    first: usize,
    chunks: usize,
    scratch: &mut Scratch,
    tile: &mut Tile,
    sorted: &mut Sorted,
) {
    macro_rules! splat {
        ($x:expr) => {
            S::f32s::splat(simd, $x)
        };
    }
    let left = leaf.count() - first;
    let valid = if left >= lanes::<S>() {
        all_lanes::<S>()
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
        let last = splat!(f32::from(context.space.last[k]));
        high[k] = h.max(splat!(-1.0)).min(last).floor();
        keep &= low[k].simd_le(high[k]);
    }
    let mut todo = bits::<S>(keep) & valid;
    if P::COUNTS {
        count_tests::<S>(tile, &low, &high, todo);
    }
    if todo == 0 {
        return;
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
        todo &= doubt::exact_signs(simd, leaf, first, &scratch.vertices, unsure, &mut signs);
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

    // One by one: a loop over the vectors would send them through memory twice.
    macro_rules! keep_row {
        ($row:expr, $lanes:expr) => {
            store::<S>($lanes, &mut scratch.setup.0[$row], first)
        };
    }
    macro_rules! keep_rows {
        ($first:expr, $vector:expr) => {
            keep_row!($first, $vector[0]);
            keep_row!($first + 1, $vector[1]);
            keep_row!($first + 2, $vector[2]);
        };
    }
    keep_rows!(0, k[0]);
    keep_rows!(3, k[1]);
    keep_rows!(6, k[2]);
    keep_rows!(DEPTH, depth);
    keep_row!(LOW, z_low);
    keep_row!(HIGH, z_high);
    keep_row!(SURE, sure);
    let ids = S::u32s::from_slice(simd, &LANE_NUMBERS[first..first + lanes::<S>()])
        + S::u32s::splat(simd, leaf.first_id());
    keep_row!(ID, ids.bitcast());
    let extent = [high[0] - low[0], high[1] - low[1]];
    keep_row!(LOW_PIXEL, low[0]);
    keep_row!(LOW_PIXEL + 1, low[1]);
    keep_row!(EXTENT, extent[0]);
    keep_row!(EXTENT + 1, extent[1]);
    let speck = splat!(SPECK as f32 - 1.0);
    let specks = bits::<S>(extent[0].simd_le(speck) & extent[1].simd_le(speck)) & todo;
    // A few of them are done faster one by one.
    if specks.count_ones() as usize >= lanes::<S>() / 2 {
        sorted.specks |= specks << first;
        todo &= !specks;
        if todo == 0 {
            return;
        }
    }

    // Very long edges: their error would put whole rows of pixels in doubt.
    let coarse = error.simd_gt(min3::<S>(reach) * splat!(1.0 / 512.0));
    let coarse = bits::<S>(coarse) & todo;
    if coarse != 0 {
        let mut signs = [0.0f32; 16];
        store::<S>(sign, &mut signs, 0);
        let vertices = &scratch.vertices;
        todo &= doubt::refine(
            simd,
            leaf,
            first,
            vertices,
            coarse,
            &signs,
            &mut scratch.setup,
        );
    }

    let (_, wide) = raster::units(simd, low, extent);
    let small = wide[0].simd_lt(splat!(raster::SMALL_COLUMNS as f32))
        & wide[1].simd_lt(splat!(raster::small_rows::<S>() as f32));
    let small = bits::<S>(small) & todo;
    sorted.small |= small << first;
    sorted.large |= (todo & !small) << first;
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
