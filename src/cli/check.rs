//! `raybomb check`: every problem of a scene file with its place.

use super::args::CheckArgs;
use super::console::{color, counted, print, say};
use super::exit::Outcome;
use super::load::{Source, parse, renderer};
use crate::geometry::is_degenerate;
use crate::scene::{ParseErrors, Scene, Severity, annotate, locate_triangles};

/// So many warnings are told unless all are asked for: as many as errors.
const MAX_WARNINGS: usize = ParseErrors::MAX;

/// Checks the file: errors and warnings go to the error stream, a summary of a good file to the standard output.
///
/// # Errors
/// Those of the file and of its text; warnings are none.
pub fn run(args: &CheckArgs) -> Outcome {
    let renderer = renderer(0)?;
    let source = Source::read(&args.scene)?;
    let scene = parse(&renderer, &source)?;
    let most = if args.all_warnings {
        usize::MAX
    } else {
        MAX_WARNINGS
    };
    let warnings = warn_of_degenerate(&source, &scene, most);
    let (triangles, operations) = (scene.triangles.len(), scene.operations.len());
    print(format_args!(
        "{}: no errors, {}, {}, {}",
        source.name,
        counted(warnings, "warning"),
        counted(triangles, "triangle"),
        counted(operations, "operation"),
    ))
}

/// Points at the first `most` triangles without area and counts all of them.
fn warn_of_degenerate(source: &Source, scene: &Scene, most: usize) -> usize {
    let degenerate = |id: &usize| is_degenerate(&scene.triangles[*id].corners);
    let ids: Vec<usize> = (0..scene.triangles.len()).filter(degenerate).collect();
    let places = locate_triangles(&source.text, ids.iter().copied().take(most));
    for (id, place) in ids.iter().zip(&places) {
        let message = format!("warning: triangle {id} has no area and is never hit");
        let (name, text) = (&source.name, &source.text);
        say(annotate(
            Severity::Warning,
            name,
            text,
            place,
            &message,
            None,
            color(),
        ));
    }
    let others = ids.len() - places.len();
    if others > 0 {
        say(format_args!(
            "… and {others} more without area (--all-warnings points at each)"
        ));
    }
    ids.len()
}
