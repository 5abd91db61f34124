//! Recording with real keys and a real mouse; picks; the question before recorded moves are lost.

use serde_json::Value;

use crate::support::{Desk, SCENE, Viewer};

fn drag(viewer: &Viewer<'_>, button: &str, (x, y): (i32, i32), (dx, dy): (i32, i32)) {
    let place = |x: i32, y: i32| [x.to_string(), y.to_string()];
    let to = |[x, y]: [String; 2]| viewer.hand(&["mousemove", "--window", "WINDOW", &x, &y]);
    to(place(x, y));
    viewer.hand(&["mousedown", button]);
    to(place(x + dx, y + dy));
    viewer.hand(&["mouseup", button]);
}

#[test]
fn what_is_recorded_and_saved_is_rendered_to_the_bit() {
    let Some(desk) = Desk::new() else { return };
    let mut viewer = desk.view(&["--no-overlay"]);
    let still = desk.still();
    viewer.shows(&still, "at start");
    viewer.keys(&["r"]);
    drag(&viewer, "1", (100, 100), (40, -25));
    viewer.hand(&["keydown", "z"]);
    drag(&viewer, "1", (100, 100), (25, 10));
    viewer.hand(&["keyup", "z"]);
    viewer.hand(&["keydown", "ctrl"]);
    drag(&viewer, "1", (100, 100), (15, 0));
    viewer.hand(&["keyup", "ctrl"]);
    viewer.keys(&["x"]);
    let recorded = viewer.rests("recorded turns");
    viewer.keys(&["ctrl+shift+s"]);
    assert_eq!(viewer.says(0), "saved scene-0001.txt");
    let size = ["--size", "320x240"];
    assert!(desk.render_file("scene-0001.txt", &size) == recorded);
    drag(&viewer, "2", (100, 100), (15, 20));
    let panned = viewer.rests("a pan");
    assert!(panned != recorded);
    viewer.keys(&["ctrl+s"]);
    assert_eq!(viewer.says(1), "saved scene-0001.txt");
    assert!(desk.render_file("scene-0001.txt", &size) == panned);
    assert!(
        desk.still() == still,
        "the scene that was opened is as it was"
    );
    for _ in 0..5 {
        viewer.keys(&["ctrl+z"]);
    }
    viewer.shows(&still, "undone");
    for _ in 0..5 {
        viewer.keys(&["ctrl+shift+z"]);
    }
    viewer.shows(&panned, "done again");
    viewer.keys(&["q"]);
    assert_eq!(viewer.ends().code(), Some(0));
}

#[test]
fn unsaved_recorded_moves_are_asked_about() {
    let Some(desk) = Desk::new() else { return };
    let mut viewer = desk.view(&[]);
    viewer.shows(&desk.still(), "at start");
    viewer.keys(&["r", "x"]);
    viewer.keys(&["q"]);
    assert!(viewer.says(0).starts_with("recorded moves are not saved"));
    let asked = viewer.rests("the question");
    viewer.keys(&["n"]);
    viewer.changes_from(&asked, "no question");
    viewer.keys(&["q"]);
    viewer.says(1);
    viewer.keys(&["y"]);
    assert_eq!(viewer.ends().code(), Some(0));
    let kept = std::fs::read_to_string(desk.path("scene.txt")).expect("a scene");
    assert_eq!(kept, SCENE);
}

#[test]
fn a_click_tells_the_triangle_and_another_one_measures() {
    let Some(desk) = Desk::new() else { return };
    let viewer = desk.view(&["--print-picks"]);
    let still = desk.still();
    viewer.shows(&still, "at start");
    let click = |x: &str, y: &str| {
        viewer.hand(&["mousemove", "--window", "WINDOW", x, y]);
        viewer.hand(&["click", "1"]);
    };
    click("157", "88");
    let pick: Value = serde_json::from_str(&viewer.prints(0)).expect("JSON");
    assert_eq!(pick["pixel"], serde_json::json!([157, 88]));
    assert_eq!(pick["id"], 0, "{pick}");
    assert_eq!(pick["color"], serde_json::json!([255, 80, 0]));
    assert_eq!(pick["corners"][2], serde_json::json!([0.0, 0.0, 2.0]));
    viewer.changes_from(&still, "what was picked");
    viewer.hand(&["keydown", "ctrl"]);
    click("160", "175");
    viewer.hand(&["keyup", "ctrl"]);
    let to: Value = serde_json::from_str(&viewer.prints(1)).expect("JSON");
    let point = |v: &Value, i: usize| v["point"][i].as_f64().expect("a number");
    let way: f64 = (0..3)
        .map(|i| (point(&pick, i) - point(&to, i)).powi(2))
        .sum();
    let measured = to["measured"].as_f64().expect("a distance");
    assert!((measured - way.sqrt()).abs() < 1e-12, "{to}");
    viewer.keys(&["Escape"]);
    viewer.shows(&still, "Esc closes the panel");
}

#[test]
fn the_bar_takes_the_film_to_the_frame_under_the_mouse() {
    let Some(desk) = Desk::new() else { return };
    let viewer = desk.view(&[]);
    let still = desk.still();
    viewer.shows(&still, "at start");
    viewer.hand(&["mousemove", "--window", "WINDOW", "160", "225"]);
    viewer.changes_from(&still, "the bar");
    viewer.hand(&["mousedown", "1"]);
    viewer.hand(&["mousemove", "--window", "WINDOW", "14", "225"]);
    viewer.hand(&["mousemove", "--window", "WINDOW", "14", "100"]);
    let first = desk.render(&["--size", "320x240", "--frame", "0"]);
    assert!(
        viewer.rests("the bar held") != first,
        "it stays in the hand"
    );
    viewer.hand(&["mouseup", "1"]);
    viewer.hand(&["mousemove", "--window", "WINDOW", "14", "90"]);
    viewer.shows(&first, "frame 0");
    viewer.keys(&["period", "Right", "period"]);
    let frame = desk.render(&["--size", "320x240", "--frame", "17"]);
    viewer.shows(&frame, "an operation and a frame");
}

#[test]
fn what_the_window_saves_it_does_not_load_again_and_what_others_make_of_it_has_the_moves_once() {
    let Some(desk) = Desk::new() else { return };
    let viewer = desk.view(&["--no-overlay"]);
    let still = desk.still();
    viewer.shows(&still, "at start");
    viewer.keys(&["r", "x"]);
    viewer.keys(&["ctrl+s"]);
    assert_eq!(viewer.says(0), "saved scene.txt");
    let saved = desk.still();
    assert!(saved != still);
    // A load would end the undoing of moves, or apply them twice.
    std::thread::sleep(std::time::Duration::from_millis(300));
    viewer.shows(&saved, "after saving");
    viewer.keys(&["ctrl+z"]);
    viewer.shows(&still, "undone");
    viewer.keys(&["ctrl+shift+z"]);
    viewer.shows(&saved, "done again");
    let text = std::fs::read_to_string(desk.path("scene.txt")).expect("a scene");
    let edited = text.replace("255 80 0", "0 250 255");
    std::fs::write(desk.path("scene.txt"), edited).expect("written");
    let expected = desk.still();
    assert!(expected != saved);
    viewer.shows(&expected, "edited");
}

#[test]
fn another_scene_is_asked_about_and_opens_without_the_moves() {
    let Some(desk) = Desk::new() else { return };
    let other = SCENE.replace("255 80 0", "0 250 255");
    std::fs::write(desk.path("zebra.txt"), other).expect("written");
    let viewer = desk.view(&[]);
    viewer.shows(&desk.still(), "at start");
    viewer.keys(&["r", "x", "Next"]);
    assert!(viewer.says(0).starts_with("recorded moves are not saved"));
    viewer.keys(&["y"]);
    let expected = desk.render_file("zebra.txt", &["--size", "320x240"]);
    viewer.shows(&expected, "the other scene");
}
