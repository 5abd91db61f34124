//! A city at night: blocks of houses on a street grid, towers in the middle, lit windows.

mod house;

use glam::{Vec2, Vec3};

use self::house::{Style, house, tower};
use super::mesh::Mesh;
use super::palette::mix;
use super::shapes::{around, block};
use super::stage;
use crate::color::Rgb;
use crate::math::Random;
use crate::scene::Scene;

/// Blocks along an edge.
const BLOCKS: i32 = 9;

/// From block to block, and half a block.
const PITCH: f32 = 2.4;
const HALF: f32 = 0.95;

const ASPHALT: Rgb = Rgb::new(36, 40, 58);
const LINE: Rgb = Rgb::new(250, 236, 170);
const PAVEMENT: Rgb = Rgb::new(78, 82, 104);
const GRASS: Rgb = Rgb::new(52, 116, 64);

/// The scene.
pub fn scene() -> Scene {
    let mut mesh = Mesh::default();
    let mut random = Random::new(1848);
    streets(&mut mesh, &mut random);
    for x in 0..BLOCKS {
        for y in 0..BLOCKS {
            let cell = Vec2::new(x as f32, y as f32) - (BLOCKS - 1) as f32 * 0.5;
            city_block(&mut mesh, &mut random, cell * PITCH);
        }
    }
    stage::scene(
        mesh,
        (Vec3::new(0.0, -28.5, 11.5), Vec3::new(0.0, 0.0, 0.9), 6.7),
        Vec3::new(-0.76, 0.03, 0.65),
        stage::turntable(0.25, 0.5),
    )
}

/// Ground, lane marks and cars.
fn streets(mesh: &mut Mesh, random: &mut Random) {
    let edge = PITCH * BLOCKS as f32 * 0.5;
    let low = Vec3::new(-edge, -edge, -0.3);
    block(mesh, low, Vec3::new(edge, edge, 0.0), ASPHALT);
    for line in 1..BLOCKS {
        let across = line as f32 * PITCH - edge;
        let dashes = (edge / 0.2) as i32;
        for dash in -dashes..dashes {
            let along = (dash as f32 + 0.5) * 0.2;
            let near_crossing = (along / PITCH - 0.5 * ((BLOCKS + 1) % 2) as f32).rem_euclid(1.0);
            if (near_crossing - 0.5).abs() < 0.14 {
                continue;
            }
            mark(
                mesh,
                Vec2::new(across, along),
                Vec2::new(0.012, 0.05),
                0.004,
                LINE,
            );
            mark(
                mesh,
                Vec2::new(along, across),
                Vec2::new(0.05, 0.012),
                0.004,
                LINE,
            );
            if random.below(6) == 0 {
                car(mesh, random, across, along);
            }
        }
    }
}

/// A level rectangle.
fn mark(mesh: &mut Mesh, centre: Vec2, half: Vec2, z: f32, color: Rgb) {
    let corner = |sx: f32, sy: f32| (centre + half * Vec2::new(sx, sy)).extend(z);
    let corners = [
        corner(-1.0, -1.0),
        corner(1.0, -1.0),
        corner(1.0, 1.0),
        corner(-1.0, 1.0),
    ];
    mesh.quad(corners, color);
}

/// A car on its side of the road, or none on a crossing.
fn car(mesh: &mut Mesh, random: &mut Random, across: f32, along: f32) {
    let paint = [
        Rgb::new(255, 60, 50),
        Rgb::new(255, 220, 60),
        Rgb::new(240, 240, 250),
        Rgb::new(70, 140, 255),
    ][random.below(4) as usize];
    let side = if random.below(2) == 0 { 0.11 } else { -0.11 };
    let turned = random.below(2) == 0;
    let place = |x: f32, y: f32, z: f32| {
        if turned {
            Vec3::new(along + y, across + x, z)
        } else {
            Vec3::new(across + x, along + y, z)
        }
    };
    let mut part = |a: Vec3, b: Vec3, color: Rgb| block(mesh, a.min(b), a.max(b), color);
    part(
        place(side - 0.045, -0.1, 0.015),
        place(side + 0.045, 0.1, 0.06),
        paint,
    );
    part(
        place(side - 0.038, -0.06, 0.06),
        place(side + 0.038, 0.04, 0.1),
        Rgb::new(150, 190, 220),
    );
}

/// What stands on one block: towers in the middle of the city, houses towards its rim, here and there a park.
fn city_block(mesh: &mut Mesh, random: &mut Random, centre: Vec2) {
    let park = random.below(9) == 0;
    let ground = if park { GRASS } else { PAVEMENT };
    let low = centre - HALF;
    block(mesh, low.extend(0.0), (centre + HALF).extend(0.03), ground);
    let downtown = (1.0 - centre.length() / (PITCH * BLOCKS as f32 * 0.5)).max(0.0);
    if park {
        trees(mesh, random, centre);
    } else if random.unit() < 1.5 * downtown - 0.35 {
        let height = 1.3 + 4.4 * downtown * downtown * random.range(0.6, 1.25);
        tower(mesh, random, centre, 0.8, height);
    } else {
        quarter(mesh, random, centre, downtown);
    }
}

/// Four lots with a house each.
fn quarter(mesh: &mut Mesh, random: &mut Random, centre: Vec2, downtown: f32) {
    for corner in 0..4 {
        let sign = Vec2::new((corner % 2) as f32, (corner / 2) as f32) * 2.0 - 1.0;
        let half = Vec2::new(random.range(0.33, 0.41), random.range(0.33, 0.41));
        let style = Style::pick(random, downtown);
        let height = 0.4 + random.range(0.0, 0.5) + 1.7 * downtown * random.unit();
        house(mesh, random, centre + sign * 0.46, half, height, style);
    }
}

fn trees(mesh: &mut Mesh, random: &mut Random, centre: Vec2) {
    mark(
        mesh,
        centre,
        Vec2::new(0.4, 0.28),
        0.036,
        Rgb::new(90, 180, 230),
    );
    for _ in 0..60 {
        let p = random.point().truncate() * 0.85;
        if p.x.abs() > 0.45 || p.y.abs() > 0.33 {
            tree(mesh, random, (centre + p).extend(0.03));
        }
    }
}

/// Two cones on a trunk.
fn tree(mesh: &mut Mesh, random: &mut Random, foot: Vec3) {
    const SIDES: usize = 7;
    let size = random.range(0.7, 1.3);
    let green = mix(Rgb::new(60, 150, 70), Rgb::new(150, 200, 70), random.unit());
    let trunk = Vec3::new(0.012, 0.012, 0.0);
    block(
        mesh,
        foot - trunk,
        foot + trunk + Vec3::Z * 0.08 * size,
        Rgb::new(150, 104, 70),
    );
    for (radius, low, high) in [(0.1, 0.06, 0.24), (0.075, 0.16, 0.34)] {
        let ring = |j: usize| foot + ((around(j, SIDES) * radius).extend(low)) * size;
        for j in 0..SIDES {
            mesh.triangle([ring(j), ring(j + 1), foot + Vec3::Z * high * size], green);
        }
    }
}
