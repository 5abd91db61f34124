//! Houses and towers: boxes whose walls are rows of windows, and what stands on their roofs.

use glam::{Vec2, Vec3};

use crate::color::Rgb;
use crate::demo::mesh::Mesh;
use crate::demo::palette::{mix, scaled};
use crate::demo::shapes::{block, cuboid_face};
use crate::math::Random;

/// From floor to floor, and from window to window at least.
const FLOOR: f32 = 0.17;
const WINDOW: f32 = 0.15;

const LIT: Rgb = Rgb::new(255, 222, 120);
const DARK: Rgb = Rgb::new(40, 52, 92);

/// What a house looks like.
#[derive(Clone, Copy, Debug)]
pub struct Style {
    wall: Rgb,
    roof: Rgb,
    gabled: bool,
}

impl Style {
    /// A style for a house; the nearer to the middle of the city (`downtown` 1), the fewer gables.
    pub fn pick(random: &mut Random, downtown: f32) -> Style {
        const WALLS: [Rgb; 6] = [
            Rgb::new(160, 84, 66),
            Rgb::new(158, 136, 110),
            Rgb::new(122, 128, 148),
            Rgb::new(92, 112, 150),
            Rgb::new(160, 118, 84),
            Rgb::new(106, 132, 124),
        ];
        const ROOFS: [Rgb; 3] = [
            Rgb::new(168, 66, 50),
            Rgb::new(112, 58, 56),
            Rgb::new(74, 80, 106),
        ];
        Style {
            wall: WALLS[random.below(6) as usize],
            roof: ROOFS[random.below(3) as usize],
            gabled: random.unit() > 1.6 * downtown,
        }
    }
}

/// A house of about `height` on a lot.
pub fn house(
    mesh: &mut Mesh,
    random: &mut Random,
    centre: Vec2,
    half: Vec2,
    height: f32,
    style: Style,
) {
    let height = (height / FLOOR).round() * FLOOR;
    let min = (centre - half).extend(0.03);
    let max = (centre + half).extend(0.03 + height);
    walls(mesh, random, min, max, style.wall, 0.45);
    if style.gabled {
        gable(mesh, min.with_z(max.z), max, style);
    } else {
        flat_roof(mesh, random, min, max, style.wall);
    }
}

/// A tower of about `height`: two to four boxes, each narrower than the one below, and a mast.
pub fn tower(mesh: &mut Mesh, random: &mut Random, centre: Vec2, half: f32, height: f32) {
    const GLASS: [Rgb; 4] = [
        Rgb::new(66, 120, 160),
        Rgb::new(112, 120, 142),
        Rgb::new(142, 110, 82),
        Rgb::new(80, 84, 150),
    ];
    let wall = GLASS[random.below(4) as usize];
    let tiers = 2 + random.below(3);
    let (mut bottom, mut half) = (0.03, Vec2::splat(half));
    for tier in 0..tiers {
        let share = height / tiers as f32 * random.range(0.8, 1.2);
        let top = bottom + (share / FLOOR).round().max(2.0) * FLOOR;
        let (min, max) = ((centre - half).extend(bottom), (centre + half).extend(top));
        walls(mesh, random, min, max, wall, 0.55);
        if tier + 1 == tiers {
            flat_roof(mesh, random, min, max, wall);
            mast(mesh, centre.extend(top), 0.35 * half.x + 0.2 * share);
        } else {
            mesh.quad(cuboid_face(min, max, 5), scaled(wall, 0.7));
        }
        bottom = top;
        half *= Vec2::new(random.range(0.68, 0.88), random.range(0.68, 0.88));
    }
}

fn mast(mesh: &mut Mesh, foot: Vec3, height: f32) {
    let steel = Rgb::new(214, 220, 235);
    for (radius, low, high) in [(0.035, 0.0, 0.5), (0.012, 0.5, 1.0)] {
        let min = foot + Vec3::new(-radius, -radius, low * height);
        let max = foot + Vec3::new(radius, radius, high * height);
        block(mesh, min, max, steel);
    }
    let lamp = foot + Vec3::Z * height;
    block(
        mesh,
        lamp - Vec3::splat(0.025),
        lamp + Vec3::splat(0.025),
        Rgb::new(255, 50, 40),
    );
}

/// Four walls of floors of windows, `lit` of them with light.
fn walls(mesh: &mut Mesh, random: &mut Random, min: Vec3, max: Vec3, wall: Rgb, lit: f32) {
    for face in 0..4 {
        let [left, right, _, top] = cuboid_face(min, max, face);
        let floors = ((top.z - left.z) / FLOOR).round().max(1.0) as usize;
        let columns = (left.distance(right) / WINDOW).floor().max(1.0) as usize;
        for floor in 0..floors {
            // A row of the wall: bottom corners left and right, top z.
            let z = |share: f32| left.z + (top.z - left.z) * (floor as f32 + share) / floors as f32;
            let strip = |a: f32, b: f32, low: f32, high: f32| {
                let (p, q) = (left.lerp(right, a), left.lerp(right, b));
                [
                    p.with_z(z(low)),
                    q.with_z(z(low)),
                    q.with_z(z(high)),
                    p.with_z(z(high)),
                ]
            };
            mesh.quad(strip(0.0, 1.0, 0.0, 0.35), wall);
            let mut pier = 0.0;
            for column in 0..columns {
                let (a, b) = (
                    (column as f32 + 0.22) / columns as f32,
                    (column as f32 + 0.78) / columns as f32,
                );
                mesh.quad(strip(pier, a, 0.35, 1.0), wall);
                let glass = if random.unit() < lit {
                    mix(LIT, Rgb::new(255, 250, 220), random.unit())
                } else {
                    scaled(DARK, random.range(0.7, 1.2))
                };
                mesh.quad(strip(a, b, 0.35, 1.0), glass);
                pier = b;
            }
            mesh.quad(strip(pier, 1.0, 0.35, 1.0), wall);
        }
    }
}

/// A roof with a ridge along the longer side; eaves stand out a little.
fn gable(mesh: &mut Mesh, min: Vec3, max: Vec3, style: Style) {
    let size = max - min;
    let along_x = size.x >= size.y;
    let (run, width) = if along_x {
        (size.x, size.y)
    } else {
        (size.y, size.x)
    };
    let rise = 0.42 * width;
    let (out, eave) = (0.04, 0.04);
    // u along the ridge from 0 to `run`, v across it from 0 to `width`.
    let at = |u: f32, v: f32, z: f32| {
        let offset = if along_x {
            Vec3::new(u, v, z)
        } else {
            Vec3::new(width - v, u, z)
        };
        min + offset
    };
    let ridge = [
        at(-out, width * 0.5, rise),
        at(run + out, width * 0.5, rise),
    ];
    let drop = eave * 2.0 * rise / width;
    let front = [at(-out, -eave, -drop), at(run + out, -eave, -drop)];
    let back = [
        at(-out, width + eave, -drop),
        at(run + out, width + eave, -drop),
    ];
    mesh.quad([front[0], front[1], ridge[1], ridge[0]], style.roof);
    mesh.quad([back[1], back[0], ridge[0], ridge[1]], style.roof);
    let peak = |u: f32| at(u, width * 0.5, rise);
    mesh.triangle(
        [at(0.0, width, 0.0), at(0.0, 0.0, 0.0), peak(0.0)],
        style.wall,
    );
    mesh.triangle(
        [at(run, 0.0, 0.0), at(run, width, 0.0), peak(run)],
        style.wall,
    );
    let chimney = at(run * 0.7, width * 0.3, rise * 0.4);
    block(
        mesh,
        chimney - Vec3::new(0.03, 0.03, 0.0),
        chimney + Vec3::new(0.03, 0.03, rise * 0.75),
        scaled(style.wall, 0.8),
    );
}

/// A floor, a parapet around it, and boxes of machinery.
fn flat_roof(mesh: &mut Mesh, random: &mut Random, min: Vec3, max: Vec3, wall: Rgb) {
    let floor = scaled(wall, 0.62);
    mesh.quad(cuboid_face(min, max, 5), floor);
    let (t, h) = (0.03, 0.05);
    let rail = [
        (min.x, min.y, max.x, min.y + t),
        (min.x, max.y - t, max.x, max.y),
        (min.x, min.y + t, min.x + t, max.y - t),
        (max.x - t, min.y + t, max.x, max.y - t),
    ];
    for (x0, y0, x1, y1) in rail {
        block(
            mesh,
            Vec3::new(x0, y0, max.z),
            Vec3::new(x1, y1, max.z + h),
            wall,
        );
    }
    let inner = ((max - min).truncate() * 0.5 - 0.16).max(Vec2::ZERO);
    for _ in 0..2 + random.below(3) {
        let p = ((min + max).truncate() * 0.5 + random.point().truncate() * inner).extend(max.z);
        let size = Vec3::new(random.range(0.04, 0.09), random.range(0.04, 0.09), 0.0);
        let top = Vec3::Z * random.range(0.05, 0.14);
        block(mesh, p - size, p + size + top, Rgb::new(190, 196, 206));
    }
}
