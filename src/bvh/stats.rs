//! Facts about a tree, for `info`, the overlay and comparisons between builders.

use super::node::{Child, Node};
use super::{Bvh, Line};

/// Facts about a tree.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BvhStats {
    /// Expected cost of a random ray that meets the scene's box, in triangle tests; a node counts as 1.
    pub sah_cost: f64,
    /// Interior nodes.
    pub nodes: usize,
    /// Leaves.
    pub leaves: usize,
    /// Interior nodes on the longest way down.
    pub depth: usize,
    /// Bytes of nodes, leaves and triangle numbers.
    pub bytes: usize,
}

impl Bvh {
    /// Facts about this tree. O(nodes).
    #[must_use]
    pub fn stats(&self) -> BvhStats {
        let mut stats = BvhStats {
            nodes: self.nodes.len(),
            bytes: size_of_val(&self.nodes[..])
                + self.lines.len() * size_of::<Line>()
                + size_of_val(&self.file_ids[..]),
            ..BvhStats::default()
        };
        if !self.nodes.is_empty() {
            let whole = half_area_of(self.bounds.min.as_dvec3(), self.bounds.max.as_dvec3());
            stats.sah_cost = 1.0;
            self.add_below(0, 1, whole, &mut stats);
        }
        stats
    }

    fn add_below(&self, node: usize, depth: usize, whole: f64, stats: &mut BvhStats) {
        stats.depth = stats.depth.max(depth);
        let node = &self.nodes[node];
        for (i, &child) in node.children.iter().enumerate() {
            if child == Child::NONE {
                continue;
            }
            let chance = if whole > 0.0 {
                half_area(node, i) / whole
            } else {
                1.0
            };
            if child.is_leaf() {
                stats.leaves += 1;
                stats.sah_cost += chance * self.leaf(child.index()).count() as f64;
            } else {
                stats.sah_cost += chance;
                self.add_below(child.index(), depth + 1, whole, stats);
            }
        }
    }
}

fn half_area(node: &Node, slot: usize) -> f64 {
    let at = |first: usize| [0, 1, 2].map(|axis| f64::from(node.bounds[first + axis][slot]));
    half_area_of(at(0).into(), at(3).into())
}

fn half_area_of(min: glam::DVec3, max: glam::DVec3) -> f64 {
    let d = (max - min).max(glam::DVec3::ZERO);
    d.x * d.y + d.y * d.z + d.z * d.x
}
