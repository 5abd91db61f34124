//! The state as a whole; its parts have tests of their own.

mod film;
mod hand;
mod picks;
mod recording;

use super::*;
use crate::timeline::camera_at;

const SIZE: (usize, usize) = (64, 48);

fn setting() -> Setting {
    let op = |axis, angle_rad| Operation { axis, angle_rad };
    Setting {
        camera: CameraSetting::Default,
        base: Camera::default_for(Aabb::EMPTY),
        operations: vec![op(Axis::X, 0.7), op(Axis::Y, -1.1)],
        timing: Timing::default(),
        pivot: DVec3::ZERO,
        bounds: Aabb::EMPTY,
        stretch: false,
        overlay: true,
        print_picks: false,
        kernels: vec![Kernel::Scalar, Kernel::Sse4],
    }
}

pub(super) fn state() -> State {
    State::new(setting(), Settings::default(), SIZE)
}

fn ms(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

pub(super) fn frame_wish(frame: u64) -> Wish {
    let s = setting();
    let camera = camera_at(s.base, &s.operations, s.timing, frame, s.pivot);
    Wish {
        view: camera.view(SIZE.0, SIZE.1, false),
        settings: Settings::default(),
        split: None,
    }
}

/// What `raybomb render` shows of the scene that [`State::scene_text`] gives.
fn rendered(state: &State) -> View {
    let (camera, operations) = state.scene_text();
    let text = format!("{camera}0 0 -1\n0\n{operations}");
    let scene = crate::scene::parse(text.as_bytes()).expect("a scene");
    let timing = Timing::default();
    let base = Camera::of_scene(&scene, Aabb::EMPTY);
    let last = timing.last_frame(&scene.operations);
    let camera = camera_at(base, &scene.operations, timing, last, setting().pivot);
    camera.view(SIZE.0, SIZE.1, false)
}

const X: Action = Action::StartTurn {
    axis: Axis::X,
    reverse: false,
};

#[test]
fn opens_on_the_still_picture_to_the_bit() {
    assert_eq!(state().wish(), frame_wish(32));
    assert_eq!(state().next_change(), None);
    assert_eq!(state().overlay(), OverlayWish::default());
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
    // Nothing else tells: the picture is the same.
    assert_eq!(s.overlay().message.as_deref(), Some("kernel: scalar"));
    s.apply(Action::NextKernel);
    assert_eq!(s.wish().settings.kernel, Kernel::Sse4);
}

#[test]
fn esc_closes_the_sheet_and_the_split_then_leaves_fullscreen_then_quits() {
    let mut s = state();
    s.apply(Action::ToggleSheet);
    s.apply(Action::ToggleSplit);
    s.apply(Action::ToggleFullscreen);
    assert_eq!(s.take_commands(), [Command::Fullscreen(true)]);
    s.apply(Action::Back);
    assert!(!s.overlay().sheet && s.wish().split.is_some());
    s.apply(Action::Back);
    assert_eq!(s.wish().split, None);
    s.apply(Action::Back);
    assert_eq!(s.take_commands(), [Command::Fullscreen(false)]);
    s.apply(Action::Back);
    assert_eq!(s.take_commands(), [Command::Quit]);
}

#[test]
fn a_click_takes_the_sheet_away_and_picks_nothing_below_it() {
    let mut s = state();
    for action in [Action::Pick((3.0, 3.0)), Action::Measure((3.0, 3.0))] {
        s.apply(Action::ToggleSheet);
        s.apply(action);
        assert!(!s.overlay().sheet);
        assert_eq!(s.take_commands(), []);
    }
    s.apply(Action::Pick((3.0, 3.0)));
    assert_ne!(s.take_commands(), []);
}

#[test]
fn letters_grow_and_shrink_within_limits_and_say_so() {
    let mut s = state();
    let mut size = |steps: i32, times: usize| {
        for _ in 0..times {
            s.apply(Action::Zoom(steps));
        }
        s.overlay().message.expect("a message")
    };
    assert_eq!(size(1, 1), "letters: 125 %");
    assert_eq!(size(-1, 1), "letters: 100 %");
    assert_eq!(size(-1, 9), "letters: 51 %, the smallest");
    assert_eq!(size(1, 3), "letters: 100 %");
    assert_eq!(size(1, 30), "letters: 596 %, the largest");
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
