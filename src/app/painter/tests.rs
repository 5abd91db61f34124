use super::*;
use crate::app::bindings::Spot;
use crate::camera::Camera;
use crate::color::Rgb;
use crate::geometry::Aabb;
use crate::render::Settings;
use crate::scene::{CameraSetting, Scene, Triangle};
use std::sync::mpsc::{Receiver, channel, sync_channel};
use std::time::Duration;

fn order(width: usize) -> Order {
    Order {
        scene: 0,
        wish: Wish {
            view: Camera::default_for(Aabb::EMPTY).view(width, 8, false),
            settings: Settings::default(),
            split: None,
        },
        pixel_size: 1,
        samples: Samples::ONE,
        moving: true,
        asked: None,
    }
}

/// One triangle in the middle.
fn world() -> Arc<World> {
    let corner = |x, y| glam::Vec3::new(x, y, 0.0);
    Arc::new(World::compile(&Scene {
        camera: CameraSetting::Default,
        light: glam::Vec3::NEG_Z,
        triangles: vec![Triangle {
            corners: [corner(-0.4, -0.4), corner(0.4, -0.4), corner(0.0, 0.4)],
            color: Rgb::new(250, 200, 150),
        }],
        operations: Vec::new(),
    }))
}

/// The thread waits until what it tells is taken: however slow a test is, it sees each notice before the next but one
/// is made.
fn painter() -> (Painter, Receiver<Notice>) {
    let (send, receive) = sync_channel(0);
    let renderer = Renderer::new(1).expect("one thread");
    let painter = Painter::start(renderer, move |n| {
        let _ = send.send(n);
    });
    let painter = painter.expect("one more");
    painter.set_world(world());
    (painter, receive)
}

fn next_picture(notices: &Receiver<Notice>) -> Box<Picture> {
    match notices.recv_timeout(Duration::from_secs(20)) {
        Ok(Notice::Picture(picture)) => picture,
        other => panic!("no picture: {other:?}"),
    }
}

/// The picture of `order` without a painter.
fn expected(order: &Order, samples: Samples) -> Frame {
    let mut frame = Frame::default();
    Refinement::default()
        .picture(
            &Renderer::new(1).expect("one thread"),
            &world(),
            &order.wish.view,
            &order.wish.settings,
            samples,
            &mut frame,
            &Progress::new(),
        )
        .expect("nobody cancels");
    frame
}

#[test]
fn the_newest_order_is_painted_last_and_none_is_invented() {
    let (painter, notices) = painter();
    for width in 1..=50 {
        painter.order(order(width));
    }
    let mut painted = 0;
    loop {
        painted += 1;
        let picture = next_picture(&notices);
        assert_eq!(picture.frame.width, picture.order.wish.view.width);
        if picture.frame.width == 50 {
            break;
        }
    }
    assert!(painted <= 50);
    assert!(notices.recv_timeout(Duration::from_millis(50)).is_err());
}

#[test]
fn a_frame_given_back_is_painted_again() {
    let (painter, notices) = painter();
    painter.order(order(16));
    let frame = next_picture(&notices).frame;
    let place = frame.pixels.as_ptr();
    painter.give_back(frame);
    painter.order(order(16));
    assert_eq!(next_picture(&notices).frame.pixels.as_ptr(), place);
}

#[test]
fn dropping_the_handle_ends_the_thread() {
    let (painter, notices) = painter();
    drop(painter);
    // The thread held the sender.
    assert!(notices.recv_timeout(Duration::from_secs(20)).is_err());
}

#[test]
fn what_stands_is_refined_step_by_step_to_the_bits_of_a_file() {
    let (painter, notices) = painter();
    let order = Order {
        samples: Samples::MAX,
        moving: false,
        ..order(60)
    };
    painter.order(order);
    let mut samples = Some(Samples::ONE);
    while let Some(now) = samples {
        let picture = next_picture(&notices);
        assert_eq!(picture.samples, now);
        assert!(picture.frame == expected(&order, now), "{now:?}");
        samples = now.refined(Samples::MAX);
    }
    assert!(notices.recv_timeout(Duration::from_millis(50)).is_err());
}

#[test]
fn another_order_ends_a_refinement() {
    let (painter, notices) = painter();
    painter.order(Order {
        samples: Samples::MAX,
        moving: false,
        ..order(3000)
    });
    assert_eq!(next_picture(&notices).frame.width, 3000);
    painter.order(order(20));
    let others: Vec<_> = std::iter::repeat_with(|| next_picture(&notices))
        .take_while(|p| p.frame.width != 20)
        .collect();
    assert!(others.len() < 2, "{} came first", others.len());
}

#[test]
fn a_rest_ends_a_refinement_until_the_next_order() {
    let (painter, notices) = painter();
    let order = Order {
        samples: Samples::MAX,
        moving: false,
        ..order(3000)
    };
    painter.order(order);
    next_picture(&notices);
    painter.rest();
    let quiet = Duration::from_millis(200);
    let late = std::iter::from_fn(|| notices.recv_timeout(quiet).ok());
    assert!(late.count() < 2, "it went on");
    painter.order(order);
    assert_eq!(next_picture(&notices).samples, Samples::ONE);
}

#[test]
fn coarse_pictures_show_the_middles_of_their_pixels() {
    let (painter, notices) = painter();
    // Three window pixels a pixel: the middle is a window pixel's middle.
    let fine = order(31);
    painter.order(fine);
    let fine = next_picture(&notices).frame;
    painter.order(Order {
        pixel_size: 3,
        ..order(31)
    });
    let coarse = next_picture(&notices).frame;
    assert_eq!((coarse.width, coarse.height), (11, 3));
    for y in 0..2 {
        for x in 0..10 {
            let middle = fine.pixels[(3 * y + 1) * 31 + 3 * x + 1];
            assert_eq!(coarse.pixels[y * 11 + x], middle, "{x}, {y}");
        }
    }
    assert!(coarse.pixels.iter().any(|&p| p != 0));
}

#[test]
fn after_a_panic_the_next_picture_is_right() {
    let (painter, notices) = painter();
    let mut absurd = order(16);
    // More pixels than there is memory, or than numbers to count them.
    absurd.wish.view.width = usize::MAX;
    painter.order(absurd);
    match notices.recv_timeout(Duration::from_secs(20)) {
        Ok(Notice::Failed(why)) => assert!(!why.is_empty()),
        other => panic!("{other:?}"),
    }
    painter.order(order(40));
    assert!(next_picture(&notices).frame == expected(&order(40), Samples::ONE));
}

#[test]
fn the_time_of_asking_is_that_of_the_first_of_the_orders_that_one_picture_answers() {
    let (send, notices) = channel();
    let painter = Painter::start(Renderer::new(1).expect("one thread"), move |n| {
        let _ = send.send(n);
    })
    .expect("one more");
    let first = Instant::now();
    for later in [5, 0, 9] {
        let asked = Some(first + Duration::from_millis(later));
        painter.order(Order { asked, ..order(16) });
    }
    // Only now it can begin.
    painter.set_world(world());
    assert_eq!(next_picture(&notices).order.asked, Some(first));
}

#[test]
fn a_question_does_not_wait_for_a_refinement_which_then_goes_on() {
    let (painter, notices) = painter();
    let order = Order {
        samples: Samples::MAX,
        moving: false,
        ..order(1200)
    };
    painter.order(order);
    assert_eq!(next_picture(&notices).samples, Samples::ONE);
    painter.probe(Probe {
        scene: 0,
        wish: order.wish,
        pixel: (600, 4),
        spot: Spot::Pick,
    });
    let (mut answered_at, mut samples) = (None, Vec::new());
    while samples.last() != Some(&64) {
        match notices.recv_timeout(Duration::from_secs(20)) {
            Ok(Notice::Picture(picture)) => {
                samples.push(picture.samples.count());
                if picture.samples == Samples::MAX {
                    assert!(picture.frame == expected(&order, Samples::MAX));
                }
            }
            Ok(Notice::Probed(answer)) => {
                answered_at = Some(samples.len());
                assert_eq!(answer.1.map(|p| p.id), Some(0));
            }
            other => panic!("{other:?}"),
        }
    }
    assert_eq!(samples, [2, 4, 8, 16, 32, 64]);
    assert!(answered_at.is_some_and(|at| at < 2), "{answered_at:?}");
}

#[test]
fn a_question_needs_a_world_and_no_order() {
    let (painter, notices) = painter();
    let probe = Probe {
        scene: 0,
        wish: order(16).wish,
        pixel: (99, 99),
        spot: Spot::Pivot,
    };
    painter.probe(probe);
    match notices.recv_timeout(Duration::from_secs(20)) {
        Ok(Notice::Probed(answer)) => assert_eq!(*answer, (probe, None)),
        other => panic!("{other:?}"),
    }
}
