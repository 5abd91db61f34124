//! Which picture to order now, and how fine: the rhythm of the window. Plain data; time enters as a value.
//!
//! Pictures follow one another at the screen's rate at most, by our own clock: presenting on X11 waits for nothing. Those
//! that a hand asks for may come twice as often, so that it waits for less than a refresh. Where the window system
//! tells when it takes the next one (Wayland), that is the clock.
//! While something moves the [`Governor`] says how coarse; when the wish has stood for a moment, or the hand has let
//! go, the fine picture follows, and then its refinement.

use std::time::{Duration, Instant};

use super::governor::Governor;
use super::latency::{Latencies, Tally};
use super::painter::{Order, Picture};
use super::state::Wish;
use crate::render::Samples;

/// A wish that has not changed for so long stands still. The fine picture has the rest of 150 ms.
const QUIET: Duration = Duration::from_millis(70);
/// The part of a refresh that a picture may take while a hand moves. What the hand does just after a picture was begun
/// waits for that one and for the next: both together should not take much more than a refresh.
const HAND_PART: f64 = 0.5;

/// What the window knows about the moment.
#[derive(Clone, Copy, Debug)]
pub struct Moment {
    /// When it is.
    pub at: Instant,
    /// The shortest time between two pictures.
    pub interval: Duration,
    /// The window system tells when it takes the next picture: nobody asks for one before.
    pub told_when: bool,
    /// A key that turns the camera is held.
    pub turning: bool,
    /// The animation plays, and each frame is shown for so long.
    pub frame_time: Option<Duration>,
    /// Somebody waits for a fine picture.
    pub must_be_fine: bool,
}

/// What to do.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Step {
    /// Order this.
    pub order: Option<Order>,
    /// Ask again at that time, whatever happens.
    pub wake: Option<Instant>,
}

/// Decides what is ordered when.
#[derive(Debug)]
pub struct Pace {
    target: Duration,
    samples: Samples,
    governor: Governor,
    /// Pictures are of this scene.
    scene: u64,
    sent: Option<(Order, Instant)>,
    /// There is a picture of this that nothing better follows.
    finest: Option<Wish>,
    /// What failed last, and was ordered once more.
    failed: Option<Wish>,
    /// When the wish last changed.
    changed: Option<Instant>,
    /// When a hand last did something.
    hand: Option<Instant>,
    /// The hand has let go since the last order.
    released: bool,
    moving: bool,
    /// What a moving picture may take.
    deadline: Duration,
    /// The first input that no order has answered.
    asked: Option<Instant>,
    /// When a hand last asked for something, a hand that let go too.
    input: Option<Instant>,
    /// From then until the newest picture in full resolution was shown.
    fine_after: Option<Duration>,
    /// From input to picture.
    pub latencies: Latencies,
    /// The same of all pictures since the last report.
    tally: Tally,
}

impl Pace {
    /// So many pictures a second while something moves, so many samples a pixel when nothing does.
    #[must_use]
    pub fn new(target_fps: f64, samples: Samples) -> Pace {
        let target = Duration::try_from_secs_f64(1.0 / target_fps).unwrap_or(Duration::MAX);
        Pace {
            target,
            samples,
            governor: Governor::default(),
            scene: 0,
            sent: None,
            finest: None,
            failed: None,
            changed: None,
            hand: None,
            released: false,
            moving: false,
            deadline: target,
            asked: None,
            input: None,
            fine_after: None,
            latencies: Latencies::default(),
            tally: Tally::default(),
        }
    }

    /// A hand did something that may change the picture.
    pub fn input(&mut self, at: Instant) {
        self.asked.get_or_insert(at);
        self.hand = Some(at);
        self.input = Some(at);
    }

    /// The hand let go: what it leaves stands still.
    pub fn let_go(&mut self) {
        self.changed = None;
        self.hand = None;
        self.released = true;
    }

    /// Another scene: nothing is ordered, nothing learned.
    pub fn forget(&mut self) {
        self.scene += 1;
        self.sent = None;
        self.finest = None;
        self.changed = None;
        self.governor.forget();
    }

    /// The scene has a better tree. What stands is ordered once more, to learn what it takes now; if that
    /// `looks_different`, pictures of the worse one are not shown any more.
    pub fn improved(&mut self, looks_different: bool) {
        self.governor.improved();
        self.sent = None;
        if looks_different {
            self.scene += 1;
            self.finest = None;
        }
    }

    /// Nothing is rendered any more. When somebody asks again, what is wanted is ordered as if it had never been.
    pub fn rest(&mut self) {
        self.sent = None;
    }

    /// True for pictures of the scene that is open; others were begun before.
    #[must_use]
    pub fn is_of_scene(&self, picture: &Picture) -> bool {
        picture.order.scene == self.scene
    }

    /// True for a picture that nothing better follows, unless the wish changes.
    #[must_use]
    pub fn is_finest(&self, picture: &Picture) -> bool {
        self.is_of_scene(picture)
            && picture.order.pixel_size == 1
            && picture.samples == self.samples_of(&picture.order.wish)
    }

    /// Samples a pixel when nothing moves. Slow engines have one.
    #[must_use]
    pub fn samples_of(&self, wish: &Wish) -> Samples {
        if wish.has_fast_side() {
            self.samples
        } else {
            Samples::ONE
        }
    }

    /// What `wish` asks for at this moment.
    pub fn step(&mut self, wish: Wish, now: &Moment) -> Step {
        let sent = self.sent;
        let is_new = sent.is_none_or(|(order, _)| order.wish != wish);
        if is_new && sent.is_some() && !self.released {
            self.changed = Some(now.at);
        }
        let quiet_at = self.changed.and_then(|at| at.checked_add(QUIET));
        let settling = quiet_at.filter(|&at| now.at < at);
        let moving = now.turning || now.frame_time.is_some() || settling.is_some();
        if moving && !self.moving {
            self.deadline = self.deadline_of(now);
            self.governor.begin(self.deadline);
        }
        self.moving = moving;
        self.deadline = self.deadline_of(now);
        let order = self.ordered(wish, moving, now.must_be_fine);
        let Some((last, at)) = sent else {
            return self.send(order, now.at);
        };
        if is_new {
            // What a hand does is answered at up to twice the screen's rate: it would wait for half a picture
            // on average, and the picture shown next would be old by as much.
            // Where the window system keeps the screen's rate, ours would only get out of step with it.
            let due = match self.asked.is_some() || now.told_when {
                true => at + now.interval / 2,
                false => at + now.interval,
            };
            if now.at < due {
                return Step {
                    order: None,
                    wake: Some(due),
                };
            }
            return self.send(order, now.at);
        }
        self.asked = None;
        let is_finer = order.pixel_size < last.pixel_size || order.samples > last.samples;
        if is_finer && (!moving || now.must_be_fine) {
            return self.send(order, now.at);
        }
        Step {
            order: None,
            wake: settling,
        }
    }

    fn ordered(&self, wish: Wish, moving: bool, must_be_fine: bool) -> Order {
        Order {
            scene: self.scene,
            wish,
            pixel_size: match moving && !must_be_fine {
                true => self.governor.pixel_size(),
                false => 1,
            },
            // What is there already is ordered once more to learn what it takes.
            samples: if moving || self.finest == Some(wish) {
                Samples::ONE
            } else {
                self.samples_of(&wish)
            },
            moving,
            asked: None,
        }
    }

    fn send(&mut self, order: Order, at: Instant) -> Step {
        let asked = self.asked.take();
        let order = Order { asked, ..order };
        self.sent = Some((order, at));
        self.released = false;
        Step {
            order: Some(order),
            wake: self.changed.and_then(|changed| changed.checked_add(QUIET)),
        }
    }

    /// A frame that plays is not late before the next one is due; a hand waits for two pictures.
    fn deadline_of(&self, now: &Moment) -> Duration {
        let hand = self.hand.is_some_and(|at| now.at < at + QUIET);
        match now.frame_time {
            _ if hand => self.target.mul_f64(HAND_PART),
            Some(time) if !now.turning => time.max(self.target),
            _ => self.target,
        }
    }

    /// A picture failed. What is wanted is ordered once more; when it fails again, it is given up until the wish changes.
    pub fn failed(&mut self) {
        let wish = self.sent.map(|(order, _)| order.wish);
        if wish != self.failed {
            self.failed = wish;
            self.sent = None;
        }
    }

    /// A picture came; showing one takes `present`.
    pub fn took(&mut self, picture: &Picture, present: Duration) {
        let wish = picture.order.wish;
        if self.is_finest(picture) {
            self.finest = Some(wish);
        } else if self.finest != Some(wish) {
            self.finest = None;
        }
        let time = picture.stats.total + present;
        if picture.order.moving {
            self.governor
                .moved(picture.order.pixel_size, time, self.deadline);
        } else if picture.samples == Samples::ONE {
            self.governor.stood(time);
        }
    }

    /// The picture was shown.
    pub fn shown(&mut self, picture: &Picture, at: Instant) {
        let (asked, pixel_size) = (picture.order.asked, picture.order.pixel_size);
        if let Some(asked) = asked {
            self.latencies.count(at.saturating_duration_since(asked));
            self.tally.count(asked, at, pixel_size, self.target);
        }
        if pixel_size == 1 && picture.samples == Samples::ONE {
            self.fine_after = self.input.map(|input| at.saturating_duration_since(input));
        }
    }

    /// What a hand asked for since the last call, and how long after its end the picture stood in full resolution,
    /// when it has moved.
    pub fn take_tally(&mut self) -> (Tally, Option<Duration>) {
        self.input = None;
        (std::mem::take(&mut self.tally), self.fine_after.take())
    }
}

#[cfg(test)]
mod tests;
