//! A scene compiled for the kernels: flat arrays and a BVH. Later layers see only [`World`].
//!
//! What every picture needs is made at once; what only some views and engines need, when they first ask.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

use glam::{DVec3, Vec3};

use crate::bvh::{Bvh, BvhStats, Quality};
use crate::geometry::{Aabb, corner_lanes, unit_normal};
use crate::raw::Pages;
use crate::scene::{Scene, Triangle};
use crate::simd::{
    Kernel, Simd, SimdBase, SimdNarrow, SimdSplit, SimdWiden, dispatch, f32x8, f64x4, transpose4,
};
use crate::watch::{Cancelled, Watch};

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
    mirror_records: Pages<MirrorRecord>,
    /// In leaf order.
    corners: OnceLock<Vec<[Vec3; 3]>>,
    /// In leaf order; the fourth number is not used.
    normals: OnceLock<Vec<[f32; 4]>>,
}

impl World {
    /// Compiles `scene`, in parallel on the current rayon pool; the same result for any number of threads.
    #[must_use]
    pub fn compile(scene: &Scene) -> World {
        World::with_quality(scene, Quality::Fine)
    }

    /// Compiles `scene` in a fraction of the time; frames take longer and show the same.
    #[must_use]
    pub fn compile_coarse(scene: &Scene) -> World {
        World::with_quality(scene, Quality::Coarse)
    }

    /// [`World::compile`] or [`World::compile_coarse`].
    #[must_use]
    pub fn with_quality(scene: &Scene, quality: Quality) -> World {
        World::with_quality_watched(scene, quality, Watch::NOBODY).expect("nobody cancels")
    }

    /// [`World::with_quality`], which tells `watch` now and then how many triangles are in their place, and how many
    /// there are. The last one may not come, and before the first one the triangles are sorted.
    ///
    /// # Errors
    /// [`Cancelled`] when `watch` says so.
    pub fn with_quality_watched(
        scene: &Scene,
        quality: Quality,
        watch: Watch<'_>,
    ) -> Result<World, Cancelled> {
        let light = unit(scene.light.as_dvec3());
        let kernel = Kernel::best();
        let placed = AtomicUsize::new(0);
        let records = |ids: &[u32], out: &mut Pages<MirrorRecord>| {
            dispatch!(kernel, simd => mirror_records(simd, light, &scene.triangles, ids, out));
            let before = placed.fetch_add(ids.len(), Ordering::Relaxed);
            watch.tell(before + ids.len(), scene.triangles.len());
        };
        let (bvh, mirror_records) = Bvh::build_with(&scene.triangles, quality, &records, watch)?;
        let triangle_count = scene.triangles.len();
        let bounds = if bvh.file_ids.len() + bvh.copies == triangle_count {
            bvh.bounds
        } else {
            Aabb::of_triangles(&scene.triangles)
        };
        Ok(World {
            bvh,
            bounds,
            triangle_count,
            light,
            mirror_records,
            corners: OnceLock::new(),
            normals: OnceLock::new(),
        })
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
        self.triangle_count - self.bvh.copies - self.bvh.file_ids.len()
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

/// Appends the records of the triangles `ids`, none of which is degenerate, to `out`: eight at a time.
#[inline(always)]
fn mirror_records<S: Simd>(
    simd: S,
    light: DVec3,
    triangles: &[Triangle],
    ids: &[u32],
    out: &mut Pages<MirrorRecord>,
) {
    for ids in ids.chunks(8) {
        let mut of_lane = [&triangles[ids[ids.len() - 1] as usize]; 8];
        for (triangle, &id) in of_lane.iter_mut().zip(ids) {
            *triangle = &triangles[id as usize];
        }
        let [ax, ay, az] = corner_lanes(simd, &of_lane, 0);
        let [bx, by, bz] = corner_lanes(simd, &of_lane, 1);
        let [cx, cy, cz] = corner_lanes(simd, &of_lane, 2);
        // Not `map`, here and below: what it calls may not be inlined, and would be compiled without the wide
        // instructions.
        let (ax, ay, az) = (ax.widen(), ay.widen(), az.widen());
        let (bx, by, bz) = (bx.widen(), by.widen(), bz.widen());
        let (cx, cy, cz) = (cx.widen(), cy.widen(), cz.widen());
        let low = mirrored(
            light,
            [bx.0 - ax.0, by.0 - ay.0, bz.0 - az.0],
            [cx.0 - ax.0, cy.0 - ay.0, cz.0 - az.0],
        );
        let high = mirrored(
            light,
            [bx.1 - ax.1, by.1 - ay.1, bz.1 - az.1],
            [cx.1 - ax.1, cy.1 - ay.1, cz.1 - az.1],
        );
        let colors = of_lane.map(|triangle| f32::from_bits(triangle.color.packed()));
        let (x0, x1) = low[0].narrow(high[0]).split();
        let (y0, y1) = low[1].narrow(high[1]).split();
        let (z0, z1) = low[2].narrow(high[2]).split();
        let (color0, color1) = f32x8::load_array(simd, colors).split();
        let [r0, r1, r2, r3] = transpose4([x0, y0, z0, color0]);
        let [r4, r5, r6, r7] = transpose4([x1, y1, z1, color1]);
        let records = [
            r0.to_array(),
            r1.to_array(),
            r2.to_array(),
            r3.to_array(),
            r4.to_array(),
            r5.to_array(),
            r6.to_array(),
            r7.to_array(),
        ];
        out.extend_from_slice(&records[..ids.len()]);
    }
}

/// The direction `light` mirrored at the planes of triangles with the edges AB = `b` and AC = `c`.
#[inline(always)]
fn mirrored<S: Simd>(light: DVec3, b: [f64x4<S>; 3], c: [f64x4<S>; 3]) -> [f64x4<S>; 3] {
    let ([bx, by, bz], [cx, cy, cz]) = (b, c);
    let (x, y, z) = (by * cz - cy * bz, bz * cx - cz * bx, bx * cy - cx * by);
    // Of a normal of any length: one division instead of seven, and a root.
    let twice = (x * light.x + y * light.y + z * light.z) * 2.0 / (x * x + y * y + z * z);
    // Added with its sign turned: the same bits.
    [
        -(x * twice) + light.x,
        -(y * twice) + light.y,
        -(z * twice) + light.z,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;
    use crate::geometry::edge_cross;
    use crate::math::Random;
    use std::sync::Mutex;

    #[test]
    fn a_build_tells_how_far_it_is_and_is_the_same_for_it() {
        let mut random = Random::new(5);
        let mut scene = crate::scene::parse(b"<d 0 0 -1 0").expect("a scene");
        scene.triangles.extend((0..20_000).map(|_| Triangle {
            corners: [(); 3].map(|()| random.point()),
            color: Rgb::BLACK,
        }));
        for quality in [Quality::Coarse, Quality::Fine] {
            let told = Mutex::new(Vec::new());
            let tell = |done, of| told.lock().expect("no panic").push((done, of));
            let world = World::with_quality_watched(&scene, quality, Watch::of(&tell));
            let world = world.expect("nobody cancels");
            let mut told = told.into_inner().expect("no panic");
            told.sort_unstable();
            assert!(told.len() > 2, "{told:?}");
            assert_eq!(told.last(), Some(&(20_000, 20_000)));
            let plain = World::with_quality(&scene, quality);
            assert_eq!(*world.bvh().file_ids, *plain.bvh().file_ids);
            assert_eq!(world.bvh_stats(), plain.bvh_stats());
        }
    }

    #[test]
    fn records_are_those_of_scalar_arithmetic_to_the_bit() {
        let mut random = Random::new(3);
        let triangles: Vec<Triangle> = (0..997)
            .map(|i| Triangle {
                corners: [(); 3].map(|()| random.point() * 10f32.powi(i % 60 - 30)),
                color: Rgb::from_packed(i as u32 * 1001),
            })
            .collect();
        let ids: Vec<u32> = (0..997).rev().collect();
        let light = unit(DVec3::new(0.3, -1.0, 2.0));
        for kernel in Kernel::available() {
            let mut records = Pages::new();
            dispatch!(kernel, simd => mirror_records(simd, light, &triangles, &ids, &mut records));
            assert_eq!(records.len(), ids.len());
            for (record, &id) in records.iter().zip(&ids) {
                let triangle = &triangles[id as usize];
                let n = edge_cross(&triangle.corners);
                let m = (light - n * (2.0 * light.dot(n) / n.dot(n))).as_vec3();
                let expected = [m.x, m.y, m.z, f32::from_bits(triangle.color.packed())];
                assert_eq!(
                    record.map(f32::to_bits),
                    expected.map(f32::to_bits),
                    "triangle {id}, kernel {}",
                    kernel.name()
                );
            }
        }
    }
}
