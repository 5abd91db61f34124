//! The window under a window manager (openbox).

use crate::support::{Desk, Viewer, is_there, until};

/// A desk with a window manager.
fn managed() -> Option<Desk> {
    let desk = Desk::new().filter(|_| is_there(&["openbox"]))?;
    desk.manage();
    Some(desk)
}

#[test]
fn a_minimised_window_rests_and_comes_back_right() {
    let Some(desk) = managed() else { return };
    let viewer = desk.view(&[]);
    viewer.shows(&desk.still(), "at start");
    viewer.keys(&["space", "v"]);
    viewer.hand(&["windowminimize", "WINDOW"]);
    assert_eq!(viewer.says(0), "playback ended at frame 48");
    viewer.sleeps("a minimised window");
    viewer.hand(&["windowactivate", "--sync", "WINDOW"]);
    let id = desk.render(&["--size", "320x240", "--view", "id"]);
    viewer.shows(&id, "back on the screen");
    viewer.keys(&["k"]);
    viewer.shows(&id, "with the keyboard");
}

#[test]
fn nothing_is_painted_for_a_minimised_window_and_slow_engines_go_on_afterwards() {
    let Some(desk) = managed() else { return };
    desk.bring_bomb();
    let mut command = desk.program();
    command.args(["view", "bomb.txt", "--no-overlay", "--engine", "report"]);
    let viewer = Viewer::start(&desk, command.args(["--size", "640x480"]));
    // Black before the first outline.
    let outline = until("an outline", || {
        Some(viewer.grab()).filter(|shown| shown.rgb.iter().any(|&c| c != 0))
    });
    viewer.hand(&["windowminimize", "WINDOW"]);
    viewer.sleeps("a minimised window");
    viewer.hand(&["windowactivate", "--sync", "WINDOW"]);
    viewer.changes_from(&outline, "finer pixels");
}

#[test]
fn fullscreen_fills_the_screen_and_gives_back_size_and_place() {
    let Some(desk) = managed() else { return };
    let viewer = desk.view(&["--no-overlay"]);
    let still = desk.still();
    viewer.shows(&still, "at start");
    viewer.keys(&["f"]);
    viewer.shows(&desk.render(&["--size", "1600x1200"]), "fullscreen");
    viewer.keys(&["Escape"]);
    viewer.shows(&still, "as before");
}

#[test]
fn a_kiosk_fills_the_screen_whatever_windows_had_and_leaves_that_alone() {
    let Some(desk) = managed() else { return };
    let file = desk.path("state/raybomb/window.json");
    std::fs::create_dir_all(file.parent().expect("a folder")).expect("made");
    let whole = desk.render(&["--size", "1600x1200"]);
    for remembered in [None, Some(r#"{"place":[210,140],"size":[500,400]}"#)] {
        if let Some(text) = remembered {
            std::fs::write(&file, text).expect("written");
        }
        let mut command = desk.program();
        command.args(["view", "--kiosk", "scene.txt", "--steps"]);
        let mut viewer = Viewer::start(&desk, &mut command);
        viewer.shows(&whole, "all over the screen");
        viewer.keys(&["q"]);
        assert_eq!(viewer.ends().code(), Some(0));
        assert_eq!(std::fs::read_to_string(&file).ok().as_deref(), remembered);
    }
}

#[test]
fn the_place_is_kept_with_the_frame_around_it_and_a_maximised_window_keeps_what_it_was() {
    let Some(desk) = managed() else { return };
    let open = || {
        let mut command = desk.program();
        let viewer = Viewer::start(&desk, command.args(["view", "scene.txt", "--no-overlay"]));
        viewer.shows(&desk.render(&[]), "at start");
        viewer
    };
    let quit = |mut viewer: Viewer<'_>| {
        viewer.keys(&["q"]);
        assert_eq!(viewer.ends().code(), Some(0));
    };
    let viewer = open();
    viewer.hand(&["windowmove", "--sync", "WINDOW", "300", "200"]);
    let place = viewer.place();
    quit(viewer);
    for maximized in [false, true, false] {
        let viewer = open();
        until("the same place", || (viewer.place() == place).then_some(()));
        if maximized {
            desk.client().maximize(viewer.window());
            until("a window as wide as the screen", || {
                (viewer.grab().width > 1500).then_some(())
            });
            viewer.rests("maximised");
        }
        quit(viewer);
    }
}

#[test]
fn a_closed_window_asks_before_moves_are_lost() {
    let Some(desk) = managed() else { return };
    let mut viewer = desk.view(&[]);
    viewer.shows(&desk.still(), "at start");
    viewer.keys(&["r", "x"]);
    desk.client().close(viewer.window());
    assert!(viewer.says(0).starts_with("recorded moves are not saved"));
    viewer.keys(&["n"]);
    desk.client().close(viewer.window());
    viewer.says(1);
    viewer.keys(&["y"]);
    assert_eq!(viewer.ends().code(), Some(0));
}
