//! `raybomb view`: a scene in a window.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::args::WindowOptions;
use super::config::Config;
use super::console::{color, print};
use super::exit::{Failure, Outcome};
use super::load;
use crate::app::{self, AppError, AppOptions, LoadError, Source, folders};
use crate::demo::{self, Demo};

/// Opens the scene file `path` (the standard input for `-`), or without one the first of the built-in demos.
///
/// # Errors
/// Those of the scene, and no window to be had.
pub fn run(path: Option<&Path>, window: &WindowOptions, config: &Config) -> Outcome {
    if window.list_bindings {
        return print(config.keymap.listing().trim_end());
    }
    match (path, demo::all().first()) {
        (Some(path), _) => open_file(path, window, config),
        (None, Some(demo)) => open_demo(demo, window, config),
        (None, None) => Err(Failure::Failed("there are no built-in demos".to_owned())),
    }
}

fn open_file(path: &Path, window: &WindowOptions, config: &Config) -> Outcome {
    if !load::is_stdin(path) {
        return open(Source::File(path.to_owned()), window, config);
    }
    let load::Source { name, text } = load::Source::read(path)?;
    let text = Arc::new(text);
    open(Source::Text { name, text }, window, config)
}

/// Opens a built-in demo.
///
/// # Errors
/// No window to be had.
pub fn open_demo(demo: &'static Demo, window: &WindowOptions, config: &Config) -> Outcome {
    if window.list_bindings {
        return print(config.keymap.listing().trim_end());
    }
    open(Source::Demo(demo), window, config)
}

fn open(source: Source, window: &WindowOptions, config: &Config) -> Outcome {
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
        print_picks: window.print_picks,
        memory: memory(window),
        keymap: config.keymap.clone(),
        play_actions: window.play_actions.clone(),
        record_actions: window.record_actions.clone(),
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

/// The folder to remember things in. Sessions that are played, or will be, begin alike everywhere.
fn memory(window: &WindowOptions) -> Option<PathBuf> {
    let is_session = window.play_actions.is_some() || window.record_actions.is_some();
    let leaves_traces = !window.no_config && !is_session;
    leaves_traces.then(|| folders::state_folder(|name| std::env::var_os(name)))?
}

fn no_scene(error: &LoadError) -> Failure {
    let words = error.words(color());
    match error {
        LoadError::Bad { .. } => Failure::BadScene(words),
        LoadError::Unreadable(_) | LoadError::Broken(_) => Failure::Failed(words),
    }
}
