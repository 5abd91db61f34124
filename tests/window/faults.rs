//! What befalls windows: sizes, servers, clocks.

use std::time::Duration;

use crate::sessions::{rendered, settled};
use crate::support::{Desk, SCENE, Viewer};

const FAULT_TOLD: &str = "a picture failed: a fault was asked for";

/// A screen on which the largest window has room.
const HUGE: &[&str] = &["-screen", "0", "4096x2160x24"];

#[test]
fn sizes_from_one_pixel_to_4096_by_2160_are_shown_to_the_bit() {
    let Some(desk) = Desk::with(HUGE) else { return };
    let viewer = desk.view(&[]);
    viewer.shows(&desk.still(), "at start");
    for (width, height) in [(1, 1), (4096, 2160), (1, 1), (320, 240)] {
        viewer.resize(width, height);
        let size = format!("{width}x{height}");
        viewer.shows(&desk.render(&["--size", &size]), &size);
    }
}

#[test]
fn ten_thousand_random_sizes_end_on_the_last_one() {
    let Some(desk) = Desk::new() else { return };
    let viewer = desk.view(&["--play"]);
    let client = desk.client();
    let mut random = raybomb::math::Random::new(7);
    let mut side = |most: u32| 1 + random.below(most);
    for _ in 0..20 {
        let sizes: Vec<(u32, u32)> = (0..500).map(|_| (side(1500), side(1100))).collect();
        client.resize(viewer.window(), sizes);
        // Between the storms some pictures are shown.
        std::thread::sleep(Duration::from_millis(50));
    }
    viewer.resize(320, 240);
    viewer.keys(&["Return"]);
    viewer.shows(&desk.still(), "after all of them");
}

#[test]
fn a_window_taken_from_the_screen_rests_and_comes_back_right() {
    let Some(desk) = Desk::new() else { return };
    let viewer = desk.view(&[]);
    viewer.shows(&desk.still(), "at start");
    viewer.keys(&["space", "v"]);
    let client = desk.client();
    client.show(viewer.window(), false);
    assert_eq!(viewer.says(0), "playback ended at frame 48");
    viewer.sleeps("a window that is not on the screen");
    client.show(viewer.window(), true);
    let id = desk.render(&["--size", "320x240", "--view", "id"]);
    viewer.shows(&id, "back on the screen");
}

#[test]
fn another_scale_factor_enlarges_the_window_and_what_is_drawn_over_it() {
    let Some(desk) = Desk::new() else { return };
    let client = desk.client();
    let settings = client.begin_settings();
    let viewer = desk.view(&[]);
    viewer.shows(&desk.still(), "at start");
    // The letters that are kept are those of the scale factor before.
    viewer.keys(&["h"]);
    viewer.changes_from(&desk.still(), "the sheet");
    viewer.keys(&["h"]);
    let large = desk.render(&["--size", "640x480"]);
    for (dpi, expected) in [(192, &large), (96, &desk.still()), (192, &large)] {
        settings.set_dpi(dpi);
        viewer.shows(expected, &format!("{dpi} dots an inch"));
    }
    viewer.keys(&["t"]);
    let told = viewer.changes_from(&large, "a message");
    let rows = told.rgb.chunks(640 * 3).zip(large.rgb.chunks(640 * 3));
    let covered = rows.filter(|(a, b)| a != b).count();
    assert!(covered > 40, "letters twice as high: {covered} rows");
}

#[test]
fn a_file_that_is_dropped_is_opened() {
    let Some(desk) = Desk::new() else { return };
    let other = SCENE.replace("255 80 0", "0 250 255");
    std::fs::write(desk.path("other.txt"), other).expect("written");
    let mut viewer = desk.view(&[]);
    viewer.shows(&desk.still(), "at start");
    let client = desk.client();
    client.drop_file(viewer.window(), &desk.path("other.txt"));
    let expected = desk.render_file("other.txt", &["--size", "320x240"]);
    viewer.shows(&expected, "the file that was dropped");
    let red = SCENE.replace("255 80 0", "255 0 0");
    std::fs::create_dir(desk.path("talks")).expect("a folder");
    std::fs::write(desk.path("talks/red.txt"), red).expect("written");
    client.drop_file(viewer.window(), &desk.path("talks"));
    let red = desk.render_file("talks/red.txt", &["--size", "320x240"]);
    viewer.shows(&red, "the scene of the folder that was dropped");
    client.drop_file(viewer.window(), &desk.path("other.txt"));
    viewer.shows(&expected, "the file again");
    std::fs::write(desk.path("bad.txt"), "<d 0").expect("written");
    client.drop_file(viewer.window(), &desk.path("bad.txt"));
    assert!(
        viewer.says(0).contains("bad.txt:1:5: expected"),
        "{:?}",
        viewer.words()
    );
    viewer.changes_from(&expected, "the error");
    viewer.keys(&["Escape"]);
    viewer.shows(&expected, "without the error");
    viewer.keys(&["Escape"]);
    assert_eq!(viewer.ends().code(), Some(0));
}

#[test]
fn a_worker_that_panics_is_told_and_the_next_picture_is_right() {
    let Some(desk) = Desk::new() else { return };
    let fault = "fault worker\norbit 31 -17\nlet-go\nsettle";
    let mut viewer = desk.view(&["--no-overlay", "--play-actions", "-"]);
    // A thread of the painter's, then one of those for slow engines.
    for (index, engine) in ["fast", "report"].into_iter().enumerate() {
        viewer.tell(fault);
        let report = settled(&viewer, index);
        assert_eq!(report["engine"], engine);
        viewer.shows(&rendered(&desk, &report), engine);
        let place = viewer.says(2 * index);
        assert!(place.starts_with("internal error at src/"), "{place}");
        assert!(place.ends_with(": a fault was asked for"), "{place}");
        assert_eq!(viewer.says(2 * index + 1), FAULT_TOLD);
        viewer.tell("next-engine\nnext-engine");
    }
    assert_eq!(viewer.words().len(), 4, "{:?}", viewer.words());
    viewer.keys(&["q"]);
    assert_eq!(viewer.ends().code(), Some(0));
}

#[test]
fn a_worker_that_panics_is_told_in_the_window() {
    let Some(desk) = Desk::new() else { return };
    let mut viewer = desk.view(&["--play-actions", "-"]);
    viewer.tell("fault worker\nnext-view\nsettle");
    let picture = rendered(&desk, &settled(&viewer, 0));
    assert_eq!(viewer.says(1), FAULT_TOLD);
    let told = viewer.grab();
    let rows = told.rgb.chunks(320 * 3).zip(picture.rgb.chunks(320 * 3));
    let covered = rows.filter(|(a, b)| a != b).count();
    assert!((8..40).contains(&covered), "a line: {covered} rows");
}

#[test]
fn a_screen_without_24_bits_a_pixel_is_told() {
    for screen in ["1600x1200x30", "1600x1200x16", "1600x1200x8"] {
        let Some(desk) = Desk::with(&["-screen", "0", screen]) else {
            return;
        };
        let run = desk.program().args(["view", "scene.txt"]).output();
        let run = run.expect("the program runs");
        let words = String::from_utf8_lossy(&run.stderr);
        assert_eq!(run.status.code(), Some(1), "{screen}: {words}");
        let clear = "error: the window takes no picture: Visual ";
        assert!(words.starts_with(clear), "{screen}: {words}");
        assert_eq!(words.lines().count(), 1, "{screen}: {words}");
    }
}

#[test]
fn on_a_screen_with_opacity_nothing_is_seen_through_the_picture() {
    let Some(desk) = Desk::with_opacity() else {
        return;
    };
    let mut viewer = desk.view(&[]);
    viewer.shows(&desk.still(), "at start");
    let client = desk.client();
    let opacity = client.highest_bytes(viewer.window());
    assert_eq!(opacity.len(), 320 * 240);
    assert!(opacity.iter().all(|&byte| byte == 255));
    viewer.keys(&["v"]);
    let ids = desk.render(&["--size", "320x240", "--view", "id"]);
    viewer.shows(&ids, "another view");
    viewer.resize(211, 333);
    let tall = desk.render(&["--size", "211x333", "--view", "id"]);
    viewer.shows(&tall, "another size");
    viewer.keys(&["q"]);
    assert_eq!(viewer.ends().code(), Some(0));
}

#[test]
fn without_shared_memory_a_small_window_shows_its_picture_and_a_huge_one_a_smaller_picture() {
    let arguments = [HUGE, &["-extension", "MIT-SHM"]].concat();
    let Some(desk) = Desk::with(&arguments) else {
        return;
    };
    let viewer = desk.view(&[]);
    viewer.shows(&desk.still(), "at start");
    viewer.resize(4096, 2160);
    let line = viewer.says(0);
    let size = line
        .strip_prefix("the X server shares no memory with us: the picture is ")
        .and_then(|rest| rest.strip_suffix(" at most"))
        .unwrap_or_else(|| panic!("{line}"));
    let expected = desk.render(&["--size", size]);
    assert!(expected.width < 4096 && expected.width > 2000, "{size}");
    viewer.shows_in_corner(&expected, size);
    viewer.resize(4000, 2160);
    viewer.resize(320, 240);
    viewer.shows(&desk.still(), "small again");
    assert_eq!(viewer.words().len(), 1, "{:?}", viewer.words());
    // A script that asks for too much goes on with what there is.
    let mut scripted = desk.view(&["--no-overlay", "--play-actions", "-"]);
    scripted.tell("resize 4096 2160\nsettle");
    let told: serde_json::Value = serde_json::from_str(&scripted.prints(0)).expect("JSON");
    assert_eq!(told["size"][0], expected.width);
    scripted.shows_in_corner(&expected, "by a script");
}

#[test]
fn a_server_that_is_killed_ends_the_program_with_1_and_a_word() {
    let Some(desk) = Desk::new() else { return };
    let mut viewer = desk.view(&["--play"]);
    viewer.changes_from(&desk.still(), "playing");
    desk.kill_server();
    let status = viewer.ends();
    let text = viewer.words().join("\n");
    assert_eq!(status.code(), Some(1), "{text}");
    assert!(!text.contains("panicked"), "{text}");
    // Ours, or that of the X library, which may be the first to see it and ends the program itself.
    let clear = [
        "XIO:",
        "the window takes no picture",
        "the window system failed",
        "X connection to",
    ];
    assert!(clear.iter().any(|words| text.contains(words)), "{text}");
}

#[test]
fn a_server_that_dies_in_the_middle_of_an_event_is_told_in_a_line() {
    let Some(desk) = Desk::new() else { return };
    let proxy = desk.proxy();
    for moves in [false, true] {
        let mut command = desk.program();
        command.args(["view", "scene.txt", "--size", "320x240"]);
        let mut viewer = Viewer::start(&desk, command.env("DISPLAY", &proxy.display));
        viewer.shows(&desk.still(), "at start");
        viewer.keys(if moves { &["x", "Tab"] } else { &["Tab"] });
        let to = |x: &str| viewer.hand(&["mousemove", "--window", "WINDOW", x, "50"]);
        // Onto the divider and away from it.
        to("160");
        to("40");
        viewer.rests("two sides");
        proxy.go_deaf();
        // winit gives the mouse another shape, and panics when it cannot.
        to("160");
        let status = viewer.ends();
        let words = viewer.words();
        assert_eq!(status.code(), Some(1), "{words:?}");
        let mut clear =
            "error: the window system failed: the connection to the display is broken".to_owned();
        if moves {
            clear += "; the moves are kept, and offered at the next start";
        }
        assert_eq!(words, [clear]);
    }
}

#[test]
fn a_program_that_slept_for_a_while_goes_on_where_the_clock_is() {
    let Some(desk) = Desk::new() else { return };
    let still = desk.still();
    let viewer = desk.view(&["--play", "--fps", "30", "--seconds-per-op", "0.3"]);
    viewer.signal("STOP");
    std::thread::sleep(Duration::from_millis(1200));
    viewer.signal("CONT");
    assert_eq!(viewer.says(0), "playback ended at frame 27");
    viewer.shows(&still, "after the sleep");
    // A key that was let go meanwhile does not turn on.
    viewer.hand(&["keydown", "z"]);
    viewer.changes_from(&still, "a turning picture");
    viewer.signal("STOP");
    viewer.hand(&["keyup", "z"]);
    std::thread::sleep(Duration::from_millis(300));
    viewer.signal("CONT");
    viewer.rests("a key let go");
}
