//! What befalls windows: sizes, servers, clocks.

use std::time::Duration;

use crate::support::Desk;

/// A screen on which the largest window has room.
const HUGE: &[&str] = &["-screen", "0", "4096x2160x24"];

#[test]
fn sizes_from_one_pixel_to_4096_by_2160_are_shown_to_the_bit() {
    let Some(desk) = Desk::with(HUGE) else { return };
    let viewer = desk.view(&[]);
    viewer.shows(&desk.still(), "at start");
    for (width, height) in [(1, 1), (4096, 2160), (1, 1), (320, 240)] {
        viewer.resize(width, height);
        let size = format!("{width}x{height}");
        viewer.shows(&desk.render(&["--size", &size]), &size);
    }
}

#[test]
fn a_thousand_random_sizes_end_on_the_last_one() {
    let Some(desk) = Desk::new() else { return };
    let viewer = desk.view(&["--play"]);
    let mut random: u32 = 7;
    let mut side = |most: u32| {
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (1 + (random >> 8) % most).to_string()
    };
    for _ in 0..10 {
        let sizes: Vec<[String; 2]> = (0..100).map(|_| [side(1500), side(1100)]).collect();
        let command =
            |[w, h]: &'_ [String; 2]| ["windowsize".into(), "WINDOW".into(), w.clone(), h.clone()];
        let commands: Vec<String> = sizes.iter().flat_map(command).collect();
        let words: Vec<&str> = commands.iter().map(String::as_str).collect();
        viewer.hand(&words);
    }
    viewer.resize(320, 240);
    viewer.keys(&["Return"]);
    viewer.shows(&desk.still(), "after all of them");
}

#[test]
fn without_shared_memory_a_small_window_shows_its_picture_and_a_huge_one_a_smaller_picture() {
    let arguments = [HUGE, &["-extension", "MIT-SHM"]].concat();
    let Some(desk) = Desk::with(&arguments) else {
        return;
    };
    let viewer = desk.view(&[]);
    viewer.shows(&desk.still(), "at start");
    viewer.resize(4096, 2160);
    let line = viewer.says(0);
    let size = line
        .strip_prefix("the X server shares no memory with us: the picture is ")
        .and_then(|rest| rest.strip_suffix(" at most"))
        .unwrap_or_else(|| panic!("{line}"));
    let expected = desk.render(&["--size", size]);
    assert!(expected.width < 4096 && expected.width > 2000, "{size}");
    viewer.shows_in_corner(&expected, size);
    viewer.resize(4000, 2160);
    viewer.resize(320, 240);
    viewer.shows(&desk.still(), "small again");
    assert_eq!(viewer.words().len(), 1, "{:?}", viewer.words());
}

#[test]
fn a_server_that_is_killed_ends_the_program_with_1_and_a_word() {
    let Some(desk) = Desk::new() else { return };
    let mut viewer = desk.view(&["--play"]);
    viewer.changes_from(&desk.still(), "playing");
    desk.kill_server();
    let status = viewer.ends();
    let text = viewer.words().join("\n");
    assert_eq!(status.code(), Some(1), "{text}");
    assert!(!text.contains("panicked"), "{text}");
    // Ours, or that of the X library, which may be the first to see it and ends the program itself.
    let clear = [
        "XIO:",
        "the window takes no picture",
        "the window system failed",
        "X connection to",
    ];
    assert!(clear.iter().any(|words| text.contains(words)), "{text}");
}

#[test]
fn a_program_that_slept_for_a_while_goes_on_where_the_clock_is() {
    let Some(desk) = Desk::new() else { return };
    let still = desk.still();
    let viewer = desk.view(&["--play", "--fps", "30", "--seconds-per-op", "0.3"]);
    viewer.signal("STOP");
    std::thread::sleep(Duration::from_millis(1200));
    viewer.signal("CONT");
    assert_eq!(viewer.says(0), "playback ended at frame 27");
    viewer.shows(&still, "after the sleep");
    // A key that was let go meanwhile does not turn on.
    viewer.hand(&["keydown", "z"]);
    viewer.changes_from(&still, "a turning picture");
    viewer.signal("STOP");
    viewer.hand(&["keyup", "z"]);
    std::thread::sleep(Duration::from_millis(300));
    viewer.signal("CONT");
    viewer.rests("a key let go");
}
