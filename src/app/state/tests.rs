use super::hand::{TAP_MICRO_RAD, TICK_MICRO_RAD};
use super::*;
use crate::geometry::Aabb;
use crate::timeline::camera_at;

/// A tap of an axis key.
const TAP_RAD: f64 = TAP_MICRO_RAD / 1e6;
/// A second of holding it.
const HELD_RAD: f64 = 250.0 * TICK_MICRO_RAD / 1e6;

const SIZE: (usize, usize) = (64, 48);

fn setting() -> Setting {
    let op = |axis, angle_rad| Operation { axis, angle_rad };
    Setting {
        camera: CameraSetting::Default,
        base: Camera::default_for(Aabb::EMPTY),
        operations: vec![op(Axis::X, 0.7), op(Axis::Y, -1.1)],
        timing: Timing::default(),
        pivot: DVec3::ZERO,
        stretch: false,
        overlay: true,
        print_picks: false,
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
        split: None,
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
    close(turned_rad(&once), TAP_RAD + HELD_RAD);
    close(turned_rad(&often), TAP_RAD + HELD_RAD);
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
        Action::Orbit {
            dx_px,
            dy_px,
            only: None,
        },
        Action::Roll { dx_px },
        Action::Pan { dx_px, dy_px },
        Action::DollyDrag { dy_px, at: None },
        Action::Dolly {
            notches: 1.0,
            at: Some((3.0, 4.0)),
        },
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
    s.apply(Action::ReturnToScene);
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

/// The last document that the state wanted to have saved, as a scene.
fn saved(state: &mut State) -> (Document, crate::scene::Scene) {
    let document = state
        .take_commands()
        .into_iter()
        .rev()
        .find_map(|c| match c {
            Command::Save(document) => Some(document),
            _ => None,
        });
    let document = document.expect("it was saved");
    let text = b"<d 0 0 -1\n0\n<o 2 <x 0.7 <y -1.1\n";
    let text = crate::scene::with_moves(text, document.camera, &document.operations);
    let scene = crate::scene::parse(&text.expect("a scene")).expect("a scene");
    (document, scene)
}

/// A drag or a key turn about the format's pivot.
fn random_turn(state: &mut State, random: &mut crate::math::Random, now: &mut Duration) {
    const AXES: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];
    let axis = AXES[random.below(3) as usize];
    if random.below(2) == 0 {
        let reverse = random.below(2) == 0;
        state.apply(Action::StartTurn { axis, reverse });
        *now += ms(u64::from(random.below(600)));
        state.advance(*now);
        state.apply(Action::StopTurn(axis));
        return;
    }
    let kind = random.below(4);
    for _ in 0..1 + random.below(8) {
        let dx_px = f64::from(random.range(-30.0, 30.0));
        let dy_px = f64::from(random.range(-30.0, 30.0));
        state.apply(match kind {
            0 => Action::Roll { dx_px },
            1 => Action::Orbit {
                dx_px,
                dy_px,
                only: Some(axis),
            },
            _ => Action::Orbit {
                dx_px,
                dy_px,
                only: None,
            },
        });
        assert_eq!(
            state.wish().view,
            rendered(state),
            "in the middle of a drag"
        );
    }
    state.apply(Action::LetGo);
}

#[test]
fn a_hundred_recorded_turns_are_the_saved_files_picture_and_undo_goes_all_the_way_back() {
    let mut s = state();
    let mut random = crate::math::Random::new(4);
    let mut now = Duration::ZERO;
    s.apply(Action::ToggleRecording);
    let first = s.wish();
    let mut views = vec![first.view];
    for _ in 0..100 {
        random_turn(&mut s, &mut random, &mut now);
        assert_eq!(s.wish().view, rendered(&s));
        views.push(s.wish().view);
    }
    s.apply(Action::Save);
    let (document, scene) = saved(&mut s);
    assert_eq!(document.camera, CameraSetting::Default);
    let (timing, pivot) = (Timing::default(), setting().pivot);
    let last = timing.last_frame(&scene.operations);
    assert_eq!(s.frame(), (last, last));
    let camera = camera_at(setting().base, &scene.operations, timing, last, pivot);
    assert_eq!(camera.view(SIZE.0, SIZE.1, false), s.wish().view);
    for pair in scene.operations[2..].windows(2) {
        assert_ne!(pair[0].axis, pair[1].axis, "a run about one axis");
    }
    for view in views.iter().rev().skip(1) {
        s.apply(Action::Undo);
        assert_eq!(s.wish().view, *view);
    }
    assert_eq!(s.wish(), first);
    for view in &views[1..] {
        s.apply(Action::Redo);
        assert_eq!(s.wish().view, *view);
    }
}

#[test]
fn pans_dollies_and_turns_about_another_point_are_baked_to_the_bit() {
    let mut s = state();
    s.apply(Action::ToggleRecording);
    s.pivot = Some(DVec3::new(0.3, -0.2, 0.1));
    let mut random = crate::math::Random::new(8);
    for _ in 0..50 {
        let dx_px = f64::from(random.range(-9.0, 9.0));
        let dy_px = f64::from(random.range(-9.0, 9.0));
        let at = (random.below(2) == 0).then_some((20.0, 30.0));
        s.apply(match random.below(5) {
            0 => Action::Pan { dx_px, dy_px },
            1 => Action::Roll { dx_px },
            2 => Action::Dolly {
                notches: dy_px.signum(),
                at,
            },
            3 => X,
            _ => Action::Orbit {
                dx_px,
                dy_px,
                only: None,
            },
        });
        s.apply(Action::StopTurns);
        assert_eq!(s.wish().view, rendered(&s));
    }
    assert!(matches!(s.camera_setting(), CameraSetting::Set(_)));
    s.apply(Action::ReturnToScene);
    assert_eq!(s.wish(), frame_wish(32));
    s.apply(Action::Undo);
    assert_ne!(s.wish(), frame_wish(32));
}

#[test]
fn recorded_moves_are_played_and_others_lie_on_top_of_every_frame() {
    let mut s = state();
    s.apply(X);
    s.apply(Action::StopTurns);
    assert_eq!(s.frame(), (32, 32));
    s.apply(Action::GoToStart);
    assert_ne!(s.wish(), frame_wish(0));
    s.apply(Action::ToggleRecording);
    assert_eq!(s.frame(), (48, 48), "what the hand did is in the film");
    s.apply(Action::GoToStart);
    assert_eq!(s.wish(), frame_wish(0));
    s.apply(X);
    s.apply(Action::StopTurns);
    assert_eq!(s.frame(), (0, 48), "a move on another frame is an offset");
    assert_ne!(s.wish(), frame_wish(0));
    assert_eq!(s.wish().view, rendered(&s));
}

#[test]
fn a_drag_takes_back_the_turn_of_the_key_that_names_its_axis() {
    let drag = |dx_px, only| Action::Orbit {
        dx_px,
        dy_px: 0.0,
        only,
    };
    let (mut with_key, mut without) = (state(), state());
    with_key.apply(X);
    with_key.advance(ms(1500));
    for s in [&mut with_key, &mut without] {
        s.apply(drag(9.0, Some(Axis::X)));
        s.apply(drag(4.0, Some(Axis::X)));
    }
    with_key.apply(Action::StopTurn(Axis::X));
    with_key.advance(ms(3000));
    assert_eq!(with_key.wish(), without.wish());
    with_key.apply(Action::LetGo);
    with_key.apply(Action::Undo);
    assert_eq!(with_key.wish(), frame_wish(32));
}

#[test]
fn two_held_keys_turn_the_same_way_however_often_time_is_looked_at() {
    let (mut once, mut often) = (state(), state());
    for s in [&mut once, &mut often] {
        s.apply(X);
        s.advance(ms(70));
        s.apply(Action::StartTurn {
            axis: Axis::Z,
            reverse: true,
        });
    }
    for t in 70..=900 {
        often.advance(ms(t));
    }
    once.advance(ms(900));
    assert_eq!(once.wish(), often.wish());
}

#[test]
fn sides_are_looked_at_from_and_the_opposite_is_behind() {
    use crate::app::action::Side;
    let mut s = state();
    let mut eye = |from, opposite| {
        s.apply(Action::Look { from, opposite });
        assert_eq!(s.wish().view, rendered(&s));
        s.camera().eye.normalize()
    };
    for (side, direction) in [
        (Side::Front, DVec3::NEG_Y),
        (Side::Right, DVec3::X),
        (Side::Top, DVec3::Z),
        (Side::Corner, DVec3::new(1.0, -1.0, 1.0).normalize()),
    ] {
        assert!((eye(side, false) - direction).length() < 3e-6);
        assert!((eye(side, true) + direction).length() < 3e-6);
    }
}

#[test]
fn quitting_asks_only_for_recorded_moves_that_no_file_has() {
    let mut s = state();
    s.apply(X);
    s.apply(Action::StopTurns);
    s.apply(Action::Quit);
    assert_eq!(s.take_commands(), [Command::Quit], "nothing is recorded");
    s.apply(Action::ToggleRecording);
    for no in [Action::Decline, Action::Back] {
        s.apply(Action::Quit);
        assert!(s.overlay().question.is_some());
        assert!(!s.take_commands().contains(&Command::Quit));
        let before = s.wish();
        s.apply(Action::NextView);
        assert_eq!(s.wish(), before, "it waits for an answer");
        s.apply(no);
        assert_eq!(s.overlay().question, None);
    }
    let y = Action::StartTurn {
        axis: Axis::Y,
        reverse: false,
    };
    for yes in [Action::Quit, y] {
        s.apply(Action::Quit);
        s.take_commands();
        s.apply(yes);
        assert_eq!(s.take_commands(), [Command::Quit]);
        s.apply(Action::Decline);
    }
    s.apply(Action::Save);
    let (document, _) = saved(&mut s);
    s.saved(Some(document.recorded), Ok("a.txt".into()));
    s.take_commands();
    s.apply(Action::Quit);
    assert_eq!(s.take_commands(), [Command::Quit], "all is saved");
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
    assert!(s.playback.is_playing(), "the order is still loop");
}

#[test]
fn a_pick_is_shown_and_printed_and_a_second_one_measures() {
    let print_picks = true;
    let mut s = State::new(
        Setting {
            print_picks,
            ..setting()
        },
        Settings::default(),
        SIZE,
    );
    let ask = |s: &mut State, action, x: f64| {
        s.apply(action);
        let probe = match s.take_commands()[..] {
            [Command::Probe(probe)] => probe,
            ref other => panic!("{other:?}"),
        };
        s.probed(
            &probe,
            Some(Picked {
                id: 7,
                corners: [glam::Vec3::ZERO, glam::Vec3::X, glam::Vec3::Y],
                color: crate::color::Rgb::new(1, 2, 3),
                point: DVec3::new(x, 0.0, 0.0),
                distance: 2.0,
                angle_rad: 0.0,
            }),
        );
        match s.take_commands().pop() {
            Some(Command::Print(line)) => line,
            other => panic!("{other:?}"),
        }
    };
    let line = ask(&mut s, Action::Pick((5.7, 3.2)), 0.25);
    assert_eq!(
        serde_json::from_str::<serde_json::Value>(&line).expect("JSON"),
        serde_json::json!({
            "pixel": [5, 3], "id": 7, "corners": [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            "color": [1, 2, 3], "point": [0.25, 0.0, 0.0], "distance": 2.0, "angle_deg": 0.0,
        })
    );
    assert!(
        s.overlay()
            .picked
            .contains(&("triangle".into(), "7".into()))
    );
    let line = ask(&mut s, Action::Measure((1.0, 1.0)), 1.0);
    assert!(line.contains("\"measured\":0.75"), "{line}");
    s.apply(Action::Pick((-1.0, 5.0)));
    s.apply(Action::Pick((64.0, 5.0)));
    assert_eq!(s.take_commands(), [], "outside of the picture");
    s.apply(Action::Back);
    assert_eq!(s.overlay().picked, []);
    assert_eq!(s.overlay().marks, []);
}

#[test]
fn a_mark_stays_on_the_point_that_was_picked() {
    let mut s = state();
    s.picked = Some(Picked {
        id: 0,
        corners: [glam::Vec3::ZERO; 3],
        color: crate::color::Rgb::BLACK,
        point: s.view().eye.as_dvec3() + s.view().direction(10, 20),
        distance: 1.0,
        angle_rad: 0.0,
    });
    assert_eq!(s.overlay().marks, [(10, 20)]);
    s.apply(Action::Pan {
        dx_px: 10.0,
        dy_px: -4.0,
    });
    let [(x, y)] = s.overlay().marks[..] else {
        panic!("one mark")
    };
    assert!(x > 10 && y < 20, "it goes with the picture: {x} {y}");
}

#[test]
fn the_bar_shows_while_the_mouse_moves_near_it() {
    let mut s = state();
    s.pointed_at((5.0, 5.0));
    assert_eq!(s.overlay().bar, None);
    s.pointed_at((5.0, 45.0));
    let bar = s.overlay().bar.expect("near the border");
    assert_eq!((bar.frame, bar.frames_per_op), (32, 16));
    s.advance(ms(1999));
    assert!(s.overlay().bar.is_some());
    assert_eq!(s.next_change(), Some(ms(2000)));
    s.advance(ms(2000));
    assert_eq!(s.overlay().bar, None);
}
