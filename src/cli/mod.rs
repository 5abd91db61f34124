//! The command line: arguments, files, exit codes.
//!
//! Data goes to the standard output, words to the error stream. Every command gives back an [`exit::Outcome`];
//! only [`main`] turns it into words and an exit code.

mod anim;
mod args;
mod bench;
mod check;
mod console;
mod demo;
mod exit;
mod info;
mod interrupt;
mod load;
mod pattern;
mod render;
mod shot;
mod values;
mod view;

use std::io::{self, Write};
use std::process::ExitCode;
use std::sync::Arc;

use args::{Cli, Command};
use exit::{Code, Outcome};

use crate::render::Progress;

/// Parses the arguments, does what they say, returns the exit code.
#[must_use]
pub fn main() -> ExitCode {
    let cli = match args::parse() {
        Ok(cli) => cli,
        Err(e) => {
            // `--help` and `--version` come here too, with code 0; a closed output is no reason to fail.
            let _ = e.print();
            return ExitCode::from(if e.use_stderr() {
                Code::Usage
            } else {
                Code::Ok
            } as u8);
        }
    };
    let progress = Arc::new(Progress::new());
    let outcome = interrupt::watch(&progress).and_then(|()| run(&cli, &progress));
    match outcome {
        Ok(()) => ExitCode::from(Code::Ok as u8),
        Err(failure) => {
            let _ = write!(io::stderr().lock(), "{failure}");
            ExitCode::from(failure.code() as u8)
        }
    }
}

fn run(cli: &Cli, progress: &Progress) -> Outcome {
    match &cli.command {
        None => view::run(cli.scene.as_deref(), &cli.window),
        Some(Command::View(args)) => view::run(args.scene.as_deref(), &args.window),
        Some(Command::Render(args)) => render::run(args, progress),
        Some(Command::Anim(args)) => anim::run(args, progress),
        Some(Command::Check(args)) => check::run(args),
        Some(Command::Info(args)) => info::run(args),
        Some(Command::Bench(args)) => bench::run(args, progress),
        Some(Command::Demo(args)) => demo::run(args, progress),
    }
}
