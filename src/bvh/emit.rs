//! From parts of the tree, built one by one, to the whole.
//!
//! The top of a tree is a skeleton whose ends are parts. Parts that follow each other are written as one piece, with
//! indices of its own; then all pieces are laid end to end behind the nodes of the top. What a piece holds, and where
//! it starts, depends on the skeleton alone: the threads never decide a byte.

use rayon::prelude::*;

use super::node::{Child, Line, Node};
use super::pack::Packer;
use super::prim::Prim;
use super::{Bvh, PartRecords};
use crate::geometry::Aabb;
use crate::raw::large_pages;
use crate::scene::Triangle;
use crate::simd::Simd;

/// Pieces have about so many triangles: what is read and written for them stays in the second-level cache.
const PIECE: usize = 1 << 10;
/// Pieces that are written before they are laid end to end.
const PIECES_A_THREAD: usize = 16;

/// The top of a tree over parts.
pub(super) enum Top<T> {
    Node(Vec<Top<T>>),
    Part(T),
}

impl<T> Top<T> {
    /// The skeleton without its parts; those in their order.
    fn take_parts(self, parts: &mut Vec<T>) -> Top<()> {
        match self {
            Top::Node(children) => Top::Node(
                children
                    .into_iter()
                    .map(|child| child.take_parts(parts))
                    .collect(),
            ),
            Top::Part(part) => {
                parts.push(part);
                Top::Part(())
            }
        }
    }

    fn node_count(&self) -> usize {
        match self {
            Top::Node(children) => 1 + children.iter().map(Top::node_count).sum::<usize>(),
            Top::Part(_) => 0,
        }
    }
}

/// A node or leaf that is written, and the box of its triangles.
#[derive(Clone, Copy)]
pub(super) struct Branch {
    child: Child,
    pub(super) bounds: Prim,
}

/// Nodes and leaves of some parts, with indices of their own.
pub(super) struct Piece<'a> {
    triangles: &'a [Triangle],
    /// Culling has to be conservative, not tight.
    padding: f32,
    nodes: Vec<Node>,
    lines: Vec<Line>,
    file_ids: Vec<u32>,
    /// Triangles in leaf order before those of this piece.
    first_id: u32,
    /// One for each part.
    roots: Vec<Branch>,
    packer: Packer,
}

impl Piece<'_> {
    /// Adds the root of a part that is complete.
    pub(super) fn finish_part(&mut self, root: Branch) {
        self.roots.push(root);
    }

    /// Writes a leaf of the triangles `numbers`, 1 to 16, with `bounds` around them.
    #[inline(always)]
    pub(super) fn leaf<S: Simd>(&mut self, simd: S, numbers: &[u32], bounds: Prim) -> Branch {
        let first = self.first_id + self.file_ids.len() as u32;
        self.file_ids.extend_from_slice(numbers);
        let (packer, lines) = (&mut self.packer, &mut self.lines);
        Branch {
            child: packer.leaf(simd, self.triangles, numbers, first, lines),
            bounds,
        }
    }

    /// A place for a node; what is below it comes behind.
    pub(super) fn reserve_node(&mut self) -> usize {
        self.nodes.push(Node::EMPTY);
        self.nodes.len() - 1
    }

    /// Makes `branch` child `slot` of node `node`.
    #[inline(always)]
    pub(super) fn set_child(&mut self, node: usize, slot: usize, branch: &Branch) {
        set_child(&mut self.nodes[node], slot, branch, self.padding);
    }

    /// Shifts all indices.
    fn move_behind(&mut self, nodes: usize, lines: usize) {
        let children = self.nodes.iter_mut().flat_map(|n| &mut n.children);
        for child in children.chain(self.roots.iter_mut().map(|r| &mut r.child)) {
            *child = child.moved(nodes, lines);
        }
    }

    /// The node that is complete, as a branch of its own.
    pub(super) fn branch(node: usize, bounds: Prim) -> Branch {
        Branch {
            child: Child::node(node),
            bounds,
        }
    }
}

#[inline(always)]
fn set_child(node: &mut Node, slot: usize, branch: &Branch, padding: f32) {
    let bounds = branch.bounds.aabb();
    // Infinite bounds would turn into NaN in the kernels.
    let finite = |x: f32| x.clamp(f32::MIN, f32::MAX);
    for axis in 0..3 {
        node.bounds[axis][slot] = finite(bounds.min[axis] - padding);
        node.bounds[axis + 3][slot] = finite(bounds.max[axis] + padding);
    }
    node.children[slot] = branch.child;
}

/// Writes the tree of a skeleton, none of whose parts is empty. `size`: triangles of a part; `write` writes some
/// parts; `records`: see [`Bvh::build_with`]. `bounds`: the box of everything.
///
/// As many pieces as keep the threads busy are written, laid end to end and their memory used again: it is warm, and
/// the system need not clear it.
pub(super) fn assemble<T: Send + Sync, R: Copy + Send + Sync>(
    triangles: &[Triangle],
    bounds: Aabb,
    top: Top<T>,
    size: impl Fn(&T) -> usize,
    write: impl Fn(&mut Piece, &[T]) + Sync,
    records: &PartRecords<R>,
) -> (Bvh, Vec<R>) {
    let diagonal = (bounds.max.as_dvec3() - bounds.min.as_dvec3()).length();
    let padding = (diagonal * (1.0 / f64::from(1 << 20))) as f32;
    let mut parts = Vec::new();
    let top = top.take_parts(&mut parts);
    // The root is a node: a lone part gets one above it.
    let top_count = top.node_count().max(1);
    let mut whole = Whole {
        total: parts.iter().map(&size).sum(),
        nodes: vec![Node::EMPTY; top_count],
        lines: Vec::new(),
        file_ids: Vec::new(),
        records: Vec::new(),
        roots: Vec::with_capacity(parts.len()),
    };
    let empty = || {
        let piece = Piece {
            triangles,
            padding,
            nodes: Vec::with_capacity(PIECE / 16),
            lines: Vec::with_capacity(PIECE),
            file_ids: Vec::with_capacity(2 * PIECE),
            first_id: 0,
            roots: Vec::new(),
            packer: Packer::new(),
        };
        (piece, Vec::with_capacity(2 * PIECE))
    };
    let at_once = PIECES_A_THREAD * rayon::current_num_threads();
    let mut pieces = Vec::new();
    let mut first_id = 0;
    for groups in group(&parts, &size).chunks(at_once) {
        pieces.resize_with(groups.len(), empty);
        for ((piece, _), parts) in pieces.iter_mut().zip(groups) {
            piece.first_id = first_id as u32;
            first_id += parts.iter().map(&size).sum::<usize>();
        }
        pieces
            .par_iter_mut()
            .zip(groups)
            .for_each(|((piece, of_piece), parts)| {
                write(piece, parts);
                records(&piece.file_ids, of_piece);
            });
        whole.append(&mut pieces);
    }
    let mut next = (0, whole.roots.iter());
    let root = place_top(&top, &mut whole.nodes, &mut next, padding);
    if let Top::Part(()) = top {
        set_child(&mut whole.nodes[0], 0, &root, padding);
    }
    let bvh = Bvh {
        nodes: whole.nodes,
        lines: whole.lines,
        file_ids: whole.file_ids,
        bounds,
        copies: 0,
    };
    (bvh, whole.records)
}

/// The tree as far as it is written: the top's nodes, still empty, and pieces behind them.
struct Whole<R> {
    /// Triangles that there will be.
    total: usize,
    nodes: Vec<Node>,
    lines: Vec<Line>,
    file_ids: Vec<u32>,
    records: Vec<R>,
    /// One for each part.
    roots: Vec<Branch>,
}

impl<R: Copy + Send + Sync> Whole<R> {
    /// Moves what is in `pieces` behind everything.
    fn append(&mut self, pieces: &mut [(Piece, Vec<R>)]) {
        let (mut nodes, mut lines) = (self.nodes.len(), self.lines.len());
        for (piece, _) in &mut *pieces {
            piece.move_behind(nodes, lines);
            nodes += piece.nodes.len();
            lines += piece.lines.len();
        }
        let all = &*pieces;
        let written: usize = all.iter().map(|(piece, _)| piece.file_ids.len()).sum();
        let share = (self.file_ids.len() + written) as f64 / self.total as f64;
        rayon::join(
            || append(&mut self.lines, all, share, |(piece, _)| &piece.lines),
            || {
                append(&mut self.nodes, all, share, |(piece, _)| &piece.nodes);
                append(&mut self.file_ids, all, share, |(piece, _)| &piece.file_ids);
                append(&mut self.records, all, share, |(_, records)| records);
                append(&mut self.roots, all, share, |(piece, _)| &piece.roots);
            },
        );
        for (piece, records) in pieces {
            piece.nodes.clear();
            piece.lines.clear();
            piece.file_ids.clear();
            piece.roots.clear();
            records.clear();
        }
    }
}

/// One column of all pieces, behind what is there; then `share` of the tree is there.
///
/// When there is no room, makes it for all that is to come if the rest is like this share: growing by doubling would
/// copy everything again and again (aligned memory cannot grow where it is), and room that is never touched costs
/// nothing.
fn append<P, T: Copy>(all: &mut Vec<T>, pieces: &[P], share: f64, column: impl Fn(&P) -> &Vec<T>) {
    let more: usize = pieces.iter().map(|p| column(p).len()).sum();
    if all.capacity() - all.len() < more {
        let expected = ((all.len() + more) as f64 / share * 1.05) as usize;
        let mut larger = Vec::with_capacity(expected.max(all.len() + more));
        large_pages(larger.spare_capacity_mut());
        larger.extend_from_slice(all);
        *all = larger;
    }
    for piece in pieces {
        all.extend_from_slice(column(piece));
    }
}

/// Runs of parts that have at least [`PIECE`] triangles (the last one: fewer).
fn group<T>(parts: &[T], size: impl Fn(&T) -> usize) -> Vec<&[T]> {
    let (mut groups, mut start, mut count) = (Vec::new(), 0, 0);
    for (i, part) in parts.iter().enumerate() {
        count += size(part);
        if count >= PIECE || i + 1 == parts.len() {
            groups.push(&parts[start..=i]);
            (start, count) = (i + 1, 0);
        }
    }
    groups
}

/// Fills the nodes of the top, in the order of the skeleton, over the roots of the parts. `next`: the node and the
/// root that come next.
fn place_top(
    top: &Top<()>,
    nodes: &mut [Node],
    next: &mut (usize, std::slice::Iter<Branch>),
    padding: f32,
) -> Branch {
    match top {
        Top::Part(()) => *next.1.next().expect("a root for each part"),
        Top::Node(children) => {
            let me = next.0;
            next.0 += 1;
            let mut bounds = Prim::EMPTY;
            for (slot, child) in children.iter().enumerate() {
                let branch = place_top(child, nodes, next, padding);
                set_child(&mut nodes[me], slot, &branch, padding);
                bounds = bounds.join(&branch.bounds);
            }
            Piece::branch(me, bounds)
        }
    }
}
