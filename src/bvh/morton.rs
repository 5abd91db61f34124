//! Triangles along a space-filling curve: Morton codes of their middles, sorted.
//!
//! Neighbours in space are neighbours on the curve, and all triangles of one cell of an octree are one range of it:
//! the coarse tree is those cells, the fine one starts from small ones. Source: Lauterbach et al., "Fast BVH
//! construction on GPUs", 2009.

use glam::Vec3;
use rayon::prelude::*;

use super::prim::Prim;
use crate::geometry::is_degenerate;
use crate::scene::Triangle;

/// Bits of a code for each axis.
const AXIS_BITS: u32 = 10;
/// Bits of a code.
const CODE_BITS: u32 = 3 * AXIS_BITS;
/// Bits that choose the bucket in the first pass of the sort.
const BUCKET_BITS: u32 = 8;
/// Bits that one later pass sorts by.
const PASS_BITS: u32 = (CODE_BITS - BUCKET_BITS) / 2;
const BUCKETS: usize = 1 << BUCKET_BITS;
/// Triangles that are measured and numbered as one piece.
const PIECE: usize = 1 << 15;
/// Below this the library's sort is faster than counting.
const SMALL_BUCKET: usize = 1 << 10;

/// A code above the number of its triangle.
pub(super) type Key = u64;

/// The number of the triangle of `key`.
#[inline(always)]
pub(super) fn number(key: Key) -> u32 {
    key as u32
}

/// The code of `key`.
#[inline(always)]
pub(super) fn code(key: Key) -> u32 {
    (key >> 32) as u32
}

/// The boxes of some triangles and of their middles.
#[derive(Clone, Copy)]
struct Measure {
    bounds: Prim,
    middles: (Vec3, Vec3),
}

impl Measure {
    const EMPTY: Measure = Measure {
        bounds: Prim::EMPTY,
        middles: (Vec3::INFINITY, Vec3::NEG_INFINITY),
    };

    #[inline(always)]
    fn add(&mut self, prim: &Prim) {
        let middle = prim.middle();
        self.bounds = self.bounds.join(prim);
        self.middles = (self.middles.0.min(middle), self.middles.1.max(middle));
    }

    fn join(self, other: &Measure) -> Measure {
        Measure {
            bounds: self.bounds.join(&other.bounds),
            middles: (
                self.middles.0.min(other.middles.0),
                self.middles.1.max(other.middles.1),
            ),
        }
    }
}

/// From middles to codes.
#[derive(Clone, Copy)]
struct Grid {
    origin: Vec3,
    /// The same for all axes, so that cells are cubes: half of cells a unit, since it multiplies half differences.
    factor: f32,
}

impl Grid {
    fn over((low, high): (Vec3, Vec3)) -> Grid {
        let half_size = (high * 0.5 - low * 0.5).max_element();
        // A little less than the number of cells, so that rounding does not lead beyond the last one.
        let factor = ((1 << AXIS_BITS) as f32 * 0.9999) / half_size;
        Grid {
            origin: low * 0.5,
            factor: factor.min(f32::MAX),
        }
    }

    #[inline(always)]
    fn code(self, middle: Vec3) -> u32 {
        let cell = (middle * 0.5 - self.origin) * self.factor;
        // Conversions keep to the range: 0 at least, and not above the last cell.
        let spread = |x: f32| spread((x as i32 as u32).min((1 << AXIS_BITS) - 1));
        spread(cell.x) << 2 | spread(cell.y) << 1 | spread(cell.z)
    }
}

/// Two zero bits between any two of the lowest ten bits.
#[inline(always)]
fn spread(x: u32) -> u32 {
    let x = (x | x << 16) & 0x0300_00ff;
    let x = (x | x << 8) & 0x0300_f00f;
    let x = (x | x << 4) & 0x030c_30c3;
    (x | x << 2) & 0x0924_9249
}

/// Keys in the order of their codes, and the box of their triangles.
pub(super) struct Sorted {
    pub(super) keys: Vec<Key>,
    pub(super) bounds: Prim,
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
    let prim_at = |place| {
        let number = number_at(place);
        (number, &triangles[number as usize].corners)
    };
    let pieces: Vec<_> = (0..count)
        .step_by(PIECE)
        .map(|start| start..count.min(start + PIECE))
        .collect();
    // Each piece's measure, and the places of what has no area.
    let measures: Vec<(Measure, Vec<usize>)> = pieces
        .par_iter()
        .map(|piece| {
            let (mut measure, mut flat) = (Measure::EMPTY, Vec::new());
            for place in piece.clone() {
                let (_, corners) = prim_at(place);
                if is_degenerate(corners) {
                    flat.push(place);
                } else {
                    measure.add(&Prim::of(corners));
                }
            }
            (measure, flat)
        })
        .collect();
    let all = measures
        .iter()
        .fold(Measure::EMPTY, |all, (measure, _)| all.join(measure));
    let grid = Grid::over(all.middles);
    let runs: Vec<Runs> = pieces
        .into_par_iter()
        .zip(&measures)
        .map(|(piece, (_, flat))| {
            let mut flat = flat.iter().copied().peekable();
            let mut keys = Vec::with_capacity(piece.len());
            for place in piece {
                if flat.next_if_eq(&place).is_none() {
                    let (number, corners) = prim_at(place);
                    let code = grid.code(Prim::of(corners).middle());
                    keys.push(Key::from(code) << 32 | Key::from(number));
                }
            }
            Runs::new(&keys)
        })
        .collect();
    Sorted {
        keys: merge(&runs),
        bounds: all.bounds,
    }
}

/// The keys of a piece, bucket by bucket.
struct Runs {
    keys: Vec<Key>,
    /// Where each bucket starts; one more for the end.
    starts: [u32; BUCKETS + 1],
}

fn bucket(key: Key) -> usize {
    (key >> (32 + CODE_BITS - BUCKET_BITS)) as usize % BUCKETS
}

impl Runs {
    fn new(unsorted: &[Key]) -> Runs {
        let mut keys = vec![0; unsorted.len()];
        let mut starts = [0; BUCKETS + 1];
        counting_sort::<BUCKETS>(unsorted, &mut keys, bucket, &mut starts[..BUCKETS]);
        // Each start has moved to its bucket's end.
        starts.rotate_right(1);
        starts[0] = 0;
        Runs { keys, starts }
    }

    fn of(&self, bucket: usize) -> &[Key] {
        &self.keys[self.starts[bucket] as usize..self.starts[bucket + 1] as usize]
    }
}

/// Copies `from` to `to` in the order of `digit` (below `N`), equal ones in the order they had. `ends`: room for `N`
/// numbers, which are where the keys of each digit end.
#[inline(always)]
fn counting_sort<const N: usize>(
    from: &[Key],
    to: &mut [Key],
    digit: impl Fn(Key) -> usize,
    ends: &mut [u32],
) {
    let ends: &mut [u32; N] = ends.try_into().expect("a place for each digit");
    ends.fill(0);
    for &key in from {
        ends[digit(key) % N] += 1;
    }
    let mut start = 0;
    for end in ends.iter_mut() {
        (*end, start) = (start, start + *end);
    }
    for &key in from {
        let place = &mut ends[digit(key) % N];
        to[*place as usize] = key;
        *place += 1;
    }
}

/// All keys in order.
fn merge(runs: &[Runs]) -> Vec<Key> {
    let mut keys = vec![0; runs.iter().map(|r| r.keys.len()).sum()];
    let mut rest = &mut keys[..];
    let mut buckets = Vec::new();
    for bucket in 0..BUCKETS {
        let len = runs.iter().map(|r| r.of(bucket).len()).sum();
        let (this, behind) = rest.split_at_mut(len);
        buckets.push((bucket, this));
        rest = behind;
    }
    buckets
        .into_par_iter()
        .filter(|(_, keys)| !keys.is_empty())
        .for_each_init(Vec::new, |scratch, (bucket, keys)| {
            let mut rest = &mut *keys;
            for run in runs.iter().map(|r| r.of(bucket)) {
                let (this, behind) = rest.split_at_mut(run.len());
                this.copy_from_slice(run);
                rest = behind;
            }
            sort_bucket(keys, scratch);
        });
    keys
}

/// Sorts keys that share their highest bits by the others.
fn sort_bucket(keys: &mut [Key], scratch: &mut Vec<Key>) {
    const DIGITS: usize = 1 << PASS_BITS;
    if keys.len() < SMALL_BUCKET {
        keys.sort_unstable();
        return;
    }
    if scratch.len() < keys.len() {
        scratch.resize(keys.len(), 0);
    }
    let scratch = &mut scratch[..keys.len()];
    let mut ends = [0; DIGITS];
    let low = |key: Key| (key >> 32) as usize % DIGITS;
    let high = |key: Key| (key >> (32 + PASS_BITS)) as usize % DIGITS;
    counting_sort::<DIGITS>(keys, scratch, low, &mut ends);
    counting_sort::<DIGITS>(scratch, keys, high, &mut ends);
}

/// Where to cut `keys` (in order, at least 2) in two cells: at their highest differing bit, or in the middle when all
/// codes are equal. Never 0 or the end.
pub(super) fn cut(keys: &[Key]) -> usize {
    let (first, last) = (code(keys[0]), code(keys[keys.len() - 1]));
    if first == last {
        return keys.len() / 2;
    }
    let shift = (first ^ last).ilog2();
    keys.partition_point(|&key| code(key) >> shift == first >> shift)
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
            let grid = Grid::over((Vec3::splat(-3.0 * scale), Vec3::splat(3.0 * scale)));
            assert_eq!(grid.code(Vec3::splat(-3.0 * scale)), 0, "scale {scale}");
            assert_eq!(grid.code(Vec3::splat(3.0 * scale)), (1 << CODE_BITS) - 1);
            assert_eq!(grid.code(Vec3::new(3.0, -3.0, -3.0) * scale), 0x2492_4924);
        }
    }

    #[test]
    fn cuts_leave_something_on_both_sides() {
        let key = |code: u64, number: u64| code << 32 | number;
        assert_eq!(cut(&[key(0, 0), key(1, 1), key(4, 2), key(6, 3)]), 2);
        assert_eq!(cut(&[key(5, 0), key(5, 1), key(5, 2), key(5, 3)]), 2);
        assert_eq!(cut(&[key(0, 9), key(u64::from(u32::MAX), 3)]), 1);
    }
}
