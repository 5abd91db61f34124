//! Eight triangles in a row of a cell, and one ray.

use super::frame::Seen;
use crate::simd::{Lanes, SimdBase, SimdFloat, SimdMask, f32x8};
use crate::trace::space::ROUNDOFF;

/// Triangles of a block.
pub const LANES: usize = 8;

/// A point in the frame of the light, x and y from the middle of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Across the light.
    pub x: f32,
    /// Across the light.
    pub y: f32,
    /// Toward it.
    pub z: f32,
}

/// Eight triangles as the light sees them from the middle of their cell, all counter-clockwise.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub struct Block {
    /// Corners a, b, c: x, then y; a row each.
    across: [[f32; LANES]; 6],
    /// z of corner a.
    height: [f32; LANES],
    /// The cross product of the edges from a to b and from a to c.
    normal: [[f32; LANES]; 3],
    /// Numbers in leaf order.
    ids: [u32; LANES],
    /// The highest z.
    top: f32,
    /// How far a corner can be from a ray of the cell, in x or in y.
    spread: f32,
    /// How far another corner's z can be from corner a's.
    depth: f32,
    /// Error of an edge function: times (distance in z + `spread`).
    edge_error: f32,
    /// Error of a height: times the distance in z, times (distance in z + `spread`).
    height_error: f32,
}

/// What a block says of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// No triangle hides it.
    Free,
    /// One does.
    Hidden,
    /// Perhaps those lanes (as bits) do: too close to tell.
    Perhaps(u32),
}

impl Block {
    /// No triangles yet.
    pub const EMPTY: Block = Block {
        across: [[0.0; LANES]; 6],
        height: [0.0; LANES],
        normal: [[0.0; LANES]; 3],
        ids: [0; LANES],
        top: f32::NEG_INFINITY,
        spread: 0.0,
        depth: 0.0,
        edge_error: 0.0,
        height_error: 0.0,
    };

    /// Puts a triangle into lane `lane`, and into those behind it until others come: repeating one changes nothing.
    /// The cell's middle is at `middle` and its sides are `side` long, with room for rounding.
    pub fn put(&mut self, lane: usize, corners: &[Seen; 3], id: u32, middle: [f64; 2], side: f32) {
        let [a, b, c] = *corners;
        let edge = |p: Seen| [p.x - a.x, p.y - a.y, f64::from(p.z) - f64::from(a.z)];
        let ([ux, uy, uz], [vx, vy, vz]) = (edge(b), edge(c));
        let normal = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
        for (row, n) in self.normal.iter_mut().zip(normal) {
            row[lane..].fill(n as f32);
        }
        for (i, p) in corners.iter().enumerate() {
            self.across[i][lane..].fill((p.x - middle[0]) as f32);
            self.across[3 + i][lane..].fill((p.y - middle[1]) as f32);
            self.top = self.top.max(p.z);
        }
        self.height[lane..].fill(a.z);
        self.ids[lane..].fill(id);
        let most = |x: f64, y: f64| x.abs().max(y.abs()) as f32;
        let width = most(ux, vx).max(most(uy, vy)).max(most(ux - vx, uy - vy));
        self.spread = self.spread.max((width + side) * 1.001);
        self.depth = self.depth.max(most(uz, vz) * 1.001);
        // With m the spread, g the largest distance in z and u the unit roundoff, the rule of free rays, the place of
        // a corner and its difference from the ray's each move x and y by at most u(4m + 2g) in all. An edge function
        // is the difference of two products of such numbers: its error is below u·m(18m + 8g);
        // where the rule's rounding turns a triangle round, u·m(24m + 20g).
        self.edge_error = 32.0 * ROUNDOFF * self.spread;
        // And a height, by its three corners' cofactors, is wrong by less than u·m·g(78m + 36g).
        self.height_error = 80.0 * ROUNDOFF * self.spread;
    }

    /// True when all triangles, and those of the blocks behind, lie below a ray's origin.
    #[inline(always)]
    pub fn is_below(&self, z: f32) -> bool {
        self.top <= z
    }

    /// The highest z.
    pub fn top(&self) -> f32 {
        self.top
    }

    /// The triangles' numbers in leaf order; the last one may be there several times.
    pub fn ids(&self) -> &[u32; LANES] {
        &self.ids
    }

    /// The triangle's number in leaf order.
    #[inline(always)]
    pub fn id(&self, lane: usize) -> usize {
        self.ids[lane & 7] as usize
    }

    /// Whether one of the triangles hides the light from `place`.
    #[inline(always)]
    pub fn test<S: Lanes>(&self, simd: S, place: Place) -> Answer {
        macro_rules! splat {
            ($x:expr) => {
                f32x8::splat(simd, $x)
            };
        }
        macro_rules! from {
            ($row:expr, $origin:expr) => {
                f32x8::load_array_ref(simd, &self.across[$row]) - $origin
            };
        }
        let (x, y) = (splat!(place.x), splat!(place.y));
        let (xa, xb, xc) = (from!(0, x), from!(1, x), from!(2, x));
        let (ya, yb, yc) = (from!(3, y), from!(4, y), from!(5, y));
        let za = f32x8::load_array_ref(simd, &self.height) - splat!(place.z);
        // Fused: this only sorts out, and less rounding is within the bounds too.
        let ab = xa.mul_sub(yb, ya * xb);
        let bc = xb.mul_sub(yc, yb * xc);
        let ca = xc.mul_sub(ya, yc * xa);
        let edge = ab.min(bc.min(ca));
        let normal = |k: usize| f32x8::load_array_ref(simd, &self.normal[k]);
        let height = normal(0).mul_add(xa, normal(1).mul_add(ya, normal(2) * za));
        let far = za.abs() + splat!(self.depth);
        let reach = far + splat!(self.spread);
        let edge_error = reach * splat!(self.edge_error);
        let height_error = reach * (far * splat!(self.height_error));
        let zero = splat!(0.0);
        let perhaps = (edge + edge_error).simd_ge(zero) & (height + height_error).simd_ge(zero);
        let perhaps = perhaps.to_bitmask() as u32;
        if perhaps == 0 {
            return Answer::Free;
        }
        let surely = edge.simd_gt(edge_error) & height.simd_gt(height_error);
        if surely.to_bitmask() != 0 {
            return Answer::Hidden;
        }
        Answer::Perhaps(perhaps)
    }
}
