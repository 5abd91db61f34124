//! Balls, boxes, tubes and what turns on a lathe.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::mesh::Mesh;
use crate::color::Rgb;

/// Cosine and sine of `i / n` of a full turn; those of `i = n` are those of 0 to the bit, so that seams close.
pub fn around(i: usize, n: usize) -> Vec2 {
    let (s, c) = libm::sincosf(TAU * (i % n) as f32 / n as f32);
    Vec2::new(c, s)
}

/// A place and three axes at right angles, right-handed.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// Where it stands.
    pub origin: Vec3,
    /// Its axes, of length 1.
    pub axes: [Vec3; 3],
}

impl Frame {
    /// A frame whose third axis points along `up`.
    pub fn along(origin: Vec3, up: Vec3) -> Frame {
        let z = up.normalize();
        let x = z.any_orthonormal_vector();
        Frame {
            origin,
            axes: [x, z.cross(x), z],
        }
    }

    /// The world's place of a point of this frame.
    pub fn at(&self, p: Vec3) -> Vec3 {
        self.origin + self.axes[0] * p.x + self.axes[1] * p.y + self.axes[2] * p.z
    }
}

/// A body of revolution about the third axis of `frame`: `profile` is (radius, height), from the bottom up for an
/// outside that is outside; coloured by (profile piece, segment, centre).
pub fn lathe(
    mesh: &mut Mesh,
    frame: Frame,
    profile: &[Vec2],
    segments: usize,
    color: impl Fn(usize, usize, Vec3) -> Rgb,
) {
    let point = |j: usize, i: usize| {
        let spoke = around(j, segments) * profile[i].x;
        frame.at(spoke.extend(profile[i].y))
    };
    mesh.grid(segments, profile.len() - 1, point, |j, i, c| color(i, j, c));
}

/// A tube around `path`. `ups` are directions across the path, one for each point; they keep it from twisting.
/// `radius` is by point, the colour by (piece of the path, segment around it, centre). The ends stay open
/// unless `closed`: then the last point joins the first.
pub fn tube(
    mesh: &mut Mesh,
    (path, ups, closed): (&[Vec3], &[Vec3], bool),
    radius: impl Fn(usize) -> f32,
    segments: usize,
    color: impl Fn(usize, usize, Vec3) -> Rgb,
) {
    let n = path.len();
    let point = |i: usize, j: usize| {
        let i = i % n;
        let (before, after) = if closed {
            (path[(i + n - 1) % n], path[(i + 1) % n])
        } else {
            (path[i.saturating_sub(1)], path[(i + 1).min(n - 1)])
        };
        let side = (after - before).cross(ups[i]).normalize();
        let up = side.cross(after - before).normalize();
        let a = around(j, segments) * radius(i);
        path[i] + side * a.x - up * a.y
    };
    let pieces = if closed { n } else { n - 1 };
    mesh.grid(pieces, segments, |i, j| point(i, segments - j), color);
}

/// The faces of a cube from `min` to `max`: -x, +x, -y, +y, -z, +z. One without a colour is left out.
pub fn cuboid(mesh: &mut Mesh, min: Vec3, max: Vec3, faces: [Option<Rgb>; 6]) {
    for (k, color) in faces.into_iter().enumerate() {
        if let Some(color) = color {
            mesh.quad(cuboid_face(min, max, k), color);
        }
    }
}

/// Face `k` of [`cuboid`]: seen from outside, the lower left corner first, then counter-clockwise; a wall's first edge is
/// level.
pub fn cuboid_face(min: Vec3, max: Vec3, k: usize) -> [Vec3; 4] {
    let p = |x: u8, y: u8, z: u8| {
        let pick = |bit: u8, low: f32, high: f32| if bit == 0 { low } else { high };
        Vec3::new(
            pick(x, min.x, max.x),
            pick(y, min.y, max.y),
            pick(z, min.z, max.z),
        )
    };
    match k {
        0 => [p(0, 1, 0), p(0, 0, 0), p(0, 0, 1), p(0, 1, 1)],
        1 => [p(1, 0, 0), p(1, 1, 0), p(1, 1, 1), p(1, 0, 1)],
        2 => [p(0, 0, 0), p(1, 0, 0), p(1, 0, 1), p(0, 0, 1)],
        3 => [p(1, 1, 0), p(0, 1, 0), p(0, 1, 1), p(1, 1, 1)],
        4 => [p(0, 1, 0), p(1, 1, 0), p(1, 0, 0), p(0, 0, 0)],
        _ => [p(0, 0, 1), p(1, 0, 1), p(1, 1, 1), p(0, 1, 1)],
    }
}

/// A box of one colour without its bottom, for what stands on the ground.
pub fn block(mesh: &mut Mesh, min: Vec3, max: Vec3, color: Rgb) {
    let c = Some(color);
    cuboid(mesh, min, max, [c, c, c, c, None, c]);
}

/// The triangles of a ball of radius 1: an icosahedron, each face cut into four `level` times.
pub fn ball(level: u32) -> Vec<[Vec3; 3]> {
    let mut faces = icosahedron();
    for _ in 0..level {
        faces = faces.into_iter().flat_map(quartered).collect();
    }
    faces
}

fn quartered([a, b, c]: [Vec3; 3]) -> [[Vec3; 3]; 4] {
    let mid = |p: Vec3, q: Vec3| (p + q).normalize();
    let (ab, bc, ca) = (mid(a, b), mid(b, c), mid(c, a));
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
}

fn icosahedron() -> Vec<[Vec3; 3]> {
    const FACES: [[usize; 3]; 20] = [
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    let golden = (1.0 + 5f32.sqrt()) / 2.0;
    let mut points = Vec::new();
    // Three golden rectangles.
    for turn in 0..3 {
        for (x, y) in [
            (-1.0, golden),
            (1.0, golden),
            (-1.0, -golden),
            (1.0, -golden),
        ] {
            let p = match turn {
                0 => Vec3::new(x, y, 0.0),
                1 => Vec3::new(0.0, x, y),
                _ => Vec3::new(y, 0.0, x),
            };
            points.push(p.normalize());
        }
    }
    FACES.map(|face| face.map(|i| points[i])).to_vec()
}

/// Directions spread evenly over the sphere: direction `i` of `n`, on a golden spiral.
pub fn spread(i: usize, n: usize) -> Vec3 {
    let z = 1.0 - (2 * i + 1) as f32 / n as f32;
    let (s, c) = libm::sincosf(2.399_963_3 * i as f32);
    let r = (1.0 - z * z).sqrt();
    Vec3::new(r * c, r * s, z)
}
