//! What outlives a window: settings, its size and place, and moves that no file has.

use crate::support::{Desk, Picture, SCENE, Viewer};

fn drag(viewer: &Viewer<'_>, button: &str, (dx, dy): (i32, i32)) {
    let to = |x: i32, y: i32| {
        let (x, y) = (x.to_string(), y.to_string());
        viewer.hand(&["mousemove", "--window", "WINDOW", &x, &y]);
    };
    to(100, 100);
    viewer.hand(&["mousedown", button]);
    to(100 + dx, 100 + dy);
    viewer.hand(&["mouseup", button]);
}

/// A recorded drag and turn, and a pan that is not recorded.
fn make_moves(viewer: &Viewer<'_>, still: &Picture) -> Picture {
    viewer.shows(still, "at start");
    viewer.keys(&["r"]);
    drag(viewer, "1", (40, -25));
    viewer.keys(&["z", "r"]);
    drag(viewer, "2", (15, 20));
    let moved = viewer.rests("moves");
    assert!(moved != *still);
    moved
}

/// Answers the question what is to become of moves that were left over.
fn answer(viewer: &Viewer<'_>, index: usize, key: &str) {
    let question = viewer.says(index);
    assert!(question.starts_with("moves of a session"), "{question}");
    viewer.keys(&[key]);
}

fn quit(viewer: Viewer<'_>) {
    quit_with(viewer, 0);
}

/// Quits a window that has said so many lines.
fn quit_with(mut viewer: Viewer<'_>, lines: usize) {
    viewer.keys(&["q"]);
    assert_eq!(viewer.ends().code(), Some(0), "{:?}", viewer.words());
    assert_eq!(viewer.words().len(), lines, "{:?}", viewer.words());
}

#[test]
fn moves_outlive_a_display_server_that_is_killed() {
    let Some(mut desk) = Desk::new() else { return };
    let still = desk.still();
    let moved = {
        let mut viewer = desk.view(&["--no-overlay"]);
        let moved = make_moves(&viewer, &still);
        desk.kill_server();
        assert_eq!(viewer.ends().code(), Some(1));
        moved
    };
    desk.restart_server();
    {
        let mut viewer = desk.view(&["--no-overlay"]);
        answer(&viewer, 0, "y");
        viewer.shows(&moved, "taken back");
        viewer.keys(&["ctrl+z"]);
        viewer.shows(&still, "undone");
        viewer.keys(&["ctrl+shift+z", "ctrl+s"]);
        assert_eq!(viewer.says(1), "saved scene.txt");
        assert!(desk.still() == moved, "the saved file's picture is another");
        viewer.keys(&["q"]);
        assert_eq!(viewer.ends().code(), Some(0));
    }
    let viewer = desk.view(&["--no-overlay"]);
    viewer.shows(&moved, "saved");
    quit(viewer);
}

#[test]
fn windows_on_one_file_leave_their_own_moves_and_unwanted_ones_go() {
    let Some(desk) = Desk::new() else { return };
    let still = desk.still();
    let pictures = ["x", "y"].map(|key| {
        let viewer = desk.view(&["--no-overlay"]);
        viewer.shows(&still, "at start");
        viewer.keys(&["r", key]);
        (viewer.rests(key), viewer)
    });
    let pictures = pictures.map(|(picture, mut viewer)| {
        viewer.signal("KILL");
        viewer.ends();
        picture
    });
    {
        let mut viewer = desk.view(&["--no-overlay"]);
        answer(&viewer, 0, "y");
        viewer.changes_from(&still, "taken back");
        assert!(pictures.contains(&viewer.rests("taken back")));
        viewer.signal("KILL");
        viewer.ends();
    }
    let mut viewer = desk.view(&[]);
    answer(&viewer, 0, "n");
    answer(&viewer, 1, "n");
    viewer.shows(&still, "dropped");
    viewer.keys(&["q"]);
    assert_eq!(viewer.ends().code(), Some(0));
    quit(desk.view(&[]));
    assert_eq!(
        std::fs::read_to_string(desk.path("scene.txt"))
            .ok()
            .as_deref(),
        Some(SCENE)
    );
}

#[test]
fn a_window_that_quits_leaves_no_moves_and_a_damaged_journal_is_told() {
    let Some(desk) = Desk::new() else { return };
    let folder = desk.path("state/raybomb/moves");
    let journals = || std::fs::read_dir(&folder).map_or(0, Iterator::count);
    let mut viewer = desk.view(&["--no-overlay"]);
    make_moves(&viewer, &desk.still());
    assert_eq!(journals(), 1);
    viewer.keys(&["q", "y"]);
    assert_eq!(viewer.ends().code(), Some(0));
    assert_eq!(journals(), 0);
    let mut viewer = desk.view(&["--no-overlay"]);
    make_moves(&viewer, &desk.still());
    viewer.signal("KILL");
    viewer.ends();
    let file = std::fs::read_dir(&folder)
        .expect("journals")
        .flatten()
        .next();
    let file = file.expect("a journal").path();
    let mut bytes = std::fs::read(&file).expect("a journal");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(&file, bytes).expect("written");
    let mut viewer = desk.view(&["--no-overlay"]);
    assert!(
        viewer
            .says(0)
            .starts_with("a damaged journal of moves is ignored")
    );
    viewer.shows(&desk.still(), "without the moves");
    viewer.keys(&["q"]);
    assert_eq!(viewer.ends().code(), Some(0));
    let hermetic = desk.view(&["--no-overlay", "--no-config"]);
    make_moves(&hermetic, &desk.still());
    assert_eq!(journals(), 1, "the damaged one alone");
}

#[test]
fn moves_are_still_offered_when_the_file_is_saved_meanwhile() {
    let Some(desk) = Desk::new() else { return };
    let mut viewer = desk.view(&["--no-overlay"]);
    make_moves(&viewer, &desk.still());
    viewer.signal("KILL");
    viewer.ends();
    let viewer = desk.view(&["--no-overlay"]);
    assert!(viewer.says(0).starts_with("moves of a session"));
    let other = SCENE.replace("255 80 0", "0 250 255");
    std::fs::write(desk.path("scene.txt"), other).expect("written");
    answer(&viewer, 1, "y");
    viewer.changes_from(&desk.still(), "taken back");
    let moved = viewer.rests("taken back");
    viewer.keys(&["ctrl+s"]);
    assert_eq!(viewer.says(2), "saved scene.txt");
    assert!(desk.still() == moved, "the saved file's picture is another");
}

#[test]
fn a_signal_leaves_the_moves_that_are_recorded_and_no_others() {
    let Some(desk) = Desk::new() else { return };
    let still = desk.still();
    for (keys, left) in [(&["x"][..], false), (&["r", "x"], true)] {
        let mut viewer = desk.view(&["--no-overlay"]);
        viewer.shows(&still, "at start");
        viewer.keys(keys);
        viewer.changes_from(&still, "a turn");
        viewer.rests("a turn");
        viewer.signal("INT");
        assert_eq!(viewer.ends().code(), Some(130));
        let viewer = desk.view(&["--no-overlay"]);
        if left {
            answer(&viewer, 0, "n");
        }
        viewer.shows(&still, "at the next start");
        quit_with(viewer, usize::from(left));
    }
}

#[test]
fn size_and_place_are_those_of_the_last_window() {
    let Some(desk) = Desk::new() else { return };
    let open = |options: &[&str]| {
        let mut command = desk.program();
        Viewer::start(&desk, command.args(["view", "scene.txt"]).args(options))
    };
    let viewer = open(&[]);
    viewer.shows(&desk.render(&[]), "the plane's shape");
    viewer.resize(500, 300);
    viewer.hand(&["windowmove", "WINDOW", "210", "120"]);
    let expected = desk.render(&["--size", "500x300"]);
    viewer.shows(&expected, "resized");
    quit(viewer);
    for options in [&[][..], &["--no-config"], &["--play-actions", "-"]] {
        let viewer = open(options);
        if options.is_empty() {
            viewer.shows(&expected, "the remembered size");
            assert_eq!(viewer.place(), (210, 120));
        } else {
            viewer.shows(&desk.render(&[]), "the plane's shape");
            viewer.resize(400, 400);
            viewer.shows(&desk.render(&["--size", "400x400"]), "another size");
        }
        quit(viewer);
    }
    let viewer = open(&["--size", "320x240"]);
    viewer.shows(&desk.still(), "the size that is asked for");
    quit(viewer);
    open(&[]).shows(&expected, "still the remembered size");
}

#[test]
fn settings_are_followed() {
    let Some(desk) = Desk::new() else { return };
    std::fs::create_dir_all(desk.path("config/raybomb")).expect("a folder");
    let settings = "[options]\nview = \"id\"\nsize = \"300x200\"\n[keys]\nquit = \"Ctrl+w\"\nnext-view = \"q\"\nturn-x = \"w\"\n";
    std::fs::write(desk.path("config/raybomb/config.toml"), settings).expect("written");
    let mut command = desk.program();
    let mut viewer = Viewer::start(&desk, command.args(["view", "scene.txt"]));
    let size = ["--size", "300x200", "--view"];
    let view = |name: &'static str| desk.render(&[&size[..], &[name]].concat());
    viewer.shows(&view("id"), "the view of the settings");
    viewer.keys(&["q"]);
    viewer.shows(&view("normal"), "the next view");
    viewer.keys(&["w"]);
    viewer.changes_from(&view("normal"), "a turn");
    viewer.keys(&["ctrl+w"]);
    assert_eq!(viewer.ends().code(), Some(0));
    let options = ["--view", "depth"];
    let viewer = desk.view(&options);
    let expected = desk.render(&["--size", "320x240", "--view", "depth"]);
    viewer.shows(&expected, "the command line wins");
}
