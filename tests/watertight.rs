//! Closed meshes seen from inside, and sheets in front of the eye, have no holes: no ray passes between triangles,
//! also where rays are aimed at vertices and edges as exactly as `f32` can say.
//!
//! `RAYBOMB_RAYS=1e9 cargo test --release --test watertight` shoots that many rays (about 10⁷ otherwise).

mod common;

use common::{ball, look_at, scene, sheet};
use glam::Vec3;
use raybomb::camera::{Camera, View};
use raybomb::frame::{Hits, MISS};
use raybomb::math::Random;
use raybomb::render::{Engine, Progress, Renderer};
use raybomb::simd::Kernel;
use raybomb::trace::probe::Silent;
use raybomb::trace::{Rig, TILE, Tracer};
use raybomb::world::World;

const SIZE: (usize, usize) = (960, 540);

/// One mesh and a camera that sees nothing but it.
struct Case {
    name: String,
    triangles: Vec<[Vec3; 3]>,
    camera: Camera,
}

/// A camera at `eye` looking somewhere, with an angle of view of its own.
fn some_camera(r: &mut Random, eye: Vec3) -> Camera {
    let target = eye + r.point().normalize();
    look_at(eye, target, f64::from(r.range(0.3, 1.3)), 16.0 / 9.0)
}

fn case(number: u64) -> Case {
    let mut r = Random::new(1000 + number);
    let far = [
        Vec3::ZERO,
        Vec3::new(523.25, -71.5, 99.125),
        Vec3::new(1e5, -3e4, 7e4),
    ];
    let offset = far[(number / 3 % 3) as usize];
    match number % 3 {
        // Balls, smooth and jagged, small and large, near the origin and far from it.
        0 => {
            let n = [5, 20, 90, 300][(number / 9 % 4) as usize];
            let bump = [0.0, 0.3][(number / 3 % 2) as usize];
            // So far out a ball of radius 1 would be a few steps of `f32` across.
            let radius = if offset.x > 1e4 { 64.0 } else { 1.0 };
            let eye = offset + 0.4 * radius * r.point();
            let at_origin = ball(&mut r, n, bump, Vec3::ZERO);
            Case {
                name: format!(
                    "ball of {} triangles about {offset}, bumps of {bump}",
                    at_origin.len()
                ),
                triangles: at_origin
                    .iter()
                    .map(|t| t.map(|p| p * radius + offset))
                    .collect(),
                camera: some_camera(&mut r, eye),
            }
        }
        // Sheets whose vertices lie on pixels' centres.
        kind => {
            let step = [1, 2, 3, 5, 7, 16, 33, 50][(number / 3 % 8) as usize];
            let eye = far[(number / 3 % 2) as usize] * 0.1;
            let camera = some_camera(&mut r, eye);
            let view = View::new(&camera, SIZE.0, SIZE.1);
            let smooth = kind == 1;
            let triangles = sheet(&view, step, |x, y| {
                if smooth {
                    3.0 + (x * 0.01).sin() + (y * 0.013).cos()
                } else {
                    1.0 + 4.0 * f64::from(r.unit())
                }
            });
            Case {
                name: format!("sheet with a vertex every {step} pixels, smooth: {smooth}"),
                triangles,
                camera,
            }
        }
    }
}

fn rays() -> u64 {
    std::env::var("RAYBOMB_RAYS").map_or(10_000_000, |s| s.parse::<f64>().expect("a number") as u64)
}

#[test]
fn closed_meshes_have_no_holes() {
    let renderer = Renderer::new(0).expect("threads");
    let kernels = Kernel::available();
    let (mut shot, mut number, mut hits) = (0u64, 0, Hits::default());
    while shot < rays() {
        let case = case(number);
        let world = renderer.install(|| World::compile(&scene(case.triangles)));
        let view = View::new(&case.camera, SIZE.0, SIZE.1);
        // All kernels give the same bits (see the oracle's tests), so each takes its turn.
        let kernel = kernels[number as usize % kernels.len()];
        renderer
            .hits(
                &world,
                &view,
                Engine::Fast,
                kernel,
                &mut hits,
                &Progress::new(),
            )
            .expect("nobody cancels");
        let holes = hits.pixels.iter().filter(|h| h.id == MISS).count();
        assert_eq!(holes, 0, "case {number}, {}, {}", case.name, kernel.name());
        shot += hits.pixels.len() as u64;
        number += 1;
    }
    println!("{shot} rays, {number} meshes, no hole");
}

/// The test above would notice: kernels that trust rounded edge functions leak on the same meshes.
#[test]
fn without_the_guard_meshes_leak() {
    let mut holes = 0;
    for number in [1, 2, 4, 5] {
        let case = case(number);
        let world = World::compile(&scene(case.triangles));
        let view = View::new(&case.camera, SIZE.0, SIZE.1);
        let rig = Rig::new(&view, world.bvh().bounds);
        let mut tracer = Tracer::without_guard();
        // Whole tiles only: a tile that sticks out of the picture sees more than the mesh.
        for y in (0..SIZE.1 - TILE).step_by(TILE) {
            for x in (0..SIZE.0 - TILE).step_by(TILE) {
                tracer.trace::<Silent>(Kernel::best(), world.bvh(), &rig.tile(x, y));
                holes += tracer.tile().id.iter().filter(|&&id| id == MISS).count();
            }
        }
    }
    println!("{holes} holes without the guard");
    assert!(
        holes > 0,
        "the guard makes no difference: the test above proves nothing"
    );
}
