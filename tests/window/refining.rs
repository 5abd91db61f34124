//! `--aa`, and what is shown while something moves.

use crate::support::Desk;

#[test]
fn a_standing_window_refines_to_the_bits_of_render() {
    let Some(desk) = Desk::new() else { return };
    for samples in ["2", "64"] {
        let expected = desk.render(&["--size", "320x240", "--aa", samples]);
        assert!(expected != desk.still());
        let viewer = desk.view(&["--aa", samples]);
        viewer.shows(&expected, samples);
        // Again after a move, of which the way back is exact.
        viewer.keys(&["y"]);
        viewer.changes_from(&expected, "a turn");
        viewer.keys(&["Return"]);
        viewer.shows(&expected, "after the turn");
        viewer.keys(&["s"]);
        assert_eq!(viewer.says(0)[..6], *"saved ");
    }
    let saved = std::fs::read(desk.path("raybomb-0002.png")).expect("a file");
    let expected = desk.render(&["--size", "320x240", "--aa", "64"]);
    assert!(crate::support::Picture::from_png(&saved) == expected);
}

#[test]
fn a_rate_out_of_reach_makes_moving_pictures_coarse_and_standing_ones_fine() {
    let Some(desk) = Desk::new() else { return };
    let still = desk.still();
    // No picture takes less than a microsecond.
    let viewer = desk.view(&["--target-fps", "1000000"]);
    viewer.shows(&still, "at start");
    viewer.hand(&["keydown", "z"]);
    crate::support::until("coarse pixels", || {
        viewer.grab().is_made_of_squares(12).then_some(())
    });
    // A file is of the fine picture all the same.
    viewer.keys(&["s"]);
    assert_eq!(viewer.says(0), "saved raybomb-0001.png");
    viewer.hand(&["keyup", "z"]);
    let rested = viewer.rests("a key let go");
    assert!(!rested.is_made_of_squares(2), "it stays coarse");
    viewer.keys(&["Return"]);
    viewer.shows(&still, "after Enter");
    let saved = std::fs::read(desk.path("raybomb-0001.png")).expect("a file");
    assert!(!crate::support::Picture::from_png(&saved).is_made_of_squares(2));
}

#[test]
fn a_scene_that_is_fast_enough_is_never_coarse() {
    let Some(desk) = Desk::new() else { return };
    // A second for each picture is enough on any machine.
    let viewer = desk.view(&["--target-fps", "1"]);
    viewer.shows(&desk.still(), "at start");
    viewer.hand(&["keydown", "z"]);
    for _ in 0..15 {
        assert!(!viewer.grab().is_made_of_squares(2));
    }
    viewer.hand(&["keyup", "z"]);
}
