//! What a tracer measures about its own work, beside the hits: chosen as a type, so that it costs nothing when it
//! is not asked for.

use crate::raw::ticks;

/// Which measurements are compiled into a kernel.
pub trait Probe {
    /// Tests are counted by 4x4 block, for the view `cost`.
    const COUNTS: bool = false;
    /// The ticks of each stage are added up.
    const TIMES: bool = false;
}

/// Nothing: what pictures are made with.
#[derive(Debug)]
pub enum Silent {}

impl Probe for Silent {}

/// [`Probe::COUNTS`]
#[derive(Debug)]
pub enum Counting {}

impl Probe for Counting {
    const COUNTS: bool = true;
}

/// [`Probe::TIMES`]
#[derive(Debug)]
pub enum Timing {}

impl Probe for Timing {
    const TIMES: bool = true;
}

/// Where the time of a tile goes, in ticks of the processor's time stamp counter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StageTicks {
    /// From box to box: the stack, nodes, what is hidden.
    pub traversal: u64,
    /// Leaves: vertices, screen boxes, edge functions.
    pub setup: u64,
    /// From edge functions to pixels.
    pub coverage: u64,
}

/// Measures what lies between two calls.
#[derive(Clone, Copy, Debug)]
pub struct Stopwatch(u64);

impl Stopwatch {
    /// Starts, where `P` times.
    #[inline(always)]
    #[must_use]
    pub fn start<P: Probe>() -> Stopwatch {
        Stopwatch(if P::TIMES { ticks() } else { 0 })
    }

    /// Ticks since the start or the last call.
    #[inline(always)]
    pub fn lap<P: Probe>(&mut self) -> u64 {
        if !P::TIMES {
            return 0;
        }
        let now = ticks();
        now.saturating_sub(std::mem::replace(&mut self.0, now))
    }
}
