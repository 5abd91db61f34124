//! An island in the evening sun: a million triangles, the largest demo.

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::mesh::Mesh;
use super::noise::Noise;
use super::palette::{gradient, mix, scaled, smoothstep};
use super::stage;
use crate::color::Rgb;
use crate::scene::Scene;

/// Cells along x and y: 2 · 800 · 625 triangles.
const COLUMNS: usize = 800;
const ROWS: usize = 625;

/// Half the width of the square.
const HALF: f32 = 20.0;

/// What the noise of a height of 1 becomes.
const HEIGHT: f32 = 11.0;

/// The scene.
pub fn scene() -> Scene {
    let noise = Noise::new(20);
    let heights = heights(&noise);
    let mut mesh = Mesh::default();
    let point = |i: usize, j: usize| {
        let p = place(i, j);
        let h = heights[j * (COLUMNS + 1) + i];
        p.extend(if h > 0.0 { h } else { wave(&noise, p) })
    };
    let color = |i: usize, j: usize, centre: Vec3| {
        let at = |di: usize, dj: usize| heights[(j + dj) * (COLUMNS + 1) + i + di];
        let mean = (at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1)) * 0.25;
        let step = 2.0 * HALF / COLUMNS as f32;
        let slope = Vec2::new(at(1, 0) - at(0, 0), at(0, 1) - at(0, 0)).length() / step;
        if centre.z > 0.03 {
            land(&noise, centre, slope)
        } else {
            water(centre, mean)
        }
    };
    mesh.grid(COLUMNS, ROWS, point, color);
    stage::scene(
        mesh,
        (Vec3::new(0.0, -38.0, 17.0), Vec3::new(0.0, 0.0, 0.9), 9.6),
        Vec3::new(-0.5, 0.5, 0.7),
        stage::turntable(0.2, 0.0),
    )
}

fn place(i: usize, j: usize) -> Vec2 {
    let at = |k: usize, n: usize| HALF * (2.0 * k as f32 / n as f32 - 1.0);
    Vec2::new(at(i, COLUMNS), at(j, ROWS))
}

/// Heights above the sea, row by row; below zero under it.
fn heights(noise: &Noise) -> Vec<f32> {
    (0..=ROWS)
        .into_par_iter()
        .flat_map_iter(|j| (0..=COLUMNS).map(move |i| height(noise, place(i, j))))
        .collect()
}

fn height(noise: &Noise, p: Vec2) -> f32 {
    let q = p / HALF;
    let coast = q.length() + 0.3 * (noise.value(q * 2.6 + 40.0).x - 0.5);
    let island = 1.0 - smoothstep(0.15, 0.85, coast);
    let rock = noise.mountains(q * 2.4 + Vec2::new(11.3, 7.1), 11);
    HEIGHT * (rock * (0.25 + 0.75 * island) * island.sqrt() - 0.1)
}

/// A ripple for the sun to glitter on.
fn wave(noise: &Noise, p: Vec2) -> f32 {
    let swell = noise.value(p * Vec2::new(1.1, 2.2)).x - 0.5;
    let ripple = noise.value(p * Vec2::new(4.0, 7.0) + 90.0).x - 0.5;
    0.03 * swell + 0.012 * ripple
}

/// By height above the sea and slope, with some chance.
fn land(noise: &Noise, p: Vec3, slope: f32) -> Rgb {
    let jitter = noise.value(p.truncate() * 2.0 + 17.0).x - 0.5;
    let grain = noise.value(p.truncate() * 11.0).x - 0.5;
    let stops = [
        (0.05, Rgb::new(242, 222, 164)),
        (0.2, Rgb::new(226, 206, 140)),
        (0.32, Rgb::new(126, 178, 72)),
        (1.0, Rgb::new(74, 148, 62)),
        (1.9, Rgb::new(96, 130, 70)),
        (2.5, Rgb::new(168, 148, 122)),
    ];
    let ground = gradient(&stops, p.z + 0.35 * jitter * p.z.min(1.0));
    let rock = mix(
        Rgb::new(172, 146, 122),
        Rgb::new(126, 112, 108),
        jitter + 0.5,
    );
    let bare = mix(ground, rock, smoothstep(0.75, 1.15, slope + 0.3 * grain));
    let snow = smoothstep(2.7, 3.1, p.z + 1.2 * jitter) * smoothstep(1.5, 0.9, slope);
    scaled(mix(bare, Rgb::new(252, 252, 255), snow), 1.0 + 0.25 * grain)
}

/// From turquoise to deep blue to nothing at the world's rim.
fn water(p: Vec3, bottom: f32) -> Rgb {
    let stops = [
        (0.0, Rgb::new(150, 236, 220)),
        (0.25, Rgb::new(60, 180, 200)),
        (0.7, Rgb::new(28, 110, 170)),
        (1.1, Rgb::new(16, 66, 128)),
    ];
    let rim = smoothstep(0.99, 0.72, p.truncate().length() / HALF);
    scaled(gradient(&stops, -bottom), rim)
}
