//! The normal of the side turned to the eye: x, y, z from [-1, 1] as red, green, blue.

use super::{dot, pixel};

/// `normal`: unit, either side. `ray`: the pixel's direction.
#[inline(always)]
pub fn color(normal: [f32; 4], ray: [f32; 3]) -> u32 {
    let [x, y, z, _] = normal;
    let flip = if dot([x, y, z], ray) > 0.0 { -1.0 } else { 1.0 };
    let level = |c: f32| (c * flip + 1.0) * 127.5;
    pixel(level(x), level(y), level(z))
}
