//! Recorded moves: saved, undone, asked about.

use super::*;

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
    assert!(s.scene_text().0.starts_with("<s"));
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
fn recording_says_that_it_waits_where_moves_are_not_recorded() {
    let mut s = state();
    let words = |s: &State| s.overlay().recording;
    assert_eq!(words(&s), None);
    s.apply(Action::ToggleRecording);
    assert_eq!(words(&s).as_deref(), Some("recording"));
    for (away, back) in [
        (Action::GoToStart, Action::GoToEnd),
        (Action::TogglePlayback, Action::GoToEnd),
    ] {
        s.apply(away);
        assert_eq!(words(&s).as_deref(), Some("recording waits: End"));
        s.apply(back);
        assert_eq!(words(&s).as_deref(), Some("recording"));
    }
}

#[test]
fn saving_away_from_the_last_frame_saves_what_is_recorded_and_says_what_it_leaves_out() {
    let mut s = state();
    s.apply(Action::ToggleRecording);
    s.apply(X);
    s.apply(Action::StopTurns);
    s.apply(Action::ToggleRecording);
    let recorded = s.wish();
    s.apply(Action::GoToStart);
    let (dx_px, dy_px) = (7.0, 3.0);
    for on_top in [
        Action::Orbit {
            dx_px,
            dy_px,
            only: None,
        },
        Action::Pan { dx_px, dy_px },
    ] {
        s.apply(on_top);
        s.apply(Action::LetGo);
        let shown = s.wish();
        s.apply(Action::Save);
        let (document, scene) = saved(&mut s);
        assert_eq!(document.camera, CameraSetting::Default);
        let (timing, pivot) = (Timing::default(), setting().pivot);
        let last = timing.last_frame(&scene.operations);
        let camera = camera_at(setting().base, &scene.operations, timing, last, pivot);
        assert_eq!(camera.view(SIZE.0, SIZE.1, false), recorded.view);
        s.saved(Some(document.moves), Ok("a.txt".into()));
        let said = s.overlay().message.expect("a message");
        assert!(said.starts_with("saved a.txt without"), "{said}");
        assert_eq!(s.wish(), shown);
    }
    s.apply(Action::GoToEnd);
    s.apply(Action::Save);
    let (document, _) = saved(&mut s);
    s.saved(Some(document.moves), Ok("a.txt".into()));
    assert_eq!(s.overlay().message.as_deref(), Some("saved a.txt"));
}

#[test]
fn operations_about_another_pivot_than_the_formats_say_what_they_need() {
    let saved_as = |pivot, operations| {
        let setting = Setting {
            pivot,
            operations,
            ..setting()
        };
        let mut s = State::new(setting, Settings::default(), SIZE);
        s.saved(None, Ok("a.txt".into()));
        let said = s.overlay().message.expect("a message");
        s.apply(Action::PrintCamera);
        let printed = s.overlay().message.expect("a message");
        (said, printed.contains("--pivot centre"))
    };
    let operations = setting().operations;
    let needs = "saved a.txt; its operations need --pivot centre";
    assert_eq!(
        saved_as(DVec3::ONE, operations.clone()),
        (needs.into(), true)
    );
    for (pivot, operations) in [(DVec3::ONE, Vec::new()), (DVec3::ZERO, operations)] {
        assert_eq!(saved_as(pivot, operations), ("saved a.txt".into(), false));
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
    for yes in [Action::Quit, Action::Accept] {
        s.apply(Action::Quit);
        s.take_commands();
        s.apply(yes);
        assert_eq!(s.take_commands(), [Command::Quit]);
        s.apply(Action::Decline);
    }
    s.apply(Action::Save);
    let (document, _) = saved(&mut s);
    s.saved(Some(document.moves), Ok("a.txt".into()));
    s.take_commands();
    s.apply(Action::Quit);
    assert_eq!(s.take_commands(), [Command::Quit], "all is saved");
}
