//! The exact distances of many hits at once: those that [`Meeting::distance`](super::rule::Meeting::distance) tells,
//! to the bit.
//!
//! They are `f64` in a fixed order of steps, so lanes can take them: as many rays as there are lanes of `f32`, half of
//! them at a time. Lanes tell which of them are certain that the triangle's box changes nothing; the few others are
//! left to the rule.
//!
//! A triangle across an axis has a box without depth: the rule then gives the distance of its side, a quotient of
//! `f32` numbers in `f64`, rounded. Such a quotient has so many digits to spare that rounding it twice is rounding it
//! once, so it is a quotient in `f32`.

use super::Ray;
use super::block::{LANES, UNDERFLOW};
use super::ready::Ready;
use super::rule::INSIDE;
use super::single::hit;
use super::tree::RayTree;
use super::window::{MOST, Row};
use crate::frame::{Hit, MISS};
use crate::simd::{
    Lanes, Select, SimdBase, SimdFloat, SimdMask, SimdNarrow, SimdWiden, all_lanes, bits, lanes,
    load,
};
use crate::trace::space::ROUNDOFF;

/// Three coordinates of as many points as there are lanes.
type Points<S> = [<S as crate::simd::Simd>::f32s; 3];

/// Rays and the triangles that they hit.
#[derive(Clone, Copy, Debug)]
pub struct HitRows<'a> {
    /// By axis x, y, z.
    pub origin: [&'a Row; 3],
    pub dir: [&'a Row; 3],
    /// Block times 8 plus lane, or [`MISS`].
    pub slot: &'a [u32; MOST],
}

impl HitRows<'_> {
    /// Tells what those of the first `count` rays hit that hit anything, by their numbers; `ray` is the ray of a number as
    /// it came.
    #[inline(always)]
    pub fn each_hit<'r, S: Lanes>(
        &self,
        simd: S,
        tree: &RayTree,
        count: usize,
        ray: impl Fn(usize) -> &'r Ray,
        mut tell: impl FnMut(usize, Hit),
    ) {
        for at in (0..count).step_by(lanes::<S>()) {
            let slots = &self.slot[at..at + lanes::<S>()];
            let misses = bits::<S>(S::u32s::from_slice(simd, slots).simd_eq(MISS));
            let mut left =
                !misses & all_lanes::<S>() & u32::MAX >> 32usize.saturating_sub(count - at);
            if left == 0 {
                continue;
            }
            let (t, certain) = self.distances(simd, tree, at);
            while left != 0 {
                let lane = left.trailing_zeros() as usize % 16;
                left &= left - 1;
                let slot = self.slot[(at + lane) % MOST];
                let hit = if certain >> lane & 1 != 0 {
                    let id = tree.file_id(slot);
                    Hit { id, t: t[lane] }
                } else {
                    hit(tree, ray(at + lane), slot)
                };
                tell(at + lane, hit);
            }
        }
    }

    /// The distances of the rays from number `at` on, as many as there are lanes, and which of them are certain, as
    /// bits. Means something where a ray hits.
    #[inline(always)]
    fn distances<S: Lanes>(&self, simd: S, tree: &RayTree, at: usize) -> ([f32; 16], u32) {
        let slots = &self.slot[at..at + lanes::<S>()];
        let first = slots[0];
        let same = bits::<S>(S::u32s::from_slice(simd, slots).simd_eq(first)) == all_lanes::<S>();
        let row = |rows: &[&Row; 3]| {
            [
                load(simd, rows[0], at),
                load(simd, rows[1], at),
                load(simd, rows[2], at),
            ]
        };
        let (origin, dir) = (row(&self.origin), row(&self.dir));
        let (t, certain) = if same {
            of_one(simd, tree, first, &origin, &dir)
        } else {
            let corners = gather(simd, tree, slots);
            let (t, certain) = of_many(simd, &corners, &origin, &dir);
            if certain == all_lanes::<S>() {
                (t, certain)
            } else {
                let (of_flat, flat) = across_axis(simd, &corners, &origin, &dir);
                (flat.select(of_flat, t), certain | bits::<S>(flat))
            }
        };
        let mut distances = [0.0; 16];
        t.store_slice(&mut distances[..lanes::<S>()]);
        (distances, certain)
    }
}

/// Room for up to [`MOST`] rays of a stream and the triangles that they hit.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct HitRoom {
    origin: [Row; 3],
    dir: [Row; 3],
    slot: [u32; MOST],
}

impl Default for HitRoom {
    fn default() -> HitRoom {
        HitRoom {
            origin: [[0.0; MOST]; 3],
            dir: [[0.0; MOST]; 3],
            slot: [MISS; MOST],
        }
    }
}

impl HitRoom {
    /// Tells what the rays `which`, at most [`MOST`], hit: they are numbers of `rays` as they came and as they are
    /// `ready`.
    #[inline(always)]
    pub fn each_hit<S: Lanes>(
        &mut self,
        simd: S,
        tree: &RayTree,
        which: &[u16],
        ready: &[Ready],
        rays: &[Ray],
        mut tell: impl FnMut(usize, Hit),
    ) {
        self.slot = [MISS; MOST];
        for (at, &i) in which.iter().enumerate() {
            let (ray, slot) = (&rays[usize::from(i)], ready[usize::from(i)].nearest.slot);
            tree.prefetch_slot(slot);
            let at = at % MOST;
            for k in 0..3 {
                self.origin[k][at] = ray.origin[k];
                self.dir[k][at] = ray.dir[k];
            }
            self.slot[at] = slot;
        }
        let [ox, oy, oz] = &self.origin;
        let [x, y, z] = &self.dir;
        let rows = HitRows {
            origin: [ox, oy, oz],
            dir: [x, y, z],
            slot: &self.slot,
        };
        rows.each_hit(
            simd,
            tree,
            which.len(),
            #[inline(always)]
            |at| &rays[usize::from(which[at])],
            #[inline(always)]
            |at, hit| tell(usize::from(which[at]), hit),
        );
    }
}

/// The corners of a triangle for each lane; any where there is none.
#[inline(always)]
fn gather<S: Lanes>(simd: S, tree: &RayTree, slots: &[u32]) -> [Points<S>; 3] {
    let mut rows = [[[0.0; 16]; 3]; 3];
    for (lane, &slot) in slots.iter().enumerate().take(16) {
        let slot = if slot == MISS { 0 } else { slot as usize };
        let block = &tree.blocks[slot / LANES];
        for (rows, from) in rows.iter_mut().zip(&block.corners) {
            for (row, from) in rows.iter_mut().zip(from) {
                row[lane] = from[slot % LANES];
            }
        }
    }
    let point = |corner: usize| {
        [
            load(simd, &rows[corner][0], 0),
            load(simd, &rows[corner][1], 0),
            load(simd, &rows[corner][2], 0),
        ]
    };
    [point(0), point(1), point(2)]
}

/// The distances of a triangle that all rays hit, and in which lanes they are certain, as bits.
#[inline(always)]
fn of_one<S: Lanes>(
    simd: S,
    tree: &RayTree,
    slot: u32,
    origin: &Points<S>,
    dir: &Points<S>,
) -> (S::f32s, u32) {
    let [a, b, c] = tree.corners(slot);
    let flat = a.cmpeq(b) & b.cmpeq(c);
    // No closure for each of the three: it may not be inlined.
    macro_rules! splat {
        ($p:expr) => {
            [
                S::f32s::splat(simd, $p.x),
                S::f32s::splat(simd, $p.y),
                S::f32s::splat(simd, $p.z),
            ]
        };
    }
    let corners = [splat!(a), splat!(b), splat!(c)];
    if flat.any() {
        let across = flat.bitmask().trailing_zeros() as usize % 3;
        let t = (corners[0][across] - origin[across]) / dir[across];
        let mut certain = t.simd_eq(t);
        for k in [(across + 1) % 3, (across + 2) % 3] {
            certain &= within(simd, &corners, origin, dir, t, k);
        }
        if bits::<S>(certain) == all_lanes::<S>() {
            return (t, all_lanes::<S>());
        }
    }
    of_many(simd, &corners, origin, dir)
}

/// The distances of triangles across an axis, and in which lanes they are that and certain.
#[inline(always)]
fn across_axis<S: Lanes>(
    simd: S,
    corners: &[Points<S>; 3],
    origin: &Points<S>,
    dir: &Points<S>,
) -> (S::f32s, S::mask32s) {
    let [a, b, c] = corners;
    let mut t = S::f32s::splat(simd, f32::NAN);
    let mut flat = [t.simd_eq(t); 3];
    for k in 0..3 {
        flat[k] = a[k].simd_eq(b[k]) & b[k].simd_eq(c[k]);
        t = flat[k].select((a[k] - origin[k]) / dir[k], t);
    }
    let mut certain = t.simd_eq(t);
    for (k, flat) in flat.into_iter().enumerate() {
        certain &= flat | within(simd, corners, origin, dir, t, k);
    }
    (t, certain)
}

/// In which lanes the point at distance `t` lies well between the sides of the triangle's box across axis `k`.
#[inline(always)]
fn within<S: Lanes>(
    simd: S,
    corners: &[Points<S>; 3],
    origin: &Points<S>,
    dir: &Points<S>,
    t: S::f32s,
    k: usize,
) -> S::mask32s {
    let [a, b, c] = corners;
    let point = dir[k] * t;
    // Of a point, rounding makes less than three roundings.
    let margin = point.abs().mul_add(
        S::f32s::splat(simd, 8.0 * ROUNDOFF),
        S::f32s::splat(simd, UNDERFLOW),
    );
    let low = a[k].min(b[k]).min(c[k]) - origin[k];
    let high = a[k].max(b[k]).max(c[k]) - origin[k];
    (point - margin).simd_gt(low) & (point + margin).simd_lt(high)
}

/// The distances of a triangle for each ray that it hits, and in which lanes they are certain, as bits.
#[inline(always)]
fn of_many<S: Lanes>(
    simd: S,
    corners: &[Points<S>; 3],
    origin: &Points<S>,
    dir: &Points<S>,
) -> (S::f32s, u32) {
    macro_rules! relative {
        ($p:expr) => {
            [$p[0] - origin[0], $p[1] - origin[1], $p[2] - origin[2]]
        };
    }
    let (a, b, c) = (
        relative!(corners[0]),
        relative!(corners[1]),
        relative!(corners[2]),
    );
    macro_rules! of_axes {
        ($k:ident => $of:expr) => {
            [
                {
                    let $k = 0;
                    $of
                },
                {
                    let $k = 1;
                    $of
                },
                {
                    let $k = 2;
                    $of
                },
            ]
        };
    }
    let low = of_axes!(k => a[k].min(b[k]).min(c[k]).widen());
    let high = of_axes!(k => a[k].max(b[k]).max(c[k]).widen());
    let a = of_axes!(k => a[k].widen());
    let b = of_axes!(k => b[k].widen());
    let c = of_axes!(k => c[k].widen());
    let d = of_axes!(k => dir[k].widen());
    macro_rules! half {
        ($half:tt) => {
            half::<S>(
                simd,
                [a[0].$half, a[1].$half, a[2].$half],
                [b[0].$half, b[1].$half, b[2].$half],
                [c[0].$half, c[1].$half, c[2].$half],
                [d[0].$half, d[1].$half, d[2].$half],
                [low[0].$half, low[1].$half, low[2].$half],
                [high[0].$half, high[1].$half, high[2].$half],
            )
        };
    }
    let (first, certain) = half!(0);
    let (second, also_certain) = half!(1);
    (
        first.narrow(second),
        certain | also_certain << (lanes::<S>() / 2),
    )
}

/// Half of the lanes, step by step as the rule; and in which a point lies so well inside the box that it changes
/// nothing.
#[inline(always)]
fn half<S: Lanes>(
    simd: S,
    a: [S::f64s; 3],
    b: [S::f64s; 3],
    c: [S::f64s; 3],
    d: [S::f64s; 3],
    low: [S::f64s; 3],
    high: [S::f64s; 3],
) -> (S::f64s, u32) {
    let p = [c[0] - a[0], c[1] - a[1], c[2] - a[2]];
    let q = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let normal = [
        p[1] * q[2] - q[1] * p[2],
        p[2] * q[0] - q[2] * p[0],
        p[0] * q[1] - q[0] * p[1],
    ];
    let whole = normal[0] * a[0] + normal[1] * a[1] + normal[2] * a[2];
    let t = whole / (normal[0] * d[0] + normal[1] * d[1] + normal[2] * d[2]);
    let inside = S::f64s::splat(simd, INSIDE);
    let mut certain = t.simd_eq(t);
    for k in 0..3 {
        let point = d[k] * t;
        let margin = point.abs() * inside;
        certain &= (point - margin).simd_gt(low[k]) & (point + margin).simd_lt(high[k]);
    }
    (t, certain.to_bitmask() as u32)
}
