//! Questions in the window, before moves are lost or come back.

use super::{Command, State};
use crate::app::action::Action;

impl State {
    /// Does what takes another scene's place, or none's; asks before, where recorded moves are lost by it.
    pub fn leave(&mut self, command: Command) {
        if self.moves.is_unsaved() {
            self.let_go_of_all();
            self.playback.pause();
            self.ask(command);
        } else {
            self.commands.push(command);
        }
    }

    /// Asks, in the window and on the terminal, before `command` is done.
    pub(super) fn ask(&mut self, command: Command) {
        self.asking = Some(command);
        let question = self.question();
        self.commands.extend(question.map(Command::Report));
    }

    /// Takes an action as the answer to the question that waits. Others wait.
    pub(super) fn answer(&mut self, action: Action) {
        let is_offer = matches!(self.asking, Some(Command::TakeBack(_)));
        match action {
            // Not now is neither yes nor no: it is offered again another time.
            Action::Quit if is_offer => {
                self.asking = None;
                self.leave(Command::Quit);
            }
            Action::Decline if is_offer => {
                self.asking = None;
                self.commands.push(Command::DropMoves);
            }
            // Quitting loses more than what was asked about: it is no yes to that.
            Action::Quit if self.asking != Some(Command::Quit) => self.ask(Command::Quit),
            Action::Accept | Action::Quit => self.commands.extend(self.asking.take()),
            Action::Decline | Action::Back => self.asking = None,
            Action::Save | Action::SaveAs => {
                self.asking = None;
                self.apply(action);
            }
            _ => {}
        }
    }

    /// True while a question waits for an answer.
    #[must_use]
    pub fn is_asking(&self) -> bool {
        self.asking.is_some()
    }

    /// The question that waits.
    pub(super) fn question(&self) -> Option<String> {
        let does = match self.asking.as_ref()? {
            Command::TakeBack(_) => {
                let later = self.keymap.chord_of(Action::Back);
                let later = later.map_or(String::new(), |chord| format!(", {chord}: not now"));
                return Some(format!(
                    "moves of a session that was cut off: y takes them back, n drops them{later}"
                ));
            }
            Command::Quit => "quits",
            _ => "drops them",
        };
        let save = self.keymap.chord_of(Action::Save);
        let save = save.map_or(String::new(), |chord| format!(", {chord} saves"));
        Some(format!(
            "recorded moves are not saved: y {does}, n stays{save}"
        ))
    }
}
