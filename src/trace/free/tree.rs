//! A second tree, for many free rays: small leaves whose triangles lie side by side in lanes.
//!
//! The tree of [`World`] is made for tiles: its leaves are small meshes of up to 16 triangles, whose vertices are
//! moved into the tile's frame once for thousands of rays. A ray that comes alone wants fewer triangles, each ready
//! to be tested. So this tree is built beside it by those who shoot many rays; a single question (what is under the
//! mouse?) is answered by the tree that is there.

use glam::Vec3;
use rayon::prelude::*;

use super::block::{Block, LANES};
use super::frame::is_ray;
use super::many::AT_ONCE;
use super::walk::FreeTracer;
use super::{Ray, brute};
use crate::bvh::{Bvh, Child, Leaf, Line, Node};
use crate::color::Rgb;
use crate::frame::{Hit, MISS};
use crate::geometry::Aabb;
use crate::raw::{large_pages, prefetch};
use crate::scene::Triangle;
use crate::simd::{Kernel, dispatch};
use crate::world::World;

/// A [`Node`] with the order of its children. 256 bytes.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub struct RayNode {
    /// See [`Node::bounds`].
    pub bounds: [[f32; 8]; 6],
    /// What each box holds; leaves have the number of their block.
    pub children: [Child; 8],
    /// For rays of each octant (bits 0, 1, 2: goes down along x, y, z) the children, 3 bits each, the farthest first.
    pub orders: [u32; 8],
}

/// A tree for many free rays.
#[derive(Debug)]
pub struct RayTree {
    /// Interior nodes; the root is the first.
    pub(super) nodes: Vec<RayNode>,
    pub(super) blocks: Vec<Block>,
    /// Of all triangles in the tree.
    pub(super) bounds: Aabb,
}

/// Trees of more bytes than this do not stay in the caches.
const FAR: usize = 32 << 20;

/// The word of a leaf's first line that nobody uses: here, the number of its block.
const SPARE: usize = 15;

impl RayTree {
    /// Builds the tree over the triangles of `world`, in parallel on the current rayon pool; the same for any
    /// number of threads.
    ///
    /// # Panics
    /// As [`Bvh::build`].
    #[must_use]
    pub fn build(world: &World) -> RayTree {
        let of_world = world.bvh();
        let color = Rgb::from_packed(0);
        let triangles: Vec<Triangle> = of_world
            .corners()
            .into_iter()
            .map(|corners| Triangle { corners, color })
            .collect();
        let Bvh {
            nodes,
            mut lines,
            file_ids,
            bounds,
            ..
        } = Bvh::build_for_rays(&triangles);
        drop(triangles);
        let file_ids: Vec<u32> = file_ids
            .iter()
            .map(|&id| of_world.file_ids[id as usize])
            .collect();
        let firsts = number(&mut lines);
        let node = |node: &Node| RayNode {
            bounds: node.bounds,
            children: node.children.map(|child| {
                if child.is_leaf() {
                    Child::leaf(lines[child.index()].0[SPARE] as usize, 1)
                } else {
                    child
                }
            }),
            orders: orders(node),
        };
        let block = |&first: &u32| block(Leaf::new(&lines[first as usize..]), &file_ids);
        RayTree {
            nodes: packed(&nodes, node),
            blocks: packed(&firsts, block),
            bounds,
        }
    }

    /// The corners of the triangle in `slot`: block times 8 plus lane.
    #[inline(always)]
    pub(super) fn corners(&self, slot: u32) -> [Vec3; 3] {
        let block = &self.blocks[slot as usize / LANES];
        let lane = slot as usize % LANES;
        [0, 1, 2].map(|corner| {
            let [x, y, z] = &block.corners[corner];
            Vec3::new(x[lane], y[lane], z[lane])
        })
    }

    /// Its number in the file.
    #[inline(always)]
    pub(super) fn file_id(&self, slot: u32) -> u32 {
        self.blocks[slot as usize / LANES].ids[slot as usize % LANES]
    }

    /// The nearest hit of each ray, in the same order: the triangle's number in the file, and the distance.
    ///
    /// # Panics
    /// When this CPU lacks `kernel`, or the slices differ in length.
    pub fn closest_hits(
        &self,
        kernel: Kernel,
        tracer: &mut FreeTracer,
        rays: &[Ray],
        hits: &mut [Hit],
    ) {
        assert_eq!(rays.len(), hits.len(), "a hit for each ray");
        if self.nodes.is_empty() {
            hits.fill(Hit::NONE);
            return;
        }
        let FreeTracer { stack, company, .. } = tracer;
        dispatch!(kernel, simd => {
            for (rays, hits) in rays.chunks(AT_ONCE).zip(hits.chunks_mut(AT_ONCE)) {
                company.trace(simd, self, rays, hits, stack);
            }
        });
    }

    /// Asks for the lines of a child.
    #[inline(always)]
    pub(super) fn prefetch(&self, child: Child) {
        if child.is_leaf() {
            for line in 0..size_of::<Block>() / 64 {
                prefetch(&self.blocks, child.index(), line);
            }
        } else {
            for line in 0..size_of::<RayNode>() / 64 {
                prefetch(&self.nodes, child.index(), line);
            }
        }
    }

    /// Asks for the block of the triangle in `slot`.
    #[inline(always)]
    pub(super) fn prefetch_slot(&self, slot: u32) {
        self.prefetch(Child::leaf(slot as usize / LANES, 1));
    }

    /// Whether most of the tree is far away, in memory that is slow.
    #[inline(always)]
    pub(super) fn is_far(&self) -> bool {
        self.bytes() > FAR
    }

    /// A ray that no bound holds for.
    #[cold]
    #[inline(never)]
    pub(super) fn wild(&self, ray: &Ray) -> Hit {
        if !is_ray(ray) || ray.t_min.is_nan() || ray.t_max.is_nan() {
            return Hit::NONE;
        }
        let slots = self.blocks.iter().enumerate().flat_map(|(i, block)| {
            let used = block.ids.iter().take_while(|&&id| id != MISS).count();
            (0..used).map(move |lane| (i * LANES + lane) as u32)
        });
        let (corners, ids): (Vec<_>, Vec<_>) = slots
            .map(|slot| (self.corners(slot), self.file_id(slot)))
            .unzip();
        brute::closest_hit(&corners, &ids, ray)
    }

    /// Bytes of memory.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.blocks[..])
    }
}

/// What `make` makes of each, in large pages: rays visit the tree in no order that a page of 4 KiB would suit.
fn packed<T: Sync, U: Send>(from: &[T], make: impl Fn(&T) -> U + Send + Sync) -> Vec<U> {
    let mut all = Vec::with_capacity(from.len());
    large_pages(all.spare_capacity_mut());
    from.par_iter().map(make).collect_into_vec(&mut all);
    all
}

/// Writes into every leaf its number; their first lines.
fn number(lines: &mut [Line]) -> Vec<u32> {
    let (mut firsts, mut at) = (Vec::new(), 0);
    while at < lines.len() {
        lines[at].0[SPARE] = firsts.len() as u32;
        firsts.push(at as u32);
        at += Leaf::new(&lines[at..]).line_count();
    }
    firsts
}

/// The order of the children for rays of each octant.
fn orders(node: &Node) -> [u32; 8] {
    [0, 1, 2, 3, 4, 5, 6, 7].map(|octant: usize| {
        let distance = |i: usize| -> f32 {
            let along = |k: usize| {
                let middle = node.bounds[k][i] * 0.5 + node.bounds[k + 3][i] * 0.5;
                if octant >> k & 1 == 0 {
                    middle
                } else {
                    -middle
                }
            };
            along(0) + along(1) + along(2)
        };
        let mut children = [0, 1, 2, 3, 4, 5, 6, 7];
        children.sort_by(|&a, &b| distance(b).total_cmp(&distance(a)));
        children
            .iter()
            .rev()
            .fold(0, |order, &i| order << 3 | i as u32)
    })
}

fn block(leaf: Leaf<'_>, file_ids: &[u32]) -> Block {
    let mut block = Block {
        corners: [[[f32::NAN; LANES]; 3]; 3],
        ids: [MISS; LANES],
    };
    for lane in 0..leaf.count() {
        for (rows, corner) in block.corners.iter_mut().zip(leaf.corners(lane)) {
            for (row, x) in rows.iter_mut().zip(corner.to_array()) {
                row[lane] = x;
            }
        }
        block.ids[lane] = file_ids[leaf.first_id() as usize + lane];
    }
    block
}
