//! `raybomb view`: a scene in a window.

use std::path::Path;

use super::args::WindowOptions;
use super::exit::{Failure, Outcome};
use super::load::Source;
use crate::demo::{self, Demo};

/// Until the window is there.
const NO_WINDOW: &str = "there is no window yet; raybomb render writes pictures";

/// Opens the scene file `path`.
///
/// # Errors
/// Those of the scene, and no window to be had.
pub fn open_file(path: &Path, window: &WindowOptions) -> Outcome {
    let _ = window;
    Source::read(path)?.parse()?;
    Err(Failure::NoWindow(NO_WINDOW.to_owned()))
}

/// Opens a built-in demo.
///
/// # Errors
/// No window to be had.
pub fn open_demo(demo: &Demo) -> Outcome {
    let _ = demo;
    Err(Failure::NoWindow(NO_WINDOW.to_owned()))
}

/// Opens the first of the built-in demos.
///
/// # Errors
/// No window to be had.
pub fn open_default(window: &WindowOptions) -> Outcome {
    let _ = window;
    match demo::all().first() {
        Some(demo) => open_demo(demo),
        None => Err(Failure::Failed("there are no built-in demos".to_owned())),
    }
}
