//! Playing: the keys of a player, and the bar of frames.

use std::time::Duration;

use super::{State, next};
use crate::app::overlay::zoom_factor;
use crate::app::scrub::{Bar, BarWish};
use crate::timeline::Order;

/// How long the bar stays when the mouse rests.
const BAR: Duration = Duration::from_secs(2);

impl State {
    pub(super) fn toggle_playback(&mut self, backwards: bool) {
        if self.playback.is_playing() {
            let frame = self.playback.pause();
            self.report(format!("paused at frame {frame}"));
            return;
        }
        self.playback.play(backwards);
        // Nothing to play ends here.
        if self.playback.advance(Duration::ZERO) {
            let frame = self.playback.frame();
            self.report(format!("playback ended at frame {frame}"));
        }
    }

    pub(super) fn step_operation(&mut self, back: bool) {
        let n = self.setting.timing.frames_per_op();
        let frame = self.playback.pause();
        self.playback.seek(if back {
            frame.saturating_sub(1) / n * n
        } else {
            (frame / n + 1).saturating_mul(n)
        });
    }

    pub(super) fn set_speed(&mut self, speed: f64) {
        self.playback.set_speed(speed);
        self.say(format!("speed {:.2}", self.playback.speed()));
    }

    pub(super) fn next_order(&mut self) {
        let order = next(&Order::ALL, self.playback.order());
        self.playback.set_order(order);
        self.say(format!("play: {}", order.name()));
    }

    /// The first end of a loop, then the second, then none.
    pub(super) fn mark_section(&mut self) {
        let line = if let Some((a, b)) = self.marked() {
            self.section_start = None;
            self.playback.set_section(Some((a, b)));
            format!("loop from frame {a} to {b}")
        } else if self.section_start.take().is_some() || self.playback.section().is_some() {
            self.playback.set_section(None);
            "no loop".to_owned()
        } else {
            let frame = self.playback.frame();
            self.section_start = Some(frame);
            format!("loop from frame {frame}")
        };
        self.say(line);
    }

    /// From the first end of a loop to the frame shown. The film may have become shorter since the end was set.
    fn marked(&self) -> Option<(u64, u64)> {
        let start = self.section_start?.min(self.playback.last_frame());
        let frame = self.playback.frame();
        (start != frame).then(|| (start.min(frame), start.max(frame)))
    }

    /// The mouse is at a place: near the lower border the bar is shown while it moves, and as long as it `holds` the bar
    /// wherever it is.
    pub fn pointed_at(&mut self, place: (f64, f64), holds: bool) {
        let near = self.bar().is_some_and(|bar| holds || bar.contains(place));
        self.bar_until = match holds {
            true => near.then_some(Duration::MAX),
            false => near.then(|| self.now + BAR),
        };
    }

    /// The film stands where a hand holds it.
    pub(super) fn holds_bar(&self) -> bool {
        self.bar_until == Some(Duration::MAX)
    }

    /// Where the bar is, or would be; `None` when there is one frame only or nothing may be drawn.
    #[must_use]
    pub fn bar(&self) -> Option<Bar> {
        let last = self.playback.last_frame();
        let scale = self.scale_factor * zoom_factor(self.zoom);
        (self.setting.overlay && last > 0).then(|| Bar::new(self.size_px, scale, last))
    }

    pub(super) fn bar_wish(&self) -> Option<BarWish> {
        self.bar_until?;
        Some(BarWish {
            bar: self.bar()?,
            frame: self.playback.frame(),
            frames_per_op: self.setting.timing.frames_per_op(),
            section: self.playback.section().or_else(|| self.marked()),
        })
    }
}
