//! The window on a Wayland compositor (weston, in a window of the X server's): the same pixels from the same hands.

use std::process::{Child, Command, Stdio};

use serde_json::Value;

use crate::support::{Desk, Picture, Viewer, is_there, until};

const SOCKET: &str = "wayland-test";

/// A compositor on the desk.
struct Compositor<'a> {
    desk: &'a Desk,
    child: Child,
}

impl<'a> Compositor<'a> {
    fn start(desk: &'a Desk) -> Option<Compositor<'a>> {
        Compositor::with(desk, 1600, 1200, 1)
    }

    /// On a screen of that size in logical pixels, `scale` physical ones each.
    fn with(desk: &'a Desk, width: u32, height: u32, scale: u32) -> Option<Compositor<'a>> {
        if !is_there(&["weston"]) {
            return None;
        }
        let child = desk
            .on_display(&mut Command::new("weston"))
            .args(["--backend=x11-backend.so", "--use-pixman", "--no-config"])
            .arg("--idle-time=0")
            .args([format!("--width={width}"), format!("--height={height}")])
            .arg(format!("--scale={scale}"))
            .arg(format!("--socket={SOCKET}"))
            .env("XDG_RUNTIME_DIR", desk.path(""))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("weston starts");
        let mut compositor = Compositor { desk, child };
        let window = until("a compositor", || {
            let ended = compositor.child.try_wait().expect("it is ours");
            assert!(ended.is_none(), "{ended:?}");
            let found = desk.xdotool(&["search", "--onlyvisible", "--class", "weston"]);
            let text = String::from_utf8_lossy(&found.stdout).into_owned();
            let window = text.lines().next().map(str::to_owned);
            window.filter(|_| desk.path(SOCKET).exists())
        });
        desk.xdotool(&["windowfocus", "--sync", &window]);
        compositor.leave();
        Some(compositor)
    }

    /// Takes the mouse, whose arrow is part of the screen, from the window.
    fn leave(&self) {
        self.desk.xdotool(&["mousemove", "1599", "1199"]);
    }

    /// The window with its scene at 640x480: from there on it only shrinks, and is all on the screen.
    fn view(&self, options: &[&str]) -> Viewer<'a> {
        self.open(&[&["--size", "640x480"], options].concat())
    }

    /// The same, played by a script; its first picture is on the screen, and it has printed a line.
    fn scripted(&self) -> Viewer<'a> {
        let mut viewer = self.view(&["--play-actions", "-"]);
        viewer.tell("settle");
        viewer.prints(0);
        self.shows(&self.desk.render(&[]), "at start");
        viewer
    }

    fn open(&self, options: &[&str]) -> Viewer<'a> {
        self.open_file("scene.txt", options)
    }

    fn open_file(&self, file: &str, options: &[&str]) -> Viewer<'a> {
        let mut command = self.desk.program();
        command
            .env_remove("DISPLAY")
            .env("WAYLAND_DISPLAY", SOCKET)
            .env("XDG_RUNTIME_DIR", self.desk.path(""))
            .args(["view", file, "--no-overlay"]);
        Viewer::run(self.desk, command.args(options))
    }

    /// Waits until `expected` is somewhere on the screen, to the bit, and tells where.
    fn shows(&self, expected: &Picture, what: &str) -> (usize, usize) {
        until(what, || self.desk.screen().place_of(expected))
    }

    /// Taps `key` until `old` is nowhere on the screen: on a busy machine the compositor may swallow a tap.
    fn leaves(&self, old: &Picture, key: &str) {
        until("another picture", || {
            self.keys(&[key]);
            self.desk.screen().place_of(old).is_none().then_some(())
        });
    }

    fn keys(&self, keys: &[&str]) {
        let arguments = [&["key"], keys].concat();
        assert!(self.desk.xdotool(&arguments).status.success());
    }

    fn signal(&self, name: &str) {
        let kill = format!("kill -{name} {}", self.child.id());
        let done = Command::new("sh").args(["-c", &kill]).status();
        assert!(done.expect("a shell").success(), "{kill}");
    }

    fn end(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Drop for Compositor<'_> {
    fn drop(&mut self) {
        self.end();
    }
}

#[test]
fn settled_pictures_are_on_the_screen_to_the_bit() {
    let Some(desk) = Desk::new() else { return };
    let Some(compositor) = Compositor::start(&desk) else {
        return;
    };
    let mut viewer = compositor.scripted();
    for (i, (width, height)) in [(500, 300), (31, 20), (320, 240)].into_iter().enumerate() {
        viewer.tell(&format!("next-view\nresize {width} {height}\nsettle"));
        let told: Value = serde_json::from_str(&viewer.prints(i + 1)).expect("JSON");
        assert_eq!(told["size"], serde_json::json!([width, height]));
        let view = told["view"].as_str().expect("a view");
        let size = format!("{width}x{height}");
        let expected = desk.render(&["--size", &size, "--view", view]);
        compositor.shows(&expected, &size);
    }
    viewer.tell("quit");
    assert_eq!(viewer.ends().code(), Some(0));
}

#[test]
fn on_a_fine_screen_windows_have_the_size_that_is_asked_for_and_do_not_grow() {
    let Some(desk) = Desk::new() else { return };
    let Some(compositor) = Compositor::with(&desk, 800, 600, 2) else {
        return;
    };
    for size in ["640x480", "640x480", "500x300"] {
        let asked = ["--size", "500x300"];
        let options = &asked[..if size == "500x300" { 2 } else { 0 }];
        let mut viewer = compositor.open(options);
        compositor.shows(&desk.render(&["--size", size]), size);
        compositor.keys(&["q"]);
        assert_eq!(viewer.ends().code(), Some(0));
        assert!(!desk.path("state/raybomb/window.json").exists());
    }
}

#[test]
fn a_window_that_no_picture_is_taken_of_rests_and_comes_back_right() {
    let Some(desk) = Desk::new() else { return };
    let Some(compositor) = Compositor::start(&desk) else {
        return;
    };
    let mut viewer = compositor.scripted();
    // A compositor that does nothing sends no frame callbacks, as for a minimised window.
    compositor.signal("STOP");
    viewer.tell(&"next-view\nwait 0.1\n".repeat(6));
    viewer.tell("print-camera");
    assert_eq!(viewer.prints(1), "<s", "it waits for the compositor");
    viewer.sleeps("a window that nobody sees");
    compositor.signal("CONT");
    compositor.shows(&desk.render(&["--view", "id"]), "seen again");
    viewer.tell("quit");
    assert_eq!(viewer.ends().code(), Some(0));
    // A picture that takes its time.
    desk.bring_bomb();
    let options = ["--size", "640x480", "--engine", "report"];
    let viewer = compositor.open_file("bomb.txt", &options);
    until("a slow engine at work", || {
        (viewer.cpu_ticks() > 100).then_some(())
    });
    compositor.signal("STOP");
    viewer.sleeps("a slow engine for a window that nobody sees");
    let rested = viewer.cpu_ticks();
    compositor.signal("CONT");
    until("the same at work again", || {
        (viewer.cpu_ticks() > rested + 50).then_some(())
    });
}

#[test]
fn hands_reach_the_window_and_moves_outlive_a_compositor_that_is_killed() {
    let Some(desk) = Desk::new() else { return };
    let Some(mut compositor) = Compositor::start(&desk) else {
        return;
    };
    let mut viewer = compositor.view(&[]);
    let still = desk.render(&[]);
    let (x, y) = compositor.shows(&still, "at start");
    let middle = [x + 320, y + 240].map(|n| n.to_string());
    compositor.keys(&["v"]);
    let id = desk.render(&["--view", "id"]);
    compositor.shows(&id, "the next view");
    compositor.keys(&["v", "v", "v", "v"]);
    compositor.shows(&still, "all views");
    compositor.keys(&["r"]);
    desk.xdotool(&["mousemove", &middle[0], &middle[1]]);
    desk.xdotool(&["mousedown", "1"]);
    desk.xdotool(&["mousemove_relative", "40", "-25"]);
    desk.xdotool(&["mouseup", "1"]);
    compositor.leave();
    // Moves that no file has, and a compositor that goes.
    compositor.leaves(&still, "z");
    compositor.end();
    assert_eq!(viewer.ends().code(), Some(1));
    let text = viewer.words().join("\n");
    assert!(!text.contains("panicked"), "{text}");
    let clear = ["the window system failed", "the window takes no picture"];
    assert!(clear.iter().any(|words| text.contains(words)), "{text}");
    let journals = std::fs::read_dir(desk.path("state/raybomb/moves"));
    assert_eq!(journals.expect("a folder").count(), 1);
}
