//! Colours by numbers in 0..=1.

use glam::Vec3;

use crate::color::Rgb;

/// The colour `(r, g, b)`, each kept in 0..=1.
pub fn rgb(c: Vec3) -> Rgb {
    let c = (c.clamp(Vec3::ZERO, Vec3::ONE) * 255.0).round();
    // In 0..=255 by the line above.
    Rgb::new(c.x as u8, c.y as u8, c.z as u8)
}

/// A colour's channels in 0..=1.
pub fn channels(c: Rgb) -> Vec3 {
    Vec3::new(f32::from(c.r), f32::from(c.g), f32::from(c.b)) / 255.0
}

/// From `a` at 0 to `b` at 1.
pub fn mix(a: Rgb, b: Rgb, t: f32) -> Rgb {
    rgb(channels(a).lerp(channels(b), t.clamp(0.0, 1.0)))
}

/// `c` brighter or darker by a factor.
pub fn scaled(c: Rgb, factor: f32) -> Rgb {
    rgb(channels(c) * factor)
}

/// The colour wheel: 0 red, 1/3 green, 2/3 blue, 1 red again; `pale` from 0 (full) to 1 (white).
pub fn hue(turn: f32, pale: f32) -> Rgb {
    let channel = |shift: f32| {
        let x = (turn + shift).rem_euclid(1.0) * 6.0;
        ((x - 3.0).abs() - 1.0).clamp(0.0, 1.0)
    };
    let full = Vec3::new(channel(0.0), channel(2.0 / 3.0), channel(1.0 / 3.0));
    rgb(full.lerp(Vec3::ONE, pale))
}

/// A colour between stops that rise from low to high.
pub fn gradient(stops: &[(f32, Rgb)], t: f32) -> Rgb {
    let above = stops.iter().position(|&(at, _)| at > t);
    match above {
        Some(0) => stops[0].1,
        Some(i) => {
            let ((low, a), (high, b)) = (stops[i - 1], stops[i]);
            mix(a, b, (t - low) / (high - low))
        }
        None => stops[stops.len() - 1].1,
    }
}

/// 0 below `low`, 1 above `high`, smooth between.
pub fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
