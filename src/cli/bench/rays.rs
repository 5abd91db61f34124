//! The rays of the workloads that measure rays other than the camera's.

use glam::{DVec3, Vec3};

use crate::camera::View;
use crate::frame::{Hits, MISS};
use crate::geometry::{Aabb, unit_normal};
use crate::math::Random;
use crate::scene::Scene;
use crate::trace::free::{Ray, lift};
use crate::trace::light::{Start, start};
use crate::world::World;

/// Pixels of a square whose rays lie together in memory, each way.
const SQUARE: usize = 8;

/// A point that a picture shows.
struct Point {
    /// Lifted off the surface.
    origin: Vec3,
    /// The triangle's number in the file.
    triangle: u32,
    /// The camera ray's direction.
    dir: DVec3,
    /// Unit length, towards the camera.
    normal: DVec3,
}

/// Every point that is turned to the light, on the side that the picture shows.
pub fn lit(scene: &Scene, world: &World, view: &View, hits: &Hits) -> Vec<Start> {
    let mut starts = Vec::new();
    let to_light = -world.light();
    each_point(scene, world, view, hits, |point| {
        if point.normal.dot(to_light) > 0.0 {
            starts.push(start(point.origin, point.triangle));
        }
    });
    starts
}

/// Mirror rays from every point, of unit length.
pub fn mirrored(scene: &Scene, world: &World, view: &View, hits: &Hits) -> Vec<Ray> {
    let mut rays = Vec::new();
    each_point(scene, world, view, hits, |point| {
        let Point { dir, normal, .. } = point;
        let mirrored = dir - normal * (2.0 * dir.dot(normal));
        rays.push(Ray::new(point.origin, mirrored.normalize().as_vec3()));
    });
    rays
}

/// `count` rays from points evenly spread over `bounds`, in evenly spread directions; the same ones each time.
pub fn random(bounds: Aabb, count: usize) -> Vec<Ray> {
    let mut random = Random::new(0x9E37_79B9_7F4A_7C15);
    let mut ray = || {
        let at = [random.unit(), random.unit(), random.unit()];
        let origin = bounds.min + (bounds.max - bounds.min) * Vec3::from(at);
        let z = 1.0 - 2.0 * f64::from(random.unit());
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * f64::from(random.unit()));
        let r = (1.0 - z * z).max(0.0).sqrt();
        Ray::new(origin, DVec3::new(r * cos, r * sin, z).as_vec3())
    };
    if bounds.is_empty() {
        return Vec::new();
    }
    (0..count).map(|_| ray()).collect()
}

/// Every point that the picture shows, square by square, along a curve (Morton's) in each.
fn each_point(scene: &Scene, world: &World, view: &View, hits: &Hits, mut work: impl FnMut(Point)) {
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
