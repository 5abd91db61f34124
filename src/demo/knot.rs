//! A torus knot: a tube that winds twice around one axis of a torus while it winds five times around the other.

use glam::Vec3;

use super::mesh::Mesh;
use super::palette::hue;
use super::shapes::{around, tube};
use super::stage;
use crate::scene::Scene;

/// Pieces along the tube.
const PIECES: usize = 900;

/// Faces around it.
const SIDES: usize = 40;

/// Turns around the torus' hole and around its body.
const TURNS: (usize, usize) = (2, 5);

/// How often the stripes wind around the tube on its way.
const TWIST: usize = 7;

/// The scene.
pub fn scene() -> Scene {
    let mut mesh = Mesh::default();
    let path: Vec<Vec3> = (0..PIECES).map(|i| on_torus(i).0).collect();
    let ups: Vec<Vec3> = (0..PIECES).map(twisted).collect();
    tube(
        &mut mesh,
        (&path, &ups, true),
        |_| 0.37,
        SIDES,
        |i, j, _| {
            let stripe = j % 10 < 2;
            hue(i as f32 / PIECES as f32, if stripe { 0.75 } else { 0.1 })
        },
    );
    stage::scene(
        mesh,
        (Vec3::new(0.0, -8.6, 7.4), Vec3::new(0.0, 0.0, -0.1), 3.15),
        Vec3::new(-0.45, 0.4, 0.8),
        stage::turntable(-0.5, 0.3),
    )
}

/// Point `i` of the path, and the direction from the torus' core to it.
fn on_torus(i: usize) -> (Vec3, Vec3) {
    let hole = around(i * TURNS.0, PIECES);
    let body = around(i * TURNS.1, PIECES);
    let out = (hole * body.x).extend(body.y);
    (hole.extend(0.0) * 2.0 + out * 0.95, out)
}

/// A direction across the path at point `i` that winds around it.
fn twisted(i: usize) -> Vec3 {
    let (here, out) = on_torus(i);
    let ahead = (on_torus(i + 1).0 - here).normalize();
    let side = ahead.cross(out).normalize();
    let turn = around(i * TWIST, PIECES);
    side.cross(ahead) * turn.x + side * turn.y
}
