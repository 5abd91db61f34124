//! The command line: arguments, files, exit codes.
//!
//! Data goes to the standard output, words to the error stream. Every command gives back an [`exit::Outcome`];
//! only [`main`] turns it into words and an exit code.

mod anim;
mod args;
mod bench;
mod check;
mod config;
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
use config::Config;
use exit::{Code, Failure, Outcome};

use crate::render::Progress;

/// Parses the arguments, does what they say, returns the exit code.
#[must_use]
pub fn main() -> ExitCode {
    match args::parse(&[]) {
        Ok(cli) => code_of(configured(cli)),
        Err(e) => told_by_clap(&e),
    }
}

/// Reads the settings, if it is a window that is asked for, and does what the arguments say.
fn configured(cli: Cli) -> Outcome {
    let Some(config) = cli.window().map(Config::load).transpose()? else {
        return started(&cli, &Config::default());
    };
    // They were right without the defaults, and those were tried one by one.
    let cli = args::parse(&config.defaults).unwrap_or(cli);
    started(&cli, &config)
}

fn started(cli: &Cli, config: &Config) -> Outcome {
    let progress = Arc::new(Progress::new());
    interrupt::watch(&progress)?;
    run(cli, config, &progress)
}

/// `--help` and `--version` come here too, with code 0; a closed output is no reason to fail.
fn told_by_clap(error: &clap::Error) -> ExitCode {
    let _ = error.print();
    ExitCode::from(if error.use_stderr() {
        Code::Usage
    } else {
        Code::Ok
    } as u8)
}

fn code_of(outcome: Outcome) -> ExitCode {
    match outcome {
        Ok(()) => ExitCode::from(Code::Ok as u8),
        Err(failure) => {
            let _ = write!(io::stderr().lock(), "{failure}");
            ExitCode::from(failure.code() as u8)
        }
    }
}

fn run(cli: &Cli, config: &Config, progress: &Progress) -> Outcome {
    match &cli.command {
        None => match cli.scene.as_deref().and_then(args::misspelt) {
            Some(told) => Err(Failure::Usage(told)),
            None => view::run(cli.scene.as_deref(), &cli.window, config),
        },
        Some(Command::View(args)) => view::run(args.scene.as_deref(), &args.window, config),
        Some(Command::Render(args)) => render::run(args, progress),
        Some(Command::Anim(args)) => anim::run(args, progress),
        Some(Command::Check(args)) => check::run(args),
        Some(Command::Info(args)) => info::run(args),
        Some(Command::Bench(args)) => bench::run(args, progress),
        Some(Command::Demo(args)) => demo::run(args, config, progress),
    }
}
