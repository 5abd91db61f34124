//! A ray's way down the tree.

use super::frame::{RayFrame, is_ray};
use super::many::Company;
use super::rule::{self, Meeting};
use super::{Ray, brute, leaf};
use crate::bvh::{Bvh, Child, Leaf, Node};
use crate::frame::{Hit, MISS};
use crate::simd::{
    Kernel, Lanes, SimdBase, SimdFloat, SimdMask, VertexScratch, dispatch, f32x8, lanes,
};

/// What one thread needs to trace free rays.
#[derive(Clone, Debug)]
pub struct FreeTracer {
    pub(super) stack: Stack,
    pub(super) company: Company,
    scratch: Box<VertexScratch>,
}

/// Nodes and leaves to visit: the bits of the nearest distance (not negative, so they sort as numbers do), then
/// the child's word.
#[derive(Clone, Debug)]
pub(super) struct Stack(pub(super) Vec<u64>);

impl Default for Stack {
    fn default() -> Stack {
        Stack(vec![0; 256])
    }
}

impl Stack {
    /// Makes room for a node's children above `depth`.
    #[inline(always)]
    pub(super) fn reserve(&mut self, depth: usize) {
        if depth + 8 > self.0.len() {
            self.0.resize(2 * self.0.len(), 0);
        }
    }
}

impl Default for FreeTracer {
    fn default() -> FreeTracer {
        FreeTracer {
            stack: Stack::default(),
            company: Company::default(),
            scratch: Box::new(VertexScratch::NEW),
        }
    }
}

impl FreeTracer {
    /// The nearest hit of each ray, in the same order: the triangle's number in the file, and the distance.
    ///
    /// # Panics
    /// When this CPU lacks `kernel`, or the slices differ in length.
    pub fn closest_hits(&mut self, kernel: Kernel, bvh: &Bvh, rays: &[Ray], hits: &mut [Hit]) {
        assert_eq!(rays.len(), hits.len(), "a hit for each ray");
        dispatch!(kernel, simd => for (ray, hit) in rays.iter().zip(hits) {
            *hit = self.trace::<_, false>(simd, bvh, ray);
        });
    }

    /// Whether each ray hits anything, in the same order.
    ///
    /// # Panics
    /// When this CPU lacks `kernel`, or the slices differ in length.
    pub fn any_hits(&mut self, kernel: Kernel, bvh: &Bvh, rays: &[Ray], hits: &mut [bool]) {
        assert_eq!(rays.len(), hits.len(), "an answer for each ray");
        dispatch!(kernel, simd => for (ray, hit) in rays.iter().zip(hits) {
            *hit = self.hits_any(simd, bvh, ray);
        });
    }

    /// Whether a ray hits anything.
    #[inline(always)]
    pub(in crate::trace) fn hits_any<S: Lanes>(&mut self, simd: S, bvh: &Bvh, ray: &Ray) -> bool {
        self.trace::<_, true>(simd, bvh, ray).id != MISS
    }

    /// The nearest hit, or with `ANY` the first one that is found.
    #[inline(always)]
    fn trace<S: Lanes, const ANY: bool>(&mut self, simd: S, bvh: &Bvh, ray: &Ray) -> Hit {
        if bvh.nodes.is_empty() || !is_ray(ray) {
            return Hit::NONE;
        }
        let Some(frame) = RayFrame::new(ray, &bvh.bounds) else {
            return brute::closest_hit(&bvh.corners(), &bvh.file_ids, ray);
        };
        let mut best = Best {
            t: ray.t_max,
            id: MISS,
        };
        let mut depth = 0;
        let mut child = Child::node(0);
        loop {
            if child.is_leaf() {
                let leaf = bvh.leaf(child.index());
                self.leaf::<S>(simd, bvh, leaf, &frame, ray, &mut best);
                if ANY && best.id != MISS {
                    break;
                }
            } else {
                let node = &bvh.nodes[child.index()];
                let (near, mut met) = boxes(simd, &frame, node, best.t);
                if met != 0 {
                    let mut ahead = met;
                    while ahead != 0 {
                        bvh.prefetch(node.children[ahead.trailing_zeros() as usize & 7]);
                        ahead &= ahead - 1;
                    }
                    self.stack.reserve(depth);
                    depth = push(&mut self.stack.0, depth, &node.children, &near, &mut met);
                    child = Child(self.stack.0[depth] as u32);
                    continue;
                }
            }
            loop {
                if depth == 0 {
                    return best.hit(bvh);
                }
                depth -= 1;
                let entry = self.stack.0[depth];
                if f32::from_bits((entry >> 32) as u32) <= best.t {
                    child = Child(entry as u32);
                    break;
                }
            }
        }
        best.hit(bvh)
    }

    #[inline(always)]
    fn leaf<S: Lanes>(
        &mut self,
        simd: S,
        bvh: &Bvh,
        leaf: Leaf<'_>,
        frame: &RayFrame,
        ray: &Ray,
        best: &mut Best,
    ) {
        leaf::see(simd, frame, leaf, &mut self.scratch);
        let mut first = 0;
        while first < leaf.count() {
            let mut left = leaf::candidates(simd, frame, leaf, first, &self.scratch);
            while left != 0 {
                let at = first + left.trailing_zeros() as usize;
                left &= left - 1;
                best.offer(bvh, leaf, at, ray);
            }
            first += lanes::<S>();
        }
    }
}

/// The nearest hit so far.
#[derive(Clone, Copy, Debug)]
struct Best {
    t: f32,
    /// In leaf order.
    id: u32,
}

impl Best {
    /// Takes triangle `at` of `leaf` if the ray hits it nearer, or as near with a lower number in the file.
    #[inline(always)]
    fn offer(&mut self, bvh: &Bvh, leaf: Leaf<'_>, at: usize, ray: &Ray) {
        let triangle = rule::relative(&leaf.corners(at), ray.origin);
        let meeting = Meeting::new(&triangle);
        let t = meeting.distance(ray);
        let wins = ray.t_min <= t && t <= self.t && meeting.meets(&triangle, ray.dir);
        if !wins {
            return;
        }
        let id = leaf.first_id() + at as u32;
        let file_id = |id: u32| bvh.file_ids[id as usize];
        if t < self.t || self.id == MISS || file_id(id) < file_id(self.id) {
            *self = Best { t, id };
        }
    }

    #[inline(always)]
    fn hit(self, bvh: &Bvh) -> Hit {
        if self.id == MISS {
            return Hit::NONE;
        }
        Hit {
            id: bvh.file_ids[self.id as usize],
            t: self.t,
        }
    }
}

/// The nearest distance of each child's box, and which of them the ray meets not beyond `far`.
#[inline(always)]
fn boxes<S: Lanes>(simd: S, frame: &RayFrame, node: &Node, far: f32) -> ([f32; 8], u32) {
    let mut enter = f32x8::splat(simd, 0.0);
    let mut leave = f32x8::splat(simd, far);
    for k in 0..3 {
        let row = frame.near_row[k];
        let opposite = if row >= 3 { row - 3 } else { row + 3 };
        let inverse = f32x8::splat(simd, frame.inverse[k]);
        let near = f32x8::load_array_ref(simd, &node.bounds[row % 6]);
        let far = f32x8::load_array_ref(simd, &node.bounds[opposite % 6]);
        enter = enter.max(inverse.mul_add(near, f32x8::splat(simd, frame.near_offset[k])));
        leave = leave.min(inverse.mul_add(far, f32x8::splat(simd, frame.far_offset[k])));
    }
    let mut near = [0.0; 8];
    enter.store_array(&mut near);
    (near, enter.simd_le(leave).to_bitmask() as u32)
}

/// Puts the `children` that are `met` (not none) onto the stack from `depth` on, the nearest on top; its depth below
/// the nearest.
#[inline(always)]
pub(super) fn push(
    stack: &mut [u64],
    depth: usize,
    children: &[Child; 8],
    near: &[f32; 8],
    met: &mut u32,
) -> usize {
    let mut top = depth;
    while *met != 0 {
        let i = met.trailing_zeros() as usize & 7;
        *met &= *met - 1;
        let child = children[i];
        let entry = u64::from(near[i].to_bits()) << 32 | u64::from(child.0);
        let mut at = top;
        while at > depth && stack[at - 1] < entry {
            stack[at] = stack[at - 1];
            at -= 1;
        }
        stack[at] = entry;
        top += 1;
    }
    top - 1
}
