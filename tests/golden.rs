//! Small pictures of every view, compared exactly at every width and several thread counts with those in
//! `tests/golden/`. `UPDATE_GOLDEN=1` renews them; a difference is written to `tests/out/` as expected | difference |
//! actual.

mod common;

use std::path::Path;

use common::{ball, look_at, scene};
use glam::Vec3;
use raybomb::camera::{Camera, View};
use raybomb::export::save_picture;
use raybomb::frame::Frame;
use raybomb::math::Random;
use raybomb::render::{Engine, Progress, Reflection, Renderer, Settings, ViewMode};
use raybomb::scene::Scene;
use raybomb::simd::Kernel;
use raybomb::world::World;

const VIEWS: [(&str, ViewMode, Reflection); 5] = [
    ("shaded", ViewMode::Shaded, Reflection::Mirror),
    ("as-printed", ViewMode::Shaded, Reflection::AsPrinted),
    ("id", ViewMode::Id, Reflection::Mirror),
    ("normal", ViewMode::Normal, Reflection::Mirror),
    ("depth", ViewMode::Depth, Reflection::Mirror),
];

fn scenes() -> Vec<(&'static str, Scene, Camera)> {
    let mut r = Random::new(77);
    let camera = look_at(Vec3::new(1.0, 1.2, 2.6), Vec3::ZERO, 0.5, 4.0 / 3.0);
    let soup = (0..60)
        .map(|_| {
            let p = r.point();
            [p, p + r.point() * 0.7, p + r.point() * 0.7]
        })
        .collect();
    // A room seen from inside: triangles that reach behind the eye.
    let inside = look_at(
        Vec3::new(0.2, 0.1, 0.3),
        Vec3::new(-0.5, -0.3, -1.0),
        0.9,
        4.0 / 3.0,
    );
    vec![
        ("soup", scene(soup), camera),
        ("ball", scene(ball(&mut r, 9, 0.25, Vec3::ZERO)), camera),
        ("room", scene(ball(&mut r, 3, 0.0, Vec3::ZERO)), inside),
    ]
}

fn render(renderer: &Renderer, world: &World, camera: &Camera, settings: &Settings) -> Frame {
    let mut frame = Frame::default();
    renderer
        .picture(
            world,
            &View::new(camera, 128, 96),
            settings,
            &mut frame,
            &Progress::new(),
        )
        .expect("nobody cancels");
    frame
}

fn read(path: &Path) -> Option<Frame> {
    let file = std::io::BufReader::new(std::fs::File::open(path).ok()?);
    let mut reader = ::png::Decoder::new(file).read_info().expect("a PNG file");
    let mut bytes = vec![0; reader.output_buffer_size().expect("a small picture")];
    let info = reader.next_frame(&mut bytes).expect("a whole PNG file");
    let pixels = bytes
        .chunks_exact(3)
        .map(|c| u32::from_be_bytes([0, c[0], c[1], c[2]]))
        .collect();
    Some(Frame {
        width: info.width as usize,
        height: info.height as usize,
        pixels,
    })
}

fn write(path: &Path, frame: &Frame) {
    std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder to write to");
    save_picture(path, frame).expect("a written file");
}

/// Expected, difference and actual side by side.
fn triptych(expected: &Frame, actual: &Frame) -> Frame {
    let (w, h) = (actual.width, actual.height);
    let mut out = Frame::new(3 * w, h);
    for y in 0..h {
        for x in 0..w {
            let (e, a) = (expected.pixels[y * w + x], actual.pixels[y * w + x]);
            let difference = if e == a { 0 } else { 0x00ff_ffff };
            for (i, p) in [e, difference, a].into_iter().enumerate() {
                out.pixels[y * 3 * w + i * w + x] = p;
            }
        }
    }
    out
}

#[test]
fn pictures_are_the_same_bits_everywhere() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let renew = std::env::var_os("UPDATE_GOLDEN").is_some();
    let renderers = [1, 3].map(|n| Renderer::new(n).expect("threads"));
    let mut wrong = Vec::new();
    for (scene_name, scene, camera) in scenes() {
        let world = World::compile(&scene);
        for (view_name, mode, reflection) in VIEWS {
            let name = format!("{scene_name}-{view_name}.png");
            let settings = |engine, kernel| Settings {
                engine,
                kernel,
                mode,
                reflection,
                ..Settings::default()
            };
            let brute = settings(Engine::Brute, Kernel::Scalar);
            let brute = render(&renderers[0], &world, &camera, &brute);
            let path = root.join("golden").join(&name);
            if renew {
                write(&path, &brute);
            }
            let expected = read(&path)
                .unwrap_or_else(|| panic!("no tests/golden/{name}: UPDATE_GOLDEN=1 makes it"));
            let mut check = |what: String, actual: &Frame| {
                if *actual != expected {
                    write(&root.join("out").join(&name), &triptych(&expected, actual));
                    wrong.push(format!("{name} by {what}"));
                }
            };
            check("brute force".into(), &brute);
            for kernel in Kernel::available() {
                for renderer in &renderers {
                    let actual = render(renderer, &world, &camera, &settings(Engine::Fast, kernel));
                    check(
                        format!("{} at {} threads", kernel.name(), renderer.threads()),
                        &actual,
                    );
                }
            }
        }
    }
    assert!(wrong.is_empty(), "see tests/out: {wrong:#?}");
}
