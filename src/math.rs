//! Double-precision helpers on glam types whose results are the same on every platform.
//!
//! glam's own rotation constructors call the system's `sin` and `cos`; a camera built with them would
//! differ by a bit from machine to machine, and so would the picture. These take both from `libm`.

use glam::{DMat3, DVec3};

use crate::scene::Axis;

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
