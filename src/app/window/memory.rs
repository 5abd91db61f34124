//! What outlives the window: its size and place, and the moves that no file has.

use super::{Viewer, report};
use crate::app::backend;
use crate::app::journal::{Ground, Kept};

impl Viewer {
    /// Keeps finished moves safe.
    pub(super) fn note_moves(&mut self) {
        let state = &self.state;
        if let Err(e) = self.journal.note(state.revision(), || state.kept()) {
            self.tell(&format!("moves are not safe from a crash: {e}"));
        }
    }

    /// Another scene is open: moves that were left over from it are offered.
    pub(super) fn begin_journal(&mut self, ground: Option<Ground>) {
        self.journal.open(ground);
        self.offer_moves();
    }

    /// Asks about moves that were left over, if there are any.
    pub(super) fn offer_moves(&mut self) {
        self.journal.put_off();
        let mut words = Vec::new();
        let found = self.journal.find(|line| words.push(line.to_owned()));
        for line in words {
            self.tell(&line);
        }
        if let Some(kept) = found {
            self.state.offer(kept);
        }
    }

    pub(super) fn take_back(&mut self, kept: Kept) {
        self.state.advance(self.now());
        self.state.take_back(kept);
        self.journal.adopt();
    }

    pub(super) fn drop_moves(&mut self) {
        self.journal.drop_offered();
        self.offer_moves();
    }

    /// The window goes: what it was like is remembered.
    pub(super) fn keep_placement(&mut self) {
        if self.state.is_fullscreen() {
            return;
        }
        // Asked for only now: where no window manager is, X11 tells no moves. Wayland tells no places.
        let Some(screen) = self.stage.screen() else {
            return;
        };
        let window = &screen.window;
        match backend::quietly(|| (window.is_maximized(), window.outer_position())) {
            // Neither is its own: what it had before is kept.
            Ok((true, _)) => return,
            Ok((false, Ok(place))) => self.memory.moved(place.into()),
            Ok((false, Err(_))) | Err(_) => {}
        }
        if let Err(e) = self.memory.keep() {
            report(&format!("the window's place is not remembered: {e}"));
        }
    }
}
