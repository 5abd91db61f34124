use super::*;
use crate::math::Random;
use crate::timeline::rotation_after;

fn camera() -> Camera {
    Camera {
        eye: DVec3::new(0.0, 0.0, 5.0),
        top_left: DVec3::new(-2.0, 1.5, 1.0),
        top_right: DVec3::new(2.0, 1.5, 1.0),
        bottom_left: DVec3::new(-2.0, -1.5, 1.0),
    }
}

fn angles(moves: &Moves) -> Vec<(Axis, i64)> {
    let turns = moves.list.turns.iter();
    turns.map(|t| (t.axis, t.micro_rad)).collect()
}

#[test]
fn turns_about_one_axis_in_a_row_are_one_and_nothing_is_none() {
    let mut m = Moves::default();
    for (axis, micro) in [
        (Axis::X, 5.0),
        (Axis::X, 2.0),
        (Axis::Y, 3.0),
        (Axis::Y, -3.0),
        (Axis::X, 1.0),
    ] {
        m.turn(axis, micro);
        m.end();
    }
    assert_eq!(angles(&m), [(Axis::X, 8)]);
    m.turn(Axis::X, -8.0);
    m.end();
    assert_eq!(angles(&m), []);
}

#[test]
fn undo_and_redo_go_through_every_step_and_back() {
    let mut m = Moves::default();
    let mut random = Random::new(3);
    let mut lists = vec![m.list.clone()];
    for i in 0..200 {
        m.set_recording(i % 7 > 2);
        match random.below(3) {
            0 => m.turn(Axis::X, f64::from(random.below(9))),
            1 => m.turn_freely(DQuat::from_xyzw(0.1, 0.2, 0.3, 1.0).normalize()),
            _ => {
                let up = DVec3::Y * f64::from(random.unit());
                assert!(m.bake(camera(), DMat3::IDENTITY, DVec3::ZERO, |p| p + up));
            }
        }
        m.end();
        if lists.last() != Some(&m.list) {
            lists.push(m.list.clone());
        }
    }
    for list in lists.iter().rev().skip(1) {
        assert!(m.undo());
        assert_eq!(m.list, *list);
    }
    assert!(!m.undo());
    for list in &lists[1..] {
        assert!(m.redo());
        assert_eq!(m.list, *list);
    }
    assert!(!m.redo());
}

#[test]
fn a_free_turn_becomes_at_most_three_turns_to_the_millionth() {
    let mut random = Random::new(9);
    for _ in 0..200 {
        let p = random.point().as_dvec3();
        let q = DQuat::from_xyzw(p.x, p.y, p.z, 0.3).normalize();
        let mut m = Moves::default();
        m.turn_freely(q);
        let turned: Vec<Operation> = m.on_top().collect();
        assert!(turned.len() <= 3);
        let error = rotation_after(&turned) - DMat3::from_quat(q);
        assert!(error.to_cols_array().iter().all(|e| e.abs() < 2e-6));
    }
}

#[test]
fn a_quarter_about_y_hides_no_turn() {
    let m = rotation(Axis::Z, 0.4)
        * rotation(Axis::Y, std::f64::consts::FRAC_PI_2)
        * rotation(Axis::X, 0.3);
    let turns = turns_of(m).map(Turn::operation);
    let error = rotation_after(&turns) - m;
    assert!(error.to_cols_array().iter().all(|e| e.abs() < 2e-6));
}

#[test]
fn only_what_is_recorded_is_unsaved_until_it_is_saved_or_undone() {
    let mut m = Moves::default();
    m.turn(Axis::X, 5.0);
    m.end();
    assert!(!m.is_unsaved());
    m.record();
    assert!(m.is_unsaved());
    assert_eq!((m.recorded().len(), m.on_top().len()), (1, 0));
    m.mark_saved(m.to_write(true));
    assert!(!m.is_unsaved());
    assert!(m.undo());
    assert!(m.is_unsaved(), "the file has more");
    assert!(m.redo());
    assert!(!m.is_unsaved());
}

#[test]
fn a_turn_on_top_is_not_merged_into_the_film() {
    let mut m = Moves::default();
    m.set_recording(true);
    m.turn(Axis::X, 5.0);
    m.end();
    m.set_recording(false);
    m.turn(Axis::X, 5.0);
    m.end();
    assert_eq!((m.recorded().len(), m.on_top().len()), (1, 1));
}

#[test]
fn a_camera_that_no_file_could_hold_is_not_baked() {
    let mut m = Moves::default();
    let flat = |p: DVec3| DVec3::new(p.x, 0.0, p.z);
    assert!(!m.bake(camera(), DMat3::IDENTITY, DVec3::ZERO, flat));
    let far = |p: DVec3| p + DVec3::X * 1e300;
    assert!(!m.bake(camera(), DMat3::IDENTITY, DVec3::ZERO, far));
    assert_eq!(m.base(camera()), camera());
    assert!(!m.undo());
}

#[test]
fn baking_for_hours_keeps_the_cameras_shape() {
    let mut m = Moves::default();
    let pivot = DVec3::new(0.1, 0.2, 0.3);
    let turn = rotation(Axis::Z, 0.3) * rotation(Axis::X, 1.0);
    let step = rotation(Axis::Y, 0.013) * rotation(Axis::X, -0.021);
    for _ in 0..10_000 {
        let motion = |p| step * (p - pivot) + pivot;
        assert!(m.bake(camera(), turn, DVec3::ZERO, motion));
    }
    let (s, t) = m.base(camera()).plane_size();
    assert!((s - 4.0).abs() < 1e-6 && (t - 3.0).abs() < 1e-6);
    let eye = |c: Camera| (c.turned(turn, DVec3::ZERO).eye - pivot).length();
    assert!((eye(m.base(camera())) - eye(camera())).abs() < 1e-6);
}

#[test]
fn what_is_taken_back_leaves_no_step() {
    let mut m = Moves::default();
    m.turn(Axis::Z, 87_266.0);
    m.take_back();
    m.end();
    assert_eq!(angles(&m), []);
    assert!(!m.undo());
}
