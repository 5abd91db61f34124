//! `--kiosk`: scenes in turn, and keys that do nothing.

use crate::support::{Desk, SCENE, Viewer, until};

#[test]
fn a_kiosk_shows_a_folders_scenes_in_turn_passes_over_bad_ones_and_knows_only_q() {
    let Some(desk) = Desk::new() else { return };
    let folder = desk.path("show");
    std::fs::create_dir(&folder).expect("made");
    let short = SCENE
        .replace("<z 0.7\n<x -0.25\n<y 0.125", "<z 0.7")
        .replace("<o\n3", "<o\n1");
    for (name, text) in [
        ("a.txt", short.clone()),
        ("b.txt", "no scene".to_owned()),
        ("c.txt", short.replace("255 80 0", "0 250 255")),
    ] {
        std::fs::write(folder.join(name), text).expect("written");
    }
    let last = |name: &str| desk.render_file(&format!("show/{name}"), &["--size", "320x240"]);
    let (first, second) = (last("a.txt"), last("c.txt"));
    let mut command = desk.program();
    command.args(["view", "--size", "320x240", "--kiosk", "show"]);
    let mut viewer = Viewer::start(&desk, command.args(["--steps"]));
    viewer.shows(&first, "the end of the first");
    viewer.keys(&["x", "Tab", "v", "Escape", "h"]);
    // It is quite black for a moment only.
    until("the dark between them", || {
        viewer.grab().rgb.iter().all(|&c| c < 100).then_some(())
    });
    viewer.shows(&second, "the end of the third");
    let line = viewer.says(0);
    assert!(line.starts_with("show/b.txt:1:1: expected"), "{line}");
    viewer.keys(&["q"]);
    assert_eq!(viewer.ends().code(), Some(0));
}

#[test]
fn a_kiosk_without_any_scene_ends_and_says_why() {
    let Some(desk) = Desk::new() else { return };
    std::fs::write(desk.path("bad.txt"), "no scene").expect("written");
    std::fs::create_dir(desk.path("empty")).expect("made");
    for (arguments, code, words) in [
        (
            &["--kiosk", "bad.txt", "none.txt"][..],
            1,
            "none.txt: no such file",
        ),
        (&["--kiosk", "empty"], 1, "no scene in"),
    ] {
        let output = desk.program().args(arguments).output().expect("it runs");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{said}");
        assert!(said.contains(words), "{said}");
    }
}
