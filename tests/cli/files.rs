//! Pictures and arrays: their bytes, and that every way to the same picture gives the same one.

use crate::support::{Array, Folder, Picture};

const SMALL: [&str; 2] = ["--size", "75x50"];

fn render<'a>(more: &[&'a str]) -> Vec<&'a str> {
    [&["render", "scene.txt"], &SMALL[..], more].concat()
}

#[test]
fn render_without_a_name_writes_data_bmp_and_prints_nothing() {
    let folder = Folder::new();
    let run = folder.run(&render(&[])).ok();
    assert_eq!(run.stdout, "");
    assert_eq!(folder.names(), ["data.bmp", "scene.txt"]);
    let picture = Picture::from_bmp(&folder.read("data.bmp"));
    assert_eq!((picture.width, picture.height), (75, 50));
}

#[test]
fn the_hash_is_that_of_the_files_pixels() {
    let folder = Folder::new();
    for view in ["shaded", "id", "normal", "depth"] {
        let hash = folder.hash(&render(&["--hash", "--view", view]));
        let bmp = folder.hash(&render(&["--hash", "--view", view, "-o", "x.bmp"]));
        let png = folder.hash(&render(&["--hash", "--view", view, "-o", "x.png"]));
        let picture = Picture::from_bmp(&folder.read("x.bmp"));
        assert_eq!(picture, Picture::from_png(&folder.read("x.png")));
        assert_eq!([&bmp, &png], [&hash, &hash]);
        assert_eq!(picture.hash(), hash);
    }
}

#[test]
fn hash_alone_writes_nothing() {
    let folder = Folder::new();
    let hash = folder.hash(&render(&["--hash"]));
    assert!(hash.len() == 64 && hash.bytes().all(|b| b"0123456789abcdef".contains(&b)));
    assert_eq!(folder.names(), ["scene.txt"]);
}

#[test]
fn any_number_of_threads_gives_the_same_picture() {
    let folder = Folder::new();
    let hash = |threads| folder.hash(&render(&["--hash", "--threads", threads]));
    let expected = hash("0");
    for threads in ["1", "2", "3", "7"] {
        assert_eq!(hash(threads), expected, "{threads} threads");
    }
}

#[test]
fn every_kernel_of_this_cpu_and_the_oracle_give_the_same_picture() {
    let folder = Folder::new();
    let expected = folder.hash(&render(&["--hash"]));
    let brute = folder.hash(&render(&["--hash", "--engine", "brute"]));
    assert_eq!(brute, expected);
    for kernel in raybomb::simd::Kernel::available() {
        let hash = folder.hash(&render(&["--hash", "--kernel", kernel.name()]));
        assert_eq!(hash, expected, "{}", kernel.name());
    }
}

#[test]
fn the_last_frame_is_the_picture_without_a_frame() {
    let folder = Folder::new();
    let still = folder.hash(&render(&["--hash"]));
    assert_eq!(folder.hash(&render(&["--hash", "--frame", "48"])), still);
    assert_ne!(folder.hash(&render(&["--hash", "--frame", "0"])), still);
    let slow = [
        "--hash",
        "--fps",
        "2",
        "--seconds-per-op",
        "1.5",
        "--frame",
        "9",
    ];
    assert_eq!(folder.hash(&render(&slow)), still);
}

#[test]
fn the_scenes_own_camera_as_an_option_is_frame_0() {
    let folder = Folder::new();
    let camera = "0 -6 4 -4 -2 3 4 -2 3 -4 -2 -3";
    let by_option = folder.hash(&render(&["--hash", "--camera", camera]));
    assert_eq!(by_option, folder.hash(&render(&["--hash", "--frame", "0"])));
    let other = folder.hash(&render(&[
        "--hash",
        "--camera",
        "0 -7 4 -4 -2 3 4 -2 3 -4 -2 -3",
    ]));
    assert_ne!(by_option, other);
}

#[test]
fn stretch_and_pivot_change_the_picture_and_the_default_shape_does_not() {
    let folder = Folder::new();
    let wide = ["render", "scene.txt", "--hash", "--size", "90x30"];
    let stretched = [&wide[..], &["--stretch"]].concat();
    assert_ne!(folder.hash(&wide), folder.hash(&stretched));
    let centre = render(&["--hash", "--pivot", "centre"]);
    assert_ne!(folder.hash(&render(&["--hash"])), folder.hash(&centre));
    let shape = ["render", "scene.txt", "--hash"];
    let same = [&shape[..], &["--size", "640x480", "--stretch"]].concat();
    assert_eq!(folder.hash(&shape), folder.hash(&same));
}

#[test]
fn the_standard_input_is_a_scene_too() {
    let folder = Folder::new();
    let args = ["render", "-", "--size", "75x50", "--hash"];
    let run = folder.run_with_input(&args, crate::support::SCENE.as_bytes());
    assert_eq!(
        run.ok().stdout.trim_end(),
        folder.hash(&render(&["--hash"]))
    );
}

#[test]
fn anim_writes_the_frames_that_render_writes() {
    let folder = Folder::new();
    let anim = [
        "anim",
        "scene.txt",
        "--size",
        "75x50",
        "--fps",
        "4",
        "-o",
        "out/more/{frame:03}.png",
        "--hash",
    ];
    let run = folder.run(&anim).ok();
    let lines: Vec<&str> = run.stdout.lines().collect();
    assert_eq!(lines.len(), 13);
    let files = crate::support::names_in(&folder.path("out/more"));
    assert_eq!(files.len(), 13);
    for (k, line) in lines.iter().enumerate() {
        let frame = k.to_string();
        let hash = folder.hash(&render(&["--hash", "--fps", "4", "--frame", &frame]));
        assert_eq!(*line, format!("{k} {hash}"));
        let file = folder.read(&format!("out/more/{k:03}.png"));
        assert_eq!(Picture::from_png(&file).hash(), hash);
    }
}

#[test]
fn anim_takes_a_range_and_needs_no_files_for_hashes() {
    let folder = Folder::new();
    let run = folder.run(&[
        "anim",
        "scene.txt",
        "--size",
        "20x10",
        "--frames",
        "46..48",
        "--hash",
    ]);
    let lines = run.ok().stdout;
    let numbers: Vec<&str> = lines.lines().filter_map(|l| l.split(' ').next()).collect();
    assert_eq!(numbers, ["46", "47", "48"]);
    assert_eq!(folder.names(), ["scene.txt"]);
    folder
        .run(&[
            "anim",
            "scene.txt",
            "--size",
            "20x10",
            "--frames",
            "9..9",
            "-o",
            "{frame}.npy",
        ])
        .ok();
    assert_eq!(folder.names(), ["9.npy", "scene.txt"]);
}

/// The array of `view`.
fn array(folder: &Folder, view: &str) -> Array {
    folder.run(&render(&["--view", view, "-o", "x.npy"])).ok();
    Array::from_npy(&folder.read("x.npy"))
}

#[test]
fn arrays_have_type_and_shape_and_miss_where_the_others_miss() {
    let folder = Folder::new();
    let ids = array(&folder, "id");
    let depth = array(&folder, "depth");
    let normal = array(&folder, "normal");
    assert_eq!(ids.shape, [50, 75]);
    assert_eq!(depth.shape, [50, 75]);
    assert_eq!(normal.shape, [50, 75, 3]);
    let normals = normal.f32s();
    for ((id, depth), n) in ids
        .u32s()
        .iter()
        .zip(depth.f32s())
        .zip(normals.chunks_exact(3))
    {
        let length = n.iter().map(|c| c * c).sum::<f32>().sqrt();
        if *id == u32::MAX {
            assert!(depth == f32::INFINITY && n == [0.0; 3]);
        } else {
            assert!(*id < 5, "triangle {id} can be seen");
            assert!(depth > 0.0 && depth < 100.0 && (length - 1.0).abs() < 1e-6);
        }
    }
}

#[test]
fn the_array_of_the_shaded_view_is_the_picture() {
    let folder = Folder::new();
    let array = array(&folder, "shaded");
    assert_eq!(
        (array.descr.as_str(), &array.shape[..]),
        ("|u1", &[50, 75, 3][..])
    );
    folder.run(&render(&["-o", "x.bmp"])).ok();
    assert_eq!(Picture::from_bmp(&folder.read("x.bmp")).rgb, array.data);
}

#[test]
fn arrays_agree_with_the_id_picture() {
    let folder = Folder::new();
    let ids = array(&folder, "id").u32s();
    folder.run(&render(&["--view", "id", "-o", "x.png"])).ok();
    let picture = Picture::from_png(&folder.read("x.png"));
    let mut colors = std::collections::HashMap::new();
    for (id, color) in ids.iter().zip(picture.rgb.chunks_exact(3)) {
        assert_eq!(colors.entry(*id).or_insert(color), &color, "triangle {id}");
    }
    assert_eq!(
        colors.get(&u32::MAX),
        Some(&&[0, 0, 0][..]),
        "the background is black"
    );
    assert!(
        colors.len() >= 4,
        "only {} things can be seen",
        colors.len()
    );
}

/// A square at z = 0, seen from 2 above through a plane at z = 1: distances and normals are known.
#[test]
fn distances_are_in_scene_units_and_normals_turn_to_the_eye() {
    let folder = Folder::new();
    for corners in ["-9 -9 0 9 -9 0 0 18 0", "-9 -9 0 0 18 0 9 -9 0"] {
        let scene = format!("<s 0 0 2 -1 1 1 1 1 1 -1 -1 1  0 0 -1  1  {corners}  9 9 9");
        folder.write("scene.txt", scene);
        let args = [
            "render",
            "scene.txt",
            "--size",
            "5x5",
            "-o",
            "x.npy",
            "--view",
        ];
        folder.run(&[&args[..], &["depth"]].concat()).ok();
        let depth = Array::from_npy(&folder.read("x.npy")).f32s();
        folder.run(&[&args[..], &["normal"]].concat()).ok();
        let normal = Array::from_npy(&folder.read("x.npy")).f32s();
        assert!(
            (depth[12] - 2.0).abs() < 1e-5,
            "the centre is {} away",
            depth[12]
        );
        let corner = 2.0 * (1.0f32 + 0.64 + 0.64).sqrt();
        assert!(
            (depth[24] - corner).abs() < 1e-5,
            "{} is not {corner}",
            depth[24]
        );
        for n in normal.chunks_exact(3) {
            assert_eq!(n, [0.0, 0.0, 1.0]);
        }
    }
}

#[test]
fn samples_a_pixel_change_the_picture_and_no_kernel_or_thread_does() {
    let folder = Folder::new();
    let hash = |options: &[&str]| folder.hash(&render(&[&["--hash"], options].concat()));
    assert_eq!(hash(&["--aa", "1"]), hash(&[]));
    let four = hash(&["--aa", "4"]);
    assert_ne!(four, hash(&[]));
    assert_ne!(four, hash(&["--aa", "8"]));
    assert_eq!(
        four,
        hash(&["--aa", "4", "--kernel", "scalar", "--threads", "3"])
    );
    assert_eq!(four, hash(&["--aa", "4", "--engine", "brute"]));
    folder
        .run(&render(&["--aa", "4", "--view", "id", "-o", "x.npy"]))
        .code_is(2)
        .says("--aa is for colours");
    folder
        .run(&render(&["--aa", "3", "--hash"]))
        .code_is(2)
        .says("power of two");
}
