//! What a beam finds out about the eight triangles of a block before any of its rays looks at them (lanes are
//! triangles): which ones it misses, and which ones lie across the whole beam.
//!
//! # Intervals
//! Seen along a ray of slope s, a corner p lies at x = (p.x − s·(p.z − ζ)) − (o.x − s·(o.z − ζ)), whatever ζ is; here it is
//! the middle of the origins' depths, so that the second term hardly differs between the rays. The first is linear in s:
//! between its values for the least and the largest slope. So every corner lies in a box of the plane across the rays,
//! x ± r and y ± s, whichever ray looks. The side of an edge, x₀y₁ − y₀x₁, is then off by at most
//! |x₀|s₁ + r₀(|y₁| + s₁) + |y₀|r₁ + s₀(|x₁| + r₁) from that of the middles. Two sides that are certain to differ in
//! sign: no ray meets the triangle. All three certain to agree: the lines of all rays do.
//!
//! All roundings of a coordinate, those of the rule's corners as well, are below 96 roundings of the reach; this is
//! in r and s. The roundings of the middles' products are below 8 roundings of each factor, these as well.

use super::beam::{Beam, STEEP};
use super::block::{Block, LANES, UNDERFLOW, error};
use crate::simd::{Lanes, SimdBase, SimdFloat, SimdMask, f32x8, mask32x8};
use crate::trace::space::ROUNDOFF;

/// Edges are looked at in blocks with a triangle that is wider than the beam by this factor.
const WIDE: f32 = 2.0;

/// What bounds the rays along x′ or y′.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sheet {
    /// Slopes of the two planes by z.
    pub slopes: [f32; 2],
    /// x − slope·z is not below, or not above this.
    pub bounds: [f32; 2],
    /// The same for x − slope·(z − ζ).
    pub near_bounds: [f32; 2],
    /// What is ahead of all rays reaches up to the first number, and down to the second: where all slopes agree in
    /// sign, the origins' own x.
    pub ahead: [f32; 2],
    /// All origins' own x − slope·(z − ζ).
    pub origins: [f32; 2],
    /// All origins' x.
    pub own: [f32; 2],
}

/// What a beam finds out about a block.
#[derive(Clone, Copy, Debug)]
pub struct Sifted {
    /// The triangles that the beam may meet, as bits.
    pub met: u32,
    /// Those that the lines of all rays are certain to pass through.
    pub across: u32,
    /// Those that rays may start on, or next to, and one ray at least goes away from: worth asking whether all do.
    pub beside: u32,
    /// For each a bound of the errors of all rays, E of [`super::block`].
    pub errors: [f32; LANES],
    /// No ray sees a corner farther away than this, in any coordinate.
    pub reaches: [f32; LANES],
}

/// A corner as all rays see it along x′ or y′: within `radius` of `middle`.
#[derive(Clone, Copy)]
struct Spread<S: Lanes> {
    middle: f32x8<S>,
    size: f32x8<S>,
    radius: f32x8<S>,
}

impl Beam {
    /// Looks at the triangles of a block.
    #[inline(always)]
    pub fn sift<S: Lanes>(&self, simd: S, block: &Block) -> Sifted {
        macro_rules! splat {
            ($x:expr) => {
                f32x8::splat(simd, $x)
            };
        }
        macro_rules! row {
            ($corner:expr, $axis:expr) => {
                f32x8::load_array_ref(simd, &block.corners[$corner][$axis])
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
        let mut beside = z_low.simd_le(o_high) & z_high.simd_ge(o_low);
        let depth = (z_high - splat!(o_low)).max(splat!(o_high) - z_low);
        let zeta = splat!(self.zeta);
        let z = [z[0] - zeta, z[1] - zeta, z[2] - zeta];
        let mut size = splat!(0.0);
        let mut wide = met;
        macro_rules! see {
            ($axis:expr, $sheet:expr) => {{
                let sheet = $sheet;
                let (s0, s1) = (splat!(-sheet.slopes[0]), splat!(-sheet.slopes[1]));
                let (o_low, o_high) = (splat!(sheet.origins[0]), splat!(sheet.origins[1]));
                let x = [row!(0, $axis), row!(1, $axis), row!(2, $axis)];
                let x_low = x[0].min(x[1]).min(x[2]);
                let x_high = x[0].max(x[1]).max(x[2]);
                met &= x_high.simd_ge(sheet.ahead[0]) & x_low.simd_le(sheet.ahead[1]);
                beside &= x_high.simd_ge(sheet.own[0]) & x_low.simd_le(sheet.own[1]);
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
                met &= above.simd_ge(sheet.near_bounds[0]) & below.simd_le(sheet.near_bounds[1]);
                let highest = above.max(b[0]).max(b[1]).max(b[2]);
                let lowest = below.min(a[0]).min(a[1]).min(a[2]);
                size = size.max(highest - o_low).max(o_high - lowest);
                let width = (a[0] - b[0]).abs() + (o_high - o_low);
                wide &= (highest - lowest).simd_gt(width * splat!(WIDE));
                (a, b, o_low, o_high)
            }};
        }
        let x = see!(ax, &self.sheets[0]);
        let y = see!(ay, &self.sheets[1]);
        beside &= met;
        if beside.to_bitmask() != 0 {
            let x = [row!(0, ax), row!(1, ax), row!(2, ax)];
            let y = [row!(0, ay), row!(1, ay), row!(2, ay)];
            beside &= self.first_leaves(simd, x, y, z);
        }
        let size = size + splat!(self.slack);
        let steep = depth * splat!(STEEP);
        let mut sifted = Sifted {
            met: met.to_bitmask() as u32,
            across: 0,
            beside: beside.to_bitmask() as u32,
            errors: [0.0; LANES],
            reaches: [0.0; LANES],
        };
        error(simd, size, steep).store_array(&mut sifted.errors);
        (size + steep).store_array(&mut sifted.reaches);
        if (met & wide).to_bitmask() == 0 {
            return sifted;
        }
        macro_rules! spread {
            ($x:expr) => {{
                let (a, b, o_low, o_high) = &$x;
                macro_rules! corner {
                    ($i:expr) => {{
                        let low = a[$i].min(b[$i]) - *o_high;
                        let high = a[$i].max(b[$i]) - *o_low;
                        let middle = (low + high) * splat!(0.5);
                        let size = middle.abs();
                        let radius = (high - low).mul_add(splat!(0.5), splat!(self.slack));
                        let radius = size.mul_add(splat!(8.0 * ROUNDOFF), radius);
                        Spread::<S> {
                            middle,
                            size,
                            radius,
                        }
                    }};
                }
                [corner!(0), corner!(1), corner!(2)]
            }};
        }
        let (x, y) = (spread!(x), spread!(y));
        macro_rules! side {
            ($i:expr, $j:expr) => {{
                let (x0, y0, x1, y1) = (&x[$i], &y[$i], &x[$j], &y[$j]);
                let side = x0.middle.mul_sub(y1.middle, y0.middle * x1.middle);
                let off = x0.size.mul_add(y1.radius, splat!(UNDERFLOW));
                let off = x0.radius.mul_add(y1.size + y1.radius, off);
                let off = y0.size.mul_add(x1.radius, off);
                let off = y0.radius.mul_add(x1.size + x1.radius, off);
                (side, off * splat!(1.0 + 16.0 * ROUNDOFF))
            }};
        }
        let (side0, off0) = side!(1, 2);
        let (side1, off1) = side!(2, 0);
        let (side2, off2) = side!(0, 1);
        let least = (side0 - off0).min(side1 - off1).min(side2 - off2);
        let most = (side0 + off0).max(side1 + off1).max(side2 + off2);
        let all_up = least.simd_gt(0.0);
        let all_down = most.simd_lt(0.0);
        let one_up = (side0 - off0)
            .max(side1 - off1)
            .max(side2 - off2)
            .simd_gt(0.0);
        let one_down = (side0 + off0)
            .min(side1 + off1)
            .min(side2 + off2)
            .simd_lt(0.0);
        let met = met & !(one_up & one_down);
        sifted.met = met.to_bitmask() as u32;
        sifted.across = ((all_up | all_down) & met).to_bitmask() as u32;
        sifted
    }

    /// Whether the first ray seems to go away from each triangle's plane. z is less ζ.
    #[inline(always)]
    fn first_leaves<S: Lanes>(
        &self,
        simd: S,
        x: [f32x8<S>; 3],
        y: [f32x8<S>; 3],
        z: [f32x8<S>; 3],
    ) -> mask32x8<S> {
        macro_rules! splat {
            ($x:expr) => {
                f32x8::splat(simd, $x)
            };
        }
        let (px, py, pz) = (x[1] - x[0], y[1] - y[0], z[1] - z[0]);
        let (qx, qy, qz) = (x[2] - x[0], y[2] - y[0], z[2] - z[0]);
        let nx = py.mul_sub(qz, pz * qy);
        let ny = pz.mul_sub(qx, px * qz);
        let nz = px.mul_sub(qy, py * qx);
        let x = x[0] - splat!(self.origin[0][0]);
        let y = y[0] - splat!(self.origin[1][0]);
        let z = z[0] - splat!(self.origin[2][0] - self.zeta);
        let whole = nx.mul_add(x, ny.mul_add(y, nz * z));
        let [x, y, z] = [&self.dir[0], &self.dir[1], &self.dir[2]];
        let (x, y, z) = (splat!(x[0]), splat!(y[0]), splat!(z[0]));
        let along = nx.mul_add(x, ny.mul_add(y, nz * z));
        (whole * along).simd_lt(0.0)
    }
}
