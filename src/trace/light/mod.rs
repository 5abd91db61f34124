//! Rays toward the light: each with an origin of its own, all in one direction. Is there anything in between?
//!
//! Seen along that direction, triangles and origins are points and triangles of a plane ([`frame`]), and a ray is
//! hidden when its point lies in a triangle and below it. So the triangles are sorted into the cells of a grid on
//! that plane, once a scene ([`LightGrid::build`]); a ray looks at the triangles of one cell, eight at a time and
//! the highest first, until the next ones all lie lower than its origin ([`block`]). There is no tree to walk; a
//! point in the sun needs one block or two, those of its own surface. Close relatives: Johnson et al., "The
//! irregular Z-buffer", 2005, which sorts the origins instead.
//!
//! The answer is that of a free ray ([`super::free`]), to the bit: blocks only sort out what is certain.

mod block;
mod frame;
mod grid;

use glam::Vec3;

pub use grid::LightGrid;

use crate::simd::{Kernel, Lanes, dispatch};
use crate::trace::free::rule::{self, Meeting};
use crate::trace::free::{FreeTracer, Ray};
use crate::world::World;
use block::{Answer, Block};
use grid::Query;

/// A cell with more blocks than this costs more than a way down the tree.
const CROWD: u32 = 24;

/// Rays whose cells are found before the first of them is looked into.
const AT_ONCE: usize = 16;

impl LightGrid {
    /// For each of `origins`: whether the ray from there toward the light hits anything. Same answers as
    /// [`FreeTracer::any_hits`] for [`LightGrid::ray`]s.
    ///
    /// # Panics
    /// When this CPU lacks `kernel`, the slices differ in length, or `world` is not the one of the grid.
    pub fn hidden(
        &self,
        kernel: Kernel,
        world: &World,
        tracer: &mut FreeTracer,
        origins: &[Vec3],
        hidden: &mut [bool],
    ) {
        assert_eq!(origins.len(), hidden.len(), "an answer for each origin");
        let mut left = Vec::new();
        dispatch!(kernel, simd => {
            let mut at = 0;
            for (origins, hidden) in origins.chunks(AT_ONCE).zip(hidden.chunks_mut(AT_ONCE)) {
                self.ask_many(simd, world, origins, hidden, at, &mut left);
                at += AT_ONCE;
            }
        });
        if !left.is_empty() {
            dispatch!(kernel, simd => for i in left {
                hidden[i] = tracer.hits_any(simd, world.bvh(), &self.ray(origins[i]));
            });
        }
    }

    /// The ray from `origin` toward the light.
    #[must_use]
    pub fn ray(&self, origin: Vec3) -> Ray {
        Ray::new(origin, self.frame.dir)
    }

    /// Answers for up to [`AT_ONCE`] origins, the first of which is number `first`: finds all their cells before it
    /// looks into the first, so that the blocks arrive meanwhile. Those that are better off with the tree go to
    /// `left`.
    #[inline(always)]
    fn ask_many<S: Lanes>(
        &self,
        simd: S,
        world: &World,
        origins: &[Vec3],
        hidden: &mut [bool],
        first: usize,
        left: &mut Vec<usize>,
    ) {
        let mut queries = [Query::NONE; AT_ONCE];
        for (i, (query, &origin)) in queries.iter_mut().zip(origins).enumerate() {
            if self.frame.holds(origin) {
                *query = self.query(origin);
                if query.end - query.first > CROWD {
                    *query = Query::NONE;
                    left.push(first + i);
                }
            } else {
                left.push(first + i);
            }
        }
        for ((query, &origin), hidden) in queries.iter().zip(origins).zip(hidden) {
            *hidden = self.ask(simd, world, query, origin);
        }
    }

    #[inline(always)]
    fn ask<S: Lanes>(&self, simd: S, world: &World, query: &Query, origin: Vec3) -> bool {
        for block in self.blocks(query) {
            if block.is_below(query.place.z) {
                return false;
            }
            match block.test(simd, query.place) {
                Answer::Free => {}
                Answer::Hidden => return true,
                Answer::Perhaps(lanes) => {
                    if self.settle(world, block, lanes, origin) {
                        return true;
                    }
                }
            }
        }
        false
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
