//! What the window shows, at every size, and what is drawn over it.

use std::time::Duration;

use crate::support::{Desk, Picture, until};

#[test]
fn it_opens_on_the_picture_that_render_writes() {
    let Some(desk) = Desk::new() else { return };
    let viewer = desk.view(&[]);
    println!("a window after {:?}", viewer.opened_in);
    viewer.shows(&desk.still(), "at start");
    assert!(
        viewer.opened_in < Duration::from_secs(5),
        "{:?}",
        viewer.opened_in
    );
}

#[test]
fn it_has_the_planes_shape_when_no_size_is_asked_for() {
    let Some(desk) = Desk::new() else { return };
    let mut command = desk.program();
    let viewer = crate::support::Viewer::start(&desk, command.arg("scene.txt"));
    let expected = desk.render(&[]);
    assert_eq!((expected.width, expected.height), (640, 480));
    viewer.shows(&expected, "at start");
}

#[test]
fn picture_options_mean_what_they_mean_to_render() {
    let Some(desk) = Desk::new() else { return };
    for options in [
        &["--view", "depth", "--stretch"][..],
        &["--reflection", "as-printed", "--threads", "1"],
        &["--pivot", "centre", "--kernel", "scalar"],
        &["--engine", "brute", "--view", "normal"],
    ] {
        let size = ["--size", "300x100"];
        let mut command = desk.program();
        command.args(["view", "scene.txt"]).args(size).args(options);
        let viewer = crate::support::Viewer::start(&desk, &mut command);
        let both: Vec<&str> = size.iter().chain(options).copied().collect();
        viewer.shows(&desk.render(&both), &format!("{options:?}"));
    }
}

#[test]
fn every_size_shows_its_own_picture() {
    let Some(desk) = Desk::new() else { return };
    let viewer = desk.view(&[]);
    viewer.shows(&desk.still(), "at start");
    for (width, height) in [
        (333, 217),
        (1, 1),
        (64, 1000),
        (1500, 40),
        (1, 700),
        (320, 240),
    ] {
        viewer.resize(width, height);
        let size = format!("{width}x{height}");
        viewer.shows(&desk.render(&["--size", &size]), &size);
    }
}

#[test]
fn a_storm_of_sizes_ends_on_the_last_one() {
    let Some(desk) = Desk::new() else { return };
    let viewer = desk.view(&["--play"]);
    for i in 0..60 {
        viewer.resize(1 + (i * 137) % 900, 1 + (i * 71) % 700);
    }
    viewer.resize(320, 240);
    viewer.keys(&["End"]);
    viewer.shows(&desk.still(), "after the storm");
}

#[test]
fn a_covered_window_rests_and_shows_the_right_picture_afterwards() {
    let Some(desk) = Desk::new() else { return };
    let viewer = desk.view(&[]);
    viewer.shows(&desk.still(), "at start");
    viewer.keys(&["space"]);
    let other = desk.view(&[]);
    assert_eq!(viewer.says(0), "playback ended at frame 48");
    viewer.focus();
    viewer.keys(&["v"]);
    other.hand(&["windowmove", "WINDOW", "700", "0"]);
    let id = desk.render(&["--size", "320x240", "--view", "id"]);
    viewer.shows(&id, "uncovered");
}

#[test]
fn the_overlay_comes_and_goes_and_leaves_the_picture_as_it_was() {
    let Some(desk) = Desk::new() else { return };
    let still = desk.still();
    let viewer = desk.view(&[]);
    viewer.shows(&still, "at start");
    for key in ["i", "h", "question"] {
        viewer.keys(&[key]);
        viewer.changes_from(&still, "the overlay");
        viewer.keys(&[key]);
        viewer.shows(&still, key);
    }
    viewer.keys(&["h"]);
    viewer.changes_from(&still, "the sheet");
    viewer.keys(&["Escape"]);
    viewer.shows(&still, "Esc closes the sheet");
}

#[test]
fn without_overlay_nothing_is_ever_drawn_over_the_picture() {
    let Some(desk) = Desk::new() else { return };
    let still = desk.still();
    let viewer = desk.view(&["--no-overlay"]);
    viewer.shows(&still, "at start");
    viewer.keys(&["i", "h", "s"]);
    assert_eq!(viewer.says(0), "saved raybomb-0001.png");
    for _ in 0..10 {
        std::thread::sleep(Duration::from_millis(30));
        assert!(viewer.grab() == still, "something was drawn");
    }
}

#[test]
fn a_screenshot_is_the_picture_without_the_overlay() {
    let Some(desk) = Desk::new() else { return };
    let still = desk.still();
    std::fs::write(desk.path("raybomb-0001.png"), "mine").expect("written");
    let viewer = desk.view(&[]);
    viewer.shows(&still, "at start");
    viewer.keys(&["i"]);
    viewer.changes_from(&still, "statistics");
    viewer.keys(&["s"]);
    assert_eq!(viewer.says(0), "saved raybomb-0002.png");
    let file = std::fs::read(desk.path("raybomb-0002.png")).expect("a file");
    assert!(Picture::from_png(&file) == still);
    let mine = std::fs::read(desk.path("raybomb-0001.png")).expect("a file");
    assert_eq!(mine, b"mine");
    viewer.keys(&["i"]);
    // The message goes by itself.
    viewer.shows(&still, "after the message");
}

#[test]
fn v_shows_the_next_view_and_k_the_same_picture_by_another_kernel() {
    let Some(desk) = Desk::new() else { return };
    let viewer = desk.view(&[]);
    for view in ["id", "normal", "depth"] {
        viewer.keys(&["v"]);
        viewer.shows(&desk.render(&["--size", "320x240", "--view", view]), view);
    }
    let depth = viewer.grab();
    viewer.keys(&["k"]);
    viewer.changes_from(&depth, "the kernel's name");
    viewer.shows(&depth, "the same picture without it");
}

#[test]
fn an_idle_window_uses_no_cpu() {
    let Some(desk) = Desk::new() else { return };
    let viewer = desk.view(&[]);
    viewer.shows(&desk.still(), "at start");
    viewer.keys(&["i"]);
    let idle = || {
        std::thread::sleep(Duration::from_millis(500));
        let before = viewer.cpu_ticks();
        std::thread::sleep(Duration::from_secs(3));
        viewer.cpu_ticks() - before
    };
    assert!(idle() <= 1, "after the start");
    viewer.keys(&["x", "space"]);
    std::thread::sleep(Duration::from_millis(300));
    viewer.keys(&["space"]);
    until("the pause", || (!viewer.words().is_empty()).then_some(()));
    assert!(idle() <= 1, "after a turn and a pause");
}
