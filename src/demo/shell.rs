//! A sea snail: a ring that shrinks by the same share with every turn, as it climbs.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::mesh::Mesh;
use super::palette::{mix, smoothstep};
use super::shapes::around;
use super::stage;
use crate::color::Rgb;
use crate::scene::Scene;

/// Pieces along the spiral, and around the tube.
const ALONG: usize = 1300;
const ROUND: usize = 110;

/// Turns of the spiral, and by what factor one turn shrinks it.
const TURNS: f32 = 7.0;
const SHRINK: f32 = 0.62;

/// The scene.
pub fn scene() -> Scene {
    let mut mesh = Mesh::default();
    mesh.grid(ALONG, ROUND, point, |i, j, _| color(i, j));
    stage::scene(
        mesh,
        (Vec3::new(0.0, -10.0, 2.2), Vec3::new(0.0, 0.0, -0.15), 2.35),
        Vec3::new(-0.5, 0.25, 0.8),
        stage::turntable(0.6, 0.0),
    )
}

/// How large the ring is after `turns`.
fn size(turns: f32) -> f32 {
    libm::expf(libm::logf(SHRINK) * turns)
}

/// Turns up to piece `i`: short pieces where the ring is large.
fn turns(i: usize) -> f32 {
    let share = i as f32 / ALONG as f32;
    TURNS * share * share.sqrt()
}

fn point(i: usize, j: usize) -> Vec3 {
    let turns = turns(i);
    let (s, c) = libm::sincosf(TAU * turns);
    let spoke = Vec2::new(c, s);
    let ring = around(j, ROUND);
    // Ribs across, a keel outside.
    let rib = 1.0 + 0.035 * libm::cosf(TAU * 22.0 * turns);
    let scale = size(turns);
    let out = 0.95 + 0.9 * rib * ring.x;
    let up = 1.12 * rib * ring.y + 2.65;
    (spoke * out * scale).extend(1.75 - up * scale)
}

/// Cream with rust-red flames that follow the growth.
fn color(i: usize, j: usize) -> Rgb {
    let (cream, rust, pearl) = (
        Rgb::new(255, 238, 210),
        Rgb::new(214, 96, 48),
        Rgb::new(255, 170, 150),
    );
    let along = turns(i);
    let round = j as f32 / ROUND as f32;
    let wave = libm::sinf(TAU * (along * 11.0 + 0.35 * libm::sinf(TAU * round * 5.0)));
    let band = libm::sinf(TAU * round * 3.0);
    let spots = smoothstep(0.0, 0.6, wave + 0.5 * band);
    let mouth = smoothstep(0.1, 0.0, along);
    mix(mix(cream, rust, spots), pearl, mouth)
}
