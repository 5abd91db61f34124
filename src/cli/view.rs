//! `raybomb view`: a scene in a window.

use std::path::Path;

use super::args::WindowOptions;
use super::console::print;
use super::exit::{Failure, Outcome};
use super::load::{Source, is_stdin, renderer};
use crate::app::{self, AppError, AppOptions, Origin};
use crate::demo::{self, Demo};
use crate::scene::Scene;

/// Opens the scene file `path`, or without one the first of the built-in demos.
///
/// # Errors
/// Those of the scene, and no window to be had.
pub fn run(path: Option<&Path>, window: &WindowOptions) -> Outcome {
    if window.list_bindings {
        return list_bindings();
    }
    match (path, demo::all().first()) {
        (Some(path), _) => open_file(path, window),
        (None, Some(demo)) => open_demo(demo, window),
        (None, None) => Err(Failure::Failed("there are no built-in demos".to_owned())),
    }
}

fn open_file(path: &Path, window: &WindowOptions) -> Outcome {
    let source = Source::read(path)?;
    let scene = renderer(window.picture.machine.threads)?.install(|| source.parse())?;
    let origin = if is_stdin(path) {
        Origin::Text(source.text)
    } else {
        Origin::File(path.to_owned())
    };
    open(scene, origin, source.name, window)
}

/// Opens a built-in demo.
///
/// # Errors
/// No window to be had.
pub fn open_demo(demo: &'static Demo, window: &WindowOptions) -> Outcome {
    if window.list_bindings {
        return list_bindings();
    }
    let origin = Origin::Demo(demo);
    open(demo.scene(), origin, demo.title.to_owned(), window)
}

/// Prints the table of keys: chords, two blanks or more, words.
fn list_bindings() -> Outcome {
    let sheet = app::sheet();
    let width = sheet.iter().map(|(chords, _)| chords.len()).max();
    for (chords, says) in &sheet {
        print(format_args!(
            "{chords:width$}  {says}",
            width = width.unwrap_or(0)
        ))?;
    }
    Ok(())
}

fn open(scene: Scene, origin: Origin, name: String, window: &WindowOptions) -> Outcome {
    let picture = &window.picture;
    let options = AppOptions {
        scene,
        origin,
        name,
        size: picture.size.map(|size| (size.width, size.height)),
        settings: picture.settings(),
        threads: picture.machine.threads,
        timing: window.time.timing(),
        stretch: picture.stretch,
        pivot: picture.pivot,
        play: window.play,
        overlay: !window.no_overlay,
        print_picks: window.print_picks,
        play_actions: window.play_actions.clone(),
        record_actions: window.record_actions.clone(),
    };
    app::run(options).map_err(|e| match &e {
        AppError::NoWindow { .. } => Failure::NoWindow(e.to_string()),
        AppError::Broken { .. } => Failure::Failed(e.to_string()),
    })
}
