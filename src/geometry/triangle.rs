//! Facts about one triangle, in `f64`.

use glam::{DVec3, Vec3};

use crate::scene::Triangle;
use crate::simd::{Simd, SimdBase, SimdCombine, SimdMask, f32x4, f32x8, transpose4};

/// The cross product of the edges AB and AC, in `f64`. Squares of what is not zero in it stay in the range of `f64`.
#[must_use]
pub fn edge_cross(corners: &[Vec3; 3]) -> DVec3 {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    (b - a).cross(c - a)
}

/// True when the cross product of the edges, in `f64`, is the zero vector: such a triangle is never hit.
#[must_use]
pub fn is_degenerate(corners: &[Vec3; 3]) -> bool {
    edge_cross(corners) == DVec3::ZERO
}

/// Corner `corner` of eight triangles: x, y and z, a triangle a lane.
#[inline(always)]
pub fn corner_lanes<S: Simd>(simd: S, triangles: &[&Triangle; 8], corner: usize) -> [f32x8<S>; 3] {
    // Not a closure: that might not be inlined, and would be compiled without the wide instructions.
    macro_rules! row {
        ($lane:expr) => {{
            let Vec3 { x, y, z } = triangles[$lane].corners[corner];
            f32x4::load_array(simd, [x, y, z, 0.0])
        }};
    }
    let [x0, y0, z0, _] = transpose4([row!(0), row!(1), row!(2), row!(3)]);
    let [x1, y1, z1, _] = transpose4([row!(4), row!(5), row!(6), row!(7)]);
    [x0.combine(x1), y0.combine(y1), z0.combine(z1)]
}

/// A bit for each of eight triangles, given as lanes of their corners: set only when it is not degenerate, and nearly
/// always then.
///
/// That is when a component of the cross product is so large beside what it is the difference of, and that so far
/// from denormal numbers, that rounding to `f32` cannot account for it.
#[inline(always)]
pub fn have_area_for_sure<S: Simd>(corners: &[[f32x8<S>; 3]; 3]) -> u32 {
    let [a, b, c] = corners;
    let (ex, ey, ez) = (b[0] - a[0], b[1] - a[1], b[2] - a[2]);
    let (fx, fy, fz) = (c[0] - a[0], c[1] - a[1], c[2] - a[2]);
    large_difference(ey * fz, ez * fy)
        | large_difference(ez * fx, ex * fz)
        | large_difference(ex * fy, ey * fx)
}

/// The lanes in which p - q is not a matter of rounding.
#[inline(always)]
fn large_difference<S: Simd>(p: f32x8<S>, q: f32x8<S>) -> u32 {
    let size = p.abs() + q.abs();
    ((p - q).abs().simd_gt(size * 1e-5) & size.simd_gt(1e-30)).to_bitmask() as u32
}

/// The unit normal by the right-hand rule over A, B, C. `corners` must not be degenerate.
#[must_use]
pub fn unit_normal(corners: &[Vec3; 3]) -> DVec3 {
    let n = edge_cross(corners);
    n / n.length()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;
    use crate::math::Random;
    use crate::simd::{Kernel, dispatch};

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
        let (mut lines, mut slivers, mut surely) = (0, 0, 0);
        for i in 0..20_000 {
            let (p, q) = (random.point(), random.point());
            let scale = 2f32.powi(i % 250 - 125);
            // On the line up to rounding.
            let t = [p, p + q, p + q * random.range(-2.0, 2.0)].map(|p| p * scale);
            let degenerate = is_degenerate(&t);
            *(if degenerate { &mut lines } else { &mut slivers }) += 1;
            let triangle = Triangle {
                corners: t,
                color: Rgb::BLACK,
            };
            let sure = dispatch!(Kernel::best(), simd => {
                let corner = |i| corner_lanes(simd, &[&triangle; 8], i);
                have_area_for_sure(&[corner(0), corner(1), corner(2)])
            });
            assert!(sure == 0 || sure == 255 && !degenerate, "{t:?}");
            surely += sure / 255;
            let line = [p, p + p, p * 4.0].map(|p| p * scale);
            assert!(is_degenerate(&line), "{line:?}");
            lines += 1;
        }
        assert!(lines > 1000 && slivers > 1000, "{lines} and {slivers}");
        assert!(surely > 10, "{surely}");
    }

    #[test]
    fn unit_normal_survives_extreme_scales() {
        for scale in [1e-38f32, 1e-30, 1.0, 1e30, 1e38] {
            let t = [Vec3::ZERO, Vec3::X * scale, Vec3::Y * scale];
            assert_eq!(unit_normal(&t), DVec3::Z, "scale {scale}");
        }
    }
}
