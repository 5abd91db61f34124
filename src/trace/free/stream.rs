//! Many rays down a [`RayTree`] together.
//!
//! A ray alone spends most of its time waiting: for a node, for the test of that node to tell where to go, for a
//! branch that was guessed wrong. So rays are sorted by octant, and those of one octant visit a node one after the
//! other before any goes on: the node is in registers, the tests do not wait for each other, and each ray is put onto
//! the lists of the children that it meets. Lists are visited nearest child first, in the order that suits the octant;
//! where few rays are left they go on alone, each in its own order. Close relatives: Gribble, Ramani, "Coherent ray
//! tracing via stream filtering", 2008; Barringer, Akenine-Möller, "Dynamic ray stream traversal", 2014.

use super::Ray;
use super::distances::HitRoom;
use super::ready::{Extent, Ready};
use super::single::{Boxes, Sides, Slabs, Walker};
use super::tree::RayTree;
use super::window::MOST;
use crate::bvh::Child;
use crate::frame::{Hit, MISS};
use crate::simd::{Lanes, SimdBase, SimdMask, u16x8};

/// Rays of a stream at least and at most.
const SHORT: usize = 1 << 11;
const LONG: usize = 1 << 14;
/// A stream has a ray for so many bytes of the tree: enough to share its nodes, and with a small tree no more than
/// the caches hold.
const BYTES_A_RAY: usize = 32;

/// Rays that go on alone when no more are left; the second number is for trees that are far away.
const FEW: [usize; 2] = [3, 6];

/// Rays that go alone in turn.
const WALKERS: usize = 16;

/// Rays that were put aside, and their numbers.
#[derive(Clone, Debug, Default)]
pub struct Aside {
    pub rays: Vec<Ray>,
    pub numbers: Vec<u32>,
}

/// Room for streams: what they leave behind is used again.
#[derive(Clone, Debug, Default)]
pub struct Room {
    ready: Vec<Ready>,
    lists: Vec<u16>,
    /// Of each ray on a list, the children that it meets.
    met: Vec<u16>,
    visits: Vec<Visit>,
    found: Box<HitRoom>,
    walkers: Vec<Walker>,
}

/// Rays that are to visit a child.
#[derive(Clone, Copy, Debug)]
struct Visit {
    child: Child,
    /// Their list.
    start: u32,
    count: u32,
    /// From here on nobody needs the lists.
    free: u32,
}

impl Room {
    /// The nearest hits of any number of tame rays, all of one octant.
    #[inline(always)]
    pub fn trace<S: Lanes>(
        &mut self,
        simd: S,
        tree: &RayTree,
        octant: usize,
        aside: &Aside,
        hits: &mut [Hit],
    ) {
        let Aside { rays, numbers } = aside;
        let extent = Extent::new(&tree.bounds);
        let length = (tree.bytes() / BYTES_A_RAY).clamp(SHORT, LONG);
        for (numbers, rays) in numbers.chunks(length).zip(rays.chunks(length)) {
            self.ready.clear();
            self.ready
                .extend(rays.iter().map(|ray| Ready::new(ray, &extent)));
            self.stream(simd, tree, octant, rays);
            // Whether a ray hit anything is anybody's guess: those that did come first onto a list, without a branch.
            let mut found = 0;
            for (i, (&number, ready)) in numbers.iter().zip(&self.ready).enumerate() {
                hits[number as usize] = Hit::NONE;
                self.met[found] = i as u16;
                found += usize::from(ready.nearest.slot != MISS);
            }
            for found in self.met[..found].chunks(MOST) {
                self.found.each_hit(
                    simd,
                    tree,
                    found,
                    &self.ready,
                    rays,
                    #[inline(always)]
                    |i, hit| hits[numbers[i] as usize] = hit,
                );
            }
        }
    }

    /// Traces the prepared rays, all of one octant.
    #[inline(always)]
    fn stream<S: Lanes>(&mut self, simd: S, tree: &RayTree, octant: usize, rays: &[Ray]) {
        let sides = Sides::of_octant(octant);
        let few = FEW[usize::from(tree.is_far())];
        self.make_room(rays.len());
        self.met.resize(LONG + 8, 0);
        for (i, place) in self.lists[..rays.len()].iter_mut().enumerate() {
            *place = i as u16;
        }
        self.visits.clear();
        self.visits.push(Visit {
            child: Child::node(0),
            start: 0,
            count: rays.len() as u32,
            free: rays.len() as u32,
        });
        while let Some(visit) = self.visits.pop() {
            let (child, start, count) = (visit.child, visit.start as usize, visit.count as usize);
            if count <= few {
                self.go_alone(simd, tree, &sides, visit, few, rays);
            } else if child.is_leaf() {
                for &i in &self.lists[start..start + count] {
                    let me = &mut self.ready[usize::from(i)];
                    let sheared = me.sheared(simd);
                    me.look(simd, tree, child.index(), &sheared, &rays[usize::from(i)]);
                }
            } else {
                self.visit(simd, tree, octant, &sides, visit);
            }
        }
    }

    /// Rays of small visits, this one and those that come next, go on alone: several in turn, so that the memory of
    /// one arrives while the others work.
    #[inline(always)]
    fn go_alone<S: Lanes>(
        &mut self,
        simd: S,
        tree: &RayTree,
        sides: &Sides,
        first: Visit,
        few: usize,
        rays: &[Ray],
    ) {
        self.walkers.resize_with(WALKERS + FEW[1], Walker::default);
        let mut count = 0;
        let mut visit = first;
        loop {
            tree.prefetch(visit.child);
            let start = visit.start as usize;
            for &number in &self.lists[start..start + visit.count as usize] {
                let known = self.walkers[..count]
                    .iter()
                    .position(|w| w.number == number);
                if let Some(at) = known {
                    self.walkers[at].add(visit.child);
                } else {
                    self.walkers[count].start(number, visit.child);
                    count += 1;
                }
            }
            match self.visits.last() {
                Some(next) if count < WALKERS && next.count as usize <= few => visit = *next,
                _ => break,
            }
            self.visits.pop();
        }
        while count > 0 {
            let mut at = 0;
            while at < count {
                let walker = &mut self.walkers[at];
                let number = usize::from(walker.number);
                if walker.step(simd, tree, sides, &mut self.ready[number], &rays[number]) {
                    at += 1;
                } else {
                    count -= 1;
                    self.walkers.swap(at, count);
                }
            }
        }
    }

    /// Puts the rays of a node onto the lists of its children.
    #[inline(always)]
    fn visit<S: Lanes>(
        &mut self,
        simd: S,
        tree: &RayTree,
        octant: usize,
        sides: &Sides,
        visit: Visit,
    ) {
        let node = &tree.nodes[visit.child.index()];
        let (start, count) = (visit.start as usize, visit.count as usize);
        let boxes = Boxes::new(simd, node, sides);
        let mut any = 0;
        for (met, &i) in self.met.iter_mut().zip(&self.lists[start..start + count]) {
            let me = &self.ready[usize::from(i)];
            let (_, of_me) = Slabs::new(simd, me).meet(simd, &boxes, me.nearest.high);
            *met = of_me as u16;
            any |= of_me;
        }
        self.met[count..count + 8].fill(0);
        let first_visit = self.visits.len();
        let mut end = visit.free as usize;
        let mut order = node.orders[octant % 8];
        for _ in 0..8 {
            let i = order as usize % 8;
            order >>= 3;
            if any >> i & 1 == 0 {
                continue;
            }
            self.make_room(end + count);
            let begin = end;
            let bit = u16x8::splat(simd, 1 << i);
            for at in (0..count).step_by(8) {
                let met = u16x8::from_slice(simd, &self.met[at..at + 8]);
                let list = u16x8::from_slice(simd, &self.lists[start + at..start + at + 8]);
                let meets = (met & bit).simd_eq(bit);
                list.compress(meets)
                    .store_slice(&mut self.lists[end..end + 8]);
                end += meets.to_bitmask().count_ones() as usize;
            }
            tree.prefetch(node.children[i]);
            self.visits.push(Visit {
                child: node.children[i],
                start: begin as u32,
                count: (end - begin) as u32,
                free: 0,
            });
        }
        for visit in &mut self.visits[first_visit..] {
            visit.free = end as u32;
        }
    }

    #[inline(always)]
    fn make_room(&mut self, length: usize) {
        if self.lists.len() < length + 8 {
            self.lists.resize((length + 8).next_power_of_two(), 0);
        }
    }
}
