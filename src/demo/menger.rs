//! A Menger sponge: a cube less its middle thirds, and so is each of the cubes that are left.

use glam::Vec3;

use super::mesh::Mesh;
use super::palette::{gradient, hue, mix};
use super::shapes::cuboid_face;
use super::stage;
use crate::color::Rgb;
use crate::scene::Scene;

/// How often the thirds are taken out.
const ORDER: u32 = 4;

/// Small cubes along an edge.
const SIDE: i32 = 3i32.pow(ORDER);

/// The scene.
pub fn scene() -> Scene {
    let mut mesh = Mesh::default();
    for x in 0..SIDE {
        for y in 0..SIDE {
            for z in 0..SIDE {
                if solid([x, y, z]) {
                    open_faces(&mut mesh, [x, y, z]);
                }
            }
        }
    }
    stage::scene(
        mesh,
        (Vec3::new(0.0, -6.9, 3.0), Vec3::new(0.0, 0.0, -0.04), 1.7),
        Vec3::new(-0.38, 0.45, 0.8),
        stage::turntable(0.2, 0.62),
    )
}

/// True when the small cube here is part of the sponge: no order sees it in two middles at once.
fn solid(mut cell: [i32; 3]) -> bool {
    if cell.iter().any(|c| !(0..SIDE).contains(c)) {
        return false;
    }
    for _ in 0..ORDER {
        if cell.iter().filter(|&c| c % 3 == 1).count() >= 2 {
            return false;
        }
        cell = cell.map(|c| c / 3);
    }
    true
}

/// The faces of a small cube that border on nothing.
fn open_faces(mesh: &mut Mesh, cell: [i32; 3]) {
    let corner = |c: [i32; 3]| Vec3::from_array(c.map(|c| (2 * c - SIDE) as f32)) / SIDE as f32;
    let min = corner(cell);
    let max = corner(cell.map(|c| c + 1));
    for face in 0..6 {
        let mut beyond = cell;
        beyond[face / 2] += if face % 2 == 0 { -1 } else { 1 };
        if !solid(beyond) {
            let quad = cuboid_face(min, max, face);
            mesh.quad(quad, color((quad[0] + quad[2]) * 0.5));
        }
    }
}

/// Outside from green by blue to violet along a diagonal, and a glow within.
fn color(p: Vec3) -> Rgb {
    let depth = 1.0 - p.abs().max_element();
    let shell = hue(0.58 + 0.09 * (p.x + p.y - p.z), 0.3);
    let stops = [
        (0.0, shell),
        (0.06, mix(shell, Rgb::new(255, 90, 190), 0.4)),
        (0.15, Rgb::new(255, 90, 170)),
        (0.35, Rgb::new(255, 120, 50)),
        (0.7, Rgb::new(255, 220, 100)),
    ];
    gradient(&stops, depth)
}
