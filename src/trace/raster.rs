//! From edge functions to pixels, three ways by a triangle's size on screen.

use super::coverage::{
    Broadcast, Candidate, DEPTH, HIGH, Job, LOW, SURE, Scratch, Setup, cover, cover_unit, min3,
    rows_of_unit,
};
use super::doubt;
use super::space::{HALF, ROUNDOFF, TILE};
use super::tile::{BLOCKS, FLOORS, TABLES, Tile};
use super::vec3s::{Vec3s, add, sub};
use crate::simd::{Lanes, SimdBase, SimdFloat, bits, lanes, load, store};

/// Lanes for [`specks`].
pub struct SpeckLanes<S: Lanes> {
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

/// A triangle whose box holds at most this many columns and rows of pixels' centres is a speck.
pub const SPECK: usize = 4;

/// Most places of a [`Grid`]: 4 columns and 16 rows.
const PLACES: usize = 64;

/// The places of a grid of some width, row by row.
struct Steps {
    /// Columns and rows from the first, as numbers to compute with.
    x: [f32; PLACES],
    y: [f32; PLACES],
    /// The same, to count with.
    column: [u8; PLACES],
    row: [u8; PLACES],
}

/// By width, from one column on.
static STEPS: [Steps; 4] = [Steps::new(1), Steps::new(2), Steps::new(3), Steps::new(4)];

impl Steps {
    const fn new(columns: usize) -> Steps {
        let mut steps = Steps {
            x: [0.0; PLACES],
            y: [0.0; PLACES],
            column: [0; PLACES],
            row: [0; PLACES],
        };
        let mut i = 0;
        while i < PLACES {
            steps.column[i] = (i % columns) as u8;
            steps.row[i] = (i / columns) as u8;
            steps.x[i] = steps.column[i] as f32;
            steps.y[i] = steps.row[i] as f32;
            i += 1;
        }
        steps
    }
}

/// Which part of `COLUMNS` times `ROWS` places the boxes of some lanes take, each counted from its own first place.
/// One loop over all of them ends once: loops over rows and columns would end unpredictably row by row.
struct Grid<const COLUMNS: usize, const ROWS: usize> {
    /// Lanes that reach each column.
    columns: [u32; COLUMNS],
    /// Lanes that reach each row.
    rows: [u32; ROWS],
    /// Columns that a lane reaches.
    width: usize,
    /// Rows.
    height: usize,
}

impl<const COLUMNS: usize, const ROWS: usize> Grid<COLUMNS, ROWS> {
    /// `extent`: columns and rows of each lane's box, less one.
    #[inline(always)]
    fn around<S: Lanes>(simd: S, lanes: u32, extent: [S::f32s; 2]) -> Self {
        let mut grid = Grid {
            columns: [lanes; COLUMNS],
            rows: [lanes; ROWS],
            width: 1,
            height: 1,
        };
        macro_rules! reach {
            ($i:expr, $n:expr) => {
                bits::<S>(extent[$i].simd_ge(S::f32s::splat(simd, $n as f32))) & lanes
            };
        }
        for n in 1..COLUMNS {
            grid.columns[n] = reach!(0, n);
            grid.width += usize::from(grid.columns[n] != 0);
        }
        for n in 1..ROWS {
            grid.rows[n] = reach!(1, n);
            grid.height += usize::from(grid.rows[n] != 0);
        }
        grid
    }

    /// How many places there are.
    #[inline(always)]
    fn len(&self) -> usize {
        (self.width * self.height).min(COLUMNS * ROWS)
    }

    /// Where they are.
    #[inline(always)]
    fn steps(&self) -> &'static Steps {
        &STEPS[(self.width - 1) & 3]
    }

    /// The lanes whose box has place `step`.
    #[inline(always)]
    fn lanes(&self, step: usize) -> u32 {
        let steps = self.steps();
        let (column, row) = (steps.column[step], steps.row[step]);
        self.columns[usize::from(column) % COLUMNS] & self.rows[usize::from(row) % ROWS]
    }
}

/// Words that have a bit for each pixel of each lane's box, where there are 16 lanes.
const WORDS: usize = SPECK * SPECK * 16 / 64;

/// Triangles of at most [`SPECK`] pixels each way: lanes stay triangles. Their boxes are walked in step, pixel by
/// pixel; then one loop goes over the hits of all.
#[inline(always)]
pub fn specks<S: Lanes>(
    simd: S,
    job: &Job<'_>,
    k: &SpeckLanes<S>,
    specks: u32,
    scratch: &mut Scratch,
    tile: &mut Tile,
) -> u64 {
    macro_rules! splat {
        ($x:expr) => {
            S::f32s::splat(simd, $x)
        };
    }
    let x0 = k.low[0] - splat!(HALF);
    let y0 = k.low[1] - splat!(HALF);
    let grid = Grid::<SPECK, SPECK>::around(simd, specks, k.extent);
    let steps = grid.steps();
    // Kept from call to call: to clear it would take as long as filling it.
    let z = &mut scratch.speck_depths;
    // Bit lanes * step + lane.
    let mut hits = [0u64; WORDS];
    let mut doubts = 0;
    for (step, z) in z.iter_mut().enumerate().take(grid.len()) {
        let (x, y) = (x0 + splat!(steps.x[step]), y0 + splat!(steps.y[step]));
        macro_rules! at {
            ($k:expr) => {
                $k[0] * x + ($k[1] * y + $k[2])
            };
        }
        let inside = min3::<S>([at!(k.edges[0]), at!(k.edges[1]), at!(k.edges[2])]);
        let maybe = bits::<S>(inside.simd_ge(0.0)) & grid.lanes(step);
        doubts |= maybe & !bits::<S>(inside.simd_ge(k.sure));
        store::<S>(at!(k.depth).max(k.z_low).min(k.z_high), z, 0);
        let bit = step * lanes::<S>();
        hits[bit / 64] |= u64::from(maybe) << (bit % 64);
    }
    let mut columns = [0i32; 16];
    let mut rows = [0i32; 16];
    let (c, r): (S::i32s, S::i32s) = (k.low[0].to_int(), k.low[1].to_int());
    c.store_slice(&mut columns[..lanes::<S>()]);
    r.store_slice(&mut rows[..lanes::<S>()]);
    if doubts != 0 {
        let place = |step: usize, lane: usize| {
            let x = columns[lane] as usize + usize::from(steps.column[step]);
            let y = rows[lane] as usize + usize::from(steps.row[step]);
            (x, y)
        };
        doubt::settle(simd, job, doubts, &mut hits, place, &scratch.vertices);
    }
    let mut dirty = 0u64;
    for (word, hits) in hits[..WORDS * lanes::<S>() / 16].iter().enumerate() {
        let mut left = *hits;
        while left != 0 {
            let p = left.trailing_zeros() as usize;
            left &= left - 1;
            let lane = p % lanes::<S>();
            let step = (word * 64 + p) / lanes::<S>();
            let x = columns[lane] as usize + usize::from(steps.column[step]);
            let y = rows[lane] as usize + usize::from(steps.row[step]);
            let at = TABLES.pixel(x, y);
            let id = job.id(lane);
            // Positive numbers: their bits are in the same order, and whole numbers are compared without a branch.
            let (z, old) = (z[step][lane].to_bits(), tile.z[at].to_bits());
            if z == old {
                let z = f32::from_bits(z);
                dirty |= u64::from(tile.keep_nearer(at, z, id, job.file_ids)) << (at >> 6);
                continue;
            }
            let loses = u32::from(z > old).wrapping_sub(1);
            tile.z[at] = f32::from_bits(z.max(old));
            tile.id[at] = id ^ ((id ^ tile.id[at]) & loses);
            dirty |= u64::from(!loses & 1) << (at >> 6);
        }
    }
    dirty
}
/// A triangle of at most this many columns of 4 pixels and rows of [`small_rows`] is small.
pub const SMALL_COLUMNS: usize = 4;

/// See [`SMALL_COLUMNS`]: in rows of units, 16 pixels.
pub const fn small_rows<S: Lanes>() -> usize {
    16 / rows_of_unit::<S>()
}

/// Pairs of a unit and a lane: bit `(4 * row + column) * lanes + lane`, units counted from the lane's first.
type Pairs = [u64; 4];

/// Small triangles: which units each of them may meet is found for all lanes at once; then one loop goes over all
/// pairs of unit and triangle, whose end is easier to predict than that of a loop for each. `low`: first column and
/// row of units of each lane's box; `wide`: its columns and rows less one.
#[inline(always)]
pub fn small_triangles<S: Lanes>(
    simd: S,
    job: &Job<'_>,
    small: u32,
    low: [S::f32s; 2],
    wide: [S::f32s; 2],
    scratch: &mut Scratch,
    tile: &mut Tile,
) -> u64 {
    let mut dirty = 0u64;
    let mut winners = 0;
    let mut pairs = pairs_that_meet(simd, &scratch.setup, small, low, wide);
    if job.overdrawn {
        drop_hidden(simd, scratch, low, &tile.floor, &mut pairs);
    }
    for (word, pairs) in pairs.into_iter().enumerate() {
        let mut left = pairs;
        while left != 0 {
            let pair = left.trailing_zeros() as usize;
            left &= left - 1;
            let lane = pair % lanes::<S>();
            let nth = (word * 64 + pair) / lanes::<S>();
            let down = nth / SMALL_COLUMNS * rows_of_unit::<S>();
            let unit = scratch.first_unit[lane] as usize + down * BLOCKS + nth % SMALL_COLUMNS;
            let who = Candidate {
                job,
                vertices: &scratch.vertices,
                lane,
            };
            let k = Broadcast::new(simd, &scratch.setup, lane);
            let won = cover_unit::<S, false>(simd, tile, &k, unit, who);
            dirty |= u64::from(won) << (TABLES.unit(unit, lanes::<S>()) >> 6);
            winners += u32::from(won);
        }
    }
    let all: u32 = pairs.iter().map(|pairs| pairs.count_ones()).sum();
    scratch.won += winners;
    scratch.lost += all - winners;
    dirty
}

/// The pairs of a unit inside a lane's box and its triangle that may meet.
#[inline(always)]
fn pairs_that_meet<S: Lanes>(
    simd: S,
    setup: &Setup,
    small: u32,
    low: [S::f32s; 2],
    wide: [S::f32s; 2],
) -> Pairs {
    macro_rules! splat {
        ($x:expr) => {
            S::f32s::splat(simd, $x)
        };
    }
    let rows = rows_of_unit::<S>() as f32;
    let x = low[0] * splat!(4.0) - splat!(HALF - 1.5);
    let y = low[1] * splat!(rows) - splat!(HALF - (rows - 1.0) / 2.0);
    let mut start = [splat!(0.0); 3];
    let mut right = start;
    let mut down = start;
    for i in 0..3 {
        macro_rules! row {
            ($j:expr) => {
                load(simd, &setup.0[3 * i + $j], 0)
            };
        }
        let (u, v, w) = (row!(0), row!(1), row!(2));
        // A unit's pixels around its centre, and a little for rounding.
        let reach = u.abs() * splat!(1.51) + v.abs() * splat!((rows - 1.0) / 2.0 + 0.01);
        start[i] = (u * x + (v * y + w)) + reach;
        right[i] = u * splat!(4.0);
        down[i] = v * splat!(rows);
    }
    // The sums below are rounded more often than those of a pixel: allow for as much error again.
    let lowest = splat!(0.0) - load(simd, &setup.0[SURE], 0);
    let mut in_columns = [small; SMALL_COLUMNS];
    for (column, lanes) in in_columns.iter_mut().enumerate().skip(1) {
        *lanes &= bits::<S>(wide[0].simd_ge(splat!(column as f32)));
    }
    let mut pairs = [0; 4];
    for row in 0..small_rows::<S>() {
        let below = splat!(row as f32);
        let in_row = bits::<S>(wide[1].simd_ge(below));
        if in_row & small == 0 {
            break;
        }
        let mut at = [
            start[0] + down[0] * below,
            start[1] + down[1] * below,
            start[2] + down[2] * below,
        ];
        for (column, in_column) in in_columns.iter().enumerate() {
            if *in_column == 0 {
                break;
            }
            let met = bits::<S>(min3::<S>(at).simd_ge(lowest)) & in_row & in_column;
            let bit = (row * SMALL_COLUMNS + column) * lanes::<S>();
            pairs[bit / 64] |= u64::from(met) << (bit % 64);
            at = add::<S>(at, right);
        }
    }
    pairs
}

/// Takes those pairs out whose triangle lies behind all that its unit's block holds. `low`, `pairs`: as in
/// [`pairs_that_meet`].
#[inline(always)]
fn drop_hidden<S: Lanes>(
    simd: S,
    scratch: &Scratch,
    low: [S::f32s; 2],
    floor: &[f32; FLOORS],
    pairs: &mut Pairs,
) {
    macro_rules! splat {
        ($x:expr) => {
            S::f32s::splat(simd, $x)
        };
    }
    macro_rules! row {
        ($i:expr) => {
            load(simd, &scratch.setup.0[$i], 0)
        };
    }
    let rows = rows_of_unit::<S>() as f32;
    let x = low[0] * splat!(4.0) - splat!(HALF - 1.5);
    let y = low[1] * splat!(rows) - splat!(HALF - (rows - 1.0) / 2.0);
    let (u, v, w) = (row!(DEPTH), row!(DEPTH + 1), row!(DEPTH + 2));
    // The most that it can be above its value at a unit's centre, rounding included.
    let terms = (u.abs() + v.abs()) * splat!(TILE as f32) + w.abs();
    let reach = u.abs() * splat!(1.51)
        + (v.abs() * splat!((rows - 1.0) / 2.0 + 0.01) + terms * splat!(32.0 * ROUNDOFF));
    let start = (u * x + (v * y + w)) + reach;
    let (right, down) = (u * splat!(4.0), v * splat!(rows));
    let (z_low, z_high) = (row!(LOW), row!(HIGH));
    let first_unit = S::u32s::from_slice(simd, &scratch.first_unit[..lanes::<S>()]);
    let number = |n: usize| S::u32s::splat(simd, n as u32);
    for row in 0..small_rows::<S>() {
        let bit = row * SMALL_COLUMNS * lanes::<S>();
        // Four columns are 16, 32 or 64 bits of one word.
        if pairs[bit / 64] >> (bit % 64) == 0 {
            continue;
        }
        let unit = first_unit + number(row * rows_of_unit::<S>() * BLOCKS);
        let block = ((unit >> 2) & number(BLOCKS * (BLOCKS - 1))) | (unit & number(BLOCKS - 1));
        let floors = simd.runs4(floor, block);
        let mut z = start + down * splat!(row as f32);
        for (column, floor) in floors.into_iter().enumerate() {
            let hidden = !bits::<S>(z.max(z_low).min(z_high).simd_ge(floor));
            let lanes_of = u32::MAX >> (32 - lanes::<S>());
            let bit = bit + column * lanes::<S>();
            pairs[bit / 64] &= !(u64::from(hidden & lanes_of) << (bit % 64));
            z += right;
        }
    }
}

/// A triangle that is not small.
#[inline(always)]
pub fn large_triangle<S: Lanes>(
    simd: S,
    job: &Job<'_>,
    lane: usize,
    scratch: &Scratch,
    tile: &mut Tile,
) -> u64 {
    let who = Candidate {
        job,
        vertices: &scratch.vertices,
        lane,
    };
    let k = Broadcast::new(simd, &scratch.setup, lane);
    let units_a_block = 16 / lanes::<S>();
    let [x0, x1, y0, y1] = scratch.boxes.map(|row| row[lane] as usize);
    let (x0, x1) = (x0 & (BLOCKS - 1), x1 & (BLOCKS - 1));
    let (y0, y1) = (
        (y0 / units_a_block) & (BLOCKS - 1),
        (y1 / units_a_block) & (BLOCKS - 1),
    );
    let mut dirty = 0u64;
    let reach = k.block_reach(simd);
    let sure = k.sure();
    let (lowest, highest) = (S::f32s::splat(simd, 0.0) - sure, sure + sure);
    // Blocks to look at, and those of them that it covers whole: a bit each, row by row. First all of them are found,
    // as many at a time as there are lanes; then one loop goes over them, whose end is easier to predict than that of
    // one for each vector.
    let (mut part, mut full) = ([0u64; BLOCKS / 4], [0u64; BLOCKS / 4]);
    let (mut bx, mut by) = (x0, y0);
    while by <= y1 {
        let x = load(simd, &TABLES.centre, bx);
        let y = S::f32s::splat(simd, TABLES.centre[by]);
        let e = k.edges_at(x, y);
        let most = min3::<S>(add::<S>(e, reach));
        let least = min3::<S>(sub::<S>(e, reach));
        let inside = u32::MAX >> (31 - (x1 - bx).min(lanes::<S>() - 1));
        let seen = k
            .depth_at(simd, x, y)
            .simd_ge(load(simd, &tile.floor, by * BLOCKS + bx));
        let touched = bits::<S>(most.simd_ge(lowest) & seen) & inside;
        let whole = bits::<S>(least.simd_ge(highest)) & touched;
        let bit = by % 4 * BLOCKS + bx;
        part[by / 4] |= u64::from(touched & !whole) << bit;
        full[by / 4] |= u64::from(whole) << bit;
        bx += lanes::<S>();
        if bx > x1 {
            (bx, by) = (x0, by + 1);
        }
    }
    for (rows, &blocks) in full.iter().enumerate() {
        let mut left = blocks;
        while left != 0 {
            let at = rows * 64 + left.trailing_zeros() as usize;
            left &= left - 1;
            let won = cover::<S, true>(simd, tile, &k, at, who);
            dirty |= u64::from(won) << (TABLES.offset[at & 255] >> 6);
        }
    }
    for (rows, &blocks) in part.iter().enumerate() {
        let mut left = blocks;
        while left != 0 {
            let at = rows * 64 + left.trailing_zeros() as usize;
            left &= left - 1;
            let won = cover::<S, false>(simd, tile, &k, at, who);
            dirty |= u64::from(won) << (TABLES.offset[at & 255] >> 6);
        }
    }
    dirty
}
