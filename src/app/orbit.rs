//! What a hand does to the camera: orbit, dolly, pan, and turns about the world's axes.
//!
//! Every move is rigid, so the hand is one [`Pose`] on top of the camera of the frame shown: playing goes on
//! below it, and dropping it gives the frame's own bits back. The rotation is a quaternion that is normalised
//! after each move: nothing drifts, and no direction is special (no gimbal lock).

use glam::{DQuat, DVec3};

use crate::camera::Camera;
use crate::scene::Axis;

/// The distance that is left after one notch of the wheel.
const DOLLY_NOTCH: f64 = 0.95;

/// A rigid motion: first the rotation about the world's origin, then the shift.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    rotation: DQuat,
    shift: DVec3,
}

impl Pose {
    /// No motion.
    pub const IDENTITY: Pose = Pose {
        rotation: DQuat::IDENTITY,
        shift: DVec3::ZERO,
    };

    /// A shift.
    #[must_use]
    pub fn shift(by: DVec3) -> Pose {
        Pose {
            rotation: DQuat::IDENTITY,
            shift: by,
        }
    }

    /// A right-handed turn about the line through `pivot` along `axis`, whose length is the angle in radians.
    #[must_use]
    pub fn turn(axis: DVec3, pivot: DVec3) -> Pose {
        let angle_rad = axis.length();
        if angle_rad == 0.0 {
            return Pose::IDENTITY;
        }
        let (s, c) = libm::sincos(angle_rad * 0.5);
        let v = axis * (s / angle_rad);
        let rotation = DQuat::from_xyzw(v.x, v.y, v.z, c).normalize();
        Pose {
            rotation,
            shift: pivot - rotation * pivot,
        }
    }

    /// This motion, and `next` after it.
    #[must_use]
    pub fn then(self, next: Pose) -> Pose {
        Pose {
            rotation: (next.rotation * self.rotation).normalize(),
            shift: next.rotation * self.shift + next.shift,
        }
    }

    /// The camera moved. Without motion these are the same bits.
    #[must_use]
    pub fn apply(self, camera: Camera) -> Camera {
        if self == Pose::IDENTITY {
            return camera;
        }
        camera.map(|p| self.rotation * p + self.shift)
    }
}

/// Turns about a world axis through `pivot`, as the scene's operations do.
#[must_use]
pub fn axis_turn(axis: Axis, angle_rad: f64, pivot: DVec3) -> Pose {
    let direction = match axis {
        Axis::X => DVec3::X,
        Axis::Y => DVec3::Y,
        Axis::Z => DVec3::Z,
    };
    Pose::turn(direction * angle_rad, pivot)
}

/// Turns the camera about `pivot` so that what is seen follows a hand that moved by that many pixels, right
/// and down. A hand's way of `window_height_px` is a whole turn.
#[must_use]
pub fn orbit(camera: &Camera, pivot: DVec3, dx_px: f64, dy_px: f64, window_height_px: f64) -> Pose {
    let right = (camera.top_right - camera.top_left).normalize_or_zero();
    let up = (camera.top_left - camera.bottom_left).normalize_or_zero();
    // A plane that mirrors the picture turns the other way.
    let handed = right.cross(up).dot(-view_dir(camera)).signum();
    let radians_per_px = std::f64::consts::TAU / window_height_px.max(1.0);
    Pose::turn(
        (right * dy_px + up * dx_px) * (-radians_per_px * handed),
        pivot,
    )
}

/// Moves along the view by notches of the wheel, each of which leaves 0.95 of the way to the pivot; negative
/// ones move away.
#[must_use]
pub fn dolly(camera: &Camera, pivot: DVec3, notches: f64) -> Pose {
    let way = depth(camera, pivot) * (1.0 - libm::pow(DOLLY_NOTCH, notches));
    Pose::shift(view_dir(camera) * way)
}

/// Shifts the camera in its picture plane so that the point under the cursor, at the pivot's depth, stays
/// under a cursor that moves by `plane_step`: the way of the cursor as a vector in the plane.
#[must_use]
pub fn pan(camera: &Camera, pivot: DVec3, plane_step: DVec3) -> Pose {
    let plane_depth = (camera.top_left - camera.eye).dot(normal(camera));
    let ratio = match (pivot - camera.eye).dot(normal(camera)) / plane_depth {
        ratio if ratio > 0.0 && ratio.is_finite() => ratio,
        // The pivot lies behind the eye: what stays is a point in the plane.
        _ => 1.0,
    };
    Pose::shift(plane_step * -ratio)
}

/// From the eye to the middle of the plane, unit length.
fn view_dir(camera: &Camera) -> DVec3 {
    ((camera.top_right + camera.bottom_left) * 0.5 - camera.eye).normalize_or_zero()
}

/// Square to the plane; the sign does not matter where it is used.
fn normal(camera: &Camera) -> DVec3 {
    (camera.top_right - camera.top_left)
        .cross(camera.bottom_left - camera.top_left)
        .normalize_or_zero()
}

/// How far away the pivot is along the view. Where it lies beside or behind the eye: its plain distance, or
/// the plane's, so that a dolly always moves.
fn depth(camera: &Camera, pivot: DVec3) -> f64 {
    let to_pivot = pivot - camera.eye;
    let to_plane = (camera.top_right + camera.bottom_left) * 0.5 - camera.eye;
    let along = to_pivot.dot(view_dir(camera));
    if along > 1e-3 * to_plane.length() {
        along
    } else {
        to_pivot.length().max(to_plane.length())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::View;

    /// Looks from (0, 0, 5) along -z at a plane of 4 x 3 at z = 1.
    fn camera() -> Camera {
        Camera {
            eye: DVec3::new(0.0, 0.0, 5.0),
            top_left: DVec3::new(-2.0, 1.5, 1.0),
            top_right: DVec3::new(2.0, 1.5, 1.0),
            bottom_left: DVec3::new(-2.0, -1.5, 1.0),
        }
    }

    /// Where `p` is seen, in pixels of a 400 x 300 picture.
    fn seen_at(camera: &Camera, p: DVec3) -> (f64, f64) {
        // Not by `View`: it rounds the eye to `f32`.
        let columns = glam::DMat3::from_cols(
            (camera.top_right - camera.top_left) / 400.0,
            (camera.bottom_left - camera.top_left) / 300.0,
            camera.top_left - camera.eye,
        );
        let m = columns.inverse() * (p - camera.eye);
        (m.x / m.z, m.y / m.z)
    }

    fn near(a: DVec3, b: DVec3, tolerance: f64) {
        assert!((a - b).length() <= tolerance, "{a} is not {b}");
    }

    #[test]
    fn a_whole_window_height_is_a_whole_turn() {
        let pivot = DVec3::new(1.0, 2.0, 3.0);
        let turned = orbit(&camera(), pivot, 300.0, 0.0, 300.0).apply(camera());
        near(turned.eye, camera().eye, 1e-14);
        near(turned.top_left, camera().top_left, 1e-14);
    }

    #[test]
    fn what_is_seen_follows_the_hand() {
        let p = DVec3::new(0.0, 0.0, 1.0);
        let before = seen_at(&camera(), p);
        let right = orbit(&camera(), DVec3::ZERO, 5.0, 0.0, 300.0).apply(camera());
        assert!(seen_at(&right, p).0 > before.0 + 1.0);
        let down = orbit(&camera(), DVec3::ZERO, 0.0, 5.0, 300.0).apply(camera());
        assert!(seen_at(&down, p).1 > before.1 + 1.0);
    }

    #[test]
    fn what_is_seen_follows_the_hand_through_a_mirroring_camera() {
        let c = camera();
        let mirrored = Camera {
            top_left: c.top_right,
            top_right: c.top_left,
            bottom_left: c.bottom_left + DVec3::X * 4.0,
            ..c
        };
        let p = DVec3::new(0.0, 0.0, 1.0);
        let before = seen_at(&mirrored, p);
        let right = orbit(&mirrored, DVec3::ZERO, 5.0, 0.0, 300.0).apply(mirrored);
        assert!(seen_at(&right, p).0 > before.0 + 1.0);
    }

    #[test]
    fn orbiting_over_the_pole_and_for_hours_keeps_the_shape() {
        let pivot = DVec3::new(0.1, 0.2, 0.3);
        let mut pose = Pose::IDENTITY;
        for i in 0..100_000 {
            let now = pose.apply(camera());
            let (dx, dy) = (f64::from(i % 7) - 3.0, f64::from(i % 11) - 4.0);
            pose = pose.then(orbit(&now, pivot, dx, dy, 480.0));
        }
        let now = pose.apply(camera());
        let (s, t) = now.plane_size();
        assert!((s - 4.0).abs() < 1e-12 && (t - 3.0).abs() < 1e-12);
        let distance = (now.eye - pivot).length();
        assert!((distance - (camera().eye - pivot).length()).abs() < 1e-9);
    }

    #[test]
    fn dolly_leaves_95_hundredths_a_notch_and_comes_back() {
        let in_by_2 = dolly(&camera(), DVec3::ZERO, 2.0).apply(camera());
        assert!((in_by_2.eye.z - 5.0 * 0.95 * 0.95).abs() < 1e-12);
        near(
            in_by_2.top_left - in_by_2.eye,
            camera().top_left - camera().eye,
            1e-12,
        );
        let back = dolly(&in_by_2, DVec3::ZERO, -2.0).apply(in_by_2);
        near(back.eye, camera().eye, 1e-12);
    }

    #[test]
    fn dolly_moves_with_the_pivot_on_the_eye_or_behind_it() {
        for pivot in [camera().eye, DVec3::new(0.0, 0.0, 9.0)] {
            let moved = dolly(&camera(), pivot, 1.0).apply(camera());
            assert!(moved.eye.z < 5.0, "pivot {pivot}");
        }
    }

    #[test]
    fn pan_keeps_the_point_at_the_pivots_depth_under_the_cursor() {
        let pivot = DVec3::new(0.0, 0.0, -3.0);
        let p = DVec3::new(0.7, -0.4, -3.0);
        let v = View::new(&camera(), 400, 300);
        let before = seen_at(&camera(), p);
        let moved = pan(&camera(), pivot, v.dx * 17.0 + v.dy * -9.0).apply(camera());
        let after = seen_at(&moved, p);
        assert!((after.0 - before.0 - 17.0).abs() < 1e-9);
        assert!((after.1 - before.1 + 9.0).abs() < 1e-9);
    }

    #[test]
    fn axis_turns_are_the_operations_turns() {
        let pivot = DVec3::new(3.0, -1.0, 2.0);
        for axis in [Axis::X, Axis::Y, Axis::Z] {
            let by_key = axis_turn(axis, 0.3, pivot).apply(camera());
            let by_op = camera().turned(crate::math::rotation(axis, 0.3), pivot);
            near(by_key.eye, by_op.eye, 1e-14);
            near(by_key.bottom_left, by_op.bottom_left, 1e-14);
        }
    }

    #[test]
    fn no_motion_changes_no_bit() {
        assert_eq!(Pose::IDENTITY.apply(camera()), camera());
        assert_eq!(Pose::turn(DVec3::ZERO, DVec3::ONE), Pose::IDENTITY);
    }
}
