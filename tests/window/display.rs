//! No display, the wrong display, and a display that is left over.

use std::os::unix::net::UnixListener;
use std::process::Output;

use crate::support::{Desk, Viewer};

fn no_window(output: &Output) {
    let words = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(4), "{words}");
    assert!(words.contains("`raybomb render"), "{words}");
    assert!(!words.contains("panicked"), "{words}");
}

#[test]
fn without_a_display_it_ends_with_4_and_names_render() {
    let Some(desk) = Desk::new() else { return };
    let run = |display: Option<&str>| {
        let mut command = desk.program();
        command.args(["view", "scene.txt"]);
        match display {
            Some(display) => command.env("DISPLAY", display),
            None => command.env_remove("DISPLAY"),
        };
        command.output().expect("the program runs")
    };
    for display in [None, Some(""), Some("nonsense"), Some(":64321")] {
        no_window(&run(display));
    }
}

#[test]
fn a_stale_wayland_display_does_not_hide_the_x_server() {
    let Some(desk) = Desk::new() else { return };
    let socket = desk.path("wayland-7");
    // A socket file whose owner is gone.
    drop(UnixListener::bind(&socket).expect("a socket"));
    for display in [socket.as_path(), "wayland-7".as_ref(), "nowhere".as_ref()] {
        let mut command = desk.program();
        command
            .args(["view", "scene.txt", "--size", "320x240"])
            .env("WAYLAND_DISPLAY", display)
            .env("XDG_RUNTIME_DIR", desk.path(""));
        let mut viewer = Viewer::start(&desk, &mut command);
        viewer.shows(&desk.still(), "on X11");
        viewer.keys(&["q"]);
        assert_eq!(viewer.ends().code(), Some(0));
    }
}

#[test]
fn a_stale_wayland_display_alone_is_no_display() {
    let Some(desk) = Desk::new() else { return };
    let output = desk
        .program()
        .args(["view", "scene.txt"])
        .env("WAYLAND_DISPLAY", desk.path("wayland-7"))
        .env_remove("DISPLAY")
        .output()
        .expect("the program runs");
    no_window(&output);
}
