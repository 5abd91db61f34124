//! Which frame is due: plays, pauses, steps and seeks; told by its caller how much time went by.

use std::time::Duration;

/// What follows the last frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Order {
    /// Nothing: it stands on it.
    #[default]
    Once,
    /// The first frame.
    Loop,
    /// The frame before it, and so on back to the first; neither end is shown twice.
    PingPong,
    /// The second frame: the last one is the same picture as the first, so it takes its place.
    Cyclic,
}

impl Order {
    /// All of them, each the one that a key press shows after the one before.
    pub const ALL: [Order; 4] = [Order::Once, Order::Loop, Order::PingPong, Order::Cyclic];

    /// In words.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Order::Once => "once",
            Order::Loop => "loop",
            Order::PingPong => "ping-pong",
            Order::Cyclic => "cyclic",
        }
    }
}

/// Playing can be this many times slower or faster than told.
const SPEED_LIMIT: f64 = 64.0;

/// Plays, pauses and stops.
///
/// The frame shown lies `floor(elapsed · fps · speed)` frames from where playing began: a caller that is late skips frames,
/// and never slows down. Elapsed time is a sum of whole nanoseconds, so it does not matter how often it is told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Playback {
    fps: f64,
    last: u64,
    speed: f64,
    order: Order,
    /// The only frames that are played, both included.
    section: Option<(u64, u64)>,
    motion: Motion,
}

/// What a [`Playback`] is doing.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Motion {
    /// Stands at a frame; `returning` as before that.
    Standing { frame: u64, returning: bool },
    /// Left frame `from`, when `ahead` of a frame was already over, that long ago. It was told to play `backwards`, or
    /// not; `returning`, as ping-pong does, it went the other way.
    Playing {
        from: u64,
        backwards: bool,
        returning: bool,
        ahead: f64,
        elapsed: Duration,
    },
}

impl Playback {
    /// Stands on the still picture, the last frame; `fps`, above 0, is the speed that is told.
    #[must_use]
    pub fn new(fps: f64, last: u64) -> Playback {
        Playback {
            fps,
            last,
            speed: 1.0,
            order: Order::Once,
            section: None,
            motion: Motion::Standing {
                frame: last,
                returning: false,
            },
        }
    }

    /// The number of the frame to show.
    #[must_use]
    pub fn frame(&self) -> u64 {
        match self.motion {
            Motion::Standing { frame, .. } => frame,
            Motion::Playing {
                from,
                backwards,
                returning,
                ..
            } => self.frame_after(from, backwards != returning, self.frames_passed()),
        }
    }

    /// The number of the last frame.
    #[must_use]
    pub fn last_frame(&self) -> u64 {
        self.last
    }

    /// True while frames follow one another.
    #[must_use]
    pub fn is_playing(&self) -> bool {
        matches!(self.motion, Motion::Playing { .. })
    }

    /// True when it stands on the still picture, the last frame.
    #[must_use]
    pub fn is_at_end(&self) -> bool {
        matches!(self.motion, Motion::Standing { frame, .. } if frame == self.last)
    }

    /// What follows the last frame.
    #[must_use]
    pub fn order(&self) -> Order {
        self.order
    }

    /// How many times faster than told it plays.
    #[must_use]
    pub fn speed(&self) -> f64 {
        self.speed
    }

    /// The frames that are played, if not all.
    #[must_use]
    pub fn section(&self) -> Option<(u64, u64)> {
        self.section
    }

    /// There are more or fewer frames now. On the last one it stays on the last one.
    pub fn set_last(&mut self, last: u64) {
        if last == self.last {
            return;
        }
        let at_end = self.is_at_end();
        self.rebase();
        let frame = self.frame();
        self.last = last;
        self.section = self.section.filter(|&(_, b)| b <= last);
        if at_end {
            self.stop();
        } else if frame > last {
            self.seek(last);
        }
    }

    /// Plays on from the frame shown, in ping-pong the way that it went; on the end of that way, from its beginning.
    pub fn play(&mut self, backwards: bool) {
        let frame = self.frame();
        let (low, high) = self.ends();
        let returning = self.order == Order::PingPong && self.is_returning();
        let (start, _) = in_order((low, high), backwards);
        let (_, end) = in_order((low, high), backwards != returning);
        let is_over = frame == end || frame < low || frame > high;
        self.motion = Motion::Playing {
            from: if is_over { start } else { frame },
            backwards,
            returning: returning && !is_over,
            ahead: 0.0,
            elapsed: Duration::ZERO,
        };
    }

    /// Stands still on the frame shown and returns its number.
    pub fn pause(&mut self) -> u64 {
        let frame = self.frame();
        self.motion = Motion::Standing {
            frame,
            returning: self.is_returning(),
        };
        frame
    }

    /// Stands still on the last frame, the still picture.
    pub fn stop(&mut self) {
        self.motion = Motion::Standing {
            frame: self.last,
            returning: false,
        };
    }

    /// Goes to a frame, at most the last, and stands there; while playing it plays on from there, the way that it went.
    pub fn seek(&mut self, frame: u64) {
        self.rebase();
        let frame = frame.min(self.last);
        match &mut self.motion {
            Motion::Standing { frame: now, .. } => *now = frame,
            Motion::Playing { from, ahead, .. } => {
                *from = frame;
                *ahead = 0.0;
            }
        }
    }

    /// Stands on the frame that lies `frames` after the one shown (negative: before), within the ends.
    pub fn step(&mut self, frames: i64) {
        let frame = self.pause();
        self.seek(frame.saturating_add_signed(frames));
    }

    /// Goes on with another order.
    pub fn set_order(&mut self, order: Order) {
        self.rebase();
        self.order = order;
    }

    /// Plays `speed` times as fast as told from now on, kept within 1/64 to 64; the frame shown stays.
    pub fn set_speed(&mut self, speed: f64) {
        self.rebase();
        self.speed = speed.clamp(1.0 / SPEED_LIMIT, SPEED_LIMIT);
    }

    /// Plays only the frames of `section`, both ends included and in order, and played once they follow one another again
    /// and again; `None`: all.
    pub fn set_section(&mut self, section: Option<(u64, u64)>) {
        self.rebase();
        self.section = section.filter(|&(a, b)| a < b && b <= self.last);
    }

    /// Lets `dt` go by. True when this reached the end, where playing once ends.
    pub fn advance(&mut self, dt: Duration) -> bool {
        let ends = self.ends();
        let order = self.order_played();
        let Motion::Playing {
            elapsed,
            backwards,
            returning,
            ..
        } = &mut self.motion
        else {
            return false;
        };
        *elapsed = elapsed.saturating_add(dt);
        let (start, end) = in_order(ends, *backwards != *returning);
        let ended = (order == Order::Once || start == end) && self.frame() == end;
        if ended {
            self.pause();
        }
        ended
    }

    /// Time until the next frame is due; `None` when it stands.
    #[must_use]
    pub fn next_frame_in(&self) -> Option<Duration> {
        let Motion::Playing { ahead, elapsed, .. } = self.motion else {
            return None;
        };
        let due_s = ((self.frames_passed() + 1) as f64 - ahead) / (self.fps * self.speed);
        let due = Duration::try_from_secs_f64(due_s).unwrap_or(Duration::MAX);
        Some(due.saturating_sub(elapsed))
    }

    /// First and last frame that are played.
    fn ends(&self) -> (u64, u64) {
        self.section.unwrap_or((0, self.last))
    }

    /// What follows the last frame that is played: who marks a section wants to see it again and again.
    fn order_played(&self) -> Order {
        match self.order {
            Order::Once if self.section.is_some() => Order::Loop,
            order => order,
        }
    }

    fn frames_exact(&self) -> f64 {
        match self.motion {
            Motion::Standing { .. } => 0.0,
            Motion::Playing { ahead, elapsed, .. } => {
                ahead + elapsed.as_secs_f64() * self.fps * self.speed
            }
        }
    }

    fn frames_passed(&self) -> u64 {
        // The cast rounds down, and saturates where elapsed times are absurd.
        self.frames_exact() as u64
    }

    /// The frame `passed` frames after `from`.
    fn frame_after(&self, from: u64, backwards: bool, passed: u64) -> u64 {
        let (low, high) = self.ends();
        let len = high - low;
        let at = from.clamp(low, high) - low;
        let around = |period: u64| {
            let passed = passed % period;
            let at = at % period;
            if backwards {
                (at + period - passed) % period
            } else {
                (at + passed) % period
            }
        };
        low + match self.order_played() {
            _ if len == 0 => 0,
            Order::Once if backwards => at.saturating_sub(passed),
            Order::Once => at.saturating_add(passed).min(len),
            Order::Loop => around(len + 1),
            Order::Cyclic => around(len),
            Order::PingPong => {
                let period = 2 * len;
                let phase = if backwards { period - at } else { at };
                let phase = (phase % period + passed % period) % period;
                phase.min(period - phase)
            }
        }
    }

    /// Makes the frame shown the one that playing began at, so that the rules may change.
    fn rebase(&mut self) {
        let frame = self.frame();
        let exact = self.frames_exact();
        let is_returning = self.is_returning();
        if let Motion::Playing {
            from,
            returning,
            ahead,
            elapsed,
            ..
        } = &mut self.motion
        {
            *from = frame;
            *returning = is_returning;
            *ahead = exact - exact.floor();
            *elapsed = Duration::ZERO;
        }
    }

    /// True when it goes, or went before it stood, the other way than it was told to.
    fn is_returning(&self) -> bool {
        let (from, backwards, returning) = match self.motion {
            Motion::Standing { returning, .. } => return returning,
            Motion::Playing {
                from,
                backwards,
                returning,
                ..
            } => (from, backwards, returning),
        };
        let (low, high) = self.ends();
        if self.order != Order::PingPong || low == high {
            return returning;
        }
        let after = |passed| self.frame_after(from, backwards != returning, passed);
        let passed = self.frames_passed();
        let goes_down = after(passed.saturating_add(1)) < after(passed);
        goes_down != backwards
    }
}

/// The two ends, the one that is played first before the other.
fn in_order((low, high): (u64, u64), backwards: bool) -> (u64, u64) {
    if backwards { (high, low) } else { (low, high) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn s(seconds: f64) -> Duration {
        Duration::from_secs_f64(seconds)
    }

    /// 16 frames a second, 48 and the first.
    fn playing() -> Playback {
        let mut p = Playback::new(16.0, 48);
        p.play(false);
        p
    }

    /// One frame a second, frames 0 to 3: what is shown in the next 9 seconds.
    fn shown(order: Order, backwards: bool) -> Vec<u64> {
        let mut p = Playback::new(1.0, 3);
        p.set_order(order);
        p.play(backwards);
        let frame = |_| {
            let frame = p.frame();
            p.advance(s(1.0));
            frame
        };
        (0..9).map(frame).collect()
    }

    #[test]
    fn playback_opens_on_the_still_picture_and_plays_from_the_start() {
        let mut p = Playback::new(16.0, 48);
        assert_eq!(
            (p.frame(), p.is_playing(), p.is_at_end()),
            (48, false, true)
        );
        p.play(false);
        assert_eq!((p.frame(), p.is_playing()), (0, true));
        assert_eq!(p.next_frame_in(), Some(s(1.0 / 16.0)));
    }

    #[test]
    fn the_frame_follows_the_clock_and_not_the_calls() {
        let mut one = playing();
        let mut many = one;
        assert!(!one.advance(s(1.55)));
        for _ in 0..155 {
            assert!(!many.advance(s(0.01)));
        }
        assert_eq!(one, many);
        assert_eq!(one.frame(), 24);
    }

    #[test]
    fn playing_on_after_a_pause_starts_at_the_paused_frame() {
        let mut p = playing();
        p.advance(s(1.0));
        assert_eq!(p.pause(), 16);
        assert!(!p.advance(s(100.0)));
        assert_eq!(p.frame(), 16);
        p.play(false);
        assert_eq!(p.frame(), 16);
    }

    #[test]
    fn playback_ends_once_and_stands_on_the_still_picture() {
        let mut p = playing();
        assert!(p.advance(Duration::MAX));
        assert!(!p.advance(s(1.0)));
        assert_eq!((p.frame(), p.next_frame_in()), (48, None));
    }

    #[test]
    fn nothing_to_play_ends_at_once() {
        for order in Order::ALL {
            let mut p = Playback::new(16.0, 0);
            p.set_order(order);
            p.play(false);
            assert!(p.advance(Duration::ZERO));
            assert_eq!(p.frame(), 0);
        }
    }

    #[test]
    fn no_order_shows_a_frame_twice_in_a_row() {
        assert_eq!(shown(Order::Once, false), [0, 1, 2, 3, 3, 3, 3, 3, 3]);
        assert_eq!(shown(Order::Once, true), [3, 2, 1, 0, 0, 0, 0, 0, 0]);
        assert_eq!(shown(Order::Loop, false), [0, 1, 2, 3, 0, 1, 2, 3, 0]);
        assert_eq!(shown(Order::Loop, true), [3, 2, 1, 0, 3, 2, 1, 0, 3]);
        assert_eq!(shown(Order::PingPong, false), [0, 1, 2, 3, 2, 1, 0, 1, 2]);
        assert_eq!(shown(Order::PingPong, true), [3, 2, 1, 0, 1, 2, 3, 2, 1]);
        assert_eq!(shown(Order::Cyclic, false), [0, 1, 2, 0, 1, 2, 0, 1, 2]);
        // The last frame is the first: from it the way back goes on to the last but one.
        assert_eq!(shown(Order::Cyclic, true), [0, 2, 1, 0, 2, 1, 0, 2, 1]);
    }

    #[test]
    fn another_speed_and_order_keep_the_frame_and_the_direction() {
        let mut p = playing();
        p.advance(s(1.03));
        p.set_speed(2.0);
        assert_eq!(p.frame(), 16);
        // 1.03 s are 16.48 frames; at twice the speed 0.52 more take 16.25 ms.
        p.advance(s(0.0162));
        assert_eq!(p.frame(), 16);
        p.advance(s(0.0002));
        assert_eq!(p.frame(), 17);
        p.set_order(Order::PingPong);
        p.advance(s(1.5));
        p.set_order(Order::Once);
        p.advance(s(0.25));
        assert!(p.frame() < 40, "it was on the way back");
    }

    #[test]
    fn ping_pong_goes_on_the_way_it_went_after_a_pause_and_a_seek() {
        for (backwards, frames) in [(false, [3, 2, 1]), (true, [0, 1, 2])] {
            let mut p = Playback::new(1.0, 3);
            p.set_order(Order::PingPong);
            p.play(backwards);
            p.advance(s(4.0));
            assert_eq!(p.pause(), frames[1], "on the way back");
            p.play(backwards);
            p.advance(s(1.0));
            assert_eq!(p.frame(), frames[2]);
            p.seek(frames[1]);
            p.advance(s(1.0));
            assert_eq!(p.frame(), frames[2]);
            // The other way of playing turns it round.
            p.pause();
            p.play(!backwards);
            p.advance(s(1.0));
            assert_eq!(p.frame(), frames[1]);
            // From the end of the way it begins anew.
            p.pause();
            p.seek(3 - frames[0]);
            p.play(backwards);
            assert_eq!(p.frame(), 3 - frames[0]);
            p.advance(s(1.0));
            assert_eq!(p.frame(), frames[0].abs_diff(2));
        }
    }

    #[test]
    fn a_section_is_played_alone_again_and_again_until_it_is_dropped() {
        let mut p = playing();
        p.set_section(Some((16, 20)));
        for _ in 0..50 {
            p.advance(s(0.06));
            assert!((16..=20).contains(&p.frame()), "{}", p.frame());
        }
        p.set_section(None);
        p.advance(s(9.0));
        assert_eq!(p.frame(), 48);
    }

    #[test]
    fn steps_and_seeks_stay_within_the_ends() {
        let mut p = Playback::new(16.0, 48);
        p.step(1);
        assert_eq!(p.frame(), 48);
        p.step(-50);
        assert_eq!(p.frame(), 0);
        p.step(3);
        p.seek(99);
        assert_eq!(p.frame(), 48);
    }

    #[test]
    fn more_frames_keep_the_still_picture_the_last_one() {
        let mut p = Playback::new(16.0, 48);
        p.set_last(64);
        assert_eq!(p.frame(), 64);
        p.seek(50);
        p.set_last(32);
        assert_eq!(p.frame(), 32);
    }

    #[test]
    fn more_frames_change_nothing_of_the_one_that_is_shown() {
        let mut p = playing();
        p.set_order(Order::Loop);
        p.advance(s(11.0));
        let shown = p.frame();
        p.set_last(64);
        assert_eq!(p.frame(), shown);
    }
}
