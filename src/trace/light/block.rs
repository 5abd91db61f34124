//! Eight triangles in a row of a cell, and one ray.
//!
//! A ray is hidden by a triangle when its point lies within the outline, and below the plane. Both are asked with an
//! error that is known for each triangle: one bound for eight would be that of the largest, and cities stand on large
//! grounds.
//!
//! # How exact
//! With m the distance of a corner from a ray of the cell across the light, g that along it and u the unit roundoff:
//! the rule of free rays, the place of a corner and its difference from the ray's each move x and y by at most
//! u(4m + 2g) in all. An edge function is the difference of two products of such numbers: its error is below
//! u·m(18m + 8g); where the rule's rounding turns a triangle round, u·m(24m + 20g). Since the plane at the ray is
//! H above its origin, g is no more than |H| and what the plane rises over m.
//!
//! The rule moves corners: with r the reach of the scene, by less than 4ur across the light and 2ur along it. When a
//! ray meets the moved triangle, there is a point of the triangle itself so near: its plane at the ray is at least
//! −4urs above the origin, with s the sum of 1 and its slopes. When the line meets it, but behind the origin or there,
//! H is at most 4urs. H itself is found with an error below 5ur + 8uds (d: a cell's side), if the triangle is not all
//! too narrow. So beyond a margin of 16urs + 16uds the sign of H decides, at once for all rays of a cell that start
//! higher than the plane and its margin rise in it. For a plane too steep or a triangle too
//! narrow, its highest and lowest corner decide.

use super::frame::Seen;
use crate::simd::{Lanes, SimdBase, SimdFloat, SimdMask, f32x8};
use crate::trace::space::ROUNDOFF;

/// Triangles of a block.
pub const LANES: usize = 8;

/// A point in the frame of the light, x and y from the middle of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Across the light.
    pub x: f32,
    /// Across the light.
    pub y: f32,
    /// Toward it.
    pub z: f32,
}

/// Steeper planes do not decide.
const STEEPEST: f64 = 1e3;

/// Triangles narrower than this are too narrow: of their width, or of what the rule moves corners by.
const NARROW: f64 = 1e-6;

/// A cell as its triangles need it.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// Across the light.
    pub middle: [f64; 2],
    /// Length of its sides, with room for rounding.
    pub side: f64,
    /// More than the rule of free rays moves a corner across the light.
    pub blur: f64,
}

/// The plane of a triangle over a cell.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    /// z = a·x + b·y + c, counted from the cell's middle.
    plane: [f64; 3],
    /// |a| + |b|.
    steep: f64,
    /// So far above or below it a point certainly is.
    margin: f64,
    /// The most that two corners lie apart across the light, along an axis.
    width: f64,
    /// No point of the triangle in the cell lies higher.
    pub top: f32,
}

impl Plane {
    /// That of a triangle with these corners.
    pub fn new(corners: &[Seen; 3], cell: &Cell) -> Plane {
        let [a, b, c] = *corners;
        let edge = |p: Seen| [p.x - a.x, p.y - a.y, f64::from(p.z) - f64::from(a.z)];
        let ([ux, uy, uz], [vx, vy, vz]) = (edge(b), edge(c));
        let normal = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
        let most = |x: f64, y: f64| x.abs().max(y.abs());
        let width = most(ux, vx).max(most(uy, vy)).max(most(ux - vx, uy - vy));
        let slopes = [-normal[0] / normal[2], -normal[1] / normal[2]];
        let steep = slopes[0].abs() + slopes[1].abs();
        let margin = cell.blur + 16.0 * f64::from(ROUNDOFF) * cell.side;
        let [low, high] = [a.z.min(b.z.min(c.z)), a.z.max(b.z.max(c.z))];
        if normal[2] > width * width.max(cell.blur) * NARROW && steep < STEEPEST {
            let rise = |k: usize, p: f64| slopes[k] * (cell.middle[k] - p);
            let height = f64::from(a.z) + rise(0, a.x) + rise(1, a.y);
            let margin = margin * (1.0 + steep);
            Plane {
                plane: [slopes[0], slopes[1], height],
                steep,
                margin,
                width,
                top: high.min((height + steep * cell.side * 0.5 + margin) as f32),
            }
        } else {
            let [low, high_z] = [low, high].map(f64::from);
            Plane {
                plane: [0.0, 0.0, (low + high_z) * 0.5],
                steep: 0.0,
                margin: margin + (high_z - low) * 0.501,
                width,
                top: high,
            }
        }
    }
}

/// Eight triangles as the light sees them from the middle of their cell, all counter-clockwise.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub struct Block {
    /// Corners a, b, c: x, then y; a row each.
    across: [[f32; LANES]; 6],
    /// The plane z = a·x + b·y + c; a row each.
    plane: [[f32; LANES]; 3],
    /// So far above or below the plane a point certainly is.
    margin: [f32; LANES],
    /// Error of an edge function: this, and the next times the distance from the plane.
    edge_error: [f32; LANES],
    more_error: [f32; LANES],
    /// Numbers in leaf order.
    ids: [u32; LANES],
    /// No triangle rises higher in the cell.
    top: f32,
}

/// What a block says of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// No triangle hides it.
    Free,
    /// One does.
    Hidden,
    /// Perhaps those lanes (as bits) do: too close to tell.
    Perhaps(u32),
}

impl Block {
    /// No triangles yet.
    pub const EMPTY: Block = Block {
        across: [[0.0; LANES]; 6],
        plane: [[0.0; LANES]; 3],
        margin: [0.0; LANES],
        edge_error: [0.0; LANES],
        more_error: [0.0; LANES],
        ids: [0; LANES],
        top: f32::NEG_INFINITY,
    };

    /// Puts a triangle into lane `lane`, and into those behind it until others come: repeating one changes nothing.
    /// `top`: that of its [`Plane`].
    pub fn put(&mut self, lane: usize, corners: &[Seen; 3], id: u32, cell: &Cell, top: f32) {
        for (i, p) in corners.iter().enumerate() {
            self.across[i][lane..].fill((p.x - cell.middle[0]) as f32);
            self.across[3 + i][lane..].fill((p.y - cell.middle[1]) as f32);
        }
        let plane = Plane::new(corners, cell);
        for (row, p) in self.plane.iter_mut().zip(plane.plane) {
            row[lane..].fill(p as f32);
        }
        let spread = (plane.width + cell.side) * 1.001;
        let more_error = 32.0 * f64::from(ROUNDOFF) * spread;
        let edge_error = more_error * (spread * (1.0 + plane.steep) + plane.margin) * 1.01;
        self.margin[lane..].fill(plane.margin as f32);
        self.edge_error[lane..].fill(edge_error as f32);
        self.more_error[lane..].fill(more_error as f32);
        self.ids[lane..].fill(id);
        self.top = self.top.max(top);
    }

    /// True when all triangles, and those of the blocks behind, certainly lie below a ray's origin.
    #[inline(always)]
    pub fn is_below(&self, z: f32) -> bool {
        self.top <= z
    }

    /// No triangle rises higher in the cell.
    pub fn top(&self) -> f32 {
        self.top
    }

    /// The triangles' numbers in leaf order; the last one may be there several times.
    pub fn ids(&self) -> &[u32; LANES] {
        &self.ids
    }

    /// The triangle's number in leaf order.
    #[inline(always)]
    pub fn id(&self, lane: usize) -> usize {
        self.ids[lane & 7] as usize
    }

    /// Whether one of the triangles hides the light from `place`.
    #[inline(always)]
    pub fn test<S: Lanes>(&self, simd: S, place: Place) -> Answer {
        macro_rules! splat {
            ($x:expr) => {
                f32x8::splat(simd, $x)
            };
        }
        macro_rules! from {
            ($row:expr, $origin:expr) => {
                f32x8::load_array_ref(simd, &self.across[$row]) - $origin
            };
        }
        let (x, y) = (splat!(place.x), splat!(place.y));
        let (xa, xb, xc) = (from!(0, x), from!(1, x), from!(2, x));
        let (ya, yb, yc) = (from!(3, y), from!(4, y), from!(5, y));
        // Fused: this only sorts out, and less rounding is within the bounds too.
        let ab = xa.mul_sub(yb, ya * xb);
        let bc = xb.mul_sub(yc, yb * xc);
        let ca = xc.mul_sub(ya, yc * xa);
        let edge = ab.min(bc.min(ca));
        let row = |row: &[f32; LANES]| f32x8::load_array_ref(simd, row);
        let [slope_x, slope_y, height] = &self.plane;
        let height = row(slope_x).mul_add(x, row(slope_y).mul_add(y, row(height)));
        let above = height - splat!(place.z);
        let error = above
            .abs()
            .mul_add(row(&self.more_error), row(&self.edge_error));
        let margin = row(&self.margin);
        let zero = splat!(0.0);
        let perhaps = (edge + error).simd_ge(zero) & (above + margin).simd_ge(zero);
        let perhaps = perhaps.to_bitmask() as u32;
        if perhaps == 0 {
            return Answer::Free;
        }
        let surely = edge.simd_gt(error) & above.simd_gt(margin);
        if surely.to_bitmask() != 0 {
            return Answer::Hidden;
        }
        Answer::Perhaps(perhaps)
    }
}
