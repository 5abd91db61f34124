//! A scene compiled for the kernels: flat arrays and a BVH. Later layers see only [`World`].
//!
//! What every picture needs is made at once; what only some views and engines need, when they first ask.

use std::sync::OnceLock;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::bvh::{Bvh, BvhStats};
use crate::geometry::{Aabb, unit_normal};
use crate::scene::Scene;

/// What shading needs of a triangle, 16 bytes: the light's direction mirrored at its plane (x, y, z), and the bits
/// of its colour `0x00RRGGBB`.
pub type MirrorRecord = [f32; 4];

/// The compiled scene.
#[derive(Debug)]
pub struct World {
    bvh: Bvh,
    bounds: Aabb,
    triangle_count: usize,
    light: DVec3,
    mirror_records: Vec<MirrorRecord>,
    /// In leaf order.
    corners: OnceLock<Vec<[Vec3; 3]>>,
    /// In leaf order; the fourth number is not used.
    normals: OnceLock<Vec<[f32; 4]>>,
}

impl World {
    /// Compiles `scene`, in parallel on the current rayon pool; the same result for any number of threads.
    #[must_use]
    pub fn compile(scene: &Scene) -> World {
        let bvh = Bvh::build(&scene.triangles);
        let light = unit(scene.light.as_dvec3());
        let mirror_records = bvh
            .file_ids
            .par_iter()
            .map(|&id| {
                let triangle = &scene.triangles[id as usize];
                let n = unit_normal(&triangle.corners);
                let m = (light - n * (2.0 * light.dot(n))).as_vec3();
                [m.x, m.y, m.z, f32::from_bits(triangle.color.packed())]
            })
            .collect();
        World {
            bvh,
            bounds: Aabb::of_triangles(&scene.triangles),
            triangle_count: scene.triangles.len(),
            light,
            mirror_records,
            corners: OnceLock::new(),
            normals: OnceLock::new(),
        }
    }

    /// The tree.
    #[must_use]
    pub fn bvh(&self) -> &Bvh {
        &self.bvh
    }

    /// The box of all triangles of the scene, degenerate ones included.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// The unit direction in which the light travels.
    #[must_use]
    pub fn light(&self) -> DVec3 {
        self.light
    }

    /// Triangles of the scene, degenerate ones included.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        self.triangle_count
    }

    /// Triangles that are never hit because they have no area.
    #[must_use]
    pub fn degenerate_count(&self) -> usize {
        self.triangle_count - self.bvh.file_ids.len()
    }

    /// In leaf order.
    #[must_use]
    pub fn mirror_records(&self) -> &[MirrorRecord] {
        &self.mirror_records
    }

    /// The corners of every triangle in the tree, in leaf order.
    #[must_use]
    pub fn corners(&self) -> &[[Vec3; 3]] {
        self.corners.get_or_init(|| self.bvh.corners())
    }

    /// The unit normals (x, y, z; the fourth number is 0) of every triangle in the tree, in leaf order.
    #[must_use]
    pub fn normals(&self) -> &[[f32; 4]] {
        self.normals.get_or_init(|| {
            let normal =
                |corners: &[Vec3; 3]| unit_normal(corners).as_vec3().extend(0.0).to_array();
            self.corners().iter().map(normal).collect()
        })
    }

    /// Facts about the tree.
    #[must_use]
    pub fn bvh_stats(&self) -> BvhStats {
        self.bvh.stats()
    }

    /// Bytes of everything that every picture needs.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.bvh_stats().bytes + size_of_val(&self.mirror_records[..])
    }
}

/// `v` at length 1, whatever its scale; `v` is not zero.
fn unit(v: DVec3) -> DVec3 {
    let v = v / v.abs().max_element();
    v / v.length()
}
