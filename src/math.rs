//! Helpers on glam types whose results are the same on every platform: rotations, random numbers.
//!
//! glam's own rotation constructors call the system's `sin` and `cos`; a camera built with them would
//! differ by a bit from machine to machine, and so would the picture. These take both from `libm`.

use glam::{DMat3, DVec3, Vec3};

/// A world axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Axis {
    /// `<x`
    X,
    /// `<y`
    Y,
    /// `<z`
    Z,
}

/// The rotation about a world axis by `angle_rad` radians, right-handed.
#[must_use]
pub fn rotation(axis: Axis, angle_rad: f64) -> DMat3 {
    let (s, c) = libm::sincos(angle_rad);
    // Columns are the images of x, y and z.
    match axis {
        Axis::X => DMat3::from_cols(DVec3::X, DVec3::new(0.0, c, s), DVec3::new(0.0, -s, c)),
        Axis::Y => DMat3::from_cols(DVec3::new(c, 0.0, -s), DVec3::Y, DVec3::new(s, 0.0, c)),
        Axis::Z => DMat3::from_cols(DVec3::new(c, s, 0.0), DVec3::new(-s, c, 0.0), DVec3::Z),
    }
}

/// The largest power of two that is not above `x` (finite, positive), as a factor that scales without rounding.
#[must_use]
pub fn power_of_two_below(x: f64) -> f64 {
    debug_assert!(x.is_finite() && x > 0.0, "needs a positive finite number");
    libm::exp2(f64::from(libm::ilogb(x)))
}

/// A small generator of random numbers whose stream is the same everywhere: SplitMix64.
/// For generated scenes and tests. Source: Steele, Lea, Flood, "Fast splittable pseudorandom number generators", 2014.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// The stream of a seed.
    #[must_use]
    pub fn new(seed: u64) -> Random {
        Random(seed)
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A whole number in 0..`n`; `n` is at least 1.
    pub fn below(&mut self, n: u32) -> u32 {
        (((self.bits() >> 32) * u64::from(n)) >> 32) as u32
    }

    /// A number in 0.0..1.0, a multiple of 2⁻²⁴.
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / 16_777_216.0
    }

    /// A number in `low`..`high`.
    pub fn range(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    /// A point of the cube with corners at ±1.
    pub fn point(&mut self) -> Vec3 {
        Vec3::new(
            self.range(-1.0, 1.0),
            self.range(-1.0, 1.0),
            self.range(-1.0, 1.0),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotations_are_right_handed() {
        let quarter = std::f64::consts::FRAC_PI_2;
        let near = |a: DVec3, b: DVec3| assert!((a - b).length() < 1e-15, "{a} is not {b}");
        near(rotation(Axis::X, quarter) * DVec3::Y, DVec3::Z);
        near(rotation(Axis::Y, quarter) * DVec3::Z, DVec3::X);
        near(rotation(Axis::Z, quarter) * DVec3::X, DVec3::Y);
    }

    #[test]
    fn power_of_two_below_is_exact() {
        assert_eq!(power_of_two_below(1.0), 1.0);
        assert_eq!(power_of_two_below(1.99), 1.0);
        assert_eq!(power_of_two_below(3e-30), 2f64.powi(-99));
    }
}
