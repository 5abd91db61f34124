//! The cold paths of a leaf: lanes whose `f32` results are in doubt.
//!
//! About one triangle in a thousand comes here, and one pixel in ten thousand.

use super::coverage::{Job, SURE, Setup, corners_of};
use super::depth::STEEP;
use super::exact::{self, PixelRay};
use super::space::{HALF, ROUNDOFF, Uvw};
use crate::bvh::Leaf;
use crate::simd::{Lanes, VertexScratch, lanes};

/// Puts the exact orientation of the lanes `unsure` into `signs`; the lanes to keep: all but those seen edge-on.
#[cold]
#[inline(never)]
pub fn exact_signs<S: Lanes>(
    simd: S,
    leaf: Leaf<'_>,
    first: usize,
    vertices: &VertexScratch,
    unsure: u32,
    signs: &mut [f32; 16],
) -> u32 {
    let mut keep = u32::MAX;
    for (lane, sign) in signs.iter_mut().enumerate().take(lanes::<S>()) {
        if unsure >> lane & 1 != 0 {
            let [a, b, c] = corners_of(simd, leaf, first + lane, vertices);
            let exact = exact::orientation(a, b, c);
            *sign = exact.signum() as f32;
            keep &= !(u32::from(exact == 0.0) << lane);
        }
    }
    keep
}

/// Forms the edges of the lanes `coarse` anew from `f64`, in pixels: an edge's error is then a small part of a
/// pixel, whatever its length. Edges that do not cross the tile are settled here. The lanes to keep.
#[cold]
#[inline(never)]
pub fn refine<S: Lanes>(
    simd: S,
    leaf: Leaf<'_>,
    first: usize,
    vertices: &VertexScratch,
    coarse: u32,
    signs: &[f32; 16],
    setup: &mut Setup,
) -> u32 {
    let mut keep = u32::MAX;
    for lane in (0..lanes::<S>()).filter(|lane| coarse >> lane & 1 != 0) {
        let corners = corners_of(simd, leaf, first + lane, vertices);
        let mut sure = 0.0f32;
        for i in 0..3 {
            let edge = refined_edge(corners[i], corners[(i + 1) % 3], f64::from(signs[lane]));
            let ([u, v, w], error) = match edge {
                Edge::Outside => {
                    keep &= !(1 << lane);
                    continue;
                }
                Edge::Inside => ([0.0, 0.0, STEEP], 0.0),
                Edge::Crosses(k, error) => (k, error),
            };
            sure = sure.max(2.0 * error);
            setup.0[3 * i][first + lane] = u;
            setup.0[3 * i + 1][first + lane] = v;
            setup.0[3 * i + 2][first + lane] = w + error;
        }
        setup.0[SURE][first + lane] = sure;
    }
    keep
}

/// How an edge lies to a tile.
enum Edge {
    /// No pixel is on its inner side.
    Outside,
    /// All pixels are.
    Inside,
    /// Coefficients, without their error bound, and that bound.
    Crosses([f32; 3], f32),
}

/// The edge function of p and q from `f64`, scaled so that a unit is about a pixel.
fn refined_edge(p: Uvw, q: Uvw, sign: f64) -> Edge {
    let [pu, pv, pw] = [p.u, p.v, p.w].map(f64::from);
    let [qu, qv, qw] = [q.u, q.v, q.w].map(f64::from);
    // Products of two f32 are exact in f64; each difference is rounded once.
    let n = [pv * qw - pw * qv, pw * qu - pu * qw, pu * qv - pv * qu];
    let slope = n[0].abs() + n[1].abs();
    // 32 is more than the farthest pixel's 31.5: the difference covers all rounding.
    let beyond = n[2].abs() > slope * 32.0;
    if beyond {
        return if n[2] * sign > 0.0 {
            Edge::Inside
        } else {
            Edge::Outside
        };
    }
    if slope == 0.0 {
        // p and q are the same point on screen, or one of them is the eye: every pixel lies on the edge.
        return Edge::Inside;
    }
    let k = n.map(|n| (n * sign / slope) as f32);
    // One rounding of each coefficient, four of the sum, with |x'| and |y'| below 32 and |w| up to 32.
    Edge::Crosses(k, 16.0 * ROUNDOFF * 64.0)
}

/// Clears those bits of `hits` (see [`raster::specks`](super::raster::specks)) in the lanes `doubts` that are misses
/// after all. `place`: the column and row in the tile of a step and a lane.
#[cold]
#[inline(never)]
pub fn settle<S: Lanes>(
    simd: S,
    job: &Job<'_>,
    first: usize,
    doubts: u32,
    hits: &mut [u64],
    place: impl Fn(usize, usize) -> (usize, usize),
    vertices: &VertexScratch,
) {
    for (word, hits) in hits.iter_mut().enumerate() {
        let all = *hits;
        for p in (0..64).filter(|p| all >> p & 1 != 0) {
            let (step, lane) = (
                (word * 64 + p) / lanes::<S>(),
                (word * 64 + p) % lanes::<S>(),
            );
            if doubts >> lane & 1 == 0 {
                continue;
            }
            let (x, y) = place(step, lane);
            let ray = PixelRay {
                x: x as f32 - HALF,
                y: y as f32 - HALF,
            };
            let corners = corners_of(simd, job.leaf, first + lane, vertices);
            *hits &= !(u64::from(!exact::hits(&corners, ray)) << p);
        }
    }
}
