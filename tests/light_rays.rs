//! Rays toward the light against every triangle: the same answer for each, at every width that this CPU has.

mod common;

use common::{ball, scene, soup};
use glam::Vec3;
use raybomb::frame::MISS;
use raybomb::geometry::unit_normal;
use raybomb::math::Random;
use raybomb::simd::Kernel;
use raybomb::trace::free::{FreeTracer, brute, lift};
use raybomb::trace::light::{LightGrid, Start, start};
use raybomb::world::World;

/// How many of the origins are hidden; all widths must agree with every triangle's answer, and it must not matter on
/// which triangle a point is said to lie.
fn compare(name: &str, triangles: Vec<[Vec3; 3]>, light: Vec3, origins: &[Vec3]) -> usize {
    let count = triangles.len() as u32;
    let mut random = Random::new(7);
    let starts: Vec<Start> = (0..)
        .zip(origins)
        .map(|(i, &origin)| {
            let triangle = match i % 3 {
                0 => MISS,
                1 => random.below(count + 2),
                _ => nearest(&triangles, origin),
            };
            start(origin, triangle)
        })
        .collect();
    compare_starts(name, triangles, light, &starts)
}

/// The number of the triangle whose plane is nearest to `point`, of those around it.
fn nearest(triangles: &[[Vec3; 3]], point: Vec3) -> u32 {
    let far = |corners: &[Vec3; 3]| {
        let plane = unit_normal(corners).as_vec3().dot(point - corners[0]);
        let around = corners.iter().map(|p| p.distance(point)).sum::<f32>();
        plane.abs() + 1e-3 * around
    };
    (0..)
        .zip(triangles)
        .min_by(|(_, a), (_, b)| far(a).total_cmp(&far(b)))
        .map_or(MISS, |(i, _)| i)
}

fn compare_starts(name: &str, triangles: Vec<[Vec3; 3]>, light: Vec3, starts: &[Start]) -> usize {
    let mut scene = scene(triangles);
    scene.light = light;
    let world = World::compile(&scene);
    let grid = LightGrid::build(&world);
    let expected: Vec<bool> = starts
        .iter()
        .map(|&[x, y, z, _]| {
            let ray = grid.ray(Vec3::new(x, y, z));
            brute::closest_hit(world.corners(), &world.bvh().file_ids, &ray).id != MISS
        })
        .collect();
    for kernel in Kernel::available() {
        let mut hidden = vec![true; starts.len()];
        let mut tracer = FreeTracer::default();
        grid.hidden(kernel, &world, &mut tracer, starts, &mut hidden);
        for (i, start) in starts.iter().enumerate() {
            assert_eq!(
                hidden[i],
                expected[i],
                "{name}, light {light}, {}: {start:?}",
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
        let starts: Vec<Start> = (0..)
            .zip(&triangles)
            .map(|(i, corners)| {
                let [a, b, c] = *corners;
                let at = [random.unit(), random.unit()];
                let point = a + ((b - a) + (c - b) * at[1]) * at[0];
                let inward = Vec3::splat(scale * at[0].min(0.0)) - point;
                let normal = unit_normal(corners).as_vec3();
                start(lift(point, normal, inward, &bounds), i)
            })
            .collect();
        let hidden = compare_starts("ball", triangles, LIGHTS[0], &starts);
        assert!(hidden > 50, "seed {seed}: {hidden}");
    }
}

/// A bumpy square of `2 n n` triangles across y, with a small roof over its middle.
fn terrain(random: &mut Random, n: usize, bump: f32, at: Vec3) -> Vec<[Vec3; 3]> {
    let heights: Vec<f32> = (0..(n + 1) * (n + 1))
        .map(|_| bump * random.unit())
        .collect();
    let point = |i: usize, j: usize| {
        let [x, z] = [i, j].map(|k| k as f32 / n as f32 * 2.0 - 1.0);
        at + Vec3::new(x, heights[i * (n + 1) + j], z)
    };
    let square = |(i, j): (usize, usize)| {
        let [a, b] = [point(i, j), point(i + 1, j)];
        let [c, d] = [point(i, j + 1), point(i + 1, j + 1)];
        [[a, b, c], [d, c, b]]
    };
    let all = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    let mut triangles: Vec<[Vec3; 3]> = all.flat_map(square).collect();
    triangles.push([(-0.3, -0.2), (0.3, -0.1), (0.1, 0.3)].map(|(x, z)| at + Vec3::new(x, 0.6, z)));
    triangles
}

#[test]
fn rims_and_heights_of_surfaces_are_hidden_as_every_triangle_says() {
    for (seed, (bump, at)) in (0..).zip([
        (0.0, Vec3::ZERO),
        (0.1, Vec3::ZERO),
        (0.4, Vec3::ZERO),
        (0.1, Vec3::splat(500.0)),
        (0.1, Vec3::new(0.0, 3e5, 0.0)),
    ]) {
        let mut random = Random::new(seed);
        let triangles = terrain(&mut random, 9, bump, at);
        let mut starts = Vec::new();
        for (i, corners) in (0..).zip(&triangles) {
            let [a, b, c] = *corners;
            let normal = unit_normal(corners).as_vec3();
            for _ in 0..12 {
                // In the middle, at an edge, at a corner; as far from the plane as the bounds of error, or not.
                let edge = [0.0, 1e-7, 1e-6, 1e-5, 0.4][random.below(5) as usize];
                let along = [0.0, 1e-6, 0.3, 0.6][random.below(4) as usize];
                let point = a + (b - a) * along + (c - a) * edge;
                let off =
                    [-1e-3, -1e-5, 0.0, 1e-7, 1e-6, 3e-6, 1e-5, 3e-5][random.below(8) as usize];
                starts.push(start(point + normal * off, i));
            }
        }
        let hidden = LIGHTS.map(|l| compare_starts("terrain", triangles.clone(), l, &starts));
        let (most, all) = (hidden.iter().max(), hidden.iter().sum::<usize>());
        assert!(
            all > 300 && most < Some(&starts.len()),
            "seed {seed}: {hidden:?}"
        );
    }
}

/// A ground of two triangles under `n` walls of sizes down to a thousandth, some of them as thin as the rounding.
fn walls(random: &mut Random, n: usize, at: Vec3) -> Vec<[Vec3; 3]> {
    let corner = |x: f32, z: f32| at + Vec3::new(x, 0.0, z);
    let [a, b, c, d] =
        [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)].map(|(x, z)| corner(x, z));
    let mut triangles = vec![[a, b, c], [c, d, a]];
    for _ in 0..n {
        let low = corner(random.range(-3.0, 3.0), random.range(-3.0, 3.0));
        let size = [1.0, 0.1, 0.01, 1e-3][random.below(4) as usize];
        let along = [Vec3::X, Vec3::Z, random.point(), Vec3::X * 1e-6][random.below(4) as usize];
        let high = low + Vec3::Y * size;
        triangles.push([low, low + along * size, high]);
        triangles.push([high + along * size, high, low + along * size]);
    }
    triangles
}

#[test]
fn walls_on_a_large_ground_are_hidden_as_every_triangle_says() {
    for (seed, at) in (0..).zip([Vec3::ZERO, Vec3::splat(400.0)]) {
        let mut random = Random::new(seed);
        let triangles = walls(&mut random, 60, at);
        let mut starts = Vec::new();
        for (i, corners) in (0..).zip(&triangles) {
            let [a, b, c] = *corners;
            let normal = unit_normal(corners).as_vec3();
            for _ in 0..if i < 2 { 300 } else { 12 } {
                // Near what stands there, on the ground and off it by about what rounding does.
                let point = if i < 2 {
                    let [p, q, _] = triangles[2 + random.below(120) as usize];
                    let foot = p + (q - p) * random.range(-0.5, 1.5);
                    Vec3::new(foot.x, at.y, foot.z)
                } else {
                    a + (b - a) * random.unit() + (c - a) * random.unit()
                };
                let off =
                    [-1e-4, -1e-5, -1e-6, 0.0, 1e-6, 1e-5, 1e-4, 1e-3][random.below(8) as usize];
                starts.push(start(point + normal * off, i));
            }
        }
        let hidden = LIGHTS.map(|l| compare_starts("walls", triangles.clone(), l, &starts));
        assert!(
            hidden.iter().sum::<usize>() > 300,
            "seed {seed}: {hidden:?}"
        );
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
