//! The emblem: a bomb of the old school, its fuse lit.

use glam::{Vec2, Vec3};

use super::mesh::Mesh;
use super::palette::{gradient, mix, smoothstep};
use super::shapes::{Frame, around, ball, lathe, spread, tube};
use super::stage;
use crate::color::Rgb;
use crate::math::Random;
use crate::scene::Scene;

const IRON: Rgb = Rgb::new(92, 99, 128);
const SHEEN: Rgb = Rgb::new(244, 248, 255);
const GLOW: Rgb = Rgb::new(255, 120, 30);
const STEEL: Rgb = Rgb::new(150, 158, 178);

/// Centre of the ball of radius 1.
const CENTRE: Vec3 = Vec3::new(-0.36, 0.0, -0.26);

/// Where the cap sits, as seen from the centre: up, and to the right of the first picture.
const CAP: Vec3 = Vec3::new(0.42, -0.08, 0.9);

/// Where the fuse burns.
const SPARK: Vec3 = Vec3::new(1.11, -0.16, 0.78);

/// The scene.
pub fn scene() -> Scene {
    let mut mesh = Mesh::default();
    body(&mut mesh);
    for turn in 0..2 {
        window(&mut mesh, turn);
    }
    cap(&mut mesh);
    fuse(&mut mesh);
    star(&mut mesh);
    sparks(&mut mesh);
    let eye = Vec3::new(0.0, -7.6, 1.3);
    stage::scene(
        mesh,
        (eye, Vec3::new(0.0, 0.0, 0.04), 1.56),
        Vec3::new(-0.5, 0.3, 0.8),
        stage::turntable(0.25, 0.0),
    )
}

fn body(mesh: &mut Mesh) {
    const ROWS: usize = 60;
    let profile: Vec<Vec2> = (0..=ROWS)
        .map(|i| {
            let a = around(i, 2 * ROWS);
            Vec2::new(a.y, -a.x)
        })
        .collect();
    let frame = Frame::along(CENTRE, CAP);
    lathe(mesh, frame, &profile, 100, |_, _, p| {
        let n = (p - CENTRE).normalize();
        mix(
            IRON,
            GLOW,
            1.2 * glow(p) * n.dot((SPARK - p).normalize()).max(0.0),
        )
    });
}

/// How much of the spark's light arrives at `p`.
fn glow(p: Vec3) -> f32 {
    let d = p.distance_squared(SPARK);
    (0.75 / (0.4 + d)).min(1.0)
}

/// The window that every bomb reflects: a large ellipse and a small one below, laid on the ball; one to the left of the
/// first picture's middle, one on the far side.
fn window(mesh: &mut Mesh, turn: usize) {
    let a = around(turn, 2);
    for (x, y, z, long, wide) in [
        (-0.55, -0.66, 0.52, 0.3, 0.19),
        (-0.88, -0.62, 0.1, 0.1, 0.07),
    ] {
        let out = Vec3::new(a.x * x - a.y * y, a.y * x + a.x * y, z).normalize();
        let level = out.cross(Vec3::Z).normalize();
        // Leaning to the right like the curve of the ball there.
        let high = (out.cross(level) * -1.0 + level * 0.5).normalize();
        let across = high.cross(out);
        ellipse(mesh, out, [high * long, across * wide]);
    }
}

/// An ellipse on the ball around the direction `out`, brightest at its upper end.
fn ellipse(mesh: &mut Mesh, out: Vec3, axes: [Vec3; 2]) {
    const RINGS: usize = 8;
    const SIDES: usize = 48;
    let point = |i: usize, j: usize| {
        let a = around(j, SIDES) * i as f32 / RINGS as f32;
        CENTRE + (out + axes[0] * a.x + axes[1] * a.y).normalize() * 1.004
    };
    let length = axes[0].length_squared();
    mesh.grid(RINGS, SIDES, point, |_, _, p| {
        let up = (p - CENTRE - out).dot(axes[0]) / length;
        mix(IRON, SHEEN, 0.78 + 0.22 * up)
    });
}

fn cap(mesh: &mut Mesh) {
    let profile = [
        (0.36, 0.9),
        (0.36, 1.13),
        (0.33, 1.17),
        (0.17, 1.17),
        (0.15, 1.12),
        (0.0, 1.12),
    ]
    .map(|(r, h)| Vec2::new(r, h));
    lathe(mesh, Frame::along(CENTRE, CAP), &profile, 64, |i, _, p| {
        let steel = if i >= 3 {
            mix(STEEL, Rgb::BLACK, 0.6)
        } else {
            STEEL
        };
        mix(steel, GLOW, 0.6 * glow(p))
    });
}

fn fuse(mesh: &mut Mesh) {
    const PIECES: usize = 56;
    const SIDES: usize = 12;
    let start = CENTRE + CAP.normalize() * 1.1;
    let controls = [
        start,
        start + CAP.normalize() * 0.55,
        SPARK + Vec3::new(-0.1, 0.1, 0.7),
        SPARK,
    ];
    let path: Vec<Vec3> = (0..=PIECES)
        .map(|i| bezier(controls, i as f32 / PIECES as f32))
        .collect();
    let ups = vec![Vec3::Y; path.len()];
    let (rope, groove) = (Rgb::new(240, 206, 150), Rgb::new(140, 92, 50));
    tube(
        mesh,
        (&path, &ups, false),
        |_| 0.07,
        SIDES,
        |i, j, p| {
            // Two strands, wound round each other.
            let strand = if (i + j) % 4 < 3 { rope } else { groove };
            let ember = smoothstep(0.45, 0.05, p.distance(SPARK));
            mix(strand, GLOW, ember)
        },
    );
}

fn bezier([a, b, c, d]: [Vec3; 4], t: f32) -> Vec3 {
    let (ab, bc, cd) = (a.lerp(b, t), b.lerp(c, t), c.lerp(d, t));
    ab.lerp(bc, t).lerp(bc.lerp(cd, t), t)
}

/// The flame: long and short spikes, white within and red at their tips.
fn star(mesh: &mut Mesh) {
    const SPIKES: usize = 46;
    let mut random = Random::new(1);
    for i in 0..SPIKES {
        let long = if i % 2 == 0 { 1.0 } else { 0.6 };
        let length = 0.56 * long * random.range(0.75, 1.1);
        spike(mesh, spread(i, SPIKES), length);
    }
    for face in ball(2) {
        mesh.triangle(face.map(|p| SPARK + p * 0.17), Rgb::new(255, 252, 225));
    }
}

fn spike(mesh: &mut Mesh, direction: Vec3, length: f32) {
    const SIDES: usize = 5;
    const RINGS: usize = 4;
    let profile: Vec<Vec2> = (0..=RINGS)
        .map(|i| i as f32 / RINGS as f32)
        .map(|t| Vec2::new(0.095 * (1.0 - t), 0.06 + (length - 0.06) * t))
        .collect();
    let frame = Frame::along(SPARK, direction);
    lathe(mesh, frame, &profile, SIDES, |_, _, p| {
        flame(p.distance(SPARK))
    });
}

fn flame(distance: f32) -> Rgb {
    let stops = [
        (0.1, Rgb::new(255, 248, 190)),
        (0.2, Rgb::new(255, 214, 84)),
        (0.34, Rgb::new(255, 148, 24)),
        (0.54, Rgb::new(255, 60, 10)),
    ];
    gradient(&stops, distance)
}

/// What flies off: small tetrahedra around the flame.
fn sparks(mesh: &mut Mesh) {
    const SPARKS: usize = 34;
    let mut random = Random::new(6);
    for i in 0..SPARKS {
        let place = SPARK + spread(i, SPARKS) * random.range(0.5, 0.85);
        let size = random.range(0.015, 0.04);
        let color = mix(Rgb::new(255, 240, 150), GLOW, random.unit());
        let frame = Frame::along(place, random.point());
        let tip = frame.at(Vec3::Z * size * 1.4);
        let base = [0, 1, 2].map(|j| frame.at((around(j, 3) * size).extend(-size * 0.5)));
        mesh.triangle([base[2], base[1], base[0]], color);
        for j in 0..3 {
            mesh.triangle([base[j], base[(j + 1) % 3], tip], color);
        }
    }
}
