//! Keys and the mouse on the camera.

use glam::Vec3;

use super::super::hand::{TAP_MICRO_RAD, TICK_MICRO_RAD};
use super::*;
use crate::app::action::Side;

/// A tap of an axis key.
const TAP_RAD: f64 = TAP_MICRO_RAD / 1e6;
/// A second of holding it.
const HELD_RAD: f64 = 250.0 * TICK_MICRO_RAD / 1e6;

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
fn keys_turn_about_the_pivot_that_the_hand_has_set() {
    let pivot = DVec3::new(0.3, -0.2, 0.1);
    let mut s = state();
    s.pivot = Some(pivot);
    let place = |s: &State| {
        let (x, y) = crate::app::orbit::place_of(&s.wish().view, pivot).expect("before the eye");
        DVec3::new(x, y, 0.0)
    };
    let (before, at) = (s.wish(), place(&s));
    s.apply(X);
    s.advance(ms(700));
    assert!((place(&s) - at).length() < 1e-3);
    // Held while dragging it was no turn.
    let (dx_px, dy_px, only) = (9.0, 2.0, Some(Axis::X));
    let mut without = state();
    without.pivot = s.pivot;
    for s in [&mut s, &mut without] {
        s.apply(Action::Orbit { dx_px, dy_px, only });
        s.apply(Action::StopTurns);
    }
    assert_eq!(s.wish(), without.wish());
    assert!((place(&s) - at).length() < 1e-3 && s.wish() != before);
    s.apply(Action::Undo);
    assert_eq!(s.wish(), before);
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
    let mut s = state();
    let mut eye = |from, opposite| {
        s.apply(Action::Look { from, opposite });
        assert_eq!(s.wish().view, rendered(&s));
        s.camera().eye.normalize()
    };
    // Up is y, as `t` says of this camera.
    for (side, direction) in [
        (Side::Front, DVec3::Z),
        (Side::Right, DVec3::X),
        (Side::Top, DVec3::Y),
        (Side::Corner, DVec3::ONE.normalize()),
    ] {
        assert!((eye(side, false) - direction).length() < 3e-6);
        assert!((eye(side, true) + direction).length() < 3e-6);
    }
}

#[test]
fn a_scene_beside_the_pivot_is_seen_from_every_side_and_fits_into_the_window() {
    let bounds = Aabb {
        min: Vec3::new(8.0, -1.0, 20.0),
        max: Vec3::new(9.0, 3.0, 22.0),
    };
    let mut s = State::new(
        Setting {
            base: Camera::default_for(bounds),
            bounds,
            ..setting()
        },
        Settings::default(),
        SIZE,
    );
    let is_in_middle = |s: &State| {
        let (x, y) = crate::app::orbit::place_of(&s.wish().view, DVec3::new(8.5, 1.0, 21.0))?;
        let (width, height) = (SIZE.0 as f64, SIZE.1 as f64);
        Some((x - width * 0.5).abs() < 1e-2 && (y - height * 0.5).abs() < 1e-2)
    };
    s.apply(Action::Fit);
    assert_eq!(is_in_middle(&s), Some(true), "turned away by operations");
    let said = s.overlay().message.expect("a message");
    assert!(
        said.starts_with("the scene lies beside the pivot"),
        "{said}"
    );
    for from in [Side::Front, Side::Right, Side::Top, Side::Corner] {
        let opposite = false;
        s.apply(Action::Look { from, opposite });
        assert_eq!(is_in_middle(&s), Some(true), "{from:?}");
    }
    let mut s = state();
    s.apply(Action::Fit);
    assert_eq!(s.wish(), frame_wish(32), "nothing is there");
    assert!(s.overlay().message.is_some());
}
