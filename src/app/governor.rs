//! The deadline governor: how coarse a picture may be while something moves, so that it is never late.
//!
//! Plain data: it is told how long pictures took and says how many pixels of the window's width and height one
//! pixel of the picture may stand for. What stands still is always fine. Noise only ever adds to a time, so the
//! shortest of the last few counts: one picture held up by another program changes nothing. Coarser is decided after
//! five late pictures, finer only after many pictures that would have been in time, and after each failed attempt it waits
//! longer: no pumping. Where fine pictures have been in time, many late ones must come in a row: something else wants the
//! processor, and coarser pictures would not help.
//!
//! A picture of a quarter of the pixels takes more than a quarter of the time, on large scenes much more: the tree has
//! to be searched all the same. So what a step saves is learned from each step that is taken, and a step that saves
//! next to nothing is not worth its pixels: it is taken back, and not taken again.

use std::collections::VecDeque;
use std::time::Duration;

/// Pixels of the window, each way, that one pixel of a picture stands for. In order. The last is for millions of
/// triangles on two cores: what a hand does must still be seen in time.
const STEPS: [usize; 7] = [1, 2, 3, 4, 6, 8, 12];
/// Times of this many pictures count.
const MEMORY: usize = 5;
/// And of so many where fine pictures have been in time: something else holds them up, and it will pass.
const LONG_MEMORY: usize = 20;
/// A step finer must promise to stay below this part of the deadline.
const FINER_BELOW: f64 = 0.85;
/// Pictures in a row that must promise so.
const PATIENCE: u32 = 30;
/// A step finer that lasts for so many pictures was right.
const TRIAL: u32 = 80;
/// Patience never grows beyond this.
const MAX_PATIENCE: u32 = 2560;
/// Steps that make pictures less than so many times as fast are not worth it.
const WORTH: f64 = 1.1;
/// Fewer pixels never make a picture slower; a gain of nothing could not be scaled by what is learned.
const LEAST_GAIN: f64 = 1.01;

/// Chooses the size of moving pictures by the time that they take.
#[derive(Debug)]
pub struct Governor {
    /// Index in [`STEPS`] of moving pictures.
    step: usize,
    /// Times of the last pictures of that step.
    moving: VecDeque<Duration>,
    /// The step before, and what its last pictures took.
    left: Option<(usize, Duration)>,
    /// How many times as long as those of the next step the pictures of a step take.
    gains: [f64; STEPS.len() - 1],
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
            left: None,
            gains: std::array::from_fn(expected_gain),
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
        self.left = None;
    }

    /// A fine picture of what stands still took `time`.
    pub fn stood(&mut self, time: Duration) {
        if std::mem::take(&mut self.is_outdated) {
            self.standing.clear();
        }
        remember(&mut self.standing, time, MEMORY);
    }

    /// Something begins to move, and each picture has `deadline` time: what stood still tells where to begin.
    pub fn begin(&mut self, deadline: Duration) {
        self.moving.clear();
        self.left = None;
        self.promising = 0;
        self.since_finer = None;
        // Another part of the scene may be seen now: half of what was learned of the steps is kept.
        for (i, gain) in self.gains.iter_mut().enumerate() {
            *gain = (*gain + expected_gain(i)) / 2.0;
        }
        let Some(fine) = self.standing_time() else {
            return;
        };
        self.step = if fine <= deadline {
            0
        } else {
            self.step.max(self.best_step(0, fine, deadline))
        };
    }

    /// A moving picture of `pixel_size` took `time` where it had `deadline`. Pictures of another size than is
    /// asked for now were begun before the last decision, and do not count.
    pub fn moved(&mut self, pixel_size: usize, time: Duration, deadline: Duration) {
        if pixel_size != self.pixel_size() {
            return;
        }
        remember(&mut self.moving, time, LONG_MEMORY);
        self.since_finer = self.since_finer.map(|n| n + 1);
        if self.since_finer == Some(TRIAL) {
            // The last step finer was right: the next one need not wait longer.
            self.since_finer = None;
            self.patience = PATIENCE;
        }
        let best = self.best(MEMORY).unwrap_or(time);
        let is_known = self.moving.len() >= MEMORY;
        if is_known {
            self.learn(best);
        }
        let is_fast = self.step == 0
            && self.since_finer.is_none()
            && self.standing_time().is_some_and(|t| t <= deadline);
        let patience = if is_fast { LONG_MEMORY } else { MEMORY };
        let is_late = self.moving.len() >= patience && self.best(patience) > Some(deadline);
        if !(is_late && self.coarser(best, deadline)) && self.step > 0 {
            self.finer(best, deadline);
        }
    }

    /// What a fine picture takes, as far as those tell that stood still. The first of all, which nothing was ready for,
    /// took about twice as long as others will.
    fn standing_time(&self) -> Option<Duration> {
        let best = self.standing.iter().min().copied()?;
        Some(if self.standing.len() == 1 {
            best / 2
        } else {
            best
        })
    }

    /// The shortest of the last `count` times of this step.
    fn best(&self, count: usize) -> Option<Duration> {
        self.moving.iter().rev().take(count).min().copied()
    }

    /// The first pictures of this step took `time`: what the step from the one before has brought is known.
    fn learn(&mut self, time: Duration) {
        let Some((before, time_before)) = self.left.take() else {
            return;
        };
        let (finer, coarser) = (before.min(self.step), before.max(self.step));
        let factor = time_before.as_secs_f64() / time.as_secs_f64().max(1e-6);
        let gain = if before < self.step {
            factor
        } else {
            1.0 / factor
        };
        // Over several steps at once, each has its part of that.
        let promised: f64 = self.gains[finer..coarser].iter().product();
        let power = gain.max(LEAST_GAIN).ln() / promised.ln();
        for (i, gain) in self.gains[finer..coarser].iter_mut().enumerate() {
            let pixels = expected_gain(finer + i).powi(2);
            *gain = gain.powf(power).clamp(LEAST_GAIN, pixels);
        }
    }

    /// Pictures of the current step, which take `time`, are late. True when there is a step that helps.
    fn coarser(&mut self, time: Duration, deadline: Duration) -> bool {
        let to = self.best_step(self.step, time, deadline);
        if to == self.step {
            return false;
        }
        // The last step finer was a mistake: the next one waits longer.
        if self.since_finer.take().is_some() {
            self.patience = (self.patience * 2).min(MAX_PATIENCE);
        }
        self.set_step(to, time);
        true
    }

    /// Pictures of the current step take `time`, and the next finer ones may do.
    fn finer(&mut self, time: Duration, deadline: Duration) {
        let gain = self.gains[self.step - 1];
        let promised = time.mul_f64(gain);
        if gain >= WORTH && promised > deadline.mul_f64(FINER_BELOW) {
            self.promising = 0;
            return;
        }
        self.promising += 1;
        if self.promising >= self.patience {
            self.since_finer = Some(0);
            self.set_step(self.step - 1, time);
        }
    }

    /// The finest step, none finer than `from`, that promises to be in time where a picture of `from` takes `time`. When
    /// none is, the coarsest that is worth it.
    fn best_step(&self, from: usize, time: Duration, deadline: Duration) -> usize {
        let mut promised = time;
        let mut best = (from, time);
        for step in from..STEPS.len() {
            if promised.mul_f64(WORTH) <= best.1 {
                best = (step, promised);
            }
            if promised <= deadline {
                return step;
            }
            if let Some(gain) = self.gains.get(step) {
                promised = promised.div_f64(*gain);
            }
        }
        best.0
    }

    fn set_step(&mut self, step: usize, time: Duration) {
        self.left = Some((self.step, time));
        self.step = step;
        self.moving.clear();
        self.promising = 0;
    }
}

fn remember(times: &mut VecDeque<Duration>, time: Duration, count: usize) {
    if times.len() == count {
        times.pop_front();
    }
    times.push_back(time);
}

/// What the step after `step` brings on most scenes: half of the pixels' width makes a picture twice as slow,
/// where four times as many pixels would make it four times as slow.
fn expected_gain(step: usize) -> f64 {
    STEPS[step + 1] as f64 / STEPS[step] as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    const DEADLINE: Duration = Duration::from_micros(16_667);

    /// What pictures of the sizes in [`STEPS`] took, in ms for a window of 1920x1080: a scene whose time shrinks with the
    /// pixels, one of single triangles, and two large ones, where most of the time goes into the search. The best of
    /// three runs of `raybomb bench SCENE --workload shaded --threads 1 --size WxH` on an Intel with AVX-512.
    const LANDSCAPE_100K: [f64; STEPS.len()] = [8.8, 5.0, 3.2, 2.8, 2.1, 1.8, 1.5];
    const SOUP_200K: [f64; STEPS.len()] = [17.8, 7.9, 6.2, 6.6, 4.7, 2.9, 2.3];
    const SPHEREGRID_1M: [f64; STEPS.len()] = [25.3, 16.3, 13.8, 12.3, 9.0, 6.7, 4.3];
    const LANDSCAPE_2M: [f64; STEPS.len()] = [32.6, 21.4, 18.7, 16.9, 12.9, 10.5, 6.4];

    fn ms(ms: f64) -> Duration {
        Duration::from_secs_f64(ms / 1e3)
    }

    /// Moves for `count` pictures, the `i`-th of which takes `time(i, step)` ms; returns the sizes.
    fn play(
        governor: &mut Governor,
        count: usize,
        deadline: Duration,
        time: impl Fn(usize, usize) -> f64,
    ) -> Vec<usize> {
        (0..count)
            .map(|i| {
                let size = governor.pixel_size();
                let time = time(i, governor.step);
                governor.moved(size, ms(time), deadline);
                size
            })
            .collect()
    }

    /// The times of `scene`, up to a fifth longer now and then.
    fn of(scene: [f64; STEPS.len()]) -> impl Fn(usize, usize) -> f64 {
        move |i, step| scene[step] * (1.0 + 0.1 * (i % 3) as f64)
    }

    /// A scene whose fine pictures take `fine`, `fixed` of which does not shrink with the picture.
    fn affine(fine: f64, fixed: f64) -> impl Fn(usize, usize) -> f64 {
        of(STEPS.map(|size| fixed + (fine - fixed) / (size * size) as f64))
    }

    fn changes(sizes: &[usize]) -> usize {
        sizes.windows(2).filter(|w| w[0] != w[1]).count()
    }

    #[test]
    fn a_scene_that_is_fast_enough_stays_fine_whatever_holds_up_single_pictures() {
        let mut g = Governor::default();
        // Every third picture meets another program; so do two in a row, now and then.
        let time = |i: usize, _| {
            if i.is_multiple_of(3) || i % 50 == 1 {
                300.0
            } else {
                9.0
            }
        };
        assert_eq!(play(&mut g, 1000, DEADLINE, time), [1; 1000]);
        // Known to be fast: half of the time another program has the processor.
        g.stood(ms(18.0));
        let time = |i: usize, _| if i % 30 < 15 { 300.0 } else { 9.0 };
        assert_eq!(play(&mut g, 1000, DEADLINE, time), [1; 1000]);
    }

    #[test]
    fn pictures_that_are_held_up_now_and_then_become_fine_again() {
        let mut g = Governor::default();
        g.stood(ms(40.0));
        g.begin(DEADLINE);
        assert_eq!(g.pixel_size(), 2);
        let time = |i: usize, step: usize| {
            if i.is_multiple_of(4) {
                300.0
            } else {
                [9.0, 5.0][step]
            }
        };
        assert_eq!(play(&mut g, 100, DEADLINE, time).last(), Some(&1));
    }

    #[test]
    fn a_slow_scene_becomes_coarse_after_five_pictures_and_stays_so() {
        let mut g = Governor::default();
        let sizes = play(&mut g, 1000, DEADLINE, affine(60.0, 10.0));
        assert_eq!(sizes[..6], [1, 1, 1, 1, 1, 4]);
        assert!(changes(&sizes) <= 3, "{sizes:?}");
    }

    #[test]
    fn large_scenes_find_their_size_and_keep_it() {
        for (scene, deadline, size) in [
            (LANDSCAPE_100K, 10.0, 1),
            (LANDSCAPE_100K, 7.0, 2),
            (SOUP_200K, 10.0, 2),
            (SOUP_200K, 7.5, 3),
            (SPHEREGRID_1M, 14.5, 3),
            (SPHEREGRID_1M, 8.3, 8),
            (LANDSCAPE_2M, 14.0, 6),
            (LANDSCAPE_2M, 8.3, 12),
        ] {
            let mut g = Governor::default();
            g.stood(ms(2.0 * scene[0]));
            g.begin(ms(deadline));
            let sizes = play(&mut g, 6000, ms(deadline), of(scene));
            let last = &sizes[5000..];
            let here = last.iter().filter(|&&s| s == size).count();
            assert!(
                here >= 950,
                "{here} of {scene:?} in {deadline} ms, at the end size {:?}",
                sizes.last()
            );
            assert!(
                changes(&sizes) <= 24,
                "{}: {scene:?}, {deadline} ms",
                changes(&sizes)
            );
            let late = sizes.iter().enumerate().filter(|(i, s)| {
                let step = STEPS.iter().position(|of| of == *s).expect("a step");
                of(scene)(*i, step).min(scene[step]) > deadline
            });
            assert!(late.count() <= 60, "{scene:?}, {deadline} ms");
        }
    }

    #[test]
    fn a_step_that_saves_nothing_is_taken_back() {
        let mut g = Governor::default();
        // Late at any size: two steps help a little, the others do not.
        let scene = [40.0, 30.0, 25.0, 25.0, 25.0, 24.5, 24.5];
        let sizes = play(&mut g, 4000, DEADLINE, of(scene));
        let coarse = sizes[2000..].iter().filter(|&&s| s > 3).count();
        assert!(coarse < 500, "{coarse} pictures in vain");
        assert!(sizes[2000..].iter().all(|&s| s >= 2));
    }

    #[test]
    fn a_turn_past_a_heavy_part_of_the_scene_is_followed_there_and_back() {
        let mut g = Governor::default();
        // Six seconds each way.
        let heavy = |i: usize| 1.0 + (i as f64 / 100.0).sin();
        let sizes = play(&mut g, 3600, DEADLINE, |i, step| SOUP_200K[step] * heavy(i));
        let fine = |range: std::ops::Range<usize>| sizes[range].iter().min().copied();
        assert_eq!(fine(440..500), Some(1), "the light part");
        assert!(fine(780..800) > Some(1), "the heavy part");
        assert!(changes(&sizes) <= 50, "{}", changes(&sizes));
    }

    #[test]
    fn a_scene_at_the_border_between_two_sizes_does_not_pump() {
        let mut g = Governor::default();
        // In time at every size but the finest; when coarse, it promises to be in time there too.
        let time = |_, step| if step == 0 { 17.5 } else { 2.0 };
        let sizes = play(&mut g, 5000, DEADLINE, time);
        assert!(changes(&sizes) <= 20, "{} changes", changes(&sizes));
    }

    #[test]
    fn a_scene_that_becomes_fast_becomes_fine_again() {
        let mut g = Governor::default();
        play(&mut g, 50, DEADLINE, affine(200.0, 0.0));
        assert!(g.pixel_size() > 2);
        let sizes = play(&mut g, 300, DEADLINE, affine(4.0, 0.0));
        assert_eq!(sizes.last(), Some(&1));
    }

    #[test]
    fn what_stood_still_tells_where_a_move_begins() {
        let mut g = Governor::default();
        g.stood(ms(900.0));
        g.stood(ms(30.0));
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
        play(&mut g, 60, DEADLINE, affine(90.0, 40.0));
        assert!(g.pixel_size() > 2);
        g.improved();
        let sizes = play(&mut g, 300, DEADLINE, affine(18.0, 6.0));
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
