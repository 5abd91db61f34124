//! What one pixel of a picture shows: the triangle, its place, how far and at which angle.

use glam::{DVec3, Vec3};

use super::{Engine, EngineAtWork, Renderer, Wanted};
use crate::camera::View;
use crate::color::Rgb;
use crate::geometry::unit_normal;
use crate::simd::Kernel;
use crate::trace::TILE;
use crate::trace::tile::pixel_offset;
use crate::world::World;

/// The hit of one pixel's ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Picked {
    /// The triangle's number in the file.
    pub id: u32,
    /// Its corners A, B, C.
    pub corners: [Vec3; 3],
    /// Its colour in the file.
    pub color: Rgb,
    /// Where the ray meets it.
    pub point: DVec3,
    /// From the eye to that point.
    pub distance: f64,
    /// Between the ray and the triangle's normal, in radians: 0 is head-on, a quarter turn is edge-on.
    pub angle_rad: f64,
}

impl Renderer {
    /// What pixel (`x`, `y`) of the picture of `view` shows; `None` for the background, and outside of it. It is traced
    /// as it is for the picture, with all of its tile where the engine goes by tiles, so that it is the same triangle to
    /// the bit.
    #[must_use]
    pub fn pick(
        &self,
        world: &World,
        view: &View,
        engine: Engine,
        kernel: Kernel,
        (x, y): (usize, usize),
    ) -> Option<Picked> {
        if x >= view.width || y >= view.height {
            return None;
        }
        let engine = EngineAtWork::new(world, view, engine);
        let mut tracer = self.tracers[0]
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner());
        let (x0, y0) = (x - x % TILE, y - y % TILE);
        let has_hits = if engine.goes_by_tiles() {
            engine.trace(&mut tracer, kernel, x0, y0, Wanted::Hits)
        } else {
            // A whole tile may take minutes.
            let pixel = [(x - x0, y - y0)];
            engine.trace_pixels(tracer.cleared_tile(), x0, y0, &pixel, &|| true)
        };
        if !has_hits {
            return None;
        }
        let tile = tracer.tile();
        let at = pixel_offset(x - x0, y - y0);
        // A miss has a number beyond all triangles.
        let index = tile.id[at] as usize;
        let id = *world.bvh().file_ids.get(index)?;
        let t = f64::from((1.0 / tile.z[at]) * engine.t_per_w());
        let corners = world.corners()[index];
        let direction = view.direction(x, y);
        let cosine = direction.normalize().dot(unit_normal(&corners)).abs();
        Some(Picked {
            id,
            corners,
            color: Rgb::from_packed(world.mirror_records()[index][3].to_bits()),
            point: view.eye.as_dvec3() + direction * t,
            distance: direction.length() * t,
            angle_rad: libm::acos(cosine.min(1.0)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::demo;
    use crate::frame::{Hits, MISS};
    use crate::render::Progress;

    #[test]
    fn a_pick_is_what_the_picture_shows_and_lies_in_its_triangle() {
        let scene = demo::all().last().expect("the sample").scene();
        let renderer = Renderer::new(1).expect("a thread");
        let world = World::compile(&scene);
        let view = Camera::of_scene(&scene, world.bounds()).view(150, 100, false);
        let mut hits = Hits::default();
        let kernel = Kernel::best();
        let mut count = 0;
        for engine in [Engine::Fast, Engine::Brute, Engine::Report] {
            let traced = renderer.hits(&world, &view, engine, kernel, &mut hits, &Progress::new());
            assert!(traced.is_ok());
            for y in (0..100).step_by(9) {
                for x in (0..150).step_by(7) {
                    let hit = hits.pixels[y * 150 + x];
                    let picked = renderer.pick(&world, &view, engine, kernel, (x, y));
                    assert_eq!(picked.map_or(MISS, |p| p.id), hit.id);
                    let Some(p) = picked else { continue };
                    count += 1;
                    let triangle = scene.triangles[p.id as usize];
                    assert_eq!((p.corners, p.color), (triangle.corners, triangle.color));
                    let off = unit_normal(&p.corners).dot(p.point - p.corners[0].as_dvec3());
                    assert!(off.abs() < 1e-3 * p.distance, "off its plane by {off}");
                    assert!((p.point - view.eye.as_dvec3()).length() - p.distance < 1e-9);
                }
            }
            assert_eq!(renderer.pick(&world, &view, engine, kernel, (150, 0)), None);
        }
        assert!(count > 60, "{count} hits");
    }
}
