//! The command line.

use std::process::ExitCode;

/// Parses the arguments, does what they say, returns the exit code.
#[must_use]
pub fn main() -> ExitCode {
    ExitCode::SUCCESS
}
