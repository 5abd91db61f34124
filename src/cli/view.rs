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
    if window.kiosk.is_some() && path.is_none() {
        return open(None, window, config);
    }
    match (path, demo::all().first()) {
        (Some(path), _) => open_file(path, window, config),
        (None, Some(demo)) => open_demo(demo, window, config),
        (None, None) => Err(Failure::Failed("there are no built-in demos".to_owned())),
    }
}

fn open_file(path: &Path, window: &WindowOptions, config: &Config) -> Outcome {
    if !load::is_stdin(path) {
        return open(Some(Source::File(path.to_owned())), window, config);
    }
    let load::Source { name, text } = load::Source::read(path)?;
    let text = Arc::new(text);
    open(Some(Source::Text { name, text }), window, config)
}

/// Opens a built-in demo.
///
/// # Errors
/// No window to be had.
pub fn open_demo(demo: &'static Demo, window: &WindowOptions, config: &Config) -> Outcome {
    if window.list_bindings {
        return print(config.keymap.listing().trim_end());
    }
    open(Some(Source::Demo(demo)), window, config)
}

/// What a kiosk shows: `first`, then what is named, or else all demos.
fn round(first: Option<Source>, names: &[PathBuf]) -> Result<Vec<Source>, Failure> {
    let mut sources: Vec<Source> = first.into_iter().collect();
    for name in names {
        let demo = demo::all().iter().find(|d| name == Path::new(d.name));
        match demo {
            Some(demo) if !name.exists() => sources.push(Source::Demo(demo)),
            _ if name.is_dir() => {
                let scenes = app::scenes_in(name).map_err(|e| Failure::file("read", name, &e))?;
                sources.extend(scenes.into_iter().map(Source::File));
            }
            _ => sources.push(Source::File(name.clone())),
        }
    }
    if sources.is_empty() && !names.is_empty() {
        return Err(Failure::Failed("no scene in these folders".to_owned()));
    }
    if sources.is_empty() {
        sources.extend(demo::all().iter().map(Source::Demo));
    }
    Ok(sources)
}

/// Opens the window; there is a `source`, or a kiosk.
fn open(source: Option<Source>, window: &WindowOptions, config: &Config) -> Outcome {
    let picture = &window.picture;
    let kiosk = match &window.kiosk {
        Some(names) => Some(round(source.clone(), names)?),
        None => None,
    };
    let first = kiosk.as_ref().and_then(|sources| sources.first().cloned());
    let source = source.or(first).expect("a scene or a round of them");
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
        kiosk,
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
