//! From edge functions to pixels, three ways by a triangle's size on screen.

use super::coverage::{
    Broadcast, Candidate, DEPTH, EXTENT, HIGH, Job, LOW, LOW_PIXEL, MOST_PAIRS, Place, SURE,
    Scratch, Setup, cover, cover_unit, min3, rows_of_unit,
};
use super::doubt;
use super::space::{HALF, ROUNDOFF, TILE};
use super::tile::{BLOCKS, FLOORS, TABLES, Tile};
use super::vec3s::{Vec3s, add, sub};
use crate::simd::{
    LANE_NUMBERS, Lanes, SimdBase, SimdFloat, SimdMask, all_lanes, bits, lanes, load, store,
};

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
/// pixel; then one loop goes over the hits of all. `specks`: lanes of the leaf's triangles from number `first` on.
#[inline(always)]
pub fn specks<S: Lanes>(
    simd: S,
    job: &Job<'_>,
    first: usize,
    specks: u32,
    scratch: &mut Scratch,
    tile: &mut Tile,
) -> u64 {
    macro_rules! splat {
        ($x:expr) => {
            S::f32s::splat(simd, $x)
        };
    }
    macro_rules! row {
        ($i:expr) => {
            load(simd, &scratch.setup.0[$i], first)
        };
    }
    macro_rules! rows {
        ($i:expr) => {
            [row!($i), row!($i + 1), row!($i + 2)]
        };
    }
    let edges: [Vec3s<S>; 3] = [rows!(0), rows!(3), rows!(6)];
    let depth = rows!(DEPTH);
    let (z_low, z_high, sure) = (row!(LOW), row!(HIGH), row!(SURE));
    let low = [row!(LOW_PIXEL), row!(LOW_PIXEL + 1)];
    let extent = [row!(EXTENT), row!(EXTENT + 1)];
    let x0 = low[0] - splat!(HALF);
    let y0 = low[1] - splat!(HALF);
    let grid = Grid::<SPECK, SPECK>::around(simd, specks, extent);
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
        let inside = min3::<S>([at!(edges[0]), at!(edges[1]), at!(edges[2])]);
        let maybe = bits::<S>(inside.simd_ge(0.0)) & grid.lanes(step);
        doubts |= maybe & !bits::<S>(inside.simd_ge(sure));
        store::<S>(at!(depth).max(z_low).min(z_high), z, 0);
        let bit = step * lanes::<S>();
        hits[bit / 64] |= u64::from(maybe) << (bit % 64);
    }
    let mut columns = [0i32; 16];
    let mut rows = [0i32; 16];
    let (c, r): (S::i32s, S::i32s) = (low[0].to_int(), low[1].to_int());
    c.store_slice(&mut columns[..lanes::<S>()]);
    r.store_slice(&mut rows[..lanes::<S>()]);
    if doubts != 0 {
        let place = |step: usize, lane: usize| {
            let x = columns[lane] as usize + usize::from(steps.column[step]);
            let y = rows[lane] as usize + usize::from(steps.row[step]);
            (x, y)
        };
        doubt::settle(
            simd,
            job,
            first,
            doubts,
            &mut hits,
            place,
            &scratch.vertices,
        );
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
            let id = job.id(first + lane);
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

/// Small triangles, the bits of `small`: which units they may meet is found for as many at once as there are lanes; then
/// one loop goes over all pairs of unit and triangle, whose end is easier to predict than that of a loop for each.
#[inline(always)]
pub fn small_triangles<S: Lanes>(
    simd: S,
    job: &Job<'_>,
    small: u32,
    scratch: &mut Scratch,
    tile: &mut Tile,
) -> u64 {
    let mut count = 0;
    let mut first = 0;
    while first < 16 {
        let here = small >> first & all_lanes::<S>();
        if here != 0 {
            count = list_pairs(simd, job, first, here, scratch, &tile.floor, count);
        }
        first += lanes::<S>();
    }
    let mut dirty = 0u64;
    let mut winners = 0;
    macro_rules! pair {
        ($i:expr) => {{
            let pair = scratch.pairs[$i % MOST_PAIRS] as usize;
            (pair % 16, Place::of_unit(simd, pair / 16))
        }};
    }
    // The place of the next one is looked up while this one is computed: what it needs is then there.
    let mut next = pair!(0usize);
    for i in 1..=count {
        let (lane, place) = next;
        next = pair!(i);
        let who = Candidate {
            job,
            vertices: &scratch.vertices,
            lane,
        };
        let k = Broadcast::new(simd, &scratch.setup, lane);
        let won = cover_unit::<S, false>(simd, tile, &k, &place, who);
        dirty |= u64::from(won) << (place.at >> 6);
        winners += u32::from(won);
    }
    scratch.won += winners;
    scratch.lost += count as u32 - winners;
    dirty
}

/// Adds to the pairs, `count` so far, those of as many triangles as there are lanes, from number `first` on: the bits of
/// `small`, each with the units in its box that it may meet. Those units are left out, where much is hidden, whose block
/// holds nothing but what is nearer. How many pairs there are then.
#[inline(always)]
fn list_pairs<S: Lanes>(
    simd: S,
    job: &Job<'_>,
    first: usize,
    small: u32,
    scratch: &mut Scratch,
    floor: &[f32; FLOORS],
    mut count: usize,
) -> usize {
    let Scratch { setup, pairs, .. } = scratch;
    macro_rules! splat {
        ($x:expr) => {
            S::f32s::splat(simd, $x)
        };
    }
    macro_rules! row {
        ($i:expr) => {
            load(simd, &setup.0[$i], first)
        };
    }
    macro_rules! number {
        ($n:expr) => {
            S::u32s::splat(simd, $n as u32)
        };
    }
    let (low, wide) = units(
        simd,
        [row!(LOW_PIXEL), row!(LOW_PIXEL + 1)],
        [row!(EXTENT), row!(EXTENT + 1)],
    );
    // Column of blocks, row of pixels: whole numbers far below 2^24.
    let unit = low[0] + low[1] * splat!((rows_of_unit::<S>() * BLOCKS) as f32);
    let mut unit: S::u32s = unit.to_int();
    let lane = S::u32s::from_slice(simd, &LANE_NUMBERS[first..first + lanes::<S>()]);

    let rows = rows_of_unit::<S>() as f32;
    let x = low[0] * splat!(4.0) - splat!(HALF - 1.5);
    let y = low[1] * splat!(rows) - splat!(HALF - (rows - 1.0) / 2.0);
    // A unit's pixels around its centre, and a little for rounding.
    let (across, along) = (splat!(1.51), splat!((rows - 1.0) / 2.0 + 0.01));
    let mut start = [splat!(0.0); 3];
    let mut right = start;
    let mut down = start;
    for i in 0..3 {
        let (u, v, w) = (row!(3 * i), row!(3 * i + 1), row!(3 * i + 2));
        let reach = u.abs() * across + v.abs() * along;
        start[i] = (u * x + (v * y + w)) + reach;
        right[i] = u * splat!(4.0);
        down[i] = v * splat!(rows);
    }
    // The sums below are rounded more often than those of a pixel: allow for as much error again.
    let lowest = splat!(0.0) - row!(SURE);

    // The most that 1/w can be above its value at a unit's centre, rounding included.
    let (z_low, z_high) = (row!(LOW), row!(HIGH));
    let mut z_start = splat!(0.0);
    let (mut z_right, mut z_down) = (z_start, z_start);
    if job.overdrawn {
        let (u, v, w) = (row!(DEPTH), row!(DEPTH + 1), row!(DEPTH + 2));
        let terms = (u.abs() + v.abs()) * splat!(TILE as f32) + w.abs();
        let reach = u.abs() * across + (v.abs() * along + terms * splat!(32.0 * ROUNDOFF));
        z_start = (u * x + (v * y + w)) + reach;
        z_right = u * splat!(4.0);
        z_down = v * splat!(rows);
    }

    let small = S::mask32s::from_bitmask(simd, u64::from(small));
    let mut in_columns = [small; SMALL_COLUMNS];
    let mut columns = 1;
    for (column, lanes) in in_columns.iter_mut().enumerate().skip(1) {
        *lanes &= wide[0].simd_ge(splat!(column as f32));
        columns += usize::from(lanes.any_true());
    }
    for row in 0..small_rows::<S>() {
        let below = splat!(row as f32);
        let in_row = wide[1].simd_ge(below);
        if !(in_row & small).any_true() {
            break;
        }
        let mut at = [
            start[0] + down[0] * below,
            start[1] + down[1] * below,
            start[2] + down[2] * below,
        ];
        let mut floors = [splat!(0.0); SMALL_COLUMNS];
        if job.overdrawn {
            let block =
                ((unit >> 2) & number!(BLOCKS * (BLOCKS - 1))) | (unit & number!(BLOCKS - 1));
            floors = simd.runs4(floor, block);
        }
        let mut z = z_start + z_down * below;
        let mut pair = (unit << 4) | lane;
        for column in 0..columns {
            let mut met = min3::<S>(at).simd_ge(lowest) & in_row & in_columns[column];
            if job.overdrawn {
                met &= z.max(z_low).min(z_high).simd_ge(floors[column]);
                z += z_right;
            }
            // Full only after the very last place: no pair is ever written over.
            let end = count % MOST_PAIRS;
            pair.compress(met)
                .store_slice(&mut pairs[end..end + lanes::<S>()]);
            count += bits::<S>(met).count_ones() as usize;
            at = add::<S>(at, right);
            pair += number!(16);
        }
        unit += number!(rows_of_unit::<S>() * BLOCKS);
    }
    count
}

/// Boxes of pixels (first column and row, and how many follow) as boxes of units, in columns of 4 pixels and rows of
/// units.
#[inline(always)]
pub fn units<S: Lanes>(
    simd: S,
    low: [S::f32s; 2],
    extent: [S::f32s; 2],
) -> ([S::f32s; 2], [S::f32s; 2]) {
    let column = S::f32s::splat(simd, 0.25);
    let row = S::f32s::splat(simd, 1.0 / rows_of_unit::<S>() as f32);
    let high = [low[0] + extent[0], low[1] + extent[1]];
    let first = [(low[0] * column).floor(), (low[1] * row).floor()];
    let last = [(high[0] * column).floor(), (high[1] * row).floor()];
    (first, [last[0] - first[0], last[1] - first[1]])
}

/// The first of the `large` triangles that covers the whole tile.
#[cold]
#[inline(never)]
pub fn first_whole<S: Lanes>(simd: S, setup: &Setup, large: u32) -> Option<usize> {
    simd.vectorize(
        #[inline(always)]
        || first_whole_on(simd, setup, large),
    )
}

#[inline(always)]
fn first_whole_on<S: Lanes>(simd: S, setup: &Setup, large: u32) -> Option<usize> {
    macro_rules! row {
        ($i:expr, $first:expr) => {
            load(simd, &setup.0[$i], $first)
        };
    }
    // From the tile's middle to its outermost pixels, and a little for rounding.
    let across = S::f32s::splat(simd, HALF + 0.01);
    for first in (0..16).step_by(lanes::<S>()) {
        macro_rules! least {
            ($edge:expr) => {
                row!($edge + 2, first)
                    - (row!($edge, first).abs() + row!($edge + 1, first).abs()) * across
            };
        }
        let sure = row!(SURE, first);
        let covers = min3::<S>([least!(0), least!(3), least!(6)]).simd_ge(sure + sure);
        let covers = bits::<S>(covers & row!(LOW, first).simd_gt(0.0)) & (large >> first);
        if covers != 0 {
            return Some(first + covers.trailing_zeros() as usize);
        }
    }
    None
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
    let pixel = |row: usize| scratch.setup.0[row][lane & 15] as i32 as usize;
    let block = |pixel: usize| pixel / 4 % BLOCKS;
    let (x0, y0) = (pixel(LOW_PIXEL), pixel(LOW_PIXEL + 1));
    let (x1, y1) = (block(x0 + pixel(EXTENT)), block(y0 + pixel(EXTENT + 1)));
    let (x0, y0) = (block(x0), block(y0));
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
    if tile.whole.is_some() && full != part {
        // Where they are the same, both are empty.
        tile.write_out(simd);
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
