//! A ray's own frame: what the tests of boxes and the first look at a leaf need. It only culls, with all rounding
//! errors on the safe side.

use glam::Vec3;

use super::Ray;
use crate::geometry::Aabb;
use crate::trace::space::ROUNDOFF;

/// Scenes and origins within these magnitudes are what the error bounds hold for.
pub(super) const TAME_SCENE: std::ops::RangeInclusive<f32> = 8.7e-19..=1.1e15;
/// And directions within these.
pub(super) const TAME_DIR: std::ops::RangeInclusive<f32> = 9.1e-13..=1.1e12;

/// A coordinate of the direction below this part of the largest one is taken for it: it keeps reciprocals in range.
pub(super) const FLAT: f32 = 1.0 / 1_073_741_824.0;

/// A ray, prepared.
#[derive(Clone, Copy, Debug)]
pub struct RayFrame {
    /// The ray's origin, its axes in the order of `axes`.
    pub origin: [f32; 3],
    /// The axes x, y, z (0..3) in the order x′, y′, z′: z′ is the one along which the direction is longest.
    pub axes: [usize; 3],
    /// A point lies at x′ − `shear[0]`·z′ and y′ − `shear[1]`·z′ when seen along the ray.
    pub shear: [f32; 2],
    /// Twice the error of those two numbers.
    pub blur: f32,
    /// Slabs of a box, by space axis: distance = bound · `inverse` + offset.
    pub inverse: [f32; 3],
    /// Offset that makes the near sides' distances too small, not too large.
    pub near_offset: [f32; 3],
    /// Offset that makes the far sides' distances too large.
    pub far_offset: [f32; 3],
    /// Row of the near sides in [`crate::bvh::Node::bounds`]; the far side's is the other one of its axis.
    pub near_row: [usize; 3],
}

impl RayFrame {
    /// Prepares a ray for a scene with these bounds (not empty). `None` when its numbers are so large or so small
    /// that the error bounds would not hold.
    #[inline(always)]
    pub fn new(ray: &Ray, bounds: &Aabb) -> Option<RayFrame> {
        let longest = ray.dir.abs().max_element();
        let reach = bounds
            .min
            .abs()
            .max(bounds.max.abs())
            .max(ray.origin.abs())
            .max_element();
        if !TAME_SCENE.contains(&reach) || !TAME_DIR.contains(&longest) {
            return None;
        }
        let dir = ray.dir.to_array();
        let z = if dir[0].abs() == longest {
            0
        } else if dir[1].abs() == longest {
            1
        } else {
            2
        };
        let axes = [[1, 2, 0], [2, 0, 1], [0, 1, 2]][z];
        let origin = ray.origin.to_array();
        // Of any distance to a side, rounding makes an error below 12 roundings of the reach; this is 16.
        let slack = reach * (16.0 * ROUNDOFF);
        let mut frame = RayFrame {
            origin: axes.map(|k| origin[k]),
            axes,
            shear: [dir[axes[0]] / dir[z], dir[axes[1]] / dir[z]],
            // Of x' and y', less than 4 roundings of numbers up to twice the reach.
            blur: reach * (16.0 * ROUNDOFF),
            inverse: [0.0; 3],
            near_offset: [0.0; 3],
            far_offset: [0.0; 3],
            near_row: [0; 3],
        };
        let least = longest * FLAT;
        for k in 0..3 {
            let d = if dir[k].abs() < least {
                least.copysign(dir[k])
            } else {
                dir[k]
            };
            let inverse = 1.0 / d;
            let outward = slack.copysign(inverse);
            frame.inverse[k] = inverse;
            frame.near_offset[k] = -(origin[k] + outward) * inverse;
            frame.far_offset[k] = -(origin[k] - outward) * inverse;
            frame.near_row[k] = if inverse >= 0.0 { k } else { k + 3 };
        }
        Some(frame)
    }
}

/// Whether the ray is one at all: finite, and with a direction.
#[inline(always)]
pub fn is_ray(ray: &Ray) -> bool {
    ray.origin.is_finite() && ray.dir.is_finite() && ray.dir != Vec3::ZERO
}
