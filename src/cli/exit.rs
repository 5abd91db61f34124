//! How the program ends: one table of exit codes, and the failures that lead to them.

use std::fmt::{self, Write as _};
use std::path::Path;

use crate::render::Cancelled;

/// Why the program ends, as scripts see it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Code {
    /// Done.
    Ok = 0,
    /// A file, a folder or the system stood in the way.
    Failed = 1,
    /// The arguments make no sense.
    Usage = 2,
    /// The scene file is not one.
    BadScene = 3,
    /// No window to be had.
    NoWindow = 4,
    /// Two pictures that must be equal are not.
    Differs = 5,
    /// Stopped by Ctrl+C, SIGTERM or SIGHUP.
    Interrupted = 130,
}

/// Every exit code with its meaning, as `--help` shows it.
const TABLE: [(Code, &str); 7] = [
    (Code::Ok, "done"),
    (
        Code::Failed,
        "failed: missing file, folder instead of a file, disk full, ...",
    ),
    (Code::Usage, "usage: arguments that make no sense"),
    (Code::BadScene, "bad scene: the text is not a scene"),
    (Code::NoWindow, "no window to be had"),
    (Code::Differs, "a hash or picture differs that must not"),
    (Code::Interrupted, "stopped by Ctrl+C"),
];

/// The table as text for the end of `--help`.
#[must_use]
pub fn help_table() -> String {
    TABLE
        .iter()
        .fold("Exit codes:".to_owned(), |mut text, (code, meaning)| {
            write!(text, "\n  {:>3}  {meaning}", *code as u8).expect("a String takes any text");
            text
        })
}

/// What went wrong; [`fmt::Display`] gives the text for the standard error stream.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Failure {
    /// [`Code::Failed`]
    Failed(String),
    /// [`Code::Usage`]
    Usage(String),
    /// [`Code::BadScene`]; the whole text, which begins with the place of the first problem.
    BadScene(String),
    /// [`Code::NoWindow`]
    NoWindow(String),
    /// [`Code::Differs`]
    Differs(String),
    /// [`Code::Interrupted`]
    Interrupted,
    /// Whoever read our standard output has gone: nothing to tell.
    OutputClosed,
}

/// What every command gives back.
pub type Outcome = Result<(), Failure>;

impl Failure {
    /// `cannot DO PATH: WHY`, a failure of the file system.
    #[must_use]
    pub fn file(action: &str, path: &Path, why: &dyn fmt::Display) -> Failure {
        Failure::Failed(format!("cannot {action} {}: {why}", path.display()))
    }

    /// The exit code.
    #[must_use]
    pub fn code(&self) -> Code {
        match self {
            Failure::Failed(_) | Failure::OutputClosed => Code::Failed,
            Failure::Usage(_) => Code::Usage,
            Failure::BadScene(_) => Code::BadScene,
            Failure::NoWindow(_) => Code::NoWindow,
            Failure::Differs(_) => Code::Differs,
            Failure::Interrupted => Code::Interrupted,
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Failure::Failed(text) | Failure::NoWindow(text) | Failure::Differs(text) => {
                writeln!(f, "error: {text}")
            }
            Failure::Usage(text) => {
                writeln!(f, "error: {text}\n\nFor more information, try '--help'.")
            }
            Failure::BadScene(text) => writeln!(f, "{}", text.trim_end()),
            Failure::Interrupted => writeln!(f, "stopped"),
            Failure::OutputClosed => Ok(()),
        }
    }
}

impl From<Cancelled> for Failure {
    fn from(_: Cancelled) -> Failure {
        Failure::Interrupted
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_has_every_code_that_a_failure_can_have() {
        let text = String::new;
        let failures = [
            Failure::Failed(text()),
            Failure::Usage(text()),
            Failure::BadScene(text()),
            Failure::NoWindow(text()),
            Failure::Differs(text()),
            Failure::Interrupted,
        ];
        for failure in failures {
            assert!(TABLE.iter().any(|(code, _)| *code == failure.code()));
        }
        assert!(help_table().contains("\n  130  stopped"));
    }
}
