//! A ray, prepared for the way down a [`super::RayTree`], and what it has met so far.

use glam::Vec3;

use super::Ray;
use super::frame::FLAT;
use crate::frame::MISS;
use crate::geometry::Aabb;
use crate::trace::space::ROUNDOFF;

/// The axes x, y, z in the order x′, y′, z′ for each z′.
pub const AXES: [[usize; 3]; 3] = [[1, 2, 0], [2, 0, 1], [0, 1, 2]];

/// The nearest hit so far: which triangle, and how far away.
#[derive(Clone, Copy, Debug)]
pub struct Nearest {
    /// The distance is not below this.
    pub low: f32,
    /// And not above this. Both are the end of the ray while there is no hit.
    pub high: f32,
    /// Block times 8 plus lane, or [`MISS`].
    pub slot: u32,
}

/// A ray, prepared. Its numbers only cull, and decide what is certain; see [`super::frame`] and [`super::block`].
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug)]
pub struct Ready {
    /// Slabs of a box, by axis: distance = bound · `inverse` + offset.
    pub inverse: [f32; 4],
    pub near_offset: [f32; 4],
    pub far_offset: [f32; 4],
    pub nearest: Nearest,
    pub t_min: f32,
    /// The origin, its axes in the order x′, y′, z′: z′ is the one along which the direction is longest.
    pub origin: [f32; 3],
    /// Minus the direction along x′ and y′, by that along z′.
    pub shear: [f32; 2],
    /// 1 / direction along z′.
    pub inverse_z: f32,
    /// z′.
    pub longest: u32,
}

/// What the rays of a scene have in common.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    /// The largest magnitude of a coordinate.
    pub reach: f32,
}

impl Extent {
    /// Of a scene with these bounds.
    pub fn new(bounds: &Aabb) -> Extent {
        Extent {
            reach: bounds.min.abs().max(bounds.max.abs()).max_element(),
        }
    }
}

#[inline(always)]
pub fn largest(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[inline(always)]
pub fn smallest(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline(always)]
pub fn largest_of(v: Vec3) -> f32 {
    largest(v.x, largest(v.y, v.z))
}

impl Ready {
    /// Prepares a tame ray.
    #[inline(always)]
    pub fn new(ray: &Ray, extent: &Extent) -> Ready {
        let o = ray.origin.extend(0.0).to_array();
        let d = ray.dir.extend(0.0).to_array();
        let reach = largest(extent.reach, largest_of(ray.origin.abs()));
        let longest = largest_of(ray.dir.abs());
        // Of any distance to a side, rounding makes an error below 12 roundings of the reach; this is 16.
        let slack = reach * (16.0 * ROUNDOFF);
        let least = longest * FLAT;
        let (mut inverse, mut near_offset, mut far_offset) = ([0.0; 4], [0.0; 4], [0.0; 4]);
        for k in 0..4 {
            let steep = if d[k].abs() < least {
                least.copysign(d[k])
            } else {
                d[k]
            };
            inverse[k] = 1.0 / steep;
            let outward = slack.copysign(inverse[k]);
            near_offset[k] = -(o[k] + outward) * inverse[k];
            far_offset[k] = -(o[k] - outward) * inverse[k];
        }
        // 0, 1 or 2 without a branch.
        let (x, y) = (d[0].abs() == longest, d[1].abs() == longest);
        let z = (1 - usize::from(x)) * (2 - usize::from(y));
        let [ax, ay, az] = AXES[z];
        let shear = d.map(|x| x / -d[az]);
        Ready {
            inverse,
            near_offset,
            far_offset,
            nearest: Nearest {
                low: ray.t_max,
                high: ray.t_max,
                slot: MISS,
            },
            t_min: ray.t_min,
            origin: [o[ax], o[ay], o[az]],
            shear: [shear[ax], shear[ay]],
            inverse_z: inverse[az],
            longest: z as u32,
        }
    }
}
