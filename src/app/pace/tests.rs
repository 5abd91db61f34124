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
        told_when: false,
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

#[test]
fn where_the_window_system_keeps_the_rate_ours_does_not() {
    let (mut pace, start) = pace();
    let told = |ms| Moment {
        told_when: true,
        ..moment(start, ms)
    };
    pace.step(wish(1), &told(0));
    assert_eq!(pace.step(wish(2), &told(3)).order, None);
    let order = pace.step(wish(2), &told(16)).order;
    assert_eq!(order.expect("before our own refresh").wish, wish(2));
}

#[test]
fn what_was_ordered_before_a_rest_is_ordered_again() {
    let (mut pace, start) = pace();
    let ordered = |pace: &mut Pace, ms| pace.step(wish(1), &moment(start, ms)).order;
    let first = ordered(&mut pace, 0);
    assert_eq!(ordered(&mut pace, 50), None);
    pace.rest();
    assert_eq!(ordered(&mut pace, 9000), first);
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
fn a_better_tree_does_not_begin_anew_with_what_is_refined() {
    let (mut pace, start) = pace();
    let ordered = |pace: &mut Pace, ms| pace.step(wish(1), &moment(start, ms)).order;
    let order = ordered(&mut pace, 0).expect("the first");
    let coarse = picture(&order, 90);
    let fine = Picture {
        samples: order.samples,
        ..picture(&order, 90)
    };
    assert!(coarse.is_coarser_than(&fine) && !fine.is_coarser_than(&coarse));
    // In the middle of it: all samples once more, but what has fewer than there are is not shown.
    pace.took(&coarse, Duration::ZERO);
    pace.improved(false);
    let again = ordered(&mut pace, 10).expect("again");
    assert_eq!(again.samples, order.samples);
    assert!(picture(&again, 9).is_coarser_than(&fine));
    // At the end of it: once, to learn what it takes.
    pace.took(&fine, Duration::ZERO);
    pace.improved(false);
    let again = ordered(&mut pace, 20).expect("again");
    assert_eq!(again.samples, Samples::ONE);
    pace.took(&picture(&again, 9), Duration::ZERO);
    assert_eq!(ordered(&mut pace, 30), None);
    // What looks different is another picture.
    pace.improved(true);
    let other = ordered(&mut pace, 40).expect("another");
    assert_eq!(other.samples, order.samples);
    assert!(!picture(&other, 9).is_coarser_than(&fine));
}

#[test]
fn a_refined_picture_that_comes_back_is_refined_again() {
    let (mut pace, start) = pace();
    let ordered = |pace: &mut Pace, width, ms| pace.step(wish(width), &moment(start, ms)).order;
    let order = ordered(&mut pace, 1, 0).expect("the first");
    let fine = Picture {
        samples: order.samples,
        ..picture(&order, 3)
    };
    pace.took(&fine, Duration::ZERO);
    let other = ordered(&mut pace, 2, 100).expect("another");
    pace.took(&picture(&other, 3), Duration::ZERO);
    ordered(&mut pace, 1, 200).expect("on the way");
    let back = ordered(&mut pace, 1, 300).expect("what stands");
    assert_eq!(back.samples, order.samples);
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
