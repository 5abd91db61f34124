//! Exact copies of a triangle: those that only make a tree slow.
//!
//! A triangle with the very corners of another in the same order is hit by the same rays at the same distances, to
//! the bit; so the lower number always wins, and what has the higher one is never seen. A file of a hundred thousand
//! copies would yet make every ray compare them all. (With the corners in another order the distance may differ in
//! its last bit: those stay.)
//!
//! Copies share a cell of the Morton grid. Most cells hold few triangles, of which nobody is told apart: that would
//! cost every scene time to save little in a few. Only the crowded ones are looked at.

use std::ops::Range;

use rayon::prelude::*;

use super::radix::{Key, code, number};
use crate::raw::Pages;
use crate::scene::Triangle;

/// Keys so far apart are compared: cells with twice as many triangles are always found crowded, those with at most as
/// many never.
const STRIDE: usize = 16;

/// Whether a cell of `keys`, in order, is crowded.
#[inline(always)]
pub(super) fn is_crowded(keys: &[Key]) -> bool {
    let mut found = false;
    let mut last = None;
    for &key in keys.iter().step_by(STRIDE) {
        let this = Some(code(key));
        found |= this == last;
        last = this;
    }
    found
}

/// Takes all triangles out of the crowded cells of `keys`, which are in order, that are copies of one with a lower
/// number; how many there were.
#[cold]
pub(super) fn drop_copies(triangles: &[Triangle], keys: &mut Pages<Key>) -> usize {
    let cells = crowded_cells(keys);
    let originals: Vec<Vec<Key>> = cells
        .par_iter()
        .map(|cell| originals(triangles, &keys[cell.clone()]))
        .collect();
    let before = keys.len();
    let mut next = 0;
    let mut end = 0;
    for (cell, originals) in cells.into_iter().zip(&originals) {
        keys.copy_within(end..cell.start, next);
        next += cell.start - end;
        keys[next..next + originals.len()].copy_from_slice(originals);
        next += originals.len();
        end = cell.end;
    }
    keys.copy_within(end.., next);
    keys.truncate(next + before - end);
    before - keys.len()
}

/// The places of the keys of all crowded cells, in order.
fn crowded_cells(keys: &[Key]) -> Vec<Range<usize>> {
    let mut cells = Vec::new();
    let mut at = STRIDE;
    while at < keys.len() {
        let cell = code(keys[at]);
        if code(keys[at - STRIDE]) != cell {
            at += STRIDE;
            continue;
        }
        let of_cell = |key: &&Key| code(**key) == cell;
        let start = at - keys[..at].iter().rev().take_while(of_cell).count();
        let end = at + keys[at..].iter().take_while(of_cell).count();
        cells.push(start..end);
        at = end + STRIDE;
    }
    cells
}

/// Those of the `keys` of one cell that are no copies, in order of their numbers.
fn originals(triangles: &[Triangle], keys: &[Key]) -> Vec<Key> {
    let bits = |key: Key| {
        let corners = &triangles[number(key) as usize].corners;
        corners.map(|p| p.to_array().map(f32::to_bits))
    };
    // By a mixture of all bits first: most are told apart without a look at their corners.
    let mut sorted: Vec<(u64, Key)> = keys.iter().map(|&key| (mixture(bits(key)), key)).collect();
    sorted.sort_unstable_by(|(mixed, key), (other_mixed, other)| {
        mixed
            .cmp(other_mixed)
            .then_with(|| bits(*key).cmp(&bits(*other)))
            .then(key.cmp(other))
    });
    sorted.dedup_by(|(mixed, key), (first_mixed, first)| {
        mixed == first_mixed && bits(*key) == bits(*first)
    });
    let mut originals: Vec<Key> = sorted.into_iter().map(|(_, key)| key).collect();
    originals.sort_unstable();
    originals
}

/// A number that depends on every bit.
fn mixture(corners: [[u32; 3]; 3]) -> u64 {
    corners.as_flattened().iter().fold(0, |mixed: u64, &bits| {
        (mixed ^ u64::from(bits))
            .wrapping_mul(0x9e37_79b9_7f4a_7c15)
            .rotate_left(29)
    })
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::bvh::morton;
    use crate::bvh::{Bvh, Quality};
    use crate::color::Rgb;
    use crate::math::Random;

    /// `groups` triangles with `copies` copies of each, mixed, around one point with another far away.
    fn copied(groups: usize, copies: usize) -> Vec<Triangle> {
        let triangle = |corners| Triangle {
            corners,
            color: Rgb::BLACK,
        };
        let mut random = Random::new(groups as u64);
        let corners: Vec<[Vec3; 3]> = (0..groups)
            .map(|_| [(); 3].map(|()| random.point()))
            .collect();
        let far = [1e6, 2e6, 3e6].map(|x| Vec3::new(x, 1e6, 1.0 - x * 0.3));
        let mut all: Vec<Triangle> = (0..groups * copies)
            .map(|i| triangle(corners[i * 7 % groups]))
            .collect();
        all.push(triangle(far));
        all
    }

    #[test]
    fn of_copies_in_a_crowded_cell_the_first_stays() {
        for (groups, copies) in [(1, 33), (3, 40), (100, 11), (1000, 1), (5, 3000)] {
            let triangles = copied(groups, copies);
            for quality in [Quality::Fine, Quality::Coarse] {
                let bvh = Bvh::with_quality(&triangles, quality);
                assert_eq!(bvh.validate(&triangles), Ok(()));
                assert_eq!(bvh.copies, groups * (copies - 1), "{groups} {copies} times");
                let mut ids = bvh.file_ids.to_vec();
                ids.sort_unstable();
                assert!(ids[..groups].iter().copied().eq(0..groups as u32));
            }
        }
    }

    #[test]
    fn the_same_corners_in_another_order_are_no_copy() {
        let mut triangles = copied(1, 60);
        for triangle in &mut triangles[10..20] {
            triangle.corners.rotate_left(1);
        }
        triangles[59].corners[0].x += 1e-6;
        let mut keys = morton::sort_all(&triangles).keys;
        assert_eq!(drop_copies(&triangles, &mut keys), 57);
        let left: Vec<u32> = keys.iter().map(|&key| number(key)).collect();
        assert_eq!(left, [0, 10, 59, 60]);
        assert_eq!(drop_copies(&triangles, &mut keys), 0, "a second time");
    }

    #[test]
    fn cells_of_thirty_two_are_always_crowded_and_of_sixteen_never() {
        for length in [0, 1, 16, 17, 32, 33, 100] {
            for before in 0..40u64 {
                let codes = (0..before)
                    .chain(std::iter::repeat_n(40, length))
                    .chain(41..90);
                let keys: Vec<Key> = codes.map(|code| code << 32).collect();
                let cells = crowded_cells(&keys);
                assert_eq!(is_crowded(&keys), !cells.is_empty());
                let start = before as usize;
                if length >= 32 {
                    assert_eq!(cells.len(), 1);
                    assert_eq!(cells[0], start..start + length);
                } else {
                    assert!(length > 16 || cells.is_empty());
                }
            }
        }
    }
}
