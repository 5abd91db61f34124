//! Frame numbers and the camera that belongs to them.
//!
//! A frame depends on its number alone: turns are composed anew from the operations, never accumulated from
//! frame to frame. There is no clock here; time enters as a value. Which frame is due when is the business of
//! [`Playback`].

mod playback;

use glam::{DMat3, DVec3};

use crate::camera::Camera;
use crate::math::rotation;
use crate::scene::Operation;

pub use playback::{Order, Playback};

/// How an operation gets from nothing to its angle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Ease {
    /// In equal steps, as the format says.
    #[default]
    Linear,
    /// Starts and stops gently: 3p² - 2p³ of the way when the share p of the time is over.
    Smooth,
}

impl Ease {
    /// The share of the angle after the share `part` (0 to 1) of the time.
    #[must_use]
    pub fn at(self, part: f64) -> f64 {
        match self {
            Ease::Linear => part,
            Ease::Smooth => part * part * (3.0 - 2.0 * part),
        }
    }
}

/// How operations become frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timing {
    /// Frames a second, above 0.
    pub fps: f64,
    /// Seconds that each operation takes, above 0.
    pub seconds_per_op: f64,
    /// How each of them moves.
    pub ease: Ease,
}

impl Default for Timing {
    /// The report's 1/16 s a frame, a second an operation.
    fn default() -> Timing {
        Timing {
            fps: 16.0,
            seconds_per_op: 1.0,
            ease: Ease::Linear,
        }
    }
}

impl Timing {
    /// The report's slide show: every frame, 1/16 s each, is a whole operation.
    pub const STEPS: Timing = Timing {
        fps: 16.0,
        seconds_per_op: 1.0 / 16.0,
        ease: Ease::Linear,
    };

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

/// The operations that lead to frame `frame`, the one under way with the angle that it has reached; past the
/// last frame all of them.
pub fn operations_at(
    operations: &[Operation],
    timing: Timing,
    frame: u64,
) -> impl Iterator<Item = Operation> {
    let n = timing.frames_per_op();
    let done = usize::try_from(frame / n)
        .unwrap_or(usize::MAX)
        .min(operations.len());
    // Written so that the last step of an operation has exactly its angle.
    let part = timing.ease.at((frame % n) as f64 / n as f64);
    let under_way = operations
        .get(done)
        .filter(|_| part > 0.0)
        .map(|op| Operation {
            axis: op.axis,
            angle_rad: op.angle_rad * part,
        });
    operations[..done].iter().copied().chain(under_way)
}

/// The turn that brings the base camera to frame `frame`; past the last frame it stays.
#[must_use]
pub fn rotation_at(operations: &[Operation], timing: Timing, frame: u64) -> DMat3 {
    composed(operations_at(operations, timing, frame))
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
    composed(operations.iter().copied())
}

/// `operations`, the first applied first.
fn composed(operations: impl Iterator<Item = Operation>) -> DMat3 {
    operations.fold(DMat3::IDENTITY, then)
}

/// `turn`, and `op` after it.
fn then(turn: DMat3, op: Operation) -> DMat3 {
    rotation(op.axis, op.angle_rad) * turn
}

/// Composes long lists of operations again and again: what is the same at the beginning is not composed anew. The
/// bits are those of [`rotation_after`].
#[derive(Clone, Debug, Default)]
pub struct Composer {
    /// Each operation with the turn up to its end.
    done: Vec<(Operation, DMat3)>,
}

impl Composer {
    /// All of `operations`, the first applied first. O(operations), but dear only from the first that is new.
    pub fn compose(&mut self, operations: impl Iterator<Item = Operation>) -> DMat3 {
        let mut count = 0;
        for op in operations {
            if self.done.get(count).is_none_or(|(same, _)| *same != op) {
                self.done.truncate(count);
                let turn = self.done.last().map_or(DMat3::IDENTITY, |(_, turn)| *turn);
                self.done.push((op, then(turn, op)));
            }
            count += 1;
        }
        self.done.truncate(count);
        self.done.last().map_or(DMat3::IDENTITY, |(_, turn)| *turn)
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
        for ease in [Ease::Linear, Ease::Smooth] {
            let t = Timing {
                ease,
                ..Timing::default()
            };
            for done in 0..=3 {
                assert_eq!(
                    rotation_at(&ops(), t, 16 * done as u64),
                    rotation_after(&ops()[..done])
                );
            }
        }
    }

    #[test]
    fn a_composer_gives_the_bits_of_composing_anew() {
        let mut composer = Composer::default();
        let mut list = Vec::new();
        for i in 0..60 {
            match i % 5 {
                4 => list.truncate(i / 3),
                k => list.extend(&ops()[..k.min(3)]),
            }
            let all = list.iter().copied();
            assert_eq!(composer.compose(all), rotation_after(&list));
        }
    }

    #[test]
    fn smooth_frames_begin_and_end_slowly_and_never_turn_back() {
        let at = |k: u64| Ease::Smooth.at(k as f64 / 16.0);
        assert!((1..=16).all(|k| at(k) > at(k - 1)));
        assert!(at(1) < 1.0 / 32.0 && at(15) > 31.0 / 32.0);
        assert_eq!((at(0), at(8), at(16)), (0.0, 0.5, 1.0));
    }

    #[test]
    fn steps_show_one_operation_a_frame() {
        assert_eq!(Timing::STEPS.frames_per_op(), 1);
        assert_eq!(Timing::STEPS.last_frame(&ops()), 3);
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
            ease: Ease::Linear,
        };
        assert_eq!(t.frames_per_op(), 1);
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
