//! `raybomb demo`: the built-in scenes.

use std::path::Path;

use super::args::DemoArgs;
use super::config::Config;
use super::console::print;
use super::exit::{Failure, Outcome};
use super::shot::write_file;
use super::view;
use crate::demo::{self, Demo};
use crate::render::Progress;
use crate::scene;

/// Lists the demos, opens one or saves it.
///
/// # Errors
/// Usage: no such demo; and those of the file or the window.
pub fn run(args: &DemoArgs, config: &Config, progress: &Progress) -> Outcome {
    let Some(name) = &args.name else {
        return list();
    };
    let demo = find(name)?;
    match &args.write {
        Some(path) => save(demo, path, progress),
        None => view::open_demo(demo, &args.window, config),
    }
}

fn list() -> Outcome {
    let width = demo::all().iter().map(|d| d.name.len()).max().unwrap_or(0);
    for demo in demo::all() {
        print(format_args!(
            "{:width$}  {:>9} triangles  {}",
            demo.name, demo.triangles, demo.title
        ))?;
    }
    Ok(())
}

fn find(name: &str) -> Result<&'static Demo, Failure> {
    demo::all().iter().find(|d| d.name == name).ok_or_else(|| {
        let names: Vec<&str> = demo::all().iter().map(|d| d.name).collect();
        Failure::Usage(format!(
            "there is no demo {name:?}; there are {}",
            names.join(", ")
        ))
    })
}

fn save(demo: &Demo, path: &Path, progress: &Progress) -> Outcome {
    let scene = demo.scene();
    write_file(path, progress, |mut out| scene::write(&scene, &mut out))
}
