//! Built-in scenes.

use glam::Vec3;

use crate::color::Rgb;
use crate::scene::{CameraSetting, Scene, Triangle};

/// A scene that comes with the program.
#[derive(Clone, Copy, Debug)]
pub struct Demo {
    /// What the command line calls it.
    pub name: &'static str,
    /// What it shows.
    pub title: &'static str,
    /// How many triangles it has.
    pub triangles: usize,
}

impl Demo {
    /// The scene.
    #[must_use]
    pub fn scene(&self) -> Scene {
        Scene {
            camera: CameraSetting::Default,
            light: Vec3::NEG_Z,
            triangles: vec![Triangle {
                corners: [Vec3::ZERO, Vec3::X, Vec3::Y],
                color: Rgb::new(255, 128, 0),
            }],
            operations: Vec::new(),
        }
    }
}

/// All demos; the first is shown when no scene is named.
#[must_use]
pub fn all() -> &'static [Demo] {
    &[Demo {
        name: "triangle",
        title: "one triangle",
        triangles: 1,
    }]
}
