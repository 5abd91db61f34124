//! `raybomb view`: a scene in a window.

use std::path::Path;
use std::sync::Arc;

use super::args::WindowOptions;
use super::console::color;
use super::exit::{Failure, Outcome};
use super::load;
use crate::app::{self, AppError, AppOptions, LoadError, Source};
use crate::demo::{self, Demo};

/// Opens the scene file `path`, or the standard input for `-`.
///
/// # Errors
/// Those of the scene, and no window to be had.
pub fn open_file(path: &Path, window: &WindowOptions) -> Outcome {
    if !load::is_stdin(path) {
        return open(Source::File(path.to_owned()), window);
    }
    let load::Source { name, text } = load::Source::read(path)?;
    let text = Arc::new(text);
    open(Source::Text { name, text }, window)
}

/// Opens a built-in demo.
///
/// # Errors
/// No window to be had.
pub fn open_demo(demo: &'static Demo, window: &WindowOptions) -> Outcome {
    open(Source::Demo(demo), window)
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

fn open(source: Source, window: &WindowOptions) -> Outcome {
    let picture = &window.picture;
    let options = AppOptions {
        source: source.clone(),
        size: picture.size.map(|size| (size.width, size.height)),
        settings: picture.settings(),
        samples: picture.aa,
        target_fps: window.target_fps,
        threads: picture.machine.threads,
        timing: window.time.timing(),
        stretch: picture.stretch,
        pivot: picture.pivot,
        play: window.play,
        overlay: !window.no_overlay,
    };
    app::run(options).map_err(|e| match e {
        // The scene comes before the window: with a bad one, that is what is told.
        AppError::NoWindow { .. } => match source.scene() {
            Ok(_) => Failure::NoWindow(e.to_string()),
            Err(bad) => no_scene(&bad),
        },
        AppError::NoScene(bad) => no_scene(&bad),
        AppError::Broken { .. } => Failure::Failed(e.to_string()),
    })
}

fn no_scene(error: &LoadError) -> Failure {
    let words = error.words(color());
    match error {
        LoadError::Bad { .. } => Failure::BadScene(words),
        LoadError::Unreadable(_) | LoadError::Broken(_) => Failure::Failed(words),
    }
}
