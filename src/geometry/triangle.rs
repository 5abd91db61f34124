//! Facts about one triangle, in `f64`.

use glam::{DVec3, Vec3, Vec3A, Vec3Swizzles};

/// The cross product of the edges AB and AC, in `f64`.
fn edge_cross(corners: &[Vec3; 3]) -> DVec3 {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    (b - a).cross(c - a)
}

/// True when the cross product of the edges, in `f64`, is the zero vector: such a triangle is never hit.
#[must_use]
pub fn is_degenerate(corners: &[Vec3; 3]) -> bool {
    !has_area_for_sure(corners) && edge_cross(corners) == DVec3::ZERO
}

/// True only when a component of the cross product is so large beside what it is the difference of, and that so far
/// from denormal numbers, that rounding to `f32` cannot account for it. Half the work of [`edge_cross`].
#[inline(always)]
fn has_area_for_sure(corners: &[Vec3; 3]) -> bool {
    let [a, b, c] = corners.map(Vec3A::from);
    let (e, f) = (b - a, c - a);
    let (p, q) = (e.yzx() * f.zxy(), e.zxy() * f.yzx());
    let size = p.abs() + q.abs();
    ((p - q).abs().cmpgt(size * 1e-5) & size.cmpgt(Vec3A::splat(1e-30))).any()
}

/// The unit normal by the right-hand rule over A, B, C. `corners` must not be degenerate.
#[must_use]
pub fn unit_normal(corners: &[Vec3; 3]) -> DVec3 {
    let n = edge_cross(corners);
    // Squares of very large or very small components would leave the range of f64.
    let n = n / n.abs().max_element();
    n / n.length()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Random;

    #[test]
    fn points_and_lines_are_degenerate() {
        let p = Vec3::new(1.0, 2.0, 3.0);
        assert!(is_degenerate(&[p, p, p]));
        assert!(is_degenerate(&[p, p * 2.0, p * 4.0]));
        assert!(!is_degenerate(&[p, p + Vec3::X * 1e-6, p + Vec3::Y * 1e-6]));
    }

    #[test]
    fn slivers_are_told_from_lines() {
        let mut random = Random::new(5);
        let (mut lines, mut slivers) = (0, 0);
        for i in 0..20_000 {
            let (p, q) = (random.point(), random.point());
            let scale = 2f32.powi(i % 250 - 125);
            // On the line up to rounding.
            let t = [p, p + q, p + q * random.range(-2.0, 2.0)].map(|p| p * scale);
            let degenerate = is_degenerate(&t);
            assert_eq!(degenerate, edge_cross(&t) == DVec3::ZERO, "{t:?}");
            *(if degenerate { &mut lines } else { &mut slivers }) += 1;
            let line = [p, p + p, p * 4.0].map(|p| p * scale);
            assert!(is_degenerate(&line), "{line:?}");
            lines += 1;
        }
        assert!(lines > 1000 && slivers > 1000, "{lines} and {slivers}");
    }

    #[test]
    fn unit_normal_survives_extreme_scales() {
        for scale in [1e-38f32, 1e-30, 1.0, 1e30, 1e38] {
            let t = [Vec3::ZERO, Vec3::X * scale, Vec3::Y * scale];
            assert_eq!(unit_normal(&t), DVec3::Z, "scale {scale}");
        }
    }
}
