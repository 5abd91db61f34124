//! Engines and views, one at a time and side by side: what the window shows is what `raybomb render` makes.

use serde_json::Value;

use crate::support::{Desk, Picture, Viewer};

const SIZE: [&str; 2] = ["--size", "320x240"];

fn rendered(desk: &Desk, options: &[&str]) -> Picture {
    desk.render(&[&SIZE, options].concat())
}

fn scripted(desk: &Desk) -> Viewer<'_> {
    desk.view(&["--no-overlay", "--play-actions", "-"])
}

/// Plays `script`, the `index`-th (from 0) that settles, and returns what it says.
fn settles(viewer: &mut Viewer<'_>, index: usize, script: &str) -> Value {
    viewer.tell(&format!("{script}\nsettle"));
    serde_json::from_str(&viewer.prints(index)).expect("JSON")
}

#[test]
fn split_in_two_it_shows_the_fast_engine_on_the_left_and_the_report_on_the_right() {
    let Some(desk) = Desk::new() else { return };
    let still = desk.still();
    let report = rendered(&desk, &["--engine", "report"]);
    assert!(still != report, "they differ at edges");
    let mut viewer = scripted(&desk);
    let told = settles(&mut viewer, 0, "split");
    assert_eq!(told["sides"][1]["engine"], "report");
    assert_eq!(told["sides"][1]["columns"], serde_json::json!([160, 320]));
    viewer.shows(&still.beside(&report, 160), "split");
    let ids = rendered(&desk, &["--view", "id"]);
    settles(
        &mut viewer,
        1,
        "divider 0.25\nnext-right-engine\nnext-right-view",
    );
    viewer.shows(&still.beside(&ids, 80), "views");
    let told = settles(&mut viewer, 2, "next-engine\nnext-right-engine");
    assert_eq!(told["sides"][1]["engine"], "brute");
    viewer.shows(&still.beside(&ids, 80), "brute force on both");
    settles(&mut viewer, 3, "split\nnext-engine\nnext-engine");
    viewer.shows(&still, "whole again");
}

#[test]
fn the_divider_follows_the_mouse_and_the_camera_turns_both_sides() {
    let Some(desk) = Desk::new() else { return };
    let still = desk.still();
    let report = rendered(&desk, &["--engine", "report"]);
    let viewer = desk.view(&["--no-overlay"]);
    viewer.shows(&still, "at start");
    viewer.keys(&["Tab"]);
    let both = |column| still.beside(&report, column);
    viewer.shows(&both(160), "Tab");
    let to = |x: &str| viewer.hand(&["mousemove", "--window", "WINDOW", x, "100"]);
    to("162");
    viewer.hand(&["mousedown", "1"]);
    to("90");
    viewer.shows(&both(90), "the divider at the left");
    to("250");
    viewer.shows(&both(250), "the divider at the right");
    viewer.hand(&["mouseup", "1"]);
    viewer.keys(&["x"]);
    viewer.changes_from(&both(250), "a turn");
    viewer.keys(&["Return"]);
    viewer.shows(&both(250), "and back");
    viewer.keys(&["Tab"]);
    viewer.shows(&still, "whole again");
}

#[test]
fn engines_follow_one_another_and_are_saved_whole() {
    let Some(desk) = Desk::new() else { return };
    let still = desk.still();
    let report = rendered(&desk, &["--engine", "report"]);
    let mut viewer = scripted(&desk);
    let told = settles(&mut viewer, 0, "next-engine");
    assert_eq!(
        (told["engine"].as_str(), told["aa"].as_u64()),
        (Some("brute"), Some(1))
    );
    viewer.shows(&still, "brute force");
    settles(&mut viewer, 1, "next-engine");
    viewer.shows(&report, "the report's method");
    viewer.tell("screenshot");
    assert_eq!(viewer.says(0), "saved raybomb-0001.png");
    let saved = std::fs::read(desk.path("raybomb-0001.png")).expect("a file");
    assert!(Picture::from_png(&saved) == report);
}

#[test]
fn function_keys_pick_views_and_the_cost_map_is_scaled_as_render_scales_it() {
    let Some(desk) = Desk::new() else { return };
    let viewer = desk.view(&["--no-overlay"]);
    viewer.shows(&desk.still(), "at start");
    viewer.keys(&["F3"]);
    viewer.shows(&rendered(&desk, &["--view", "normal"]), "F3");
    viewer.keys(&["F5"]);
    let cost = rendered(&desk, &["--view", "cost"]);
    viewer.shows(&cost, "F5");
    let brighter = rendered(&desk, &["--view", "cost", "--cost-scale", "256"]);
    assert!(brighter != cost);
    viewer.keys(&["F9", "F9"]);
    viewer.shows(&brighter, "F9");
    viewer.keys(&["F10", "F10"]);
    viewer.shows(&cost, "F10");
}

#[test]
fn the_cross_of_the_axes_turns_with_the_camera_and_is_no_part_of_the_picture() {
    let Some(desk) = Desk::new() else { return };
    let still = desk.still();
    let viewer = desk.view(&[]);
    viewer.shows(&still, "at start");
    viewer.keys(&["a"]);
    let with_cross = viewer.changes_from(&still, "a");
    let upper = 3 * 320 * 120;
    assert!(with_cross.rgb[..upper] == still.rgb[..upper]);
    viewer.keys(&["s"]);
    viewer.says(0);
    let saved = std::fs::read(desk.path("raybomb-0001.png")).expect("a file");
    assert!(Picture::from_png(&saved) == still);
}
