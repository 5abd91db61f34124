//! Scenes and cameras that several test programs share.
#![allow(dead_code, reason = "each test program uses a part")]

use glam::{DVec3, Vec3};
use raybomb::camera::{Camera, View};
use raybomb::color::Rgb;
use raybomb::math::Random;
use raybomb::scene::{CameraSetting, Scene, Triangle};

/// A scene of triangles, lit from above.
pub fn scene(triangles: Vec<[Vec3; 3]>) -> Scene {
    let triangles = triangles
        .into_iter()
        .enumerate()
        .map(|(i, corners)| Triangle {
            corners,
            color: Rgb::new((i * 37 % 256) as u8, (i * 91 % 256) as u8, 200),
        })
        .collect();
    Scene {
        camera: CameraSetting::Default,
        light: Vec3::new(-0.45, -1.0, -0.35),
        triangles,
        operations: Vec::new(),
    }
}

/// A camera at `eye` that looks at `target`, with half the plane's height `tan` times its distance.
pub fn look_at(eye: Vec3, target: Vec3, tan: f64, aspect: f64) -> Camera {
    let (eye, target) = (eye.as_dvec3(), target.as_dvec3());
    let back = (eye - target).normalize();
    let up = if back.y.abs() > 0.9 {
        DVec3::X
    } else {
        DVec3::Y
    };
    let right = up.cross(back).normalize();
    let up = back.cross(right);
    let distance = (eye - target).length();
    let (half_height, half_width) = (distance * tan, distance * tan * aspect);
    let corner = |x: f64, y: f64| target + right * (x * half_width) + up * (y * half_height);
    Camera {
        eye,
        top_left: corner(-1.0, 1.0),
        top_right: corner(1.0, 1.0),
        bottom_left: corner(-1.0, -1.0),
    }
}

/// A closed bumpy ball about `centre` with radii between 1 and 1 + `bump`: `4 n (n - 1)` triangles.
pub fn ball(random: &mut Random, n: usize, bump: f32, centre: Vec3) -> Vec<[Vec3; 3]> {
    use std::f32::consts::PI;
    let radii: Vec<f32> = (0..(n + 1) * 2 * n)
        .map(|_| 1.0 + bump * random.unit())
        .collect();
    let point = |i: usize, j: usize| {
        let j = j % (2 * n);
        let (a, b) = (i as f32 / n as f32 * PI, j as f32 / n as f32 * PI);
        let radius = match i {
            0 => radii[0],
            i if i == n => radii[1],
            i => radii[i * 2 * n + j],
        };
        let (sa, ca) = match i {
            0 => (0.0, 1.0),
            i if i == n => (0.0, -1.0),
            _ => (a.sin(), a.cos()),
        };
        centre + radius * Vec3::new(sa * b.cos(), ca, sa * b.sin())
    };
    let mut triangles = Vec::with_capacity(4 * n * (n - 1));
    for i in 0..n {
        for j in 0..2 * n {
            let (a, b, c, d) = (
                point(i, j),
                point(i, j + 1),
                point(i + 1, j),
                point(i + 1, j + 1),
            );
            if i > 0 {
                triangles.push([a, b, c]);
            }
            if i < n - 1 {
                triangles.push([b, d, c]);
            }
        }
    }
    triangles
}

/// A sheet in front of a view whose vertices lie on the centres of every `step`-th pixel, as near as `f32` can say,
/// at a distance of its own each; it reaches beyond the picture on all sides.
pub fn sheet(
    view: &View,
    step: usize,
    mut distance: impl FnMut(f64, f64) -> f64,
) -> Vec<[Vec3; 3]> {
    let (columns, rows) = (view.width / step + 3, view.height / step + 3);
    let mut points = Vec::with_capacity(columns * rows);
    for j in 0..rows {
        for i in 0..columns {
            let (x, y) = (
                i as f64 * step as f64 - step as f64,
                j as f64 * step as f64 - step as f64,
            );
            let direction = view.base + view.dx * x + view.dy * y;
            points.push((view.eye.as_dvec3() + direction * distance(x, y)).as_vec3());
        }
    }
    let mut triangles = Vec::new();
    for j in 0..rows - 1 {
        for i in 0..columns - 1 {
            let at = j * columns + i;
            let (a, b, c, d) = (
                points[at],
                points[at + 1],
                points[at + columns],
                points[at + columns + 1],
            );
            if (i ^ j) & 1 == 0 {
                triangles.extend([[a, b, c], [c, b, d]]);
            } else {
                triangles.extend([[a, b, d], [d, c, a]]);
            }
        }
    }
    triangles
}

/// Triangles of very different sizes about the origin.
pub fn soup(random: &mut Random, n: usize) -> Vec<[Vec3; 3]> {
    (0..n)
        .map(|_| {
            let (at, size) = (random.point(), 10f32.powf(random.range(-3.0, 0.3)));
            [(); 3].map(|()| at + random.point() * size)
        })
        .collect()
}
