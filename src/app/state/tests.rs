use super::*;
use crate::geometry::Aabb;

const SIZE: (usize, usize) = (64, 48);

fn setting() -> Setting {
    let op = |axis, angle_rad| Operation { axis, angle_rad };
    Setting {
        base: Camera::default_for(Aabb::EMPTY),
        operations: vec![op(Axis::X, 0.7), op(Axis::Y, -1.1)],
        timing: Timing::default(),
        pivot: DVec3::ZERO,
        stretch: false,
        overlay: true,
        kernels: vec![Kernel::Scalar, Kernel::Sse4],
    }
}

fn state() -> State {
    State::new(setting(), Settings::default(), SIZE)
}

fn ms(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

fn frame_wish(frame: u64) -> Wish {
    let s = setting();
    let camera = camera_at(s.base, &s.operations, s.timing, frame, s.pivot);
    Wish {
        view: camera.view(SIZE.0, SIZE.1, false),
        settings: Settings::default(),
    }
}

const X: Action = Action::StartTurn {
    axis: Axis::X,
    reverse: false,
};

/// The angle about x between the still picture's camera and the one shown.
fn turned_rad(state: &State) -> f64 {
    let s = setting();
    let still = camera_at(s.base, &s.operations, s.timing, 32, s.pivot).eye;
    let now = state.camera().eye;
    let angle = |p: DVec3| libm::atan2(p.z, p.y);
    (angle(now) - angle(still)).rem_euclid(std::f64::consts::TAU)
}

fn close(a: f64, b: f64) {
    assert!((a - b).abs() < 1e-12, "{a} is not {b}");
}

#[test]
fn opens_on_the_still_picture_to_the_bit() {
    assert_eq!(state().wish(), frame_wish(32));
    assert_eq!(state().next_change(), None);
    assert_eq!(state().overlay(), OverlayWish::default());
}

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
fn a_tap_turns_by_five_degrees_however_often_time_is_looked_at() {
    let mut s = state();
    s.apply(X);
    for t in 0..120 {
        s.advance(ms(t));
    }
    s.apply(Action::StopTurn(Axis::X));
    s.advance(ms(5000));
    close(turned_rad(&s), TAP_RAD);
}

#[test]
fn a_held_key_turns_by_the_clock() {
    let (mut once, mut often) = (state(), state());
    once.apply(X);
    often.apply(X);
    for t in 0..=1250 {
        often.advance(ms(t));
    }
    once.advance(ms(1250));
    close(turned_rad(&once), TAP_RAD + HELD_RAD_PER_S);
    close(turned_rad(&often), TAP_RAD + HELD_RAD_PER_S);
    assert!(once.is_turning());
}

#[test]
fn lost_focus_stops_the_turn_and_the_wakes() {
    let mut s = state();
    s.apply(X);
    s.advance(ms(400));
    s.apply(Action::StopTurns);
    let wish = s.wish();
    s.advance(ms(9000));
    assert_eq!(s.wish(), wish);
    assert_eq!((s.is_turning(), s.next_change()), (false, None));
}

#[test]
fn every_camera_action_changes_the_picture_and_enter_restores_its_bits() {
    let (dx_px, dy_px) = (7.0, -3.0);
    for action in [
        X,
        Action::Orbit { dx_px, dy_px },
        Action::Pan { dx_px, dy_px },
        Action::DollyDrag { dy_px },
        Action::Dolly { notches: 1.0 },
    ] {
        let mut s = state();
        s.apply(action);
        assert_ne!(s.wish(), frame_wish(32), "{action:?}");
        s.apply(Action::ReturnToScene);
        assert_eq!(s.wish(), frame_wish(32), "{action:?}");
    }
}

#[test]
fn enter_while_playing_stops_on_the_still_picture() {
    let mut s = state();
    s.apply(Action::TogglePlayback);
    s.advance(ms(500));
    s.apply(Action::ReturnToScene);
    s.advance(ms(900));
    assert_eq!(s.wish(), frame_wish(32));
}

#[test]
fn views_and_kernels_go_round() {
    let mut s = state();
    for _ in MODES {
        s.apply(Action::NextView);
    }
    assert_eq!(s.wish(), frame_wish(32));
    s.apply(Action::NextKernel);
    assert_eq!(s.wish().settings.kernel, Kernel::Scalar);
    s.apply(Action::NextKernel);
    assert_eq!(s.wish().settings.kernel, Kernel::Sse4);
}

#[test]
fn esc_closes_the_sheet_then_leaves_fullscreen_then_quits() {
    let mut s = state();
    s.apply(Action::ToggleSheet);
    s.apply(Action::ToggleFullscreen);
    assert_eq!(s.take_commands(), [Command::Fullscreen(true)]);
    s.apply(Action::Back);
    assert!(!s.overlay().sheet);
    s.apply(Action::Back);
    assert_eq!(s.take_commands(), [Command::Fullscreen(false)]);
    s.apply(Action::Back);
    assert_eq!(s.take_commands(), [Command::Quit]);
}

#[test]
fn messages_go_away_by_themselves() {
    let mut s = state();
    s.advance(ms(1000));
    s.say("saved".into());
    assert_eq!(s.overlay().message.as_deref(), Some("saved"));
    assert_eq!(s.next_change(), Some(ms(4000)));
    s.advance(ms(4000));
    assert_eq!(s.overlay(), OverlayWish::default());
}

#[test]
fn without_overlay_nothing_is_drawn_and_esc_quits() {
    let mut s = State::new(
        Setting {
            overlay: false,
            ..setting()
        },
        Settings::default(),
        SIZE,
    );
    s.apply(Action::ToggleSheet);
    s.apply(Action::ToggleStatistics);
    s.say("saved".into());
    assert_eq!(s.overlay(), OverlayWish::default());
    s.apply(Action::Back);
    assert_eq!(s.take_commands(), [Command::Quit]);
}

#[test]
fn sizes_without_pixels_and_clocks_that_jump_back_are_ignored() {
    let mut s = state();
    s.resize(0, 10);
    assert_eq!(s.size_px(), SIZE);
    s.resize(1, 1);
    assert_eq!(s.wish().view.width, 1);
    s.apply(X);
    s.advance(ms(1000));
    let wish = s.wish();
    s.advance(ms(10));
    assert_eq!(s.wish(), wish);
}
