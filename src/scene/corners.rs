//! The camera of a scene file: the default one, or four points, which must be an eye beside a plane.
//!
//! Both conditions are decided exactly, on the numbers as `f32` holds them: a camera is refused only when it shows
//! nothing, however thin its plane is.

use glam::Vec3;
use robust::{Coord, Coord3D};

use super::error::{Expected, ParseErrorKind, Point};
use super::model::{CameraCorners, CameraSetting};
use super::parser::{Halt, Parser};

impl Parser<'_> {
    /// `<d`, or `<s` and its twelve numbers.
    pub(super) fn camera(&mut self) -> Result<CameraSetting, Halt> {
        let (span, letter) = self.keyword(Expected::Camera)?;
        match letter {
            Some(b'd') => Ok(CameraSetting::Default),
            Some(b's') => Ok(CameraSetting::Set(self.corners()?)),
            _ => self.halt(span, Expected::Camera),
        }
    }

    fn corners(&mut self) -> Result<CameraCorners, Halt> {
        let (eye, eye_span) = self.point(Point::Eye)?;
        let (top_left, plane) = self.point(Point::TopLeft)?;
        let (top_right, _) = self.point(Point::TopRight)?;
        let (bottom_left, last) = self.point(Point::BottomLeft)?;
        let all = [eye, top_left, top_right, bottom_left];
        if all.iter().all(|p| p.is_finite()) {
            if on_one_line(top_left, top_right, bottom_left) {
                self.note(plane.start..last.end, ParseErrorKind::PlaneOnOneLine, None)?;
            } else if in_one_plane(all) {
                self.note(eye_span, ParseErrorKind::EyeInPlane, None)?;
            }
        }
        Ok(CameraCorners {
            eye,
            top_left,
            top_right,
            bottom_left,
        })
    }
}

/// True when the points lie on one line; exact.
fn on_one_line(a: Vec3, b: Vec3, c: Vec3) -> bool {
    // They do when their shadows on all three planes of two axes do.
    let shadow = |pick: fn(Vec3) -> (f32, f32)| {
        let [a, b, c] = [a, b, c].map(|p| {
            let (x, y) = pick(p);
            Coord { x, y }
        });
        robust::orient2d(a, b, c)
    };
    shadow(|p| (p.x, p.y)) == 0.0 && shadow(|p| (p.y, p.z)) == 0.0 && shadow(|p| (p.z, p.x)) == 0.0
}

/// True when the points lie in one plane; exact.
fn in_one_plane(points: [Vec3; 4]) -> bool {
    let [a, b, c, d] = points.map(|p| Coord3D {
        x: p.x,
        y: p.y,
        z: p.z,
    });
    robust::orient3d(a, b, c, d) == 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_on_a_line_are_told_from_points_next_to_it() {
        // Doubling is exact; the triple is rounded, and so beside the line by less than its last bit.
        let a = Vec3::new(0.1, 0.2, 0.3);
        assert!(on_one_line(a, a * 2.0, a * 4.0));
        assert!(!on_one_line(a, a * 2.0, a * 3.0));
        for scale in [f32::MIN_POSITIVE, 1.0, 1e38] {
            let next = Vec3::new(scale.next_up(), scale, scale);
            assert!(on_one_line(
                Vec3::ZERO,
                Vec3::splat(scale),
                Vec3::splat(-scale)
            ));
            assert!(
                !on_one_line(Vec3::ZERO, Vec3::splat(scale), next),
                "{scale}"
            );
        }
    }

    #[test]
    fn an_eye_in_the_plane_is_told_from_one_next_to_it() {
        // Powers of two, so that all points but the last are exact.
        for scale in [f32::MIN_POSITIVE, 1.0, 2f32.powi(126)] {
            let (o, a, b) = (Vec3::splat(scale), Vec3::X * scale, Vec3::Y * scale);
            // z = x + y - 1, in units of `scale`.
            assert!(in_one_plane([Vec3::new(0.5, 0.75, 0.25) * scale, o, a, b]));
            let beside = Vec3::new(0.5, 0.75, 0.25f32.next_up()) * scale;
            assert_eq!(
                in_one_plane([beside, o, a, b]),
                beside.z == 0.25 * scale,
                "{scale}"
            );
        }
    }
}
