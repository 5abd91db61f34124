//! The points that a picture shows: where rays begin that go on from them.

use glam::{DVec3, Vec3};

use crate::camera::View;
use crate::frame::{Hits, MISS};
use crate::geometry::unit_normal;
use crate::scene::Scene;
use crate::trace::free::lift;
use crate::world::World;

/// Pixels of a square whose points follow each other, each way.
const SQUARE: usize = 8;

/// A point that a picture shows.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Where it is, lifted off the surface.
    pub origin: Vec3,
    /// The triangle's number in the file.
    pub triangle: u32,
    /// The camera ray's direction.
    pub dir: DVec3,
    /// Unit length, towards the camera.
    pub normal: DVec3,
}

/// Every point that the picture shows, square by square, along a curve (Morton's) in each.
///
/// `hits` are those of `view`, and `world` is compiled from `scene`.
pub fn each_point(
    scene: &Scene,
    world: &World,
    view: &View,
    hits: &Hits,
    mut work: impl FnMut(Point),
) {
    for top in (0..view.height).step_by(SQUARE) {
        for left in (0..view.width).step_by(SQUARE) {
            for i in 0..SQUARE * SQUARE {
                let bit = |from: usize, to: usize| (i >> from & 1) << to;
                let x = left + bit(0, 0) + bit(2, 1) + bit(4, 2);
                let y = top + bit(1, 0) + bit(3, 1) + bit(5, 2);
                if x >= view.width || y >= view.height {
                    continue;
                }
                let hit = hits.pixels[y * view.width + x];
                if hit.id == MISS {
                    continue;
                }
                let dir = view.direction(x, y);
                let mut normal = unit_normal(&scene.triangles[hit.id as usize].corners);
                if normal.dot(dir) > 0.0 {
                    normal = -normal;
                }
                let point = (view.eye.as_dvec3() + dir * f64::from(hit.t)).as_vec3();
                let origin = lift(point, normal.as_vec3(), dir.as_vec3(), &world.bounds());
                work(Point {
                    origin,
                    triangle: hit.id,
                    dir,
                    normal,
                });
            }
        }
    }
}
