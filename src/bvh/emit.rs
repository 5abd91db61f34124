//! From parts of the tree, built one by one, to the whole.
//!
//! The top of a tree is a skeleton whose ends are parts. Parts that follow each other are written as one piece, with
//! indices of its own; then all pieces are laid end to end behind the nodes of the top. What a piece holds, and where
//! it starts, depends on the skeleton alone: the threads never decide a byte. A thread that is alone writes each piece
//! where it belongs.

use rayon::prelude::*;

use super::node::{Child, Line, Node};
use super::pack::Packer;
use super::prim::Prim;
use super::{Bvh, PartRecords};
use crate::geometry::Aabb;
use crate::raw::Pages;
use crate::scene::Triangle;
use crate::simd::Simd;
use crate::watch::Cancelled;

/// Pieces have about so many triangles: what is read and written for them stays in the second-level cache.
const PIECE: usize = 1 << 10;
/// Pieces that are written before they are laid end to end, at most.
const PIECES_A_THREAD: usize = 16;
/// And at most one in so many of all: what they hold is held twice.
const SHARE: usize = 4;

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
    nodes: Pages<Node>,
    lines: Pages<Line>,
    file_ids: Pages<u32>,
    /// Triangles in leaf order before those of this piece.
    first_id: u32,
    /// One for each part.
    roots: Pages<Branch>,
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
        // Builders call themselves, which the compiler inlines nowhere: without this, no wide instructions.
        let child = simd.vectorize(
            #[inline(always)]
            || packer.leaf(simd, self.triangles, numbers, first, lines),
        );
        Branch { child, bounds }
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
/// parts, or is cancelled; `records`: see [`Bvh::build_with`]; `room`: memory for them. `bounds`: the box of
/// everything.
///
/// As many pieces as keep the threads busy are written, laid end to end and their memory used again: it is warm, and
/// the system need not clear it.
pub(super) fn assemble<T: Send + Sync, R: Copy + Send + Sync>(
    triangles: &[Triangle],
    bounds: Aabb,
    top: Top<T>,
    size: impl Fn(&T) -> usize,
    write: impl Fn(&mut Piece, &[T]) -> Result<(), Cancelled> + Sync,
    records: &PartRecords<R>,
    room: Pages<R>,
) -> Result<(Bvh, Pages<R>), Cancelled> {
    let diagonal = (bounds.max.as_dvec3() - bounds.min.as_dvec3()).length();
    let padding = (diagonal * (1.0 / f64::from(1 << 20))) as f32;
    let mut parts = Vec::new();
    let top = top.take_parts(&mut parts);
    // The root is a node: a lone part gets one above it.
    let top_count = top.node_count().max(1);
    let empty = || Piece {
        triangles,
        padding,
        nodes: Pages::new(),
        lines: Pages::new(),
        file_ids: Pages::new(),
        first_id: 0,
        roots: Pages::new(),
        packer: Packer::new(),
    };
    let mut whole = Whole {
        piece: empty(),
        records: room,
    };
    whole.make_room(parts.iter().map(&size).sum());
    for _ in 0..top_count {
        whole.piece.reserve_node();
    }
    let groups = group(&parts, &size);
    let threads = rayon::current_num_threads();
    let at_once = (groups.len() / SHARE).clamp(threads, PIECES_A_THREAD * threads);
    let mut pieces = Vec::new();
    let mut first_id = 0;
    for groups in groups.chunks(at_once) {
        if threads == 1 {
            for parts in groups {
                let piece = &mut whole.piece;
                let first = piece.file_ids.len();
                write(piece, parts)?;
                records(&piece.file_ids[first..], &mut whole.records);
            }
            continue;
        }
        pieces.resize_with(groups.len(), || (empty(), Pages::new()));
        for ((piece, _), parts) in pieces.iter_mut().zip(groups) {
            piece.first_id = first_id as u32;
            first_id += parts.iter().map(&size).sum::<usize>();
        }
        pieces
            .par_iter_mut()
            .zip(groups)
            .try_for_each(|((piece, of_piece), parts)| {
                write(piece, parts)?;
                records(&piece.file_ids, of_piece);
                Ok(())
            })?;
        whole.append(&mut pieces);
    }
    let Whole { piece, records, .. } = whole;
    let Piece {
        mut nodes,
        lines,
        file_ids,
        roots,
        ..
    } = piece;
    let root = place_top(&top, &mut nodes, &mut (0, roots.iter()), padding);
    if let Top::Part(()) = top {
        set_child(&mut nodes[0], 0, &root, padding);
    }
    let bvh = Bvh {
        nodes,
        lines,
        file_ids,
        bounds,
        copies: 0,
    };
    Ok((bvh, records))
}

/// The tree as far as it is written.
struct Whole<'a, R: Copy> {
    /// The top's nodes, still empty, and all that is written behind them.
    piece: Piece<'a>,
    records: Pages<R>,
}

impl<R: Copy + Send + Sync> Whole<'_, R> {
    /// Room for a tree of so many triangles. What is not used costs nothing, and what grows would be copied: so room
    /// for a node for 16 triangles, where a mesh has one for 60, and for seven lines for eight, where a mesh has four
    /// and triangles that share no corners have six.
    fn make_room(&mut self, triangles: usize) {
        let Piece {
            nodes,
            lines,
            file_ids,
            ..
        } = &mut self.piece;
        nodes.make_room(triangles / 16);
        lines.make_room(triangles / 8 * 7);
        file_ids.make_room(triangles);
        self.records.make_room(triangles);
    }

    /// Moves what is in `pieces` behind everything.
    fn append(&mut self, pieces: &mut [(Piece, Pages<R>)]) {
        let all = &mut self.piece;
        let (mut nodes, mut lines) = (all.nodes.len(), all.lines.len());
        for (piece, _) in &mut *pieces {
            piece.move_behind(nodes, lines);
            nodes += piece.nodes.len();
            lines += piece.lines.len();
        }
        let from = &*pieces;
        rayon::join(
            || append(&mut all.lines, from, |(piece, _)| &piece.lines),
            || {
                append(&mut all.nodes, from, |(piece, _)| &piece.nodes);
                append(&mut all.file_ids, from, |(piece, _)| &piece.file_ids);
                append(&mut self.records, from, |(_, records)| records);
                append(&mut all.roots, from, |(piece, _)| &piece.roots);
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

/// One column of all pieces, behind what is there.
fn append<P, T: Copy>(all: &mut Pages<T>, pieces: &[P], column: impl Fn(&P) -> &Pages<T>) {
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
