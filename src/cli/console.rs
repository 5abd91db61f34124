//! What the program prints: data to the standard output, words and progress to the standard error stream.

use std::env;
use std::ffi::OsString;
use std::fmt::Display;
use std::io::{self, IsTerminal, Write};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

use super::exit::{Failure, Outcome};
use crate::render::Progress;
use crate::watch::Watch;

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

/// `1 triangle`, `2 triangles`.
pub fn counted(n: usize, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}

/// Ends the line of a bar that may be on the terminal.
pub fn leave_bar() {
    if io::stderr().is_terminal() {
        say("");
    }
}

/// True when words may be coloured.
#[must_use]
pub fn color() -> bool {
    io::stderr().is_terminal() && takes_color(|name| env::var_os(name).unwrap_or_default())
}

/// True for a terminal that knows how, unless somebody forbids it; `variable` is empty for those that are not set.
fn takes_color(variable: impl Fn(&str) -> OsString) -> bool {
    variable("NO_COLOR").is_empty() && variable("TERM") != "dumb"
}

/// What a bar of steps looks like, and one of a part of something.
const STEPS: &str = "{msg} {wide_bar} {pos}/{len}  {eta} left";
const PART: &str = "{msg} {wide_bar} {percent} %";

/// A bar of `total` steps on a terminal, nothing elsewhere.
#[must_use]
pub fn bar(total: u64, what: &str) -> ProgressBar {
    styled_bar(STEPS, total, what)
}

fn styled_bar(template: &str, total: u64, what: &str) -> ProgressBar {
    let style = ProgressStyle::with_template(template).expect("the template is well-formed");
    let total_known = Some(total);
    // Hidden by itself where the error stream is no terminal.
    ProgressBar::with_draw_target(total_known, indicatif::ProgressDrawTarget::stderr())
        .with_style(style)
        .with_message(what.to_owned())
}

/// Does `work`; a picture that takes more than a moment gets a bar of its tiles on a terminal.
pub fn with_tile_bar<R>(progress: &Progress, work: impl FnOnce() -> R) -> R {
    with_bar(STEPS, "tiles", || progress.tiles(), work)
}

/// Does `work`, which tells any of its threads' counts of what is done and of all there is; when it takes more than a
/// moment it gets a bar on a terminal.
pub fn with_part_bar<R>(what: &str, work: impl FnOnce(Watch<'_>) -> R) -> R {
    let (done, total) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let tell = |now: usize, of: usize| {
        done.fetch_max(now, Ordering::Relaxed);
        total.store(of, Ordering::Relaxed);
    };
    let counts = || (done.load(Ordering::Relaxed), total.load(Ordering::Relaxed));
    with_bar(PART, what, counts, || work(Watch::of(&tell)))
}

fn with_bar<R>(
    template: &str,
    what: &str,
    counts: impl Fn() -> (usize, usize) + Sync,
    work: impl FnOnce() -> R,
) -> R {
    const STEP: Duration = Duration::from_millis(50);
    if !io::stderr().is_terminal() {
        return work();
    }
    let done = AtomicBool::new(false);
    thread::scope(|scope| {
        let painter = scope.spawn(|| {
            thread::park_timeout(STEP * 10);
            let bar = styled_bar(template, 0, what);
            while !done.load(Ordering::Relaxed) {
                let (now, total) = counts();
                // As long as that is not known, nothing is done.
                bar.set_length(total.max(1) as u64);
                bar.set_position(now as u64);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_can_be_forbidden_and_are_not_for_dumb_terminals() {
        let taken = |forbidden: &str, terminal: &str| {
            takes_color(|name| if name == "TERM" { terminal } else { forbidden }.into())
        };
        assert!(taken("", "xterm") && taken("", ""));
        assert!(!taken("1", "xterm") && !taken("", "dumb"));
    }
}
