//! How long work is watched from outside: it tells how far it is, and asks now and then whether it is still wanted.
//!
//! It asks at its seams, between two stages or before each part that a thread takes: often enough for a hand that
//! waits, and too rarely to cost anything.

use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};

/// What is done and what there is to do, in parts: from any thread, and the numbers of different threads in any order.
type Tell<'a> = dyn Fn(usize, usize) + Sync + 'a;

/// What never comes true.
static NEVER: AtomicBool = AtomicBool::new(false);

/// Who watches a piece of work.
#[derive(Clone, Copy)]
pub struct Watch<'a> {
    tell: &'a Tell<'a>,
    cancelled: &'a AtomicBool,
}

impl<'a> Watch<'a> {
    /// Nobody: the work is never cancelled.
    pub const NOBODY: Watch<'static> = Watch::of(&|_, _| ());

    /// `tell` is told how far the work is, which is never cancelled.
    #[must_use]
    pub const fn of(tell: &'a Tell<'a>) -> Watch<'a> {
        Watch::with_cancel(tell, &NEVER)
    }

    /// The same, and the work stops soon after `cancelled` has become true.
    #[must_use]
    pub const fn with_cancel(tell: &'a Tell<'a>, cancelled: &'a AtomicBool) -> Watch<'a> {
        Watch { tell, cancelled }
    }

    /// Tells that `done` parts of `of` are done.
    pub fn tell(&self, done: usize, of: usize) {
        (self.tell)(done, of);
    }

    /// Asks whether the work shall go on.
    ///
    /// # Errors
    /// [`Cancelled`] when not.
    pub fn check(&self) -> Result<(), Cancelled> {
        match self.cancelled.load(Ordering::Relaxed) {
            true => Err(Cancelled),
            false => Ok(()),
        }
    }
}

impl fmt::Debug for Watch<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut out = f.debug_struct("Watch");
        out.field("cancelled", self.cancelled)
            .finish_non_exhaustive()
    }
}

/// The work was stopped before its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cancelled;
