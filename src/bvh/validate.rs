//! Checks of a whole tree against the triangles that it was built from.

use std::collections::HashMap;

use glam::Vec3;

use super::node::{Child, WIDTH};
use super::{Bvh, MAX_LEAF};
use crate::geometry::{Aabb, is_degenerate};
use crate::scene::Triangle;

/// What is wrong with a tree.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Invalid(pub String);

impl Bvh {
    /// Checks that every triangle with an area is in exactly one leaf, with the very bits of its corners, or else is
    /// counted as a copy of one with a lower number that is; that every box holds what is below it, and that every
    /// node and line is used once. O(triangles).
    ///
    /// # Errors
    /// The first thing found wrong.
    pub fn validate(&self, triangles: &[Triangle]) -> Result<(), Invalid> {
        let mut check = Check {
            bvh: self,
            triangles,
            seen: vec![false; triangles.len()],
            nodes: 0,
            lines: 0,
        };
        if !self.nodes.is_empty() {
            check.node(0)?;
        }
        ensure(check.nodes == self.nodes.len(), || "unused nodes".into())?;
        ensure(check.lines == self.lines.len(), || "unused lines".into())?;
        let solid = |&id: &usize| !is_degenerate(&triangles[id].corners);
        let (inside, outside): (Vec<usize>, Vec<usize>) = (0..triangles.len())
            .filter(solid)
            .partition(|&id| check.seen[id]);
        ensure(self.file_ids.len() == inside.len(), || {
            format!("{} triangles for {}", self.file_ids.len(), inside.len())
        })?;
        ensure(self.copies == outside.len(), || {
            format!("{} copies are counted, not {}", outside.len(), self.copies)
        })?;
        if !outside.is_empty() {
            let lowest: HashMap<_, _> = inside
                .into_iter()
                .rev()
                .map(|id| (bits(triangles[id].corners), id))
                .collect();
            for id in outside {
                let original = lowest.get(&bits(triangles[id].corners));
                ensure(original.is_some_and(|&original| original < id), || {
                    format!("triangle {id} is in no leaf")
                })?;
            }
        }
        Ok(())
    }
}

fn bits(corners: [Vec3; 3]) -> [[u32; 3]; 3] {
    corners.map(|p| p.to_array().map(f32::to_bits))
}

fn ensure(holds: bool, what: impl FnOnce() -> String) -> Result<(), Invalid> {
    if holds { Ok(()) } else { Err(Invalid(what())) }
}

struct Check<'a> {
    bvh: &'a Bvh,
    triangles: &'a [Triangle],
    seen: Vec<bool>,
    nodes: usize,
    lines: usize,
}

impl Check<'_> {
    /// Checks everything below a node; the box of its triangles.
    fn node(&mut self, index: usize) -> Result<Aabb, Invalid> {
        self.nodes += 1;
        let node = *self
            .bvh
            .nodes
            .get(index)
            .ok_or_else(|| Invalid(format!("no node {index}")))?;
        let mut all = Aabb::EMPTY;
        for slot in 0..WIDTH {
            let child = node.children[slot];
            let row =
                |first: usize| Vec3::from([0, 1, 2].map(|axis| node.bounds[first + axis][slot]));
            let stated = Aabb {
                min: row(0),
                max: row(3),
            };
            let real = if child == Child::NONE {
                ensure(stated.is_empty(), || {
                    format!("node {index}: nothing in a box")
                })?;
                continue;
            } else if child.is_leaf() {
                self.leaf(child)?
            } else {
                self.node(child.index())?
            };
            ensure(stated.contains(real), || {
                format!("node {index}, child {slot}: {stated:?} does not hold {real:?}")
            })?;
            all = all.join(real);
        }
        ensure(!all.is_empty(), || format!("node {index} is empty"))?;
        Ok(all)
    }

    fn leaf(&mut self, child: Child) -> Result<Aabb, Invalid> {
        let leaf = self.bvh.leaf(child.index());
        self.lines += leaf.line_count();
        let name = child.index();
        ensure((1..=MAX_LEAF).contains(&leaf.count()), || {
            format!("leaf {name} has {} triangles", leaf.count())
        })?;
        ensure(leaf.line_count() == 1 + 3 * child.chunks(), || {
            format!("leaf {name} and its parent differ in length")
        })?;
        let mut all = Aabb::EMPTY;
        for i in 0..leaf.count() {
            let id = self.bvh.file_ids[leaf.first_id() as usize + i];
            let seen = &mut self.seen[id as usize];
            ensure(!*seen, || format!("triangle {id} is in two leaves"))?;
            *seen = true;
            let corners = leaf.corners(i);
            ensure(
                bits(corners) == bits(self.triangles[id as usize].corners),
                || format!("triangle {id} has other corners"),
            )?;
            all = corners.into_iter().fold(all, Aabb::with);
        }
        Ok(all)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;
    use crate::math::Random;

    fn triangle(corners: [Vec3; 3]) -> Triangle {
        Triangle {
            corners,
            color: Rgb::BLACK,
        }
    }

    fn soup(n: usize, size: f32, scale: f32) -> Vec<Triangle> {
        let mut r = Random::new(n as u64);
        (0..n)
            .map(|_| {
                let p = r.point();
                triangle([p, p + r.point() * size, p + r.point() * size].map(|p| p * scale))
            })
            .collect()
    }

    fn nested(i: usize) -> Triangle {
        triangle([Vec3::NEG_ONE, Vec3::ONE, Vec3::new(-1.0, 1.0, -1.0)].map(|p| p * i as f32))
    }

    fn needles(n: usize) -> Vec<Triangle> {
        let mut r = Random::new(9);
        let needle = |_| {
            let (p, q) = (r.point(), r.point());
            triangle([p, p + q * 100.0, p + q * 100.0 + r.point() * 1e-4])
        };
        (0..n).map(needle).collect()
    }

    /// A model of 20,000 triangles in one cell of the grid over a few huge ones, and a smaller one in a cell of its.
    fn tiny_among_huge() -> Vec<Triangle> {
        let mut all: Vec<Triangle> = soup(20, 2.0, 1e6);
        all.extend(soup(20_000, 0.05, 1.0));
        all.extend(soup(5000, 0.05, 1e-6));
        all
    }

    /// Middles at every power of two: whatever is cut off, half of the rest lies in one bin.
    fn powers() -> Vec<Triangle> {
        let at = |i: i32| {
            let mut p = Vec3::ZERO;
            let size = 2f32.powi(i / 3 - 120);
            p[i as usize % 3] = size;
            triangle([p, p + Vec3::X * size * 0.01, p + Vec3::Y * size * 0.01])
        };
        (0..12_000).map(|i| at(i % 720)).collect()
    }

    fn hard_input() -> Vec<(&'static str, Vec<Triangle>)> {
        let one = triangle([Vec3::ZERO, Vec3::X, Vec3::Y]);
        let flat = |i: usize| {
            triangle([Vec3::X, Vec3::Y, Vec3::ONE].map(|p| p * i as f32 * Vec3::new(1.0, 1.0, 0.0)))
        };
        let octaves = (-60..60).map(|e| {
            let s = 2f32.powi(e);
            triangle([
                Vec3::splat(s),
                Vec3::splat(s) + Vec3::X * s * 0.1,
                Vec3::splat(s) + Vec3::Y * s * 0.1,
            ])
        });
        vec![
            ("nothing", vec![]),
            ("one", vec![one]),
            ("no area", vec![triangle([Vec3::ZERO; 3]); 5]),
            ("equal", vec![one; 1000]),
            ("flat", (0..500).map(flat).collect()),
            ("octaves", octaves.collect()),
            ("soup", soup(20_000, 0.05, 1.0)),
            ("tiny", soup(3000, 0.05, 1e-30)),
            ("huge", soup(3000, 0.05, 1e30)),
            ("largest", soup(3000, 0.05, 1e38)),
            ("overlapping", soup(3000, 2.0, 1.0)),
            ("equal middles", (1..3000).map(nested).collect()),
            ("needles", needles(3000)),
            ("tiny among huge", tiny_among_huge()),
            ("powers", powers()),
            ("many equal", vec![one; 100_000]),
        ]
    }

    type Builder = fn(&[Triangle]) -> Bvh;
    const BUILDERS: [(&str, Builder); 2] = [("fine", Bvh::build), ("coarse", Bvh::build_coarse)];

    #[test]
    fn trees_over_hard_input_are_valid_and_shallow() {
        for (name, triangles) in hard_input() {
            for (builder, build) in BUILDERS {
                let bvh = build(&triangles);
                assert_eq!(bvh.validate(&triangles), Ok(()), "{name}, {builder}");
                let stats = bvh.stats();
                assert!(stats.sah_cost.is_finite(), "{name}, {builder}");
                assert!(
                    stats.depth <= 64,
                    "{name}, {builder}: {} nodes deep",
                    stats.depth
                );
            }
        }
    }

    #[test]
    fn the_same_tree_for_any_number_of_threads() {
        let mut triangles = soup(60_000, 0.02, 1.0);
        triangles.extend(tiny_among_huge());
        for (name, builder) in BUILDERS {
            let build = |threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
                pool.expect("threads").install(|| builder(&triangles))
            };
            let one = build(1);
            assert_eq!(one.validate(&triangles), Ok(()), "{name}");
            for threads in [2, 3, 7] {
                let other = build(threads);
                assert_eq!(*one.file_ids, *other.file_ids, "{name}, {threads} threads");
                assert_eq!(*one.lines, *other.lines, "{name}, {threads} threads");
                let bits = |b: &Bvh| -> Vec<_> {
                    let bounds = |n: &super::super::Node| n.bounds.map(|r| r.map(f32::to_bits));
                    b.nodes.iter().map(|n| (bounds(n), n.children)).collect()
                };
                assert_eq!(bits(&one), bits(&other), "{name}, {threads} threads");
            }
        }
    }

    #[test]
    fn clusters_keep_a_model_in_a_huge_scene_apart() {
        // The same model alone and in one cell of the grid: its own part of the tree is about as good.
        let model = soup(20_000, 0.05, 1.0);
        let alone = Bvh::build(&model).stats();
        let among = Bvh::build(&tiny_among_huge()[..20_020]).stats();
        assert!(
            among.leaves * 10 < alone.leaves * 11,
            "{} and {} leaves",
            among.leaves,
            alone.leaves
        );
    }

    #[test]
    fn a_crowded_cell_of_a_small_scene_becomes_as_good_a_part_as_alone() {
        for few in [100, 3000] {
            let wide = soup(few, 2.0, 1e6);
            for crowd in [64, 65, 300, 1023, 1024, 1025] {
                let model = soup(crowd, 0.05, 1.0);
                let all = [&wide[..], &model].concat();
                for (builder, build) in BUILDERS {
                    let valid = build(&all).validate(&all);
                    assert_eq!(valid, Ok(()), "{crowd} among {few}, {builder}");
                }
                let leaves = |triangles: &[Triangle]| Bvh::build(triangles).stats().leaves;
                let (together, apart) = (leaves(&all), leaves(&wide) + leaves(&model));
                assert!(
                    together * 10 <= apart * 11 + 20,
                    "{crowd} among {few}: {together} leaves, apart {apart}"
                );
            }
        }
    }

    #[test]
    fn validate_notices_a_wrong_box_and_a_wrong_corner() {
        let triangles = soup(100, 0.1, 1.0);
        let mut bvh = Bvh::build(&triangles);
        bvh.nodes[0].bounds[3][0] = bvh.nodes[0].bounds[0][0];
        assert!(bvh.validate(&triangles).is_err());
        let mut bvh = Bvh::build(&triangles);
        bvh.lines[1].0[0] ^= 1;
        assert!(bvh.validate(&triangles).is_err());
    }
}
