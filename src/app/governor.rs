//! The deadline governor: how coarse a picture may be while something moves, so that it is never late.
//!
//! Plain data: it is told how long pictures took and says how many pixels of the window's width and height one
//! pixel of the picture may stand for. What stands still is always fine. Noise only ever adds to a time, so the
//! shortest of the last few counts: one picture held up by another program changes nothing. Coarser is decided after
//! three late pictures, finer only after many pictures that would have been in time, and after each failed attempt it waits
//! longer: no pumping.

use std::collections::VecDeque;
use std::time::Duration;

/// Pixels of the window, each way, that one pixel of a picture stands for. In order.
const STEPS: [usize; 6] = [1, 2, 3, 4, 6, 8];
/// Times of this many pictures count.
const MEMORY: usize = 3;
/// A step finer must promise to stay below this part of the deadline.
const FINER_BELOW: f64 = 0.7;
/// Pictures in a row that must promise so.
const PATIENCE: u32 = 20;
/// A step finer that lasts for so many pictures was right.
const TRIAL: u32 = 80;
/// Patience never grows beyond this.
const MAX_PATIENCE: u32 = 2560;

/// Chooses the size of moving pictures by the time that they take.
#[derive(Debug)]
pub struct Governor {
    /// Index in [`STEPS`] of moving pictures.
    step: usize,
    /// Times of the last pictures of that step.
    moving: VecDeque<Duration>,
    /// Times of the last fine pictures of what stood still.
    standing: VecDeque<Duration>,
    /// They are of a worse tree than there is now.
    is_outdated: bool,
    /// Pictures in a row that would have been in time a step finer.
    promising: u32,
    patience: u32,
    /// Pictures since the last step finer.
    since_finer: Option<u32>,
}

impl Default for Governor {
    /// Knows nothing: the first moving picture is fine.
    fn default() -> Governor {
        Governor {
            step: 0,
            moving: VecDeque::new(),
            standing: VecDeque::new(),
            is_outdated: false,
            promising: 0,
            patience: PATIENCE,
            since_finer: None,
        }
    }
}

impl Governor {
    /// Window pixels for each picture pixel, each way, while something moves.
    #[must_use]
    pub fn pixel_size(&self) -> usize {
        STEPS[self.step]
    }

    /// Another scene or window: what was learned is void.
    pub fn forget(&mut self) {
        *self = Governor::default();
    }

    /// The same scene has a better tree: pictures are faster from now on, and mistakes were those of the worse one.
    pub fn improved(&mut self) {
        self.is_outdated = true;
        self.promising = 0;
        self.patience = PATIENCE;
        self.since_finer = None;
    }

    /// A fine picture of what stands still took `time`.
    pub fn stood(&mut self, time: Duration) {
        if std::mem::take(&mut self.is_outdated) {
            self.standing.clear();
        }
        remember(&mut self.standing, time);
    }

    /// Something begins to move, and each picture has `deadline` time: what stood still tells where to begin.
    pub fn begin(&mut self, deadline: Duration) {
        self.moving.clear();
        self.promising = 0;
        self.since_finer = None;
        let Some(fine) = self.standing.iter().min().copied() else {
            return;
        };
        self.step = if fine <= deadline {
            0
        } else {
            let promising = first_step(|to| scaled(fine, 1, to) <= deadline);
            self.step.max(promising)
        };
    }

    /// A moving picture of `pixel_size` took `time` where it had `deadline`. Pictures of another size than is
    /// asked for now were begun before the last decision, and do not count.
    pub fn moved(&mut self, pixel_size: usize, time: Duration, deadline: Duration) {
        if pixel_size != self.pixel_size() {
            return;
        }
        remember(&mut self.moving, time);
        self.since_finer = self.since_finer.map(|n| n + 1);
        if self.since_finer == Some(TRIAL) {
            // The last step finer was right: the next one need not wait longer.
            self.since_finer = None;
            self.patience = PATIENCE;
        }
        let best = self.moving.iter().min().copied().unwrap_or(time);
        if best > deadline {
            self.promising = 0;
            if self.moving.len() == MEMORY {
                self.coarser(best, deadline);
            }
        } else if self.step > 0 {
            self.finer(time, deadline);
        }
    }

    fn coarser(&mut self, best: Duration, deadline: Duration) {
        let to = first_step(|to| self.promised(best, to) <= deadline).max(self.step + 1);
        if to >= STEPS.len() {
            return self.set_step(STEPS.len() - 1);
        }
        // The last step finer was a mistake: the next one waits longer.
        if self.since_finer.take().is_some() {
            self.patience = (self.patience * 2).min(MAX_PATIENCE);
        }
        self.set_step(to);
    }

    fn finer(&mut self, time: Duration, deadline: Duration) {
        let finer = STEPS[self.step - 1];
        if self.promised(time, finer) > deadline.mul_f64(FINER_BELOW) {
            self.promising = 0;
            return;
        }
        self.promising += 1;
        if self.promising >= self.patience {
            self.since_finer = Some(0);
            self.set_step(self.step - 1);
        }
    }

    /// What a picture of pixels of size `to` takes, when one of now takes `time`. A part of the time does not depend
    /// on the pixels: how large that is, the fine picture of what stood still tells. Without that, it is nothing.
    fn promised(&self, time: Duration, to: usize) -> Duration {
        let from = self.pixel_size();
        let all = scaled(time, from, to);
        let fine = self.standing.iter().min().copied().unwrap_or_default();
        if from == 1 || fine <= time {
            return all;
        }
        let per_pixel = (fine - time).as_secs_f64() / (1.0 - share(from));
        let change_s = per_pixel * (share(to) - share(from));
        let part = (time.as_secs_f64() + change_s).max(0.0);
        let part = Duration::try_from_secs_f64(part).unwrap_or(all);
        // In proportion is the most that a finer picture can take, and the least that a coarser one can.
        if to < from {
            all.min(part)
        } else {
            all.max(part)
        }
    }

    fn set_step(&mut self, step: usize) {
        self.step = step;
        self.moving.clear();
        self.promising = 0;
    }
}

fn remember(times: &mut VecDeque<Duration>, time: Duration) {
    if times.len() == MEMORY {
        times.pop_front();
    }
    times.push_back(time);
}

/// What a picture of pixels of size `to` takes when one of size `from` takes `time`: as many times as long as it
/// has pixels.
fn scaled(time: Duration, from: usize, to: usize) -> Duration {
    time.mul_f64(share(to) / share(from))
}

/// The part of the fine picture's pixels that one with pixels of `size` has.
fn share(size: usize) -> f64 {
    1.0 / (size * size) as f64
}

/// The finest step whose pixel size is in time; the coarsest when none is.
fn first_step(in_time: impl Fn(usize) -> bool) -> usize {
    let found = STEPS.iter().position(|&to| in_time(to));
    found.unwrap_or(STEPS.len() - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    const DEADLINE: Duration = Duration::from_micros(16_667);

    fn ms(ms: f64) -> Duration {
        Duration::from_secs_f64(ms / 1e3)
    }

    /// Moves for `count` pictures on a scene whose fine pictures take `fine` and a part of which, `fixed`, does not
    /// shrink with the picture; returns the sizes.
    fn play(governor: &mut Governor, count: usize, fine: f64, fixed: f64) -> Vec<usize> {
        (0..count)
            .map(|i| {
                let size = governor.pixel_size();
                let noise = 1.0 + 0.1 * (i % 3) as f64;
                let time = fixed + (fine - fixed) / (size * size) as f64 * noise;
                governor.moved(size, ms(time), DEADLINE);
                size
            })
            .collect()
    }

    fn changes(sizes: &[usize]) -> usize {
        sizes.windows(2).filter(|w| w[0] != w[1]).count()
    }

    #[test]
    fn a_scene_that_is_fast_enough_stays_fine_whatever_holds_up_single_pictures() {
        let mut g = Governor::default();
        for i in 0..1000 {
            assert_eq!(g.pixel_size(), 1);
            // Every third picture meets another program; so do two in a row, now and then.
            let late = i % 3 == 0 || i % 50 == 1;
            g.moved(1, ms(if late { 300.0 } else { 9.0 }), DEADLINE);
        }
    }

    #[test]
    fn a_slow_scene_becomes_coarse_after_three_pictures_and_stays_so() {
        let mut g = Governor::default();
        let sizes = play(&mut g, 1000, 60.0, 0.0);
        assert_eq!(sizes[..4], [1, 1, 1, 2]);
        assert!(changes(&sizes) <= 1, "{sizes:?}");
    }

    #[test]
    fn what_does_not_shrink_with_the_picture_is_met_by_further_steps() {
        let mut g = Governor::default();
        let sizes = play(&mut g, 40, 100.0, 14.0);
        assert_eq!(sizes.last(), Some(&6));
        assert!(changes(&sizes) <= 4, "{sizes:?}");
    }

    #[test]
    fn the_fine_picture_tells_how_much_does_not_shrink() {
        let mut g = Governor::default();
        // A moment in which nothing helped, then a scene with 6 ms that no pixel size saves.
        play(&mut g, 20, 500.0, 400.0);
        assert_eq!(g.pixel_size(), 8);
        g.stood(ms(36.0));
        let sizes = play(&mut g, 400, 36.0, 6.0);
        assert_eq!(sizes.last(), Some(&3), "{sizes:?}");
        assert_eq!(changes(&sizes), 3);
    }

    #[test]
    fn a_scene_at_the_border_between_two_sizes_does_not_pump() {
        let mut g = Governor::default();
        // In time at every size but the finest; when coarse, it promises to be in time there too.
        let mut sizes = Vec::new();
        for _ in 0..5000 {
            let size = g.pixel_size();
            sizes.push(size);
            let time = if size == 1 { 17.5 } else { 2.0 };
            g.moved(size, ms(time), DEADLINE);
        }
        assert!(changes(&sizes) <= 20, "{} changes", changes(&sizes));
    }

    #[test]
    fn a_scene_that_becomes_fast_becomes_fine_again() {
        let mut g = Governor::default();
        play(&mut g, 50, 200.0, 0.0);
        assert_eq!(g.pixel_size(), 4);
        assert_eq!(play(&mut g, 200, 4.0, 0.0).last(), Some(&1));
    }

    #[test]
    fn what_stood_still_tells_where_a_move_begins() {
        let mut g = Governor::default();
        g.stood(ms(900.0));
        g.stood(ms(60.0));
        g.begin(DEADLINE);
        assert_eq!(g.pixel_size(), 2);
        g.stood(ms(10.0));
        g.begin(DEADLINE);
        assert_eq!(g.pixel_size(), 1);
        g.forget();
        g.begin(DEADLINE);
        assert_eq!(g.pixel_size(), 1);
    }

    #[test]
    fn a_better_tree_makes_finer_what_the_coarse_one_made_coarse() {
        let mut g = Governor::default();
        g.stood(ms(90.0));
        // Built beside the pictures: nothing is in time.
        play(&mut g, 60, 90.0, 40.0);
        assert_eq!(g.pixel_size(), 8);
        g.improved();
        g.stood(ms(18.0));
        let sizes = play(&mut g, 200, 18.0, 6.0);
        assert_eq!(sizes.last(), Some(&2), "{sizes:?}");
    }

    #[test]
    fn pictures_of_another_size_do_not_count() {
        let mut g = Governor::default();
        for _ in 0..9 {
            g.moved(2, ms(100.0), DEADLINE);
        }
        assert_eq!(g.pixel_size(), 1);
    }
}
