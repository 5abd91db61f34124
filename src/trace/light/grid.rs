//! The triangles of a scene sorted into the cells of a grid on the light's plane.

use std::ops::RangeInclusive;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::block::{Block, Cell, LANES, Place, Plane};
use super::frame::{LightFrame, Seen};
use super::open::OpenTriangles;
use crate::raw::prefetch;
use crate::world::World;

/// Cells for each triangle, at most.
const CELLS_PER_TRIANGLE: f64 = 1.0;

/// Entries of cells for each triangle, about, at most. With 6, and twice the cells, 10⁵ triangles are a tenth faster
/// and 10⁶ a third slower, at 300 to 400 bytes a triangle instead of 220 to 260.
const ENTRIES_PER_TRIANGLE: f64 = 4.0;

/// With more triangles around it than this, one is not looked at any further.
const MOST_ABOVE: usize = 4096;

/// A grid over the plane that the light looks at.
#[derive(Debug)]
pub struct LightGrid {
    pub(super) frame: LightFrame,
    pub(super) open: OpenTriangles,
    /// The middle of the first cell.
    x: f64,
    y: f64,
    /// Length of a cell's sides.
    side: f64,
    /// Cells for each unit of length.
    scale: f64,
    columns: usize,
    rows: usize,
    /// The largest column and row.
    last: [f64; 2],
    /// Where each cell's blocks start, row by row; one more for the end.
    starts: Vec<u32>,
    blocks: Vec<Block>,
}

/// Where to look for what hides the light from a point.
#[derive(Clone, Copy, Debug)]
pub struct Query {
    pub place: Place,
    /// The first block.
    pub first: u32,
    /// And the one behind the last.
    pub end: u32,
}

impl Query {
    /// Nowhere.
    pub const NONE: Query = Query {
        place: Place {
            x: 0.0,
            y: 0.0,
            z: 0.0,
        },
        first: 0,
        end: 0,
    };
}

/// The whole number nearest to `x`, which is 0 or more and below 2³²; a cast would cost three times as much. Never
/// falls as x grows: what keeps a point inside the cells of the triangles around it.
#[inline(always)]
fn nearest(x: f64) -> u32 {
    // Where the spacing of numbers is 1.
    (x + 4_503_599_627_370_496.0).to_bits() as u32
}

/// A triangle as the light sees it.
#[derive(Clone, Copy)]
struct Shadow {
    /// Counter-clockwise. (One that is seen nearly edge-on may be so only as `f64` sees it: its edge functions are
    /// then smaller than the error that a block allows for.)
    corners: [Seen; 3],
    id: u32,
}

impl Shadow {
    fn new(corners: [Seen; 3], id: u32) -> Shadow {
        let [a, b, c] = corners;
        let area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        Shadow {
            corners: if area < 0.0 { [a, c, b] } else { corners },
            id,
        }
    }
}

fn range(values: [f64; 3]) -> (f64, f64) {
    let [a, b, c] = values;
    (a.min(b).min(c), a.max(b).max(c))
}

impl LightGrid {
    /// Sorts the triangles of `world`, in parallel on the current rayon pool; the same grid for any number of
    /// threads.
    #[must_use]
    pub fn build(world: &World) -> LightGrid {
        let dir = (-world.light()).as_vec3();
        let frame = LightFrame::new(dir, &world.bvh().bounds);
        let mut grid = LightGrid {
            frame,
            open: OpenTriangles::default(),
            x: 0.0,
            y: 0.0,
            side: 1.0,
            scale: 1.0,
            columns: 0,
            rows: 0,
            last: [-1.0; 2],
            starts: vec![0],
            blocks: Vec::new(),
        };
        if !frame.is_tame() {
            return grid;
        }
        let shadows: Vec<Shadow> = world
            .corners()
            .par_iter()
            .enumerate()
            .map(|(id, corners)| Shadow::new(corners.map(|p| frame.see(p)), id as u32))
            .collect();
        grid.choose_cells(&shadows);
        grid.fill(&shadows);
        grid.open = OpenTriangles::find(&grid, world);
        grid
    }

    /// Bytes in memory.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(&self.starts[..]) + size_of_val(&self.blocks[..]) + self.open.bytes()
    }

    /// Where to look for what hides the light from `origin`; asks for the first block.
    #[inline(always)]
    pub(super) fn query(&self, origin: Vec3) -> Query {
        let seen = self.frame.see(origin);
        let (x, y) = (
            (seen.x - self.x) * self.scale,
            (seen.y - self.y) * self.scale,
        );
        if !(x >= 0.0 && y >= 0.0 && x <= self.last[0] && y <= self.last[1]) {
            return Query::NONE;
        }
        let (column, row) = (nearest(x), nearest(y));
        let [x, y] = self.middle(column, row);
        let cell = self.cell(column, row);
        let &[first, end] = &self.starts[cell..cell + 2] else {
            unreachable!("two were asked for");
        };
        for line in 0..size_of::<Block>() / 64 {
            prefetch(&self.blocks, first as usize, line);
        }
        Query {
            place: Place {
                x: (seen.x - x) as f32,
                y: (seen.y - y) as f32,
                z: seen.z,
            },
            first,
            end,
        }
    }

    /// The blocks of a query, highest first.
    #[inline(always)]
    pub(super) fn blocks(&self, query: &Query) -> &[Block] {
        &self.blocks[query.first as usize..query.end as usize]
    }

    #[inline(always)]
    fn cell(&self, column: u32, row: u32) -> usize {
        row as usize * self.columns + column as usize
    }

    /// The middle of a cell.
    #[inline(always)]
    fn middle(&self, column: u32, row: u32) -> [f64; 2] {
        [
            self.x + f64::from(column) * self.side,
            self.y + f64::from(row) * self.side,
        ]
    }

    /// Square cells, as small as the limits allow.
    fn choose_cells(&mut self, shadows: &[Shadow]) {
        let boxes = |shadow: &Shadow| {
            let (x, y) = (
                range(shadow.corners.map(|p| p.x)),
                range(shadow.corners.map(|p| p.y)),
            );
            [x.0, y.0, x.1, y.1]
        };
        let blur = 2.0 * self.frame.blur;
        let [x0, y0, x1, y1] = shadows.iter().map(boxes).fold(
            [
                f64::INFINITY,
                f64::INFINITY,
                f64::NEG_INFINITY,
                f64::NEG_INFINITY,
            ],
            |a, b| {
                [
                    a[0].min(b[0]),
                    a[1].min(b[1]),
                    a[2].max(b[2]),
                    a[3].max(b[3]),
                ]
            },
        );
        (self.x, self.y) = (x0 - blur, y0 - blur);
        let (width, height) = (x1 - x0 + 2.0 * blur, y1 - y0 + 2.0 * blur);
        let count = shadows.len() as f64;
        let mut side = (width * height / (count * CELLS_PER_TRIANGLE)).sqrt();
        // Long and thin grids; and cells stay far larger than the blur.
        side = side.max(width.max(height) / 4096.0);
        let entries = |side: f64| -> f64 {
            let of_one = |s: &Shadow| {
                let [x0, y0, x1, y1] = boxes(s);
                ((x1 - x0) / side + 1.0) * ((y1 - y0) / side + 1.0)
            };
            // In a fixed order, for the same sum each time.
            shadows.iter().map(of_one).sum()
        };
        while entries(side) > ENTRIES_PER_TRIANGLE * count + 64.0 && side < width.max(height) {
            side *= 1.25;
        }
        (self.side, self.scale) = (side, 1.0 / side);
        let cells = |size: f64| (size / side) as usize + 2;
        (self.columns, self.rows) = (cells(width), cells(height));
        self.last = [self.columns, self.rows].map(|n| (n - 1) as f64);
    }

    /// The columns and rows of the cells that touch a box.
    fn cells_around(
        &self,
        x: (f64, f64),
        y: (f64, f64),
    ) -> (RangeInclusive<u32>, RangeInclusive<u32>) {
        let blur = self.frame.blur;
        let cells = |(low, high): (f64, f64), start: f64, last: f64| {
            let place = |v: f64| nearest(((v - start) * self.scale).clamp(0.0, last));
            place(low - blur)..=place(high + blur)
        };
        (
            cells(x, self.x, self.last[0]),
            cells(y, self.y, self.last[1]),
        )
    }

    /// Puts the numbers in leaf order into `ids` of all triangles that may touch a triangle's box and reach higher
    /// than its lowest corner; corners count from the middle of the scene. False when there are too many.
    pub(super) fn above(&self, corners: &[DVec3; 3], ids: &mut Vec<u32>) -> bool {
        ids.clear();
        // Most that come again are recognised.
        let mut known = [u32::MAX; 64];
        let [a, b, c] = corners.map(|p| p + self.frame.middle());
        let (columns, rows) = self.cells_around(range([a.x, b.x, c.x]), range([a.y, b.y, c.y]));
        let floor = a.z.min(b.z).min(c.z);
        for row in rows {
            for column in columns.clone() {
                let cell = self.cell(column, row);
                let blocks = self.starts[cell] as usize..self.starts[cell + 1] as usize;
                let higher = |block: &&Block| f64::from(block.top()) > floor;
                for block in self.blocks[blocks].iter().take_while(higher) {
                    for &id in block.ids() {
                        let place = &mut known[id as usize % 64];
                        if *place != id {
                            *place = id;
                            ids.push(id);
                        }
                    }
                }
                if ids.len() > MOST_ABOVE {
                    return false;
                }
            }
        }
        true
    }

    /// The cells that a triangle may touch.
    fn cells_of(&self, shadow: &Shadow) -> impl Iterator<Item = [u32; 2]> {
        let (columns, rows) = self.cells_around(
            range(shadow.corners.map(|p| p.x)),
            range(shadow.corners.map(|p| p.y)),
        );
        let outline = (!is_small(&columns, &rows)).then(|| Outline::new(self, shadow));
        let all = columns;
        rows.flat_map(move |y| all.clone().map(move |x| [x, y]))
            .filter(move |&[x, y]| outline.is_none_or(|o| o.touches(x, y)))
    }

    fn fill(&mut self, shadows: &[Shadow]) {
        let mut counts = vec![0u32; self.columns * self.rows];
        for shadow in shadows {
            for [column, row] in self.cells_of(shadow) {
                counts[self.cell(column, row)] += 1;
            }
        }
        self.starts = starts_of(counts.iter().map(|count| count.div_ceil(LANES as u32)));
        let mut firsts = starts_of(counts.iter().copied());
        let total = |starts: &[u32]| starts.last().map_or(0, |&end| end as usize);
        let mut entries = vec![(0.0f32, 0u32); total(&firsts)];
        for (i, shadow) in (0..).zip(shadows) {
            for [column, row] in self.cells_of(shadow) {
                let cell = self.around(column, row);
                let next = &mut firsts[self.cell(column, row)];
                entries[*next as usize] = (Plane::new(&shadow.corners, &cell).top, i);
                *next += 1;
            }
        }
        let mut blocks = vec![Block::EMPTY; total(&self.starts)];
        let (mut entries, mut rest) = (&mut entries[..], &mut blocks[..]);
        let mut rows = Vec::new();
        for (row, counts) in (0..).zip(counts.chunks(self.columns)) {
            let of_row = counts.iter().map(|&count| count as usize).sum();
            let cells = self.cell(0, row)..self.cell(0, row + 1);
            let block_count = self.starts[cells.end] - self.starts[cells.start];
            rows.push((
                row,
                counts,
                entries.split_off_mut(..of_row).unwrap_or_default(),
                rest.split_off_mut(..block_count as usize)
                    .unwrap_or_default(),
            ));
        }
        rows.into_par_iter()
            .for_each(|(row, counts, mut entries, mut blocks)| {
                for (column, &count) in (0..).zip(counts) {
                    let count = count as usize;
                    let cell = self.around(column, row);
                    let entries = entries.split_off_mut(..count).unwrap_or_default();
                    let blocks = blocks
                        .split_off_mut(..count.div_ceil(LANES))
                        .unwrap_or_default();
                    // Highest first.
                    entries.sort_unstable_by(|(a, i), (b, j)| b.total_cmp(a).then(i.cmp(j)));
                    for (at, &(top, i)) in entries.iter().enumerate() {
                        let Shadow { corners, id } = &shadows[i as usize];
                        blocks[at / LANES].put(at % LANES, corners, *id, &cell, top);
                    }
                }
            });
        self.blocks = blocks;
    }

    /// A cell, with room for rounding.
    fn around(&self, column: u32, row: u32) -> Cell {
        let blur = self.frame.blur;
        Cell {
            middle: self.middle(column, row),
            side: self.side + 8.0 * blur,
            blur,
        }
    }
}

/// Where each starts when they follow each other; one more for the end.
fn starts_of(counts: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut end = 0;
    let mut starts: Vec<u32> = counts
        .map(|count| {
            let start = end;
            end += count;
            start
        })
        .collect();
    starts.push(end);
    starts
}

/// True when there is nothing to gain from a look at the outline.
fn is_small(columns: &RangeInclusive<u32>, rows: &RangeInclusive<u32>) -> bool {
    columns.start() == columns.end() || rows.start() == rows.end()
}

/// The edge functions of a triangle over the cells of a grid.
#[derive(Clone, Copy)]
struct Outline {
    /// Change a column, change a row, value at the best corner of the first cell.
    edges: [[f64; 3]; 3],
}

impl Outline {
    fn new(grid: &LightGrid, shadow: &Shadow) -> Outline {
        let side = grid.side;
        let margin = 4.0 * grid.frame.blur;
        let at = |i: usize| {
            let p = shadow.corners[i % 3];
            [p.x - grid.x, p.y - grid.y]
        };
        let edges = [0, 1, 2].map(|i| {
            let (p, q) = (at(i), at(i + 1));
            let (u, v) = (p[1] - q[1], q[0] - p[0]);
            let w = p[0] * q[1] - p[1] * q[0];
            // The corner of a cell, with a margin around it, where the function is largest.
            let best = (u.abs() + v.abs()) * (side * 0.5 + margin);
            [u * side, v * side, w + best]
        });
        Outline { edges }
    }

    fn touches(&self, x: u32, y: u32) -> bool {
        self.edges
            .iter()
            .all(|[u, v, w]| u * f64::from(x) + v * f64::from(y) + w >= 0.0)
    }
}
