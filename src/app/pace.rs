//! Which picture to order now, and how fine: the rhythm of the window. Plain data; time enters as a value.
//!
//! Pictures follow one another at the screen's rate at most, by our own clock: presenting on X11 waits for nothing. Those
//! that a hand asks for may come twice as often, so that it waits for less than a refresh.
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
const HAND_PART: f64 = 0.55;

/// What the window knows about the moment.
#[derive(Clone, Copy, Debug)]
pub struct Moment {
    /// When it is.
    pub at: Instant,
    /// The shortest time between two pictures.
    pub interval: Duration,
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
        self.changed = None;
        self.governor.forget();
    }

    /// The scene has a better tree. What stands is ordered once more, to learn what it takes now; if that
    /// `looks_different`, pictures of the worse one are not shown any more.
    pub fn improved(&mut self, looks_different: bool) {
        self.governor.improved();
        self.sent = None;
        self.scene += u64::from(looks_different);
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
            let due = match self.asked {
                Some(_) => at + now.interval / 2,
                None => at + now.interval,
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
            samples: if moving {
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
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::frame::Frame;
    use crate::geometry::Aabb;
    use crate::render::{RenderStats, Settings};

    const INTERVAL: Duration = Duration::from_micros(16_667);

    fn wish(width: usize) -> Wish {
        Wish {
            view: Camera::default_for(Aabb::EMPTY).view(width, 8, false),
            settings: Settings::default(),
            split: None,
        }
    }

    fn moment(start: Instant, ms: u64) -> Moment {
        Moment {
            at: start + Duration::from_millis(ms),
            interval: INTERVAL,
            turning: false,
            frame_time: None,
            must_be_fine: false,
        }
    }

    fn pace() -> (Pace, Instant) {
        let samples = Samples::new(16).expect("a count");
        (Pace::new(60.0, samples), Instant::now())
    }

    /// The picture of `order`, which took `ms`.
    fn picture(order: &Order, ms: u64) -> Picture {
        Picture {
            frame: Frame::default(),
            order: *order,
            samples: Samples::ONE,
            stats: RenderStats {
                total: Duration::from_millis(ms),
                ..RenderStats::default()
            },
            side_times: [Duration::ZERO; 2],
        }
    }

    #[test]
    fn what_stands_is_ordered_once_and_with_all_samples() {
        let (mut pace, start) = pace();
        let first = pace.step(wish(1), &moment(start, 0));
        let order = first.order.expect("the first");
        assert_eq!((order.samples.count(), order.pixel_size), (16, 1));
        for ms in [1, 100, 10_000] {
            assert_eq!(pace.step(wish(1), &moment(start, ms)), Step::default());
        }
    }

    #[test]
    fn what_fails_is_ordered_once_more_and_then_given_up() {
        let (mut pace, start) = pace();
        let ordered = |pace: &mut Pace, wish, ms| pace.step(wish, &moment(start, ms)).order;
        for (width, from) in [(1, 0), (2, 1000)] {
            assert!(ordered(&mut pace, wish(width), from).is_some());
            pace.failed();
            let again = ordered(&mut pace, wish(width), from + 1);
            assert!(again.is_some_and(|order| order.wish == wish(width)));
            pace.failed();
            assert_eq!(ordered(&mut pace, wish(width), from + 2), None);
        }
    }

    #[test]
    fn pictures_follow_at_the_screens_rate_and_the_newest_wish_counts() {
        let (mut pace, start) = pace();
        pace.step(wish(1), &moment(start, 0));
        let early = pace.step(wish(2), &moment(start, 5));
        assert_eq!(early.order, None);
        assert_eq!(early.wake, Some(start + INTERVAL));
        let step = pace.step(wish(3), &moment(start, 17));
        assert_eq!(step.order.expect("in time").wish, wish(3));
    }

    #[test]
    fn what_a_hand_asks_for_waits_for_half_of_a_refresh_at_most() {
        let (mut pace, start) = pace();
        pace.step(wish(1), &moment(start, 0));
        pace.input(start + Duration::from_millis(2));
        let early = pace.step(wish(2), &moment(start, 3));
        assert_eq!(
            (early.order, early.wake),
            (None, Some(start + INTERVAL / 2))
        );
        let step = pace.step(wish(3), &moment(start, 9));
        assert_eq!(step.order.expect("in time").wish, wish(3));
        // What moves by itself keeps the screen's rate.
        assert_eq!(pace.step(wish(4), &moment(start, 20)).order, None);
    }

    /// Moves a slow scene until its pictures are coarse; the last wish is `wish(99)`, at 1000 ms.
    fn coarse(pace: &mut Pace, start: Instant) {
        let order = pace.step(wish(1), &moment(start, 0)).order;
        pace.took(&picture(&order.expect("the first"), 80), Duration::ZERO);
        let step = pace.step(wish(99), &moment(start, 1000));
        let order = step.order.expect("another wish");
        assert_eq!((order.pixel_size, order.moving), (3, true));
        assert_eq!(order.samples, Samples::ONE);
    }

    #[test]
    fn the_fine_picture_follows_when_the_wish_has_stood_for_a_moment() {
        let (mut pace, start) = pace();
        coarse(&mut pace, start);
        let step = pace.step(wish(99), &moment(start, 1010));
        assert_eq!(
            (step.order, step.wake),
            (None, Some(start + Duration::from_millis(1070)))
        );
        let fine = pace.step(wish(99), &moment(start, 1070)).order;
        let fine = fine.expect("the fine one");
        assert_eq!(
            (fine.pixel_size, fine.samples.count(), fine.moving),
            (1, 16, false)
        );
        assert_eq!(pace.step(wish(99), &moment(start, 1071)), Step::default());
    }

    #[test]
    fn the_fine_picture_follows_at_once_when_the_hand_lets_go() {
        let (mut pace, start) = pace();
        coarse(&mut pace, start);
        pace.let_go();
        let fine = pace.step(wish(99), &moment(start, 1002)).order;
        assert_eq!(fine.expect("the fine one").pixel_size, 1);
        // The last way of the hand and its end in one go.
        coarse(&mut pace, start + Duration::from_secs(5));
        pace.let_go();
        let fine = pace.step(wish(98), &moment(start, 6030)).order;
        assert_eq!(fine.expect("the fine one").pixel_size, 1);
    }

    #[test]
    fn what_turns_without_a_hand_stays_coarse() {
        let (mut pace, start) = pace();
        coarse(&mut pace, start);
        let turning = Moment {
            turning: true,
            ..moment(start, 5000)
        };
        assert_eq!(pace.step(wish(99), &turning).order, None);
        let order = pace.step(wish(98), &turning).order;
        assert_eq!(order.expect("another wish").pixel_size, 3);
        let saving = Moment {
            must_be_fine: true,
            ..turning
        };
        let order = pace.step(wish(98), &saving).order;
        assert_eq!(order.expect("somebody waits").pixel_size, 1);
    }

    #[test]
    fn a_played_frame_is_late_only_when_the_next_one_is_due() {
        let (mut pace, start) = pace();
        let playing = |ms| Moment {
            frame_time: Some(Duration::from_millis(62)),
            ..moment(start, ms)
        };
        for i in 0..20 {
            let order = pace.step(wish(1 + i), &playing(62 * i as u64)).order;
            let order = order.expect("the next frame");
            assert_eq!(order.pixel_size, 1);
            pace.took(&picture(&order, 50), Duration::from_millis(1));
        }
        pace.input(start + Duration::from_millis(1300));
        for i in 0..6 {
            let order = pace
                .step(wish(50 + i), &playing(1300 + 17 * i as u64))
                .order;
            pace.took(&picture(&order.expect("a drag"), 50), Duration::ZERO);
        }
        assert!(pace.governor.pixel_size() > 1);
    }

    #[test]
    fn pictures_of_the_scene_before_are_known() {
        let (mut pace, start) = pace();
        let order = pace.step(wish(1), &moment(start, 0)).order;
        let before = picture(&order.expect("the first"), 3);
        assert!(pace.is_of_scene(&before));
        pace.forget();
        assert!(!pace.is_of_scene(&before));
        let order = pace.step(wish(1), &moment(start, 1)).order;
        let after = picture(&order.expect("the same wish of another scene"), 3);
        assert!(pace.is_of_scene(&after));
    }

    #[test]
    fn a_better_tree_has_what_stands_ordered_once_more() {
        let (mut pace, start) = pace();
        let order = pace.step(wish(1), &moment(start, 0)).order;
        let before = picture(&order.expect("the first"), 90);
        for (ms, looks_different) in [(10, false), (20, true)] {
            pace.improved(looks_different);
            assert_eq!(pace.is_of_scene(&before), !looks_different);
            let step = pace.step(wish(1), &moment(start, ms));
            assert_eq!(step.order.expect("again").wish, wish(1));
            assert_eq!(pace.step(wish(1), &moment(start, ms + 1)).order, None);
        }
    }

    #[test]
    fn latency_counts_from_the_first_input_and_only_where_it_changed_the_picture() {
        let (mut pace, start) = pace();
        pace.step(wish(1), &moment(start, 0));
        pace.input(start + Duration::from_millis(50));
        pace.step(wish(1), &moment(start, 51));
        for ms in [100, 104] {
            pace.input(start + Duration::from_millis(ms));
        }
        let order = pace.step(wish(2), &moment(start, 105)).order;
        let picture = picture(&order.expect("another wish"), 3);
        pace.shown(&picture, start + Duration::from_millis(110));
        let p50 = pace.latencies.percentile(50);
        assert_eq!(p50, Some(Duration::from_millis(10)));
    }
}
