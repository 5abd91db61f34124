//! A leaf's triangles and one ray.
//!
//! Every vertex is seen along the ray, once: as a point (x, y) of the plane across it, by a shear that needs no
//! square root. There the ray is the point 0, and whether it lies in a triangle is three products of two numbers.
//! Source: Woop, Benthin, Wald, "Watertight ray/triangle intersection", 2013. Theirs decides by those numbers; here
//! they only rule out lanes, by a bound of their error, and the few lanes that are left are decided in `f64`
//! ([`super::rule`]).

use super::frame::RayFrame;
use crate::bvh::Leaf;
use crate::simd::{Bytes, Lanes, SimdBase, VertexScratch, bits, lanes};

/// Below this, products of two numbers lose bits to underflow.
const UNDERFLOW: f32 = 1e-36;

/// The lanes' triangles from `first` on that the ray may meet, as bits. [`see`] must have been called.
#[inline(always)]
pub fn candidates<S: Lanes>(
    simd: S,
    frame: &RayFrame,
    leaf: Leaf<'_>,
    first: usize,
    scratch: &VertexScratch,
) -> u32 {
    let chunks = leaf.vertex_count().div_ceil(16);
    let [x0, y0, w0, _] = simd.corners(scratch, leaf.corner_words(0), first, chunks);
    let [x1, y1, w1, _] = simd.corners(scratch, leaf.corner_words(1), first, chunks);
    let [x2, y2, w2, _] = simd.corners(scratch, leaf.corner_words(2), first, chunks);
    let sides = [x0 * y1 - y0 * x1, x1 * y2 - y1 * x2, x2 * y0 - y2 * x0];
    // Of a product, the error is at most blur/2 times the sum of both points' sizes, and the rounding of the
    // product itself blur times one of them: this is half as much again.
    let error = w0.max(w1.max(w2)) * S::f32s::splat(simd, 3.0 * frame.blur)
        + S::f32s::splat(simd, UNDERFLOW);
    let least = sides[0].min(sides[1].min(sides[2]));
    let most = sides[0].max(sides[1].max(sides[2]));
    let near = (least + error).simd_ge(0.0) | (most - error).simd_le(0.0);
    let left = leaf.count() - first;
    let valid = if left >= lanes::<S>() {
        u32::MAX
    } else {
        (1 << left) - 1
    };
    bits::<S>(near) & valid
}

/// Puts the leaf's vertices as the ray sees them into `scratch`: x, y, and |x| + |y| with the error on top.
#[inline(always)]
pub fn see<S: Lanes>(simd: S, frame: &RayFrame, leaf: Leaf<'_>, scratch: &mut VertexScratch) {
    macro_rules! splat {
        ($x:expr) => {
            S::f32s::splat(simd, $x)
        };
    }
    let origin = [
        splat!(frame.origin[0]),
        splat!(frame.origin[1]),
        splat!(frame.origin[2]),
    ];
    let shear = [splat!(frame.shear[0]), splat!(frame.shear[1])];
    let blur = splat!(frame.blur);
    let count = leaf.vertex_count();
    let mut at = 0;
    while at < count {
        let (chunk, lane) = (at / 16, at % 16);
        macro_rules! relative {
            ($axis:expr) => {{
                let words =
                    &leaf.coordinate_bits(chunk, frame.axes[$axis])[lane..lane + lanes::<S>()];
                S::u32s::from_slice(simd, words).bitcast::<S::f32s>() - origin[$axis]
            }};
        }
        let z = relative!(2);
        let x = relative!(0) - shear[0] * z;
        let y = relative!(1) - shear[1] * z;
        let size = (x.abs() + y.abs()) + blur;
        simd.put_vertices(scratch, at, [x, y, size, size]);
        at += lanes::<S>();
    }
}
