//! From the binary tree to 8-wide nodes and leaves of lines.
//!
//! The top of the tree is collapsed first and leaves off at subtrees of moderate size; these are collapsed in
//! parallel, each with indices of its own, then laid end to end. Where a subtree starts depends on the tree alone.

use glam::Vec3;
use rayon::prelude::*;

use super::Bvh;
use super::build::{BinaryNode, Tree};
use super::node::{Child, Leaf, Line, MAX_LEAF, Node, WIDTH};
use crate::geometry::Aabb;
use crate::scene::Triangle;

/// Subtrees of at most this many triangles are collapsed as one piece.
const PIECE: usize = 1 << 13;

/// Part of the result, with indices of its own.
#[derive(Default)]
struct Piece {
    nodes: Vec<Node>,
    lines: Vec<Line>,
    file_ids: Vec<u32>,
}

/// A place in the top of the tree where the root of a piece belongs.
struct Hole {
    /// Index in the binary tree.
    at: usize,
    node: usize,
    slot: usize,
}

pub(super) fn collapse(triangles: &[Triangle], tree: Tree) -> Bvh {
    if tree.refs.is_empty() {
        return Bvh {
            nodes: Vec::new(),
            lines: Vec::new(),
            file_ids: Vec::new(),
            bounds: tree.bounds,
        };
    }
    let diagonal = (tree.bounds.max.as_dvec3() - tree.bounds.min.as_dvec3()).length();
    let collapser = Collapser {
        triangles,
        tree: &tree,
        // Culling has to be conservative, not tight.
        padding: (diagonal * (1.0 / f64::from(1 << 20))) as f32,
    };
    let mut top = Piece::default();
    let mut holes = Vec::new();
    top.nodes.push(Node::EMPTY);
    collapser.top(&mut top, &mut holes, 0, 0);
    let pieces: Vec<(Piece, Child)> = holes
        .par_iter()
        .map(|hole| {
            let mut piece = Piece::default();
            let root = collapser.child(&mut piece, hole.at);
            (piece, root)
        })
        .collect();
    join(top, &holes, pieces, tree.bounds)
}

/// Lays the pieces behind the top, in the order of their holes.
fn join(mut top: Piece, holes: &[Hole], pieces: Vec<(Piece, Child)>, bounds: Aabb) -> Bvh {
    let sum = |count: fn(&Piece) -> usize| pieces.iter().map(|(p, _)| count(p)).sum::<usize>();
    top.nodes.reserve_exact(sum(|p| p.nodes.len()));
    top.lines.reserve_exact(sum(|p| p.lines.len()));
    top.file_ids.reserve_exact(sum(|p| p.file_ids.len()));
    for (hole, (piece, root)) in holes.iter().zip(pieces) {
        let (nodes, lines, ids) = (top.nodes.len(), top.lines.len(), top.file_ids.len());
        top.nodes[hole.node].children[hole.slot] = root.moved(nodes, lines);
        top.nodes.extend(piece.nodes.into_iter().map(|mut node| {
            node.children = node.children.map(|c| c.moved(nodes, lines));
            node
        }));
        let start = top.lines.len();
        top.lines.extend(piece.lines);
        renumber(&mut top.lines[start..], ids as u32);
        top.file_ids.extend(piece.file_ids);
    }
    Bvh {
        nodes: top.nodes,
        lines: top.lines,
        file_ids: top.file_ids,
        bounds,
    }
}

/// Adds `ids` to the first number of every leaf in `lines`.
fn renumber(lines: &mut [Line], ids: u32) {
    let mut at = 0;
    while at < lines.len() {
        let count = Leaf::new(&lines[at..]).line_count();
        lines[at].0[12] += ids;
        at += count;
    }
}

struct Collapser<'a> {
    triangles: &'a [Triangle],
    tree: &'a Tree,
    padding: f32,
}

impl Collapser<'_> {
    fn node(&self, at: usize) -> &BinaryNode {
        &self.tree.nodes[at]
    }

    /// Up to 8 nodes that together hold what `at` holds: opens the child with the largest box again and again.
    fn open(&self, at: usize) -> Vec<usize> {
        if self.node(at).is_leaf {
            return vec![at];
        }
        let halves = |at: usize| [at + 1, at + self.node(at).first_or_right as usize];
        let mut children = Vec::with_capacity(WIDTH);
        children.extend(halves(at));
        while children.len() < WIDTH {
            let largest = children
                .iter()
                .enumerate()
                .filter(|&(_, &c)| !self.node(c).is_leaf)
                // The first of equals, so that the order is that of the tree.
                .rev()
                .max_by(|a, b| self.area(*a.1).total_cmp(&self.area(*b.1)))
                .map(|(i, _)| i);
            let Some(i) = largest else { break };
            let [left, right] = halves(children[i]);
            children[i] = left;
            children.insert(i + 1, right);
        }
        children
    }

    fn area(&self, at: usize) -> f64 {
        let b = &self.node(at).bounds;
        let d = b.max.as_dvec3() - b.min.as_dvec3();
        d.x * d.y + d.y * d.z + d.z * d.x
    }

    fn set_bounds(&self, node: &mut Node, slot: usize, bounds: &Aabb) {
        let padding = Vec3::splat(self.padding);
        // Infinite bounds would turn into NaN in the kernels.
        let finite = |p: Vec3| p.clamp(Vec3::MIN, Vec3::MAX);
        let (min, max) = (finite(bounds.min - padding), finite(bounds.max + padding));
        for axis in 0..3 {
            node.bounds[axis][slot] = min[axis];
            node.bounds[axis + 3][slot] = max[axis];
        }
    }

    /// Fills node `me` of the top from binary node `at`; small subtrees become holes.
    fn top(&self, out: &mut Piece, holes: &mut Vec<Hole>, at: usize, me: usize) {
        for (slot, child) in self.open(at).into_iter().enumerate() {
            let below = self.node(child);
            self.set_bounds(&mut out.nodes[me], slot, &below.bounds);
            if below.count as usize <= PIECE {
                holes.push(Hole {
                    at: child,
                    node: me,
                    slot,
                });
            } else {
                let node = out.nodes.len();
                out.nodes.push(Node::EMPTY);
                out.nodes[me].children[slot] = Child::node(node);
                self.top(out, holes, child, node);
            }
        }
    }

    /// Writes everything below binary node `at` to `out`; its child word, with indices that count from there.
    fn child(&self, out: &mut Piece, at: usize) -> Child {
        let binary = self.node(at);
        if binary.is_leaf {
            let refs = &self.tree.refs[binary.first_or_right as usize..][..binary.count as usize];
            let mut corners = [[Vec3::ZERO; 3]; MAX_LEAF];
            let first_id = out.file_ids.len() as u32;
            for (corners, r) in corners.iter_mut().zip(refs) {
                *corners = self.triangles[r.id() as usize].corners;
                out.file_ids.push(r.id());
            }
            return Leaf::write(&corners[..refs.len()], first_id, &mut out.lines);
        }
        let me = out.nodes.len();
        out.nodes.push(Node::EMPTY);
        for (slot, child) in self.open(at).into_iter().enumerate() {
            self.set_bounds(&mut out.nodes[me], slot, &self.node(child).bounds);
            let word = self.child(out, child);
            out.nodes[me].children[slot] = word;
        }
        Child::node(me)
    }
}
