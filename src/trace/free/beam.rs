//! Rays that keep together go down a [`RayTree`] as one beam.
//!
//! Rays from neighbouring pixels that a mirror sent on go nearly the same way. Up to 64 of them are bounded by four
//! planes and tested against a node as if they were one ray; in a leaf, first the beam sorts out triangles (lanes are
//! triangles), then each that is left is tested by all rays (lanes are rays).
//!
//! # The planes
//! Let z be the axis along which the rays are longest, all in the same sense, s the slopes dx/|dz| of the rays and s₀
//! the least. On every ray, at any point ahead of its origin o, x − s₀·|z| is not below that of o: so the least of
//! x − s₀·|z| over all origins is a bound for all that the rays can meet. The same for the largest slope, and for y.

use super::Ray;
use super::block::{LANES, UNDERFLOW};
use super::distances::HitRows;
use super::ready::{Nearest, largest};
use super::sift::Sheet;
use super::single::{hit, settle};
use super::tree::{RayNode, RayTree};
use super::walk::{Stack, push};
use super::window::{MOST, Row, Window, fold, main_axes, smallest};
use crate::bvh::Child;
use crate::frame::{Hit, MISS};
use crate::simd::{
    Bytes, Lanes, Select, SimdBase, SimdFloat, SimdMask, bits, f32x8, lanes, load, store,
};
use crate::trace::space::ROUNDOFF;

/// The steepest slope.
pub const STEEP: f32 = 2.0;

/// What a node and a block cost, in tests of a triangle by eight rays.
const NODE_WORK: usize = 3;
const BLOCK_WORK: usize = 4;

/// All rays of a window.
const ALL: [u8; MOST] = {
    let mut index = [0; MOST];
    let mut i = 0;
    while i < MOST {
        index[i] = i as u8;
        i += 1;
    }
    index
};

/// A triangle that a beam may meet.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    /// Block times 8 plus lane.
    slot: u32,
    /// x′, y′ and z′ of the three corners.
    corners: [[f32; 3]; 3],
    /// See [`Sifted`](super::sift::Sifted).
    error: f32,
    reach: f32,
}

/// Some rays and what bounds them.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct Beam {
    /// Rays, and how many numbers a row has: whole vectors of any width.
    count: usize,
    padded: usize,
    origin: [Row; 3],
    dir: [Row; 3],
    /// Minus the slopes along x′ and y′.
    slope: [Row; 2],
    /// 1 / direction along z′.
    inverse: Row,
    /// The direction along z′, without its sign.
    stride: Row,
    t_min: Row,
    low: Row,
    high: Row,
    slot: [u32; MOST],
    /// Which ray of the window it is.
    index: [u8; MOST],
    pub axes: [usize; 3],
    /// 1 or −1: the sense of the rays along z′.
    pub sense: f32,
    pub sheets: [Sheet; 2],
    /// The origins' z′, least and most.
    pub depths: [f32; 2],
    /// The middle of them.
    pub zeta: f32,
    pub slack: f32,
    /// No ray looks farther along z′ than this.
    pub far: f32,
}

impl Default for Beam {
    fn default() -> Beam {
        Beam {
            count: 0,
            padded: 0,
            origin: [[0.0; MOST]; 3],
            dir: [[0.0; MOST]; 3],
            slope: [[0.0; MOST]; 2],
            inverse: [0.0; MOST],
            stride: [0.0; MOST],
            t_min: [0.0; MOST],
            low: [0.0; MOST],
            high: [0.0; MOST],
            slot: [0; MOST],
            index: [0; MOST],
            axes: [0; 3],
            sense: 1.0,
            sheets: [Sheet::default(); 2],
            depths: [0.0; 2],
            zeta: 0.0,
            slack: 0.0,
            far: 0.0,
        }
    }
}

impl Beam {
    /// Takes the rays `members` of `window`, as bits, all of them like ray `seed`: see [`Window::like`].
    #[inline(always)]
    pub fn take<S: Lanes>(&mut self, simd: S, window: &Window, members: u64, seed: usize) {
        let (axes, sense) = main_axes(window.dir(seed));
        (self.axes, self.sense) = (axes, sense);
        self.count = members.count_ones() as usize;
        self.padded = self.count.next_multiple_of(lanes::<S>());
        self.slot = [MISS; MOST];
        self.slack = window.reach * (96.0 * ROUNDOFF);
        if members == u64::MAX {
            self.index = ALL;
            for (k, &axis) in axes.iter().enumerate() {
                self.origin[k] = window.origin[axis];
                self.dir[k] = window.dir[axis];
            }
            self.t_min = window.t_min;
            self.low = window.t_max;
        } else {
            self.gather(window, members);
        }
        self.high = self.low;
        self.bound(simd);
    }

    #[inline(always)]
    fn gather(&mut self, window: &Window, members: u64) {
        let [x, y, z] = self.axes;
        let mut left = members;
        let mut index = 0;
        for i in 0..self.padded {
            // Places that are left over repeat the last ray.
            if left != 0 {
                index = left.trailing_zeros() as usize % MOST;
                left &= left - 1;
            }
            self.index[i] = index as u8;
            self.origin[0][i] = window.origin[x][index];
            self.origin[1][i] = window.origin[y][index];
            self.origin[2][i] = window.origin[z][index];
            self.dir[0][i] = window.dir[x][index];
            self.dir[1][i] = window.dir[y][index];
            self.dir[2][i] = window.dir[z][index];
            self.t_min[i] = window.t_min[index];
            self.low[i] = window.t_max[index];
        }
    }

    /// Finds slopes and planes.
    #[inline(always)]
    fn bound<S: Lanes>(&mut self, simd: S) {
        let infinity = S::f32s::splat(simd, f32::INFINITY);
        let mut least = [infinity; 3];
        let mut most = [-infinity; 3];
        for at in (0..self.padded).step_by(lanes::<S>()) {
            let [x, y, z] = [0, 1, 2].map(
                #[inline(always)]
                |k| load(simd, &self.dir[k], at),
            );
            let inverse = S::f32s::splat(simd, 1.0) / z;
            let (x, y) = (x / z, y / z);
            least[0] = least[0].min(x);
            most[0] = most[0].max(x);
            least[1] = least[1].min(y);
            most[1] = most[1].max(y);
            let origin = load(simd, &self.origin[2], at);
            least[2] = least[2].min(origin);
            most[2] = most[2].max(origin);
            store::<S>(-x, &mut self.slope[0], at);
            store::<S>(-y, &mut self.slope[1], at);
            store::<S>(inverse, &mut self.inverse, at);
            store::<S>(z.abs(), &mut self.stride, at);
        }
        let [z_low, z_high] = [fold::<S>(least[2], smallest), fold::<S>(most[2], largest)];
        self.depths = [z_low - self.slack, z_high + self.slack];
        self.zeta = (z_low + z_high) * 0.5;
        let zeta = S::f32s::splat(simd, self.zeta);
        for k in 0..2 {
            let slopes = [fold::<S>(least[k], smallest), fold::<S>(most[k], largest)];
            let [s0, s1] = if self.sense > 0.0 {
                slopes
            } else {
                [slopes[1], slopes[0]]
            };
            let mut low = [infinity; 3];
            let mut high = [-infinity; 3];
            for at in (0..self.padded).step_by(lanes::<S>()) {
                let x = load(simd, &self.origin[k], at);
                let z = load(simd, &self.origin[2], at) - zeta;
                let own = load(simd, &self.slope[k], at).mul_add(z, x);
                low[0] = low[0].min(x - S::f32s::splat(simd, s0) * z);
                high[0] = high[0].max(x - S::f32s::splat(simd, s1) * z);
                low[1] = low[1].min(own);
                high[1] = high[1].max(own);
                low[2] = low[2].min(x);
                high[2] = high[2].max(x);
            }
            let (low, high) = (
                low.map(
                    #[inline(always)]
                    |low| fold::<S>(low, smallest),
                ),
                high.map(
                    #[inline(always)]
                    |high| fold::<S>(high, largest),
                ),
            );
            let near_bounds = [low[0] - self.slack, high[0] + self.slack];
            self.sheets[k] = Sheet {
                slopes: [s0, s1],
                bounds: [
                    near_bounds[0] - s0 * self.zeta - self.slack,
                    near_bounds[1] - s1 * self.zeta + self.slack,
                ],
                near_bounds,
                ahead: [
                    if self.sense * s0 > 0.0 {
                        low[2] - self.slack
                    } else {
                        f32::NEG_INFINITY
                    },
                    if self.sense * s1 < 0.0 {
                        high[2] + self.slack
                    } else {
                        f32::INFINITY
                    },
                ],
                origins: [low[1], high[1]],
            };
        }
        self.look_ahead(simd);
    }

    /// Brings up to date how far the rays look.
    #[inline(always)]
    fn look_ahead<S: Lanes>(&mut self, simd: S) {
        let mut far = S::f32s::splat(simd, 0.0);
        for at in (0..self.padded).step_by(lanes::<S>()) {
            far = far.max(load(simd, &self.high, at) * load(simd, &self.stride, at));
        }
        // The product and the slack are rounded.
        self.far = fold::<S>(far, largest) * (1.0 + 4.0 * ROUNDOFF) + self.slack;
    }

    /// Finds the nearest hits of the rays that were taken, all out of the window `rays`; how much work it was, about
    /// one for a triangle and eight rays. Gives up when it is more than `patience`.
    #[inline(always)]
    pub fn trace<S: Lanes>(
        &mut self,
        simd: S,
        tree: &RayTree,
        rays: &[Ray],
        stack: &mut Stack,
        patience: usize,
    ) -> Option<usize> {
        let mut work = 0;
        let mut depth = 0;
        let mut child = Child::node(0);
        loop {
            if child.is_leaf() {
                work += self.leaf(simd, tree, child.index(), rays);
                if work > patience {
                    return None;
                }
            } else {
                let node = &tree.nodes[child.index()];
                let (near, mut met) = self.meet(simd, node);
                work += NODE_WORK;
                if met != 0 {
                    stack.reserve(depth);
                    depth = push(&mut stack.0, depth, &node.children, &near, &mut met);
                    child = Child(stack.0[depth] as u32);
                    continue;
                }
            }
            let next = loop {
                if depth == 0 {
                    break None;
                }
                depth -= 1;
                let entry = stack.0[depth];
                if f32::from_bits((entry >> 32) as u32) <= self.far {
                    break Some(Child(entry as u32));
                }
            };
            match next {
                Some(next) => child = next,
                None => break,
            }
        }
        Some(work)
    }

    /// Writes what its rays hit, all out of the window `rays`.
    #[inline(always)]
    pub fn write<S: Lanes>(&self, simd: S, tree: &RayTree, rays: &[Ray], hits: &mut [Hit]) {
        // The axes follow each other in a circle.
        let place = [0, 1, 2].map(|axis| (axis + 3 - self.axes[0]) % 3);
        let rows = HitRows {
            origin: place.map(|k| &self.origin[k]),
            dir: place.map(|k| &self.dir[k]),
            slot: &self.slot,
        };
        for at in (0..self.count).step_by(lanes::<S>()) {
            let (t, certain) = rows.distances(simd, tree, at);
            let index = &self.index[at..self.count.min(at + lanes::<S>())];
            for (lane, &index) in index.iter().enumerate() {
                let index = usize::from(index);
                let slot = self.slot[at + lane];
                hits[index] = if slot == MISS {
                    Hit::NONE
                } else if certain >> lane & 1 != 0 {
                    let id = tree.file_id(slot);
                    Hit { id, t: t[lane] }
                } else {
                    hit(tree, &rays[index], slot)
                };
            }
        }
    }

    #[inline(always)]
    fn nearest(&self, i: usize) -> Nearest {
        Nearest {
            low: self.low[i % MOST],
            high: self.high[i % MOST],
            slot: self.slot[i % MOST],
        }
    }

    /// How far along z′ each child's box is at least, and which of them the beam may meet.
    #[inline(always)]
    fn meet<S: Lanes>(&self, simd: S, node: &RayNode) -> ([f32; 8], u32) {
        macro_rules! row {
            ($row:expr) => {
                f32x8::load_array_ref(simd, &node.bounds[$row % 6])
            };
        }
        let [ax, ay, az] = self.axes;
        let (z_low, z_high) = (row!(az), row!(az + 3));
        let (near, mut met) = if self.sense > 0.0 {
            (
                z_low - f32x8::splat(simd, self.depths[1]),
                z_high.simd_ge(self.depths[0]),
            )
        } else {
            (
                f32x8::splat(simd, self.depths[0]) - z_high,
                z_low.simd_le(self.depths[1]),
            )
        };
        let near = near.max(f32x8::splat(simd, 0.0));
        met &= near.simd_le(self.far);
        for (axis, sheet) in [(ax, &self.sheets[0]), (ay, &self.sheets[1])] {
            let [s0, s1] = sheet.slopes;
            let z0 = if s0 > 0.0 { z_low } else { z_high };
            let z1 = if s1 > 0.0 { z_high } else { z_low };
            let (x_low, x_high) = (row!(axis), row!(axis + 3));
            met &= x_high.simd_ge(sheet.ahead[0]) & x_low.simd_le(sheet.ahead[1]);
            let above = f32x8::splat(simd, -s0).mul_add(z0, x_high);
            let below = f32x8::splat(simd, -s1).mul_add(z1, x_low);
            met &= above.simd_ge(sheet.bounds[0]) & below.simd_le(sheet.bounds[1]);
        }
        let mut distances = [0.0; 8];
        near.store_array(&mut distances);
        (distances, met.to_bitmask() as u32)
    }

    /// Lets all rays look at the triangles of a block that the beam may meet.
    #[inline(always)]
    fn leaf<S: Lanes>(&mut self, simd: S, tree: &RayTree, block: usize, rays: &[Ray]) -> usize {
        let of_block = &tree.blocks[block];
        let sifted = self.sift(simd, of_block);
        let work = BLOCK_WORK + sifted.met.count_ones() as usize * (self.padded / 8);
        let mut nearer = false;
        let mut left = sifted.met;
        while left != 0 {
            let lane = left.trailing_zeros() as usize % LANES;
            left &= left - 1;
            let this = Candidate {
                slot: (block * LANES + lane) as u32,
                corners: self
                    .axes
                    .map(|axis| [0, 1, 2].map(|corner| of_block.corners[corner][axis % 3][lane])),
                error: sifted.errors[lane],
                reach: sifted.reaches[lane],
            };
            nearer |= if sifted.across >> lane & 1 != 0 {
                self.pass(simd, tree, &this, rays)
            } else {
                self.triangle(simd, tree, &this, rays)
            };
        }
        if nearer {
            self.look_ahead(simd);
        }
        work
    }

    /// Lets all rays look at one triangle; whether it is nearer for any.
    #[inline(always)]
    fn triangle<S: Lanes>(
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
    fn pass<S: Lanes>(&mut self, simd: S, tree: &RayTree, this: &Candidate, rays: &[Ray]) -> bool {
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
