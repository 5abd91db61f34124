//! Pictures on their way: ordered, taken, shown with what lies over them, saved.

use std::path::Path;
use std::time::{Duration, Instant};

use winit::event_loop::ActiveEventLoop;

use super::{Message, Stage, Viewer, report};
use crate::app::overlay::{Line, Told};
use crate::app::pace::Moment;
use crate::app::painter::Picture;
use crate::app::state::OverlayWish;
use crate::app::{backend, panics, screenshot, script};
use crate::render::Samples;

impl Viewer {
    /// What is to be drawn over the picture now.
    pub(super) fn wanted_overlay(&self) -> (OverlayWish, Option<Vec<Line>>) {
        let board = self.opener.board(Instant::now());
        // Between a scene and its first picture there is nothing else to see.
        let last = self.drawn.1.as_ref().filter(|_| self.picture.is_none());
        let board = board.or_else(|| last.cloned());
        let is_quiet = self.kiosk.is_some() && self.picture.is_some();
        let board = board.filter(|_| self.state.may_overlay() && !is_quiet);
        (self.state.overlay(), board)
    }

    /// Shows the newest picture, whole, with what is to be drawn over it.
    pub(super) fn redraw(&mut self, event_loop: &ActiveEventLoop) {
        self.state.advance(self.now());
        self.drawn = self.wanted_overlay();
        let Stage::Running(screen) = &mut self.stage else {
            return;
        };
        let picture = self.picture.as_deref();
        self.redrawn = Instant::now();
        let figures = if self.drawn.0.statistics {
            let frame = self.state.frame();
            let mut lines = self.statistics.lines(picture, frame, self.redrawn);
            lines.extend(picture.map(fineness));
            lines.push(self.pace.latencies.line());
            lines.extend(self.opener.improvement());
            lines
        } else {
            Vec::new()
        };
        let (overlay, drawn, slow) = (&mut self.overlay, &self.drawn, &self.slow);
        let wish = picture.map(|p| &p.order.wish);
        let labels = wish
            .filter(|_| self.state.may_overlay())
            .and_then(|wish| slow.labels(wish, self.side_times));
        // Before the first picture there is a board to be read.
        let kiosk = self.kiosk.as_ref().filter(|_| picture.is_some());
        let light = kiosk.map_or(256, |kiosk| kiosk.light(self.redrawn));
        let shown = screen.show(picture, |canvas| {
            if let Some(wish) = wish {
                // To ask for all pixels is to copy them before the panels can darken them on their way.
                if wish.sides().iter().any(|side| side.is_slow()) {
                    let width = canvas.width;
                    slow.lay(wish, canvas.pixels(), width);
                }
                if drawn.0.axes {
                    overlay.axes(canvas, &wish.view, &drawn.0);
                }
            }
            let told = Told {
                statistics: &figures,
                labels: labels.as_ref(),
                board: drawn.1.as_deref(),
            };
            overlay.draw(canvas, &drawn.0, &told);
            if light < 256 {
                canvas.fade(light);
            }
        });
        match shown {
            Ok(time) => self.present = time,
            Err(e) => return self.fail(event_loop, e),
        }
        self.slow.is_new = false;
        if std::mem::take(&mut self.is_new)
            && let Some(picture) = &self.picture
        {
            let now = Instant::now();
            self.pace.shown(picture, now);
            self.statistics.count(now, self.present);
        }
    }

    /// A picture came: the one before goes back to the render thread, or this one where it shows less of the same.
    pub(super) fn take_picture(&mut self, picture: Box<Picture>) {
        self.is_awaited = false;
        if !self.pace.is_of_scene(&picture) {
            return self.painter.give_back(picture.frame);
        }
        if self.epoch.is_none() {
            self.epoch = Some(Instant::now());
            // The same session needs a window of the same size: far below 2^32 pixels.
            let (width, height) = self.state.size_px();
            let size = script::Line::Resize(width as u32, height as u32);
            self.note(Duration::ZERO, size);
            if let Some(screen) = self.stage.screen() {
                backend::take_keyboard(&screen.window);
            }
        }
        self.pace.took(&picture, self.present);
        if picture.samples == Samples::ONE {
            self.side_times = picture.side_times;
        }
        let old = self.picture.as_deref();
        if old.is_some_and(|old| picture.is_coarser_than(old)) {
            return self.painter.give_back(picture.frame);
        }
        if let Some(old) = self.picture.replace(picture) {
            self.painter.give_back(old.frame);
        }
        self.is_new = true;
        self.stage.request_redraw();
        if self.to_be_saved {
            self.save_picture();
        }
    }

    /// Says that a picture failed: in the window each time, on the terminal as often as anybody wants to read it.
    pub(super) fn picture_failed(&mut self, why: &str) {
        let line = format!("a picture failed: {why}");
        self.failures += 1;
        if self.failures <= panics::MOST {
            report(&line);
        }
        self.state.advance(self.now());
        self.state.say(line);
    }

    /// The user wants a file of the picture; that of a slow engine may take its time.
    pub(super) fn ask_for_picture(&mut self) {
        self.save_picture();
        let wish = self.picture.as_ref().map(|p| p.order.wish);
        if wish.is_some_and(|wish| !self.slow.are_whole(&wish)) {
            self.tell("the picture is saved when it is whole");
        }
    }

    /// Saves a copy of the picture, on a thread of its own; one that is coarse when a fine one is there.
    pub(super) fn save_picture(&mut self) {
        self.saving.retain(|thread| !thread.is_finished());
        let is_ready = |p: &Picture| p.order.pixel_size == 1 && self.slow.are_whole(&p.order.wish);
        self.to_be_saved = self.picture.as_deref().is_some_and(|p| !is_ready(p));
        if self.to_be_saved {
            return;
        }
        let Some(picture) = &self.picture else {
            return self.tell("no picture to save yet");
        };
        let frame = self.slow.whole(&picture.order.wish, &picture.frame);
        let proxy = self.proxy.clone();
        self.saving.push(std::thread::spawn(move || {
            let saved = screenshot::save(&frame, Path::new("."));
            // Fails when the loop has ended: the file is there all the same.
            let _ = proxy.send_event(Message::Saved(saved));
        }));
    }

    /// Orders the picture that the state wants, when it is time for it. Returns when to come back for that.
    pub(super) fn order(&mut self) -> Option<Instant> {
        let now = Instant::now();
        let unseen_at = match &self.stage {
            Stage::Running(screen) => screen.unseen_at(),
            Stage::Waiting | Stage::Suspended(_) => Some(now),
        };
        if unseen_at.is_some_and(|at| at <= now) {
            self.rest();
            return None;
        }
        let due = self.order_at(now);
        due.into_iter().chain(unseen_at).min()
    }

    /// Nobody sees the window: no picture is rendered. What was begun goes on when it is seen again; one of what moves
    /// is finished.
    fn rest(&mut self) {
        self.slow.rest();
        if !self.is_awaited {
            self.painter.rest();
            self.pace.rest();
        }
    }

    fn order_at(&mut self, now: Instant) -> Option<Instant> {
        let Stage::Running(screen) = &self.stage else {
            return None;
        };
        // One after the other: the next picture would take the cores from showing this one. The newest wish waits
        // here; that of a picture which may be interrupted need not.
        if !self.opener.has_scene() || self.is_awaited || self.is_new {
            return None;
        }
        let time_moves = self.session.time_moves();
        let moment = Moment {
            at: now,
            interval: screen.interval,
            told_when: screen.tells_when,
            // While a script's time stands, so does the picture.
            turning: time_moves && self.state.is_turning(),
            frame_time: self.state.frame_time().filter(|_| time_moves),
            must_be_fine: self.to_be_saved,
        };
        let wish = self.state.wish();
        self.slow.order(&wish);
        let step = self.pace.step(wish, &moment);
        if let Some(order) = step.order {
            self.is_awaited = order.moving;
            self.painter.order(order);
        }
        step.wake
    }

    /// Asks for a redraw where what is drawn over the picture is not what should be. Returns when to look again.
    pub(super) fn refresh_overlay(&mut self) -> Option<Instant> {
        // The figures tell once that nothing moves any more.
        let stands_at = self.statistics.stands_at();
        let stands_at = stands_at.filter(|&at| self.drawn.0.statistics && self.redrawn < at);
        let is_due = stands_at.is_some_and(|at| at <= Instant::now());
        if is_due || self.drawn != self.wanted_overlay() {
            self.stage.request_redraw();
        }
        stands_at.filter(|_| !is_due)
    }
}

/// How fine the picture is, for the figures.
fn fineness(picture: &Picture) -> Line {
    let (size, samples) = (picture.order.pixel_size, picture.samples.count());
    let text = match (size, samples) {
        (1, 1) => "1 sample a pixel".to_string(),
        (1, _) => format!("{samples} samples a pixel"),
        _ => format!("{size}x{size} pixels as one"),
    };
    Line::new("detail", text)
}
