//! The figures of the overlay: how fast, how large, by what means.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use super::overlay::Line;
use super::painter::Picture;
use super::state::Wish;

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
        let ms = |d: Duration| format!("{:.2} ms", d.as_secs_f64() * 1e3);
        let stats = picture.stats;
        let wish = &picture.order.wish;
        let settings = wish.settings;
        let (width, height) = (picture.frame.width, picture.frame.height);
        // Slow sides tell for themselves how far they are.
        let fast = |text: String| match wish.has_fast_side() {
            true => text,
            false => "-".to_owned(),
        };
        let rays = fast_part(wish) * (width * height) as f64;
        let mrays_s = rays / 1e6 / stats.total.as_secs_f64().max(1e-9);
        let fps = self
            .rate(now)
            .map_or("standing".to_string(), |rate| format!("{rate:.1}"));
        vec![
            Line::new("fps", fps),
            Line::new("render", fast(ms(stats.total))),
            Line::new("  trace", fast(ms(stats.trace))),
            Line::new("  shade", fast(ms(stats.shade))),
            Line::new("present", ms(self.present)),
            Line::new("speed", fast(format!("{mrays_s:.1} Mray/s"))),
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

/// The part of the picture's columns that the fast engine makes.
fn fast_part(wish: &Wish) -> f64 {
    let sides = wish.sides();
    let fast = sides.iter().filter(|side| side.is_fast());
    let columns: usize = fast.map(|side| side.columns.len()).sum();
    columns as f64 / wish.view.width as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::painter::Order;
    use crate::app::side::Split;
    use crate::camera::Camera;
    use crate::frame::Frame;
    use crate::geometry::Aabb;
    use crate::render::{Engine, RenderStats, Samples, Settings};

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
    fn the_speed_is_that_of_the_fast_sides_alone() {
        let speed = |column: usize| {
            let report = Settings {
                engine: Engine::Report,
                ..Settings::default()
            };
            let wish = Wish {
                view: Camera::default_for(Aabb::EMPTY).view(100, 80, false),
                settings: Settings::default(),
                split: Some(Split {
                    settings: report,
                    column,
                }),
            };
            let mut frame = Frame::default();
            frame.resize(100, 80);
            let picture = Picture {
                frame,
                order: Order {
                    scene: 0,
                    wish,
                    pixel_size: 1,
                    samples: Samples::ONE,
                    moving: false,
                    asked: None,
                },
                samples: Samples::ONE,
                stats: RenderStats {
                    total: Duration::from_millis(u64::from(column > 0)),
                    ..RenderStats::default()
                },
                side_times: [Duration::ZERO; 2],
            };
            let lines = Statistics::new(1, 1).lines(Some(&picture), (0, 0), Instant::now());
            let of = |name: &str| lines.iter().find(|l| l.name == name).expect("a line");
            (of("render").text.clone(), of("speed").text.clone())
        };
        assert_eq!(speed(100), ("1.00 ms".into(), "8.0 Mray/s".into()));
        assert_eq!(speed(25), ("1.00 ms".into(), "2.0 Mray/s".into()));
        assert_eq!(speed(0), ("-".into(), "-".into()));
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
