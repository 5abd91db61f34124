//! Playing, and the bar of frames.

use super::*;

#[test]
fn a_paused_picture_is_the_frame_that_is_reported() {
    let mut s = state();
    s.apply(Action::TogglePlayback);
    assert_eq!(s.wish(), frame_wish(0));
    s.advance(ms(1010));
    s.apply(Action::TogglePlayback);
    assert_eq!(
        s.take_commands(),
        [Command::Report("paused at frame 16".into())]
    );
    s.advance(ms(60_000));
    assert_eq!(s.wish(), frame_wish(16));
    assert_eq!(s.take_commands(), []);
}

#[test]
fn playback_ends_on_the_still_picture_and_says_so_once() {
    let mut s = state();
    s.apply(Action::TogglePlayback);
    s.advance(ms(60_000));
    s.advance(ms(60_001));
    assert_eq!(s.wish(), frame_wish(32));
    assert_eq!(
        s.take_commands(),
        [Command::Report("playback ended at frame 32".into())]
    );
    assert_eq!(s.next_change(), None);
}

#[test]
fn while_playing_the_next_change_is_the_next_frame() {
    let mut s = state();
    s.play();
    let mut wakes = 0;
    while let Some(at) = s.next_change() {
        let before = s.frame().0;
        // Rounding to nanoseconds may wake a hair early; then the next wake is due at once.
        s.advance(at.max(s.now + Duration::from_nanos(1)));
        wakes += 1;
        assert!(s.frame().0 <= before + 1, "a frame was skipped");
    }
    assert!((32..100).contains(&wakes), "{wakes} wakes for 32 frames");
}

#[test]
fn enter_stops_no_film_and_leaves_no_frame() {
    let mut s = state();
    s.apply(Action::TogglePlayback);
    s.advance(ms(500));
    s.apply(Action::ReturnToScene);
    s.advance(ms(1010));
    assert_eq!(s.wish(), frame_wish(16));
    s.apply(Action::TogglePlayback);
    s.apply(X);
    assert_ne!(s.wish(), frame_wish(16));
    for _ in 0..2 {
        s.apply(Action::ReturnToScene);
        assert_eq!(s.wish(), frame_wish(16));
    }
}

#[test]
fn enter_while_playing_drops_the_offset_and_keeps_the_time() {
    let mut s = state();
    s.apply(Action::TogglePlayback);
    s.advance(ms(500));
    s.apply(X);
    s.apply(Action::Pan {
        dx_px: 5.0,
        dy_px: 5.0,
    });
    s.advance(ms(1010));
    assert_ne!(s.wish(), frame_wish(16));
    s.apply(Action::ReturnToScene);
    assert_eq!(s.wish(), frame_wish(16));
    s.advance(ms(1510));
    assert_eq!(s.wish(), frame_wish(24));
}

#[test]
fn frames_and_operations_are_stepped_through() {
    let mut s = state();
    for (action, frame) in [
        (Action::StepFrames(-1), 31),
        (Action::StepOperation { back: true }, 16),
        (Action::StepOperation { back: true }, 0),
        (Action::StepOperation { back: true }, 0),
        (Action::StepFrames(1), 1),
        (Action::StepOperation { back: false }, 16),
        (Action::Seek(20), 20),
        (Action::StepOperation { back: true }, 16),
        (Action::GoToEnd, 32),
        (Action::StepFrames(1), 32),
        (Action::GoToStart, 0),
    ] {
        s.apply(action);
        assert_eq!(s.frame().0, frame, "{action:?}");
        assert_eq!(s.wish(), frame_wish(frame));
    }
}

#[test]
fn two_marks_make_a_loop_and_a_third_drops_it() {
    let mut s = state();
    for frame in [20, 12] {
        s.apply(Action::Seek(frame));
        s.apply(Action::MarkSection);
    }
    s.apply(Action::TogglePlayback);
    for t in 0..80 {
        s.advance(ms(50 * t));
        assert!((12..=20).contains(&s.frame().0));
    }
    s.apply(Action::MarkSection);
    s.advance(ms(60_000));
    assert_eq!((s.playback.is_playing(), s.frame().0), (false, 32));
}

#[test]
fn the_first_mark_is_seen_on_the_bar_and_stays_in_a_film_that_becomes_shorter() {
    let mut s = state();
    s.apply(Action::Seek(30));
    s.apply(Action::MarkSection);
    s.apply(Action::Seek(2));
    s.pointed_at((5.0, 45.0), false);
    let bar = |s: &State| s.overlay().bar.expect("near the border");
    assert_eq!(bar(&s).section, Some((2, 30)));
    let one = setting();
    s.reload(Subject {
        camera: one.camera,
        base: one.base,
        operations: one.operations[..1].to_vec(),
        pivot: one.pivot,
        bounds: one.bounds,
    });
    s.apply(Action::MarkSection);
    let said = s.overlay().message;
    assert_eq!(said.as_deref(), Some("loop from frame 2 to 16"));
    assert_eq!(bar(&s).section, Some((2, 16)));
}

#[test]
fn the_bar_shows_while_the_mouse_moves_near_it() {
    let mut s = state();
    s.pointed_at((5.0, 5.0), false);
    assert_eq!(s.overlay().bar, None);
    s.pointed_at((5.0, 45.0), false);
    let bar = s.overlay().bar.expect("near the border");
    assert_eq!((bar.frame, bar.frames_per_op), (32, 16));
    s.advance(ms(1999));
    assert!(s.overlay().bar.is_some());
    assert_eq!(s.next_change(), Some(ms(2000)));
    s.advance(ms(2000));
    assert_eq!(s.overlay().bar, None);
    s.pointed_at((5.0, 5.0), true);
    s.advance(ms(60_000));
    assert!(
        s.overlay().bar.is_some(),
        "held, the hand may stray and rest"
    );
    s.pointed_at((5.0, 5.0), false);
    assert_eq!(s.overlay().bar, None);
}

#[test]
fn a_film_that_plays_stands_while_a_hand_holds_the_bar() {
    let mut s = state();
    s.play();
    s.advance(ms(500));
    s.pointed_at((5.0, 45.0), true);
    s.apply(Action::Seek(10));
    let wakes = s.next_change().expect("it plays");
    assert!(wakes > s.now);
    s.advance(ms(5000));
    assert_eq!(s.frame().0, 10);
    s.pointed_at((5.0, 45.0), false);
    s.advance(ms(6010));
    assert_eq!(s.frame().0, 26);
}
