//! The oracle of free rays: every triangle, by the exact rule alone.

use glam::Vec3;

use super::Ray;
use super::frame::is_ray;
use super::rule::{self, Meeting};
use crate::frame::Hit;

/// The nearest hit of `ray` with `triangles`, which are numbered by `file_ids`; of equally near ones, the lowest
/// number.
#[must_use]
pub fn closest_hit(triangles: &[[Vec3; 3]], file_ids: &[u32], ray: &Ray) -> Hit {
    let mut best = Hit::NONE;
    if !is_ray(ray) {
        return best;
    }
    for (corners, &id) in triangles.iter().zip(file_ids) {
        let triangle = rule::relative(corners, ray.origin);
        if rule::meets_exactly(&triangle, ray.dir) {
            let t = Meeting::new(&triangle).distance(ray);
            let counts = ray.t_min <= t && t <= ray.t_max;
            if counts && (t < best.t || t == best.t && id < best.id) {
                best = Hit { id, t };
            }
        }
    }
    best
}
