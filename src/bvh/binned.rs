//! The binned surface area heuristic: where to cut a set of boxes in two.
//!
//! Source: Wald, "On fast construction of SAH-based bounding volume hierarchies", 2007.

use super::prim::{Prim, load, middle};
use crate::simd::{
    Select, Simd, SimdBase, SimdCvtFloat, SimdInterleaved, SimdMask, SimdSplit, f32x4, f32x8, i32x4,
};

/// Bins of an axis; for sets of few boxes, [`FEW_BINS`].
const BINS: usize = 16;
/// Bins for sets below four times as many boxes as [`BINS`]: to look through more costs more than it finds.
const FEW_BINS: usize = 8;
/// Beyond this an `f32` has no fraction: the low bits of a sum with it are the rounded number. Cheaper than a
/// conversion.
const WHOLE: f32 = 8_388_608.0;

/// Boxes that will become one part of the tree.
pub(super) struct Set<'a> {
    pub(super) prims: &'a mut [Prim],
    /// As long; where the parts go when the set is cut.
    spare: &'a mut [Prim],
    /// Around all boxes.
    pub(super) bounds: Prim,
    /// Triangles in all.
    pub(super) weight: u32,
}

/// Where to cut a set.
#[derive(Clone, Copy, Debug)]
pub(super) struct Split {
    binning: Binning,
    axis: usize,
    /// Bins up to this one go left.
    last_left: usize,
    left: Prim,
    right: Prim,
    left_weight: u32,
    /// Area times weight, summed over both sides.
    pub(super) cost: f32,
}

/// From the middles of boxes to bins: the nearest of evenly spaced centres.
#[derive(Clone, Copy, Debug)]
struct Binning {
    origin: [f32; 4],
    factor: [f32; 4],
}

impl Binning {
    #[inline(always)]
    fn new<S: Simd>(simd: S, prims: &[Prim], bins: usize) -> Binning {
        let mut low = f32x4::splat(simd, f32::INFINITY);
        let mut high = f32x4::splat(simd, f32::NEG_INFINITY);
        for prim in prims {
            let middle = middle(simd, prim);
            low = low.min(middle);
            high = high.max(middle);
        }
        let size = (high - low).to_array();
        // A little less than the last bin's number, so that the largest middle stays below its upper end.
        let factor = |d: f32| {
            let factor = (bins - 1) as f32 * 0.9999 / d;
            if d > 0.0 && factor.is_finite() {
                factor
            } else {
                0.0
            }
        };
        Binning {
            origin: low.to_array(),
            factor: [factor(size[0]), factor(size[1]), factor(size[2]), 0.0],
        }
    }

    /// The bin on each axis, above [`WHOLE`].
    #[inline(always)]
    fn bins<S: Simd>(&self, simd: S, prim: &Prim) -> f32x4<S> {
        let origin = f32x4::load_array(simd, self.origin);
        let factor = f32x4::load_array(simd, self.factor);
        (middle(simd, prim) - origin) * factor + f32x4::splat(simd, WHOLE)
    }
}

/// What is in the bins of three axes.
struct Bins<const N: usize> {
    bounds: [[Prim; N]; 3],
    weights: [[u32; N]; 3],
}

/// The box around both.
#[inline(always)]
fn join<S: Simd>(simd: S, a: &Prim, b: &Prim) -> Prim {
    Prim(load(simd, a).min(load(simd, b)).to_array())
}

/// The size of a box on each axis, with the sign turned; something in the fourth lane.
#[inline(always)]
fn minus_size<S: Simd>(bounds: f32x8<S>) -> [f32; 4] {
    let (low, minus_high) = bounds.split();
    (low + minus_high).to_array()
}

/// Half areas of four boxes: those of [`Prim::half_area`] to the bit.
#[inline(always)]
fn half_areas<S: Simd>(simd: S, minus_sizes: &[[f32; 4]], scale: f32) -> f32x4<S> {
    let [x, y, z, _] = f32x4::load_four_interleaved(simd, minus_sizes.as_flattened());
    let (x, y, z) = (x * -scale, y * -scale, z * -scale);
    let (x, y, z) = (x.max(0.0), y.max(0.0), z.max(0.0));
    x * y + y * z + z * x
}

impl<const N: usize> Bins<N> {
    #[inline(always)]
    fn new<S: Simd>(simd: S, prims: &[Prim], binning: &Binning) -> Bins<N> {
        let mut bins = Bins {
            bounds: [[Prim::EMPTY; N]; 3],
            weights: [[0; N]; 3],
        };
        for prim in prims {
            let place = binning.bins(simd, prim).to_array();
            let (lanes, weight) = (load(simd, prim), prim.weight());
            for (axis, place) in place[..3].iter().enumerate() {
                let bin = place.to_bits() as usize % N;
                let bounds = &mut bins.bounds[axis][bin];
                *bounds = Prim(load(simd, bounds).min(lanes).to_array());
                bins.weights[axis][bin] += weight;
            }
        }
        bins
    }

    /// Of all cuts behind a bin (on any axis) the cheapest: its cost, axis and bin. Among equals the first bin, then
    /// the first axis. `None` when no cut leaves something on both sides.
    ///
    /// Sweeping is most of the work for few boxes, so areas and costs are computed for four cuts at a time.
    #[inline(always)]
    fn cheapest<S: Simd>(&self, simd: S, scale: f32, weight: u32) -> Option<(f32, usize, usize)> {
        let none = f32x4::splat(simd, f32::INFINITY);
        let (mut costs, mut least) = ([[0.0; N]; 3], none);
        let (mut left, mut right) = ([[0.0; 4]; N], [[0.0; 4]; N]);
        let mut left_weights = [0i32; N];
        for (axis, costs) in costs.iter_mut().enumerate() {
            let bins = &self.bounds[axis];
            let (mut bounds, mut sum) = (f32x8::splat(simd, f32::INFINITY), 0);
            for i in 0..N {
                bounds = bounds.min(load(simd, &bins[i]));
                left[i] = minus_size(bounds);
                sum += self.weights[axis][i];
                left_weights[i] = sum as i32;
            }
            let mut bounds = f32x8::splat(simd, f32::INFINITY);
            for i in (1..N).rev() {
                bounds = bounds.min(load(simd, &bins[i]));
                right[i - 1] = minus_size(bounds);
            }
            for at in (0..N).step_by(4) {
                let left_weight = i32x4::from_slice(simd, &left_weights[at..at + 4]);
                let right_weight = i32x4::splat(simd, weight as i32) - left_weight;
                let left_area = half_areas(simd, &left[at..at + 4], scale);
                let right_area = half_areas(simd, &right[at..at + 4], scale);
                let cost = left_area * f32x4::float_from(left_weight)
                    + right_area * f32x4::float_from(right_weight);
                let both = left_weight.simd_gt(0) & right_weight.simd_gt(0);
                // Not where infinite areas made it NaN, either.
                let cost = (both & cost.simd_lt(none)).select(cost, none);
                cost.store_slice(&mut costs[at..at + 4]);
                least = least.min(cost);
            }
        }
        let least = least.reduce_min();
        if least == f32::INFINITY {
            return None;
        }
        let mut equal = [0; 3];
        for (equal, costs) in equal.iter_mut().zip(&costs) {
            for at in (0..N).step_by(4) {
                let costs = f32x4::from_slice(simd, &costs[at..at + 4]);
                *equal |= costs.simd_eq(least).to_bitmask() << at;
            }
        }
        let bin = (equal[0] | equal[1] | equal[2]).trailing_zeros() as usize;
        let axis = equal.iter().position(|bits| bits >> bin & 1 == 1)?;
        Some((least, axis, bin))
    }
}

impl<'a> Set<'a> {
    /// All of `prims`; `spare` is as long.
    pub(super) fn new(prims: &'a mut [Prim], spare: &'a mut [Prim]) -> Set<'a> {
        assert_eq!(prims.len(), spare.len(), "a spare place for each");
        let bounds = prims.iter().fold(Prim::EMPTY, |all, p| all.join(p));
        let weight = prims.iter().map(Prim::weight).sum();
        Set {
            prims,
            spare,
            bounds,
            weight,
        }
    }

    /// The cheapest cut between bins, or `None` when all middles share a bin on every axis. Areas are those of
    /// lengths taken `scale` times.
    #[inline(always)]
    pub(super) fn best_split<S: Simd>(&self, simd: S, scale: f32) -> Option<Split> {
        if self.prims.len() < 4 * BINS {
            self.best_of_bins::<S, FEW_BINS>(simd, scale)
        } else {
            self.best_of_bins::<S, BINS>(simd, scale)
        }
    }

    #[inline(always)]
    fn best_of_bins<S: Simd, const N: usize>(&self, simd: S, scale: f32) -> Option<Split> {
        let binning = Binning::new(simd, self.prims, N);
        let bins = Bins::<N>::new(simd, self.prims, &binning);
        let (cost, axis, last_left) = bins.cheapest(simd, scale, self.weight)?;
        // Loops, not folds: a closure may not be inlined, and would be compiled without the wide instructions.
        let (mut left, mut right) = (Prim::EMPTY, Prim::EMPTY);
        for (i, bin) in bins.bounds[axis].iter().enumerate() {
            if i <= last_left {
                left = join(simd, &left, bin);
            } else {
                right = join(simd, &right, bin);
            }
        }
        Some(Split {
            binning,
            axis,
            last_left,
            left,
            right,
            left_weight: bins.weights[axis][..=last_left].iter().sum(),
            cost,
        })
    }

    /// Both sides of a cut, by copying without a branch: each box goes to the next place of its side.
    #[inline(always)]
    pub(super) fn cut<S: Simd>(self, simd: S, split: &Split) -> [Set<'a>; 2] {
        let last_left = f32x4::splat(simd, WHOLE + split.last_left as f32);
        let (mut left, mut right) = (0, self.prims.len());
        for prim in &*self.prims {
            let bins = split.binning.bins(simd, prim);
            let goes_left = bins.simd_le(last_left).to_bitmask() as usize >> split.axis & 1;
            let place = if goes_left == 1 { left } else { right - 1 };
            self.spare[place] = *prim;
            left += goes_left;
            right -= 1 - goes_left;
        }
        let (left_prims, right_prims) = self.spare.split_at_mut(left);
        let (left_spare, right_spare) = self.prims.split_at_mut(left);
        let part = |prims, spare, bounds, weight| Set {
            prims,
            spare,
            bounds,
            weight,
        };
        let right_weight = self.weight - split.left_weight;
        [
            part(left_prims, left_spare, split.left, split.left_weight),
            part(right_prims, right_spare, split.right, right_weight),
        ]
    }

    /// Both halves in the order that the boxes have: when any cut is as good as any other.
    pub(super) fn halve(self) -> [Set<'a>; 2] {
        let middle = self.prims.len() / 2;
        let (left, right) = self.prims.split_at_mut(middle);
        let (left_spare, right_spare) = self.spare.split_at_mut(middle);
        [Set::new(left, left_spare), Set::new(right, right_spare)]
    }
}
