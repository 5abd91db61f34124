//! Rays toward the light against every triangle: the same answer for each, at every width that this CPU has.

mod common;

use common::{ball, scene, soup};
use glam::Vec3;
use raybomb::frame::MISS;
use raybomb::geometry::unit_normal;
use raybomb::math::Random;
use raybomb::simd::Kernel;
use raybomb::trace::free::{FreeTracer, brute, lift};
use raybomb::trace::light::LightGrid;
use raybomb::world::World;

/// How many of the origins are hidden; all widths must agree with every triangle's answer.
fn compare(name: &str, triangles: Vec<[Vec3; 3]>, light: Vec3, origins: &[Vec3]) -> usize {
    let mut scene = scene(triangles);
    scene.light = light;
    let world = World::compile(&scene);
    let grid = LightGrid::build(&world);
    let expected: Vec<bool> = origins
        .iter()
        .map(|&origin| {
            let ray = grid.ray(origin);
            brute::closest_hit(world.corners(), &world.bvh().file_ids, &ray).id != MISS
        })
        .collect();
    for kernel in Kernel::available() {
        let mut hidden = vec![false; origins.len()];
        let mut tracer = FreeTracer::default();
        grid.hidden(kernel, &world, &mut tracer, origins, &mut hidden);
        for (i, origin) in origins.iter().enumerate() {
            assert_eq!(
                hidden[i],
                expected[i],
                "{name}, light {light}, {}: {origin:?}",
                kernel.name()
            );
        }
    }
    expected.iter().filter(|&&hidden| hidden).count()
}

/// Lights from all sides, along axes too.
const LIGHTS: [Vec3; 5] = [
    Vec3::new(-0.45, -1.0, -0.35),
    Vec3::new(0.0, 0.0, 1.0),
    Vec3::new(1.0, 0.0, 0.0),
    Vec3::new(1.0, -1.0, 1.0),
    Vec3::new(0.3, 0.9, -0.91),
];

#[test]
fn random_origins_are_hidden_as_every_triangle_says() {
    for (seed, light) in (0..).zip(LIGHTS) {
        let mut random = Random::new(seed);
        let triangles = soup(&mut random, 60 + 60 * seed as usize);
        let mut origins: Vec<Vec3> = (0..300).map(|_| random.point() * 1.2).collect();
        // On the triangles too: corners, edges, faces.
        for [a, b, c] in triangles.iter().take(60) {
            origins.extend([*a, *a + (*b - *a) * 0.5, (*a + *b + *c) / 3.0]);
        }
        let hidden = compare("soup", triangles, light, &origins);
        assert!((20..origins.len() - 20).contains(&hidden), "{hidden}");
    }
}

#[test]
fn whole_numbers_with_all_their_ties_are_hidden_as_every_triangle_says() {
    for light in LIGHTS {
        let mut random = Random::new(17);
        let mut whole = |span: u32| {
            Vec3::from_array([(); 3].map(|()| random.below(span) as f32 - (span / 2) as f32))
        };
        let triangles = (0..100).map(|_| [(); 3].map(|()| whole(5))).collect();
        let origins: Vec<Vec3> = (0..400).map(|_| whole(7)).collect();
        assert!(compare("grid", triangles, light, &origins) > 40);
    }
}

#[test]
fn surfaces_of_a_ball_are_hidden_as_every_triangle_says() {
    for (seed, bump, at, scale) in [
        (1, 0.0, 0.0, 1.0),
        (2, 0.3, 500.0, 1.0),
        (3, 0.3, 0.0, 1e-4),
        (4, 0.1, 0.0, 1e8),
        (5, 0.1, 0.0, 1e-12),
        (6, 0.1, 0.0, 1e14),
    ] {
        let mut random = Random::new(seed);
        let triangles: Vec<[Vec3; 3]> = ball(&mut random, 10, bump, Vec3::splat(at))
            .iter()
            .map(|t| t.map(|p| p * scale))
            .collect();
        let bounds = World::compile(&scene(triangles.clone())).bounds();
        let origins: Vec<Vec3> = triangles
            .iter()
            .map(|corners| {
                let [a, b, c] = *corners;
                let at = [random.unit(), random.unit()];
                let point = a + ((b - a) + (c - b) * at[1]) * at[0];
                let inward = Vec3::splat(scale * at[0].min(0.0)) - point;
                lift(point, unit_normal(corners).as_vec3(), inward, &bounds)
            })
            .collect();
        let hidden = compare("ball", triangles, LIGHTS[0], &origins);
        assert!(hidden > 50, "seed {seed}: {hidden}");
    }
}

#[test]
fn crowds_and_giants_are_hidden_as_every_triangle_says() {
    let mut random = Random::new(23);
    // Hundreds in one place, and two that cover everything.
    let mut triangles: Vec<[Vec3; 3]> = soup(&mut random, 50);
    let same = [Vec3::ZERO, Vec3::X * 0.3, Vec3::Z * 0.3];
    triangles.extend([same; 400]);
    let giant = |y: f32| [-1.0, 0.0, 1.0].map(|k| Vec3::new(60.0 * k, y, 90.0 - 130.0 * k * k));
    triangles.extend([giant(-1.5), giant(1.3)]);
    let origins: Vec<Vec3> = (0..300)
        .map(|_| {
            Vec3::new(
                random.unit() * 0.3,
                random.range(-2.0, 2.0),
                random.unit() * 0.3,
            )
        })
        .collect();
    for light in LIGHTS {
        let hidden = compare("crowd", triangles.clone(), light, &origins);
        assert!(hidden > 10, "{hidden}");
    }
}

#[test]
fn nothing_hides_nothing() {
    let origins = [Vec3::ZERO, Vec3::NAN, Vec3::splat(1e30)];
    assert_eq!(compare("nothing", Vec::new(), LIGHTS[0], &origins), 0);
}
