//! One triangle over one 4x4 block of pixels: the innermost loop.
//!
//! An edge function is `f32` and has a rounding error of at most δ; its coefficients come with δ added. So a negative
//! value means outside, one of at least 2δ means inside, and between the two (about one pixel in ten thousand along
//! an edge) the exact test is asked. Equal distances are as rare: both go to one cold function.

use super::exact::{self, PixelRay};
use super::raster::SPECK;
use super::space::{HALF, ROUNDOFF, TILE, Uvw};
use super::tile::{BLOCKS, PIXELS, TABLES, Tile, Whole};
use crate::bvh::Leaf;
use crate::simd::{Lanes, Select, SimdBase, SimdMask, VertexScratch, lanes, load, store};

/// Rows of [`Setup`]: three edges of three coefficients, then these.
pub const DEPTH: usize = 9;
/// Row of the smallest 1/w.
pub const LOW: usize = 12;
/// Row of the largest 1/w.
pub const HIGH: usize = 13;
/// Row of twice the largest δ of the edges.
pub const SURE: usize = 14;
/// Row of the triangles' numbers in leaf order, as bits.
pub const ID: usize = 15;
/// Rows of the first column and row of pixels' centres in the triangles' screen boxes.
pub const LOW_PIXEL: usize = 16;
/// Rows of how many columns and rows follow on the first.
pub const EXTENT: usize = 18;
/// How many rows there are.
const ROWS: usize = 20;

/// Pairs of a unit and a small triangle of one leaf at most: 16 triangles in 16x16 pixels each, four of these a unit
/// where there are four lanes.
pub const MOST_PAIRS: usize = 1024;

/// What is known of the triangles of a leaf, up to 16: a column each.
#[repr(C, align(64))]
#[derive(Clone, Debug)]
pub struct Setup(pub [[f32; 16]; ROWS]);

impl Setup {
    /// The triangle of a lane as what covers all blocks up to column and row `last`.
    pub fn whole(&self, lane: usize, last: [usize; 2]) -> Whole {
        let row = |i: usize| self.0[i][lane & 15];
        Whole {
            id: row(ID).to_bits(),
            depth: [row(DEPTH), row(DEPTH + 1), row(DEPTH + 2)],
            low: row(LOW),
            high: row(HIGH),
            last,
        }
    }
}

/// Where a leaf's intermediate results live between leaves.
#[derive(Clone, Debug)]
pub struct Scratch {
    pub(super) vertices: VertexScratch,
    pub(super) setup: Setup,
    /// 1/w at each place of the specks' common box: see [`super::raster::specks`].
    pub(super) speck_depths: [[f32; 16]; SPECK * SPECK],
    /// Pairs of a unit and a small triangle of the leaf: 16 times the unit, and the triangle's column in `setup`.
    pub(super) pairs: [u32; MOST_PAIRS + 16],
    /// Those in this tile that won a pixel.
    pub(super) won: u32,
    /// Those that won none.
    pub(super) lost: u32,
    /// Leaves looked at in this tile.
    pub(super) leaves: u32,
    /// Those with no pixel's centre in them.
    pub(super) missed: u32,
}

impl Scratch {
    /// Nothing yet.
    pub const NEW: Scratch = Scratch {
        vertices: VertexScratch::NEW,
        setup: Setup([[0.0; 16]; ROWS]),
        speck_depths: [[0.0; 16]; SPECK * SPECK],
        pairs: [0; MOST_PAIRS + 16],
        won: 0,
        lost: 0,
        leaves: 0,
        missed: 0,
    };
}

/// The leaf at work.
#[derive(Clone, Copy)]
pub struct Job<'a> {
    /// The leaf.
    pub leaf: Leaf<'a>,
    /// The file's number of each triangle in leaf order.
    pub file_ids: &'a [u32],
    /// More pairs of a small triangle and pixels were hidden in this tile than seen.
    pub overdrawn: bool,
}

/// The triangle that a block is tested against, for the cold path.
#[derive(Clone, Copy)]
pub struct Candidate<'a> {
    /// Its leaf.
    pub job: &'a Job<'a>,
    /// The leaf's vertices in the tile's frame.
    pub vertices: &'a VertexScratch,
    /// Its lane.
    pub lane: usize,
}

impl Job<'_> {
    /// The number, in leaf order, of a triangle of the leaf.
    #[inline(always)]
    pub fn id(&self, lane: usize) -> u32 {
        self.leaf.first_id() + lane as u32
    }
}

/// The corners, in the tile's frame, of the triangle at a place of a leaf.
pub fn corners_of<S: Lanes>(
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
/// One triangle's coefficients in every lane.
#[derive(Clone, Copy)]
pub struct Broadcast<S: Lanes> {
    edges: [[S::f32s; 3]; 3],
    depth: [S::f32s; 3],
    low: S::f32s,
    high: S::f32s,
    sure: S::f32s,
    id: S::u32s,
}

impl<S: Lanes> Broadcast<S> {
    /// Lane `lane` of `setup`.
    #[inline(always)]
    pub fn new(simd: S, setup: &Setup, lane: usize) -> Broadcast<S> {
        let lane = lane & 15;
        macro_rules! row {
            ($i:expr) => {
                S::f32s::splat(simd, setup.0[$i][lane])
            };
        }
        Broadcast {
            edges: [
                [row!(0), row!(1), row!(2)],
                [row!(3), row!(4), row!(5)],
                [row!(6), row!(7), row!(8)],
            ],
            depth: [row!(DEPTH), row!(DEPTH + 1), row!(DEPTH + 2)],
            low: row!(LOW),
            high: row!(HIGH),
            sure: row!(SURE),
            id: S::u32s::splat(simd, setup.0[ID][lane].to_bits()),
        }
    }

    /// The three edge functions at given points.
    #[inline(always)]
    pub fn edges_at(&self, x: S::f32s, y: S::f32s) -> [S::f32s; 3] {
        let [a, b, c] = &self.edges;
        [
            a[0] * x + (a[1] * y + a[2]),
            b[0] * x + (b[1] * y + b[2]),
            c[0] * x + (c[1] * y + c[2]),
        ]
    }

    /// How far each edge function can differ from its value at the centre of a 4x4 block.
    #[inline(always)]
    pub fn block_reach(&self, simd: S) -> [S::f32s; 3] {
        // 1.5 pixels each way, and a little for rounding.
        let reach = S::f32s::splat(simd, 1.51);
        let [a, b, c] = &self.edges;
        [
            (a[0].abs() + a[1].abs()) * reach,
            (b[0].abs() + b[1].abs()) * reach,
            (c[0].abs() + c[1].abs()) * reach,
        ]
    }

    /// The depth at given points, and how far it can be above that within 1.5 pixels, rounding included.
    #[inline(always)]
    pub fn depth_at(&self, simd: S, x: S::f32s, y: S::f32s) -> S::f32s {
        let [u, v, w] = &self.depth;
        let terms = (u.abs() + v.abs()) * S::f32s::splat(simd, TILE as f32) + w.abs();
        let reach = (u.abs() + v.abs()) * S::f32s::splat(simd, 1.51)
            + terms * S::f32s::splat(simd, 16.0 * ROUNDOFF);
        ((*u * x + (*v * y + *w)) + reach)
            .max(self.low)
            .min(self.high)
    }

    /// Twice the largest δ.
    #[inline(always)]
    pub fn sure(&self) -> S::f32s {
        self.sure
    }
}

/// The smallest of three.
#[inline(always)]
pub fn min3<S: Lanes>(v: [S::f32s; 3]) -> S::f32s {
    v[0].min(v[1].min(v[2]))
}

/// Pixel rows of a unit: the part of a 4x4 block that fills a vector, 4 pixels wide.
pub const fn rows_of_unit<S: Lanes>() -> usize {
    lanes::<S>() / 4
}

/// Where a unit is.
#[derive(Clone, Copy)]
pub struct Place<S: Lanes> {
    /// The unit with its first pixel in column `4 * (unit % 16)` and row `unit / 16`.
    unit: usize,
    /// Where it starts in memory.
    pub at: usize,
    /// x′ and y′ of its pixels.
    x: S::f32s,
    y: S::f32s,
}

impl<S: Lanes> Place<S> {
    /// Of a unit, taken modulo the number of these.
    #[inline(always)]
    pub fn of_unit(simd: S, unit: usize) -> Place<S> {
        let row = (unit / BLOCKS) & (TILE - rows_of_unit::<S>());
        Place {
            unit,
            at: TABLES.unit(unit, lanes::<S>()),
            x: load(simd, &TABLES.x[unit % BLOCKS], 0),
            y: load(simd, TABLES.y.as_flattened(), 4 * row),
        }
    }
}

/// Tests one triangle at the pixels of block `block` (row by row of blocks) and keeps what is nearer; true when it
/// won a pixel. `FULL`: the caller knows that the triangle covers the whole block.
#[inline(always)]
pub fn cover<S: Lanes, const FULL: bool>(
    simd: S,
    tile: &mut Tile,
    k: &Broadcast<S>,
    block: usize,
    who: Candidate<'_>,
) -> bool {
    let mut won = false;
    let mut row = 0;
    while row < 4 {
        let unit = (block / BLOCKS * 4 + row) * BLOCKS + block % BLOCKS;
        won |= cover_unit::<S, FULL>(simd, tile, k, &Place::of_unit(simd, unit), who);
        row += rows_of_unit::<S>();
    }
    if FULL {
        // Large triangles are tested against this before they come here.
        let at = usize::from(TABLES.offset[block & (BLOCKS * BLOCKS - 1)]) & 0xff0;
        let mut least = load(simd, &tile.z, at);
        let mut first = lanes::<S>();
        while first < 16 {
            least = least.min(load(simd, &tile.z, at + first));
            first += lanes::<S>();
        }
        tile.floor[block & (BLOCKS * BLOCKS - 1)] = least.reduce_min();
    }
    won
}

/// The part of [`cover`] for one unit.
#[inline(always)]
pub fn cover_unit<S: Lanes, const FULL: bool>(
    simd: S,
    tile: &mut Tile,
    k: &Broadcast<S>,
    place: &Place<S>,
    who: Candidate<'_>,
) -> bool {
    let (at, x, y) = (place.at & (PIXELS - lanes::<S>()), place.x, place.y);
    let old = load(simd, &tile.z, at);
    let z = k.depth[0] * x + (k.depth[1] * y + k.depth[2]);
    let z = z.max(k.low).min(k.high);
    let (wins, rare, sure);
    if FULL {
        wins = z.simd_gt(old);
        rare = z.simd_eq(old);
        sure = wins | rare;
    } else {
        let inside = min3::<S>(k.edges_at(x, y));
        let maybe = inside.simd_ge(0.0) & z.simd_ge(old);
        sure = inside.simd_ge(k.sure);
        wins = sure & z.simd_gt(old);
        rare = maybe ^ wins;
    }
    if rare.any_true() {
        let mut zs = [0.0f32; 16];
        store::<S>(z, &mut zs, 0);
        let candidates = (rare | wins).to_bitmask() as u32;
        let sure = sure.to_bitmask() as u32;
        // In parts: as one they would be put together in memory even when they are not needed.
        let Candidate {
            job,
            vertices,
            lane,
        } = who;
        return cover_exactly(
            simd, tile, &zs, candidates, sure, place.unit, job, vertices, lane,
        );
    }
    // Blend and store without asking whether anything won: the answer is hard to predict.
    store::<S>(wins.select(z, old), &mut tile.z, at);
    let ids = &mut tile.id[at..at + lanes::<S>()];
    let old_ids = S::u32s::from_slice(simd, ids);
    wins.select(k.id, old_ids).store_slice(ids);
    wins.any_true()
}

/// What [`cover_unit`] does for the lanes `candidates`, without any doubt left. `sure`: lanes whose pixel the triangle
/// covers, known beforehand; `triangle`: its lane.
#[cold]
#[inline(never)]
#[expect(
    clippy::too_many_arguments,
    reason = "what the hot loop has in registers, as it is"
)]
fn cover_exactly<S: Lanes>(
    simd: S,
    tile: &mut Tile,
    z: &[f32; 16],
    candidates: u32,
    sure: u32,
    unit: usize,
    job: &Job<'_>,
    vertices: &VertexScratch,
    triangle: usize,
) -> bool {
    let at = TABLES.unit(unit, lanes::<S>());
    let id = job.id(triangle);
    let mut won = false;
    let mut left = candidates;
    while left != 0 {
        let lane = left.trailing_zeros() as usize & 15;
        left &= left - 1;
        // Where many triangles lie in one plane nearly all end here.
        if !tile.would_keep(at + lane, z[lane], id, job.file_ids) {
            continue;
        }
        let covered = sure >> lane & 1 != 0 || {
            let ray = PixelRay {
                x: (unit % BLOCKS * 4 + lane % 4) as f32 - HALF,
                y: (unit / BLOCKS + lane / 4) as f32 - HALF,
            };
            let corners = corners_of(simd, job.leaf, triangle, vertices);
            exact::hits(&corners, ray)
        };
        if covered {
            tile.z[at + lane] = z[lane];
            tile.id[at + lane] = id;
            won = true;
        }
    }
    won
}
