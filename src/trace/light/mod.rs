//! Rays toward the light: each with an origin of its own, all in one direction. Is there anything in between?
//!
//! Seen along that direction, triangles and origins are points and triangles of a plane ([`frame`]), and a ray is
//! hidden when its point lies in a triangle and below it. So the triangles are sorted into the cells of a grid on
//! that plane, once a scene ([`LightGrid::build`]); a ray looks at the triangles of one cell, eight at a time and
//! those first that rise highest in it, until the next ones all lie lower than its origin ([`block`]). There is no
//! tree to walk; a point in the sun needs one block or two, those of its own surface. Close relatives: Johnson et
//! al., "The irregular Z-buffer", 2005, which sorts the origins instead.
//!
//! Most points do not even come there: they lie on a triangle that has nothing above it, which was found out when
//! the grid was built ([`open`]).
//!
//! The answer is that of a free ray ([`super::free`]), to the bit: blocks only sort out what is certain.

mod block;
mod frame;
mod grid;
mod open;

use glam::Vec3;

pub use grid::LightGrid;
pub use open::{Start, start};

use crate::simd::{Kernel, Lanes, dispatch, lanes};
use crate::trace::free::rule::{self, Meeting};
use crate::trace::free::{FreeTracer, Ray};
use crate::world::World;
use block::{Answer, Block};
use grid::Query;

/// Looking at more blocks than this costs more than a way down the tree.
const CROWD: usize = 24;

/// Rays whose cells are found before the first of them is looked into.
const AT_ONCE: usize = 16;

/// Rays that are sorted out before the first of them goes to the grid.
const SORTED_OUT: usize = 1024;

/// Where a ray starts.
#[inline(always)]
fn origin(start: &Start) -> Vec3 {
    let [x, y, z, _] = *start;
    Vec3::new(x, y, z)
}

impl LightGrid {
    /// For each of `starts`: whether the ray from there toward the light hits anything. Same answers as
    /// [`FreeTracer::any_hits`] for [`LightGrid::ray`]s.
    ///
    /// # Panics
    /// When this CPU lacks `kernel`, the slices differ in length, or `world` is not the one of the grid.
    pub fn hidden(
        &self,
        kernel: Kernel,
        world: &World,
        tracer: &mut FreeTracer,
        starts: &[Start],
        hidden: &mut [bool],
    ) {
        assert_eq!(starts.len(), hidden.len(), "an answer for each start");
        hidden.fill(false);
        let (mut unsure, mut left) = (Vec::new(), Vec::new());
        let mut are_few = false;
        dispatch!(kernel, simd => {
            for first in (0..starts.len()).step_by(SORTED_OUT) {
                unsure.clear();
                are_few = self.sort_out(simd, starts, first, are_few, &mut unsure);
                for unsure in unsure.chunks(AT_ONCE) {
                    self.ask_many(simd, world, starts, unsure, hidden, &mut left);
                }
            }
        });
        if !left.is_empty() {
            dispatch!(kernel, simd => for i in left {
                hidden[i] = tracer.hits_any(simd, world.bvh(), &self.ray(origin(&starts[i])));
            });
        }
    }

    /// The ray from `origin` toward the light.
    #[must_use]
    pub fn ray(&self, origin: Vec3) -> Ray {
        Ray::new(origin, self.frame.dir)
    }

    /// Puts those of the [`SORTED_OUT`] `starts` from number `first` on into `unsure` that do not certainly see the
    /// light. Returns whether as many of them as there are lanes lie on few triangles, mostly, so that it pays to expect
    /// that of the next ones (`are_few`): with 16 lanes; fewer are gathered as fast.
    #[inline(always)]
    fn sort_out<S: Lanes>(
        &self,
        simd: S,
        starts: &[Start],
        first: usize,
        are_few: bool,
        unsure: &mut Vec<usize>,
    ) -> bool {
        let end = starts.len().min(first + SORTED_OUT);
        if self.open.is_empty() {
            unsure.extend(first..end);
            return false;
        }
        let many = lanes::<S>();
        let (groups, mut few) = ((end - first).div_ceil(many), 0);
        for first in (first..end).step_by(many) {
            let count = many.min(end - first);
            let mut padded = [[0.0; 4]; 16];
            let some = if count == many {
                &starts[first..first + many]
            } else {
                padded[..count].copy_from_slice(&starts[first..end]);
                &padded[..many]
            };
            let seeing = match are_few {
                true => self.open.see_light_on_few(simd, &self.frame, some),
                false => self.open.see_light(simd, &self.frame, some),
            };
            if many == 16 {
                let [one, middle, last] = [0, 8, 15].map(|lane| some[lane][3].to_bits());
                few += usize::from((middle == one) | (middle == last));
            }
            let mut left = !seeing & u32::MAX >> (32 - count);
            while left != 0 {
                unsure.push(first + left.trailing_zeros() as usize);
                left &= left - 1;
            }
        }
        few * 8 > groups * 7
    }

    /// Answers for up to [`AT_ONCE`] of `starts`: finds all their cells before it looks into the first, so that the
    /// blocks arrive meanwhile. Those that are better off with the tree go to `left`.
    #[inline(always)]
    fn ask_many<S: Lanes>(
        &self,
        simd: S,
        world: &World,
        starts: &[Start],
        which: &[usize],
        hidden: &mut [bool],
        left: &mut Vec<usize>,
    ) {
        let mut queries = [Query::NONE; AT_ONCE];
        for (query, &i) in queries.iter_mut().zip(which) {
            let origin = origin(&starts[i]);
            if self.frame.holds(origin) {
                *query = self.query(origin);
            } else {
                left.push(i);
            }
        }
        for (query, &i) in queries.iter().zip(which) {
            match self.ask(simd, world, query, origin(&starts[i])) {
                Some(answer) => hidden[i] = answer,
                None => left.push(i),
            }
        }
    }

    /// `None` when there is too much to look at.
    #[inline(always)]
    fn ask<S: Lanes>(&self, simd: S, world: &World, query: &Query, origin: Vec3) -> Option<bool> {
        let blocks = self.blocks(query);
        for block in blocks.iter().take(CROWD) {
            if block.is_below(query.place.z) {
                return Some(false);
            }
            match block.test(simd, query.place) {
                Answer::Free => {}
                Answer::Hidden => return Some(true),
                Answer::Perhaps(lanes) => {
                    if self.settle(world, block, lanes, origin) {
                        return Some(true);
                    }
                }
            }
        }
        (blocks.len() <= CROWD).then_some(false)
    }

    /// Whether one of the triangles `lanes` (as bits) of a block hides the light.
    #[cold]
    #[inline(never)]
    fn settle(&self, world: &World, block: &Block, lanes: u32, origin: Vec3) -> bool {
        (0..8).filter(|lane| lanes >> lane & 1 != 0).any(|lane| {
            let triangle = rule::relative(&world.corners()[block.id(lane)], origin);
            Meeting::new(&triangle).meets(&triangle, self.frame.dir)
        })
    }
}
