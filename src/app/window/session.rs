//! The window at work on a session: scripts and the mouse.

use winit::dpi::PhysicalSize;
use winit::event::ElementState;
use winit::event_loop::ActiveEventLoop;
use winit::window::CursorIcon;

use super::{Stage, Viewer};
use crate::app::action::Action;
use crate::app::bindings::Button;
use crate::app::painter::Picture;
use crate::app::script::Line;
use crate::app::session::print;

/// What the left button holds, other than the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Held {
    Nothing,
    /// The bar of frames.
    Bar,
    /// The divider of a split picture.
    Divider,
}

impl Viewer {
    /// Plays the lines of the script that are due.
    pub(super) fn play_script(&mut self, event_loop: &ActiveEventLoop) {
        if let Some((width, height)) = self.session.give_up_size(self.real()) {
            self.tell(&format!(
                "the window does not take the size {width}x{height}: the session goes on without"
            ));
        }
        // Time begins with the first picture, but actions need only the scene.
        while self.opener.has_scene()
            && !event_loop.exiting()
            && let Some(line) = self.session.next(self.real(), self.is_settled())
        {
            match line {
                Line::Act(action) => {
                    self.act(Some(action));
                    self.obey(event_loop);
                }
                Line::Resize(width, height) => {
                    if let Some(screen) = self.stage.screen() {
                        let size = PhysicalSize::new(width, height);
                        // Some systems answer at once, others with an event.
                        if let Some(size) = screen.window.request_inner_size(size) {
                            self.resized(size);
                        }
                    }
                }
                Line::Settle => print(&self.session.settle_report(&self.state, &mut self.pace)),
                Line::Fault if self.state.wish().has_fast_side() => self.painter.inject_fault(),
                Line::Fault => self.slow.inject_fault(),
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
        let is_shown = |p: &Picture| p.order.wish == self.state.wish() && self.pace.is_finest(p);
        matches!(self.stage, Stage::Running(_))
            && !self.is_new
            && !self.slow.is_new
            && self.slow.are_whole(&self.state.wish())
            && self.pending == 0
            && !self.opener.is_loading()
            && !(self.opener.is_improving() && self.state.wish().shows_cost())
            && self.picture.as_deref().is_some_and(is_shown)
            && self.drawn == self.wanted_overlay()
            && self.session.has_size()
    }

    pub(super) fn button(&mut self, state: ElementState, button: Button) {
        let now = self.now();
        let place = self.input.cursor_px();
        let bar = self.state.bar();
        let on_bar = place.zip(bar).filter(|(place, bar)| bar.contains(*place));
        let action = match state {
            ElementState::Pressed if button == Button::Left && on_bar.is_some() => {
                self.hold(Held::Bar);
                on_bar.map(|((x, _), bar)| Action::Seek(bar.frame_at(x)))
            }
            ElementState::Pressed
                if button == Button::Left
                    && place.is_some_and(|place| self.state.is_on_divider(place)) =>
            {
                self.hold(Held::Divider);
                None
            }
            ElementState::Pressed => {
                self.input.button_down(button, now);
                None
            }
            ElementState::Released if button == Button::Left && self.held != Held::Nothing => {
                // A recorded session knows nothing of the hand that held the film.
                let held = place.zip(bar).filter(|_| self.held == Held::Bar);
                self.hold(Held::Nothing);
                held.map(|((x, _), bar)| Action::Seek(bar.frame_at(x)))
            }
            ElementState::Released => self.input.button_up(button, now),
        };
        self.act(action);
        if state == ElementState::Released {
            self.pace.let_go();
        }
    }

    /// The left button takes hold of something, or lets go. The bar is shown as long as it is held.
    pub(super) fn hold(&mut self, held: Held) {
        self.held = held;
        self.show_bar();
    }

    /// Shows the bar of frames where the mouse is on it.
    fn show_bar(&mut self) {
        self.state.advance(self.now());
        if let Some(place) = self.input.cursor_px().filter(|_| self.kiosk.is_none()) {
            self.state.pointed_at(place, self.held == Held::Bar);
        }
    }

    pub(super) fn cursor_moved(&mut self, x: f64, y: f64) {
        let moved = self.input.cursor_moved(x, y, self.now());
        self.show_bar();
        let action = match (self.held, self.state.bar()) {
            (Held::Bar, Some(bar)) => Some(Action::Seek(bar.frame_at(x))),
            (Held::Divider, _) => Some(Action::SetDivider(self.state.divider_at(x))),
            _ => moved,
        };
        self.show_cursor((x, y));
        self.act(action);
    }

    /// The mouse tells where the divider can be held.
    fn show_cursor(&mut self, place: (f64, f64)) {
        let is_held = self.held == Held::Divider;
        let icon = match is_held || self.state.is_on_divider(place) {
            true => CursorIcon::ColResize,
            false => CursorIcon::Default,
        };
        if std::mem::replace(&mut self.cursor, icon) != icon
            && let Some(screen) = self.stage.screen()
        {
            screen.window.set_cursor(icon);
        }
    }
}
