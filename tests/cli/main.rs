//! The command line, by the real program: what scripts rely on.

mod commands;
mod config;
mod docs;
mod exit_codes;
mod files;
mod help;
#[cfg(unix)]
mod interrupt;
mod support;
