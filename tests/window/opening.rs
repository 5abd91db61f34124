//! Scenes that are loaded while the window is there: at the start, saved again, and other files of the folder.

use std::time::Duration;

use crate::support::{Desk, Viewer, until};

/// The scene with its first colour changed.
fn other(desk: &Desk) -> String {
    let scene = std::fs::read_to_string(desk.path("scene.txt")).expect("a scene");
    scene.replace("255 80 0", "0 250 255")
}

fn picture(desk: &Desk, name: &str) -> crate::support::Picture {
    desk.render_file(name, &["--size", "320x240"])
}

/// A large scene: many times the triangles of the small one.
fn write_large(desk: &Desk, name: &str) {
    let triangle = "-2 -1 -1  2 -1 -1  0 0 2  255 80 0\n";
    let head = "<s 0 -6 4 -4 -2 3 4 -2 3 -4 -2 -3 0.3 1 -1 200000\n";
    let text = head.to_owned() + &triangle.repeat(200_000);
    std::fs::write(desk.path(name), text).expect("a large scene");
}

#[test]
fn a_file_saved_again_is_shown_with_the_hands_turn_and_the_frame_kept() {
    let Some(desk) = Desk::new() else { return };
    let still = desk.still();
    let viewer = desk.view(&[]);
    viewer.shows(&still, "at start");
    std::fs::write(desk.path("other.txt"), other(&desk)).expect("written");
    let expected = picture(&desk, "other.txt");
    assert!(expected != still);
    // By a rename, as editors do it, and back by writing into the file.
    let first = std::fs::read(desk.path("scene.txt")).expect("read");
    std::fs::rename(desk.path("other.txt"), desk.path("scene.txt")).expect("renamed");
    viewer.shows(&expected, "saved by a rename");
    std::fs::write(desk.path("scene.txt"), &first).expect("written");
    viewer.shows(&still, "saved in place");
    viewer.keys(&["x"]);
    viewer.changes_from(&still, "a turn");
    let turned = viewer.rests("a turn");
    std::fs::write(desk.path("scene.txt"), other(&desk)).expect("written");
    viewer.changes_from(&turned, "saved while turned");
    assert!(
        viewer.rests("saved while turned") != expected,
        "the turn is lost"
    );
    std::fs::write(desk.path("scene.txt"), &first).expect("written");
    viewer.shows(&turned, "the first one, turned");
}

#[test]
fn a_bad_save_shows_the_error_over_the_last_good_picture_until_it_is_good_again() {
    let Some(desk) = Desk::new() else { return };
    let still = desk.still();
    let viewer = desk.view(&[]);
    viewer.shows(&still, "at start");
    let good = std::fs::read_to_string(desk.path("scene.txt")).expect("read");
    let bad = good.replace("0.3 1 -1", "0.3 one -1");
    std::fs::write(desk.path("scene.txt"), bad).expect("written");
    let board = viewer.changes_from(&still, "the error");
    let edge = 3 * 320 * 20;
    assert!(board.rgb[..edge] == still.rgb[..edge], "the picture stays");
    let line = viewer.says(0);
    assert!(line.starts_with("scene.txt:6:5: expected"), "{line}");
    // What hands do goes on under the error.
    viewer.keys(&["x"]);
    viewer.changes_from(&board, "a turn under the error");
    viewer.keys(&["Return"]);
    std::fs::write(desk.path("scene.txt"), good).expect("written");
    viewer.shows(&still, "good again");
}

#[test]
fn page_keys_go_through_the_scenes_of_the_folder() {
    let Some(desk) = Desk::new() else { return };
    let still = desk.still();
    std::fs::write(desk.path("zebra.txt"), other(&desk)).expect("written");
    std::fs::write(desk.path("notes.txt"), "no scene").expect("written");
    let expected = picture(&desk, "zebra.txt");
    let viewer = desk.view(&[]);
    viewer.shows(&still, "at start");
    viewer.keys(&["Next"]);
    viewer.shows(&expected, "the next one");
    viewer.keys(&["Next"]);
    let line = viewer.says(0);
    assert!(line.starts_with("notes.txt:1:1: expected"), "{line}");
    viewer.changes_from(&expected, "the error");
    viewer.keys(&["Next"]);
    viewer.shows(&still, "round to the first");
    viewer.keys(&["Prior", "Prior"]);
    viewer.shows(&expected, "two back");
}

#[test]
fn a_bad_scene_at_the_start_ends_with_3_and_its_place() {
    let Some(desk) = Desk::new() else { return };
    std::fs::write(desk.path("bad.txt"), "<d\n0 0 x").expect("written");
    for (file, code, words) in [
        ("bad.txt", 3, "bad.txt:2:5: expected"),
        ("none.txt", 1, "error: cannot read none.txt: no such file"),
    ] {
        let output = desk
            .program()
            .args(["view", file])
            .output()
            .expect("it runs");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{said}");
        assert!(said.starts_with(words), "{said}");
    }
}

/// The program on a pipe into which nothing is written yet.
fn view_pipe(desk: &Desk) -> Viewer<'_> {
    let made = std::process::Command::new("mkfifo")
        .arg(desk.path("pipe"))
        .status();
    assert!(made.expect("mkfifo runs").success());
    let mut command = desk.program();
    Viewer::start(desk, command.args(["view", "pipe", "--size", "320x240"]))
}

#[test]
fn the_window_is_there_before_the_scene_and_tells_how_far_it_is() {
    let Some(desk) = Desk::new() else { return };
    let still = desk.still();
    let viewer = view_pipe(&desk);
    let bright = |p: &crate::support::Picture| p.rgb.iter().any(|&c| c > 200);
    until("words in the window", || {
        bright(&viewer.grab()).then_some(())
    });
    // Keys that need a scene do nothing yet.
    viewer.keys(&["x", "space", "s"]);
    let scene = std::fs::read(desk.path("scene.txt")).expect("read");
    std::fs::write(desk.path("pipe"), scene).expect("written");
    viewer.shows(&still, "after loading");
    assert_eq!(viewer.words(), Vec::<String>::new());
}

#[test]
fn esc_gives_up_the_first_load_and_the_program() {
    let Some(desk) = Desk::new() else { return };
    let mut viewer = view_pipe(&desk);
    viewer.keys(&["Escape"]);
    assert_eq!(viewer.ends().code(), Some(0));
    assert_eq!(viewer.words(), Vec::<String>::new());
}

#[test]
fn esc_gives_up_a_load_and_keeps_the_scene() {
    let Some(desk) = Desk::new() else { return };
    write_large(&desk, "large.txt");
    let still = desk.still();
    let viewer = desk.view(&["--threads", "1"]);
    viewer.shows(&still, "at start");
    viewer.keys(&["Prior", "Escape"]);
    assert_eq!(viewer.says(0), "loading cancelled");
    viewer.shows(&still, "after Esc");
    std::thread::sleep(Duration::from_millis(800));
    assert!(viewer.rests("long after Esc") == still);
}

#[test]
fn a_window_that_watches_a_file_uses_no_cpu() {
    let Some(desk) = Desk::new() else { return };
    let viewer = desk.view(&["--aa", "4"]);
    viewer.shows(&desk.render(&["--size", "320x240", "--aa", "4"]), "refined");
    std::fs::write(desk.path("beside.txt"), "not ours").expect("written");
    std::thread::sleep(Duration::from_millis(300));
    let before = viewer.cpu_ticks();
    std::thread::sleep(Duration::from_secs(2));
    assert!(viewer.cpu_ticks() - before <= 1);
    until("no words", || viewer.words().is_empty().then_some(()));
}
