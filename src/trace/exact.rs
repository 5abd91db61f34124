//! The exact tests behind every pixel.
//!
//! In a tile's frame the eye is the origin, the corners a, b, c of a triangle are three `f32` vectors, and the ray
//! of a pixel is d = (x′, y′, 1). The ray hits when d lies in the closed cone that a, b and c span: when the
//! determinants |a b d|, |b c d| and |c a d| all have the sign of |a b c| or are zero. Which sign a determinant has
//! is a question of exact arithmetic, so it does not depend on how it is computed. That makes the picture
//! watertight: the cones of a closed mesh, seen from inside, cover every direction, because the corners that
//! triangles share are the same `f32`s in both.
//!
//! Source of the exact signs: Shewchuk, "Adaptive precision floating-point arithmetic and fast robust geometric
//! predicates", 1997 (crate `robust`).

use robust::{Coord3D, orient3d};

use super::space::Uvw;

/// The ray of a pixel, in the tile's frame: (x′, y′, 1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelRay {
    /// Pixels right of the tile's centre.
    pub x: f32,
    /// Pixels below it.
    pub y: f32,
}

fn coord(p: Uvw) -> Coord3D<f64> {
    Coord3D {
        x: f64::from(p.u),
        y: f64::from(p.v),
        z: f64::from(p.w),
    }
}

const ORIGIN: Coord3D<f64> = Coord3D {
    x: 0.0,
    y: 0.0,
    z: 0.0,
};

/// A number with the sign of the determinant |a b c|, zero only if that is zero. All coordinates are finite.
#[must_use]
pub fn orientation(a: Uvw, b: Uvw, c: Uvw) -> f64 {
    orient3d(coord(a), coord(b), coord(c), ORIGIN)
}

/// A number with the sign of |p q d|: on which side of the edge from p to q the ray passes.
#[must_use]
pub fn edge_side(p: Uvw, q: Uvw, ray: PixelRay) -> f64 {
    let d = Coord3D {
        x: f64::from(ray.x),
        y: f64::from(ray.y),
        z: 1.0,
    };
    orient3d(coord(p), coord(q), d, ORIGIN)
}

/// True when the ray meets the closed triangle. One that is seen exactly edge-on covers no pixel: its neighbours
/// cover its outline.
#[must_use]
pub fn hits(corners: &[Uvw; 3], ray: PixelRay) -> bool {
    let [a, b, c] = *corners;
    let whole = orientation(a, b, c);
    let inside = |p, q| {
        let side = edge_side(p, q, ray);
        if whole > 0.0 {
            side >= 0.0
        } else {
            side <= 0.0
        }
    };
    whole != 0.0 && inside(a, b) && inside(b, c) && inside(c, a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Random;

    /// |a b c| in 128-bit integers, for coordinates that are whole numbers.
    fn whole_determinant(a: [i64; 3], b: [i64; 3], c: [i64; 3]) -> i128 {
        let m = |i: usize, j: usize| {
            i128::from(b[i]) * i128::from(c[j]) - i128::from(b[j]) * i128::from(c[i])
        };
        i128::from(a[0]) * m(1, 2) + i128::from(a[1]) * m(2, 0) + i128::from(a[2]) * m(0, 1)
    }

    #[test]
    fn signs_agree_with_whole_numbers() {
        let mut r = Random::new(11);
        let mut zeros = 0;
        for round in 0..200_000 {
            // Small ranges make ties common, large ones use all 24 bits.
            let span = 1u32 << (2 + round % 22);
            let mut point = || [0; 3].map(|_: i32| i64::from(r.below(span)) - i64::from(span / 2));
            let (a, b, mut c) = (point(), point(), point());
            if round % 3 == 0 {
                c = [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
            }
            let uvw = |p: [i64; 3]| Uvw {
                u: p[0] as f32,
                v: p[1] as f32,
                w: p[2] as f32,
            };
            let exact = whole_determinant(a, b, c);
            zeros += usize::from(exact == 0);
            let sign = orientation(uvw(a), uvw(b), uvw(c));
            assert_eq!(
                sign.partial_cmp(&0.0),
                Some(exact.cmp(&0)),
                "{a:?} {b:?} {c:?}"
            );
            let d = [2 * a[0].rem_euclid(32) - 31, 2 * b[1].rem_euclid(32) - 31];
            let ray = PixelRay {
                x: d[0] as f32 / 2.0,
                y: d[1] as f32 / 2.0,
            };
            let exact = whole_determinant(a, b, [d[0], d[1], 2]);
            let sign = edge_side(uvw(a), uvw(b), ray);
            assert_eq!(
                sign.partial_cmp(&0.0),
                Some(exact.cmp(&0)),
                "{a:?} {b:?} {d:?}"
            );
        }
        assert!(zeros > 60_000, "too few ties to mean anything: {zeros}");
    }
}
