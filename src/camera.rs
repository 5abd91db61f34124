//! Eye and projection plane in `f64`, and the rays of one picture's pixels.

use glam::{DMat3, DVec3, Vec3};

use crate::geometry::Aabb;
use crate::scene::{CameraCorners, CameraSetting, Scene};

/// The largest width or height of a picture.
pub const MAX_SIZE: usize = 16384;

/// Half the angle of view of the default camera, top to bottom: 22.5 degrees.
const DEFAULT_HALF_ANGLE_RAD: f64 = std::f64::consts::FRAC_PI_8;

/// The eye and three corners of the projection plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where the rays start.
    pub eye: DVec3,
    /// Top-left corner of the projection plane (O).
    pub top_left: DVec3,
    /// Top-right corner (A).
    pub top_right: DVec3,
    /// Bottom-left corner (B).
    pub bottom_left: DVec3,
}

/// What the operations turn the camera about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pivot {
    /// The world's origin, as the format says.
    #[default]
    Origin,
    /// The centre of the box of all triangles.
    Centre,
}

impl Pivot {
    /// The point itself, for a scene with these bounds (the origin when they are empty).
    #[must_use]
    pub fn point(self, bounds: Aabb) -> DVec3 {
        match self {
            Pivot::Centre if !bounds.is_empty() => centre(bounds),
            _ => DVec3::ZERO,
        }
    }
}

fn centre(bounds: Aabb) -> DVec3 {
    (bounds.min.as_dvec3() + bounds.max.as_dvec3()) * 0.5
}

impl Camera {
    /// The scene's camera before any operation; `bounds` is the box of all its triangles.
    #[must_use]
    pub fn of_scene(scene: &Scene, bounds: Aabb) -> Camera {
        match scene.camera {
            CameraSetting::Default => Camera::default_for(bounds),
            CameraSetting::Set(corners) => Camera::from(corners),
        }
    }

    /// The `<d` camera: straight above (+z) the box, the picture's right is +x and its top +y; 4:3.
    #[must_use]
    pub fn default_for(bounds: Aabb) -> Camera {
        let bounds = if bounds.is_empty() {
            Aabb {
                min: Vec3::splat(-0.5),
                max: Vec3::splat(0.5),
            }
        } else {
            bounds
        };
        let c = centre(bounds);
        let h = (bounds.max.as_dvec3() - bounds.min.as_dvec3()) * 0.5;
        let tan = libm::tan(DEFAULT_HALF_ANGLE_RAD);
        let dist = match 1.05 * (h.x * 0.75).max(h.y) / tan {
            0.0 => 1.0,
            d => d,
        };
        let z_max = f64::from(bounds.max.z);
        let half_height = dist * tan;
        let half_width = half_height * 4.0 / 3.0;
        let corner =
            |sx: f64, sy: f64| DVec3::new(c.x + sx * half_width, c.y + sy * half_height, z_max);
        let round = |p: DVec3| p.as_vec3().as_dvec3();
        Camera {
            eye: round(DVec3::new(c.x, c.y, z_max + dist)),
            top_left: round(corner(-1.0, 1.0)),
            top_right: round(corner(1.0, 1.0)),
            bottom_left: round(corner(-1.0, -1.0)),
        }
    }

    /// Eye and all three corners turned about `pivot`.
    #[must_use]
    pub fn turned(self, rotation: DMat3, pivot: DVec3) -> Camera {
        self.map(|p| rotation * (p - pivot) + pivot)
    }

    /// Every point of the camera replaced by `f` of it.
    #[must_use]
    pub fn map(self, f: impl Fn(DVec3) -> DVec3) -> Camera {
        Camera {
            eye: f(self.eye),
            top_left: f(self.top_left),
            top_right: f(self.top_right),
            bottom_left: f(self.bottom_left),
        }
    }

    /// Length of the plane's top and left side.
    #[must_use]
    pub fn plane_size(self) -> (f64, f64) {
        (
            (self.top_right - self.top_left).length(),
            (self.bottom_left - self.top_left).length(),
        )
    }

    /// The plane widened about its centre to the shape of a `width` x `height` picture: never cropped,
    /// never stretched.
    #[must_use]
    pub fn widened(self, width: usize, height: usize) -> Camera {
        let (s, t) = self.plane_size();
        let (w, h) = (width as f64, height as f64);
        if (s * h - t * w).abs() <= 0.5 * s.max(t) {
            return self;
        }
        let right = self.top_right - self.top_left;
        let down = self.bottom_left - self.top_left;
        let centre = self.top_left + (right + down) * 0.5;
        let (right, down) = if w / h > s / t {
            (right * (t * w / h / s), down)
        } else {
            (right, down * (s * h / w / t))
        };
        let top_left = centre - (right + down) * 0.5;
        Camera {
            eye: self.eye,
            top_left,
            top_right: top_left + right,
            bottom_left: top_left + down,
        }
    }

    /// The rays of a `width` x `height` picture: the plane widened to its shape, or with `stretch` as it is.
    #[must_use]
    pub fn view(self, width: usize, height: usize, stretch: bool) -> View {
        if stretch {
            View::new(&self, width, height)
        } else {
            View::new(&self.widened(width, height), width, height)
        }
    }

    /// The picture's size when none is asked for: height 480 and the plane's shape, each 1..=16384.
    /// (The default camera's 4:3 gives 640x480.)
    #[must_use]
    pub fn default_size(self) -> (usize, usize) {
        let (s, t) = self.plane_size();
        let width = (480.0 * s / t).round().clamp(1.0, MAX_SIZE as f64);
        // A default camera far from the origin may have lost its plane to rounding: still 4:3.
        (if width.is_nan() { 640 } else { width as usize }, 480)
    }
}

impl From<CameraCorners> for Camera {
    fn from(c: CameraCorners) -> Camera {
        Camera {
            eye: c.eye.as_dvec3(),
            top_left: c.top_left.as_dvec3(),
            top_right: c.top_right.as_dvec3(),
            bottom_left: c.bottom_left.as_dvec3(),
        }
    }
}

/// The rays of one picture: pixel (x, y) looks from `eye` along `base + x·dx + y·dy`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Pixels a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Where all rays start: the camera's eye rounded to `f32`.
    pub eye: Vec3,
    /// Direction through the centre of pixel (0, 0), from the rounded eye.
    pub base: DVec3,
    /// One pixel to the right.
    pub dx: DVec3,
    /// One pixel down.
    pub dy: DVec3,
}

impl View {
    /// The plane mapped onto a `width` x `height` picture as it is (see [`Camera::widened`]).
    #[must_use]
    pub fn new(camera: &Camera, width: usize, height: usize) -> View {
        let eye = camera.eye.as_vec3();
        let dx = (camera.top_right - camera.top_left) / width as f64;
        let dy = (camera.bottom_left - camera.top_left) / height as f64;
        View {
            width,
            height,
            eye,
            base: camera.top_left + dx * 0.5 + dy * 0.5 - eye.as_dvec3(),
            dx,
            dy,
        }
    }

    /// The direction of pixel (`x`, `y`), not normalised.
    #[must_use]
    pub fn direction(&self, x: usize, y: usize) -> DVec3 {
        self.base + self.dx * x as f64 + self.dy * y as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit_box() -> Aabb {
        Aabb {
            min: Vec3::splat(-1.0),
            max: Vec3::splat(1.0),
        }
    }

    #[test]
    fn default_camera_looks_down_with_x_right_and_y_up() {
        let c = Camera::default_for(unit_box());
        assert!(c.eye.z > 1.0 && c.eye.x == 0.0 && c.eye.y == 0.0);
        assert!(c.top_right.x > c.top_left.x && c.top_left.y > c.bottom_left.y);
        assert_eq!(c.default_size(), (640, 480));
        let v = View::new(&c, 640, 480);
        assert!(v.direction(0, 0).z < 0.0);
    }

    #[test]
    fn default_camera_of_nothing_and_of_a_point_has_a_size() {
        assert_eq!(Camera::default_for(Aabb::EMPTY).default_size(), (640, 480));
        let point = Aabb::EMPTY.with(Vec3::ONE);
        assert_eq!(Camera::default_for(point).eye.z, 2.0);
    }

    #[test]
    fn widening_keeps_the_centre_and_never_crops() {
        let c = Camera::default_for(unit_box());
        let (s, t) = c.plane_size();
        for (w, h) in [(1920, 1080), (100, 1000), (640, 480)] {
            let d = c.widened(w, h);
            let (s2, t2) = d.plane_size();
            assert!(
                s2 >= s * 0.999_999 && t2 >= t * 0.999_999,
                "{w}x{h} cropped"
            );
            let shape = s2 / t2 / (w as f64 / h as f64);
            assert!((shape - 1.0).abs() < 1e-3, "{w}x{h} has shape {shape}");
            let mid = |c: Camera| (c.top_right + c.bottom_left) * 0.5;
            assert!((mid(c) - mid(d)).length() < 1e-12);
        }
        assert_eq!(c.widened(640, 480), c);
    }

    #[test]
    fn a_view_is_widened_unless_stretched() {
        let c = Camera::default_for(unit_box());
        assert_eq!(c.view(200, 100, true), View::new(&c, 200, 100));
        let wide = c.widened(200, 100);
        assert_eq!(c.view(200, 100, false), View::new(&wide, 200, 100));
        assert_ne!(c.view(200, 100, true), c.view(200, 100, false));
    }
}
