//! Rays that follow each other, and which of them keep together.

use glam::Vec3;

use super::Ray;
use super::frame::{TAME_DIR, TAME_SCENE};
use super::ready::{AXES, Extent, largest_of};
use crate::simd::{Lanes, SimdBase, bits, f32x4, lanes, load, transpose4};

/// Rays of a window at most.
pub const MOST: usize = 64;

/// A number for each ray.
pub type Row = [f32; MOST];

/// The axes in the order x′, y′, z′, z′ the one along which `dir` is longest, and 1 or −1: its sense there.
#[inline(always)]
pub fn main_axes(dir: Vec3) -> ([usize; 3], f32) {
    let size = dir.abs();
    let longest = largest_of(size);
    let z = (1 - usize::from(size.x == longest)) * (2 - usize::from(size.y == longest));
    (AXES[z], if dir[z] < 0.0 { -1.0 } else { 1.0 })
}

/// Up to 64 rays that follow each other.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct Window {
    pub origin: [Row; 3],
    pub dir: [Row; 3],
    pub t_min: Row,
    pub t_max: Row,
    count: usize,
    /// The rays that the bounds of errors hold for, as bits.
    pub tame: u64,
    /// The largest magnitude of a coordinate of an origin or of the scene.
    pub reach: f32,
}

impl Default for Window {
    fn default() -> Window {
        Window {
            origin: [[0.0; MOST]; 3],
            dir: [[0.0; MOST]; 3],
            t_min: [0.0; MOST],
            t_max: [0.0; MOST],
            count: 0,
            tame: 0,
            reach: 0.0,
        }
    }
}

impl Window {
    /// Takes up to [`MOST`] rays.
    #[inline(always)]
    pub fn fill<S: Lanes>(&mut self, simd: S, rays: &[Ray], extent: &Extent) {
        self.count = rays.len().min(MOST);
        let rays = &rays[..self.count];
        let fours = rays.chunks_exact(4);
        let rest = fours.remainder();
        for (i, four) in fours.enumerate() {
            let at = 4 * i;
            macro_rules! columns {
                ($row:expr) => {
                    transpose4([
                        $row(&four[0]),
                        $row(&four[1]),
                        $row(&four[2]),
                        $row(&four[3]),
                    ])
                };
            }
            let [ox, oy, oz, x] = columns!(|ray: &Ray| f32x4::load_array(
                simd,
                [ray.origin.x, ray.origin.y, ray.origin.z, ray.dir.x]
            ));
            let [y, z, t_min, t_max] = columns!(|ray: &Ray| f32x4::load_array(
                simd,
                [ray.dir.y, ray.dir.z, ray.t_min, ray.t_max]
            ));
            ox.store_slice(&mut self.origin[0][at..at + 4]);
            oy.store_slice(&mut self.origin[1][at..at + 4]);
            oz.store_slice(&mut self.origin[2][at..at + 4]);
            x.store_slice(&mut self.dir[0][at..at + 4]);
            y.store_slice(&mut self.dir[1][at..at + 4]);
            z.store_slice(&mut self.dir[2][at..at + 4]);
            t_min.store_slice(&mut self.t_min[at..at + 4]);
            t_max.store_slice(&mut self.t_max[at..at + 4]);
        }
        for (i, ray) in (self.count - rest.len()..).zip(rest) {
            for k in 0..3 {
                self.origin[k][i] = ray.origin[k];
                self.dir[k][i] = ray.dir[k];
            }
            self.t_min[i] = ray.t_min;
            self.t_max[i] = ray.t_max;
        }
        self.tame = 0;
        let mut farthest = S::f32s::splat(simd, 0.0);
        for at in (0..self.count).step_by(lanes::<S>()) {
            macro_rules! size {
                ($row:expr) => {
                    load(simd, &$row, at).abs()
                };
            }
            let [ox, oy, oz] = [
                size!(self.origin[0]),
                size!(self.origin[1]),
                size!(self.origin[2]),
            ];
            let [x, y, z] = [size!(self.dir[0]), size!(self.dir[1]), size!(self.dir[2])];
            let longest = x.max(y).max(z);
            let reach = ox.max(oy).max(oz).max(S::f32s::splat(simd, extent.reach));
            farthest = farthest.max(reach);
            // Each by itself: what is not a number is in no range.
            let (far, long) = (*TAME_SCENE.end(), *TAME_DIR.end());
            let tame = ox.simd_le(far)
                & oy.simd_le(far)
                & oz.simd_le(far)
                & reach.simd_ge(*TAME_SCENE.start())
                & x.simd_le(long)
                & y.simd_le(long)
                & z.simd_le(long)
                & longest.simd_ge(*TAME_DIR.start())
                & load(simd, &self.t_max, at).simd_ge(f32::NEG_INFINITY);
            self.tame |= u64::from(bits::<S>(tame)) << at;
        }
        self.tame &= u64::MAX >> (MOST - self.count);
        self.reach = farthest.reduce_max();
    }

    /// The direction of ray `i`.
    #[inline(always)]
    pub fn dir(&self, i: usize) -> Vec3 {
        let [x, y, z] = &self.dir;
        Vec3::new(x[i % MOST], y[i % MOST], z[i % MOST])
    }

    /// The tame rays whose slopes differ by at most `spread` from those of ray `seed`, as bits.
    #[inline(always)]
    pub fn like<S: Lanes>(&self, simd: S, seed: usize, spread: f32) -> u64 {
        macro_rules! splat {
            ($x:expr) => {
                S::f32s::splat(simd, $x)
            };
        }
        let dir = self.dir(seed);
        let ([ax, ay, az], sense) = main_axes(dir);
        let slopes = [dir[ax] / dir[az], dir[ay] / dir[az]];
        let mut members = 0;
        for at in (0..self.count).step_by(lanes::<S>()) {
            let [x, y, z] = [
                load(simd, &self.dir[ax], at),
                load(simd, &self.dir[ay], at),
                load(simd, &self.dir[az], at),
            ];
            let apart = (x - z * splat!(slopes[0]))
                .abs()
                .max((y - z * splat!(slopes[1])).abs());
            let ahead = z * splat!(sense);
            let like = apart.simd_le(ahead * splat!(spread)) & ahead.simd_gt(0.0);
            members |= u64::from(bits::<S>(like)) << at;
        }
        members & self.tame
    }
}
