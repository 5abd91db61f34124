//! Free rays against every triangle: the same triangle at the same distance, to the bit, at every width that this
//! CPU has.

mod common;

use common::{ball, look_at, scene, soup};
use glam::{Quat, Vec3};
use raybomb::camera::View;
use raybomb::frame::{Hit, Hits, MISS};
use raybomb::math::Random;
use raybomb::render::{Engine, Progress, Renderer};
use raybomb::simd::Kernel;
use raybomb::trace::free::{self, FreeTracer, Ray, RayTree, brute, lift};
use raybomb::world::World;

/// Traces at all widths, one by one and as many, closest and any hit, and compares; the hits.
fn compare(name: &str, world: &World, rays: &[Ray]) -> Vec<Hit> {
    let bvh = world.bvh();
    let expected: Vec<Hit> = rays
        .iter()
        .map(|ray| brute::closest_hit(world.corners(), &bvh.file_ids, ray))
        .collect();
    let tree = RayTree::build(world);
    for kernel in Kernel::available() {
        let mut tracer = FreeTracer::default();
        let mut hits = vec![Hit::NONE; rays.len()];
        tracer.closest_hits(kernel, bvh, rays, &mut hits);
        let mut of_many = vec![Hit { id: 7, t: 7.0 }; rays.len()];
        tree.closest_hits(kernel, &mut tracer, rays, &mut of_many);
        let mut any = vec![false; rays.len()];
        tracer.any_hits(kernel, bvh, rays, &mut any);
        for (i, ray) in rays.iter().enumerate() {
            let bits = |h: Hit| (h.id, h.t.to_bits());
            assert_eq!(
                bits(hits[i]),
                bits(expected[i]),
                "{name}, {}: {ray:?}",
                kernel.name()
            );
            assert_eq!(
                bits(of_many[i]),
                bits(expected[i]),
                "{name}, {}, as one of many: {ray:?}",
                kernel.name()
            );
            assert_eq!(
                any[i],
                expected[i].id != MISS,
                "{name}, {}, any hit: {ray:?}",
                kernel.name()
            );
        }
    }
    expected
}

fn hit_count(hits: &[Hit]) -> usize {
    hits.iter().filter(|h| h.id != MISS).count()
}

#[test]
fn random_rays_hit_what_every_triangle_says() {
    for seed in 0..12 {
        let mut random = Random::new(seed);
        let world = World::compile(&scene(soup(&mut random, 40 + 30 * seed as usize)));
        let rays: Vec<Ray> = (0..400)
            .map(|i| {
                let mut ray = Ray::new(random.point() * 1.5, random.point());
                if i % 3 == 0 {
                    ray.t_min = random.unit();
                    ray.t_max = ray.t_min + 2.0 * random.unit();
                }
                ray
            })
            .collect();
        let hits = compare(&format!("soup of seed {seed}"), &world, &rays);
        assert!(hit_count(&hits) > 25, "seed {seed}: {}", hit_count(&hits));
    }
}

#[test]
fn rays_along_axes_and_planes_hit_what_every_triangle_says() {
    // Corners and origins on a small grid: rays run along edges and in planes, and distances tie.
    for seed in 0..8 {
        let mut random = Random::new(100 + seed);
        let mut whole = |span: u32| {
            Vec3::from_array([(); 3].map(|()| random.below(span) as f32 - (span / 2) as f32))
        };
        let triangles: Vec<_> = (0..120).map(|_| [(); 3].map(|()| whole(5))).collect();
        let world = World::compile(&scene(triangles));
        let rays: Vec<Ray> = (0..500).map(|_| Ray::new(whole(7), whole(3))).collect();
        let hits = compare(&format!("grid of seed {seed}"), &world, &rays);
        assert!(hit_count(&hits) > 25, "seed {seed}: {}", hit_count(&hits));
    }
}

/// Mirror rays, as neighbouring pixels send them on: `facets` small sets of rays, each of which keeps together.
fn bundles(random: &mut Random, facets: usize, size: u32) -> Vec<Ray> {
    let mut rays = Vec::new();
    for _ in 0..facets {
        let (origin, dir) = (random.point() * 2.0, random.point());
        let spread = random.unit() * 0.4;
        for _ in 0..1 + random.below(size) {
            let mut ray = Ray::new(
                origin + random.point() * 0.1,
                (dir + random.point() * spread) * (0.5 + random.unit()),
            );
            if random.below(8) == 0 {
                ray.t_min = random.unit();
                ray.t_max = ray.t_min + 2.0 * random.unit();
            }
            rays.push(ray);
        }
    }
    rays
}

#[test]
fn rays_that_keep_together_hit_what_every_triangle_says() {
    for seed in 0..6 {
        let mut random = Random::new(300 + seed);
        let mut triangles = soup(&mut random, 150);
        triangles.extend(ball(&mut random, 8, 0.1, Vec3::ZERO));
        let world = World::compile(&scene(triangles));
        let mut rays = bundles(&mut random, 12, 90);
        // One that is not tame, and one that is none, among the others.
        rays[20].dir *= 1e-20;
        rays[40].origin.x = f32::NAN;
        rays[60].t_max = f32::NAN;
        rays[61].t_max = -1.0;
        let hits = compare(&format!("bundles of seed {seed}"), &world, &rays);
        assert!(hit_count(&hits) > 25, "seed {seed}: {}", hit_count(&hits));
    }
}

/// The twelve triangles of a box with these corners.
fn room(low: Vec3, high: Vec3) -> Vec<[Vec3; 3]> {
    let mut walls = Vec::new();
    for across in 0..3 {
        let (u, v) = ((across + 1) % 3, (across + 2) % 3);
        for side in [low, high] {
            let corner = |a: Vec3, b: Vec3| {
                let mut p = side;
                p[u] = a[u];
                p[v] = b[v];
                p
            };
            let [p, q, r, s] = [
                corner(low, low),
                corner(high, low),
                corner(high, high),
                corner(low, high),
            ];
            walls.extend([[p, q, r], [p, r, s]]);
        }
    }
    walls
}

#[test]
fn rays_that_leave_plane_mirrors_hit_what_every_triangle_says() {
    for seed in 0..6 {
        let mut random = Random::new(500 + seed);
        let mut triangles = room(Vec3::splat(-2.0), Vec3::new(2.0, 1.5, 2.0));
        triangles.extend(room(Vec3::new(-0.5, -2.0, 0.1), Vec3::new(0.2, 0.4, 0.9)));
        triangles.extend(
            ball(&mut random, 5, 0.1, Vec3::ZERO)
                .iter()
                .map(|t| t.map(|p| p * 0.3 + Vec3::new(1.0, -0.8, -0.6))),
        );
        // Walls across the axes, walls that are not, and far away from the origin.
        if seed % 3 != 0 {
            let turn = Quat::from_axis_angle(random.point().normalize(), 3.0 * random.unit());
            let far = Vec3::splat(if seed % 3 == 1 { 0.0 } else { 300.0 });
            triangles = triangles
                .iter()
                .map(|t| t.map(|p| turn * p + far))
                .collect();
        }
        let world = World::compile(&scene(triangles.clone()));
        let bounds = world.bounds();
        let eye = (bounds.min + bounds.max) * 0.5 + random.point() * 0.6;
        // Squares of 8x8 pixels that look anywhere.
        let mut rays = Vec::new();
        for _ in 0..12 {
            let (to, right, up) = (random.point(), random.point(), random.point());
            for i in 0..64 {
                let (x, y) = ((i % 8) as f32 / 300.0, (i / 8) as f32 / 300.0);
                let seen = Ray::new(eye, to + right * x + up * y);
                let Some(pick) = free::closest_hit(Kernel::best(), &world, &seen) else {
                    continue;
                };
                let corners = &triangles[pick.triangle as usize];
                let normal = raybomb::geometry::unit_normal(corners).as_vec3();
                let mut ray = Ray::new(
                    lift(pick.point, normal, seen.dir, &bounds),
                    seen.dir - normal * (2.0 * seen.dir.dot(normal)),
                );
                if i == 40 {
                    ray.t_min = 2.0 * random.unit();
                    ray.t_max = ray.t_min + 2.0 * random.unit();
                }
                rays.push(ray);
            }
        }
        let hits = compare(&format!("mirrors of seed {seed}"), &world, &rays);
        assert!(hit_count(&hits) > 600, "seed {seed}: {}", hit_count(&hits));
    }
}

#[test]
fn beams_that_start_on_and_beside_a_surface_hit_what_every_triangle_says() {
    for seed in 0..4 {
        let mut random = Random::new(600 + seed);
        let triangles = ball(&mut random, 6, 0.1, Vec3::splat(seed as f32));
        let world = World::compile(&scene(triangles.clone()));
        let mut rays = Vec::new();
        for _ in 0..60 {
            let t = &triangles[random.below(triangles.len() as u32) as usize];
            let normal = raybomb::geometry::unit_normal(t).as_vec3();
            let along = (t[1] - t[0]).normalize();
            // How far off the surface all start, and how steeply they leave it: some of a beam may come back.
            let off = [0.0, 1e-7, 1e-5, 1e-2][random.below(4) as usize] * (random.unit() - 0.5);
            let steep = [1.0, 0.2, 0.02, 0.0][random.below(4) as usize] * (random.unit() - 0.3);
            for _ in 0..64 {
                let (a, b) = (random.unit(), random.unit());
                let on_it = t[0] + (t[1] - t[0]) * a + (t[2] - t[0]) * b * (1.0 - a);
                rays.push(Ray::new(
                    on_it + normal * off,
                    along + normal * steep + random.point() * 0.03,
                ));
            }
        }
        let hits = compare(&format!("the surface of seed {seed}"), &world, &rays);
        assert!(hit_count(&hits) > 400 && hit_count(&hits) < rays.len() - 400);
    }
}

#[test]
fn parallel_rays_through_corners_and_along_edges_hit_what_every_triangle_says() {
    for seed in 0..6 {
        let mut random = Random::new(400 + seed);
        let mut whole = |span: u32| {
            Vec3::from_array([(); 3].map(|()| random.below(span) as f32 - (span / 2) as f32))
        };
        let triangles: Vec<_> = (0..120).map(|_| [(); 3].map(|()| whole(5))).collect();
        let world = World::compile(&scene(triangles));
        let mut rays = Vec::new();
        for _ in 0..5 {
            let dir = whole(3);
            rays.extend((0..100).map(|_| Ray::new(whole(7) - dir * 2.0, dir)));
        }
        let hits = compare(&format!("parallel rays of seed {seed}"), &world, &rays);
        assert!(hit_count(&hits) > 10, "seed {seed}: {}", hit_count(&hits));
    }
}

#[test]
fn rays_that_start_on_corners_edges_and_faces_hit_what_every_triangle_says() {
    let mut random = Random::new(7);
    let triangles = ball(&mut random, 8, 0.3, Vec3::new(0.3, -0.2, 0.1));
    let world = World::compile(&scene(triangles.clone()));
    let rays: Vec<Ray> = (0..1500)
        .map(|i| {
            let [a, b, c] = triangles[random.below(triangles.len() as u32) as usize];
            let origin = match i % 3 {
                0 => a,
                1 => a + (b - a) * random.unit(),
                _ => (a + b + c) / 3.0,
            };
            Ray::new(origin, random.point())
        })
        .collect();
    let hits = compare("ball", &world, &rays);
    assert!(hit_count(&hits) > 300);
}

#[test]
fn huge_tiny_and_far_scenes_hit_what_every_triangle_says() {
    for (scale, far) in [
        (1e-30f32, 0.0f32),
        (1e-17, 0.0),
        (1e-12, 0.0),
        (1e-3, 500.0),
        (1.0, 1e5),
        (1e6, 0.0),
        (1e14, 0.0),
        (1e25, 0.0),
    ] {
        let mut random = Random::new(scale.to_bits().into());
        let at = Vec3::splat(far);
        let triangles = soup(&mut random, 60)
            .iter()
            .map(|t| t.map(|p| p * scale + at))
            .collect();
        let world = World::compile(&scene(triangles));
        for length in [1e-20f32, 1.0, 1e18] {
            let rays: Vec<Ray> = (0..60)
                .map(|_| {
                    let origin = random.point() * (2.0 * scale) + at;
                    Ray::new(origin, -random.point() * length)
                })
                .collect();
            let hits = compare(&format!("scale {scale}, {far} away"), &world, &rays);
            assert!(hit_count(&hits) > 1, "scale {scale}, length {length}");
        }
    }
}

#[test]
fn what_is_no_ray_hits_nothing() {
    let world = World::compile(&scene(soup(&mut Random::new(3), 50)));
    let rays = [
        Ray::new(Vec3::ZERO, Vec3::ZERO),
        Ray::new(Vec3::NAN, Vec3::X),
        Ray::new(Vec3::ZERO, Vec3::INFINITY),
        Ray {
            t_min: f32::NAN,
            ..Ray::new(Vec3::splat(-2.0), Vec3::ONE)
        },
    ];
    assert_eq!(hit_count(&compare("no rays", &world, &rays)), 0);
    let nothing = World::compile(&scene(Vec::new()));
    let ray = [Ray::new(Vec3::ZERO, Vec3::X)];
    assert_eq!(hit_count(&compare("no triangles", &nothing, &ray)), 0);
}

#[test]
fn no_ray_leaves_a_closed_mesh() {
    for (seed, n, bump, far) in [(1, 6, 0.4, 0.0), (2, 14, 0.1, 500.0), (3, 40, 0.0, 1e5)] {
        let mut random = Random::new(seed);
        let centre = Vec3::splat(far);
        let triangles = ball(&mut random, n, bump, centre);
        let world = World::compile(&scene(triangles.clone()));
        // From near the centre, at every corner and at points of every edge.
        let mut rays = Vec::new();
        for [a, b, c] in triangles {
            let origin = centre + random.point() * 0.3;
            for (p, q) in [(a, b), (b, c), (c, a)] {
                rays.push(Ray::new(origin, p - origin));
                rays.push(Ray::new(origin, p + (q - p) * random.unit() - origin));
            }
        }
        for kernel in Kernel::available() {
            let mut any = vec![false; rays.len()];
            FreeTracer::default().any_hits(kernel, world.bvh(), &rays, &mut any);
            let through = any.iter().filter(|&&hit| !hit).count();
            assert_eq!(through, 0, "{n} rows, {far} away, {}", kernel.name());
        }
    }
}

#[test]
fn lifted_origins_do_not_hit_their_own_surface() {
    let mut random = Random::new(5);
    let triangles = ball(&mut random, 10, 0.0, Vec3::new(3.0, 1.0, -2.0));
    let world = World::compile(&scene(triangles.clone()));
    for corners in &triangles {
        let normal = raybomb::geometry::unit_normal(corners).as_vec3();
        let at = [random.unit(), random.unit()];
        let [a, b, c] = *corners;
        let point = a + ((b - a) + (c - b) * at[1]) * at[0];
        let outward = point - Vec3::new(3.0, 1.0, -2.0);
        // Seen from outside: whatever leaves there meets nothing of a convex body.
        let origin = lift(point, normal, -outward, &world.bounds());
        let outside = if normal.dot(outward) > 0.0 {
            normal
        } else {
            -normal
        };
        let ray = Ray::new(origin, outside + random.point() * 0.5);
        assert_eq!(free::closest_hit(Kernel::best(), &world, &ray), None);
    }
}

#[test]
fn free_rays_meet_what_the_picture_shows_but_for_outlines() {
    let mut random = Random::new(9);
    let world = World::compile(&scene(soup(&mut random, 200)));
    let camera = look_at(Vec3::new(0.5, 1.0, 4.0), Vec3::ZERO, 0.5, 1.0);
    let view = View::new(&camera, 48, 48);
    let mut hits = Hits::default();
    Renderer::new(1)
        .expect("a thread")
        .hits(
            &world,
            &view,
            Engine::Fast,
            Kernel::best(),
            &mut hits,
            &Progress::new(),
        )
        .expect("nobody cancels");
    let mut differing = 0;
    for (i, shown) in hits.pixels.iter().enumerate() {
        let (x, y) = (i % 48, i / 48);
        let ray = Ray::new(view.eye, view.direction(x, y).as_vec3());
        let met = free::closest_hit(Kernel::best(), &world, &ray);
        differing += usize::from(met.map_or(MISS, |p| p.triangle) != shown.id);
    }
    // The two rules round a corner in frames of their own: at outlines they may differ.
    assert!(
        hit_count(&hits.pixels) > 1000 && differing <= 3,
        "{differing}"
    );
}
