//! The figures of the overlay: how fast, how large, by what means.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use super::overlay::Line;
use super::painter::Picture;

/// Pictures of this long ago count for the rate.
const WINDOW: Duration = Duration::from_secs(1);

/// When pictures were shown, and what does not change.
#[derive(Debug)]
pub struct Statistics {
    threads: usize,
    triangles: usize,
    shown: VecDeque<Instant>,
    present: Duration,
}

impl Statistics {
    /// Of a renderer with `threads` threads and a scene with `triangles` triangles.
    #[must_use]
    pub fn new(threads: usize, triangles: usize) -> Statistics {
        Statistics {
            threads,
            triangles,
            shown: VecDeque::new(),
            present: Duration::ZERO,
        }
    }

    /// A new picture was shown at `now`; copying, drawing over and handing over took `present`.
    pub fn count(&mut self, now: Instant, present: Duration) {
        self.shown.push_back(now);
        self.present = present;
        while self.shown.front().is_some_and(|&t| t + WINDOW < now) {
            self.shown.pop_front();
        }
    }

    /// Pictures a second, over the second before `now`; `None` for a picture that stands.
    fn rate(&self, now: Instant) -> Option<f64> {
        let count = self.shown.iter().filter(|&&t| t + WINDOW > now).count();
        let (first, last) = (
            *self.shown.iter().nth_back(count.checked_sub(1)?)?,
            *self.shown.back()?,
        );
        let seconds = last.saturating_duration_since(first).as_secs_f64();
        (seconds > 0.0).then(|| (count - 1) as f64 / seconds)
    }

    /// When it is clear that the newest picture stands, unless another one is shown before.
    #[must_use]
    pub fn stands_at(&self) -> Option<Instant> {
        self.shown.back().map(|&last| last + WINDOW)
    }

    /// The figures at `now` as text; `frame` is the number shown and the last one.
    #[must_use]
    pub fn lines(&self, picture: Option<&Picture>, frame: (u64, u64), now: Instant) -> Vec<Line> {
        let Some(picture) = picture else {
            return vec![Line::new("", "no picture yet")];
        };
        let ms = |d: Duration| d.as_secs_f64() * 1e3;
        let stats = picture.stats;
        let settings = picture.order.wish.settings;
        let (width, height) = (picture.frame.width, picture.frame.height);
        let seconds = stats.total.as_secs_f64();
        let mrays_s = (width * height) as f64 / 1e6 / seconds.max(1e-9);
        let fps = self
            .rate(now)
            .map_or("standing".to_string(), |rate| format!("{rate:.1}"));
        vec![
            Line::new("fps", fps),
            Line::new("render", format!("{:.2} ms", ms(stats.total))),
            Line::new("  trace", format!("{:.2} ms", ms(stats.trace))),
            Line::new("  shade", format!("{:.2} ms", ms(stats.shade))),
            Line::new("present", format!("{:.2} ms", ms(self.present))),
            Line::new("speed", format!("{mrays_s:.1} Mray/s")),
            Line::new("kernel", settings.kernel.name()),
            Line::new("engine", format!("{:?}", settings.engine).to_lowercase()),
            Line::new("view", format!("{:?}", settings.mode).to_lowercase()),
            Line::new("threads", self.threads.to_string()),
            Line::new("triangles", self.triangles.to_string()),
            Line::new("size", format!("{width}x{height}")),
            Line::new("frame", format!("{} of {}", frame.0, frame.1)),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rate_is_that_of_the_last_second() {
        let mut s = Statistics::new(2, 12);
        let start = Instant::now();
        let at = |ms| start + Duration::from_millis(ms);
        assert_eq!((s.rate(start), s.stands_at()), (None, None));
        for i in 0..200 {
            s.count(at(20 * i), Duration::ZERO);
        }
        for ms in [3980, 4500] {
            let rate = s.rate(at(ms)).expect("many pictures");
            assert!((rate - 50.0).abs() < 1e-9, "{rate}");
        }
        assert_eq!(s.stands_at(), Some(at(4980)));
        assert_eq!(s.rate(at(4980)), None);
        s.count(at(60_000), Duration::ZERO);
        assert_eq!(s.rate(at(60_000)), None);
    }

    #[test]
    fn without_a_picture_there_are_no_figures() {
        assert_eq!(
            Statistics::new(1, 1)
                .lines(None, (0, 0), Instant::now())
                .len(),
            1
        );
    }
}
