//! The oracle: every triangle for every pixel, by the same rule as the kernels, written plainly.
//!
//! Its arithmetic is not theirs: it looks at signs in `f64` first and asks [`exact`] where rounding could matter.

use glam::Vec3;

use super::depth::Depth;
use super::exact::{self, PixelRay};
use super::space::{HALF, TILE, TileSpace, Uvw};
use super::tile::{Tile, pixel_offset};

/// Traces all of `triangles` (in leaf order) over a cleared tile.
pub fn trace(triangles: &[[Vec3; 3]], file_ids: &[u32], space: &TileSpace, tile: &mut Tile) {
    for (id, corners) in (0u32..).zip(triangles) {
        let corners = corners.map(|p| space.transform(p));
        triangle(&corners, id, file_ids, tile);
    }
    fill_cost(triangles, tile);
}

/// The same for some pixels (columns and rows) of the tile, and until `go_on` says no, which is asked before each
/// triangle: then the tile is unfinished, and it returns false.
pub fn trace_pixels(
    triangles: &[[Vec3; 3]],
    file_ids: &[u32],
    space: &TileSpace,
    pixels: &[(usize, usize)],
    go_on: &impl Fn() -> bool,
    tile: &mut Tile,
) -> bool {
    for (id, corners) in (0u32..).zip(triangles) {
        if !go_on() {
            return false;
        }
        let corners = corners.map(|p| space.transform(p));
        triangle_at(&corners, id, file_ids, pixels.iter().copied(), tile);
    }
    fill_cost(triangles, tile);
    true
}

fn fill_cost(triangles: &[[Vec3; 3]], tile: &mut Tile) {
    tile.cost
        .fill(u32::try_from(triangles.len()).unwrap_or(u32::MAX));
}

/// Tests one triangle, given in the tile's frame, at every pixel of the tile; true when it won one.
pub(super) fn triangle(corners: &[Uvw; 3], id: u32, file_ids: &[u32], tile: &mut Tile) -> bool {
    let pixels = (0..TILE).flat_map(|y| (0..TILE).map(move |x| (x, y)));
    triangle_at(corners, id, file_ids, pixels, tile)
}

fn triangle_at(
    corners: &[Uvw; 3],
    id: u32,
    file_ids: &[u32],
    pixels: impl Iterator<Item = (usize, usize)>,
    tile: &mut Tile,
) -> bool {
    let finite = |p: &Uvw| p.u.is_finite() && p.v.is_finite() && p.w.is_finite();
    if !corners.iter().all(finite) {
        return false;
    }
    let Some(depth) = Depth::of(corners) else {
        return false;
    };
    let [a, b, c] = *corners;
    let whole = exact::orientation(a, b, c);
    if whole == 0.0 {
        return false;
    }
    let sides = [
        Side::new(a, b, whole),
        Side::new(b, c, whole),
        Side::new(c, a, whole),
    ];
    let mut won = false;
    pixels.for_each(|(x, y)| {
        let ray = PixelRay {
            x: x as f32 - HALF,
            y: y as f32 - HALF,
        };
        if sides.iter().all(|s| s.inside(ray)) {
            let z = depth.at(ray.x, ray.y);
            won |= tile.keep_nearer(pixel_offset(x, y), z, id, file_ids);
        }
    });
    won
}

/// One edge: the sign of |p q d| for many rays d.
struct Side {
    p: Uvw,
    q: Uvw,
    /// 1 or −1: the side that is inside.
    sign: f64,
    /// p × q in `f64`.
    cross: [f64; 3],
    /// Beyond this, the sign of the rounded value is right.
    doubt: f64,
}

impl Side {
    fn new(p: Uvw, q: Uvw, whole: f64) -> Side {
        let [pu, pv, pw] = [p.u, p.v, p.w].map(f64::from);
        let [qu, qv, qw] = [q.u, q.v, q.w].map(f64::from);
        // Products of two f32 are exact in f64; each difference is rounded once.
        let cross = [pv * qw - pw * qv, pw * qu - pu * qw, pu * qv - pv * qu];
        let size = (cross[0].abs() + cross[1].abs()) * f64::from(HALF) + cross[2].abs();
        Side {
            p,
            q,
            sign: whole.signum(),
            cross,
            // Three roundings of the coefficients and four of the sum, with room to spare.
            doubt: size * (16.0 * f64::EPSILON),
        }
    }

    fn inside(&self, ray: PixelRay) -> bool {
        let [u, v, w] = self.cross;
        let value = u * f64::from(ray.x) + (v * f64::from(ray.y) + w);
        let side = if value.abs() > self.doubt {
            value
        } else {
            exact::edge_side(self.p, self.q, ray)
        };
        side * self.sign >= 0.0
    }
}
