//! `raybomb view`: a scene in a window.

use std::path::Path;

use super::args::WindowOptions;
use super::exit::{Failure, Outcome};
use super::load::{Source, renderer};
use crate::app::{self, AppError, AppOptions};
use crate::demo::{self, Demo};
use crate::scene::Scene;

/// Opens the scene file `path`.
///
/// # Errors
/// Those of the scene, and no window to be had.
pub fn open_file(path: &Path, window: &WindowOptions) -> Outcome {
    let source = Source::read(path)?;
    let scene = renderer(window.picture.machine.threads)?.install(|| source.parse())?;
    open(scene, source.name, window)
}

/// Opens a built-in demo.
///
/// # Errors
/// No window to be had.
pub fn open_demo(demo: &Demo, window: &WindowOptions) -> Outcome {
    open(demo.scene(), demo.title.to_owned(), window)
}

/// Opens the first of the built-in demos.
///
/// # Errors
/// No window to be had.
pub fn open_default(window: &WindowOptions) -> Outcome {
    match demo::all().first() {
        Some(demo) => open_demo(demo, window),
        None => Err(Failure::Failed("there are no built-in demos".to_owned())),
    }
}

fn open(scene: Scene, name: String, window: &WindowOptions) -> Outcome {
    let picture = &window.picture;
    let options = AppOptions {
        scene,
        name,
        size: picture.size.map(|size| (size.width, size.height)),
        settings: picture.settings(),
        threads: picture.machine.threads,
        timing: window.time.timing(),
        stretch: picture.stretch,
        pivot: picture.pivot,
        play: window.play,
        overlay: !window.no_overlay,
    };
    app::run(options).map_err(|e| match &e {
        AppError::NoWindow { .. } => Failure::NoWindow(e.to_string()),
        AppError::Broken { .. } => Failure::Failed(e.to_string()),
    })
}
