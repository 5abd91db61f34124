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
use super::block::{Block, LANES, UNDERFLOW, error};
use super::ready::Nearest;
use super::single::{hit, settle};
use super::tree::{RayNode, RayTree};
use super::walk::{Stack, push};
use super::window::{MOST, Row, Window, fold, main_axes};
use crate::bvh::Child;
use crate::frame::{Hit, MISS};
use crate::simd::{
    Bytes, Lanes, Select, SimdBase, SimdFloat, SimdMask, bits, f32x8, lanes, load, store,
};
use crate::trace::space::ROUNDOFF;

/// The steepest slope.
const STEEP: f32 = 2.0;

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

/// What bounds the rays along x′ or y′.
#[derive(Clone, Copy, Debug, Default)]
struct Sheet {
    /// Slopes of the two planes by z.
    slopes: [f32; 2],
    /// x − slope·z is not below, or not above this.
    bounds: [f32; 2],
    /// All origins' own x − slope·z.
    origins: [f32; 2],
}

/// Some rays and what bounds them.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct Beam {
    /// Rays, and how many numbers a row has: whole vectors of any width.
    count: usize,
    padded: usize,
    origin: [Row; 3],
    /// First the directions; then minus the slopes, and 1 / direction along z′.
    dir: [Row; 3],
    /// The direction along z′, without its sign.
    stride: Row,
    t_min: Row,
    low: Row,
    high: Row,
    slot: [u32; MOST],
    /// Which ray of the window it is.
    index: [u8; MOST],
    axes: [usize; 3],
    /// 1 or −1: the sense of the rays along z′.
    sense: f32,
    sheets: [Sheet; 2],
    /// The origins' z′, least and most.
    depths: [f32; 2],
    slack: f32,
    /// No ray looks farther along z′ than this.
    far: f32,
}

impl Default for Beam {
    fn default() -> Beam {
        Beam {
            count: 0,
            padded: 0,
            origin: [[0.0; MOST]; 3],
            dir: [[0.0; MOST]; 3],
            stride: [0.0; MOST],
            t_min: [0.0; MOST],
            low: [0.0; MOST],
            high: [0.0; MOST],
            slot: [0; MOST],
            index: [0; MOST],
            axes: [0; 3],
            sense: 1.0,
            sheets: [Sheet {
                slopes: [0.0; 2],
                bounds: [0.0; 2],
                origins: [0.0; 2],
            }; 2],
            depths: [0.0; 2],
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
        self.slack = window.reach * (64.0 * ROUNDOFF);
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
            store::<S>(-x, &mut self.dir[0], at);
            store::<S>(-y, &mut self.dir[1], at);
            store::<S>(inverse, &mut self.dir[2], at);
            store::<S>(z.abs(), &mut self.stride, at);
        }
        for k in 0..2 {
            let slopes = [fold::<S>(least[k], f32::min), fold::<S>(most[k], f32::max)];
            let [s0, s1] = if self.sense > 0.0 {
                slopes
            } else {
                [slopes[1], slopes[0]]
            };
            let mut low = [infinity; 2];
            let mut high = [-infinity; 2];
            for at in (0..self.padded).step_by(lanes::<S>()) {
                let (x, z) = (
                    load(simd, &self.origin[k], at),
                    load(simd, &self.origin[2], at),
                );
                let own = load(simd, &self.dir[k], at).mul_add(z, x);
                low[0] = low[0].min(x - S::f32s::splat(simd, s0) * z);
                high[0] = high[0].max(x - S::f32s::splat(simd, s1) * z);
                low[1] = low[1].min(own);
                high[1] = high[1].max(own);
            }
            self.sheets[k] = Sheet {
                slopes: [s0, s1],
                bounds: [
                    fold::<S>(low[0], f32::min) - self.slack,
                    fold::<S>(high[0], f32::max) + self.slack,
                ],
                origins: [fold::<S>(low[1], f32::min), fold::<S>(high[1], f32::max)],
            };
        }
        self.depths = [
            fold::<S>(least[2], f32::min) - self.slack,
            fold::<S>(most[2], f32::max) + self.slack,
        ];
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
        self.far = fold::<S>(far, f32::max) * (1.0 + 4.0 * ROUNDOFF) + self.slack;
    }

    /// The nearest hits of the rays that were taken, all out of the window `rays`; and how much work it was, about
    /// one for a triangle and eight rays. Gives up when it is more than `patience`.
    #[inline(always)]
    pub fn trace<S: Lanes>(
        &mut self,
        simd: S,
        tree: &RayTree,
        rays: &[Ray],
        hits: &mut [Hit],
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
        for (i, &index) in self.index[..self.count].iter().enumerate() {
            let index = usize::from(index);
            hits[index] = hit(tree, &rays[index], self.nearest(i));
        }
        Some(work)
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
            let above = f32x8::splat(simd, -s0).mul_add(z0, row!(axis + 3));
            let below = f32x8::splat(simd, -s1).mul_add(z1, row!(axis));
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
        let (mut left, errors) = self.sort_out(simd, of_block);
        let work = BLOCK_WORK + left.count_ones() as usize * (self.padded / 8);
        let mut nearer = false;
        while left != 0 {
            let lane = left.trailing_zeros() as usize % LANES;
            left &= left - 1;
            let slot = (block * LANES + lane) as u32;
            nearer |= self.triangle(simd, tree, of_block, lane, slot, errors[lane], rays);
        }
        if nearer {
            self.look_ahead(simd);
        }
        work
    }

    /// The triangles that the beam may meet, as bits; and for each of the eight a bound for all rays, E of
    /// [`super::block`].
    #[inline(always)]
    fn sort_out<S: Lanes>(&self, simd: S, block: &Block) -> (u32, [f32; LANES]) {
        macro_rules! splat {
            ($x:expr) => {
                f32x8::splat(simd, $x)
            };
        }
        macro_rules! row {
            ($corner:expr, $axis:expr) => {
                f32x8::load_array_ref(simd, &block.corners[$corner][$axis % 3])
            };
        }
        let [ax, ay, az] = self.axes;
        let z = [row!(0, az), row!(1, az), row!(2, az)];
        let z_low = z[0].min(z[1]).min(z[2]);
        let z_high = z[0].max(z[1]).max(z[2]);
        let [o_low, o_high] = self.depths;
        let (near, mut met) = if self.sense > 0.0 {
            (z_low - splat!(o_high), z_high.simd_ge(o_low))
        } else {
            (splat!(o_low) - z_high, z_low.simd_le(o_high))
        };
        met &= near.simd_le(self.far);
        let depth = (z_high - splat!(o_low)).max(splat!(o_high) - z_low);
        let mut size = splat!(0.0);
        for (axis, sheet) in [(ax, &self.sheets[0]), (ay, &self.sheets[1])] {
            let x = [row!(0, axis), row!(1, axis), row!(2, axis)];
            let [s0, s1] = sheet.slopes.map(
                #[inline(always)]
                |s| splat!(-s),
            );
            let a = [
                s0.mul_add(z[0], x[0]),
                s0.mul_add(z[1], x[1]),
                s0.mul_add(z[2], x[2]),
            ];
            let b = [
                s1.mul_add(z[0], x[0]),
                s1.mul_add(z[1], x[1]),
                s1.mul_add(z[2], x[2]),
            ];
            let above = a[0].max(a[1]).max(a[2]);
            let below = b[0].min(b[1]).min(b[2]);
            met &= above.simd_ge(sheet.bounds[0]) & below.simd_le(sheet.bounds[1]);
            let highest = above.max(b[0]).max(b[1]).max(b[2]);
            let lowest = below.min(a[0]).min(a[1]).min(a[2]);
            size = size
                .max(highest - splat!(sheet.origins[0]))
                .max(splat!(sheet.origins[1]) - lowest);
        }
        let size = size + splat!(self.slack);
        let error = error(simd, size, depth * splat!(STEEP));
        let mut errors = [0.0; LANES];
        error.store_array(&mut errors);
        (met.to_bitmask() as u32, errors)
    }

    /// Lets all rays look at one triangle; whether it is nearer for any. `error`: see [`Beam::sort_out`].
    #[inline(always)]
    #[expect(
        clippy::too_many_arguments,
        reason = "one triangle, in its block and in the tree"
    )]
    fn triangle<S: Lanes>(
        &mut self,
        simd: S,
        tree: &RayTree,
        block: &Block,
        lane: usize,
        slot: u32,
        error: f32,
        rays: &[Ray],
    ) -> bool {
        macro_rules! splat {
            ($x:expr) => {
                S::f32s::splat(simd, $x)
            };
        }
        macro_rules! corner {
            ($corner:expr) => {{
                let rows = &block.corners[$corner];
                [
                    splat!(rows[self.axes[0] % 3][lane]),
                    splat!(rows[self.axes[1] % 3][lane]),
                    splat!(rows[self.axes[2] % 3][lane]),
                ]
            }};
        }
        let (p, q, r) = (corner!(0), corner!(1), corner!(2));
        let error = splat!(error);
        let mut nearer = false;
        for at in (0..self.padded).step_by(lanes::<S>()) {
            let [ox, oy, oz] = [
                load(simd, &self.origin[0], at),
                load(simd, &self.origin[1], at),
                load(simd, &self.origin[2], at),
            ];
            let (sx, sy) = (load(simd, &self.dir[0], at), load(simd, &self.dir[1], at));
            macro_rules! seen {
                ($p:expr) => {{
                    let z = $p[2] - oz;
                    [sx.mul_add(z, $p[0] - ox), sy.mul_add(z, $p[1] - oy), z]
                }};
            }
            let [x0, y0, z0] = seen!(p);
            let [x1, y1, z1] = seen!(q);
            let [x2, y2, z2] = seen!(r);
            let side0 = x1.mul_sub(y2, y1 * x2);
            let side1 = x2.mul_sub(y0, y2 * x0);
            let side2 = x0.mul_sub(y1, y0 * x1);
            let least = side0.min(side1).min(side2);
            let most = side0.max(side1).max(side2);
            let near = (least + error).simd_ge(0.0) | (most - error).simd_le(0.0);
            if bits::<S>(near) == 0 {
                continue;
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
            let inverse = load(simd, &self.dir[2], at);
            let margin = (error * sum)
                .abs()
                .mul_add(splat!(6.5), splat!(16.0 * ROUNDOFF));
            let margin = margin * (depth * inverse).abs();
            let t = z * inverse;
            let (low, high) = (t - margin, t + margin);
            let in_front = low.simd_gt(0.0);
            let (was_low, was_high) = (load(simd, &self.low, at), load(simd, &self.high, at));
            let sure = inside & in_front & low.simd_le(was_high);
            let settled = inside & (in_front | high.simd_lt(0.0));
            let wins = sure & high.simd_lt(was_low) & low.simd_ge(load(simd, &self.t_min, at));
            let open = bits::<S>((near & !settled) | (sure & !wins));
            if bits::<S>(wins) != 0 {
                nearer = true;
                store::<S>(wins.select(low, was_low), &mut self.low, at);
                store::<S>(wins.select(high, was_high), &mut self.high, at);
                let slots = &mut self.slot[at..at + lanes::<S>()];
                let was: S::f32s = S::u32s::from_slice(simd, slots).bitcast();
                let this: S::f32s = S::u32s::splat(simd, slot).bitcast();
                wins.select(this, was)
                    .bitcast::<S::u32s>()
                    .store_slice(slots);
            }
            if open != 0 {
                nearer |= self.settle(tree, slot, at, open, rays);
            }
        }
        nearer
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
