//! What one ray does in a [`RayTree`]: it looks into a leaf, or goes all the way down from some node.

use super::Ray;
use super::block::{Found, Sheared};
use super::ready::{AXES, Nearest, Ready};
use super::rule::{self, Meeting};
use super::tree::{RayNode, RayTree};
use super::walk::{Stack, push};
use crate::bvh::Child;
use crate::frame::{Hit, MISS};
use crate::simd::{Lanes, SimdBase, SimdFloat, SimdMask, f32x8};

/// A ray's slabs in all lanes.
#[derive(Clone, Copy, Debug)]
pub struct Slabs<S: Lanes> {
    inverse: [f32x8<S>; 3],
    near_offset: [f32x8<S>; 3],
    far_offset: [f32x8<S>; 3],
}

/// Rows of the sides of [`RayNode::bounds`] that rays of one octant (bits 0, 1, 2: goes down along x, y, z) meet first,
/// and last.
#[derive(Clone, Copy, Debug)]
pub struct Sides {
    near: [usize; 3],
    far: [usize; 3],
}

impl Sides {
    pub fn of_octant(octant: usize) -> Sides {
        let near = [0, 1, 2].map(|k| k + 3 * (octant >> k & 1));
        Sides {
            near,
            far: [3 - near[0], 5 - near[1], 7 - near[2]],
        }
    }
}

/// The boxes of a node's children: their near and far sides along each axis. Loaded before rays visit the node, since
/// no compiler can know that what is written meanwhile is not the node.
#[derive(Clone, Copy, Debug)]
pub struct Boxes<S: Lanes> {
    near: [f32x8<S>; 3],
    far: [f32x8<S>; 3],
}

impl<S: Lanes> Boxes<S> {
    #[inline(always)]
    pub fn new(simd: S, node: &RayNode, sides: &Sides) -> Boxes<S> {
        macro_rules! rows {
            ($of:expr) => {
                [
                    f32x8::load_array_ref(simd, &node.bounds[$of[0]]),
                    f32x8::load_array_ref(simd, &node.bounds[$of[1]]),
                    f32x8::load_array_ref(simd, &node.bounds[$of[2]]),
                ]
            };
        }
        Boxes {
            near: rows!(sides.near),
            far: rows!(sides.far),
        }
    }
}

impl<S: Lanes> Slabs<S> {
    #[inline(always)]
    pub fn new(simd: S, ray: &Ready) -> Slabs<S> {
        macro_rules! splat {
            ($row:expr) => {
                [
                    f32x8::splat(simd, $row[0]),
                    f32x8::splat(simd, $row[1]),
                    f32x8::splat(simd, $row[2]),
                ]
            };
        }
        Slabs {
            inverse: splat!(ray.inverse),
            near_offset: splat!(ray.near_offset),
            far_offset: splat!(ray.far_offset),
        }
    }

    /// Where the ray enters each child's box, and which of them it meets not beyond `far`.
    #[inline(always)]
    pub fn meet(&self, simd: S, boxes: &Boxes<S>, far: f32) -> (f32x8<S>, u32) {
        let mut enter = f32x8::splat(simd, 0.0);
        let mut leave = f32x8::splat(simd, far);
        for k in 0..3 {
            enter = enter.max(self.inverse[k].mul_add(boxes.near[k], self.near_offset[k]));
            leave = leave.min(self.inverse[k].mul_add(boxes.far[k], self.far_offset[k]));
        }
        (enter, enter.simd_le(leave).to_bitmask() as u32)
    }
}

impl Ready {
    /// In all lanes.
    #[inline(always)]
    pub fn sheared<S: Lanes>(&self, simd: S) -> Sheared<S> {
        macro_rules! splat {
            ($x:expr) => {
                f32x8::splat(simd, $x)
            };
        }
        let [x, y, z] = self.origin;
        Sheared {
            axes: AXES[self.longest as usize % 3],
            origin: [splat!(x), splat!(y), splat!(z)],
            shear: [splat!(self.shear[0]), splat!(self.shear[1])],
            inverse: splat!(self.inverse_z),
        }
    }

    /// Looks at the triangles of a block; `ray` is this ray as it came.
    ///
    /// Whether a ray hits something is anybody's guess, so the usual case goes without a branch.
    #[inline(always)]
    pub fn look<S: Lanes>(
        &mut self,
        simd: S,
        tree: &RayTree,
        block: usize,
        sheared: &Sheared<S>,
        ray: &Ray,
    ) {
        let found = tree.blocks[block].look(simd, sheared, self.nearest.high);
        let lane = found.sure.trailing_zeros() as usize % 8;
        let (low, high) = (found.low[lane], found.high[lane]);
        let alone = found.sure.is_power_of_two() & (high < self.nearest.low) & (low >= self.t_min);
        let slot = (block * 8 + lane) as u32;
        self.nearest = [self.nearest, Nearest { low, high, slot }][usize::from(alone)];
        if (found.doubtful != 0) | (found.sure != 0) & !alone {
            self.look_closer(tree, block, &found, ray);
        }
    }

    /// Takes the triangles that were found one by one.
    #[cold]
    #[inline(never)]
    fn look_closer(&mut self, tree: &RayTree, block: usize, found: &Found, ray: &Ray) {
        let mut left = found.doubtful | found.sure;
        while left != 0 {
            let lane = left.trailing_zeros() as usize % 8;
            left &= left - 1;
            let slot = (block * 8 + lane) as u32;
            let (low, high) = (found.low[lane], found.high[lane]);
            let sure = found.sure >> lane & 1 != 0;
            if slot == self.nearest.slot || sure && low > self.nearest.high {
                continue;
            }
            if sure && high < self.nearest.low && low >= self.t_min {
                self.nearest = Nearest { low, high, slot };
            } else {
                self.nearest = settle(tree, ray, self.nearest, slot);
            }
        }
    }
}

/// A ray that goes on alone, one node or leaf a step.
#[derive(Clone, Debug, Default)]
pub struct Walker {
    /// The ray's number in its stream.
    pub number: u16,
    child: Child,
    stack: Stack,
    depth: usize,
}

impl Walker {
    /// Starts ray `number` at `child`.
    #[inline(always)]
    pub fn start(&mut self, number: u16, child: Child) {
        self.number = number;
        self.child = child;
        self.depth = 0;
    }

    /// Later, after everything else, the ray goes on at `child` as well.
    #[inline(always)]
    pub fn add(&mut self, child: Child) {
        self.stack.reserve(self.depth);
        self.stack.0.copy_within(..self.depth, 1);
        self.stack.0[0] = u64::from(child.0);
        self.depth += 1;
    }

    /// Looks at a node or leaf and asks for the next one; false when there is none.
    #[inline(always)]
    pub fn step<S: Lanes>(
        &mut self,
        simd: S,
        tree: &RayTree,
        sides: &Sides,
        me: &mut Ready,
        ray: &Ray,
    ) -> bool {
        if self.child.is_leaf() {
            let sheared = me.sheared(simd);
            me.look(simd, tree, self.child.index(), &sheared, ray);
        } else {
            let node = &tree.nodes[self.child.index()];
            let slabs = Slabs::new(simd, me);
            let (enter, mut met) =
                slabs.meet(simd, &Boxes::new(simd, node, sides), me.nearest.high);
            if met != 0 {
                let mut near = [0.0; 8];
                enter.store_array(&mut near);
                self.stack.reserve(self.depth);
                let depth = self.depth;
                self.depth = push(&mut self.stack.0, depth, &node.children, &near, &mut met);
                self.child = Child(self.stack.0[self.depth] as u32);
                tree.prefetch(self.child);
                return true;
            }
        }
        while self.depth > 0 {
            self.depth -= 1;
            let entry = self.stack.0[self.depth];
            if f32::from_bits((entry >> 32) as u32) <= me.nearest.high {
                self.child = Child(entry as u32);
                tree.prefetch(self.child);
                return true;
            }
        }
        false
    }
}

/// The distance of a triangle that the ray hits.
#[inline(always)]
fn distance(tree: &RayTree, ray: &Ray, slot: u32) -> f32 {
    Meeting::new(&rule::relative(&tree.corners(slot), ray.origin)).distance(ray)
}

/// What became of a ray that hits the triangle in `slot`: for the few that lanes are not certain of.
#[cold]
#[inline(never)]
pub fn hit(tree: &RayTree, ray: &Ray, slot: u32) -> Hit {
    Hit {
        id: tree.file_id(slot),
        t: distance(tree, ray, slot),
    }
}

/// Lets the exact rule decide between the nearest triangle so far and the one in `slot`.
#[cold]
#[inline(never)]
pub fn settle(tree: &RayTree, ray: &Ray, nearest: Nearest, slot: u32) -> Nearest {
    let triangle = rule::relative(&tree.corners(slot), ray.origin);
    let meeting = Meeting::new(&triangle);
    let t = meeting.distance(ray);
    let counts = ray.t_min <= t && t <= nearest.high && meeting.meets(&triangle, ray.dir);
    if !counts {
        return nearest;
    }
    let this = Nearest {
        low: t,
        high: t,
        slot,
    };
    if nearest.slot == MISS {
        return this;
    }
    let other = distance(tree, ray, nearest.slot);
    if t < other || t == other && tree.file_id(slot) < tree.file_id(nearest.slot) {
        this
    } else {
        Nearest {
            low: other,
            high: other,
            slot: nearest.slot,
        }
    }
}
