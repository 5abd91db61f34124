//! How near a hit is: 1/w over the pixels of a tile, the same bits in every engine.

use super::space::Uvw;

/// A corner nearer than this to the plane of the eye (w, where the scene's largest is about 1) counts as behind it.
pub const NEAR: f32 = 1e-30;

/// Coefficients beyond this are useless: the triangle is seen all but edge-on.
pub const STEEP: f32 = 1e30;

/// 1/w of a triangle's plane at a pixel: affine in x′ and y′, and kept between its corners' values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Depth {
    /// Change a pixel to the right.
    pub u: f32,
    /// Change a pixel down.
    pub v: f32,
    /// Value at the tile's centre.
    pub w: f32,
    /// Smallest value.
    pub low: f32,
    /// Largest value.
    pub high: f32,
}

impl Depth {
    /// The depth of a triangle; `None` when no corner lies in front of the eye: such a triangle is never hit.
    ///
    /// `f32`, every operation rounded, in this order: the kernels repeat it lane by lane.
    #[must_use]
    pub fn of(corners: &[Uvw; 3]) -> Option<Depth> {
        let [a, b, c] = *corners;
        let w_max = a.w.max(b.w.max(c.w));
        if w_max.is_nan() || w_max <= NEAR {
            return None;
        }
        let (low, high) = if a.w.min(b.w.min(c.w)) > NEAR {
            let i = [1.0 / a.w, 1.0 / b.w, 1.0 / c.w];
            (i[0].min(i[1].min(i[2])), i[0].max(i[1].max(i[2])))
        } else {
            (1.0 / w_max, f32::MAX)
        };
        let ca = [c.u - a.u, c.v - a.v, c.w - a.w];
        let ab = [a.u - b.u, a.v - b.v, a.w - b.w];
        let normal = [
            ca[1] * ab[2] - ca[2] * ab[1],
            ca[2] * ab[0] - ca[0] * ab[2],
            ca[0] * ab[1] - ca[1] * ab[0],
        ];
        let determinant = (normal[0] * a.u + normal[1] * a.v) + normal[2] * a.w;
        let inverse = 1.0 / determinant;
        let [u, v, w] = normal.map(|n| n * inverse);
        Some(if (u.abs() + v.abs()) + w.abs() < STEEP {
            Depth { u, v, w, low, high }
        } else {
            Depth {
                u: 0.0,
                v: 0.0,
                w: low,
                low,
                high,
            }
        })
    }

    /// 1/w at a pixel.
    #[inline(always)]
    #[must_use]
    pub fn at(&self, x: f32, y: f32) -> f32 {
        (self.u * x + (self.v * y + self.w))
            .max(self.low)
            .min(self.high)
    }
}
