//! The original report's method against the fast engine: away from edges both see the same triangle.

mod common;

use common::{ball, look_at, scene};
use glam::{DVec3, Vec3};
use raybomb::camera::View;
use raybomb::frame::{Hits, MISS};
use raybomb::math::Random;
use raybomb::render::{Engine, Progress, Renderer};
use raybomb::scene::Scene;
use raybomb::simd::Kernel;
use raybomb::world::World;

/// The smallest barycentric coordinate of the point where a ray meets a triangle's plane.
fn smallest_barycentric(corners: [Vec3; 3], eye: DVec3, direction: DVec3) -> f64 {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    let n = (b - a).cross(c - a);
    let p = eye + direction * ((a - eye).dot(n) / direction.dot(n));
    let part = |q: DVec3, r: DVec3| (q - p).cross(r - p).dot(n) / n.dot(n);
    part(b, c).min(part(c, a)).min(part(a, b))
}

/// How many pixels both must agree on, and how many do.
fn compare(renderer: &Renderer, scene: &Scene, view: &View) -> (usize, usize) {
    let world = World::compile(scene);
    let trace = |engine| {
        let mut hits = Hits::default();
        renderer
            .hits(
                &world,
                view,
                engine,
                Kernel::best(),
                &mut hits,
                &Progress::new(),
            )
            .expect("nobody cancels");
        hits
    };
    let (fast, report) = (trace(Engine::Fast), trace(Engine::Report));
    let id = |hits: &Hits, x: usize, y: usize| hits.pixels[y * view.width + x].id;
    let (mut compared, mut agree) = (0, 0);
    for y in 1..view.height - 1 {
        for x in 1..view.width - 1 {
            let me = id(&fast, x, y);
            let alone = (0..9).all(|i| id(&fast, x + i % 3 - 1, y + i / 3 - 1) == me);
            // Of either engine's hit: the report's tolerance also takes points a hair outside a triangle.
            let clear = |id: u32| {
                id == MISS || {
                    let corners = scene.triangles[id as usize].corners;
                    smallest_barycentric(corners, view.eye.as_dvec3(), view.direction(x, y)) > 1e-3
                }
            };
            let other = id(&report, x, y);
            if alone && clear(me) && clear(other) {
                compared += 1;
                agree += usize::from(other == me);
            }
        }
    }
    (compared, agree)
}

#[test]
fn agrees_with_the_fast_engine_away_from_edges() {
    let renderer = Renderer::new(0).expect("threads");
    let mut r = Random::new(9);
    let soup = (0..100)
        .map(|_| {
            let p = r.point();
            [p, p + r.point() * 0.6, p + r.point() * 0.6]
        })
        .collect();
    let far = Vec3::new(500.0, -200.0, 300.0);
    let scenes = [
        ("soup", scene(soup), Vec3::ZERO),
        ("ball", scene(ball(&mut r, 6, 0.3, Vec3::ZERO)), Vec3::ZERO),
        (
            "ball far from the origin",
            scene(ball(&mut r, 6, 0.3, far)),
            far,
        ),
    ];
    for (name, scene, centre) in scenes {
        let camera = look_at(centre + Vec3::new(0.5, 0.8, 3.0), centre, 0.5, 4.0 / 3.0);
        let view = View::new(&camera, 640, 480);
        let (compared, agree) = compare(&renderer, &scene, &view);
        let share = 100.0 * compared as f64 / (640.0 * 480.0);
        println!(
            "{name}: {share:.1} % of the pixels compared, {} differ",
            compared - agree
        );
        assert!(
            share >= 80.0,
            "{name}: only {share:.1} % of the pixels were compared"
        );
        assert_eq!(compared, agree, "{name}");
    }
}
