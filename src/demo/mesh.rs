//! Triangles under construction.

use glam::{DVec3, Vec3};

use crate::color::Rgb;
use crate::geometry;
use crate::scene::Triangle;

/// A growing list of triangles, none of them degenerate. Counter-clockwise seen from outside, where a shape has one.
#[derive(Debug, Default)]
pub struct Mesh {
    triangles: Vec<Triangle>,
}

impl Mesh {
    /// All triangles so far.
    pub fn into_triangles(self) -> Vec<Triangle> {
        self.triangles
    }

    /// Adds a triangle, its corners rounded to four decimals; one that has no area then is left out.
    pub fn triangle(&mut self, corners: [Vec3; 3], color: Rgb) {
        let corners = corners.map(rounded);
        if !geometry::is_degenerate(&corners) {
            self.triangles.push(Triangle { corners, color });
        }
    }

    /// Adds a plane quadrilateral, its corners in order around it.
    pub fn quad(&mut self, [a, b, c, d]: [Vec3; 4], color: Rgb) {
        self.triangle([a, b, c], color);
        self.triangle([a, c, d], color);
    }

    /// Adds a surface: `rows` x `columns` cells between the points `point(i, j)`, 0 <= i <= rows, 0 <= j <= columns,
    /// two triangles each, coloured by cell and centre. Outside is where i × j points.
    pub fn grid(
        &mut self,
        rows: usize,
        columns: usize,
        point: impl Fn(usize, usize) -> Vec3,
        color: impl Fn(usize, usize, Vec3) -> Rgb,
    ) {
        let row = |i| (0..=columns).map(|j| point(i, j)).collect::<Vec<_>>();
        let mut near = row(0);
        for i in 0..rows {
            let far = row(i + 1);
            for j in 0..columns {
                let mut add = |corners: [Vec3; 3]| {
                    let centre = (corners[0] + corners[1] + corners[2]) / 3.0;
                    self.triangle(corners, color(i, j, centre));
                };
                let [a, b, c, d] = [near[j], far[j], far[j + 1], near[j + 1]];
                // Diagonals that alternate show less of the grid.
                if (i + j) % 2 == 0 {
                    add([a, b, c]);
                    add([a, c, d]);
                } else {
                    add([a, b, d]);
                    add([b, c, d]);
                }
            }
            near = far;
        }
    }
}

/// `p` to four decimals: short in a file, and equal for points that two formulas put in the same place.
pub fn rounded(p: Vec3) -> Vec3 {
    let q: DVec3 = (p.as_dvec3() * 1e4).round() / 1e4;
    // Plus zero: no minus zeros in the files.
    q.as_vec3() + Vec3::ZERO
}
