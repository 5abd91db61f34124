//! A tile's own frame: where everything is small near the tile, rounding is small too.
//!
//! With `b` the direction through the tile's centre, a point `q` relative to the eye is `q = u·dx + v·dy + w·b`.
//! The ray of a pixel is then (x′, y′, 1), with x′ and y′ the pixel's distance from the tile's centre: at most
//! 31.5. A point lies on screen at (u/w, v/w), and `w` is its distance in lengths of the ray's direction, times
//! one power of two a frame that brings the scene's largest `w` to about 1.
//!
//! The rounding of this transform decides pixels; so the tile size is part of the definition of the picture.

use glam::{DVec3, Vec3};

use crate::camera::View;
use crate::geometry::Aabb;
use crate::math::power_of_two_below;

/// Pixels of a tile each way.
pub const TILE: usize = 64;

/// Largest |x′| and |y′| of a pixel of a tile.
pub const HALF: f32 = (TILE as f32 - 1.0) / 2.0;

/// The unit roundoff of `f32`.
pub const ROUNDOFF: f32 = 1.0 / 16_777_216.0;

/// What is the same for all tiles of a picture.
#[derive(Clone, Copy, Debug)]
pub struct Rig {
    view: View,
    /// Largest magnitude of a coordinate of the scene, by axis: bounds the rounding.
    reach: DVec3,
    /// Power of two by which the rows are multiplied.
    scale: f64,
}

/// The frame of one tile.
#[derive(Clone, Copy, Debug)]
pub struct TileSpace {
    /// The eye.
    pub eye: Vec3,
    /// Rows of the transform: u, v, w of a point relative to the eye.
    pub rows: [Vec3; 3],
    /// For boxes: `row · p` is within ± `slack` of `row · eye` plus the exact value. Only culling uses it.
    pub offset: Vec3,
    /// See `offset`.
    pub slack: Vec3,
    /// Last column and last row of the tile that lie in the picture, 0 to 63: beyond them nothing need be found.
    pub last: [u8; 2],
}

/// A point in a tile's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Uvw {
    /// Screen x, times `w`.
    pub u: f32,
    /// Screen y, times `w`.
    pub v: f32,
    /// Distance along the rays.
    pub w: f32,
}

impl Rig {
    /// The frame of a picture of a scene with these bounds.
    #[must_use]
    pub fn new(view: &View, bounds: Aabb) -> Rig {
        let (low, high) = if bounds.is_empty() {
            (DVec3::ZERO, DVec3::ZERO)
        } else {
            (bounds.min.as_dvec3(), bounds.max.as_dvec3())
        };
        let row = view.dx.cross(view.dy) / view.dx.dot(view.dy.cross(view.base));
        let eye = view.eye.as_dvec3();
        let w_max = (row * (low - eye)).max(row * (high - eye)).element_sum();
        let scale = if w_max.is_finite() && w_max > 0.0 {
            1.0 / power_of_two_below(w_max)
        } else {
            1.0
        };
        Rig {
            view: *view,
            reach: low.abs().max(high.abs()),
            scale,
        }
    }

    /// `t`, in lengths of a ray's direction, is `w` times this power of two.
    #[must_use]
    pub fn t_per_w(&self) -> f32 {
        (1.0 / self.scale) as f32
    }

    /// The frame of the tile whose first pixel is (`x`, `y`).
    #[must_use]
    pub fn tile(&self, x: usize, y: usize) -> TileSpace {
        let View { dx, dy, eye, .. } = self.view;
        let b =
            self.view.base + dx * (x as f64 + f64::from(HALF)) + dy * (y as f64 + f64::from(HALF));
        let determinant = dx.dot(dy.cross(b));
        let row = |v: DVec3| (v / determinant * self.scale).as_vec3();
        let rows = [row(dy.cross(b)), row(b.cross(dx)), row(dx.cross(dy))];
        let eye64 = eye.as_dvec3();
        let offset = rows.map(|r| -r.as_dvec3().dot(eye64));
        // 16 roundings of the largest terms: more than the box test and the transform of a vertex make together.
        let slack = rows.map(|r| {
            r.as_dvec3().abs().dot(eye64.abs() + self.reach) * (16.0 * f64::from(ROUNDOFF))
        });
        TileSpace {
            eye,
            rows,
            offset: DVec3::from(offset).as_vec3(),
            slack: DVec3::from(slack).as_vec3(),
            last: [(self.view.width, x), (self.view.height, y)]
                .map(|(size, first)| size.saturating_sub(first + 1).min(TILE - 1) as u8),
        }
    }
}

impl TileSpace {
    /// The transform of a vertex: `f32`, every operation rounded, in this order.
    #[inline(always)]
    #[must_use]
    pub fn transform(&self, p: Vec3) -> Uvw {
        let q = p - self.eye;
        let [u, v, w] = self.rows.map(|r| (r.x * q.x + r.y * q.y) + r.z * q.z);
        Uvw { u, v, w }
    }
}
