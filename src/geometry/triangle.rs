//! Facts about one triangle, in `f64`.

use glam::{DVec3, Vec3};

/// The cross product of the edges AB and AC, in `f64`.
fn edge_cross(corners: &[Vec3; 3]) -> DVec3 {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    (b - a).cross(c - a)
}

/// True when the cross product of the edges, in `f64`, is the zero vector: such a triangle is never hit.
#[must_use]
pub fn is_degenerate(corners: &[Vec3; 3]) -> bool {
    edge_cross(corners) == DVec3::ZERO
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

    #[test]
    fn points_and_lines_are_degenerate() {
        let p = Vec3::new(1.0, 2.0, 3.0);
        assert!(is_degenerate(&[p, p, p]));
        assert!(is_degenerate(&[p, p * 2.0, p * 4.0]));
        assert!(!is_degenerate(&[p, p + Vec3::X * 1e-6, p + Vec3::Y * 1e-6]));
    }

    #[test]
    fn unit_normal_survives_extreme_scales() {
        for scale in [1e-38f32, 1e-30, 1.0, 1e30, 1e38] {
            let t = [Vec3::ZERO, Vec3::X * scale, Vec3::Y * scale];
            assert_eq!(unit_normal(&t), DVec3::Z, "scale {scale}");
        }
    }
}
