//! The cube of all colours: red along x, green along y, blue along z; an octant taken out to show its inside.

use glam::Vec3;

use super::mesh::Mesh;
use super::palette::rgb;
use super::stage;
use crate::color::Rgb;
use crate::scene::Scene;

/// Small cubes along an edge.
const SIDE: usize = 10;

/// Half a small cube, of a pitch of 1, and what its edges lose.
const HALF: f32 = 0.43;
const BEVEL: f32 = 0.09;

/// The scene.
pub fn scene() -> Scene {
    let mut mesh = Mesh::default();
    for cell in 0..SIDE * SIDE * SIDE {
        let [x, y, z] = [cell % SIDE, cell / SIDE % SIDE, cell / SIDE / SIDE];
        if x >= SIDE / 2 && y < SIDE / 2 && z >= SIDE / 2 {
            continue;
        }
        let place = Vec3::new(x as f32, y as f32, z as f32);
        let middle = (SIDE - 1) as f32 * 0.5;
        let tone = Vec3::splat(0.18) + place / (SIDE - 1) as f32 * 0.82;
        bevelled(&mut mesh, place - Vec3::splat(middle), rgb(tone));
    }
    stage::scene(
        mesh,
        (Vec3::new(0.0, -36.0, 16.5), Vec3::new(0.0, 0.0, -0.25), 8.5),
        Vec3::new(-0.34, 0.3, 0.88),
        stage::turntable(0.25, 0.66),
    )
}

/// A small cube with its edges and corners cut off: 6 squares, 12 strips, 8 triangles.
fn bevelled(mesh: &mut Mesh, centre: Vec3, color: Rgb) {
    let inner = HALF - BEVEL;
    // The corner near `signs`, on the face of axis `axis`.
    let corner = |signs: Vec3, axis: usize| {
        let mut p = signs * inner;
        p[axis] = signs[axis] * HALF;
        centre + p
    };
    let sign = |bit: usize| if bit == 0 { -1.0 } else { 1.0 };
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for side in 0..2 {
            let at = |a: f32, b: f32| {
                let mut s = Vec3::ZERO;
                s[axis] = sign(side);
                s[u] = a * sign(side);
                s[v] = b;
                s
            };
            let face = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
            mesh.quad(face.map(|(a, b)| corner(at(a, b), axis)), color);
            for edge in 0..2 {
                // The strip between this face and the next axis' face, along the third axis.
                let (low, high) = (at(sign(edge), -1.0), at(sign(edge), 1.0));
                let mut strip = [
                    corner(low, axis),
                    corner(low, u),
                    corner(high, u),
                    corner(high, axis),
                ];
                if edge == 0 {
                    strip.reverse();
                }
                mesh.quad(strip, color);
            }
        }
    }
    for bits in 0..8 {
        let s = Vec3::new(sign(bits & 1), sign(bits >> 1 & 1), sign(bits >> 2));
        let mut tip = [corner(s, 0), corner(s, 1), corner(s, 2)];
        if s.x * s.y * s.z < 0.0 {
            tip.reverse();
        }
        mesh.triangle(tip, color);
    }
}
