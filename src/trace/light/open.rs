//! Triangles that nothing lies above: a point of such a triangle sees the light, and that takes no search.
//!
//! Seen along the light, a triangle is *open* when no other rises above its plane within its outline. Whoever asks
//! for a point on a surface knows which triangle it lies on ([`Start`]); when that is an open one, all that is left
//! to find out is whether the point really lies within the outline and above the plane: four affine functions, for
//! as many points at once as there are lanes. All other points are looked up in the grid.
//!
//! # How exact
//! Places count from the middle of the scene; r is the farthest that corners and answered points are from it along
//! an axis, u the unit roundoff, s the sum of 1 and a plane's slopes. The rule of free rays rounds corners relative
//! to a ray's origin: by up to 4ur across the light, 2ur along it. The distance of a point from an edge is found
//! with an error below 28ur (a corner's: 22ur), its height above a plane with one below 20urs. So the ray of a point
//! that is found at least 96ur ([`INSET`]) inside the outline can only meet what lies 62ur inside. A triangle whose
//! corners are found on the outer side of an edge, or up to 32ur inside ([`TOUCHING`]), does not get there. Of all
//! others the corners are found no higher than 16urs above the plane ([`LEVEL`]), so they rise less than 36urs
//! above it, and a point that is found higher than that and the errors, 60urs ([`MARGIN`]), lies above them.

use glam::{DVec3, Vec3, Vec3Swizzles};
use rayon::prelude::*;

use super::frame::LightFrame;
use super::grid::LightGrid;
use crate::simd::{
    Bytes, Kernel, LANE_NUMBERS, Lanes, Select, SimdBase, all_lanes, bits, dispatch, lanes,
};
use crate::trace::space::ROUNDOFF;
use crate::world::World;

/// A point that a ray toward the light starts from: x, y, z, and the bits of the number (in the file) of the triangle
/// that it lies on. With any other number the answer is the same, and comes later.
pub type Start = [f32; 4];

/// The start at `origin`; `triangle` is [`MISS`](crate::frame::MISS) for a point on none.
#[must_use]
pub fn start(origin: Vec3, triangle: u32) -> Start {
    origin.extend(f32::from_bits(triangle)).to_array()
}

/// A triangle as [`OpenTriangles::see_light`] looks at it. A row for each edge: u, v, w, with u·x + v·y + w the
/// distance from the edge inward; and a coefficient of the plane z = a·x + b·y + c.
type Record = [[f32; 4]; 3];

/// No point lies above this one.
const CLOSED: Record = [[0.0; 4], [0.0; 4], [0.0, 0.0, 0.0, f32::INFINITY]];

/// How far inside the outline a point has to be: in units of ur, like the next.
const INSET: f64 = 96.0;

/// Corners on an edge are found no farther inside than this.
const TOUCHING: f32 = 32.0;

/// The same for corners of the outline and edges of others.
const BEYOND: f32 = 25.0;

/// Corners found no higher than this are not above the plane: in units of urs, like the next.
const LEVEL: f32 = 16.0;

/// How far above the plane a point has to be.
const MARGIN: f64 = 64.0;

/// The steepest slope.
const STEEPEST: f64 = 1e4;

/// When fewer than one triangle in this many is open, asking each start's costs more than it saves.
const WORTHWHILE: usize = 4;

/// Triangles that are looked at in a row.
const AT_ONCE: usize = 256;

/// What is known of every triangle of a scene.
#[derive(Debug)]
pub struct OpenTriangles {
    /// A [`Record`] for each by its number in the file, and one for any other number.
    rows: Vec<[f32; 4]>,
}

impl Default for OpenTriangles {
    /// Knows of none.
    fn default() -> OpenTriangles {
        OpenTriangles {
            rows: CLOSED.to_vec(),
        }
    }
}

impl OpenTriangles {
    /// Finds out, in parallel on the current rayon pool; the same for any number of threads and any kernel.
    pub fn find(grid: &LightGrid, world: &World) -> OpenTriangles {
        let frame = &grid.frame;
        if frame.half == 0.0 {
            return OpenTriangles::default();
        }
        let all: Vec<[f32; 4]> = world
            .corners()
            .par_iter()
            .flat_map_iter(|corners| {
                corners.map(|p| frame.centred(p).as_vec3().extend(0.0).to_array())
            })
            .collect();
        let kernel = Kernel::best();
        let find = |triangles: &[[Vec3; 3]]| -> Vec<Record> {
            let mut above = Vec::new();
            let mut record = |triangle: &[Vec3; 3]| {
                let corners = triangle.map(|p| frame.centred(p));
                let outline = Outline::new(frame, corners)?;
                let open = grid.above(&corners, &mut above)
                    && dispatch!(kernel, simd => outline.is_open(simd, &all, &above));
                open.then(|| outline.record())
            };
            triangles
                .iter()
                .map(|triangle| record(triangle).unwrap_or(CLOSED))
                .collect()
        };
        let records: Vec<Record> = world
            .corners()
            .par_chunks(AT_ONCE)
            .flat_map_iter(find)
            .collect();
        let open = records.iter().filter(|record| **record != CLOSED).count();
        if open > world.triangle_count() / WORTHWHILE {
            let mut rows = CLOSED.repeat(world.triangle_count() + 1);
            for (&id, record) in world.bvh().file_ids.iter().zip(&records) {
                let at = 3 * id as usize;
                rows[at..at + 3].copy_from_slice(record);
            }
            OpenTriangles { rows }
        } else {
            OpenTriangles::default()
        }
    }

    /// True when no triangle is known to be open.
    pub fn is_empty(&self) -> bool {
        self.rows.len() == CLOSED.len()
    }

    /// Bytes in memory.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.rows[..])
    }

    /// Which of as many starts as there are lanes certainly see the light, as bits.
    #[inline(always)]
    pub fn see_light<S: Lanes>(&self, simd: S, frame: &LightFrame, starts: &[Start]) -> u32 {
        let starts = &starts[..lanes::<S>()];
        let none = self.rows.len() / 3 - 1;
        let mut index = [[0; 16]; 3];
        for (i, start) in starts.iter().enumerate() {
            let row = 3 * (start[3].to_bits() as usize).min(none) as u32;
            for (k, index) in index.iter_mut().enumerate() {
                index[i] = row + k as u32;
            }
        }
        let [ox, oy, oz, _] = simd.gather4(starts, &LANE_NUMBERS);
        let [x, y, z, out] = frame.centred_many(simd, [ox, oy, oz]);
        let [u0, v0, w0, a] = simd.gather4(&self.rows, &index[0]);
        let [u1, v1, w1, b] = simd.gather4(&self.rows, &index[1]);
        let [u2, v2, w2, c] = simd.gather4(&self.rows, &index[2]);
        let edge = (u0 * x + (v0 * y + w0))
            .min(u1 * x + (v1 * y + w1))
            .min(u2 * x + (v2 * y + w2));
        let plane = a * x + (b * y + c);
        bits::<S>(
            edge.simd_ge(S::f32s::splat(simd, 0.0))
                & z.simd_gt(plane)
                & out.simd_le(S::f32s::splat(simd, frame.half)),
        )
    }

    /// The same where most of the starts lie on one triangle or two, whose records all lanes then share; others take
    /// longer.
    #[inline(always)]
    pub fn see_light_on_few<S: Lanes>(&self, simd: S, frame: &LightFrame, starts: &[Start]) -> u32 {
        let starts = &starts[..lanes::<S>()];
        let [ox, oy, oz, ids] = simd.gather4(starts, &LANE_NUMBERS);
        let ids = ids.bitcast::<S::u32s>();
        let [x, y, z, out] = frame.centred_many(simd, [ox, oy, oz]);
        let near = out.simd_le(S::f32s::splat(simd, frame.half));
        let (records, _) = self.rows.as_chunks::<3>();
        macro_rules! affine {
            ($u:expr, $v:expr, $w:expr) => {
                S::f32s::splat(simd, $u) * x
                    + (S::f32s::splat(simd, $v) * y + S::f32s::splat(simd, $w))
            };
        }
        let (mut seeing, mut left) = (0, all_lanes::<S>());
        for _ in 0..2 {
            let id = starts[left.trailing_zeros() as usize][3].to_bits();
            let [[u0, v0, w0, a], [u1, v1, w1, b], [u2, v2, w2, c]] =
                records[(id as usize).min(records.len() - 1)];
            let edge = affine!(u0, v0, w0)
                .min(affine!(u1, v1, w1))
                .min(affine!(u2, v2, w2));
            let sees = edge.simd_ge(S::f32s::splat(simd, 0.0)) & z.simd_gt(affine!(a, b, c)) & near;
            let same = bits::<S>(ids.simd_eq(S::u32s::splat(simd, id)));
            seeing |= bits::<S>(sees) & same;
            left &= !same;
            if left == 0 {
                return seeing;
            }
        }
        self.see_light(simd, frame, starts)
    }
}

/// The outline of a triangle, counted from the middle of the scene, and its plane.
struct Outline {
    corners: [DVec3; 3],
    /// u, v, w: the distance inward.
    edges: [DVec3; 3],
    /// a, b, c.
    plane: DVec3,
    /// ur.
    unit: f64,
    /// urs.
    height_unit: f64,
}

impl Outline {
    /// `None` for a triangle that the light sees edge-on.
    fn new(frame: &LightFrame, corners: [DVec3; 3]) -> Option<Outline> {
        let unit = f64::from(frame.half * ROUNDOFF);
        let [a, mut b, mut c] = corners;
        let mut normal = (b - a).cross(c - a);
        if normal.z < 0.0 {
            (b, c, normal) = (c, b, -normal);
        }
        let [slope_x, slope_y] = [-normal.x / normal.z, -normal.y / normal.z];
        let steep = slope_x.abs() + slope_y.abs();
        if !(normal.z > 0.0 && steep <= STEEPEST) {
            return None;
        }
        let edges = [(a, b), (b, c), (c, a)].map(|(p, q)| {
            let inward = (q - p).xy().perp().normalize();
            inward.extend(-inward.dot(p.xy()))
        });
        Some(Outline {
            corners,
            edges,
            plane: DVec3::new(slope_x, slope_y, a.z - slope_x * a.x - slope_y * a.y),
            unit,
            height_unit: unit * (1.0 + steep),
        })
    }

    fn record(&self) -> Record {
        let plane = self.plane + DVec3::new(0.0, 0.0, MARGIN * self.height_unit);
        let inset = DVec3::new(0.0, 0.0, INSET * self.unit);
        let row = |k: usize| (self.edges[k] - inset).extend(plane[k]);
        [0, 1, 2].map(|k| row(k).as_vec4().to_array())
    }

    /// Whether none of the triangles `ids` (in leaf order) rises above the plane inside of the outline, by the
    /// corners of all triangles. It may be that none does and the answer is no.
    #[inline(always)]
    fn is_open<S: Lanes>(&self, simd: S, corners: &[[f32; 4]], ids: &[u32]) -> bool {
        macro_rules! splat {
            ($x:expr) => {
                S::f32s::splat(simd, $x as f32)
            };
        }
        macro_rules! affine {
            ($row:expr, $p:expr) => {
                splat!($row.x) * $p[0] + (splat!($row.y) * $p[1] + splat!($row.z))
            };
        }
        let touching = splat!(TOUCHING * self.unit as f32);
        let level = splat!(LEVEL * self.height_unit as f32);
        ids.chunks(lanes::<S>()).all(|ids| {
            let mut index = [[0; 16]; 3];
            for lane in 0..lanes::<S>() {
                let first = 3 * ids[lane.min(ids.len() - 1)];
                for (k, index) in index.iter_mut().enumerate() {
                    index[lane] = first + k as u32;
                }
            }
            let p = [
                simd.gather4(corners, &index[0]),
                simd.gather4(corners, &index[1]),
                simd.gather4(corners, &index[2]),
            ];
            let rise = (p[0][2] - affine!(self.plane, p[0]))
                .max(p[1][2] - affine!(self.plane, p[1]))
                .max(p[2][2] - affine!(self.plane, p[2]));
            let mut fine = rise.simd_le(level);
            for edge in &self.edges {
                let inside = affine!(edge, p[0])
                    .max(affine!(edge, p[1]))
                    .max(affine!(edge, p[2]));
                fine |= inside.simd_le(touching);
            }
            bits::<S>(fine) == all_lanes::<S>()
                || bits::<S>(fine | self.is_beyond(simd, &p)) == all_lanes::<S>()
        })
    }

    /// Whether the outline lies on the outer side of one of the edges of triangles with corners `p`.
    #[inline(always)]
    fn is_beyond<S: Lanes>(&self, simd: S, p: &[[S::f32s; 4]; 3]) -> S::mask32s {
        macro_rules! splat {
            ($x:expr) => {
                S::f32s::splat(simd, $x as f32)
            };
        }
        macro_rules! cross {
            ($d:expr, $e:expr) => {
                $d[0] * $e[1] - $d[1] * $e[0]
            };
        }
        macro_rules! edge {
            ($from:expr, $to:expr) => {
                [p[$to][0] - p[$from][0], p[$to][1] - p[$from][1]]
            };
        }
        let zero = splat!(0.0);
        let unit = self.unit as f32;
        let edges = [edge!(0, 1), edge!(1, 2), edge!(2, 0)];
        let area = cross!(edges[2], edges[0]);
        let size = edges[0][0].abs() + edges[0][1].abs() + (edges[2][0].abs() + edges[2][1].abs());
        let sure = area.abs().simd_gt(splat!(16.0 * unit) * size);
        let turned = area.simd_gt(zero);
        let mut beyond = area.simd_lt(area);
        for k in 0..3 {
            let d = edges[k];
            let reach = splat!(BEYOND * unit) * d[0].abs().max(d[1].abs());
            let mut all_out = sure;
            for corner in &self.corners {
                let e = [splat!(corner.x) - p[k][0], splat!(corner.y) - p[k][1]];
                let inward = cross!(d, e);
                let inward = turned.select(inward, zero - inward);
                let doubt = splat!(6.0 * unit) * (e[0].abs() + e[1].abs());
                all_out &= inward.simd_le(reach - doubt);
            }
            beyond |= all_out;
        }
        beyond
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;
    use crate::scene::{CameraSetting, Scene, Triangle};

    /// With the light shining along −z.
    fn grid(triangles: &[[[f32; 3]; 3]]) -> LightGrid {
        let triangle = |corners: &[[f32; 3]; 3]| Triangle {
            corners: corners.map(Vec3::from),
            color: Rgb::new(1, 2, 3),
        };
        let scene = Scene {
            camera: CameraSetting::Default,
            light: Vec3::NEG_Z,
            triangles: triangles.iter().map(triangle).collect(),
            operations: Vec::new(),
        };
        LightGrid::build(&World::compile(&scene))
    }

    /// Which triangles are open.
    fn open(triangles: &[[[f32; 3]; 3]]) -> Vec<bool> {
        let grid = grid(triangles);
        let records: Vec<_> = grid.open.rows.chunks(3).collect();
        let is_open = |i: usize| records[i.min(records.len() - 1)] != CLOSED;
        assert!(!is_open(usize::MAX), "the record for no triangle");
        (0..triangles.len()).map(is_open).collect()
    }

    #[test]
    fn both_sides_of_a_ridge_and_of_a_valley_are_open() {
        for height in [1.0, -1.0, 0.0, 30.0] {
            let (a, b) = ([0.0, -1.0, height], [0.0, 1.0, height]);
            assert_eq!(
                open(&[[a, b, [-1.0, 0.0, 0.0]], [b, a, [1.0, 0.0, 0.0]]]),
                [true; 2]
            );
        }
    }

    #[test]
    fn triangles_around_a_corner_are_open() {
        let ring = [
            [2.0, 0.0, 1.0],
            [0.5, 2.0, 0.0],
            [-2.0, 1.0, 2.0],
            [-1.0, -2.0, 0.3],
        ];
        let fan = [0, 1, 2, 3].map(|i| [[0.1, 0.1, 0.0], ring[i], ring[(i + 1) % 4]]);
        assert_eq!(open(&fan), [true; 4]);
    }

    #[test]
    fn what_lies_below_another_triangle_is_closed() {
        let low = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 1.0]];
        let over = |x: f32, z: f32| [[x, 1.0, z], [x + 1.0, 1.0, z], [x, 2.0, z]];
        assert_eq!(open(&[low, over(1.0, 2.0)]), [false, true]);
        assert_eq!(open(&[low, over(-3.0, 2.0)]), [true; 2]);
        // Pierced by it.
        assert_eq!(open(&[low, over(1.0, 0.3)]), [false; 2]);
        assert_eq!(open(&[low, over(1.0, -2.0)]), [true, false]);
    }

    #[test]
    fn what_the_light_sees_edge_on_is_closed() {
        let wall = [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.5, 0.5, 1.0]];
        assert_eq!(open(&[wall]), [false]);
    }

    #[test]
    fn starts_on_few_triangles_see_what_they_see_one_by_one() {
        let roof = |x: f32, z: f32| [[x, 0.0, z], [x + 1.0, 0.0, z], [x, 2.0, z + 0.5]];
        let triangles = [
            roof(0.0, 1.0),
            roof(1.5, 0.0),
            roof(3.0, 2.0),
            roof(3.2, 3.0),
        ];
        let grid = grid(&triangles);
        // On one triangle, on two, on three; some beside it, and some that are on none.
        let ids = |i: u32, many: u32| {
            [[0, 0, 0], [1, 0, 1], [2, 1, u32::MAX]][many as usize][i as usize % 3]
        };
        for (kernel, many) in Kernel::available()
            .into_iter()
            .flat_map(|k| [(k, 0), (k, 1), (k, 2)])
        {
            let mut all = 0;
            for shift in 0..40_u32 {
                let starts: Vec<Start> = (0..16)
                    .map(|i| {
                        let id = ids((i + shift) / 5, many);
                        let [a, b, c] = triangles[(id as usize).min(3)].map(Vec3::from);
                        let (s, t) = (i as f32 / 13.0 - 0.1, shift as f32 / 50.0);
                        start(
                            a + (b - a) * s + (c - a) * t + Vec3::new(0.0, 0.0, 1e-4),
                            id,
                        )
                    })
                    .collect();
                let (few, each) = dispatch!(kernel, simd => (
                    grid.open.see_light_on_few(simd, &grid.frame, &starts),
                    grid.open.see_light(simd, &grid.frame, &starts)
                ));
                assert_eq!(few, each, "{kernel:?} {many} {shift}");
                all |= each;
            }
            assert_ne!(all, 0, "none sees the light");
        }
    }
}
