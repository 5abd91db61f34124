//! What it means that a free ray hits a triangle, and how far away.
//!
//! The corners of the triangle are taken relative to the ray's origin: q = p − o, each coordinate rounded to `f32`.
//! Rounding a corner does not depend on the triangle that it belongs to, so triangles that share corners still share
//! them. From there on it is the rule of a pixel ([`crate::trace::exact`]): the ray of direction d hits when d lies
//! in the closed cone that a, b and c (the rounded ones) span, and whether it does is a question of exact
//! arithmetic. The cones of a closed mesh cover every direction from a point inside of it; so no ray slips through,
//! and the answer depends neither on the width nor on the order of the work.
//!
//! A triangle whose plane holds the origin is seen edge-on and never hit: a ray that starts exactly in a plane
//! leaves it.

use glam::{BVec3, DVec3, Vec3};
use robust::{Coord3D, orient3d};

use super::Ray;

/// A triangle as a ray sees it: corners relative to the origin, in `f32`.
pub type Relative = [Vec3; 3];

/// The rounding error of a determinant of three vectors in `f64`, relative to the product of their sizes. It is
/// about 7 roundings; this is 16.
const DOUBT: f64 = 16.0 / 9_007_199_254_740_992.0;

/// Eight roundings: products and quotients of numbers that are farther apart keep their order.
pub const INSIDE: f64 = 8.0 / 9_007_199_254_740_992.0;

/// The corners relative to `origin`.
#[inline(always)]
#[must_use]
pub fn relative(corners: &[Vec3; 3], origin: Vec3) -> Relative {
    corners.map(|p| p - origin)
}

/// True when the ray that starts at 0 in direction `dir` meets the triangle: by exact arithmetic alone.
#[must_use]
pub fn meets_exactly(triangle: &Relative, dir: Vec3) -> bool {
    if !triangle.iter().all(|p| p.is_finite()) {
        return false;
    }
    let [a, b, c] = *triangle;
    let whole = determinant(a, b, c);
    let inside = |p, q| {
        let side = determinant(p, q, dir);
        if whole > 0.0 {
            side >= 0.0
        } else {
            side <= 0.0
        }
    };
    whole != 0.0 && inside(a, b) && inside(b, c) && inside(c, a)
}

/// A number with the sign of |a b c|, zero only if that is zero.
fn determinant(a: Vec3, b: Vec3, c: Vec3) -> f64 {
    let coord = |p: Vec3| Coord3D {
        x: f64::from(p.x),
        y: f64::from(p.y),
        z: f64::from(p.z),
    };
    orient3d(coord(a), coord(b), coord(c), coord(Vec3::ZERO))
}

/// A triangle and a ray in `f64`, with what both questions need.
#[derive(Clone, Copy, Debug)]
pub struct Meeting {
    corners: [DVec3; 3],
    /// c − a and a − b.
    edges: [DVec3; 2],
    /// |a b c|.
    whole: f64,
    /// Parallel to the normal; longer than it by twice the area.
    normal: DVec3,
}

impl Meeting {
    /// Prepares a triangle.
    #[inline(always)]
    #[must_use]
    pub fn new(triangle: &Relative) -> Meeting {
        let corners = triangle.map(Vec3::as_dvec3);
        let [a, b, c] = corners;
        let edges = [c - a, a - b];
        let normal = edges[0].cross(edges[1]);
        Meeting {
            corners,
            edges,
            whole: normal.dot(a),
            normal,
        }
    }

    /// How far along `ray` the triangle's plane lies: `f64` in a fixed order, kept between the distances of the
    /// sides of the triangle's box, and then rounded. Means something only where the ray meets the triangle.
    ///
    /// The box matters for planes seen nearly edge-on, whose distance is all rounding: the culling of boxes may rely
    /// on a hit being nowhere else.
    #[inline(always)]
    #[must_use]
    pub fn distance(&self, ray: &Ray) -> f32 {
        let dir = ray.dir.as_dvec3();
        let [a, b, c] = self.corners;
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let t = self.whole / self.normal.dot(dir);
        // A point that lies well inside the box needs no division to see it.
        let point = dir * t;
        let margin = point.abs() * INSIDE;
        if (point - margin).cmpgt(low).all() && (point + margin).cmplt(high).all() {
            return t as f32;
        }
        let (low, high) = (low / dir, high / dir);
        let sloped = dir.cmpne(DVec3::ZERO);
        let enters = DVec3::select(sloped, low.min(high), DVec3::NEG_INFINITY);
        let leaves = DVec3::select(sloped, low.max(high), DVec3::INFINITY);
        t.min(leaves.min_element()).max(enters.max_element()) as f32
    }

    /// As [`meets_exactly`], but looks at the signs of `f64` numbers first.
    #[inline(always)]
    #[must_use]
    pub fn meets(&self, triangle: &Relative, dir: Vec3) -> bool {
        let size = |v: DVec3| v.abs().element_sum();
        let [a, b, c] = self.corners;
        let d = dir.as_dvec3();
        let sides = DVec3::new(a.cross(b).dot(d), b.cross(c).dot(d), c.cross(a).dot(d));
        let sizes = [size(a), size(b), size(c)];
        let doubts = DVec3::new(
            sizes[0] * sizes[1],
            sizes[1] * sizes[2],
            sizes[2] * sizes[0],
        ) * (size(d) * DOUBT);
        let doubt = sizes[0] * size(self.edges[0]) * size(self.edges[1]) * DOUBT;
        let sides = if self.whole < 0.0 { -sides } else { sides };
        let sure = self.whole.abs() > doubt;
        if sure && sides.cmplt(-doubts).any() {
            return false;
        }
        if sure && sides.cmpgt(doubts) == BVec3::TRUE {
            return true;
        }
        in_doubt(triangle, dir)
    }
}

/// Out of the way: about one triangle in 10⁸ that a ray comes near to.
#[cold]
#[inline(never)]
fn in_doubt(triangle: &Relative, dir: Vec3) -> bool {
    meets_exactly(triangle, dir)
}
