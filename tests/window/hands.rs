//! Keys and the mouse turn the picture, Enter brings it back to the bit.

use std::time::Duration;

use crate::support::{Desk, Picture, SCENE, Viewer, until};

#[test]
fn axis_keys_turn_the_picture_and_enter_restores_it() {
    let Some(desk) = Desk::new() else { return };
    let still = desk.still();
    let viewer = desk.view(&[]);
    viewer.shows(&still, "at start");
    let mut seen = Vec::new();
    for key in ["x", "y", "z", "X", "Y", "Z"] {
        viewer.keys(&[key]);
        viewer.changes_from(&still, key);
        let turned = viewer.rests(key);
        assert!(!seen.contains(&turned), "{key} turns like another key");
        seen.push(turned);
        viewer.keys(&["Return"]);
        viewer.shows(&still, "Enter");
    }
}

#[test]
fn a_key_that_does_nothing_says_so_for_a_moment() {
    let Some(desk) = Desk::new() else { return };
    let still = desk.still();
    let viewer = desk.view(&[]);
    viewer.shows(&still, "at start");
    viewer.keys(&["u"]);
    let told = viewer.changes_from(&still, "a message");
    let top = |picture: &Picture| picture.corner(320, 180);
    assert!(top(&told) == top(&still), "it is at the lower border");
    viewer.shows(&still, "no message");
}

#[test]
fn a_held_key_turns_until_it_is_let_go() {
    let Some(desk) = Desk::new() else { return };
    let viewer = desk.view(&[]);
    viewer.hand(&["keydown", "z"]);
    std::thread::sleep(Duration::from_millis(500));
    for _ in 0..5 {
        let old = viewer.grab();
        viewer.changes_from(&old, "a turning picture");
    }
    viewer.hand(&["keyup", "z"]);
    viewer.rests("a key let go");
}

#[test]
fn a_held_key_stops_turning_when_another_window_gets_the_keyboard() {
    let Some(desk) = Desk::new() else { return };
    let viewer = desk.view(&[]);
    let other = desk.view(&[]);
    other.hand(&["windowmove", "WINDOW", "700", "0"]);
    viewer.focus();
    viewer.hand(&["keydown", "z"]);
    std::thread::sleep(Duration::from_millis(500));
    let old = viewer.grab();
    viewer.changes_from(&old, "a turning picture");
    other.focus();
    viewer.rests("a window without the keyboard");
    viewer.hand(&["keyup", "z"]);
}

#[test]
fn the_mouse_orbits_pans_and_dollies_and_enter_restores() {
    let Some(desk) = Desk::new() else { return };
    let still = desk.still();
    let viewer = desk.view(&[]);
    viewer.shows(&still, "at start");
    let mut seen = Vec::new();
    for (button, held) in [("1", None), ("1", Some("shift")), ("2", None), ("3", None)] {
        let what = format!("button {button} with {held:?}");
        viewer.hand(&["mousemove", "--window", "WINDOW", "100", "100"]);
        if let Some(key) = held {
            viewer.hand(&["keydown", key]);
        }
        viewer.hand(&["mousedown", button]);
        viewer.hand(&["mousemove", "--window", "WINDOW", "131", "117"]);
        viewer.hand(&["mouseup", button]);
        if let Some(key) = held {
            viewer.hand(&["keyup", key]);
        }
        viewer.changes_from(&still, &what);
        let moved = viewer.rests(&what);
        viewer.hand(&["mousemove", "--window", "WINDOW", "10", "200"]);
        assert!(viewer.rests("no button") == moved, "{what} goes on");
        seen.push(moved);
        viewer.keys(&["Return"]);
        viewer.shows(&still, "Enter");
    }
    assert!(seen[1] == seen[2], "both ways to pan are the same");
    assert!(seen[0] != seen[1] && seen[0] != seen[3] && seen[1] != seen[3]);
    viewer.hand(&["click", "4"]);
    viewer.changes_from(&still, "the wheel");
    let nearer = viewer.rests("a notch");
    viewer.hand(&["click", "4"]);
    viewer.changes_from(&nearer, "another notch");
    // One step of undo each.
    viewer.keys(&["ctrl+z"]);
    viewer.shows(&nearer, "a notch less");
    viewer.keys(&["ctrl+z"]);
    viewer.shows(&still, "no notch");
    viewer.hand(&["click", "5"]);
    viewer.changes_from(&still, "the wheel the other way");
    viewer.keys(&["Return"]);
    viewer.shows(&still, "Enter after the wheel");
}

#[test]
fn q_and_esc_quit_with_0() {
    let Some(desk) = Desk::new() else { return };
    for key in ["q", "Escape"] {
        let mut viewer = desk.view(&[]);
        viewer.keys(&[key]);
        assert_eq!(viewer.ends().code(), Some(0), "{key}");
        assert_eq!(viewer.words(), Vec::<String>::new());
    }
}

#[test]
fn a_window_that_another_program_destroys_quits_with_0() {
    let Some(desk) = Desk::new() else { return };
    let mut viewer = desk.view(&["--play"]);
    viewer.hand(&["windowclose", "WINDOW"]);
    assert_eq!(viewer.ends().code(), Some(0));
}

#[test]
fn quitting_in_the_middle_of_playing_and_turning_is_clean() {
    let Some(desk) = Desk::new() else { return };
    let mut viewer = desk.view(&["--play"]);
    viewer.hand(&["keydown", "x"]);
    viewer.keys(&["i", "q"]);
    assert_eq!(viewer.ends().code(), Some(0));
}

#[test]
fn without_a_window_manager_it_takes_the_keyboard_that_no_window_has() {
    let Some(desk) = Desk::new() else { return };
    let still = desk.still();
    let mut command = desk.program();
    command.args(["view", "scene.txt", "--size", "320x240"]);
    let viewer = Viewer::open(&desk, &mut command);
    viewer.shows(&still, "at start");
    until("a key that reaches the window", || {
        viewer.keys(&["i"]);
        (viewer.rests("i") != still).then_some(())
    });
    viewer.keys(&["i"]);
    viewer.shows(&still, "i again");
    let other = Viewer::open(&desk, &mut command);
    other.shows(&still, "another window");
    viewer.keys(&["i"]);
    viewer.changes_from(&still, "the first one keeps the keyboard");
    drop((viewer, other));
    let next = Viewer::open(&desk, &mut command);
    next.shows(&still, "when they are gone");
    until("a key that reaches the next window", || {
        next.keys(&["i"]);
        (next.rests("i") != still).then_some(())
    });
}

#[test]
fn keys_that_come_before_the_scene_count() {
    let Some(desk) = Desk::new() else { return };
    let pipe = desk.path("slow.txt");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    assert!(made.expect("mkfifo").success());
    let mut command = desk.program();
    command.args(["view", "slow.txt", "--size", "320x240"]);
    let viewer = Viewer::start(&desk, &mut command);
    viewer.keys(&["v"]);
    std::thread::sleep(Duration::from_millis(300));
    std::fs::write(&pipe, SCENE).expect("written");
    let id = desk.render(&["--size", "320x240", "--view", "id"]);
    viewer.shows(&id, "the view that was asked for");
}
