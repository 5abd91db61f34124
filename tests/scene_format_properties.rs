//! The scene format over seeded random input: exact round trips, and no text that makes the reader panic.

use std::fs;
use std::path::Path;

use glam::Vec3;
use raybomb::color::Rgb;
use raybomb::math::Random;
use raybomb::scene::{
    Axis, CameraCorners, CameraSetting, Operation, ParseErrors, Scene, Triangle, locate_triangles,
    parse, write,
};

/// The body of the fuzz target `parse`.
#[path = "../fuzz/parse_body.rs"]
mod parse_body;

/// Any finite `f32`: all bit patterns, and the hard ones often.
fn any_f32(rng: &mut Random) -> f32 {
    const HARD: [f32; 10] = [
        0.0,
        -0.0,
        f32::MAX,
        f32::MIN,
        f32::MIN_POSITIVE,
        1e-45,
        -1e-45,
        1.175_494_2e-38,
        16_777_216.0,
        0.1,
    ];
    match rng.below(4) {
        0 => HARD[rng.below(10) as usize],
        1 => rng.below(2000) as f32 / 8.0 - 100.0,
        _ => loop {
            let value = f32::from_bits(rng.bits() as u32);
            if value.is_finite() {
                break value;
            }
        },
    }
}

fn any_point(rng: &mut Random) -> Vec3 {
    Vec3::new(any_f32(rng), any_f32(rng), any_f32(rng))
}

fn any_angle(rng: &mut Random) -> f64 {
    const HARD: [f64; 6] = [0.0, -0.0, f64::MAX, 5e-324, 0.1 + 0.2, std::f64::consts::PI];
    match rng.below(2) {
        0 => HARD[rng.below(6) as usize],
        _ => loop {
            let value = f64::from_bits(rng.bits());
            if value.is_finite() {
                break value;
            }
        },
    }
}

fn any_scene(rng: &mut Random) -> Scene {
    let camera = if rng.below(2) == 0 {
        CameraSetting::Default
    } else {
        // Corners that surely span a plane, an eye that surely is not in it.
        let size = f32::from_bits((1 + rng.below(200)) << 23);
        CameraSetting::Set(CameraCorners {
            eye: Vec3::new(any_f32(rng), any_f32(rng), size),
            top_left: Vec3::new(-size, size, 0.0),
            top_right: Vec3::new(size, size, -0.0),
            bottom_left: Vec3::new(-size, -size, 0.0),
        })
    };
    let light = loop {
        let light = any_point(rng);
        if light != Vec3::ZERO {
            break light;
        }
    };
    let triangle = |rng: &mut Random| {
        let [r, g, b, ..] = rng.bits().to_le_bytes();
        Triangle {
            corners: [any_point(rng), any_point(rng), any_point(rng)],
            color: Rgb::new(r, g, b),
        }
    };
    let operation = |rng: &mut Random| Operation {
        axis: [Axis::X, Axis::Y, Axis::Z][rng.below(3) as usize],
        angle_rad: any_angle(rng),
    };
    Scene {
        camera,
        light,
        triangles: (0..rng.below(30)).map(|_| triangle(rng)).collect(),
        operations: (0..rng.below(4)).map(|_| operation(rng)).collect(),
    }
}

/// All numbers of a scene as bits: `==` would take 0 for -0.
fn bits(scene: &Scene) -> Vec<u64> {
    let corners = match &scene.camera {
        CameraSetting::Default => vec![],
        CameraSetting::Set(c) => vec![c.eye, c.top_left, c.top_right, c.bottom_left],
    };
    let points = corners
        .into_iter()
        .chain([scene.light])
        .chain(scene.triangles.iter().flat_map(|t| t.corners));
    let coordinates = points
        .flat_map(|p| p.to_array())
        .map(|v| u64::from(v.to_bits()));
    let colors = scene.triangles.iter().map(|t| u64::from(t.color.packed()));
    let operations = scene
        .operations
        .iter()
        .flat_map(|o| [o.axis as u64, o.angle_rad.to_bits()]);
    coordinates.chain(colors).chain(operations).collect()
}

fn written(scene: &Scene) -> Vec<u8> {
    let mut out = Vec::new();
    write(scene, &mut out).expect("a Vec takes everything");
    out
}

#[test]
fn written_scenes_read_back_to_the_bit() {
    for seed in 0..2000 {
        let scene = any_scene(&mut Random::new(seed));
        let text = written(&scene);
        let again = parse(&text)
            .unwrap_or_else(|e| panic!("seed {seed}: {}", e.render("written", &text, false)));
        assert_eq!(bits(&again), bits(&scene), "seed {seed}");
        assert_eq!(written(&again), text, "seed {seed}");
    }
}

#[test]
fn a_large_scene_reads_back_to_the_bit() {
    let mut rng = Random::new(1);
    let mut scene = any_scene(&mut rng);
    while scene.triangles.len() < 100_000 {
        scene.triangles.extend(any_scene(&mut rng).triangles);
    }
    let text = written(&scene);
    assert!(
        text.len() > 5_000_000,
        "large enough to be read in parallel"
    );
    assert_eq!(bits(&parse(&text).unwrap()), bits(&scene));
    let last = scene.triangles.len() - 1;
    let header = locate_triangles(&text, [0])[0].line;
    assert_eq!(locate_triangles(&text, [last])[0].line, header + last);
}

#[test]
fn a_large_scene_tells_the_same_error_for_any_number_of_threads() {
    let line = "0.125 0 0 1 0 0 0 1 0 255 128 0\n";
    let mut text = format!("<d 0 0 1\n40000\n{}", line.repeat(40_000)).into_bytes();
    let at = text.len() - 100 * line.len();
    text[at] = b'q';
    let errors = |threads: usize| -> ParseErrors {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| parse(&text).unwrap_err())
    };
    let alone = errors(1);
    assert_eq!(alone.errors.len(), 1);
    assert_eq!(
        (alone.errors[0].line, alone.errors[0].column),
        (2 + 40_000 - 99, 1)
    );
    for threads in [2, 3, 7] {
        assert_eq!(errors(threads), alone, "{threads} threads");
    }
}

#[test]
fn random_bytes_never_panic() {
    const LIKELY: &[u8] = b"<<dsonxyz0123456789.-+eE \n\t\r#,";
    for seed in 0..20_000 {
        let mut rng = Random::new(seed);
        let text: Vec<u8> = (0..rng.below(200))
            .map(|_| match rng.below(8) {
                0 => rng.bits() as u8,
                _ => LIKELY[rng.below(LIKELY.len() as u32) as usize],
            })
            .collect();
        check(&text, seed);
    }
}

#[test]
fn mutated_files_never_panic() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes");
    let mut texts = Vec::new();
    for sub in ["bad", "good"] {
        for entry in fs::read_dir(folder.join(sub)).unwrap() {
            texts.push((
                entry.as_ref().unwrap().file_name(),
                fs::read(entry.unwrap().path()).unwrap(),
            ));
        }
    }
    texts.sort();
    for seed in 0..10_000 {
        let mut rng = Random::new(seed);
        let pick = |rng: &mut Random| texts[rng.below(texts.len() as u32) as usize].1.clone();
        let mut text = pick(&mut rng);
        for _ in 0..=rng.below(4) {
            let at = rng.below(text.len() as u32 + 1) as usize;
            match rng.below(4) {
                0 => text.truncate(at),
                1 => text.insert(at, rng.bits() as u8),
                2 => drop(text.drain(at.saturating_sub(5)..at)),
                // The beginning of one file and the end of another.
                _ => {
                    let other = pick(&mut rng);
                    text.truncate(at);
                    text.extend_from_slice(&other[at.min(other.len())..]);
                }
            }
        }
        check(&text, seed);
    }
}

/// [`parse_body::parse_and_write`], with the seed in the message.
fn check(text: &[u8], seed: u64) {
    let result = std::panic::catch_unwind(|| parse_body::parse_and_write(text));
    assert!(
        result.is_ok(),
        "seed {seed}: {:?}",
        String::from_utf8_lossy(text)
    );
}
