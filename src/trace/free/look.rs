//! What the rays of a beam find out about one triangle (lanes are rays), and which of them it is the nearest for.

use super::Ray;
use super::beam::{Beam, STEEP};
use super::block::UNDERFLOW;
use super::ready::largest;
use super::single::settle;
use super::tree::RayTree;
use crate::simd::{Bytes, Lanes, Select, SimdBase, SimdFloat, bits, lanes, load, store};
use crate::trace::space::ROUNDOFF;

/// A triangle that a beam may meet.
#[derive(Clone, Copy, Debug)]
pub struct Candidate {
    /// Block times 8 plus lane.
    pub slot: u32,
    /// x′, y′ and z′ of the three corners.
    pub corners: [[f32; 3]; 3],
    /// See [`Sifted`](super::sift::Sifted).
    pub error: f32,
    pub reach: f32,
}

impl Beam {
    /// Lets all rays look at one triangle; whether it is nearer for any.
    #[inline(always)]
    pub fn triangle<S: Lanes>(
        &mut self,
        simd: S,
        tree: &RayTree,
        this: &Candidate,
        rays: &[Ray],
    ) -> bool {
        let mut nearer = false;
        for at in (0..self.padded).step_by(lanes::<S>()) {
            nearer |= self.look(simd, tree, this, at, rays);
        }
        nearer
    }

    /// Lets the rays from number `at` on, as many as there are lanes, look at a triangle; whether it is nearer for any.
    #[inline(always)]
    fn look<S: Lanes>(
        &mut self,
        simd: S,
        tree: &RayTree,
        this: &Candidate,
        at: usize,
        rays: &[Ray],
    ) -> bool {
        macro_rules! splat {
            ($x:expr) => {
                S::f32s::splat(simd, $x)
            };
        }
        let [ox, oy, oz] = [
            load(simd, &self.origin[0], at),
            load(simd, &self.origin[1], at),
            load(simd, &self.origin[2], at),
        ];
        let (sx, sy) = (
            load(simd, &self.slope[0], at),
            load(simd, &self.slope[1], at),
        );
        macro_rules! seen {
            ($corner:expr) => {{
                let [x, y, z] = &this.corners;
                let z = splat!(z[$corner]) - oz;
                [
                    sx.mul_add(z, splat!(x[$corner]) - ox),
                    sy.mul_add(z, splat!(y[$corner]) - oy),
                    z,
                ]
            }};
        }
        let [x0, y0, z0] = seen!(0);
        let [x1, y1, z1] = seen!(1);
        let [x2, y2, z2] = seen!(2);
        let side0 = x1.mul_sub(y2, y1 * x2);
        let side1 = x2.mul_sub(y0, y2 * x0);
        let side2 = x0.mul_sub(y1, y0 * x1);
        let least = side0.min(side1).min(side2);
        let most = side0.max(side1).max(side2);
        let error = splat!(this.error);
        let near = (least + error).simd_ge(0.0) | (most - error).simd_le(0.0);
        if bits::<S>(near) == 0 {
            return false;
        }
        // The bounds of this ray alone are tighter.
        let size = x0.abs().max(x1.abs()).max(x2.abs());
        let size = size.max(y0.abs()).max(y1.abs()).max(y2.abs());
        let depth = z0.abs().max(z1.abs()).max(z2.abs());
        let r = (depth * splat!(STEEP) + size) * splat!(10.0 * ROUNDOFF);
        let error = r.mul_add(size + r, splat!(UNDERFLOW));
        let near = (least + error).simd_ge(0.0) | (most - error).simd_le(0.0);
        let inside = least.simd_gt(error) | (most + error).simd_lt(0.0);
        let sum = splat!(1.0) / (side0 + side1 + side2);
        let z = (side0 * sum).mul_add(z0, (side1 * sum).mul_add(z1, (side2 * sum) * z2));
        let inverse = load(simd, &self.inverse, at);
        let margin = (error * sum)
            .abs()
            .mul_add(splat!(6.5), splat!(16.0 * ROUNDOFF));
        let margin = margin * (depth * inverse).abs();
        let t = z * inverse;
        let (low, high) = (t - margin, t + margin);
        let in_front = low.simd_gt(0.0);
        let settled = inside & (in_front | high.simd_lt(0.0));
        let sure = inside & in_front;
        let (wins, open) = self.compare(simd, at, sure, low, high);
        let open = bits::<S>(open | (near & !settled));
        let nearer = bits::<S>(wins) != 0;
        if nearer {
            self.take_over(simd, this.slot, at, wins, low, high);
        }
        if open != 0 {
            self.settle(tree, this.slot, at, open, rays) | nearer
        } else {
            nearer
        }
    }

    /// Lets all rays look at a triangle that their lines pass through; whether it is nearer for any.
    ///
    /// With n the normal and s the slopes, the depth of its plane is n·(p − o) / (n·s). The rule's corners are off by 2
    /// roundings of the reach from ours, so edges by 4, and by a rounding of their own: δ, here twice that. Then n is
    /// off by at most 4δ(e + δ), where e is the largest coordinate of the two edges, with its own roundings; p − o and
    /// s are three numbers each, as large as `reach` and [`STEEP`].
    #[inline(always)]
    pub fn pass<S: Lanes>(
        &mut self,
        simd: S,
        tree: &RayTree,
        this: &Candidate,
        rays: &[Ray],
    ) -> bool {
        macro_rules! splat {
            ($x:expr) => {
                S::f32s::splat(simd, $x)
            };
        }
        let edge = |corner: usize| this.corners.map(|x| x[corner] - x[0]);
        let (p, q) = (edge(1), edge(2));
        let n = [
            p[1] * q[2] - p[2] * q[1],
            p[2] * q[0] - p[0] * q[2],
            p[0] * q[1] - p[1] * q[0],
        ];
        let longest = p.iter().chain(&q).fold(0.0, |e, x| largest(e, x.abs()));
        let delta = self.slack * 0.125 + longest * (4.0 * ROUNDOFF);
        // Also for the roundings of the sums below, each less than 8 of the size of a term.
        let off = 4.0 * delta * (longest + delta) + longest * longest * (16.0 * ROUNDOFF);
        let of_whole = 3.0 * off * this.reach + UNDERFLOW;
        let of_along = (1.0 + 2.0 * STEEP) * off + UNDERFLOW;
        let n = [splat!(n[0]), splat!(n[1]), splat!(n[2])];
        let p = this.corners.map(|x| x[0]);
        let mut nearer = false;
        for at in (0..self.padded).step_by(lanes::<S>()) {
            let x = splat!(p[0]) - load(simd, &self.origin[0], at);
            let y = splat!(p[1]) - load(simd, &self.origin[1], at);
            let z = splat!(p[2]) - load(simd, &self.origin[2], at);
            let whole = n[0].mul_add(x, n[1].mul_add(y, n[2] * z));
            let (sx, sy) = (
                load(simd, &self.slope[0], at),
                load(simd, &self.slope[1], at),
            );
            let along = n[2] - n[0].mul_add(sx, n[1] * sy);
            let (whole_off, along_off) = (
                splat!(of_whole) / whole.abs(),
                splat!(of_along) / along.abs(),
            );
            let certain = whole_off.max(along_off).simd_lt(0.25);
            let t = whole / along * load(simd, &self.inverse, at);
            let margin = (whole_off + along_off).mul_add(splat!(2.0), splat!(8.0 * ROUNDOFF));
            let margin = t.abs() * margin;
            let (low, high) = (t - margin, t + margin);
            let sure = certain & t.simd_gt(0.0);
            let (wins, open) = self.compare(simd, at, sure, low, high);
            if bits::<S>(open | !certain) != 0 {
                nearer |= self.look(simd, tree, this, at, rays);
            } else if bits::<S>(wins) != 0 {
                nearer = true;
                self.take_over(simd, this.slot, at, wins, low, high);
            }
        }
        nearer
    }

    /// For which rays a triangle that is hit for `sure` between `low` and `high` is the nearest so far; and for which
    /// that is open.
    #[inline(always)]
    fn compare<S: Lanes>(
        &self,
        simd: S,
        at: usize,
        sure: S::mask32s,
        low: S::f32s,
        high: S::f32s,
    ) -> (S::mask32s, S::mask32s) {
        let sure = sure & low.simd_le(load(simd, &self.high, at));
        let wins = sure
            & high.simd_lt(load(simd, &self.low, at))
            & low.simd_ge(load(simd, &self.t_min, at));
        (wins, sure & !wins)
    }

    /// The triangle is the nearest so far for the rays that it `wins`.
    #[inline(always)]
    fn take_over<S: Lanes>(
        &mut self,
        simd: S,
        slot: u32,
        at: usize,
        wins: S::mask32s,
        low: S::f32s,
        high: S::f32s,
    ) {
        let (was_low, was_high) = (load(simd, &self.low, at), load(simd, &self.high, at));
        store::<S>(wins.select(low, was_low), &mut self.low, at);
        store::<S>(wins.select(high, was_high), &mut self.high, at);
        let slots = &mut self.slot[at..at + lanes::<S>()];
        let was: S::f32s = S::u32s::from_slice(simd, slots).bitcast();
        let this: S::f32s = S::u32s::splat(simd, slot).bitcast();
        wins.select(this, was)
            .bitcast::<S::u32s>()
            .store_slice(slots);
    }

    /// Lets the exact rule decide for the rays `open`, as bits from number `at` on.
    #[cold]
    #[inline(never)]
    fn settle(&mut self, tree: &RayTree, slot: u32, at: usize, open: u32, rays: &[Ray]) -> bool {
        let mut nearer = false;
        for i in at..self.count.min(at + 16) {
            if open >> (i - at) & 1 == 0 {
                continue;
            }
            let ray = &rays[usize::from(self.index[i])];
            let nearest = settle(tree, ray, self.nearest(i), slot);
            (self.low[i], self.high[i]) = (nearest.low, nearest.high);
            nearer |= self.slot[i] != nearest.slot;
            self.slot[i] = nearest.slot;
        }
        nearer
    }
}
