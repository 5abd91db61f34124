//! Axis-aligned bounding boxes.

use glam::Vec3;

use crate::scene::Triangle;

/// An axis-aligned box; [`Aabb::EMPTY`] has `min > max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Smallest coordinates.
    pub min: Vec3,
    /// Largest coordinates.
    pub max: Vec3,
}

impl Aabb {
    /// The box of nothing: joining it with a box gives that box.
    pub const EMPTY: Aabb = Aabb {
        min: Vec3::INFINITY,
        max: Vec3::NEG_INFINITY,
    };

    /// The smallest box around `triangles`, the empty box for none.
    #[must_use]
    pub fn of_triangles(triangles: &[Triangle]) -> Aabb {
        triangles
            .iter()
            .flat_map(|t| t.corners)
            .fold(Aabb::EMPTY, |b, p| b.with(p))
    }

    /// This box grown to hold `p`.
    #[must_use]
    pub fn with(self, p: Vec3) -> Aabb {
        Aabb {
            min: self.min.min(p),
            max: self.max.max(p),
        }
    }

    /// The smallest box around both.
    #[must_use]
    pub fn join(self, other: Aabb) -> Aabb {
        Aabb {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    /// True for a box that holds no point.
    #[must_use]
    pub fn is_empty(self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// True when `other` lies inside (the empty box lies inside every box).
    #[must_use]
    pub fn contains(self, other: Aabb) -> bool {
        other.is_empty() || (self.min.cmple(other.min).all() && self.max.cmpge(other.max).all())
    }

    /// Half of the surface area: what the surface area heuristic needs. 0 for the empty box.
    #[must_use]
    pub fn half_area(self) -> f32 {
        if self.is_empty() {
            return 0.0;
        }
        let d = self.max - self.min;
        d.x * d.y + d.y * d.z + d.z * d.x
    }
}
