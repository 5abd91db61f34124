//! What the program prints: data to the standard output, words and progress to the standard error stream.

use std::fmt::Display;
use std::io::{self, IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

use super::exit::{Failure, Outcome};
use crate::render::Progress;

/// Prints `text` and a newline to the standard output.
///
/// # Errors
/// When it takes no more: closed, or a full disk.
pub fn print(text: impl Display) -> Outcome {
    let mut out = io::stdout().lock();
    writeln!(out, "{text}")
        .and_then(|()| out.flush())
        .map_err(|e| match e.kind() {
            io::ErrorKind::BrokenPipe => Failure::OutputClosed,
            _ => Failure::Failed(format!("cannot write to the standard output: {e}")),
        })
}

/// Prints a line of words. A closed error stream is no reason to stop.
pub fn say(text: impl Display) {
    let _ = writeln!(io::stderr().lock(), "{text}");
}

/// True when words may be coloured.
#[must_use]
pub fn color() -> bool {
    io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty())
}

/// A bar of `total` steps on a terminal, nothing elsewhere.
#[must_use]
pub fn bar(total: u64, what: &str) -> ProgressBar {
    let style = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len}  {eta} left")
        .expect("the template is well-formed");
    let total_known = Some(total);
    // Hidden by itself where the error stream is no terminal.
    ProgressBar::with_draw_target(total_known, indicatif::ProgressDrawTarget::stderr())
        .with_style(style)
        .with_message(what.to_owned())
}

/// Does `work`; a picture that takes more than a moment gets a bar of its tiles on a terminal.
pub fn with_tile_bar<R>(progress: &Progress, work: impl FnOnce() -> R) -> R {
    const STEP: Duration = Duration::from_millis(50);
    if !io::stderr().is_terminal() {
        return work();
    }
    let done = AtomicBool::new(false);
    thread::scope(|scope| {
        let painter = scope.spawn(|| {
            thread::park_timeout(STEP * 10);
            let bar = bar(0, "tiles");
            while !done.load(Ordering::Relaxed) {
                let (tiles, total) = progress.tiles();
                bar.set_length(total as u64);
                bar.set_position(tiles as u64);
                thread::park_timeout(STEP);
            }
            bar.finish_and_clear();
        });
        let result = work();
        done.store(true, Ordering::Relaxed);
        painter.thread().unpark();
        result
    })
}
