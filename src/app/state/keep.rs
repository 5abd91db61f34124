//! What a journal keeps of the moves, and how they come back.

use super::{Command, State};
use crate::app::journal::Kept;
use crate::app::moves::Written;

impl State {
    /// Another number after each finished move.
    #[must_use]
    pub fn revision(&self) -> u64 {
        self.moves.revision()
    }

    /// The moves that no file has; `None` when there are none.
    #[must_use]
    pub fn kept(&self) -> Option<Kept> {
        let none = self.moves.is_untouched() && !self.moves.is_any_saved();
        if none || self.moves.is_as_saved() {
            return None;
        }
        Some(Kept {
            own_operations: self.setting.operations.len(),
            camera: self.setting.camera,
            base: self.setting.base,
            list: self.moves.list().clone(),
            frame: self.playback.frame(),
        })
    }

    /// Asks whether moves that were left over are wanted.
    pub fn offer(&mut self, kept: Kept) {
        self.ask(Command::TakeBack(Box::new(kept)));
    }

    /// Asks no longer whether they are wanted. False when nothing of the kind was asked.
    pub fn withdraw_offer(&mut self) -> bool {
        let is_offer = matches!(self.asking, Some(Command::TakeBack(_)));
        if is_offer {
            self.asking = None;
        }
        is_offer
    }

    /// Goes on where moves were left over: one step, which can be undone.
    pub fn take_back(&mut self, kept: Kept) {
        self.let_go_of_all();
        let setting = &mut self.setting;
        // What the file has of them is theirs to tell.
        let own = kept.own_operations.min(setting.operations.len());
        let saved = setting.operations.split_off(own);
        let base = (kept.camera != setting.camera).then_some(setting.base);
        self.moves.mark_saved(Written::of_file(&saved, base));
        setting.camera = kept.camera;
        setting.base = kept.base;
        self.recording = false;
        self.moves.take_over(kept.list);
        self.after_move();
        self.playback.seek(kept.frame);
        self.say("the moves are back".to_owned());
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{frame_wish, state};
    use super::*;
    use crate::app::action::Action;

    fn drag(state: &mut State) {
        let (dx_px, dy_px, only) = (7.0, 3.0, None);
        state.apply(Action::Orbit { dx_px, dy_px, only });
        state.apply(Action::LetGo);
    }

    fn pan(state: &mut State) {
        let (dx_px, dy_px) = (2.0, -9.0);
        state.apply(Action::Pan { dx_px, dy_px });
        state.apply(Action::LetGo);
    }

    /// Another program takes back what `state` keeps.
    fn again(state: &State, mut other: State) -> State {
        let kept = state.kept().expect("something to keep");
        other.offer(kept);
        other.apply(Action::Accept);
        let take_back = other.take_commands().pop();
        let Some(Command::TakeBack(kept)) = take_back else {
            panic!("{take_back:?}");
        };
        other.take_back(*kept);
        other
    }

    #[test]
    fn moves_come_back_to_the_bit_and_can_be_undone() {
        let mut s = state();
        assert_eq!(s.kept(), None);
        s.apply(Action::ToggleRecording);
        drag(&mut s);
        pan(&mut s);
        s.apply(Action::ToggleRecording);
        drag(&mut s);
        for frame in [s.frame().1, 5] {
            s.apply(Action::Seek(frame));
            let mut back = again(&s, state());
            assert_eq!((back.wish(), back.frame()), (s.wish(), s.frame()));
            assert_eq!(back.kept(), s.kept());
            back.apply(Action::Undo);
            back.apply(Action::GoToEnd);
            assert_eq!(back.wish(), frame_wish(32));
            assert_eq!(back.kept(), None, "as it was opened");
        }
    }

    #[test]
    fn each_finished_move_is_another_revision_and_a_save_leaves_nothing_to_keep() {
        let mut s = state();
        let before = s.revision();
        s.apply(Action::ToggleRecording);
        let (dx_px, dy_px, only) = (7.0, 3.0, None);
        s.apply(Action::Orbit { dx_px, dy_px, only });
        assert_eq!(s.revision(), before, "in the middle of a drag");
        s.apply(Action::LetGo);
        assert_ne!(s.revision(), before);
        s.apply(Action::Save);
        let saved = s.take_commands().into_iter().find_map(|c| match c {
            Command::Save(document) => Some(document),
            _ => None,
        });
        let saved = saved.expect("a document");
        s.saved(Some(saved.moves.clone()), Ok("a.txt".into()));
        assert_eq!(s.kept(), None);
        drag(&mut s);
        // The saved file, opened by another program.
        let mut other = state();
        other.setting.operations = saved.operations;
        other.setting.camera = saved.camera;
        other.after_move();
        let back = again(&s, other);
        assert_eq!((back.wish(), back.frame()), (s.wish(), s.frame()));
        assert_eq!(back.kept(), s.kept());
        s.apply(Action::Undo);
        assert_eq!(s.kept(), None, "what the file has, again");
    }

    #[test]
    fn the_offer_can_be_taken_dropped_and_put_off() {
        let mut s = state();
        drag(&mut s);
        let kept = s.kept().expect("a drag");
        let answered = |action| {
            let mut s = state();
            s.offer(kept.clone());
            let question = s.overlay().question.expect("a question");
            assert!(question.starts_with("moves of a session"), "{question}");
            s.take_commands();
            s.apply(action);
            assert_eq!(s.overlay().question, None);
            s.take_commands()
        };
        let take_back = Command::TakeBack(Box::new(kept.clone()));
        assert_eq!(answered(Action::Accept), [take_back]);
        assert_eq!(answered(Action::Decline), [Command::DropMoves]);
        assert_eq!(answered(Action::Back), []);
        assert_eq!(answered(Action::Quit), [Command::Quit]);
        let mut s = state();
        assert!(!s.withdraw_offer());
        s.offer(kept);
        assert!(s.withdraw_offer() && !s.is_asking());
    }
}
