//! Frame numbers and the camera that belongs to them.
//!
//! A frame depends on its number alone: turns are composed anew from the operations, never accumulated from
//! frame to frame. There is no clock here; time enters as a value.

use glam::{DMat3, DVec3};

use crate::camera::Camera;
use crate::math::rotation;
use crate::scene::Operation;

/// How operations become frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timing {
    /// Frames a second.
    pub fps: f64,
    /// Seconds that each operation takes.
    pub seconds_per_op: f64,
}

impl Default for Timing {
    /// The report's 1/16 s a frame, a second an operation.
    fn default() -> Timing {
        Timing {
            fps: 16.0,
            seconds_per_op: 1.0,
        }
    }
}

impl Timing {
    /// Frames that one operation takes, at least 1.
    #[must_use]
    pub fn frames_per_op(self) -> u64 {
        (self.fps * self.seconds_per_op).round().max(1.0) as u64
    }

    /// The number of the last frame, which is the still picture: 0 without operations.
    #[must_use]
    pub fn last_frame(self, operations: &[Operation]) -> u64 {
        self.frames_per_op().saturating_mul(operations.len() as u64)
    }
}

/// The turn that brings the base camera to frame `frame`; past the last frame it stays.
#[must_use]
pub fn rotation_at(operations: &[Operation], timing: Timing, frame: u64) -> DMat3 {
    let n = timing.frames_per_op();
    let done = usize::try_from(frame / n)
        .unwrap_or(usize::MAX)
        .min(operations.len());
    let mut turn = rotation_after(&operations[..done]);
    if let Some(op) = operations.get(done) {
        // Written so that the last step of an operation has exactly its angle.
        let part = (frame % n) as f64 / n as f64;
        turn = rotation(op.axis, op.angle_rad * part) * turn;
    }
    turn
}

/// The camera of frame `frame`: `base` turned about `pivot`. The window and the files both ask here, so the
/// same frame number is the same picture.
#[must_use]
pub fn camera_at(
    base: Camera,
    operations: &[Operation],
    timing: Timing,
    frame: u64,
    pivot: DVec3,
) -> Camera {
    base.turned(rotation_at(operations, timing, frame), pivot)
}

/// All of `operations`, the first applied first.
#[must_use]
pub fn rotation_after(operations: &[Operation]) -> DMat3 {
    operations.iter().fold(DMat3::IDENTITY, |turn, op| {
        rotation(op.axis, op.angle_rad) * turn
    })
}

/// Plays, pauses and stops; told by its caller how much time went by.
///
/// The frame shown is `from + floor(elapsed · fps)`: a caller that is late skips frames, and never slows down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Playback {
    fps: f64,
    last: u64,
    motion: Motion,
}

/// What a [`Playback`] is doing.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Motion {
    /// Stands at a frame.
    Standing { frame: u64 },
    /// Left frame `from` that many seconds ago.
    Playing { from: u64, elapsed_s: f64 },
}

impl Playback {
    /// Stands on the still picture, the last frame.
    #[must_use]
    pub fn new(timing: Timing, operations: &[Operation]) -> Playback {
        let last = timing.last_frame(operations);
        Playback {
            fps: timing.fps,
            last,
            motion: Motion::Standing { frame: last },
        }
    }

    /// Other operations take the place of the old ones: the frame and the playing stay where they are as far as there
    /// are frames; the still picture stays the still picture.
    pub fn set_operations(&mut self, timing: Timing, operations: &[Operation]) {
        let last = timing.last_frame(operations);
        if let Motion::Standing { frame } = &mut self.motion {
            *frame = if *frame == self.last {
                last
            } else {
                last.min(*frame)
            };
        }
        self.last = last;
    }

    /// The number of the frame to show.
    #[must_use]
    pub fn frame(&self) -> u64 {
        match self.motion {
            Motion::Standing { frame } => frame,
            // The cast rounds down, and saturates where elapsed times are absurd.
            Motion::Playing { from, elapsed_s } => from
                .saturating_add((elapsed_s * self.fps) as u64)
                .min(self.last),
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

    /// Plays on from the frame shown; on the last frame, from frame 0.
    pub fn play(&mut self) {
        let from = match self.frame() {
            frame if frame == self.last => 0,
            frame => frame,
        };
        self.motion = Motion::Playing {
            from,
            elapsed_s: 0.0,
        };
    }

    /// Stands still on the frame shown and returns its number.
    pub fn pause(&mut self) -> u64 {
        let frame = self.frame();
        self.motion = Motion::Standing { frame };
        frame
    }

    /// Stands still on the last frame, the still picture.
    pub fn stop(&mut self) {
        self.motion = Motion::Standing { frame: self.last };
    }

    /// Lets `dt_s` seconds go by. True when this reached the last frame, where playing ends.
    pub fn advance(&mut self, dt_s: f64) -> bool {
        let Motion::Playing { elapsed_s, .. } = &mut self.motion else {
            return false;
        };
        *elapsed_s += dt_s;
        let ended = self.frame() == self.last;
        if ended {
            self.stop();
        }
        ended
    }

    /// Seconds until the next frame is due; `None` when it stands.
    #[must_use]
    pub fn next_frame_in_s(&self) -> Option<f64> {
        let Motion::Playing { from, elapsed_s } = self.motion else {
            return None;
        };
        let due_s = (self.frame() - from + 1) as f64 / self.fps;
        Some((due_s - elapsed_s).max(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Aabb;
    use crate::scene::Axis;

    fn ops() -> Vec<Operation> {
        let op = |axis, angle_rad| Operation { axis, angle_rad };
        vec![op(Axis::X, 0.7), op(Axis::Y, -1.1), op(Axis::Z, 0.3)]
    }

    #[test]
    fn each_operation_ends_exactly_on_its_angle() {
        let t = Timing::default();
        for done in 0..=3 {
            assert_eq!(
                rotation_at(&ops(), t, 16 * done as u64),
                rotation_after(&ops()[..done])
            );
        }
    }

    #[test]
    fn frames_past_the_end_and_without_operations_stand_still() {
        let t = Timing::default();
        assert_eq!(t.last_frame(&ops()), 48);
        assert_eq!(rotation_at(&ops(), t, 1000), rotation_after(&ops()));
        assert_eq!(t.last_frame(&[]), 0);
        assert_eq!(rotation_at(&[], t, 5), DMat3::IDENTITY);
    }

    #[test]
    fn an_operation_takes_at_least_one_frame() {
        let t = Timing {
            fps: 1.0,
            seconds_per_op: 0.1,
        };
        assert_eq!(t.frames_per_op(), 1);
    }

    #[test]
    fn playback_opens_on_the_still_picture_and_plays_from_the_start() {
        let mut p = Playback::new(Timing::default(), &ops());
        assert_eq!((p.frame(), p.is_playing()), (48, false));
        p.play();
        assert_eq!((p.frame(), p.is_playing()), (0, true));
        assert_eq!(p.next_frame_in_s(), Some(1.0 / 16.0));
    }

    #[test]
    fn the_frame_follows_the_clock_and_not_the_calls() {
        let mut one = Playback::new(Timing::default(), &ops());
        one.play();
        let mut many = one;
        assert!(!one.advance(1.55));
        for _ in 0..155 {
            assert!(!many.advance(0.01));
        }
        assert_eq!(one.frame(), 24);
        assert_eq!(many.frame(), 24);
    }

    #[test]
    fn playing_on_after_a_pause_starts_at_the_paused_frame() {
        let mut p = Playback::new(Timing::default(), &ops());
        p.play();
        p.advance(1.0);
        assert_eq!(p.pause(), 16);
        assert!(!p.advance(100.0));
        assert_eq!(p.frame(), 16);
        p.play();
        assert_eq!(p.frame(), 16);
    }

    #[test]
    fn playback_ends_once_and_stands_on_the_still_picture() {
        let mut p = Playback::new(Timing::default(), &ops());
        p.play();
        assert!(p.advance(1e300));
        assert!(!p.advance(1.0));
        assert_eq!((p.frame(), p.next_frame_in_s()), (48, None));
    }

    #[test]
    fn other_operations_keep_the_frame_as_far_as_there_are_frames() {
        let t = Timing::default();
        let mut p = Playback::new(t, &ops());
        p.set_operations(t, &ops()[..2]);
        assert_eq!(p.frame(), 32);
        p.play();
        p.advance(1.0);
        p.set_operations(t, &ops());
        assert_eq!((p.frame(), p.is_playing()), (16, true));
        p.pause();
        p.set_operations(t, &[]);
        assert_eq!(p.frame(), 0);
    }

    #[test]
    fn nothing_to_play_ends_at_once() {
        let mut p = Playback::new(Timing::default(), &[]);
        p.play();
        assert!(p.advance(0.0));
        assert_eq!(p.frame(), 0);
    }

    #[test]
    fn the_camera_of_a_frame_is_the_base_camera_turned_about_the_pivot() {
        let base = Camera::default_for(Aabb::EMPTY);
        let (t, pivot) = (Timing::default(), DVec3::new(1.0, 2.0, 3.0));
        assert_eq!(camera_at(base, &ops(), t, 0, DVec3::ZERO), base);
        let turned = camera_at(base, &ops(), t, 20, pivot);
        assert_eq!(turned, base.turned(rotation_at(&ops(), t, 20), pivot));
        let distance = |c: Camera| (c.eye - pivot).length();
        assert!((distance(turned) - distance(base)).abs() < 1e-12);
    }
}
