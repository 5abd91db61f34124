//! What the terminal hears of a panic while there is a window.
//!
//! Threads that render and load catch theirs, and the window says what failed and goes on. Then Rust's own words, that a
//! thread panicked and how to get a backtrace, say more than is true: one line with the place, for who reports the
//! bug, is enough, and so are a few of them: what fails once may fail at every picture.
//!
//! winit panics when the display goes away in the middle of what it does. That is no bug to be reported.

use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe};
use std::path::{Component, Path};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use super::painter::message_of;
use super::window::report;

/// So many are told on the terminal.
pub const MOST: usize = 20;

thread_local! {
    /// The last panic of this thread was winit's.
    static IS_WINITS: Cell<bool> = const { Cell::new(false) };
}

/// From now on panics of other threads than the calling one are told in one line, and those of winit on this one by
/// [`catch_winits`], unless `RUST_BACKTRACE` asks for more.
pub fn tell_in_one_line() {
    let wants_more = std::env::var_os("RUST_BACKTRACE").is_some_and(|v| v != "0");
    let (usual, here) = (panic::take_hook(), thread::current().id());
    let told = AtomicUsize::new(0);
    panic::set_hook(Box::new(move |panic| {
        let is_here = thread::current().id() == here;
        let is_winits = is_here && panic.location().is_some_and(|p| is_in_winit(p.file()));
        IS_WINITS.set(is_winits);
        match panic.location() {
            Some(_) if is_winits && !wants_more => {}
            Some(place) if !is_here && !wants_more => {
                if told.fetch_add(1, Ordering::Relaxed) < MOST {
                    let why = message_of(panic.payload());
                    report(&format!("internal error at {place}: {why}"));
                }
            }
            _ => usual(panic),
        }
    }));
}

/// Runs `work`, the whole loop of events, and turns a panic of winit's into its message; for a single call, where any
/// panic is winit's, there is [`quietly`](super::backend::quietly). Needs [`tell_in_one_line`] before.
///
/// # Panics
/// On, when it is not winit's.
pub fn catch_winits<R>(work: impl FnOnce() -> R) -> Result<R, String> {
    panic::catch_unwind(AssertUnwindSafe(work)).map_err(|panicked| {
        if !IS_WINITS.take() {
            panic::resume_unwind(panicked);
        }
        message_of(&*panicked)
    })
}

/// Whether the source file is one of winit's, from a registry (`winit-0.30.0/src/..`) or beside ours.
fn is_in_winit(file: &str) -> bool {
    let is_winit = |part: Component<'_>| {
        let name = part.as_os_str().to_str();
        name.is_some_and(|name| name == "winit" || name.starts_with("winit-"))
    };
    Path::new(file).components().any(is_winit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn winits_source_is_known_wherever_it_lies() {
        assert!(is_in_winit("/home/me/registry/winit-0.30.13/src/window.rs"));
        assert!(is_in_winit("vendor/winit/src/window.rs"));
        assert!(!is_in_winit("src/app/window.rs"));
        assert!(!is_in_winit("/home/me/winits/src/app/window.rs"));
    }
}
