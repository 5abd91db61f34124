//! The window at work on a session: scripts, the mouse, and scenes that are saved.

use std::io;
use std::path::PathBuf;

use winit::dpi::PhysicalSize;
use winit::event::ElementState;

use super::{Message, Stage, Viewer};
use crate::app::action::Action;
use crate::app::bindings::Button;
use crate::app::moves::Recorded;
use crate::app::save::{Origin, save};
use crate::app::script::Line;
use crate::app::session::print;
use crate::app::state::Document;

impl Viewer {
    /// Plays the lines of the script that are due.
    pub(super) fn play_script(&mut self) {
        while let Some(line) = self.session.next(self.real(), self.is_settled()) {
            match line {
                Line::Act(action) => self.act(Some(action)),
                Line::Resize(width, height) => {
                    if let Some(screen) = self.stage.screen() {
                        let size = PhysicalSize::new(width, height);
                        // Some systems answer at once, others with an event.
                        if let Some(size) = screen.window.request_inner_size(size) {
                            self.resized(size);
                        }
                    }
                }
                Line::Settle => print(&self.session.settle_report(&self.state)),
                Line::Wait(_) => {}
            }
            self.state.advance(self.now());
        }
    }

    /// A recorded session waits where the picture stood.
    pub(super) fn note_settled(&mut self) {
        if self.is_settled()
            && !self.state.is_moving()
            && let Some(e) = self.session.settled()
        {
            self.tell(&format!("cannot record the session: {e}"));
        }
    }

    /// True when the window shows what the state wants and nothing is under way.
    pub(super) fn is_settled(&self) -> bool {
        let shown = self.picture.as_ref().map(|p| p.wish);
        matches!(self.stage, Stage::Running(_))
            && !self.is_new
            && self.pending == 0
            && shown == Some(self.state.wish())
            && self.drawn == self.state.overlay()
            && self.session.has_size(self.state.size_px())
    }

    pub(super) fn button(&mut self, state: ElementState, button: Button) {
        let now = self.now();
        let place = self.input.cursor_px();
        let bar = self.state.bar();
        let on_bar = place.zip(bar).filter(|(place, bar)| bar.contains(*place));
        let action = match state {
            ElementState::Pressed if button == Button::Left && on_bar.is_some() => {
                self.scrubbing = true;
                on_bar.map(|((x, _), bar)| Action::Seek(bar.frame_at(x)))
            }
            ElementState::Pressed => {
                self.input.button_down(button, now);
                None
            }
            ElementState::Released if button == Button::Left && self.scrubbing => {
                self.scrubbing = false;
                None
            }
            ElementState::Released => self.input.button_up(button, now),
        };
        self.act(action);
    }

    pub(super) fn cursor_moved(&mut self, x: f64, y: f64) {
        let now = self.now();
        let moved = self.input.cursor_moved(x, y, now);
        self.state.advance(now);
        self.state.pointed_at((x, y));
        let action = match self.state.bar() {
            Some(bar) if self.scrubbing => Some(Action::Seek(bar.frame_at(x))),
            _ => moved,
        };
        self.act(action);
    }

    /// Saves the scene with the hand's moves, on a thread of its own.
    pub(super) fn save_scene(&mut self, document: Document) {
        let (origin, proxy) = (self.origin.clone(), self.proxy.clone());
        self.pending += 1;
        self.saving.push(std::thread::spawn(move || {
            let saved = save(&origin, &document);
            // Fails when the loop has ended: the file is there all the same.
            let _ = proxy.send_event(Message::SceneSaved(document.recorded, saved));
        }));
    }

    pub(super) fn scene_saved(&mut self, recorded: Recorded, saved: io::Result<PathBuf>) {
        self.pending -= 1;
        self.state.advance(self.now());
        let name = saved.map(|path| {
            let name = path.display().to_string();
            self.origin = Origin::File(path);
            name
        });
        self.state.saved(recorded, name.map_err(|e| e.to_string()));
    }
}
