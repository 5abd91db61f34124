//! The fast engine against brute force: the same triangle at the same distance for every pixel, to the bit, at every
//! width that this CPU has and for several thread counts.

mod common;

use common::{ball, look_at, scene};
use glam::Vec3;
use raybomb::camera::{Camera, View};
use raybomb::frame::{Frame, Hits};
use raybomb::math::Random;
use raybomb::render::{Engine, Progress, Renderer, Settings};
use raybomb::scene::Scene;
use raybomb::simd::Kernel;
use raybomb::world::World;

fn trace(renderer: &Renderer, world: &World, view: &View, engine: Engine, kernel: Kernel) -> Hits {
    let mut hits = Hits::default();
    renderer
        .hits(world, view, engine, kernel, &mut hits, &Progress::new())
        .expect("nobody cancels");
    hits
}

/// Compares at all widths; how many pixels hit something.
fn compare(
    renderers: &[Renderer],
    name: &str,
    scene: &Scene,
    camera: &Camera,
    size: (usize, usize),
) -> usize {
    let world = renderers[0].install(|| World::compile(scene));
    world
        .bvh()
        .validate(&scene.triangles)
        .expect("a valid tree");
    let view = View::new(camera, size.0, size.1);
    let expected = trace(&renderers[0], &world, &view, Engine::Brute, Kernel::Scalar);
    for (i, kernel) in Kernel::available().into_iter().enumerate() {
        // Every kernel with every thread count over the scenes, one count a scene: they are independent.
        let renderer = &renderers[(i + name.len()) % renderers.len()];
        let fast = trace(renderer, &world, &view, Engine::Fast, kernel);
        let bits = |h: &raybomb::frame::Hit| (h.id, h.t.to_bits());
        let differing = expected
            .pixels
            .iter()
            .zip(&fast.pixels)
            .filter(|(a, b)| bits(a) != bits(b));
        let examples: Vec<_> = expected
            .pixels
            .iter()
            .zip(&fast.pixels)
            .enumerate()
            .filter(|(_, (a, b))| bits(a) != bits(b))
            .take(3)
            .map(|(i, (a, b))| (i % size.0, i / size.0, *a, *b))
            .collect();
        assert_eq!(
            differing.count(),
            0,
            "{name}, {} at {} threads: (x, y, brute, fast) {examples:?}",
            kernel.name(),
            renderer.threads()
        );
    }
    expected.pixels.iter().filter(|h| h.t.is_finite()).count()
}

fn renderers() -> Vec<Renderer> {
    [1, 2, 3, 7]
        .map(|n| Renderer::new(n).expect("threads"))
        .into()
}

fn report_kernels() {
    let missing: Vec<_> = Kernel::ALL
        .into_iter()
        .filter(|k| !Kernel::available().contains(k))
        .collect();
    println!(
        "kernels tested: {:?}; not on this CPU: {missing:?}",
        Kernel::available()
    );
}

/// Triangles of one random scene: the seed chooses count, size, spread and scale.
fn random_scene(seed: u64) -> (Scene, Camera) {
    let mut r = Random::new(seed);
    let count = 1 + r.below(400) as usize;
    let size = [0.01, 0.05, 0.3, 2.0][r.below(4) as usize];
    let snap = r.below(3) == 0;
    let offset = if r.below(3) == 0 {
        r.point() * 500.0
    } else {
        Vec3::ZERO
    };
    // On a grid, corners, edges and planes coincide all the time.
    let place = |p: Vec3| if snap { (p * 8.0).round() / 8.0 } else { p };
    let triangles = (0..count)
        .map(|_| {
            let p = r.point();
            [p, p + r.point() * size, p + r.point() * size].map(|q| place(q) + offset)
        })
        .collect();
    let eye = place(r.point() * [0.5, 1.5, 4.0][r.below(3) as usize]) + offset;
    let mut target = place(r.point() * 0.3) + offset;
    if target == eye {
        target += Vec3::X;
    }
    let tan = f64::from(r.range(0.1, 1.2));
    (scene(triangles), look_at(eye, target, tan, 1.3))
}

#[test]
fn random_scenes() {
    report_kernels();
    let renderers = renderers();
    let mut hit = 0;
    for seed in 0..240 {
        let (scene, camera) = random_scene(seed);
        hit += compare(
            &renderers,
            &format!("seed {seed}"),
            &scene,
            &camera,
            (100, 76),
        );
    }
    assert!(hit > 240 * 100 * 76 / 10, "only {hit} pixels hit anything");
}

/// Most leaves and boxes lie between the centres of pixels here, and tiles end at the first pixel, early and late.
#[test]
fn more_triangles_than_pixels_in_pictures_of_odd_sizes() {
    let renderers = renderers();
    let mut random = Random::new(3);
    // Most leaves of the ball lie between pixels. Those of the cloud behind it overlap along the way.
    let mut triangles = ball(&mut random, 150, 0.01, Vec3::new(-0.7, 0.0, 0.7));
    triangles.extend((0..50_000).map(|_| {
        let middle = Vec3::new(0.8, 0.0, -1.0) + random.point();
        [(); 3].map(|()| middle + random.point() * 0.03)
    }));
    let scene = scene(triangles);
    let camera = look_at(Vec3::new(0.0, 0.4, 4.5), Vec3::ZERO, 0.4, 1.3);
    for size in [(40, 30), (20, 15), (9, 7), (65, 3), (1, 70)] {
        let hit = compare(&renderers, &format!("{size:?}"), &scene, &camera, size);
        assert!(hit > 0 && hit < scene.triangles.len(), "{size:?}: {hit}");
    }
}

/// A named scene and its camera.
type Case = (&'static str, Vec<[Vec3; 3]>, Camera);

fn hard_cases() -> Vec<Case> {
    let mut r = Random::new(5);
    let front = look_at(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, 0.5, 1.3);
    let one = [
        Vec3::new(-1.0, -1.0, 0.0),
        Vec3::new(1.0, -1.0, 0.0),
        Vec3::new(0.0, 1.0, 0.0),
    ];
    let square = |z: f32, s: f32| {
        let p = |x: f32, y: f32| Vec3::new(x * s, y * s, z);
        [
            [p(-1., -1.), p(1., -1.), p(-1., 1.)],
            [p(1., 1.), p(-1., 1.), p(1., -1.)],
        ]
    };
    let slivers = |r: &mut Random, length: f32, n: usize| -> Vec<[Vec3; 3]> {
        (0..n)
            .map(|_| {
                let (p, d) = (r.point(), r.point() * length);
                [p - d, p + d, p + r.point() * 1e-3]
            })
            .collect()
    };
    let soup = |r: &mut Random, scale: f32| -> Vec<[Vec3; 3]> {
        (0..200)
            .map(|_| {
                let p = r.point();
                [p, p + r.point() * 0.3, p + r.point() * 0.3].map(|p| p * scale)
            })
            .collect()
    };
    let mut cases: Vec<Case> = vec![
        ("nothing", vec![], front),
        ("one triangle", vec![one], front),
        (
            "one triangle, turned over",
            vec![[one[0], one[2], one[1]]],
            front,
        ),
        (
            "degenerate",
            vec![
                [Vec3::ZERO; 3],
                [Vec3::X, Vec3::X * 2.0, Vec3::X * 3.0],
                one,
            ],
            front,
        ),
        ("equal centroids", vec![one; 100], front),
        (
            "coplanar overlaps",
            (1..60).flat_map(|i| square(0.0, i as f32 / 40.0)).collect(),
            front,
        ),
        (
            "parallel layers a bit apart",
            (0..60).flat_map(|i| square(i as f32 * 1e-7, 0.8)).collect(),
            front,
        ),
        ("slivers", slivers(&mut r, 1.0, 300), front),
        ("slivers 1e5 long", slivers(&mut r, 1e5, 300), front),
        (
            "needles of one ulp",
            {
                let ulp = f32::EPSILON;
                (0..200)
                    .map(|_| {
                        let (p, d) = (r.point(), r.point());
                        [p, p + d, p + d * 0.5 + Vec3::new(ulp, 0.0, 0.0)]
                    })
                    .collect()
            },
            front,
        ),
    ];
    // An eye on a surface, on an edge, on a corner; and inside the plane of many triangles.
    let floor = square(0.0, 2.0).to_vec();
    let target = Vec3::new(0.3, 0.2, -1.0);
    for (name, eye) in [
        ("eye on a face", Vec3::new(0.3, 0.1, 0.0)),
        ("eye on an edge", Vec3::ZERO),
        ("eye on a corner", Vec3::new(2.0, 2.0, 0.0)),
        ("eye beside", Vec3::new(5.0, 0.0, 0.0)),
    ] {
        let mut triangles = floor.clone();
        triangles.extend(square(-1.0, 3.0));
        cases.push((name, triangles, look_at(eye, target, 0.8, 1.3)));
    }
    // Axis-parallel rays: a plane and triangles on a grid that the pixels' centres meet exactly.
    let grid: Vec<[Vec3; 3]> = (-4..4)
        .flat_map(|i| (-4..4).map(move |j| (i as f32, j as f32)))
        .flat_map(|(x, y)| {
            let p = |dx: f32, dy: f32| Vec3::new(x + dx, y + dy, -4.0);
            [
                [p(0., 0.), p(1., 0.), p(0., 1.)],
                [p(1., 0.), p(1., 1.), p(0., 1.)],
            ]
        })
        .collect();
    let parallel = Camera {
        eye: glam::DVec3::ZERO,
        top_left: glam::DVec3::new(-4.0, 4.0, -4.0),
        top_right: glam::DVec3::new(4.0, 4.0, -4.0),
        bottom_left: glam::DVec3::new(-4.0, -4.0, -4.0),
    };
    cases.push(("axis-parallel", grid.clone(), parallel));
    cases.push((
        "seen edge-on",
        grid.iter()
            .map(|t| t.map(|p| Vec3::new(p.x, 0.0, p.y)))
            .collect(),
        parallel,
    ));
    for (name, scale) in [
        ("1e-30", 1e-30f32),
        ("1e-15", 1e-15),
        ("1e15", 1e15),
        ("1e30", 1e30),
        ("1e37", 1e37),
    ] {
        let eye = Vec3::new(0.0, 0.0, 2.0) * scale;
        cases.push((
            name,
            soup(&mut r, scale),
            look_at(eye, Vec3::ZERO, 0.5, 1.3),
        ));
    }
    // From micrometres to light years in one scene.
    let mixed = (-30..=30)
        .flat_map(|e| {
            let s = 10f32.powi(e);
            soup(&mut r, s).into_iter().take(20).collect::<Vec<_>>()
        })
        .collect();
    cases.push((
        "all scales at once",
        mixed,
        look_at(Vec3::new(0.0, 0.0, 2.0), Vec3::ZERO, 0.5, 1.3),
    ));
    let near = ball(&mut r, 12, 0.3, Vec3::ZERO);
    cases.push((
        "through a telescope",
        near.clone(),
        look_at(Vec3::new(0.0, 0.0, 5.0), Vec3::X * 0.2, 1e-7, 1.3),
    ));
    cases.push((
        "absurd camera",
        near,
        look_at(Vec3::new(0.0, 0.0, 5.0), Vec3::X * 0.2, 1e-14, 1.3),
    ));
    let mut huge_and_tiny = ball(&mut r, 10, 0.3, Vec3::ZERO);
    huge_and_tiny.extend(square(-2.0, 1e6));
    huge_and_tiny.extend(square(-3.0, 1e9));
    cases.push(("huge triangles among small ones", huge_and_tiny, front));
    cases
}

/// Seen along the axis of the one tile, all of a plane is at one distance: whatever the order of the leaves, the lower
/// number wins.
#[test]
fn leaves_that_tie_with_what_stands_are_not_hidden() {
    let camera = Camera {
        eye: glam::DVec3::ZERO,
        top_left: glam::DVec3::new(-4.0, 4.0, -4.0),
        top_right: glam::DVec3::new(4.0, 4.0, -4.0),
        bottom_left: glam::DVec3::new(-4.0, -4.0, -4.0),
    };
    let mut random = Random::new(11);
    let mut layers = vec![[
        Vec3::new(-9.0, 9.0, -4.0),
        Vec3::new(9.0, 9.0, -4.0),
        Vec3::new(0.0, -30.0, -4.0),
    ]];
    for _ in 0..2000 {
        let corner = Vec3::new(random.range(-4.0, 4.0), random.range(-4.0, 4.0), -4.0);
        layers.push([corner, corner + Vec3::X * 0.4, corner + Vec3::Y * 0.4]);
    }
    // The one that covers all has the highest number.
    layers.rotate_left(1);
    compare(&renderers(), "one plane", &scene(layers), &camera, (64, 64));
}

/// Many small steep triangles in front of each other, those in front not always first: most pairs of triangle and
/// pixels are hidden, by next to nothing.
#[test]
fn small_triangles_behind_each_other() {
    let mut random = Random::new(23);
    let triangles = (0..6000)
        .map(|_| {
            let middle = Vec3::new(random.range(-1.2, 1.2), random.range(-0.8, 0.8), 0.0);
            [(); 3].map(|()| middle + random.point() * Vec3::new(0.07, 0.07, 0.5))
        })
        .collect();
    let camera = look_at(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, 0.4, 1.3);
    compare(
        &renderers(),
        "crowd",
        &scene(triangles),
        &camera,
        (200, 150),
    );
}

/// Every triangle of a leaf may cover every pixel: as many pairs of triangle and pixels as there can be.
#[test]
fn tilted_triangles_that_all_cover_a_small_picture() {
    let renderers = renderers();
    let mut random = Random::new(31);
    let camera = look_at(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, 0.4, 1.0);
    for seed in 0..30 {
        let triangles = (0..16)
            .map(|_| {
                [(-3.9, -1.8), (3.9, -1.8), (0.0, 5.0)]
                    .map(|(x, y)| Vec3::new(x, y, random.range(-2.0, 0.5)))
            })
            .collect();
        let name = format!("seed {seed}");
        let hit = compare(&renderers, &name, &scene(triangles), &camera, (16, 16));
        assert_eq!(hit, 16 * 16, "{name}");
    }
}

/// Tiles that one triangle covers whole, with others behind it, before it, through it and in its plane; in pictures that
/// end within a tile, a block and a unit. The pictures are shaded, too: that knows such tiles.
#[test]
fn tiles_that_one_triangle_covers() {
    let renderers = renderers();
    let mut random = Random::new(57);
    let sizes = [(64, 64), (150, 131), (129, 70), (61, 203), (192, 128)];
    for seed in 0..60 {
        let plane = |random: &mut Random| {
            let [x, y, z] = [0.4, 0.4, 2.0].map(|size| random.range(-size, size));
            [(-90.0, -50.0), (90.0, -50.0), (0.0, 120.0)]
                .map(|(px, py)| Vec3::new(px, py, x * px + y * py + z))
        };
        let mut triangles = vec![plane(&mut random)];
        match seed % 4 {
            1 => triangles.push(plane(&mut random)),
            // The same again, its corners in another order: a tie everywhere.
            2 => triangles.push({
                let [a, b, c] = triangles[0];
                [b, c, a]
            }),
            _ => {}
        }
        for _ in 0..[0, 0, 1, 5, 40, 40][seed % 6] {
            let middle = random.point() * Vec3::new(1.5, 1.5, 3.0);
            triangles.push([(); 3].map(|()| middle + random.point() * 0.2));
        }
        if seed % 5 == 0 {
            triangles.reverse();
        }
        let scene = scene(triangles);
        let eye = Vec3::new(random.range(-1.0, 1.0), random.range(-1.0, 1.0), 6.0);
        let camera = look_at(eye, Vec3::ZERO, 0.4, 1.2);
        let size = sizes[seed % sizes.len()];
        let hit = compare(&renderers, &format!("{seed}"), &scene, &camera, size);
        assert!(hit > size.0 * size.1 / 2, "{seed}: {hit} hits");

        let world = World::compile(&scene);
        let view = View::new(&camera, size.0, size.1);
        let picture = |engine: Engine, kernel: Kernel| {
            let settings = Settings {
                engine,
                kernel,
                ..Settings::default()
            };
            let mut frame = Frame::default();
            renderers[seed % renderers.len()]
                .picture(&world, &view, &settings, &mut frame, &Progress::new())
                .expect("nobody cancels");
            frame
        };
        let expected = picture(Engine::Brute, Kernel::Scalar);
        for kernel in Kernel::available() {
            let same = picture(Engine::Fast, kernel) == expected;
            assert!(same, "{seed}: another picture, {}", kernel.name());
        }
    }
}

#[test]
fn hard_scenes() {
    report_kernels();
    let renderers = renderers();
    for (name, triangles, camera) in hard_cases() {
        compare(&renderers, name, &scene(triangles), &camera, (150, 90));
    }
}

#[test]
fn any_number_of_threads_gives_the_same_hits() {
    let mut r = Random::new(3);
    let scene = scene(ball(&mut r, 40, 0.2, Vec3::ZERO));
    let camera = look_at(Vec3::new(0.0, 1.0, 3.0), Vec3::ZERO, 0.5, 1.3);
    let view = View::new(&camera, 640, 400);
    let renderers = renderers();
    let world = renderers[1].install(|| World::compile(&scene));
    for kernel in Kernel::available() {
        let one = trace(&renderers[0], &world, &view, Engine::Fast, kernel);
        for renderer in &renderers[1..] {
            let many = trace(renderer, &world, &view, Engine::Fast, kernel);
            assert_eq!(
                one,
                many,
                "{} at {} threads",
                kernel.name(),
                renderer.threads()
            );
        }
    }
}

#[test]
fn the_coarse_tree_shows_what_the_fine_one_shows() {
    let renderers = renderers();
    let mut r = Random::new(21);
    let ball = ball(&mut r, 40, 0.2, Vec3::ZERO);
    let camera = look_at(Vec3::new(0.0, 1.0, 3.0), Vec3::ZERO, 0.5, 1.3);
    let mut cases = hard_cases();
    cases.push(("a ball", ball, camera));
    for (name, triangles, camera) in cases {
        let scene = scene(triangles);
        let view = View::new(&camera, 150, 90);
        let fine = renderers[1].install(|| World::compile(&scene));
        let coarse = renderers[1].install(|| World::compile_coarse(&scene));
        assert_eq!(coarse.bvh().validate(&scene.triangles), Ok(()), "{name}");
        assert_eq!(fine.bounds(), coarse.bounds(), "{name}");
        for kernel in Kernel::available() {
            let [fine, coarse] = [&fine, &coarse]
                .map(|world| trace(&renderers[1], world, &view, Engine::Fast, kernel));
            assert_eq!(fine, coarse, "{name}, {}", kernel.name());
        }
    }
}
