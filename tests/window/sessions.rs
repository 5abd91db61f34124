//! Scripted sessions: at every `settle` the window shows what `raybomb render` makes of the same state.

use serde_json::Value;

use crate::support::{Desk, Picture, SCENE, Viewer};

/// A window that plays what [`Viewer::tell`] tells it.
fn scripted<'a>(desk: &'a Desk, options: &[&str]) -> Viewer<'a> {
    desk.view(&[&["--no-overlay", "--play-actions", "-"], options].concat())
}

/// What a viewer reports that settles for the `index`-th time, from 0.
pub fn settled(viewer: &Viewer<'_>, index: usize) -> Value {
    let report: Value = serde_json::from_str(&viewer.prints(index)).expect("JSON");
    assert_eq!(report["settled"], index + 1, "{report}");
    report
}

/// What `render` makes of the state that a settled viewer reports.
pub fn rendered(desk: &Desk, report: &Value) -> Picture {
    let text = |key: &str| report[key].as_str().expect("a text").to_owned();
    let light = SCENE.find("0.3 1 -1").expect("the light");
    let tail = SCENE.find("<o").expect("the tail");
    let scene = text("camera") + &SCENE[light..tail] + &text("operations");
    std::fs::write(desk.path("settled.txt"), scene).expect("written");
    let size = format!("{}x{}", report["size"][0], report["size"][1]);
    let (view, engine) = (text("view"), text("engine"));
    let aa = report["aa"].to_string();
    let how = ["--view", &view, "--engine", &engine, "--aa", &aa];
    desk.render_file("settled.txt", &[&["--size", &size], &how[..]].concat())
}

/// Plays `script`, which settles once at its end, as the `index`-th (from 0) of the session.
fn settles(desk: &Desk, viewer: &mut Viewer<'_>, index: usize, script: &str) -> (Value, Picture) {
    viewer.tell(script);
    let report = settled(viewer, index);
    let picture = rendered(desk, &report);
    viewer.shows(&picture, script);
    (report, picture)
}

const SCRIPTS: [&str; 14] = [
    "orbit 31 -17\norbit 3 4\nlet-go",
    "orbit 40 9 z\norbit 40 9 x\nlet-go",
    "start-turn x\nwait 0.4\nstop-turn x\nstart-turn y reverse\nstop-turn y",
    "start-turn z\nstart-turn x reverse\nwait 0.35\nstop-turns",
    "pan 12 30\nlet-go\ndolly 2\ndolly -1 20 200",
    "dolly-drag -33 200 90\nlet-go\nroll 25\nlet-go",
    "look corner\nlook right opposite\norbit 3 3\nlet-go",
    "turntable\norbit 50 20\nlet-go\nturntable",
    "play\nwait 0.65\nplay",
    "play\nwait 0.5\norbit 5 5\nlet-go\nwait 0.1\nplay-backwards",
    "seek 20\nstep 1\nnext-operation\nprevious-operation\nstep -3",
    "pivot 160 120\norbit 30 10\nlet-go\nundo\nredo",
    "resize 211 333\nnext-view",
    "next-view\nrecord\norbit 8 -8\nlet-go\nseek 50",
];

#[test]
fn every_settled_picture_is_the_one_that_render_makes() {
    let Some(desk) = Desk::new() else { return };
    let mut viewer = scripted(&desk, &[]);
    let mut pictures = vec![desk.still()];
    for (index, script) in SCRIPTS.iter().enumerate() {
        let (_, picture) = settles(&desk, &mut viewer, index, &format!("{script}\nsettle"));
        assert!(!pictures.contains(&picture), "nothing new: {script}");
        pictures.push(picture);
    }
    viewer.tell("resize 320 240\nnext-view\nnext-view\nnext-view\nend\nreturn\nsettle");
    viewer.shows(&pictures[0], "return");
}

#[test]
fn a_settled_session_tells_what_it_showed_on_the_way() {
    let Some(desk) = Desk::new() else { return };
    let mut viewer = scripted(&desk, &[]);
    viewer.tell("settle");
    let still: Value = serde_json::from_str(&viewer.prints(0)).expect("JSON");
    assert_eq!(still["moved"]["pictures"], 0, "{still}");
    assert_eq!(still["moved"]["input_ms"]["p99"], Value::Null, "{still}");
    let (moves, quiet) = ("orbit 5 3\nwait 0.03\n".repeat(10), "wait 0.01\nsettle");
    viewer.tell(&format!("{moves}let-go\nsettle\n{quiet}"));
    let report: Value = serde_json::from_str(&viewer.prints(1)).expect("JSON");
    let moved = &report["moved"];
    let pictures = moved["pictures"].as_u64().expect("a count");
    assert!((1..=11).contains(&pictures), "{moved}");
    let sizes = moved["pixel_sizes"].as_object().expect("counts");
    let sum: u64 = sizes.values().filter_map(Value::as_u64).sum();
    assert_eq!(sum, pictures, "{moved}");
    let ms = |key: &str| moved["input_ms"][key].as_f64().expect("a time");
    assert!(0.0 < ms("p50") && ms("p50") <= ms("p99"), "{moved}");
    assert!(moved["missed"].as_u64() <= moved["refreshes"].as_u64());
    assert!(moved["fine_after_ms"].as_f64() > Some(0.0), "{moved}");
    // Each is told once.
    let after: Value = serde_json::from_str(&viewer.prints(2)).expect("JSON");
    assert_eq!(after["moved"]["pictures"], 0, "{after}");
}

/// A hundred drags and key turns about the format's pivot.
fn hundred_turns() -> String {
    let mut random = raybomb::math::Random::new(11);
    let mut number = |limit: u32| i64::from(random.below(2 * limit + 1)) - i64::from(limit);
    let turn = |i: i64| {
        let axis = ["x", "y", "z"][usize::try_from(i % 3).expect("positive")];
        let (dx, dy) = (number(60), number(60));
        match i % 4 {
            0 => format!("orbit {dx} {dy}\norbit {dy} {dx}\nlet-go\n"),
            1 => format!("orbit {dx} {dy} {axis}\nlet-go\n"),
            2 => format!("roll {dx}\nlet-go\n"),
            // A few are held, the others tapped.
            _ if i % 24 == 3 => format!("start-turn {axis}\nwait 0.3\nstop-turn {axis}\n"),
            _ => format!("start-turn {axis} reverse\nstop-turn {axis}\n"),
        }
    };
    (0..100).map(turn).collect()
}

#[test]
fn a_hundred_recorded_turns_saved_and_rendered_are_the_windows_last_frame() {
    let Some(desk) = Desk::new() else { return };
    let mut viewer = scripted(&desk, &[]);
    let still = desk.still();
    let script = format!("record\n{}settle", hundred_turns());
    let (_, last) = settles(&desk, &mut viewer, 0, &script);
    assert!(last != still);
    viewer.tell("save\nsettle");
    viewer.prints(1);
    assert_eq!(viewer.says(0), "saved scene.txt");
    assert!(desk.still() == last, "the saved file's picture is another");
    viewer.shows(&last, "after saving");
    let saved = std::fs::read_to_string(desk.path("scene.txt")).expect("a scene");
    let (before, after) = SCENE.split_once("<o\n3\n").expect("operations");
    assert!(saved.starts_with(before) && saved.contains(after));
    viewer.tell(&format!("{}settle", "undo\n".repeat(100)));
    viewer.shows(&still, "undo");
    viewer.tell(&format!("{}settle", "redo\n".repeat(100)));
    viewer.shows(&last, "redo");
}

#[test]
fn a_session_that_is_recorded_plays_back_to_the_same_picture() {
    let Some(desk) = Desk::new() else { return };
    let mut viewer = desk.view(&["--no-overlay", "--record-actions", "session.txt"]);
    viewer.shows(&desk.still(), "at start");
    viewer.keys(&["y", "z"]);
    viewer.hand(&["mousemove", "--window", "WINDOW", "100", "100"]);
    viewer.hand(&["mousedown", "1"]);
    viewer.hand(&["mousemove", "--window", "WINDOW", "131", "117"]);
    viewer.hand(&["mouseup", "1"]);
    viewer.hand(&["click", "5"]);
    viewer.resize(200, 150);
    let last = viewer.rests("the end");
    assert_eq!((last.width, last.height), (200, 150));
    viewer.keys(&["q"]);
    viewer.ends();
    let session = std::fs::read_to_string(desk.path("session.txt")).expect("a session");
    assert!(session.contains("\nsettle\n"), "{session}");
    // Without its end, in which it quits.
    let session = session.trim_end().strip_suffix("quit").expect("a quit");
    std::fs::write(desk.path("session.txt"), session).expect("written");
    let again = desk.view(&["--no-overlay", "--play-actions", "session.txt"]);
    again.shows(&last, "played back");
}

#[test]
fn a_bad_line_ends_the_program_and_names_its_place() {
    let Some(desk) = Desk::new() else { return };
    std::fs::write(desk.path("bad.txt"), "# one\norbit 1\n").expect("written");
    let mut viewer = desk.program();
    viewer.args(["view", "scene.txt", "--play-actions", "bad.txt"]);
    let output = viewer.output().expect("the program runs");
    let words = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1));
    assert!(words.contains("bad.txt:2: orbit: needs pixels"), "{words}");
    for (script, said) in [
        ("none.txt", "error: cannot read none.txt: no such file"),
        ("-", "error: <stdin>:1: dance: is no action"),
    ] {
        let mut command = desk.program();
        command.args(["view", "scene.txt", "--play-actions", script]);
        let mut viewer = Viewer::run(&desk, &mut command);
        if script == "-" {
            viewer.tell("dance");
        }
        assert_eq!(viewer.ends().code(), Some(1));
        assert_eq!(viewer.says(0), said);
    }
}

#[test]
fn the_end_of_a_script_leaves_the_window_to_the_hand() {
    let Some(desk) = Desk::new() else { return };
    let mut viewer = scripted(&desk, &[]);
    let (_, picture) = settles(&desk, &mut viewer, 0, "orbit 9 9\nlet-go\nsettle");
    viewer.end_input();
    viewer.hand(&["keydown", "x"]);
    viewer.changes_from(&picture, "a key");
    std::thread::sleep(std::time::Duration::from_millis(400));
    let old = viewer.grab();
    viewer.changes_from(&old, "a key held");
    viewer.hand(&["keyup", "x"]);
    viewer.keys(&["q"]);
    assert_eq!(viewer.ends().code(), Some(0));
}

#[test]
fn sessions_settle_with_all_samples_while_playing_and_after_another_scene() {
    let Some(desk) = Desk::new() else { return };
    std::fs::write(
        desk.path("scenery.txt"),
        SCENE.replace("255 80 0", "0 250 255"),
    )
    .expect("written");
    let mut viewer = scripted(&desk, &["--aa", "8"]);
    let (report, _) = settles(&desk, &mut viewer, 0, "play\nwait 0.5\nsettle");
    assert_eq!(report["aa"], 8);
    let (report, _) = settles(&desk, &mut viewer, 1, "start-turn x\nwait 0.4\nsettle");
    assert_ne!(report["frame"], report["last_frame"]);
    viewer.tell("stop-turns\nnext-scene\nsettle");
    viewer.prints(2);
    let options = ["--size", "320x240", "--aa", "8"];
    viewer.shows(&desk.render_file("scenery.txt", &options), "the next scene");
}

#[test]
fn what_is_read_is_not_recorded_over() {
    let Some(desk) = Desk::new() else { return };
    std::fs::write(desk.path("script"), "settle\nquit\n").expect("written");
    for (record, what) in [("scene.txt", "the scene"), ("./script", "the script")] {
        let before = std::fs::read(desk.path(record)).expect("read");
        let mut command = desk.program();
        command.args(["view", "scene.txt", "--play-actions", "script"]);
        command.args(["--record-actions", record]);
        let output = command.output().expect("it runs");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && said.contains(what), "{said}");
        assert!(std::fs::read(desk.path(record)).expect("read") == before);
    }
}
