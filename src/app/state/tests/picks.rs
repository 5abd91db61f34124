//! What is seen at a place.

use super::*;

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
fn a_double_click_leaves_nothing_of_the_pick_that_its_first_click_was() {
    let mut s = state();
    let found = Picked {
        id: 7,
        corners: [glam::Vec3::ZERO; 3],
        color: crate::color::Rgb::BLACK,
        point: DVec3::X,
        distance: 1.0,
        angle_rad: 0.0,
    };
    for action in [Action::Pick((5.0, 3.0)), Action::SetPivot((5.0, 3.0))] {
        s.apply(action);
        let Some(Command::Probe(probe)) = s.take_commands().pop() else {
            panic!("no question");
        };
        s.probed(&probe, Some(found));
    }
    assert_eq!(s.pivot, Some(DVec3::X));
    assert_eq!((s.overlay().picked, s.overlay().marks), (vec![], vec![]));
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
