//! Smooth chance in the plane, with its slope.

use glam::{Vec2, Vec3};

use crate::math::Random;

/// Lattice points along an edge before the pattern repeats.
const SIDE: usize = 256;

/// Random heights on a lattice.
#[derive(Debug)]
pub struct Noise(Vec<f32>);

impl Noise {
    /// The noise of a seed.
    pub fn new(seed: u64) -> Noise {
        let mut random = Random::new(seed);
        Noise((0..SIDE * SIDE).map(|_| random.unit()).collect())
    }

    fn lattice(&self, x: i32, y: i32) -> f32 {
        let wrap = |i: i32| i.rem_euclid(SIDE as i32) as usize;
        self.0[wrap(y) * SIDE + wrap(x)]
    }

    /// Value in 0..1 and its derivatives by x and y. Fifth-order fade: curvature has no steps either.
    pub fn value(&self, p: Vec2) -> Vec3 {
        let cell = p.floor();
        let f = p - cell;
        let fade = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
        let slope = f * f * (f * (f - 2.0) + 1.0) * 30.0;
        // Scenes span a few thousand cells.
        let (x, y) = (cell.x as i32, cell.y as i32);
        let a = self.lattice(x, y);
        let b = self.lattice(x + 1, y);
        let c = self.lattice(x, y + 1);
        let d = self.lattice(x + 1, y + 1);
        let twist = a - b - c + d;
        Vec3::new(
            a + (b - a) * fade.x + (c - a) * fade.y + twist * fade.x * fade.y,
            slope.x * (b - a + twist * fade.y),
            slope.y * (c - a + twist * fade.x),
        )
    }

    /// Mountains in about 0..1.3: octaves of noise that grow weaker where the sum of the coarser ones is steep,
    /// so ridges stay sharp and slopes look washed out. Source: Quílez, "Value noise derivatives", 2008.
    pub fn mountains(&self, p: Vec2, octaves: u32) -> f32 {
        let (mut p, mut sum, mut weight, mut slope) = (p, 0.0, 0.5, Vec2::ZERO);
        for _ in 0..octaves {
            let n = self.value(p);
            slope += Vec2::new(n.y, n.z);
            sum += weight * n.x / (1.0 + slope.length_squared());
            weight *= 0.5;
            // Turned, so that no octave's lattice lies on the last one's. Not by Mat2: that is SIMD on some machines.
            p = 2.0 * Vec2::new(0.8 * p.x - 0.6 * p.y, 0.6 * p.x + 0.8 * p.y);
        }
        sum
    }
}
