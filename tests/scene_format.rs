//! Scene files as files: bad ones with the exact message, good ones with their content.
//!
//! `tests/scenes/bad/NAME.txt` must print `NAME.expected`; `UPDATE_EXPECTED=1` renews those (then read the
//! difference). Files that git or an editor would spoil are made here.

use std::fs;
use std::path::{Path, PathBuf};

use glam::Vec3;
use raybomb::color::Rgb;
use raybomb::scene::{
    Axis, CameraCorners, CameraSetting, Expected, Found, Operation, ParseErrorKind, ParseErrors,
    Point, Scene, Severity, Triangle, annotate, camera_text, locate_triangles, parse, write,
};

fn scenes(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/scenes")
        .join(folder);
    let mut paths: Vec<PathBuf> = fs::read_dir(folder)
        .expect("the scenes are part of the repository")
        .map(|entry| entry.expect("a folder that can be listed").path())
        .filter(|path| path.extension().is_some_and(|e| e == "txt"))
        .collect();
    paths.sort();
    paths
}

fn name(path: &Path) -> String {
    path.file_name()
        .expect("a file")
        .to_string_lossy()
        .into_owned()
}

/// What is printed for a bad text.
fn message(name: &str, text: &[u8]) -> String {
    match parse(text) {
        Ok(scene) => panic!("{name} should be bad, but was read: {scene:?}"),
        Err(errors) => errors.render(name, text, false) + "\n",
    }
}

#[test]
fn every_bad_file_prints_its_expected_message() {
    let paths = scenes("bad");
    assert!(paths.len() >= 60, "only {} bad files", paths.len());
    let mut wrong = Vec::new();
    for path in &paths {
        let actual = message(&name(path), &fs::read(path).unwrap());
        let expected_path = path.with_extension("expected");
        if std::env::var_os("UPDATE_EXPECTED").is_some() {
            fs::write(&expected_path, &actual).unwrap();
        }
        let expected = fs::read_to_string(&expected_path).unwrap_or_default();
        if actual != expected {
            wrong.push(format!(
                "{}\nexpected:\n{expected}\nactual:\n{actual}",
                name(path)
            ));
        }
    }
    assert!(
        wrong.is_empty(),
        "{} differ:\n\n{}",
        wrong.len(),
        wrong.join("\n")
    );
}

#[test]
fn every_message_begins_with_its_place_and_shows_a_caret() {
    for path in scenes("bad") {
        let text = fs::read(&path).unwrap();
        let errors = parse(&text).unwrap_err();
        assert!((1..=ParseErrors::MAX).contains(&errors.errors.len()));
        for error in &errors.errors {
            let shown = error.render("in.txt", &text, false);
            let start = format!("in.txt:{}:{}: expected ", error.line, error.column);
            assert!(shown.starts_with(&start), "{}: {shown}", name(&path));
            assert!(shown.contains(", found "), "{}: {shown}", name(&path));
            assert!(shown.contains('^'), "{}: {shown}", name(&path));
            let unseen = |c: char| c.is_control() && c != '\n';
            assert!(!shown.contains(unseen), "{}: {shown:?}", name(&path));
            assert!(error.render("in.txt", &text, true).contains("\x1b["));
        }
    }
}

fn corner(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z)
}

/// What all files in `tests/scenes/good` say.
fn good_scene() -> Scene {
    let turn = |axis, angle_rad| Operation { axis, angle_rad };
    Scene {
        camera: CameraSetting::Set(CameraCorners {
            eye: corner(0.0, 0.0, 5.0),
            top_left: corner(-1.0, 1.0, 0.0),
            top_right: corner(1.0, 1.0, 0.0),
            bottom_left: corner(-1.0, -1.0, 0.0),
        }),
        light: corner(0.0, 0.0, -1.0),
        triangles: vec![
            Triangle {
                corners: [Vec3::ZERO, Vec3::X, Vec3::Y],
                color: Rgb::new(255, 0, 0),
            },
            Triangle {
                corners: [Vec3::Z, corner(1.5, 0.0, 1.0), corner(0.0, 1.5, 1.0)],
                color: Rgb::new(0, 255, 0),
            },
        ],
        operations: vec![
            turn(Axis::X, 0.7),
            turn(Axis::Y, -0.125),
            turn(Axis::Z, 3.0),
        ],
    }
}

#[test]
fn every_good_file_says_the_same() {
    let paths = scenes("good");
    assert!(paths.len() >= 10, "only {} good files", paths.len());
    for path in paths {
        let text = fs::read(&path).unwrap();
        match parse(&text) {
            Ok(scene) => assert_eq!(scene, good_scene(), "{}", name(&path)),
            Err(errors) => panic!("{}", errors.render(&name(&path), &text, false)),
        }
    }
}

#[test]
fn all_spellings_of_all_keywords_are_read() {
    for camera in ["<d", "< d", "d", "<D", "< D", "D", "<\n#x\n\td"] {
        for tail in ["", "<n", "< n", "n", "<N", "N"] {
            let text = format!("{camera} 0 0 1 0 {tail}");
            let scene = parse(text.as_bytes()).unwrap_or_else(|e| panic!("{text:?}: {e}"));
            assert_eq!(scene.camera, CameraSetting::Default, "{text:?}");
            assert_eq!(scene.operations, [], "{text:?}");
        }
    }
    for (letter, axis) in [("x", Axis::X), ("y", Axis::Y), ("z", Axis::Z)] {
        for o in ["<o", "< O", "o"] {
            for keyword in [
                letter.to_string(),
                format!("<{letter}"),
                format!("< {}", letter.to_uppercase()),
            ] {
                let text = format!("<d 0 0 1 0 {o} 1 {keyword} .5");
                let scene = parse(text.as_bytes()).unwrap_or_else(|e| panic!("{text:?}: {e}"));
                assert_eq!(
                    scene.operations,
                    [Operation {
                        axis,
                        angle_rad: 0.5
                    }],
                    "{text:?}"
                );
            }
        }
    }
}

#[test]
fn written_text_is_plain_and_reads_back() {
    let mut out = Vec::new();
    write(&good_scene(), &mut out).unwrap();
    let plain = fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes/good/plain.txt"))
        .unwrap();
    let plain = String::from_utf8(plain)
        .unwrap()
        .replace("-1.25e-1", "-0.125");
    assert_eq!(String::from_utf8(out).unwrap(), plain);
}

#[test]
fn camera_text_is_the_beginning_of_a_scene_file() {
    let CameraSetting::Set(corners) = good_scene().camera else {
        unreachable!("the good scene sets its camera");
    };
    let text = camera_text(&corners).unwrap();
    assert_eq!(text, "<s\n0 0 5\n-1 1 0\n1 1 0\n-1 -1 0\n");
    let scene = parse((text + "0 0 1\n0\n").as_bytes()).unwrap();
    assert_eq!(scene.camera, good_scene().camera);
}

#[test]
fn numbers_that_a_file_cannot_say_are_not_written() {
    let mut scene = good_scene();
    scene.triangles[1].corners[2].y = f32::NAN;
    assert!(write(&scene, &mut Vec::new()).is_err());
    scene = good_scene();
    scene.operations[0].angle_rad = f64::INFINITY;
    assert!(write(&scene, &mut Vec::new()).is_err());
}

/// Each prefix of a file is a scene exactly where docs/format.md says so: when the last word may end there and the
/// tail is either missing or complete.
#[test]
fn a_file_cut_at_any_byte_is_read_or_refused_as_the_format_says() {
    let text = "<s\n0 0 5 -1 1 0 1 1 0 -1 -1 0\n0 0 -1\n2\n0 0 0 1 0 0 0 1 0 255 0 0\n0 0 1 1 0 1 0 1 1 0 255 17 # c\n\
                <o\n2\n<x 0.75\n<y -1.5e-1\n";
    let end_of_triangles = text.find(" 17").unwrap() + 2;
    let tail = text.find("<o").unwrap();
    let last_angle = text.find("-1.5").unwrap();
    for cut in 0..=text.len() {
        let good = match cut {
            // From the last colour's first digit up to the tail: a missing tail.
            c if c >= end_of_triangles && c <= tail => true,
            // `-1`, `-1.`, `-1.5` are numbers, `-`, `-1.5e`, `-1.5e-` are not.
            c if c > last_angle => !["-", "e", "e-"].iter().any(|e| text[..c].ends_with(e)),
            _ => false,
        };
        let scene = parse(&text.as_bytes()[..cut]);
        assert_eq!(scene.is_ok(), good, "cut at {cut}: {:?}", &text[..cut]);
        if let Ok(scene) = scene {
            assert_eq!(scene.triangles.len(), 2);
            assert_eq!(scene.operations.len(), if cut <= tail { 0 } else { 2 });
        }
    }
}

#[test]
fn a_line_of_ten_megabytes_is_shown_in_part() {
    let mut text = b"<d 0 0 -1 400000 ".to_vec();
    while text.len() < 10_000_000 {
        text.extend_from_slice(b"0 0 0 1 0 0 0 1 0 255 0 0 ");
    }
    text.extend_from_slice(b"oops");
    let error = &parse(&text).unwrap_err().errors[0];
    assert_eq!((error.line, error.column), (1, text.len() - 3));
    let shown = error.render("big.txt", &text, false);
    assert!(
        shown.len() < 1000,
        "{} bytes: {}",
        shown.len(),
        &shown[..1000]
    );
    assert!(
        shown.contains("| …") && shown.contains("255 0 0 oops"),
        "{shown}"
    );
}

#[test]
fn a_word_of_ten_megabytes_is_shown_in_part() {
    let mut text = b"<d 0 0 ".to_vec();
    text.resize(10_000_000, b'7');
    let shown = message("big.txt", &text);
    let start = format!(
        "big.txt:1:8: expected a number within ±3.4028235e38 (z of the light), found \"{}…\"\n",
        "7".repeat(39)
    );
    assert!(
        shown.starts_with(&start),
        "{}",
        &shown[..1000.min(shown.len())]
    );
    assert!(shown.len() < 1000);
}

#[test]
fn random_bytes_of_all_values_have_a_place_that_can_be_shown() {
    let text: Vec<u8> = (0..=255).collect();
    let shown = message("bytes", &text);
    assert!(
        shown.starts_with("bytes:1:1: expected <d or <s (the camera), found \"\\0"),
        "{shown}"
    );
}

#[test]
fn kinds_tell_what_a_program_may_want_to_know() {
    let kind = |text: &str| parse(text.as_bytes()).unwrap_err().errors.remove(0).kind;
    let point = Point::Corner {
        corner: 0,
        triangle: 0,
    };
    assert_eq!(
        kind("<d 0 0 1 7 <n"),
        ParseErrorKind::FewerThanClaimed {
            expected: Expected::Coordinate(Axis::X, point),
            claimed: 7,
            found: Found::Word("<n".into()),
        }
    );
    assert_eq!(kind("<d 0 0 0 0"), ParseErrorKind::ZeroLight);
    assert_eq!(
        kind("<d 0 0 1e99 0"),
        ParseErrorKind::OutOfRange {
            expected: Expected::Coordinate(Axis::Z, Point::Light),
            found: Found::Word("1e99".into()),
        }
    );
}

#[test]
fn triangles_are_found_again_in_the_text() {
    let text = b"\xef\xbb\xbf<d 0 0 1\n4 # four\n0 0 0 1 0 0 0 1 0 1 2 3\n\n# \xff\n  0 0 0 1 0 0 0 1 0 1 2 3\r\n0 0 0\n1 0 0 0 1 0 1 2 3 0 0 0 1 0 0 0 1 0 1 2 3";
    let places = |ids: &[usize]| -> Vec<(usize, usize)> {
        let found = locate_triangles(text, ids.iter().copied());
        found.iter().map(|at| (at.line, at.column)).collect()
    };
    assert_eq!(places(&[0, 1, 2, 3]), [(3, 1), (6, 3), (7, 1), (8, 19)]);
    assert_eq!(places(&[1, 3, 4, 5]), [(6, 3), (8, 19)]);
    assert_eq!(locate_triangles(b"<d 0", [0]), []);

    let at = &locate_triangles(text, [2])[0];
    let shown = annotate(
        Severity::Warning,
        "in.txt",
        text,
        at,
        "triangle 2 has no area",
        None,
        false,
    );
    assert_eq!(
        shown,
        "in.txt:7:1: triangle 2 has no area\n  |\n7 | 0 0 0\n  | ^^^^^"
    );
}
