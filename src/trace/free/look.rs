//! What the rays of a beam find out about one triangle (lanes are rays), and which of them it is the nearest for.

use super::Ray;
use super::beam::{Beam, STEEP};
use super::block::UNDERFLOW;
use super::ready::{largest, smallest};
use super::single::settle;
use super::tree::RayTree;
use crate::simd::{Bytes, Lanes, Select, SimdBase, SimdFloat, all_lanes, bits, lanes, load, store};
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

/// The plane of a [`Candidate`].
struct Plane {
    normal: [f32; 3],
    /// The errors of n·(p − o), and of n·s.
    of_whole: f32,
    of_along: f32,
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

    /// A triangle's plane, and how far from it the rule's may be.
    ///
    /// With n the normal and s the slopes, the depth of the plane is n·(p − o) / (n·s). The rule's corners are rounded
    /// relative to the origin, so its edges are off by 2 roundings of `reach` from ours, and by one of their own: δ, here
    /// twice that. Then n is off by at most 4δ(e + δ), where e is the largest coordinate of the two edges, with its own
    /// roundings; p − o is rounded as the rule does it. p − o and s are three numbers each, as large as `reach` and
    /// [`STEEP`].
    #[inline(always)]
    fn plane(&self, this: &Candidate) -> Plane {
        let edge = |corner: usize| this.corners.map(|x| x[corner] - x[0]);
        let (p, q) = (edge(1), edge(2));
        let longest = p.iter().chain(&q).fold(0.0, |e, x| largest(e, x.abs()));
        let delta = (this.reach + longest) * (4.0 * ROUNDOFF);
        // Also for the roundings of sums of three products, each less than 8 of the size of a term.
        let off = 4.0 * delta * (longest + delta) + longest * longest * (16.0 * ROUNDOFF);
        Plane {
            normal: [
                p[1] * q[2] - p[2] * q[1],
                p[2] * q[0] - p[0] * q[2],
                p[0] * q[1] - p[1] * q[0],
            ],
            of_whole: 3.0 * off * this.reach + UNDERFLOW,
            of_along: (1.0 + 2.0 * STEEP) * off + UNDERFLOW,
        }
    }

    /// Whether all rays start on one side of a triangle's plane and go away from it: for certain.
    ///
    /// So it is with what mirrors them, and with its neighbours where a surface bulges.
    #[inline(always)]
    pub fn is_behind<S: Lanes>(&self, simd: S, this: &Candidate) -> bool {
        let Plane {
            normal,
            of_whole,
            of_along,
        } = self.plane(this);
        let of_sheet = |k: usize| self.sheets[k].slopes.map(|slope| normal[k] * slope);
        let ([x0, x1], [y0, y1]) = (of_sheet(0), of_sheet(1));
        let least = normal[2] + (smallest(x0, x1) + smallest(y0, y1));
        let most = normal[2] + (largest(x0, x1) + largest(y0, y1));
        // So that n·(p − o) is above zero where a ray goes away from the plane.
        let turned = if least > of_along {
            -self.sense
        } else if most < -of_along {
            self.sense
        } else {
            return false;
        };
        let n = [
            S::f32s::splat(simd, turned * normal[0]),
            S::f32s::splat(simd, turned * normal[1]),
            S::f32s::splat(simd, turned * normal[2]),
        ];
        let mut least = S::f32s::splat(simd, f32::INFINITY);
        for at in (0..self.padded).step_by(lanes::<S>()) {
            let x = S::f32s::splat(simd, this.corners[0][0]) - load(simd, &self.origin[0], at);
            let y = S::f32s::splat(simd, this.corners[1][0]) - load(simd, &self.origin[1], at);
            let z = S::f32s::splat(simd, this.corners[2][0]) - load(simd, &self.origin[2], at);
            least = least.min(n[0].mul_add(x, n[1].mul_add(y, n[2] * z)));
        }
        bits::<S>(least.simd_gt(of_whole)) == all_lanes::<S>()
    }

    /// Lets all rays look at a triangle that their lines pass through; whether it is nearer for any.
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
        let Plane {
            normal: n,
            of_whole,
            of_along,
        } = self.plane(this);
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
            let certain = whole.abs().simd_gt(4.0 * of_whole) & along.abs().simd_gt(4.0 * of_along);
            // One division: off by the errors of whole and along, each by its part.
            let inverse_along = splat!(1.0) / along;
            let (z, inverse) = (whole * inverse_along, load(simd, &self.inverse, at));
            let off = splat!(of_along).mul_add(z.abs(), splat!(of_whole)) * inverse_along.abs();
            let margin = off.mul_add(splat!(2.0), z.abs() * splat!(8.0 * ROUNDOFF));
            let t = z * inverse;
            let margin = margin * inverse.abs();
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
            let ray = &rays[self.index[i] as usize];
            let nearest = settle(tree, ray, self.nearest(i), slot);
            (self.low[i], self.high[i]) = (nearest.low, nearest.high);
            nearer |= self.slot[i] != nearest.slot;
            self.slot[i] = nearest.slot;
        }
        nearer
    }
}
