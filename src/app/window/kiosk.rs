//! The window as a kiosk: scenes in turn, and no hand but one that quits.

use std::time::Instant;

use winit::event_loop::ActiveEventLoop;

use super::{Stage, Viewer, report};
use crate::app::AppError;
use crate::app::kiosk::Turn;
use crate::app::opener::Outcome;

impl Viewer {
    /// What the opener has goes to the kiosk, which decides when it is shown.
    pub(super) fn hear_in_kiosk(&mut self, event_loop: &ActiveEventLoop, outcome: Outcome) {
        let Some(kiosk) = &mut self.kiosk else { return };
        match outcome {
            Outcome::Show { loaded, .. } => kiosk.loaded(loaded),
            Outcome::Better(world) => {
                if let Some(world) = kiosk.improved(world) {
                    self.improve(world);
                }
            }
            Outcome::Fatal(e) | Outcome::Kept(e) => {
                let words = e.words(false);
                if !kiosk.failed() {
                    self.fail(event_loop, AppError::NoScene(e));
                } else if kiosk.is_news(&words) {
                    report(&words);
                }
            }
        }
    }

    /// Goes on with the round. Returns when to come back.
    pub(super) fn run_kiosk(&mut self, event_loop: &ActiveEventLoop) -> Option<Instant> {
        let now = Instant::now();
        loop {
            let is_playing = self.state.frame_time().is_some();
            match self.kiosk.as_mut()?.turn(now, is_playing) {
                Some(Turn::Load(source)) => self.open_source(event_loop, source),
                Some(Turn::Show(loaded)) => {
                    self.open(*loaded, false);
                    self.state.play();
                }
                None => break,
            }
        }
        let kiosk = self.kiosk.as_ref()?;
        let Stage::Running(screen) = &mut self.stage else {
            return None;
        };
        if !kiosk.is_fading(now) {
            return kiosk.wake(now);
        }
        let due = self.redrawn + screen.interval;
        if due <= now {
            screen.request_redraw();
            return Some(now + screen.interval);
        }
        Some(due)
    }
}
