//! A planetary gear: a sun, five planets and a ring, in brass and steel.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::mesh::Mesh;
use super::palette::scaled;
use super::stage;
use crate::color::Rgb;
use crate::scene::Scene;

/// Teeth of the sun, of a planet and of the ring: ring = sun + 2 · planet, and five planets fit where (sun + ring) / 5
/// is whole.
const SUN: usize = 20;
const PLANET: usize = 15;
const RING: usize = SUN + 2 * PLANET;
const PLANETS: usize = 5;

/// Diameter of a wheel's pitch circle for each of its teeth: radius = MODULE · teeth / 2.
const MODULE: f32 = 0.13;

/// The scene.
pub fn scene() -> Scene {
    let mut mesh = Mesh::default();
    let radius = |teeth: usize| MODULE * teeth as f32 / 2.0;
    let brass = Rgb::new(255, 206, 96);
    wheel(
        &mut mesh,
        &Wheel {
            centre: Vec2::ZERO,
            teeth: SUN,
            phase: 0.0,
            hole: 0.45,
            thick: 0.34,
            color: brass,
        },
    );
    for i in 0..PLANETS {
        let turn = i as f32 / PLANETS as f32;
        let (s, c) = libm::sincosf(TAU * turn);
        let centre = Vec2::new(c, s) * radius(SUN + PLANET);
        // Where the planet meets the sun's tooth, it has a gap.
        let phase = turn + 0.5 + (turn * SUN as f32 + 0.5) / PLANET as f32;
        let color = super::palette::hue(0.6 * turn + 0.45, 0.3);
        wheel(
            &mut mesh,
            &Wheel {
                centre,
                teeth: PLANET,
                phase,
                hole: 0.3,
                thick: 0.3,
                color,
            },
        );
    }
    ring(&mut mesh);
    stage::scene(
        mesh,
        (Vec3::new(0.0, -8.6, 8.2), Vec3::new(0.0, 0.0, -0.3), 3.5),
        Vec3::new(-0.3, 0.6, 0.75),
        stage::turntable(-0.35, 0.0),
    )
}

struct Wheel {
    centre: Vec2,
    teeth: usize,
    /// Of a turn, where a tooth's middle is.
    phase: f32,
    hole: f32,
    /// Half the thickness.
    thick: f32,
    color: Rgb,
}

/// Points of a tooth: (share of the pitch, height over the pitch circle in modules).
const TOOTH: [(f32, f32); 8] = [
    (-0.5, -1.1),
    (-0.30, -1.1),
    (-0.245, -0.35),
    (-0.17, 0.55),
    (-0.1, 0.95),
    (0.1, 0.95),
    (0.17, 0.55),
    (0.245, -0.35),
];

/// The outline of `teeth` teeth, `turned` by a share of a turn; `sign` -1 for teeth that point inwards.
fn outline(teeth: usize, phase: f32, sign: f32) -> Vec<Vec2> {
    let mut points = Vec::new();
    for tooth in 0..teeth {
        let mut add = |share: f32, height: f32| {
            let (s, c) = libm::sincosf(TAU * ((tooth as f32 + share) / teeth as f32 + phase));
            points.push(Vec2::new(c, s) * MODULE * (teeth as f32 / 2.0 + sign * height));
        };
        for (share, height) in TOOTH {
            add(share, height);
        }
        add(0.30, -1.1);
    }
    points.push(points[0]);
    points
}

/// `outline` pushed out or in to a circle.
fn circle(outline: &[Vec2], radius: f32) -> Vec<Vec2> {
    outline.iter().map(|p| p.normalize() * radius).collect()
}

fn wheel(mesh: &mut Mesh, w: &Wheel) {
    let rim = outline(w.teeth, w.phase, 1.0);
    let radius = MODULE * w.teeth as f32 / 2.0;
    // From the rim over a groove in the face to the hub and its hole: (share of the way in, height).
    let circles = [
        (radius - 2.4 * MODULE, 1.0),
        (radius - 2.9 * MODULE, 0.55),
        (w.hole + 0.16, 0.55),
        (w.hole + 0.1, 1.2),
        (w.hole, 1.2),
    ];
    let mut loops = vec![(rim.clone(), 1.0)];
    loops.extend(circles.map(|(r, h)| (circle(&rim, r), h)));
    faces(mesh, w.centre, &loops, w.thick, w.color);
}

/// Walls and both faces between closed `loops` (outermost first, each with its height in `thick`), the first and the
/// last joined through the body.
fn faces(mesh: &mut Mesh, centre: Vec2, loops: &[(Vec<Vec2>, f32)], thick: f32, color: Rgb) {
    let at = |(points, height): &(Vec<Vec2>, f32), j: usize, side: f32| {
        (centre + points[j]).extend(side * height * thick)
    };
    let first = &loops[0];
    let last = &loops[loops.len() - 1];
    for j in 0..first.0.len() - 1 {
        let mut strip = |a: [Vec3; 2], b: [Vec3; 2], shade: f32| {
            mesh.quad([a[0], a[1], b[1], b[0]], scaled(color, shade));
        };
        let edge = |l, side| [at(l, j, side), at(l, j + 1, side)];
        strip(edge(first, -1.0), edge(first, 1.0), 0.9);
        strip(edge(last, 1.0), edge(last, -1.0), 0.7);
        for (k, pair) in loops.windows(2).enumerate() {
            let shade = if k == 2 { 0.6 } else { 1.0 };
            strip(edge(&pair[0], 1.0), edge(&pair[1], 1.0), shade);
            strip(edge(&pair[1], -1.0), edge(&pair[0], -1.0), shade);
        }
    }
}

fn ring(mesh: &mut Mesh) {
    let teeth = outline(RING, 0.5 / RING as f32, -1.0);
    let radius = MODULE * RING as f32 / 2.0;
    let loops = [
        (circle(&teeth, radius + 0.52), 0.85),
        (circle(&teeth, radius + 0.46), 1.0),
        (circle(&teeth, radius + 0.2), 1.0),
        (teeth.clone(), 1.0),
    ];
    faces(mesh, Vec2::ZERO, &loops, 0.36, Rgb::new(150, 172, 205));
}
