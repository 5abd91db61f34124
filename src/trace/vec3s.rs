//! Vectors of three numbers, one a lane.

use super::space::TILE;
use crate::simd::{Lanes, Simd, SimdBase};

/// A vector (u, v, w) a lane.
pub type Vec3s<S> = [<S as Simd>::f32s; 3];

/// The cross product.
#[inline(always)]
pub fn cross<S: Lanes>(a: Vec3s<S>, b: Vec3s<S>) -> Vec3s<S> {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// The difference.
#[inline(always)]
pub fn sub<S: Lanes>(a: Vec3s<S>, b: Vec3s<S>) -> Vec3s<S> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// The sum.
#[inline(always)]
pub fn add<S: Lanes>(a: Vec3s<S>, b: Vec3s<S>) -> Vec3s<S> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// |u| + |v| + 32|w|: bounds every term of an edge function over the tile.
#[inline(always)]
pub fn size<S: Lanes>(simd: S, a: Vec3s<S>) -> S::f32s {
    (a[0].abs() + a[1].abs()) + a[2].abs() * S::f32s::splat(simd, TILE as f32 / 2.0)
}
