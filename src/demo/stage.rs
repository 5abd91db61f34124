//! Where the camera stands, how it moves, where the light comes from.

use std::f64::consts::FRAC_PI_4;

use glam::Vec3;

use super::mesh::{Mesh, rounded};
use crate::scene::{Axis, CameraCorners, CameraSetting, Operation, Scene};

/// A scene with a 16:9 camera. `eye` looks at `target`; `half_height` of the scene fits between the picture's
/// middle and its top there. `to_light` points to the light. z is up.
pub fn scene(
    mesh: Mesh,
    (eye, target, half_height): (Vec3, Vec3, f32),
    to_light: Vec3,
    operations: Vec<Operation>,
) -> Scene {
    Scene {
        camera: CameraSetting::Set(camera(eye, target, half_height)),
        light: rounded(-to_light),
        triangles: mesh.into_triangles(),
        operations,
    }
}

fn camera(eye: Vec3, target: Vec3, half_height: f32) -> CameraCorners {
    let right = (target - eye).cross(Vec3::Z).normalize();
    let up = right.cross(target - eye).normalize();
    let (w, h) = (right * half_height * 16.0 / 9.0, up * half_height);
    CameraCorners {
        eye: rounded(eye),
        top_left: rounded(target - w + h),
        top_right: rounded(target + w + h),
        bottom_left: rounded(target - w - h),
    }
}

/// A turn about a world axis.
pub fn turn(axis: Axis, angle_rad: f64) -> Operation {
    Operation { axis, angle_rad }
}

/// Once around the z axis in eight steps, the second half of it from higher up by `lift_rad`, then on by `last_rad` to
/// the still picture. For cameras that stand at -y: only there, and at +y, does a turn about x lift them.
pub fn turntable(lift_rad: f64, last_rad: f64) -> Vec<Operation> {
    let mut operations = Vec::new();
    for _ in 0..2 {
        operations.extend([turn(Axis::Z, FRAC_PI_4); 4]);
        operations.push(turn(Axis::X, lift_rad));
    }
    if last_rad != 0.0 {
        operations.push(turn(Axis::Z, last_rad));
    }
    operations
}
