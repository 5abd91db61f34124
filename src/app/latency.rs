//! How long it takes from a hand's move to the picture that answers it.

use std::collections::VecDeque;
use std::time::Duration;

use super::overlay::Line;

/// So many of the last pictures count.
const MEMORY: usize = 256;

/// From input to the return of the call that presents, for the last pictures that a hand asked for.
#[derive(Debug, Default)]
pub struct Latencies {
    last: VecDeque<(Duration, usize)>,
}

impl Latencies {
    /// A picture was shown that long after it was asked for, of pixels that stand for `pixel_size` of the window.
    pub fn count(&mut self, latency: Duration, pixel_size: usize) {
        if self.last.len() == MEMORY {
            self.last.pop_front();
        }
        self.last.push_back((latency, pixel_size));
    }

    /// The time that `percent` of 100 stayed within; `None` before the first.
    #[must_use]
    pub fn percentile(&self, percent: usize) -> Option<Duration> {
        let mut sorted: Vec<Duration> = self.last.iter().map(|(latency, _)| *latency).collect();
        sorted.sort_unstable();
        // The nearest rank: the smallest of them with at least that share of all at or below it.
        let rank = (sorted.len() * percent).div_ceil(100).max(1);
        sorted.get(rank - 1).copied()
    }

    /// The largest pixels of these pictures; `None` before the first.
    #[must_use]
    pub fn largest_pixel(&self) -> Option<usize> {
        self.last.iter().map(|(_, pixel_size)| *pixel_size).max()
    }

    /// The figure for the overlay.
    #[must_use]
    pub fn line(&self) -> Line {
        let ms = |percent| self.percentile(percent).map(|d| d.as_secs_f64() * 1e3);
        let text = match (ms(50), ms(99)) {
            (Some(p50), Some(p99)) => format!("p50 {p50:.1} ms, p99 {p99:.1} ms"),
            _ => "no input yet".to_string(),
        };
        Line::new("input", text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_those_of_the_last_pictures() {
        let mut l = Latencies::default();
        assert_eq!(l.percentile(50), None);
        l.count(Duration::from_secs(9), 9);
        for i in 1..=MEMORY as u64 {
            l.count(Duration::from_millis(i), 1 + i as usize % 2);
        }
        let ms = |percent| l.percentile(percent).map(|d| d.as_millis());
        assert_eq!(
            [ms(1), ms(50), ms(99), ms(100)],
            [Some(3), Some(128), Some(254), Some(256)]
        );
        assert_eq!(l.line().text, "p50 128.0 ms, p99 254.0 ms");
        // The picture of 9 seconds is long past.
        assert_eq!(l.largest_pixel(), Some(2));
    }

    #[test]
    fn one_picture_is_every_percentile() {
        let mut l = Latencies::default();
        l.count(Duration::from_millis(7), 3);
        assert_eq!(l.percentile(1), l.percentile(99));
        assert_eq!(l.largest_pixel(), Some(3));
    }
}
