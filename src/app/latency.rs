//! How long it takes from a hand's move to the picture that answers it: of the last pictures, for the overlay, and of
//! all since the last report, for a session's.

use std::collections::{BTreeMap, VecDeque};
use std::time::{Duration, Instant};

use super::overlay::Line;

/// So many of the last pictures count.
const MEMORY: usize = 256;
/// The steps in which a [`Tally`] counts times.
const BIN: Duration = Duration::from_micros(100);
/// A tally's last bin is for this and all above.
const LONGEST: Duration = Duration::from_secs(2);

/// From input to the return of the call that presents, for the last pictures that a hand asked for.
#[derive(Debug, Default)]
pub struct Latencies {
    last: VecDeque<Duration>,
}

impl Latencies {
    /// A picture was shown that long after it was asked for.
    pub fn count(&mut self, latency: Duration) {
        if self.last.len() == MEMORY {
            self.last.pop_front();
        }
        self.last.push_back(latency);
    }

    /// The time that `percent` of 100 stayed within; `None` before the first.
    #[must_use]
    pub fn percentile(&self, percent: usize) -> Option<Duration> {
        let mut sorted: Vec<Duration> = self.last.iter().copied().collect();
        sorted.sort_unstable();
        // The nearest rank: the smallest of them with at least that share of all at or below it.
        let rank = (sorted.len() * percent).div_ceil(100).max(1);
        sorted.get(rank - 1).copied()
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

/// All pictures that a hand asked for since the last report, in as much memory however many they are.
#[derive(Debug, Default)]
pub struct Tally {
    /// Pictures by the time from input to picture, in steps of [`BIN`].
    bins: Vec<u64>,
    /// Pictures by the size of their pixels.
    sizes: BTreeMap<usize, u64>,
    /// The first picture; a screen's refreshes are counted from there.
    origin: Option<Instant>,
    /// The one before.
    last: Option<Instant>,
    refreshes: u64,
    missed: u64,
}

impl Tally {
    /// A picture of pixels that stand for `pixel_size` of the window was shown `at`, and `asked` for then, on a
    /// screen with a refresh each `refresh`.
    pub fn count(&mut self, asked: Instant, at: Instant, pixel_size: usize, refresh: Duration) {
        let origin = *self.origin.get_or_insert(at);
        let latency = at.saturating_duration_since(asked).min(LONGEST);
        let bin = (latency.as_nanos() / BIN.as_nanos()) as usize; // At most LONGEST / BIN.
        if self.bins.len() <= bin {
            self.bins.resize(bin + 1, 0);
        }
        self.bins[bin] += 1;
        *self.sizes.entry(pixel_size).or_default() += 1;
        // A refresh is missed when a hand waited for all of it and nothing new was shown.
        let number = |at: Instant| {
            let since = at.saturating_duration_since(origin);
            since.as_nanos() / refresh.as_nanos().max(1)
        };
        let from = self.last.replace(at).map_or(asked, |last| last.max(asked));
        let passed = number(at).saturating_sub(number(from)) as u64; // Refreshes since the start fit.
        self.refreshes += passed;
        self.missed += passed.saturating_sub(1);
    }

    /// How many pictures.
    #[must_use]
    pub fn pictures(&self) -> u64 {
        self.bins.iter().sum()
    }

    /// Refreshes while a hand moved, and those of them that showed nothing new.
    #[must_use]
    pub fn refreshes(&self) -> (u64, u64) {
        (self.refreshes, self.missed)
    }

    /// Pictures by the size of their pixels.
    #[must_use]
    pub fn sizes(&self) -> &BTreeMap<usize, u64> {
        &self.sizes
    }

    /// The time that `percent` of 100 stayed within, rounded up to [`BIN`]; `None` without pictures.
    #[must_use]
    pub fn percentile(&self, percent: u64) -> Option<Duration> {
        let rank = (self.pictures() * percent).div_ceil(100).max(1);
        let mut below = 0;
        let bin = self.bins.iter().position(|count| {
            below += count;
            below >= rank
        })?;
        Some(BIN * (bin as u32 + 1)) // At most LONGEST / BIN.
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_those_of_the_last_pictures() {
        let mut l = Latencies::default();
        assert_eq!(l.percentile(50), None);
        l.count(Duration::from_secs(9));
        for i in 1..=MEMORY as u64 {
            l.count(Duration::from_millis(i));
        }
        let ms = |percent| l.percentile(percent).map(|d| d.as_millis());
        assert_eq!(
            [ms(1), ms(50), ms(99), ms(100)],
            [Some(3), Some(128), Some(254), Some(256)]
        );
        assert_eq!(l.line().text, "p50 128.0 ms, p99 254.0 ms");
    }

    #[test]
    fn one_picture_is_every_percentile() {
        let mut l = Latencies::default();
        l.count(Duration::from_millis(7));
        assert_eq!(l.percentile(1), l.percentile(99));
    }

    const REFRESH: Duration = Duration::from_millis(16);

    /// Counts pictures of one size that are asked for and shown at those times in ms.
    fn tally(times: &[(u64, u64)]) -> Tally {
        let start = Instant::now();
        let at = |ms| start + Duration::from_millis(ms);
        let mut tally = Tally::default();
        for &(asked, shown) in times {
            tally.count(at(asked), at(shown), 1, REFRESH);
        }
        tally
    }

    #[test]
    fn all_pictures_count_and_none_is_forgotten() {
        let pictures: Vec<(u64, u64)> = (0..1000).map(|i| (i * 10, i * 10 + 1 + i % 100)).collect();
        let mut t = tally(&pictures);
        let us = |t: &Tally, percent| t.percentile(percent).map(|d| d.as_micros());
        assert_eq!(t.pictures(), 1000);
        assert_eq!([us(&t, 50), us(&t, 99)], [Some(50_100), Some(99_100)]);
        let now = Instant::now();
        t.count(now, now + Duration::from_secs(3600), 8, REFRESH);
        assert_eq!(us(&t, 100), Some(2_000_100));
        assert_eq!(t.sizes(), &BTreeMap::from([(1, 1000), (8, 1)]));
        assert_eq!(Tally::default().percentile(99), None);
    }

    #[test]
    fn a_refresh_without_a_new_picture_is_missed_only_while_a_hand_waits() {
        // One a refresh, at any phase; two in one.
        let steady: Vec<(u64, u64)> = (0..60).map(|i| (i * 16, i * 16 + 10)).collect();
        assert_eq!(tally(&steady).refreshes(), (59, 0));
        assert_eq!(tally(&[(0, 5), (2, 7), (5, 21)]).refreshes(), (1, 0));
        // Refreshes begin at 5, 21, 37, 53, 69: two of them show nothing.
        assert_eq!(tally(&[(0, 5), (6, 60)]).refreshes(), (3, 2));
        // The hand rested.
        assert_eq!(tally(&[(0, 5), (1000, 1020)]).refreshes(), (1, 0));
    }
}
