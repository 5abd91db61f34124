//! A leaf of [`super::tree`]: eight triangles side by side, and what a ray finds out about them at once.
//!
//! Every vertex is seen along the ray as a point (x, y) of the plane across it, by a shear that needs no square root.
//! There the ray is the point 0, and on which side of an edge it passes is a product of two numbers less another.
//! Source: Woop, Benthin, Wald, "Watertight ray/triangle intersection", 2013. Theirs decides by those numbers; here
//! a bound of their error tells what is certain: that a triangle is missed, or that it is hit between two distances.
//! What is not certain, one triangle in thousands, goes to the exact rule.
//!
//! # The bound
//! u is the roundoff of `f32`, and the corners q relative to the origin are exact: the rule rounds them just so. The
//! shear has |s| ≤ B and is off by 1 rounding; so x = q.x − s·q.z is off by at most δ = 2.1u·B·|q.z| + 1.1u·|x|. Let R
//! bound |q.z|, m the six numbers |x| and |y| of a triangle, and r = BR + m: δ < 2.1u·r. A side x₀y₁ − y₀x₁ is off
//! by 4mδ + 2δ² from them, and by 4um² from its own three roundings; together less than **E = 10u·r·(m + 10u·r)**.
//!
//! The distance is (Σ side·q.z) / (Σ side), each corner with the side across from it. With errors E of the sides it is
//! off by less than 6E·R / |Σ side|, with all roundings by less than R·(6.5E / |Σ side| + 16u). B is 1 for a ray
//! alone, since z is its longest axis.

use crate::simd::Lanes;
use crate::simd::{SimdBase, SimdFloat, SimdMask, f32x8};
use crate::trace::space::ROUNDOFF;

/// Triangles of a block.
pub const LANES: usize = 8;

/// Below this, products of two numbers lose bits to underflow.
pub const UNDERFLOW: f32 = 1e-36;

/// Up to eight triangles. 320 bytes.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub struct Block {
    /// By corner, then axis; not a number where there is no triangle.
    pub corners: [[[f32; LANES]; 3]; 3],
    /// The triangles' numbers in the file; [`crate::frame::MISS`] where there is none.
    pub ids: [u32; LANES],
}

/// A ray as the test of a block needs it.
#[derive(Clone, Copy, Debug)]
pub struct Sheared<S: Lanes> {
    /// The axes x, y, z (0..3) in the order x′, y′, z′: z′ is the one along which the direction is longest.
    pub axes: [usize; 3],
    /// In that order.
    pub origin: [f32x8<S>; 3],
    /// Of x′ and y′ for each z′, with the sign turned.
    pub shear: [f32x8<S>; 2],
    /// 1 / direction along z′.
    pub inverse: f32x8<S>,
}

/// What a ray finds out about a block.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    /// The lanes' triangles that may be the nearest hit, but are not certain to be hit, as bits.
    pub doubtful: u32,
    /// Those that are hit for certain, perhaps not beyond the nearest hit so far.
    pub sure: u32,
    /// Where so: bounds of the distance.
    pub low: [f32; LANES],
    pub high: [f32; LANES],
}

impl Block {
    /// Looks at all triangles. `far`: the nearest hit so far is not beyond.
    #[inline(always)]
    pub fn look<S: Lanes>(&self, simd: S, ray: &Sheared<S>, far: f32) -> Found {
        let [ax, ay, az] = ray.axes;
        macro_rules! relative {
            ($corner:expr, $axis:expr, $at:expr) => {
                f32x8::load_array_ref(simd, &self.corners[$corner][$axis]) - ray.origin[$at]
            };
        }
        macro_rules! point {
            ($corner:expr) => {{
                let z = relative!($corner, az, 2);
                let x = ray.shear[0].mul_add(z, relative!($corner, ax, 0));
                let y = ray.shear[1].mul_add(z, relative!($corner, ay, 1));
                [x, y, z]
            }};
        }
        let [x0, y0, z0] = point!(0);
        let [x1, y1, z1] = point!(1);
        let [x2, y2, z2] = point!(2);
        // Each across from the corner of its number.
        let side0 = x1.mul_sub(y2, y1 * x2);
        let side1 = x2.mul_sub(y0, y2 * x0);
        let side2 = x0.mul_sub(y1, y0 * x1);
        let least = side0.min(side1).min(side2);
        let most = side0.max(side1).max(side2);
        let size = x0.abs().max(x1.abs()).max(x2.abs());
        let size = size.max(y0.abs()).max(y1.abs()).max(y2.abs());
        let depth = z0.abs().max(z1.abs()).max(z2.abs());
        let error = error(simd, size, depth);
        let near = (least + error).simd_ge(0.0) | (most - error).simd_le(0.0);
        let inside = least.simd_gt(error) | (most + error).simd_lt(0.0);
        let sum = f32x8::splat(simd, 1.0) / (side0 + side1 + side2);
        let z = (side0 * sum).mul_add(z0, (side1 * sum).mul_add(z1, (side2 * sum) * z2));
        let margin = (error * sum)
            .abs()
            .mul_add(f32x8::splat(simd, 6.5), f32x8::splat(simd, 16.0 * ROUNDOFF));
        let margin = margin * (depth * ray.inverse).abs();
        let t = z * ray.inverse;
        let (low, high) = (t - margin, t + margin);
        let in_front = low.simd_gt(0.0);
        let sure = inside & in_front & low.simd_le(far);
        // What is inside, and certainly behind the origin or too far, is settled.
        let settled = inside & (in_front | high.simd_lt(0.0));
        let mut found = Found {
            doubtful: (near & !settled).to_bitmask() as u32,
            sure: sure.to_bitmask() as u32,
            low: [0.0; LANES],
            high: [0.0; LANES],
        };
        low.store_array(&mut found.low);
        high.store_array(&mut found.high);
        found
    }
}

/// E, for triangles with `size` m and `depth` BR.
#[inline(always)]
pub fn error<S: Lanes>(simd: S, size: f32x8<S>, depth: f32x8<S>) -> f32x8<S> {
    let r = (depth + size) * f32x8::splat(simd, 10.0 * ROUNDOFF);
    r.mul_add(size + r, f32x8::splat(simd, UNDERFLOW))
}
