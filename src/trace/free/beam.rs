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
use super::block::LANES;
use super::distances::HitRows;
use super::look::Candidate;
use super::ready::Nearest;
use super::sift::Sheet;
use super::tree::{RayNode, RayTree};
use super::walk::{Stack, push};
use super::window::{MOST, Row, Window, main_axes};
use crate::bvh::Child;
use crate::frame::{Hit, MISS};
use crate::simd::{
    Lanes, Select, SimdBase, SimdFloat, SimdMask, all_lanes, f32x8, lanes, load, store,
};
use crate::trace::space::ROUNDOFF;

/// The steepest slope.
pub const STEEP: f32 = 2.0;

/// What a node and a block cost, in tests of a triangle by eight rays.
const NODE_WORK: usize = 3;
const BLOCK_WORK: usize = 4;

/// All rays of a window.
const ALL: [u32; MOST] = {
    let mut index = [0; MOST];
    let mut i = 0;
    while i < MOST {
        index[i] = i as u32;
        i += 1;
    }
    index
};

/// Some rays and what bounds them.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct Beam {
    /// Rays, and how many numbers a row has: whole vectors of any width.
    pub count: usize,
    pub padded: usize,
    pub origin: [Row; 3],
    pub dir: [Row; 3],
    /// Minus the slopes along x′ and y′.
    pub slope: [Row; 2],
    /// 1 / direction along z′.
    pub inverse: Row,
    /// The direction along z′, without its sign.
    stride: Row,
    pub t_min: Row,
    pub low: Row,
    pub high: Row,
    pub slot: [u32; MOST],
    /// Which ray of the window it is.
    pub index: [u32; MOST],
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
            self.gather(simd, window, members, seed);
        }
        self.high = self.low;
        self.bound(simd);
    }

    /// Moves the `members` together. Places that are left over repeat ray `seed`, one of them.
    #[inline(always)]
    fn gather<S: Lanes>(&mut self, simd: S, window: &Window, members: u64, seed: usize) {
        let [x, y, z] = self.axes;
        // Row by row: where from, where to. No loop over them: it may not be unrolled.
        macro_rules! each_row {
            ($work:ident) => {
                $work!(window.origin[x], self.origin[0]);
                $work!(window.origin[y], self.origin[1]);
                $work!(window.origin[z], self.origin[2]);
                $work!(window.dir[x], self.dir[0]);
                $work!(window.dir[y], self.dir[1]);
                $work!(window.dir[z], self.dir[2]);
                $work!(window.t_min, self.t_min);
                $work!(window.t_max, self.low);
            };
        }
        let mut end = 0;
        for at in (0..MOST).step_by(lanes::<S>()) {
            let of_vector = members >> at & u64::from(all_lanes::<S>());
            if of_vector == 0 {
                continue;
            }
            let mask = S::mask32s::from_bitmask(simd, of_vector);
            // Never beyond the row: no more of them than went by before.
            macro_rules! together {
                ($from:expr, $to:expr) => {
                    store::<S>(load(simd, &$from, at).compress(mask), &mut $to, end)
                };
            }
            each_row!(together);
            let numbers = S::u32s::from_slice(simd, &ALL[at..at + lanes::<S>()]);
            numbers
                .compress(mask)
                .store_slice(&mut self.index[end..end + lanes::<S>()]);
            end += of_vector.count_ones() as usize;
        }
        let last = self.padded - lanes::<S>();
        let used = S::mask32s::from_bitmask(simd, (1 << (self.count - last)) - 1);
        macro_rules! pad {
            ($from:expr, $to:expr) => {
                let pad = S::f32s::splat(simd, $from[seed % MOST]);
                store::<S>(used.select(load(simd, &$to, last), pad), &mut $to, last);
            };
        }
        each_row!(pad);
    }

    /// Finds slopes and planes.
    #[inline(always)]
    fn bound<S: Lanes>(&mut self, simd: S) {
        let infinity = S::f32s::splat(simd, f32::INFINITY);
        let mut least = [infinity; 3];
        let mut most = [-infinity; 3];
        for at in (0..self.padded).step_by(lanes::<S>()) {
            let x = load(simd, &self.dir[0], at);
            let y = load(simd, &self.dir[1], at);
            let z = load(simd, &self.dir[2], at);
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
        let [z_low, z_high] = [least[2].reduce_min(), most[2].reduce_max()];
        self.depths = [z_low - self.slack, z_high + self.slack];
        self.zeta = (z_low + z_high) * 0.5;
        let zeta = S::f32s::splat(simd, self.zeta);
        for k in 0..2 {
            let slopes = [least[k].reduce_min(), most[k].reduce_max()];
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
            // No closure for each of the three: it may not be inlined.
            let low = [
                low[0].reduce_min(),
                low[1].reduce_min(),
                low[2].reduce_min(),
            ];
            let high = [
                high[0].reduce_max(),
                high[1].reduce_max(),
                high[2].reduce_max(),
            ];
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
                own: [low[2], high[2]],
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
        self.far = far.reduce_max() * (1.0 + 4.0 * ROUNDOFF) + self.slack;
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

    /// Writes what its rays hit, all out of the window `rays`, where they hit anything.
    #[inline(always)]
    pub fn write<S: Lanes>(&self, simd: S, tree: &RayTree, rays: &[Ray], hits: &mut [Hit]) {
        // The axes follow each other in a circle.
        let [x, y, z] = match self.axes[0] {
            0 => [0, 1, 2],
            1 => [2, 0, 1],
            _ => [1, 2, 0],
        };
        let rows = HitRows {
            origin: [&self.origin[x], &self.origin[y], &self.origin[z]],
            dir: [&self.dir[x], &self.dir[y], &self.dir[z]],
            slot: &self.slot,
        };
        let index = |i: usize| self.index[i % MOST] as usize;
        rows.each_hit(
            simd,
            tree,
            self.count,
            #[inline(always)]
            |i| &rays[index(i)],
            #[inline(always)]
            |i, hit| hits[index(i)] = hit,
        );
    }

    #[inline(always)]
    pub fn nearest(&self, i: usize) -> Nearest {
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
                f32x8::load_array_ref(simd, &node.bounds[$row])
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
                    .map(|axis| [0, 1, 2].map(|corner| of_block.corners[corner][axis][lane])),
                error: sifted.errors[lane],
                reach: sifted.reaches[lane],
            };
            nearer |= if sifted.beside >> lane & 1 != 0 && self.is_behind(simd, &this) {
                false
            } else if sifted.across >> lane & 1 != 0 {
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
}
