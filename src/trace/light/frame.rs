//! The plane that the light looks at.

use glam::{DVec3, Vec3};

use crate::geometry::Aabb;
use crate::simd::{Lanes, SimdBase};
use crate::trace::space::ROUNDOFF;

/// Scenes of these magnitudes are what the error bounds hold for.
const TAME: std::ops::RangeInclusive<f32> = 1e-8..=1e10;

/// A point as the light sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Across the light; its error is that of `f64`.
    pub x: f64,
    /// Across the light.
    pub y: f64,
    /// Toward it: larger is nearer to the light. Exact.
    pub z: f32,
}

/// The frame of the light: the axis along which its direction is longest is z, and x and y are sheared so that rays
/// toward the light keep them.
#[derive(Clone, Copy, Debug)]
pub struct LightFrame {
    /// Where the light is.
    pub dir: Vec3,
    /// x and y of a point are its products with these: 1 along an axis, and the shear along z.
    across: [DVec3; 2],
    /// z is its product with this: 1 or −1 along an axis.
    up: Vec3,
    /// Origins farther out than this have no place in the frame; 0 when nothing has.
    reach: f32,
    /// The middle of the scene.
    middle: Vec3,
    /// Corners are closer to the middle than this along every axis; 0 when nothing is.
    pub half: f32,
    /// More than the rule of free rays moves a corner across the light by rounding it.
    pub blur: f64,
}

impl LightFrame {
    /// The frame for a scene with these bounds; `dir` is where the light is.
    pub fn new(dir: Vec3, bounds: &Aabb) -> LightFrame {
        let d = dir.to_array();
        let largest = dir.abs().max_element();
        let z = d.iter().position(|x| x.abs() == largest).unwrap_or(2);
        let axes = [[1, 2, 0], [2, 0, 1], [0, 1, 2]][z];
        let scene = if bounds.is_empty() {
            0.0
        } else {
            bounds.min.abs().max(bounds.max.abs()).max_element()
        };
        let reach = if TAME.contains(&scene) {
            scene * 1.0625
        } else {
            0.0
        };
        let middle = if reach > 0.0 {
            ((bounds.min.as_dvec3() + bounds.max.as_dvec3()) * 0.5).as_vec3()
        } else {
            Vec3::ZERO
        };
        let half = (bounds.max - middle).max(middle - bounds.min).max_element() * 1.0625;
        let half = if reach > 0.0 && TAME.contains(&half) {
            half
        } else {
            0.0
        };
        let mut up = Vec3::ZERO;
        up[axes[2]] = 1f32.copysign(d[axes[2]]);
        LightFrame {
            dir,
            across: [0, 1].map(|k| {
                let mut row = DVec3::ZERO;
                row[axes[k]] = 1.0;
                row[axes[2]] = -f64::from(d[axes[k]]) / f64::from(d[axes[2]]);
                row
            }),
            up,
            reach,
            middle,
            half,
            // Two roundings of numbers up to twice the reach; this is 16 of the reach.
            blur: f64::from(reach * (16.0 * ROUNDOFF)),
        }
    }

    /// Whether the error bounds hold for rays from `origin`.
    #[inline(always)]
    pub fn holds(&self, origin: Vec3) -> bool {
        origin.abs().max_element() < self.reach && origin.is_finite()
    }

    /// True when the frame is of use at all.
    pub fn is_tame(&self) -> bool {
        self.reach > 0.0
    }

    /// A point of space in this frame, counted from the middle of the scene.
    pub fn centred(&self, p: Vec3) -> DVec3 {
        let q = p.as_dvec3() - self.middle.as_dvec3();
        DVec3::new(
            self.across[0].dot(q),
            self.across[1].dot(q),
            self.up.as_dvec3().dot(q),
        )
    }

    /// Where the middle of the scene is.
    pub fn middle(&self) -> DVec3 {
        let Seen { x, y, z } = self.see(self.middle);
        DVec3::new(x, y, f64::from(z))
    }

    /// As [`LightFrame::centred`] in `f32`, and the largest distance along an axis of space. x and y are wrong
    /// by less than 6 unit roundoffs of that, z by less than one.
    #[inline(always)]
    pub fn centred_many<S: Lanes>(&self, simd: S, p: [S::f32s; 3]) -> [S::f32s; 4] {
        macro_rules! splat {
            ($x:expr) => {
                S::f32s::splat(simd, $x as f32)
            };
        }
        let [x, y, z] = p;
        let m = self.middle;
        let q = [x - splat!(m.x), y - splat!(m.y), z - splat!(m.z)];
        macro_rules! dot {
            ($row:expr) => {
                splat!($row.x) * q[0] + (splat!($row.y) * q[1] + splat!($row.z) * q[2])
            };
        }
        let far = q[0].abs().max(q[1].abs().max(q[2].abs()));
        [
            dot!(self.across[0]),
            dot!(self.across[1]),
            dot!(self.up),
            far,
        ]
    }

    /// A point of space in this frame.
    #[inline(always)]
    pub fn see(&self, p: Vec3) -> Seen {
        let q = p.as_dvec3();
        Seen {
            x: self.across[0].dot(q),
            y: self.across[1].dot(q),
            z: self.up.dot(p),
        }
    }
}
