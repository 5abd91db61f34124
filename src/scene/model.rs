//! What a scene file says, as plain data.

use glam::Vec3;

use crate::color::Rgb;
use crate::math::Axis;

/// A whole scene, exactly as a file states it. Knows nothing of rays.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// `<d` or `<s`.
    pub camera: CameraSetting,
    /// The direction in which the light travels; any length but zero.
    pub light: Vec3,
    /// In file order: the index is the triangle's id everywhere.
    pub triangles: Vec<Triangle>,
    /// Turns of the camera, in the order in which they are applied.
    pub operations: Vec<Operation>,
}

/// Where the camera stands before any operation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CameraSetting {
    /// `<d`: above the figure, see [`crate::camera::Camera::default_for`].
    Default,
    /// `<s`: as the file says.
    Set(CameraCorners),
}

/// The twelve numbers of an `<s` camera, in the file's order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraCorners {
    /// E, where the rays start.
    pub eye: Vec3,
    /// O, the top-left corner of the projection plane.
    pub top_left: Vec3,
    /// A, its top-right corner.
    pub top_right: Vec3,
    /// B, its bottom-left corner.
    pub bottom_left: Vec3,
}

/// A coloured triangle; both sides are visible.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    /// Corners A, B, C.
    pub corners: [Vec3; 3],
    /// The colour it shows when it mirrors the eye straight into the light.
    pub color: Rgb,
}

/// One turn of the camera about a world axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Operation {
    /// The axis, through the pivot.
    pub axis: Axis,
    /// Right-handed angle in radians.
    pub angle_rad: f64,
}
