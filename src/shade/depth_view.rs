//! Distance as grey: near is bright.
//!
//! The scale spans the scene's bounding sphere as seen from the eye, so turning the camera about the scene's centre
//! leaves it as it is and an animation does not flicker.

use super::{Shader, dot, pixel};
use crate::camera::View;
use crate::world::World;

/// The darkest hit, so that it differs from the background.
const DARKEST: f32 = 24.0;

/// Nearest and farthest distance from the eye to the bounding sphere.
#[must_use]
pub fn range(world: &World, view: &View) -> (f32, f32) {
    let bounds = world.bounds();
    if bounds.is_empty() {
        return (0.0, 1.0);
    }
    let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
    let radius = (max - min).length() * 0.5;
    let distance = ((min + max) * 0.5 - view.eye.as_dvec3()).length();
    (
        (distance - radius).max(0.0) as f32,
        (distance + radius) as f32,
    )
}

/// The grey of a hit at 1/w = `z`.
#[inline(always)]
pub fn color(shader: &Shader<'_>, x: usize, y: usize, z: f32) -> u32 {
    let ray = shader.rays.at(x, y);
    let t = (1.0 / z) * shader.t_per_w;
    let distance = dot(ray, ray).sqrt() * shader.rays.scale * t;
    let (near, far) = shader.depth_range;
    let nearness = ((far - distance) / (far - near)).clamp(0.0, 1.0);
    let grey = DARKEST + nearness * (255.0 - DARKEST);
    pixel(grey, grey, grey)
}
