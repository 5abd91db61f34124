//! Many rays, in any order: those that keep together go as beams, the others in streams.
//!
//! Rays are looked at in windows of 64 that follow each other. The first ray that is left takes all with it whose
//! directions are like its own ([`super::beam`]); what finds no company waits with others of its octant
//! ([`super::stream`]). How much alike they must be is learned on the way: of two degrees the one that made less work is
//! the middle of the next two. In front of a hedge a narrow beam meets as much as a wide one does in a bare room. What is hit does not depend on any of this.

use std::cmp::Ordering;
use std::ops::Range;

use super::Ray;
use super::beam::Beam;
use super::ready::Extent;
use super::stream::{Aside, Room};
use super::tree::RayTree;
use super::walk::Stack;
use super::window::{MOST, Window};
use crate::frame::Hit;
use crate::raw::prefetch;
use crate::simd::Lanes;

/// Rays that are sorted by octant at once.
pub const AT_ONCE: usize = 1 << 18;

/// Rays are asked for so many ahead of their use.
const AHEAD: usize = 2 * MOST;
/// Lines of the caches that a window of rays takes.
const LINES: usize = MOST * size_of::<Ray>() / 64;

/// Fewer rays than this are no beam.
const LEAST: u32 = 8;
/// So many rays of a window ask for company.
const SEEDS: usize = 12;
/// After a window without any beam, so many are not asked.
const PAUSE: u32 = 7;

/// How much slopes may differ, at first, at least and at most.
const SPREAD: f32 = 0.1;
const NARROW: f32 = 0.01;
const WIDE: f32 = 0.5;
/// What is tried: more and less by this factor.
const STEP: f32 = 1.25;
/// Windows, half of them each way, until one way is taken.
const TRIAL: usize = 64;

/// What a beam costs before it starts, and what a ray without company costs, in the unit of [`Beam::trace`].
const BEAM: usize = 20;
const ALONE: usize = 25;
/// A beam is given up when it costs more than this, and for each ray this.
const PATIENCE: usize = 40;
const PATIENCE_A_RAY: usize = 30;

/// What some rays cost.
#[derive(Clone, Copy, Debug, Default)]
struct Trial {
    work: usize,
    rays: usize,
}

/// What many rays need.
#[derive(Clone, Debug)]
pub struct Company {
    window: Box<Window>,
    beam: Box<Beam>,
    /// How much slopes may differ now.
    spread: f32,
    /// What rays cost where they may differ less, and where more.
    trials: [Trial; 2],
    /// Windows of these trials so far.
    windows: usize,
    /// Windows that will not be asked.
    pause: u32,
    /// Rays without company by octant; last those that no bound holds for.
    aside: [Aside; 9],
    room: Room,
}

impl Default for Company {
    fn default() -> Company {
        Company {
            window: Box::default(),
            beam: Box::default(),
            spread: SPREAD,
            trials: [Trial::default(); 2],
            windows: 0,
            pause: 0,
            aside: Default::default(),
            room: Room::default(),
        }
    }
}

impl Company {
    /// The nearest hits of up to [`AT_ONCE`] rays.
    #[inline(always)]
    pub fn trace<S: Lanes>(
        &mut self,
        simd: S,
        tree: &RayTree,
        rays: &[Ray],
        hits: &mut [Hit],
        stack: &mut Stack,
    ) {
        let extent = Extent::new(&tree.bounds);
        for aside in &mut self.aside {
            aside.rays.clear();
            aside.numbers.clear();
        }
        let mut first = 0;
        let all = rays;
        for (rays, hits) in rays.chunks(MOST).zip(hits.chunks_mut(MOST)) {
            // A few lines at a time: more than the CPU can wait for at once would hold up whatever comes next.
            let ask = |lines: Range<usize>| {
                for line in lines {
                    prefetch(all, first + AHEAD, line);
                }
            };
            ask(0..LINES / 4);
            self.window.fill(simd, rays, &extent);
            ask(LINES / 4..LINES / 2);
            let in_beams = self.beams(simd, tree, rays, hits, stack);
            ask(LINES / 2..LINES);
            self.put_aside(rays, first, !in_beams);
            first += rays.len();
        }
        let [octants @ .., wild] = &self.aside;
        for (octant, aside) in octants.iter().enumerate() {
            self.room.trace(simd, tree, octant, aside, hits);
        }
        for (ray, &number) in wild.rays.iter().zip(&wild.numbers) {
            hits[number as usize] = tree.wild(ray);
        }
    }

    /// Traces rays of the window as beams; those that went so, as bits.
    #[inline(always)]
    fn beams<S: Lanes>(
        &mut self,
        simd: S,
        tree: &RayTree,
        rays: &[Ray],
        hits: &mut [Hit],
        stack: &mut Stack,
    ) -> u64 {
        if self.pause > 0 {
            self.pause -= 1;
            return 0;
        }
        hits.fill(Hit::NONE);
        let trial = self.windows % 2;
        let spread = self.spread * [1.0 / STEP, STEP][trial];
        let (mut done, mut work) = (0u64, 0);
        let mut left = self.window.tame;
        for _ in 0..SEEDS {
            if left == 0 {
                break;
            }
            let seed = left.trailing_zeros() as usize;
            let members = self.window.like(simd, seed, spread) & left;
            left &= !members;
            if members.count_ones() < LEAST {
                continue;
            }
            self.beam.take(simd, &self.window, members, seed);
            let patience = PATIENCE + PATIENCE_A_RAY * members.count_ones() as usize;
            let of_beam = self.beam.trace(simd, tree, rays, stack, patience);
            if of_beam.is_some() {
                self.beam.write(simd, tree, rays, hits);
                done |= members;
            }
            work += BEAM + of_beam.unwrap_or(patience);
        }
        if done == 0 {
            self.pause = PAUSE;
        }
        let alone = rays.len() - done.count_ones() as usize;
        self.trials[trial].work += work + ALONE * alone;
        self.trials[trial].rays += rays.len();
        self.windows += 1;
        if self.windows == TRIAL {
            self.learn();
        }
        done
    }

    /// Goes the way on which rays cost less.
    fn learn(&mut self) {
        let [less, more] = self.trials;
        match (less.work * more.rays).cmp(&(more.work * less.rays)) {
            Ordering::Less => self.spread = (self.spread / STEP).max(NARROW),
            Ordering::Greater => self.spread = (self.spread * STEP).min(WIDE),
            Ordering::Equal => {}
        }
        self.trials = [Trial::default(); 2];
        self.windows = 0;
    }

    /// Sorts rays of the window by octant: those of `apart`, as bits. `first`: the number of the first of the window.
    #[inline(always)]
    fn put_aside(&mut self, rays: &[Ray], first: usize, apart: u64) {
        let mut left = apart & (u64::MAX >> (MOST - rays.len()));
        while left != 0 {
            let i = left.trailing_zeros() as usize;
            left &= left - 1;
            let ray = &rays[i];
            let tame = self.window.tame >> i & 1 != 0;
            let class = if tame {
                ray.dir.is_negative_bitmask() as usize
            } else {
                8
            };
            self.aside[class].rays.push(*ray);
            self.aside[class].numbers.push((first + i) as u32);
        }
    }
}
