//! What a hand means: orbit, roll, dolly and pan as motions of the camera. Plain geometry, nothing is kept.
//!
//! Turns are given as vectors: along the axis, as long as the angle in radians. No direction is special (no
//! gimbal lock): trackball and turntable both turn about what is right and up on the screen or in the world at
//! that moment.

use glam::{DMat3, DQuat, DVec3};

use crate::camera::{Camera, Pivot, View};
use crate::geometry::Aabb;
use crate::scene::Axis;

/// The distance that is left after one notch of the wheel.
const DOLLY_NOTCH: f64 = 0.95;

/// The distance at which a box fits, over the smallest one.
const FIT_MARGIN: f64 = 1.05;

/// An axis that points at the eye so nearly that a hand cannot turn about it by rolling the picture over.
const AXIS_AT_EYE: f64 = 0.9;

/// How the picture follows the hand.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OrbitStyle {
    /// Like a ball.
    #[default]
    Trackball,
    /// Like a plate on a spindle along this world axis.
    Turntable(Axis),
}

/// The unit vector along a world axis.
#[must_use]
pub fn direction(axis: Axis) -> DVec3 {
    match axis {
        Axis::X => DVec3::X,
        Axis::Y => DVec3::Y,
        Axis::Z => DVec3::Z,
    }
}

/// The world axis nearest to the camera's up.
#[must_use]
pub fn spindle(camera: &Camera) -> Axis {
    let up = (camera.top_left - camera.bottom_left).abs();
    if up.z >= up.x && up.z >= up.y {
        Axis::Z
    } else if up.y >= up.x {
        Axis::Y
    } else {
        Axis::X
    }
}

/// What is right, up and in front in the scene of this camera: up is the world axis nearest to the camera's.
#[must_use]
pub fn sides(camera: &Camera) -> [DVec3; 3] {
    let axis = direction(spindle(camera));
    let up = axis * (camera.top_left - camera.bottom_left).dot(axis).signum();
    let right = match spindle(camera) {
        Axis::X => DVec3::NEG_Y,
        Axis::Y | Axis::Z => DVec3::X,
    };
    [right, up, right.cross(up)]
}

/// A vector as a rotation.
#[must_use]
pub fn rotation_of(turn: DVec3) -> DQuat {
    let angle_rad = turn.length();
    if angle_rad == 0.0 {
        return DQuat::IDENTITY;
    }
    let (s, c) = libm::sincos(angle_rad * 0.5);
    let v = turn * (s / angle_rad);
    DQuat::from_xyzw(v.x, v.y, v.z, c).normalize()
}

/// Right, up, and towards the eye; unit vectors, the third is up to sign when the plane mirrors the picture.
#[derive(Clone, Copy, Debug)]
struct Frame {
    right: DVec3,
    up: DVec3,
    /// -1 when the plane mirrors the picture: then hands turn it the other way.
    handed: f64,
}

impl Frame {
    fn of(camera: &Camera) -> Frame {
        let right = (camera.top_right - camera.top_left).normalize_or_zero();
        let up = (camera.top_left - camera.bottom_left).normalize_or_zero();
        Frame {
            right,
            up,
            handed: right.cross(up).dot(-view_dir(camera)).signum(),
        }
    }
}

fn radians_per_px(window_height_px: f64) -> f64 {
    std::f64::consts::TAU / window_height_px.max(1.0)
}

/// The turn that makes what is seen follow a hand that moved by that many pixels, right and down. A hand's way
/// of `window_height_px` is a whole turn.
#[must_use]
pub fn orbit(
    camera: &Camera,
    style: OrbitStyle,
    dx_px: f64,
    dy_px: f64,
    window_height_px: f64,
) -> DVec3 {
    let Frame { right, up, handed } = Frame::of(camera);
    let spindle = match style {
        OrbitStyle::Trackball => up,
        OrbitStyle::Turntable(axis) => {
            let axis = direction(axis);
            // Upside down, the plate still follows the hand.
            if axis.dot(up) < 0.0 { -axis } else { axis }
        }
    };
    (right * dy_px + spindle * dx_px) * (-radians_per_px(window_height_px) * handed)
}

/// The angle about a world axis that follows a hand, in radians: across the axis as it is seen, or to the right
/// when it points at the eye.
#[must_use]
pub fn orbit_about(
    camera: &Camera,
    axis: Axis,
    dx_px: f64,
    dy_px: f64,
    window_height_px: f64,
) -> f64 {
    let Frame { right, up, handed } = Frame::of(camera);
    let axis = direction(axis);
    let towards_eye = -axis.dot(view_dir(camera));
    let radians = -radians_per_px(window_height_px) * handed;
    if towards_eye.abs() > AXIS_AT_EYE {
        return radians * dx_px * -towards_eye.signum();
    }
    let (along_right, along_up) = (axis.dot(right), axis.dot(up));
    let seen = libm::hypot(along_right, along_up).max(1e-9);
    radians * (along_right * dy_px + along_up * dx_px) / seen
}

/// The turn about the view that follows a hand to the right, clockwise: a whole turn for `window_height_px`.
#[must_use]
pub fn roll(camera: &Camera, dx_px: f64, window_height_px: f64) -> DVec3 {
    let Frame { handed, .. } = Frame::of(camera);
    view_dir(camera) * (-dx_px * radians_per_px(window_height_px) * handed)
}

/// The turn that makes the camera look from `from` (any length) with `up` upwards.
#[must_use]
pub fn facing(camera: &Camera, from: DVec3, up: DVec3) -> DQuat {
    let basis = |right: DVec3, up: DVec3| DMat3::from_cols(right, up, right.cross(up));
    let now = Frame::of(camera);
    let now_up = (now.up - now.right * now.up.dot(now.right)).normalize_or(now.up);
    let from = from.normalize();
    let up = (up - from * up.dot(from)).normalize();
    let then = basis(up.cross(from) * now.handed, up);
    DQuat::from_mat3(&(then * basis(now.right, now_up).transpose())).normalize()
}

/// The shift along the view by notches of the wheel, each of which leaves 0.95 of the way to the pivot; negative
/// ones move away.
#[must_use]
pub fn dolly(camera: &Camera, pivot: DVec3, notches: f64) -> DVec3 {
    view_dir(camera) * (depth(camera, pivot) * part_of_way(notches))
}

/// The same towards the point at the pivot's depth that pixel (`x_px`, `y_px`) shows: it stays where it is seen.
#[must_use]
pub fn dolly_towards(
    camera: &Camera,
    view: &View,
    (x_px, y_px): (f64, f64),
    pivot: DVec3,
    notches: f64,
) -> DVec3 {
    let ray = view.base + view.dx * (x_px - 0.5) + view.dy * (y_px - 0.5);
    let along = ray.dot(view_dir(camera));
    if along <= 0.0 {
        return dolly(camera, pivot, notches);
    }
    ray * (depth(camera, pivot) / along * part_of_way(notches))
}

/// The shift after which the whole box is seen in `view`, the picture of `camera`, with its centre in the middle. `None`
/// where there is no such place.
#[must_use]
pub fn fit(camera: &Camera, view: &View, bounds: Aabb) -> Option<DVec3> {
    let (width, height) = (view.width as f64, view.height as f64);
    let ray = |x: f64, y: f64| view.base + view.dx * (x - 0.5) + view.dy * (y - 0.5);
    let middle = ray(width * 0.5, height * 0.5).normalize_or_zero();
    let centre = Pivot::Centre.point(bounds);
    let half = bounds.max.as_dvec3() - centre;
    let edges = [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)].map(|(x, y)| ray(x, y));
    let from_side = |i: usize| {
        let inwards = edges[i].cross(edges[(i + 1) % 4]);
        let inwards = inwards * inwards.dot(middle).signum();
        // So far beyond the plane through the centre the box reaches.
        inwards.abs().dot(half) / inwards.dot(middle)
    };
    let distance = (0..4).map(from_side).fold(0.0, f64::max) * FIT_MARGIN;
    // A box without size is seen from anywhere.
    let distance = if distance > 0.0 {
        distance
    } else {
        middle.dot(view.base)
    };
    let shift = centre - middle * distance - camera.eye;
    (!bounds.is_empty() && shift.is_finite()).then_some(shift)
}

fn part_of_way(notches: f64) -> f64 {
    1.0 - libm::pow(DOLLY_NOTCH, notches)
}

/// The shift in the picture plane that keeps the point under the cursor, at the pivot's depth, under a cursor that
/// moves by `plane_step`: the way of the cursor as a vector in the plane.
#[must_use]
pub fn pan(camera: &Camera, pivot: DVec3, plane_step: DVec3) -> DVec3 {
    let plane_depth = (camera.top_left - camera.eye).dot(normal(camera));
    let ratio = match (pivot - camera.eye).dot(normal(camera)) / plane_depth {
        ratio if ratio > 0.0 && ratio.is_finite() => ratio,
        // The pivot lies behind the eye: what stays is a point in the plane.
        _ => 1.0,
    };
    plane_step * -ratio
}

/// The place in the picture, in pixels, where a point is seen; `None` when it lies beside the eye or behind it.
#[must_use]
pub fn place_of(view: &View, point: DVec3) -> Option<(f64, f64)> {
    let rays = DMat3::from_cols(view.dx, view.dy, view.base);
    let m = rays.inverse() * (point - view.eye.as_dvec3());
    let (x, y) = (m.x / m.z + 0.5, m.y / m.z + 0.5);
    (m.z > 0.0 && x.is_finite() && y.is_finite()).then_some((x, y))
}

/// From the eye to the middle of the plane, unit length.
#[must_use]
pub fn view_dir(camera: &Camera) -> DVec3 {
    ((camera.top_right + camera.bottom_left) * 0.5 - camera.eye).normalize_or_zero()
}

/// Square to the plane; the sign does not matter where it is used.
fn normal(camera: &Camera) -> DVec3 {
    (camera.top_right - camera.top_left)
        .cross(camera.bottom_left - camera.top_left)
        .normalize_or_zero()
}

/// How far away the pivot is along the view. Where it lies beside or behind the eye: how far beside, or how far
/// away the plane is, so that a dolly always moves, and never faster and faster.
fn depth(camera: &Camera, pivot: DVec3) -> f64 {
    let to_pivot = pivot - camera.eye;
    let to_plane = (camera.top_right + camera.bottom_left) * 0.5 - camera.eye;
    let along = to_pivot.dot(view_dir(camera));
    if along > 1e-3 * to_plane.length() {
        along
    } else {
        let beside = to_pivot - view_dir(camera) * along;
        beside.length().max(to_plane.length())
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    /// Looks from (0, 0, 5) along -z at a plane of 4 x 3 at z = 1.
    fn camera() -> Camera {
        Camera {
            eye: DVec3::new(0.0, 0.0, 5.0),
            top_left: DVec3::new(-2.0, 1.5, 1.0),
            top_right: DVec3::new(2.0, 1.5, 1.0),
            bottom_left: DVec3::new(-2.0, -1.5, 1.0),
        }
    }

    fn mirrored() -> Camera {
        let c = camera();
        Camera {
            top_left: c.top_right,
            top_right: c.top_left,
            bottom_left: c.bottom_left + DVec3::X * 4.0,
            ..c
        }
    }

    fn turned(c: Camera, turn: DVec3, pivot: DVec3) -> Camera {
        let q = rotation_of(turn);
        c.map(|p| q * (p - pivot) + pivot)
    }

    fn moved(c: Camera, shift: DVec3) -> Camera {
        c.map(|p| p + shift)
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
        for style in [OrbitStyle::Trackball, OrbitStyle::Turntable(Axis::Z)] {
            for (dx, dy) in [(300.0, 0.0), (0.0, 300.0)] {
                let turn = orbit(&camera(), style, dx, dy, 300.0);
                assert!((turn.length() - std::f64::consts::TAU).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn what_is_seen_follows_the_hand_in_every_style_and_through_a_mirror() {
        let p = DVec3::new(0.0, 0.0, 1.0);
        for c in [camera(), mirrored()] {
            for style in [OrbitStyle::Trackball, OrbitStyle::Turntable(Axis::Y)] {
                let before = seen_at(&c, p);
                let right = turned(c, orbit(&c, style, 5.0, 0.0, 300.0), DVec3::ZERO);
                assert!(seen_at(&right, p).0 > before.0 + 1.0);
                let down = turned(c, orbit(&c, style, 0.0, 5.0, 300.0), DVec3::ZERO);
                assert!(seen_at(&down, p).1 > before.1 + 1.0);
            }
        }
    }

    #[test]
    fn a_hand_held_to_an_axis_turns_about_it_alone_and_is_followed() {
        let p = DVec3::new(0.0, 0.0, 1.0);
        for c in [camera(), mirrored()] {
            let angle = |axis, dx, dy| orbit_about(&c, axis, dx, dy, 300.0);
            let about = |axis, angle| turned(c, direction(axis) * angle, DVec3::ZERO);
            let right = about(Axis::Y, angle(Axis::Y, 5.0, 0.0));
            assert!(seen_at(&right, p).0 > seen_at(&c, p).0 + 1.0);
            let down = about(Axis::X, angle(Axis::X, 0.0, 5.0));
            assert!(seen_at(&down, p).1 > seen_at(&c, p).1 + 1.0);
            // z points at the eye: the upper half follows the hand to the right.
            let top = DVec3::new(0.0, 0.5, 1.0);
            let rolled = about(Axis::Z, angle(Axis::Z, 5.0, 0.0));
            assert!(seen_at(&rolled, top).0 > seen_at(&c, top).0 + 0.1);
            assert_eq!(angle(Axis::Y, 0.0, 5.0), 0.0);
        }
    }

    #[test]
    fn roll_turns_the_upper_half_with_the_hand() {
        for c in [camera(), mirrored()] {
            let top = DVec3::new(0.0, 0.5, 1.0);
            let rolled = turned(c, roll(&c, 5.0, 300.0), DVec3::ZERO);
            assert!(seen_at(&rolled, top).0 > seen_at(&c, top).0 + 0.1);
        }
    }

    #[test]
    fn a_view_from_somewhere_has_up_upwards_and_keeps_the_distance() {
        for c in [camera(), mirrored()] {
            for (from, up) in [
                (DVec3::NEG_Y, DVec3::Z),
                (DVec3::X, DVec3::Z),
                (DVec3::Z, DVec3::Y),
                (DVec3::new(1.0, -1.0, 1.0), DVec3::Z),
            ] {
                let q = facing(&c, from, up);
                let then = c.map(|p| q * p);
                near(then.eye, from.normalize() * 5.0, 1e-12);
                let top = (then.top_left - then.bottom_left).normalize();
                assert!(top.dot(up) > 0.5);
                let (_, y) = seen_at(&then, up * 0.1);
                assert!(y < 150.0);
                assert_eq!(Frame::of(&then).handed, Frame::of(&c).handed);
            }
        }
    }

    #[test]
    fn dolly_leaves_95_hundredths_a_notch_and_comes_back() {
        let in_by_2 = moved(camera(), dolly(&camera(), DVec3::ZERO, 2.0));
        assert!((in_by_2.eye.z - 5.0 * 0.95 * 0.95).abs() < 1e-12);
        let back = moved(in_by_2, dolly(&in_by_2, DVec3::ZERO, -2.0));
        near(back.eye, camera().eye, 1e-12);
    }

    #[test]
    fn dolly_towards_the_cursor_keeps_what_is_under_it() {
        let c = camera();
        let view = View::new(&c, 400, 300);
        let p = DVec3::new(0.6, -0.7, 0.0);
        let at = seen_at(&c, p);
        let shift = dolly_towards(&c, &view, at, DVec3::ZERO, 3.0);
        let (x, y) = seen_at(&moved(c, shift), p);
        assert!((x - at.0).abs() < 1e-6 && (y - at.1).abs() < 1e-6);
        assert!((c.eye.z + shift.z - 5.0 * 0.95f64.powi(3)).abs() < 1e-9);
    }

    #[test]
    fn the_point_of_a_pixels_ray_is_seen_in_its_middle() {
        let view = View::new(&camera(), 400, 300);
        let eye = view.eye.as_dvec3();
        for (x, y) in [(0, 0), (399, 17), (200, 299)] {
            let ray = view.direction(x, y);
            let (px, py) = place_of(&view, eye + ray * 1.7).expect("before the eye");
            assert!((px - x as f64 - 0.5).abs() < 1e-9 && (py - y as f64 - 0.5).abs() < 1e-9);
            assert_eq!(place_of(&view, eye - ray), None);
        }
        assert_eq!(place_of(&view, eye), None);
    }

    #[test]
    fn dolly_moves_with_the_pivot_on_the_eye_or_behind_it() {
        for pivot in [camera().eye, DVec3::new(0.0, 0.0, 9.0)] {
            assert!(dolly(&camera(), pivot, 1.0).z < 0.0, "pivot {pivot}");
        }
    }

    #[test]
    fn dolly_through_the_pivot_does_not_run_away() {
        let mut c = camera();
        for _ in 0..1000 {
            c = moved(c, dolly(&c, DVec3::ZERO, 1.0));
        }
        // The plane is 4 away from the eye.
        assert!((-1000.0 * 0.05 * 4.0..0.0).contains(&c.eye.z), "{}", c.eye);
    }

    #[test]
    fn pan_keeps_the_point_at_the_pivots_depth_under_the_cursor() {
        let pivot = DVec3::new(0.0, 0.0, -3.0);
        let p = DVec3::new(0.7, -0.4, -3.0);
        let v = View::new(&camera(), 400, 300);
        let before = seen_at(&camera(), p);
        let step = v.dx * 17.0 + v.dy * -9.0;
        let after = seen_at(&moved(camera(), pan(&camera(), pivot, step)), p);
        assert!((after.0 - before.0 - 17.0).abs() < 1e-9);
        assert!((after.1 - before.1 + 9.0).abs() < 1e-9);
    }

    #[test]
    fn a_box_that_is_fitted_touches_the_border_but_for_the_margin() {
        let bounds = Aabb {
            min: Vec3::new(30.0, 4.0, -7.0),
            max: Vec3::new(31.0, 9.0, 3.0),
        };
        let corners = (0..8).map(|i| {
            let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
            let of = |bit: i32, a: f64, b: f64| if i & bit == 0 { a } else { b };
            DVec3::new(
                of(1, min.x, max.x),
                of(2, min.y, max.y),
                of(4, min.z, max.z),
            )
        });
        let aside = camera().map(|p| p + DVec3::new(0.0, 0.0, if p.z > 4.0 { 0.0 } else { 1.0 }));
        for c in [camera(), mirrored(), aside] {
            let q = facing(&c, DVec3::new(1.0, -2.0, 0.5), DVec3::Z);
            let c = c.map(|p| q * p);
            let shift = fit(&c, &View::new(&c, 400, 300), bounds).expect("a place");
            let view = View::new(&moved(c, shift), 400, 300);
            // 0 in the middle, 1 at the border.
            let off = corners.clone().map(|p| {
                let (x, y) = place_of(&view, p).expect("before the eye");
                (x / 200.0 - 1.0).abs().max((y / 150.0 - 1.0).abs())
            });
            let off = off.fold(0.0, f64::max);
            assert!(off < 1.0 && off > 0.8, "{off}");
        }
        let view = View::new(&camera(), 400, 300);
        assert_eq!(fit(&camera(), &view, Aabb::EMPTY), None);
        let point = Aabb::EMPTY.with(Vec3::ONE);
        let shift = fit(&camera(), &view, point).expect("a place");
        near(camera().eye + shift, DVec3::new(1.0, 1.0, 5.0), 1e-6);
    }

    #[test]
    fn the_sides_of_a_scene_are_right_handed_about_its_up() {
        let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
        for (up, right, front) in [
            (y, x, z),
            (z, x, -y),
            (x, -y, z),
            (-y, x, -z),
            (-z, x, y),
            (-x, -y, -z),
        ] {
            let from = front + up * 0.4 + right * 0.2;
            let q = facing(&camera(), from, up);
            assert_eq!(sides(&camera().map(|p| q * p)), [right, up, front]);
        }
    }

    #[test]
    fn the_spindle_is_the_axis_that_is_most_upright() {
        assert_eq!(spindle(&camera()), Axis::Y);
        let q = facing(&camera(), DVec3::new(1.0, -2.0, 0.5), DVec3::Z);
        assert_eq!(spindle(&camera().map(|p| q * p)), Axis::Z);
    }
}
