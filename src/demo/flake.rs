//! The sphere flake: a ball that carries nine of a third its size, and so does each of them.
//! Source: Haines, "A proposal for standard graphics environments", 1987, where ray tracers began to race.

use glam::Vec3;

use super::mesh::Mesh;
use super::shapes::{Frame, around, ball};
use super::stage;
use crate::color::Rgb;
use crate::scene::Scene;

/// By size, the smallest first.
const COLORS: [Rgb; 4] = [
    Rgb::new(255, 232, 160),
    Rgb::new(255, 104, 130),
    Rgb::new(160, 100, 255),
    Rgb::new(50, 130, 255),
];

/// How finely the balls of each size are cut.
const LEVELS: [u32; 4] = [5, 4, 3, 2];

/// The scene.
pub fn scene() -> Scene {
    let mut mesh = Mesh::default();
    let balls = LEVELS.map(ball);
    grow(&mut mesh, &balls, Frame::along(Vec3::ZERO, Vec3::Z), 1.0);
    stage::scene(
        mesh,
        (Vec3::new(0.0, -7.6, 2.6), Vec3::ZERO, 2.05),
        Vec3::new(-0.5, 0.35, 0.7),
        stage::turntable(-0.25, 0.0),
    )
}

/// The ball of `frame` and all that grow on it; `balls` are the meshes of this size and the smaller ones.
fn grow(mesh: &mut Mesh, balls: &[Vec<[Vec3; 3]>], frame: Frame, radius: f32) {
    let Some((ball, smaller)) = balls.split_first() else {
        return;
    };
    let color = COLORS[smaller.len()];
    for face in ball {
        mesh.triangle(face.map(|p| frame.origin + p * radius), color);
    }
    let first = smaller.len() + 1 == LEVELS.len();
    for direction in directions(first) {
        let out = frame.at(direction) - frame.origin;
        let child = Frame::along(frame.origin + out * radius * 4.0 / 3.0, out);
        grow(mesh, smaller, child, radius / 3.0);
    }
}

/// Six around the waist, three above, and on the first ball, which nothing carries, three below.
fn directions(first: bool) -> impl Iterator<Item = Vec3> {
    let waist = (0..6).map(|i| around(i, 6).extend(0.0));
    let cap =
        |shift: usize, z: f32| (0..3).map(move |i| (around(4 * i + shift, 12) * 0.5).extend(z));
    let below = cap(3, -0.866_025_4).take(if first { 3 } else { 0 });
    waist.chain(cap(1, 0.866_025_4)).chain(below)
}
