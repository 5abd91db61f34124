//! What the builders sort: boxes in eight lanes, with a number and a weight.

use glam::{Vec3, Vec4, Vec4Swizzles};

use crate::geometry::Aabb;
use crate::simd::{Simd, SimdBase, SimdSplit, f32x4, f32x8};

/// A box as smallest x, y, z, a number, then largest x, y, z with the sign turned, a number: the box around two
/// boxes is one minimum of eight lanes.
///
/// The numbers ride along in the fourth lanes of a box ([`Prim::with`]) and mean nothing in a union. They are whole
/// floats below 2²⁴, not bit patterns: those would be denormal floats, with which arithmetic takes many times as long.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug)]
pub(super) struct Prim(pub(super) [f32; 8]);

impl Prim {
    /// Holds nothing.
    pub(super) const EMPTY: Prim = Prim([f32::INFINITY; 8]);

    /// Heavier ones count as if they had this weight.
    pub(super) const MAX_WEIGHT: u32 = 0xffff;

    /// The box of a triangle, without number and weight.
    #[inline(always)]
    pub(super) fn of(corners: &[Vec3; 3]) -> Prim {
        let [a, b, c] = corners.map(|p| p.extend(0.0));
        Prim::new(a.min(b).min(c), -a.max(b).max(c))
    }

    #[inline(always)]
    fn new(low: Vec4, minus_high: Vec4) -> Prim {
        let mut lanes = [0.0; 8];
        low.write_to_slice(&mut lanes[..4]);
        minus_high.write_to_slice(&mut lanes[4..]);
        Prim(lanes)
    }

    /// The same box with a number and a weight.
    #[inline(always)]
    pub(super) fn with(mut self, number: u32, weight: u32) -> Prim {
        self.0[3] = (number & 0xff_ffff) as f32;
        self.0[7] = (number >> 24 << 16 | weight.min(Prim::MAX_WEIGHT)) as f32;
        self
    }

    /// The number.
    #[inline(always)]
    pub(super) fn number(&self) -> u32 {
        self.0[3] as u32 | self.0[7] as u32 >> 16 << 24
    }

    /// The weight, at most [`Prim::MAX_WEIGHT`].
    #[inline(always)]
    pub(super) fn weight(&self) -> u32 {
        self.0[7] as u32 & Prim::MAX_WEIGHT
    }

    #[inline(always)]
    fn low(&self) -> Vec4 {
        Vec4::from_slice(&self.0[..4])
    }

    #[inline(always)]
    fn minus_high(&self) -> Vec4 {
        Vec4::from_slice(&self.0[4..])
    }

    /// The box around both; no number.
    #[inline(always)]
    pub(super) fn join(&self, other: &Prim) -> Prim {
        Prim::new(
            self.low().min(other.low()),
            self.minus_high().min(other.minus_high()),
        )
    }

    /// Half of the surface area of the box, its lengths taken `scale` times; 0 when it holds nothing.
    #[inline(always)]
    pub(super) fn half_area(&self, scale: f32) -> f32 {
        let d = ((self.low() + self.minus_high()) * -scale).max(Vec4::ZERO);
        let p = d * d.yzxw();
        p.x + p.y + p.z
    }

    /// As a plain box.
    pub(super) fn aabb(&self) -> Aabb {
        Aabb {
            min: self.low().xyz(),
            max: (-self.minus_high()).xyz(),
        }
    }
}

/// The lanes of a box.
#[inline(always)]
pub(super) fn load<S: Simd>(simd: S, prim: &Prim) -> f32x8<S> {
    f32x8::load_array_ref(simd, &prim.0)
}

/// The middle of a box. The fourth lane is of no use.
#[inline(always)]
pub(super) fn middle<S: Simd>(simd: S, prim: &Prim) -> f32x4<S> {
    let (low, minus_high) = load(simd, prim).split();
    let half = f32x4::splat(simd, 0.5);
    // Half of each bound first: the sum may be beyond the range of f32.
    low * half - minus_high * half
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_weights_survive() {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
        for number in [0, 1, 0xff_ffff, 0x100_0000, 0xdead_beef, u32::MAX] {
            for weight in [0, 1, 16, 0xffff] {
                let prim = Prim::of(&corners).with(number, weight);
                assert_eq!((prim.number(), prim.weight()), (number, weight));
            }
        }
        assert_eq!(Prim::of(&corners).with(7, 1 << 20).weight(), 0xffff);
    }

    #[test]
    fn nothing_has_no_area() {
        assert_eq!(Prim::EMPTY.half_area(1.0), 0.0);
        assert!(Prim::EMPTY.aabb().is_empty());
        let flat = Prim::of(&[Vec3::ZERO, Vec3::X * 2.0, Vec3::Y * 3.0]);
        assert_eq!(flat.half_area(0.5), 1.5);
        assert_eq!(Prim::EMPTY.join(&flat).aabb(), flat.aabb());
    }
}
