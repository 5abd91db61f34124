//! The original method as the report prints it: scalar, every triangle for every ray, compared by areas.
//!
//! Kept for history and for timing beside the fast tracer; near edges it is neither watertight nor exact. The eye
//! is projected along the ray onto the plane of ABC, giving D; D is inside when the areas of ABD, ACD and BCD add
//! up to that of ABC. The report names no tolerance and computes in `f32`; a model far from the origin would fail
//! nearly everywhere, so this computes in `f64` with a relative tolerance.

use glam::{DVec3, Vec3};

use crate::camera::View;

/// How far the sum of areas may differ from the whole, relative to the whole.
pub const TOLERANCE: f64 = 1e-4;

/// Triangles between two questions whether to go on: some tens of microseconds.
const QUESTION: u32 = 1024;

/// What the method needs of a triangle for every ray.
#[derive(Clone, Copy, Debug)]
struct Plane {
    corners: [DVec3; 3],
    normal: DVec3,
    area: f64,
}

/// Triangles prepared for the method.
#[derive(Debug)]
pub struct ReportTracer {
    planes: Vec<Plane>,
}

/// The nearest triangle by the report's method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReportHit {
    /// Index of the triangle as given to [`ReportTracer::new`].
    pub index: u32,
    /// Distance in lengths of the ray's direction.
    pub t: f64,
}

impl ReportTracer {
    /// Prepares triangles.
    #[must_use]
    pub fn new(triangles: &[[Vec3; 3]]) -> ReportTracer {
        let plane = |corners: &[Vec3; 3]| {
            let corners = corners.map(Vec3::as_dvec3);
            let [a, b, c] = corners;
            Plane {
                corners,
                normal: (b - a).cross(c - a),
                area: area(a, b, c),
            }
        };
        ReportTracer {
            planes: triangles.iter().map(plane).collect(),
        }
    }

    /// The nearest hit of pixel (`x`, `y`); of equally near ones the lower of `ids`.
    #[must_use]
    pub fn trace(&self, view: &View, x: usize, y: usize, ids: &[u32]) -> Option<ReportHit> {
        self.trace_while(view, x, y, ids, &|| true).flatten()
    }

    /// The same as long as `go_on` says yes, which is asked before the first triangle and now and then; `None` when it
    /// said no.
    #[must_use]
    pub fn trace_while(
        &self,
        view: &View,
        x: usize,
        y: usize,
        ids: &[u32],
        go_on: &impl Fn() -> bool,
    ) -> Option<Option<ReportHit>> {
        let eye = view.eye.as_dvec3();
        let direction = view.direction(x, y);
        let mut nearest: Option<ReportHit> = None;
        for (index, plane) in (0u32..).zip(&self.planes) {
            if index.is_multiple_of(QUESTION) && !go_on() {
                return None;
            }
            let Some(t) = plane.hit(eye, direction) else {
                continue;
            };
            let wins = nearest.is_none_or(|n| {
                t < n.t || (t == n.t && ids[index as usize] < ids[n.index as usize])
            });
            if wins {
                nearest = Some(ReportHit { index, t });
            }
        }
        Some(nearest)
    }
}

impl Plane {
    fn hit(&self, eye: DVec3, direction: DVec3) -> Option<f64> {
        let [a, b, c] = self.corners;
        let t = (a - eye).dot(self.normal) / direction.dot(self.normal);
        // Written so that NaN (a ray in the plane) is no hit.
        if !(t > 0.0 && t.is_finite()) {
            return None;
        }
        let d = eye + direction * t;
        let parts = area(a, b, d) + area(a, c, d) + area(b, c, d);
        ((parts - self.area).abs() <= TOLERANCE * self.area).then_some(t)
    }
}

/// The area of a triangle in space by the report's formula: half the root of the sum of three squared 3x3
/// determinants, each with a column of ones.
fn area(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let minor =
        |i: usize, j: usize| a[i] * (b[j] - c[j]) + b[i] * (c[j] - a[j]) + c[i] * (a[j] - b[j]);
    let (xy, yz, zx) = (minor(0, 1), minor(1, 2), minor(2, 0));
    0.5 * (xy * xy + yz * yz + zx * zx).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn area_is_half_of_base_times_height() {
        let (a, b, c) = (
            DVec3::ONE,
            DVec3::ONE + DVec3::X * 2.0,
            DVec3::ONE + DVec3::Z * 3.0,
        );
        assert!((area(a, b, c) - 3.0).abs() < 1e-12);
    }
}
