//! The hits of one tile while it is being traced, and where each pixel of it lies in memory.

use super::space::{HALF, TILE};
use crate::frame::MISS;
use crate::simd::{Lanes, SimdBase, f32x4, lanes, load, store, transpose4};

/// Blocks of 4x4 pixels in a row of a tile.
pub const BLOCKS: usize = TILE / 4;

/// Pixels of a tile.
pub const PIXELS: usize = TILE * TILE;

/// One for each block, and some more so that 16 can be read from any.
pub const FLOORS: usize = BLOCKS * BLOCKS + 16;

/// The nearest hit so far of every pixel of a tile.
///
/// In memory the sixteen pixels of a 4x4 block are neighbours, and so are the four blocks of an 8x8 block: a block
/// is one load of 16 lanes, two of 8 or four of 4, and an 8x8 block is 64 numbers in a row.
#[repr(C, align(64))]
#[derive(Clone, Debug)]
pub struct Tile {
    /// 1/w of the nearest hit, 0 for none yet.
    pub z: [f32; PIXELS],
    /// Its triangle in leaf order, [`MISS`] for none yet.
    pub id: [u32; PIXELS],
    /// Triangle and node tests of each 4x4 block, row by row; kept only for the view `cost`.
    pub cost: [u32; BLOCKS * BLOCKS],
    /// At most the smallest `z` of each 4x4 block, row by row: what stays below it is hidden.
    pub floor: [f32; FLOORS],
    /// The 8x8 blocks that may hold a hit, as bits, row by row: all others are as cleared.
    pub touched: u64,
    /// The triangle that all of the picture's pixels in this tile show, while it is not written into `z` and `id`: it is
    /// before [`Tile::write_out`].
    pub whole: Option<Whole>,
}

/// A triangle that covers all of the picture's pixels in a tile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Whole {
    /// In leaf order.
    pub id: u32,
    /// 1/w at a pixel is u·x′ + (v·y′ + w), not below `low` and not above `high`.
    pub depth: [f32; 3],
    /// Above zero.
    pub low: f32,
    /// At least `low`.
    pub high: f32,
    /// The last column and row of 4x4 blocks.
    pub last: [usize; 2],
}

impl Whole {
    /// 1/w at some pixels.
    #[inline(always)]
    fn depth_at<S: Lanes>(&self, simd: S, x: S::f32s, y: S::f32s) -> S::f32s {
        macro_rules! splat {
            ($x:expr) => {
                S::f32s::splat(simd, $x)
            };
        }
        let [u, v, w] = self.depth;
        let z = splat!(u) * x + (splat!(v) * y + splat!(w));
        z.max(splat!(self.low)).min(splat!(self.high))
    }
}

impl Tile {
    /// All misses.
    #[must_use]
    pub fn new() -> Box<Tile> {
        Box::new(Tile {
            z: [0.0; PIXELS],
            id: [MISS; PIXELS],
            cost: [0; BLOCKS * BLOCKS],
            floor: [0.0; FLOORS],
            touched: 0,
            whole: None,
        })
    }

    /// All misses again: tiles are mostly background, so only what was touched is written.
    #[inline(always)]
    pub fn clear(&mut self) {
        if self.touched != 0 {
            self.floor.fill(0.0);
        }
        if self.whole.take().is_some() {
            // It was not written, and nothing else was.
            self.touched = 0;
        }
        while self.touched != 0 {
            let at = self.touched.trailing_zeros() as usize * 64;
            self.touched &= self.touched - 1;
            self.z[at..at + 64].fill(0.0);
            self.id[at..at + 64].fill(MISS);
        }
    }

    /// Takes `whole`, the first triangle of a tile, whose pixels need not be written unless another one is seen.
    #[cold]
    #[inline(never)]
    pub fn take_whole<S: Lanes>(&mut self, simd: S, whole: Whole) {
        simd.vectorize(
            #[inline(always)]
            || self.take_whole_on(simd, whole),
        );
    }

    #[inline(always)]
    fn take_whole_on<S: Lanes>(&mut self, simd: S, whole: Whole) {
        // Rounded sums grow with x′ and y′ as exact ones do: 1/w is least at one corner of each block.
        let [across, down] = [0, 1].map(|k| if whole.depth[k] > 0.0 { -1.5 } else { 1.5 });
        for by in 0..=whole.last[1] {
            let y = S::f32s::splat(simd, TABLES.centre[by] + down);
            for bx in (0..BLOCKS).step_by(lanes::<S>()) {
                let x = load(simd, &TABLES.centre, bx) + S::f32s::splat(simd, across);
                let least = whole.depth_at(simd, x, y);
                store::<S>(least, &mut self.floor, by * BLOCKS + bx);
            }
            // Outside of the picture nothing is held.
            self.floor[by * BLOCKS + whole.last[0] + 1..(by + 1) * BLOCKS].fill(0.0);
        }
        self.whole = Some(whole);
    }

    /// Writes the hits of [`Tile::whole`], if there is one, to the pixels.
    #[inline(always)]
    pub fn write_out<S: Lanes>(&mut self, simd: S) {
        if let Some(whole) = self.whole.take() {
            self.write(simd, whole);
        }
    }

    #[cold]
    #[inline(never)]
    fn write<S: Lanes>(&mut self, simd: S, whole: Whole) {
        simd.vectorize(
            #[inline(always)]
            || self.write_on(simd, whole),
        );
    }

    #[inline(always)]
    fn write_on<S: Lanes>(&mut self, simd: S, whole: Whole) {
        let id = S::u32s::splat(simd, whole.id);
        for by in 0..=whole.last[1] {
            for bx in 0..=whole.last[0] {
                let block = TABLES.block(bx, by);
                let mut first = 0;
                while first < 16 {
                    let x = load(simd, &TABLES.x[bx], first);
                    let y = load(simd, &TABLES.y[by], first);
                    let at = block + first;
                    store::<S>(whole.depth_at(simd, x, y), &mut self.z, at);
                    id.store_slice(&mut self.id[at..at + lanes::<S>()]);
                    first += lanes::<S>();
                }
            }
        }
    }

    /// Brings [`Tile::floor`] up to date for an 8x8 block; the smallest `z` in it.
    #[inline(always)]
    pub fn renew_floor<S: Lanes>(&mut self, simd: S, block: usize) -> f32 {
        if self.whole.is_some() {
            // They are up to date, and `z` is not.
            let at = (block / 8 * 2 * BLOCKS + block % 8 * 2) & (BLOCKS * BLOCKS - 1);
            let below = (at + BLOCKS) & (BLOCKS * BLOCKS - 1);
            let (above, below) = (&self.floor[at..at + 2], &self.floor[below..below + 2]);
            return (above[0].min(above[1])).min(below[0].min(below[1]));
        }
        let z = &self.z[block * 64..block * 64 + 64];
        macro_rules! row {
            ($i:expr) => {
                f32x4::from_slice(simd, &z[4 * $i..4 * $i + 4])
            };
        }
        macro_rules! lowest {
            ($i:expr) => {
                (row!($i).min(row!($i + 1))).min(row!($i + 2).min(row!($i + 3)))
            };
        }
        let [a, b, c, d] = transpose4([lowest!(0), lowest!(4), lowest!(8), lowest!(12)]);
        let floors = a.min(b).min(c.min(d));
        let at = (block / 8 * 2 * BLOCKS + block % 8 * 2) & (BLOCKS * BLOCKS - 1);
        self.floor[at] = floors[0];
        self.floor[at + 1] = floors[1];
        self.floor[(at + BLOCKS) & (BLOCKS * BLOCKS - 1)] = floors[2];
        self.floor[(at + BLOCKS + 1) & (BLOCKS * BLOCKS - 1)] = floors[3];
        floors.reduce_min()
    }

    /// The 8x8 blocks of the row of 4x4 blocks `by` that may hold a hit, leftmost lowest.
    #[inline(always)]
    #[must_use]
    pub fn touched_in_row(&self, by: usize) -> u32 {
        (self.touched >> (by / 2 * 8) & 255) as u32
    }

    /// True for a hit nearer than what the pixel holds, or as near and lower in the file.
    #[inline(always)]
    #[must_use]
    pub fn would_keep(&self, at: usize, z: f32, id: u32, file_ids: &[u32]) -> bool {
        let old = self.z[at];
        z > old || (z == old && file_ids[id as usize] < file_ids[self.id[at] as usize])
    }

    /// Keeps the hit if it is nearer than what the pixel holds, or as near and lower in the file.
    #[inline(always)]
    pub fn keep_nearer(&mut self, at: usize, z: f32, id: u32, file_ids: &[u32]) -> bool {
        let wins = self.would_keep(at, z, id, file_ids);
        if wins {
            self.z[at] = z;
            self.id[at] = id;
        }
        wins
    }
}

/// Where the 4x4 block in column `bx` and row `by` of blocks starts in memory.
#[inline(always)]
#[must_use]
pub const fn block_offset(bx: usize, by: usize) -> usize {
    ((by / 2) * (BLOCKS / 2) + bx / 2) * 64 + ((by & 1) * 2 + (bx & 1)) * 16
}

/// Where the pixel in column `x` and row `y` of the tile lies in memory.
#[inline(always)]
#[must_use]
pub const fn pixel_offset(x: usize, y: usize) -> usize {
    block_offset(x / 4, y / 4) + (y % 4) * 4 + x % 4
}

/// Tables that kernels load lanes from.
#[repr(C, align(64))]
#[derive(Debug)]
pub struct Tables {
    /// x′ of the pixels of a 4x4 block, by its column of blocks.
    pub x: [[f32; 16]; BLOCKS],
    /// y′, by its row of blocks.
    pub y: [[f32; 16]; BLOCKS],
    /// [`pixel_offset`] of every fourth pixel, row by row: where a unit starts that has its first pixel there.
    unit: [u16; TILE * BLOCKS],
    /// x′ of the centre of each column of blocks, or y′ of each row; some more, so that 16 can be read from any.
    pub centre: [f32; BLOCKS + 16],
    /// [`block_offset`] of each block, row by row.
    pub offset: [u16; BLOCKS * BLOCKS],
    /// [`pixel_offset`] is the sum of one for the column and one for the row.
    column: [u16; TILE],
    row: [u16; TILE],
}

/// The tables of the one tile size there is.
pub static TABLES: Tables = Tables::new();

impl Tables {
    /// [`block_offset`], looked up; `bx` and `by` are taken modulo the number of blocks in a row.
    #[inline(always)]
    #[must_use]
    pub fn block(&self, bx: usize, by: usize) -> usize {
        usize::from(self.offset[by % BLOCKS * BLOCKS + bx % BLOCKS]) & 0xff0
    }

    /// [`pixel_offset`], looked up; `x` and `y` are taken modulo the tile's size.
    #[inline(always)]
    #[must_use]
    pub fn pixel(&self, x: usize, y: usize) -> usize {
        usize::from(self.column[x & (TILE - 1)] | self.row[y & (TILE - 1)]) & (PIXELS - 1)
    }

    /// Where the unit `lanes` wide starts that has its first pixel in column `4 * (unit % 16)` and row `unit / 16`
    /// of the tile.
    #[inline(always)]
    #[must_use]
    pub fn unit(&self, unit: usize, lanes: usize) -> usize {
        usize::from(self.unit[unit & (TILE * BLOCKS - 1)]) & (PIXELS - lanes)
    }

    const fn new() -> Tables {
        let mut t = Tables {
            x: [[0.0; 16]; BLOCKS],
            y: [[0.0; 16]; BLOCKS],
            unit: [0; TILE * BLOCKS],
            centre: [0.0; BLOCKS + 16],
            offset: [0; BLOCKS * BLOCKS],
            column: [0; TILE],
            row: [0; TILE],
        };
        let mut i = 0;
        while i < TILE {
            t.column[i] = pixel_offset(i, 0) as u16;
            t.row[i] = pixel_offset(0, i) as u16;
            i += 1;
        }
        let mut b = 0;
        while b < BLOCKS {
            let mut lane = 0;
            while lane < 16 {
                t.x[b][lane] = (b * 4 + lane % 4) as f32 - HALF;
                t.y[b][lane] = (b * 4 + lane / 4) as f32 - HALF;
                lane += 1;
            }
            b += 1;
        }
        let mut i = 0;
        while i < TILE * BLOCKS {
            t.unit[i] = pixel_offset(i % BLOCKS * 4, i / BLOCKS) as u16;
            i += 1;
        }
        let mut i = 0;
        while i < BLOCKS * BLOCKS {
            let (bx, by) = (i % BLOCKS, i / BLOCKS);
            t.offset[i] = block_offset(bx, by) as u16;
            i += 1;
        }
        let mut i = 0;
        while i < BLOCKS + 16 {
            t.centre[i] = (i * 4) as f32 + 1.5 - HALF;
            i += 1;
        }
        t
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_has_a_place_of_its_own() {
        let mut seen = [false; PIXELS];
        for y in 0..TILE {
            for x in 0..TILE {
                assert!(!std::mem::replace(&mut seen[pixel_offset(x, y)], true));
                let (block, lane) = (pixel_offset(x, y) / 16 * 16, pixel_offset(x, y) % 16);
                assert_eq!(block, block_offset(x / 4, y / 4));
                assert_eq!(TABLES.pixel(x, y), pixel_offset(x, y));
                assert_eq!(TABLES.x[x / 4][lane], x as f32 - HALF);
                assert_eq!(TABLES.y[y / 4][lane], y as f32 - HALF);
            }
        }
    }
}
