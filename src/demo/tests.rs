//! Every demo keeps its promises.

use super::*;
use crate::camera::Camera;
use crate::geometry;
use crate::scene::CameraSetting;

fn assets() -> std::path::PathBuf {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("assets")
}

fn text(scene: &Scene) -> Vec<u8> {
    let mut text = Vec::new();
    scene::write(scene, &mut text).expect("all numbers are finite");
    text
}

#[test]
fn demos_are_as_told_and_survive_a_file() {
    for demo in all() {
        let made = demo.scene();
        assert_eq!(made.triangles.len(), demo.triangles, "{}", demo.name);
        let flat = made
            .triangles
            .iter()
            .position(|t| geometry::is_degenerate(&t.corners));
        assert_eq!(flat, None, "{} has a degenerate triangle", demo.name);
        let read = scene::parse(&text(&made)).expect(demo.name);
        assert!(read == made, "{} reads back differently", demo.name);
    }
}

#[test]
fn cameras_are_16_to_9_and_their_pictures_move() {
    for demo in all() {
        let scene = demo.scene();
        assert!(!scene.operations.is_empty(), "{} stands still", demo.name);
        let CameraSetting::Set(corners) = scene.camera else {
            panic!("{} leaves the camera to chance", demo.name);
        };
        let size = Camera::from(corners).default_size();
        assert_eq!(size, DEFAULT_SIZE, "{}", demo.name);
    }
}

#[test]
fn scenes_are_centred_enough_to_turn_about_the_origin() {
    for demo in all() {
        let scene = demo.scene();
        let corners = || scene.triangles.iter().flat_map(|t| t.corners);
        let low = corners().reduce(glam::Vec3::min).expect("corners");
        let high = corners().reduce(glam::Vec3::max).expect("corners");
        let off = ((low + high) * 0.5).truncate().length();
        let size = (high - low).truncate().length();
        assert!(off < 0.1 * size, "{} is {off} off, size {size}", demo.name);
    }
}

#[test]
fn the_largest_has_a_million_triangles_and_the_first_is_small() {
    let largest = all().iter().map(|d| d.triangles).max();
    assert_eq!(largest, Some(1_000_000));
    assert!(all()[0].triangles < 50_000, "it must open within a blink");
}

#[test]
fn names_are_different_words() {
    for (i, demo) in all().iter().enumerate() {
        let word = demo.name.chars().all(|c| c.is_ascii_lowercase());
        assert!(word, "{:?}", demo.name);
        assert!(
            all()[..i].iter().all(|d| d.name != demo.name),
            "{}",
            demo.name
        );
    }
}

/// A bomb.txt that differs is renewed by `raybomb demo bomb --write assets/bomb.txt`.
#[test]
fn the_file_of_the_bomb_is_what_the_code_makes() {
    let file = std::fs::read(assets().join("bomb.txt")).expect("assets/bomb.txt");
    assert!(
        file == text(&bomb::scene()),
        "assets/bomb.txt is not the bomb demo"
    );
}

#[test]
fn asset_files_parse_and_are_small() {
    let mut total = 0;
    for entry in std::fs::read_dir(assets()).expect("assets") {
        let path = entry.expect("an entry").path();
        let bytes = std::fs::read(&path).expect("a file");
        total += bytes.len();
        if path.extension().is_some_and(|e| e == "txt") {
            assert!(scene::parse(&bytes).is_ok(), "{}", path.display());
        }
    }
    assert!(total < 4_000_000, "{total} bytes");
}
