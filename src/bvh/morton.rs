//! Triangles along a space-filling curve: Morton codes of their middles, sorted.
//!
//! Neighbours in space are neighbours on the curve, and all triangles of one cell of an octree are one range of it:
//! the coarse tree is those cells, the fine one starts from small ones. Source: Lauterbach et al., "Fast BVH
//! construction on GPUs", 2009.

use glam::Vec3;
use rayon::prelude::*;

use super::radix::{BUCKETS, CODE_BITS, Runs, bucket, merge};
pub(super) use super::radix::{Key, code, number};
use crate::geometry::{Aabb, corner_lanes, have_area_for_sure, is_degenerate};
use crate::raw::{Pages, prefetch};
use crate::scene::Triangle;
use crate::simd::{Kernel, Simd, SimdBase, SimdCvtTruncate, dispatch, f32x8, i32x8};

/// Bits of a code for each axis.
const AXIS_BITS: u32 = CODE_BITS / 3;
/// Triangles that are measured and numbered as one piece.
const PIECE: usize = 1 << 15;
/// To choose the grid, eight triangles in so many are looked at, where there are many.
const SAMPLED: usize = 64;
/// So many triangles are many.
const MANY: usize = 1 << 13;
/// How much larger than the middles of those triangles the grid is, each way, in grids.
const MARGIN: f32 = 1.0 / 64.0;
/// So many triangles ahead of their use their lines are asked for: the processor itself stops at the end of a page.
const AHEAD: usize = 64;
/// So few keys are looked through one by one.
const FEW_KEYS: usize = 64;

/// Boxes that grow, one a lane: x, y and z.
struct BoxLanes<S: Simd> {
    low: [f32x8<S>; 3],
    high: [f32x8<S>; 3],
}

impl<S: Simd> BoxLanes<S> {
    #[inline(always)]
    fn empty(simd: S) -> BoxLanes<S> {
        BoxLanes {
            low: [f32x8::splat(simd, f32::INFINITY); 3],
            high: [f32x8::splat(simd, f32::NEG_INFINITY); 3],
        }
    }

    #[inline(always)]
    fn add(&mut self, low: &[f32x8<S>; 3], high: &[f32x8<S>; 3]) {
        for axis in 0..3 {
            self.low[axis] = self.low[axis].min(low[axis]);
            self.high[axis] = self.high[axis].max(high[axis]);
        }
    }

    /// Around all lanes.
    #[inline(always)]
    fn whole(&self) -> Aabb {
        let [min_x, min_y, min_z] = self.low;
        let [max_x, max_y, max_z] = self.high;
        Aabb {
            min: Vec3::new(min_x.reduce_min(), min_y.reduce_min(), min_z.reduce_min()),
            max: Vec3::new(max_x.reduce_max(), max_y.reduce_max(), max_z.reduce_max()),
        }
    }
}

/// Eight triangles at once.
struct Eight<S: Simd> {
    corners: [[f32x8<S>; 3]; 3],
    /// The boxes around them.
    bounds: BoxLanes<S>,
    /// The middles of the boxes.
    middles: [f32x8<S>; 3],
}

impl<S: Simd> Eight<S> {
    /// Those with `numbers`, at least one and at most eight; the last one stands in for what is missing.
    #[inline(always)]
    fn new(simd: S, triangles: &[Triangle], numbers: &[u32]) -> Eight<S> {
        let last = numbers.len() - 1;
        let mut of_lane = [&triangles[numbers[last] as usize]; 8];
        for (triangle, &number) in of_lane.iter_mut().zip(numbers) {
            *triangle = &triangles[number as usize];
        }
        let a = corner_lanes(simd, &of_lane, 0);
        let b = corner_lanes(simd, &of_lane, 1);
        let c = corner_lanes(simd, &of_lane, 2);
        let mut bounds = BoxLanes { low: a, high: a };
        bounds.add(&b, &b);
        bounds.add(&c, &c);
        let mut middles = a;
        for (middle, (low, high)) in middles
            .iter_mut()
            .zip(bounds.low.into_iter().zip(bounds.high))
        {
            // Half of each bound first: the sum may be beyond the range of f32.
            *middle = low * 0.5 + high * 0.5;
        }
        Eight {
            corners: [a, b, c],
            bounds,
            middles,
        }
    }
}

/// From middles to codes.
#[derive(Clone, Copy, PartialEq)]
struct Grid {
    origin: Vec3,
    /// The same for all axes, so that cells are cubes: half of cells a unit, since it multiplies half differences.
    factor: f32,
}

impl Grid {
    /// Over all `middles`, with `margin` times its size around them.
    fn over(middles: Aabb, margin: f32) -> Grid {
        let half_size = (middles.max * 0.5 - middles.min * 0.5).max_element();
        let half_size = half_size * (1.0 + 2.0 * margin);
        // A little less than the number of cells, so that rounding does not lead beyond the last one.
        let factor = ((1 << AXIS_BITS) as f32 * 0.9999) / half_size;
        Grid {
            origin: middles.min * 0.5 - half_size * margin,
            factor: factor.min(f32::MAX),
        }
    }

    /// Whether it is all around `middles`, and not much larger.
    fn suits(&self, middles: &Aabb) -> bool {
        let (low, high) = (
            middles.min * 0.5 - self.origin,
            middles.max * 0.5 - self.origin,
        );
        let size = (1 << AXIS_BITS) as f32 / self.factor;
        let used = (high - low).max_element();
        low.min_element() >= 0.0 && high.max_element() <= size && used >= size * 0.9
    }

    #[inline(always)]
    fn codes<S: Simd>(self, middles: &[f32x8<S>; 3]) -> [i32; 8] {
        let [x, y, z] = *middles;
        let x = spread(self.cells(x, self.origin.x));
        let y = spread(self.cells(y, self.origin.y));
        let z = spread(self.cells(z, self.origin.z));
        (x << 2 | y << 1 | z).to_array()
    }

    /// Places on one axis, kept to the range whatever rounding does.
    #[inline(always)]
    fn cells<S: Simd>(self, middles: f32x8<S>, origin: f32) -> i32x8<S> {
        let cells = (middles * 0.5 - origin) * self.factor;
        i32x8::truncate_from(cells.min(((1 << AXIS_BITS) - 1) as f32).max(0.0))
    }
}

/// Two zero bits between any two of the lowest ten bits.
#[inline(always)]
fn spread<S: Simd>(x: i32x8<S>) -> i32x8<S> {
    let x = (x | x << 16) & 0x0300_00ff;
    let x = (x | x << 8) & 0x0300_f00f;
    let x = (x | x << 4) & 0x030c_30c3;
    (x | x << 2) & 0x0924_9249
}

/// Keys in the order of their codes, and the box of their triangles.
pub(super) struct Sorted {
    pub(super) keys: Pages<Key>,
    /// Memory that is no longer used.
    pub(super) spare: Pages<Key>,
    pub(super) bounds: Aabb,
    /// Some cells hold so many triangles that there may be copies among them.
    pub(super) crowded: bool,
}

/// All triangles that have an area.
pub(super) fn sort_all(triangles: &[Triangle]) -> Sorted {
    let count = u32::try_from(triangles.len()).expect("triangle numbers are 32 bits wide");
    sort(triangles, count as usize, |place| place as u32)
}

/// The triangles of `keys`, on a grid of their own.
pub(super) fn sort_again(triangles: &[Triangle], keys: &[Key]) -> Sorted {
    sort(triangles, keys.len(), |place| number(keys[place]))
}

fn sort(triangles: &[Triangle], count: usize, number_at: impl Fn(usize) -> u32 + Sync) -> Sorted {
    let source = Source {
        triangles,
        count,
        number_at,
    };
    let kernel = Kernel::best();
    let starts: Vec<usize> = (0..count).step_by(PIECE).collect();
    let (step, margin) = if count < MANY {
        (8, 0.0)
    } else {
        (SAMPLED, MARGIN)
    };
    let middles: Vec<Aabb> = starts
        .par_iter()
        .map(|&start| dispatch!(kernel, simd => source.middles(simd, start, step)))
        .collect();
    let mut grid = Grid::over(middles.into_iter().fold(Aabb::EMPTY, Aabb::join), margin);
    let mut chosen_again = false;
    // What it is used for afterwards takes twice as much.
    let mut room: Pages<Key> = Pages::zeros(count, 2 * count);
    loop {
        let pieces: Vec<Piece> = starts
            .par_iter()
            .zip(room.par_chunks_mut(PIECE))
            .map_init(Vec::new, |unsorted, (&start, room)| {
                dispatch!(kernel, simd => source.piece(simd, start, grid, unsorted, room))
            })
            .collect();
        let around = |of: fn(&Piece) -> Aabb| pieces.iter().map(of).fold(Aabb::EMPTY, Aabb::join);
        // Triangles without an area count for nothing: they must not make cells larger.
        let (middles, bounds) = (around(|piece| piece.middles), around(|piece| piece.bounds));
        if chosen_again || grid.suits(&middles) || bounds.is_empty() {
            let runs: Vec<_> = pieces.into_iter().map(|piece| piece.runs).collect();
            let (keys, crowded) = merge(&runs);
            return Sorted {
                keys,
                spare: room,
                bounds,
                crowded,
            };
        }
        grid = Grid::over(middles, 0.0);
        chosen_again = true;
    }
}

/// Triangles to be sorted.
struct Source<'a, F> {
    triangles: &'a [Triangle],
    count: usize,
    number_at: F,
}

impl<F: Fn(usize) -> u32> Source<'_, F> {
    /// Calls `each` with eight numbers of every `step` of a piece after the other; at its end with fewer.
    #[inline(always)]
    fn eights(&self, start: usize, step: usize, mut each: impl FnMut(&[u32])) {
        let end = self.count.min(start + PIECE);
        for at in (start..end).step_by(step) {
            let mut numbers = [0; 8];
            for (number, place) in numbers.iter_mut().zip(at..) {
                *number = (self.number_at)(place.min(end - 1));
            }
            for line in 0..5 {
                prefetch(self.triangles, numbers[0] as usize + AHEAD, line);
            }
            each(&numbers[..(end - at).min(8)]);
        }
    }

    /// The box of the middles of eight triangles of every `step` of a piece, of those without an area as well: to
    /// tell them apart takes as long as all the rest.
    #[inline(always)]
    fn middles<S: Simd>(&self, simd: S, start: usize, step: usize) -> Aabb {
        let mut middles = BoxLanes::empty(simd);
        self.eights(
            start,
            step,
            #[inline(always)]
            |numbers| {
                let eight = Eight::new(simd, self.triangles, numbers);
                middles.add(&eight.middles, &eight.middles);
            },
        );
        middles.whole()
    }

    /// The keys of a piece in the order of their buckets, put into `room`. `unsorted`: memory to use.
    #[inline(always)]
    fn piece<'a, S: Simd>(
        &self,
        simd: S,
        start: usize,
        grid: Grid,
        unsorted: &mut Vec<Key>,
        room: &'a mut [Key],
    ) -> Piece<'a> {
        let (mut bounds, mut middles) = (BoxLanes::empty(simd), BoxLanes::empty(simd));
        let mut counts = [0; BUCKETS];
        unsorted.clear();
        self.eights(
            start,
            8,
            #[inline(always)]
            |numbers| {
                let mut eight = Eight::new(simd, self.triangles, numbers);
                let (mut solid, mut count) = ([0; 8], numbers.len());
                solid[..count].copy_from_slice(numbers);
                if have_area_for_sure(&eight.corners) != 255 {
                    count = keep_solid(self.triangles, &mut solid[..count]);
                    if count == 0 {
                        return;
                    }
                    eight = Eight::new(simd, self.triangles, &solid[..count]);
                }
                bounds.add(&eight.bounds.low, &eight.bounds.high);
                middles.add(&eight.middles, &eight.middles);
                let codes = grid.codes(&eight.middles);
                for (code, number) in codes.into_iter().zip(solid).take(count) {
                    let key = (code as Key) << 32 | Key::from(number);
                    counts[bucket(key)] += 1;
                    unsorted.push(key);
                }
            },
        );
        Piece {
            runs: Runs::new(unsorted, counts, room),
            middles: middles.whole(),
            bounds: bounds.whole(),
        }
    }
}

/// What is known of a piece.
struct Piece<'a> {
    runs: Runs<'a>,
    /// Around the middles of its boxes.
    middles: Aabb,
    /// Around its triangles.
    bounds: Aabb,
}

/// Moves the numbers of triangles that have an area to the front, in their order; returns how many there are.
#[cold]
fn keep_solid(triangles: &[Triangle], numbers: &mut [u32]) -> usize {
    let mut count = 0;
    for i in 0..numbers.len() {
        if !is_degenerate(&triangles[numbers[i] as usize].corners) {
            numbers[count] = numbers[i];
            count += 1;
        }
    }
    count
}

/// Where to cut `keys` (in order, at least 2) in two cells: at their highest differing bit, or in the middle when all
/// codes are equal. Never 0 or the end.
pub(super) fn cut(keys: &[Key]) -> usize {
    let Some(bit) = highest_difference(keys) else {
        return keys.len() / 2;
    };
    // Bits above are the same in all: a sum without branches.
    let ones = |keys: &[Key], step: usize| {
        let bits = keys.iter().step_by(step).map(|&key| key >> (32 + bit) & 1);
        bits.sum::<u64>() as usize
    };
    if keys.len() <= FEW_KEYS {
        keys.len() - ones(keys, 1)
    } else if keys.len() <= FEW_KEYS * FEW_KEYS {
        // First among some, then among those between two of them: no step waits for the one before it.
        let some = keys.len().div_ceil(FEW_KEYS);
        let end = (some - ones(keys, FEW_KEYS)) * FEW_KEYS;
        let near = &keys[end - FEW_KEYS..end.min(keys.len())];
        end - FEW_KEYS + near.len() - ones(near, 1)
    } else {
        keys.partition_point(|&key| code(key) >> bit == code(keys[0]) >> bit)
    }
}

/// The highest bit in which codes of `keys`, in order, differ.
#[inline(always)]
pub(super) fn highest_difference(keys: &[Key]) -> Option<u32> {
    (code(keys[0]) ^ code(keys[keys.len() - 1])).checked_ilog2()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;
    use crate::math::Random;

    fn soup(n: usize) -> Vec<Triangle> {
        let mut random = Random::new(n as u64);
        (0..n)
            .map(|i| {
                let p = random.point();
                // Every hundredth has no area.
                let size = if i % 100 == 99 { 0.0 } else { 0.1 };
                Triangle {
                    corners: [p, p + Vec3::X * size, p + Vec3::Y * size],
                    color: Rgb::BLACK,
                }
            })
            .collect()
    }

    #[test]
    fn keys_are_sorted_and_complete() {
        let triangles = soup(70_000);
        let sorted = sort_all(&triangles);
        assert!(sorted.keys.is_sorted());
        let mut numbers: Vec<u32> = sorted.keys.iter().map(|&k| number(k)).collect();
        numbers.sort_unstable();
        let expected: Vec<u32> = (0..70_000).filter(|i| i % 100 != 99).collect();
        assert_eq!(numbers, expected);
        let again = sort_again(&triangles, &sorted.keys[..5000]);
        assert!(again.keys.is_sorted_by_key(|&k| code(k)));
        assert_eq!(again.keys.len(), 5000);
    }

    #[test]
    fn codes_use_the_whole_grid_and_no_more() {
        for scale in [1e-30f32, 1.0, 1e38] {
            let grid = Grid::over(
                Aabb {
                    min: Vec3::splat(-3.0 * scale),
                    max: Vec3::splat(3.0 * scale),
                },
                0.0,
            );
            let code = |p: Vec3| {
                dispatch!(Kernel::best(), simd => {
                    grid.codes(&p.to_array().map(|c| f32x8::splat(simd, c)))[5]
                })
            };
            assert_eq!(code(Vec3::splat(-3.0 * scale)), 0, "scale {scale}");
            assert_eq!(code(Vec3::splat(3.0 * scale)), (1 << CODE_BITS) - 1);
            assert_eq!(code(Vec3::new(3.0, -3.0, -3.0) * scale), 0x2492_4924);
        }
    }

    #[test]
    fn cuts_leave_something_on_both_sides() {
        let key = |code: u64, number: u64| code << 32 | number;
        assert_eq!(cut(&[key(0, 0), key(1, 1), key(4, 2), key(6, 3)]), 2);
        assert_eq!(cut(&[key(5, 0), key(5, 1), key(5, 2), key(5, 3)]), 2);
        assert_eq!(cut(&[key(0, 9), key(u64::from(u32::MAX), 3)]), 1);
        for count in [63, 64, 65, 127, 128, 129, 1000, 4095, 4096, 4097, 10_000] {
            for ones in [1, 2, 62, count / 2, count - 2, count - 1] {
                let keys: Vec<Key> = (0..count)
                    .map(|i| key(if i < count - ones { i % 8 } else { 64 + i % 8 }, i))
                    .collect();
                assert_eq!(cut(&keys), (count - ones) as usize, "{ones} of {count}");
            }
        }
    }
}
