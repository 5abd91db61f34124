//! `check`, `info`, `bench` and `demo`.

use serde_json::Value;

use crate::support::{Folder, SCENE};

#[test]
fn check_tells_every_problem_with_its_place() {
    let folder = Folder::new();
    let bad = SCENE
        .replace("255 80 0", "256 80 0")
        .replace("0 200 90", "0 200 9.5");
    folder.write("bad.txt", bad);
    let run = folder.run(&["check", "bad.txt"]).code_is(3);
    assert_eq!(run.stdout, "");
    assert!(run.stderr.starts_with("bad.txt:8:"), "{}", run.stderr);
    assert!(run.stderr.contains("\nbad.txt:9:"), "{}", run.stderr);
    for command in ["render", "info", "bench", "view"] {
        let run = folder.run(&[command, "bad.txt"]).code_is(3);
        assert!(
            run.stderr.starts_with("bad.txt:8:"),
            "{command}: {}",
            run.stderr
        );
    }
    assert_eq!(folder.names(), ["bad.txt", "scene.txt"]);
}

#[test]
fn check_points_at_triangles_without_area() {
    let folder = Folder::new();
    let run = folder.run(&["check", "scene.txt"]).ok();
    assert_eq!(
        run.stdout,
        "scene.txt: no errors, 1 warning, 6 triangles, 3 operations\n"
    );
    let place = "scene.txt:13:1: warning: triangle 5 has no area and is never hit";
    assert!(run.stderr.starts_with(place), "{}", run.stderr);
    folder
        .run(&["render", "scene.txt", "--size", "9x9"])
        .ok()
        .says("scene.txt: warning: 1 triangle has no area");
}

#[test]
fn check_does_not_flood_the_terminal_with_triangles_without_area() {
    let folder = Folder::new();
    let flat = "0 0 0  1 1 1  2 2 2  9 9 9\n";
    folder.write(
        "flat.txt",
        format!("<d\n0 0 1\n25\n{}<o 0\n", flat.repeat(25)),
    );
    let pointed = |options: &[&str]| {
        let run = folder.run(&[&["check", "flat.txt"], options].concat()).ok();
        let summary = "flat.txt: no errors, 25 warnings, 25 triangles, 0 operations\n";
        assert_eq!(run.stdout, summary);
        (run.stderr.matches(": warning: ").count(), run.stderr)
    };
    let (count, words) = pointed(&[]);
    assert_eq!(count, 20, "{words}");
    let rest = "\n… and 5 more without area (--all-warnings points at each)\n";
    assert!(words.ends_with(rest), "{words}");
    let (count, words) = pointed(&["--all-warnings"]);
    assert_eq!(count, 25, "{words}");
    assert!(!words.contains("more"), "{words}");
}

#[test]
fn check_reads_the_standard_input() {
    let folder = Folder::new();
    let run = folder
        .run_with_input(&["check", "-"], b"<d 0 0 0 0")
        .code_is(3);
    assert!(
        run.stderr.starts_with("<stdin>:1:4: expected"),
        "{}",
        run.stderr
    );
}

#[test]
fn info_tells_the_same_in_words_and_in_json() {
    let folder = Folder::new();
    let words = folder.run(&["info", "scene.txt"]).ok();
    assert_eq!(words.stderr, "");
    for line in [
        "triangles    6, 1 of them without area",
        "frames       49 (0 to 48)",
    ] {
        assert!(words.stdout.contains(line), "{}", words.stdout);
    }
    let run = folder.run(&["info", "scene.txt", "--json"]).ok();
    assert_eq!(run.stdout.lines().count(), 1);
    let info: Value = serde_json::from_str(&run.stdout).expect("JSON");
    assert_eq!(info["triangles"], 6);
    assert_eq!(info["degenerate"], 1);
    assert_eq!(info["frames"], 49);
    assert_eq!(info["bounds"]["min"], serde_json::json!([-9.0, -9.0, -1.5]));
    assert_eq!(
        info["camera"]["base"]["eye"],
        serde_json::json!([0.0, -6.0, 4.0])
    );
    assert_ne!(
        info["camera"]["after_operations"]["eye"],
        info["camera"]["base"]["eye"]
    );
    assert_eq!(
        info["operations"][1],
        serde_json::json!({"axis": "x", "angle_rad": -0.25})
    );
    assert!(info["bvh"]["sah_cost"].is_number() && info["bytes"].is_number());
}

#[test]
fn info_of_a_scene_without_triangles_has_no_bounds() {
    let folder = Folder::new();
    folder.write("empty.txt", "<d 0 0 -1 0");
    let run = folder.run(&["info", "empty.txt", "--json"]).ok();
    let info: Value = serde_json::from_str(&run.stdout).expect("JSON");
    assert_eq!(info["bounds"], Value::Null);
    assert_eq!(info["camera"]["size"], serde_json::json!([640, 480]));
    folder.run(&["info", "empty.txt"]).ok();
    folder.run(&["render", "empty.txt", "--size", "9x9"]).ok();
}

const BENCH_FIELDS: &str = "scene, workload, engine, kernel, threads, width, height, triangles, frames, \
                            median_ms, min_ms, mrays_s, build_ms, bytes_per_triangle, \
                            coarse, mtris_s, rays, hits, hash";

#[test]
fn bench_prints_the_fields_of_the_contract_in_their_order() {
    let folder = Folder::new();
    for workload in [
        "primary", "shaded", "shadow", "bounce", "random", "build", "load",
    ] {
        let run = folder
            .run(&[
                "bench",
                "scene.txt",
                "--size",
                "64x48",
                "--frames",
                "3",
                "--threads",
                "2",
                "--json",
                "--kernel",
                "scalar",
                "--workload",
                workload,
            ])
            .ok();
        assert_eq!(run.stdout.lines().count(), 1);
        let mut rest = run.stdout.as_str();
        for field in BENCH_FIELDS.split(", ") {
            let key = format!("\"{field}\":");
            rest = rest
                .split_once(&key)
                .unwrap_or_else(|| panic!("{field} in {rest}"))
                .1;
        }
        let mut report: Value = serde_json::from_str(&run.stdout).expect("JSON");
        let fields = report.as_object_mut().expect("an object");
        // Where the system tells.
        let peak = fields.remove("peak_bytes_per_triangle");
        assert!(workload == "build" || peak.is_none());
        let fill = fields.remove("fill_ms");
        let filled = fill.is_some_and(|ms| ms.as_f64() > Some(0.0));
        assert_eq!(filled, workload == "shaded");
        assert_eq!(fields.len(), 19);
        assert_eq!(report["scene"], "scene");
        assert_eq!(report["workload"], workload);
        assert_eq!(
            (&report["engine"], &report["kernel"]),
            (&"fast".into(), &"scalar".into())
        );
        assert_eq!(
            (&report["threads"], &report["frames"]),
            (&2.into(), &3.into())
        );
        assert_eq!(
            (&report["width"], &report["height"]),
            (&64.into(), &48.into())
        );
        assert!(report["median_ms"].as_f64() >= report["min_ms"].as_f64());
        let rays = !matches!(workload, "build" | "load");
        assert_eq!(report["mrays_s"].is_number(), rays, "{workload}");
        let built = workload == "build";
        assert_eq!(report["mtris_s"].is_number(), built, "{workload}");
        assert_eq!(report["rays"].is_number(), rays, "{workload}");
        assert_eq!(report["hash"].is_string(), rays, "{workload}");
        if rays && workload != "shaded" {
            assert!(report["hits"].as_u64() < report["rays"].as_u64());
        }
    }
}

#[test]
fn bench_in_words_names_what_it_measured() {
    let folder = Folder::new();
    let run = folder
        .run(&["bench", "scene.txt", "--frames", "1", "--size", "64x48"])
        .ok();
    for word in [
        "scene: 6 triangles, 64x48",
        "primary, engine fast",
        "Mray/s",
        "median",
    ] {
        assert!(run.stdout.contains(word), "{}", run.stdout);
    }
}

#[test]
fn demos_are_listed_and_saved_as_scenes() {
    let folder = Folder::new();
    let list = folder.run(&["demo"]).ok().stdout;
    let names: Vec<&str> = list
        .lines()
        .filter_map(|l| l.split_whitespace().next())
        .collect();
    assert!(!names.is_empty());
    folder.run(&["demo", names[0], "--write", "demo.txt"]).ok();
    let checked = folder.run(&["check", "demo.txt"]).ok().stdout;
    assert!(checked.starts_with("demo.txt: no errors"), "{checked}");
    folder
        .run(&["demo", "no-such-demo"])
        .code_is(2)
        .says(names[0]);
    folder.run(&["demo", "--write", "x.txt"]).code_is(2);
}
