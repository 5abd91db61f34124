//! The rays of the workloads that measure rays other than the camera's.

use glam::{DVec3, Vec3};

use crate::camera::View;
use crate::frame::Hits;
use crate::geometry::Aabb;
use crate::math::Random;
use crate::render::{Point, each_point};
use crate::scene::Scene;
use crate::trace::free::Ray;
use crate::trace::light::{Start, start};
use crate::world::World;

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
