//! Free rays: each with an origin and a direction of its own. Which triangle they hit first, or whether any.
//!
//! What decides is [`rule`]: exact arithmetic, the same for every width and order of work. The lanes only tell what is
//! certain. There are two ways down:
//!
//! - [`FreeTracer`] takes rays one by one down the tree of the [`World`] that is there anyway: for a pick in the
//!   window ([`closest_hit`]), and for the few rays that another tracer leaves over. A node's eight boxes are tested at
//!   once, the nearest is entered first, and a leaf's triangles are tested as many at a time as there are lanes.
//! - [`RayTree`] is for many rays. It is a second tree with small leaves, built on demand: it takes about as long to
//!   build as the first and more memory, which a single question should not have to pay. Rays that keep together go
//!   down as beams, the others in streams.
//!
//! # Rays that leave a surface
//! A ray that starts at a point on a triangle should not hit that triangle again. The point of a hit is rounded, so
//! it may lie on either side of the plane. The way to do it here: move the origin off the surface, to the side that
//! is seen, by [`lift`] (10⁻⁵ of the scene's diagonal, far more than rounding and far less than anything that
//! can be seen). A lower limit [`Ray::t_min`] is there too; but near an edge or under a flat angle it lets rays
//! through the neighbouring triangle.

mod beam;
mod block;
pub mod brute;
mod distances;
mod frame;
mod leaf;
mod look;
mod many;
mod ready;
pub mod rule;
mod sift;
mod single;
mod stream;
mod tree;
mod walk;
mod window;

use glam::{DVec3, Vec3};

pub use many::AT_ONCE;
pub use tree::RayTree;
pub use walk::FreeTracer;

use crate::frame::{Hit, MISS};
use crate::geometry::Aabb;
use crate::simd::Kernel;
use crate::world::World;

/// A ray: the points `origin + t * dir` with `t_min <= t <= t_max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts.
    pub origin: Vec3,
    /// Where it goes; any length but zero. Distances are in lengths of it.
    pub dir: Vec3,
    /// The nearest hit that counts; 0 for all in front of the origin.
    pub t_min: f32,
    /// The farthest hit that counts; infinite for all.
    pub t_max: f32,
}

impl Ray {
    /// The ray without an end.
    #[must_use]
    pub fn new(origin: Vec3, dir: Vec3) -> Ray {
        Ray {
            origin,
            dir,
            t_min: 0.0,
            t_max: f32::INFINITY,
        }
    }
}

/// `point`, moved off a surface with unit normal `normal` to the side of it from which `dir` comes: a ray may start
/// there. `bounds`: of the scene.
#[must_use]
pub fn lift(point: Vec3, normal: Vec3, dir: Vec3, bounds: &Aabb) -> Vec3 {
    let diagonal = (bounds.max - bounds.min).length();
    let distance = 1e-5 * diagonal;
    if normal.dot(dir) > 0.0 {
        point - normal * distance
    } else {
        point + normal * distance
    }
}

/// What a ray hits first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pick {
    /// The triangle's number in the file.
    pub triangle: u32,
    /// How far away, in lengths of the ray's direction.
    pub t: f32,
    /// Where.
    pub point: Vec3,
}

impl Pick {
    fn new(hit: Hit, origin: Vec3, dir: DVec3) -> Option<Pick> {
        (hit.id != MISS).then(|| Pick {
            triangle: hit.id,
            t: hit.t,
            point: (origin.as_dvec3() + dir * f64::from(hit.t)).as_vec3(),
        })
    }
}

/// The first hit of one ray. For many rays, [`FreeTracer`] is faster.
///
/// What a picture shows at a pixel is told by `Renderer::pick`: a free ray through it rounds corners in another
/// frame, and may meet another triangle at an outline.
///
/// # Panics
/// When this CPU lacks `kernel`.
#[must_use]
pub fn closest_hit(kernel: Kernel, world: &World, ray: &Ray) -> Option<Pick> {
    let mut hit = [Hit::NONE];
    FreeTracer::default().closest_hits(kernel, world.bvh(), &[*ray], &mut hit);
    Pick::new(hit[0], ray.origin, ray.dir.as_dvec3())
}
