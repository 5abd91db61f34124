//! What another scene, or the same one loaded again, does to the state.

use std::time::Duration;

use glam::DVec3;

use super::State;
use crate::app::moves::Moves;
use crate::camera::Camera;
use crate::geometry::Aabb;
use crate::scene::{CameraSetting, Operation};

/// What the state knows of a scene.
#[derive(Clone, Debug)]
pub struct Subject {
    /// The camera as the scene states it.
    pub camera: CameraSetting,
    /// The same, before any operation.
    pub base: Camera,
    /// The scene's.
    pub operations: Vec<Operation>,
    /// What they turn the camera about, and hands to begin with.
    pub pivot: DVec3,
    /// The box of all triangles.
    pub bounds: Aabb,
}

impl State {
    /// Another scene: it stands on its still picture, and no hand has touched it.
    pub fn open(&mut self, subject: Subject) {
        self.let_go_of_all();
        self.recording = false;
        self.pivot = None;
        self.section_start = None;
        self.asking = None;
        self.moves = Moves::default();
        self.playback.set_section(None);
        self.take(subject);
        self.playback.stop();
    }

    /// The scene changed under the hand: its moves, the frame and the playing stay.
    pub fn reload(&mut self, mut subject: Subject) {
        if !self.take_saved_out_of(&mut subject) {
            self.let_go_of_all();
            self.moves.leave_saved();
            self.say("the saved moves were changed in the file: they cannot be undone".to_owned());
        }
        self.take(subject);
    }

    /// The moves that the file has from us stay the hand's. False, and nothing done, when it has others by now.
    fn take_saved_out_of(&self, subject: &mut Subject) -> bool {
        let saved = self.moves.saved();
        let operations: Vec<Operation> = saved.operations().collect();
        let corners = saved.base_corners();
        let is_there = subject.operations.ends_with(&operations)
            && corners.is_none_or(|corners| subject.camera == CameraSetting::Set(corners));
        if is_there {
            let own = subject.operations.len() - operations.len();
            subject.operations.truncate(own);
            if corners.is_some() {
                (subject.camera, subject.base) = (self.setting.camera, self.setting.base);
            }
        }
        is_there
    }

    fn take(&mut self, subject: Subject) {
        let Subject {
            camera,
            base,
            operations,
            pivot,
            bounds,
        } = subject;
        self.setting.camera = camera;
        self.setting.base = base;
        self.setting.pivot = pivot;
        self.setting.bounds = bounds;
        self.film.clone_from(&operations);
        self.setting.operations = operations;
        self.scene += 1;
        self.drop_pick();
        self.after_move();
    }

    /// True where something may be drawn over the picture.
    #[must_use]
    pub fn may_overlay(&self) -> bool {
        self.setting.overlay
    }

    /// How long each frame is shown while the animation plays; `None` when it does not.
    #[must_use]
    pub fn frame_time(&self) -> Option<Duration> {
        let seconds = 1.0 / (self.setting.timing.fps * self.playback.speed());
        let playing = self.playback.is_playing();
        playing.then(|| Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::action::Action;
    use crate::app::state::{Command, Document, Setting};
    use crate::render::Settings;
    use crate::scene::{Axis, CameraCorners};
    use crate::timeline::Timing;

    fn subject(operations: usize) -> Subject {
        let (axis, angle_rad) = (Axis::Z, 0.5);
        Subject {
            camera: CameraSetting::Default,
            base: Camera::default_for(Aabb::EMPTY),
            operations: vec![Operation { axis, angle_rad }; operations],
            pivot: DVec3::ZERO,
            bounds: Aabb::EMPTY,
        }
    }

    fn state(operations: usize) -> State {
        let Subject {
            camera,
            base,
            operations,
            pivot,
            bounds,
        } = subject(operations);
        let setting = Setting {
            camera,
            base,
            operations,
            timing: Timing::STEPS,
            pivot,
            bounds,
            stretch: false,
            overlay: true,
            print_picks: false,
            kernels: Vec::new(),
        };
        State::new(setting, Settings::default(), (64, 48))
    }

    /// Records a drag.
    fn record(state: &mut State) {
        state.apply(Action::ToggleRecording);
        drag(state);
    }

    fn drag(state: &mut State) {
        let (dx_px, dy_px) = (5.0, 3.0);
        let only = Some(Axis::X);
        state.apply(Action::Orbit { dx_px, dy_px, only });
        state.apply(Action::LetGo);
    }

    fn saved(state: &mut State) -> Document {
        state.apply(Action::Save);
        let document = state.take_commands().into_iter().find_map(|c| match c {
            Command::Save(document) => Some(document),
            _ => None,
        });
        document.expect("a document")
    }

    #[test]
    fn another_scene_stands_on_its_still_picture_without_moves() {
        let mut s = state(2);
        record(&mut s);
        s.apply(Action::Pan {
            dx_px: 3.0,
            dy_px: 1.0,
        });
        s.play();
        s.open(subject(3));
        assert_eq!(s.wish(), state(3).wish());
        assert_eq!((s.frame(), s.is_moving()), ((3, 3), false));
        drag(&mut s);
        s.apply(Action::Undo);
        assert_eq!(s.wish(), state(3).wish());
        assert_eq!(saved(&mut s).operations, subject(3).operations, "recorded");
    }

    #[test]
    fn the_camera_of_another_scene_is_the_one_that_is_saved() {
        let corners = CameraCorners {
            eye: glam::Vec3::NEG_Y,
            top_left: glam::Vec3::NEG_X,
            top_right: glam::Vec3::X,
            bottom_left: glam::Vec3::NEG_Z,
        };
        let mut s = state(1);
        s.open(Subject {
            camera: CameraSetting::Set(corners),
            base: Camera::from(corners),
            ..subject(1)
        });
        assert_eq!(saved(&mut s).camera, CameraSetting::Set(corners));
    }

    #[test]
    fn moves_outlive_a_reload_until_the_file_has_them() {
        let mut s = state(2);
        record(&mut s);
        let wish = s.wish();
        s.reload(subject(2));
        assert_eq!((s.wish(), s.frame()), (wish, (3, 3)));
        let document = saved(&mut s);
        s.saved(Some(document.moves), Ok("a.txt".into()));
        // What another program makes of the file that was saved.
        s.reload(Subject {
            operations: document.operations,
            ..subject(2)
        });
        assert_eq!((s.wish(), s.frame()), (wish, (3, 3)));
        s.apply(Action::Quit);
        assert!(s.take_commands().contains(&Command::Quit), "nothing asked");
    }

    fn pan(state: &mut State) {
        let (dx_px, dy_px) = (3.0, 1.0);
        state.apply(Action::Pan { dx_px, dy_px });
        state.apply(Action::LetGo);
    }

    /// Saves, and returns what the file has then.
    fn saved_file(state: &mut State) -> Subject {
        let document = saved(state);
        state.saved(Some(document.moves), Ok("a.txt".into()));
        Subject {
            camera: document.camera,
            base: match document.camera {
                CameraSetting::Default => subject(0).base,
                CameraSetting::Set(corners) => Camera::from(corners),
            },
            operations: document.operations,
            ..subject(0)
        }
    }

    #[test]
    fn moves_made_after_a_save_outlive_a_reload_with_all_their_undo_steps() {
        let mut s = state(2);
        s.apply(Action::ToggleRecording);
        let mut wishes = vec![s.wish()];
        drag(&mut s);
        wishes.push(s.wish());
        pan(&mut s);
        wishes.push(s.wish());
        let file = saved_file(&mut s);
        // Merged into the turn that was saved.
        drag(&mut s);
        wishes.push(s.wish());
        s.reload(file);
        for wish in wishes.iter().rev() {
            assert_eq!(s.wish(), *wish);
            s.apply(Action::Undo);
        }
        for _ in &wishes {
            s.apply(Action::Redo);
        }
        s.apply(Action::Quit);
        assert!(s.is_asking(), "the last drag is in no file");
        s.apply(Action::Decline);
        let again = saved_file(&mut s);
        s.open(again);
        assert_eq!(s.wish(), wishes[3]);
    }

    #[test]
    fn what_is_saved_without_recording_is_the_end_of_the_film_and_one_step() {
        let mut s = state(2);
        let before = (s.wish(), s.frame());
        drag(&mut s);
        let moved = s.wish();
        assert_eq!(s.frame(), before.1, "it lies on top");
        let file = saved_file(&mut s);
        let mut other = state(2);
        other.open(file);
        assert_eq!((s.wish(), s.frame()), (moved, other.frame()));
        s.apply(Action::GoToStart);
        other.apply(Action::GoToStart);
        assert_eq!(s.wish(), other.wish(), "as the file has it");
        s.apply(Action::GoToEnd);
        other.apply(Action::GoToEnd);
        // Nothing is left to record, or to ask about.
        s.apply(Action::ToggleRecording);
        s.apply(Action::Quit);
        assert!(!s.is_asking());
        s.apply(Action::Undo);
        assert_eq!((s.wish(), s.frame()), before);
        s.apply(Action::Redo);
        assert_eq!((s.wish(), s.frame()), (moved, other.frame()));
    }

    #[test]
    fn what_was_saved_and_changed_in_the_file_stays_there_and_later_moves_follow() {
        let mut s = state(2);
        record(&mut s);
        let mut file = saved_file(&mut s);
        drag(&mut s);
        pan(&mut s);
        let wish = s.wish();
        file.operations.insert(2, file.operations[0]);
        file.operations.push(file.operations[0]);
        let mut other = state(2);
        other.open(file.clone());
        let left = other.wish();
        s.reload(file);
        assert_ne!(s.wish(), wish);
        assert_eq!(s.frame(), (6, 6), "the file's five, and a drag");
        s.apply(Action::Undo);
        assert_eq!((s.wish(), s.frame()), (left, (5, 5)));
        s.apply(Action::Undo);
        assert_eq!(s.wish(), left, "nothing is left to undo");
    }

    #[test]
    fn unsaved_moves_are_asked_about_before_another_scene_takes_their_place() {
        let browse = Command::Browse { forward: true };
        let mut s = state(1);
        s.apply(Action::Browse { forward: true });
        assert_eq!(s.take_commands(), std::slice::from_ref(&browse));
        record(&mut s);
        s.apply(Action::Browse { forward: true });
        assert!(!s.take_commands().contains(&browse));
        s.apply(Action::Decline);
        assert_eq!(s.overlay().question, None);
        s.leave(Command::Open("b.txt".into()));
        assert!(s.overlay().question.is_some());
        s.take_commands();
        s.apply(Action::Accept);
        assert_eq!(s.take_commands(), [Command::Open("b.txt".into())]);
        assert_eq!(s.overlay().question, None);
    }

    #[test]
    fn quitting_at_the_question_about_another_scene_asks_about_quitting() {
        let mut s = state(1);
        record(&mut s);
        s.apply(Action::Browse { forward: true });
        let before = s.take_commands();
        s.apply(Action::Quit);
        let after = s.take_commands();
        assert!(matches!(&after[..], [Command::Report(_)]), "{after:?}");
        assert!(!before.contains(&after[0]), "another question");
        s.apply(Action::Quit);
        assert_eq!(s.take_commands(), [Command::Quit]);
    }

    #[test]
    fn an_answer_about_the_scene_before_is_not_shown() {
        let mut s = state(1);
        s.apply(Action::SetPivot((30.0, 20.0)));
        let Some(Command::Probe(probe)) = s.take_commands().pop() else {
            panic!("no question");
        };
        s.reload(subject(1));
        s.probed(&probe, None);
        assert_eq!(s.overlay().message, None);
        let again = crate::app::state::Probe { scene: 1, ..probe };
        s.probed(&again, None);
        assert!(s.overlay().message.is_some());
    }
}
