//! What the terminal hears of a panic while there is a window.
//!
//! Threads that render and load catch theirs, and the window says what failed and goes on. Then Rust's own words, that a
//! thread panicked and how to get a backtrace, say more than is true: one line with the place, for who reports the
//! bug, is enough, and so are a few of them: what fails once may fail at every picture.

use std::panic;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use super::painter::message_of;
use super::window::report;

/// So many are told on the terminal.
pub const MOST: usize = 20;

/// From now on panics of other threads than the calling one are told in one line, unless `RUST_BACKTRACE` asks for more.
pub fn tell_in_one_line() {
    let wants_more = std::env::var_os("RUST_BACKTRACE").is_some_and(|v| v != "0");
    let (usual, here) = (panic::take_hook(), thread::current().id());
    let told = AtomicUsize::new(0);
    panic::set_hook(Box::new(move |panic| match panic.location() {
        Some(place) if !wants_more && thread::current().id() != here => {
            if told.fetch_add(1, Ordering::Relaxed) < MOST {
                let why = message_of(panic.payload());
                report(&format!("internal error at {place}: {why}"));
            }
        }
        _ => usual(panic),
    }));
}
