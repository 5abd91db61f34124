//! Space, and frames that are the same pictures however they are reached.

use std::time::Duration;

use crate::support::{Desk, Picture, Viewer};

/// No test is so slow that it sees the end.
const SLOW: &[&str] = &["--seconds-per-op", "100"];

/// The frame that the viewer reports in its line number `index`, as `render` writes it.
fn paused_frame(desk: &Desk, viewer: &Viewer<'_>, index: usize) -> (u64, Picture) {
    let line = viewer.says(index);
    let number = line
        .strip_prefix("paused at frame ")
        .unwrap_or_else(|| panic!("{line}"));
    let frame = ["--size", "320x240", "--frame", number];
    let picture = desk.render(&[&frame[..], SLOW].concat());
    (number.parse().expect("a number"), picture)
}

#[test]
fn a_paused_window_shows_the_frame_that_it_reports() {
    let Some(desk) = Desk::new() else { return };
    let viewer = desk.view(SLOW);
    viewer.shows(&desk.still(), "at start");
    let mut before = 0;
    for pause in 0..3 {
        viewer.keys(&["space"]);
        std::thread::sleep(Duration::from_millis(300));
        viewer.keys(&["space"]);
        let (number, picture) = paused_frame(&desk, &viewer, pause);
        assert!((before + 1..4800).contains(&number), "frame {number}");
        viewer.shows(&picture, &format!("frame {number}"));
        assert!(viewer.rests("a paused picture") == picture);
        before = number;
    }
    assert_eq!(viewer.words().len(), 3, "{:?}", viewer.words());
}

#[test]
fn playing_ends_on_the_still_picture_on_time() {
    let Some(desk) = Desk::new() else { return };
    let viewer = desk.view(&["--play", "--fps", "30", "--seconds-per-op", "0.4"]);
    assert_eq!(viewer.says(0), "playback ended at frame 36");
    viewer.shows(&desk.still(), "at the end");
    viewer.keys(&["space"]);
    assert_eq!(viewer.says(1), "playback ended at frame 36");
    viewer.shows(&desk.still(), "at the second end");
}

#[test]
fn the_hand_moves_on_top_of_the_frame_and_enter_returns() {
    let Some(desk) = Desk::new() else { return };
    let viewer = desk.view(&[&["--play"], SLOW].concat());
    std::thread::sleep(Duration::from_millis(500));
    viewer.keys(&["y", "space"]);
    let (number, picture) = paused_frame(&desk, &viewer, 0);
    assert!(viewer.rests("a turned frame") != picture, "frame {number}");
    viewer.keys(&["Return"]);
    viewer.shows(&picture, "after Enter");
}

#[test]
fn a_press_on_the_hidden_bar_shows_it_until_it_is_let_go() {
    let Some(desk) = Desk::new() else { return };
    let still = desk.still();
    let viewer = desk.view(&[]);
    viewer.shows(&still, "at start");
    // The last frame's place: the picture stays.
    viewer.hand(&["mousemove", "--window", "WINDOW", "306", "230"]);
    viewer.changes_from(&still, "the bar under the mouse");
    viewer.shows(&still, "the mouse rests");
    viewer.hand(&["mousedown", "1"]);
    let held = viewer.changes_from(&still, "the bar is held");
    std::thread::sleep(Duration::from_secs(3));
    assert!(viewer.rests("the hand rests") == held);
    viewer.hand(&["mouseup", "1"]);
    viewer.shows(&still, "let go, it goes away");
}
