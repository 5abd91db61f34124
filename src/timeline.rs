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

#[cfg(test)]
mod tests {
    use super::*;
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
}
