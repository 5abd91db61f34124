//! `raybomb render`: one picture.

use std::path::Path;

use super::args::RenderArgs;
use super::console::{print, with_tile_bar};
use super::exit::{Failure, Outcome};
use super::load::Stage;
use super::shot::{Shooter, format_of, is_stdout};
use crate::camera::{Camera, View};
use crate::render::Progress;

/// What the original called its picture.
const DEFAULT_OUTPUT: &str = "data.bmp";

/// Renders the picture that `args` ask for.
///
/// # Errors
/// Those of the arguments, the scene and the output file.
pub fn run(args: &RenderArgs, progress: &Progress) -> Outcome {
    if args.hash && args.output.as_deref().is_some_and(is_stdout) {
        return Err(Failure::Usage(
            "--output and --hash both go to the standard output: name a file for the picture"
                .to_owned(),
        ));
    }
    let default_output = (!args.hash).then_some(Path::new(DEFAULT_OUTPUT));
    let file = match args.output.as_deref().or(default_output) {
        Some(path) => Some((path, format_of(path, args.picture.view, args.picture.aa)?)),
        None => None,
    };
    let stage = Stage::load(&args.scene, &args.picture, &args.time)?;
    let view = view(args, &stage)?;
    let mut shooter = Shooter::new(&stage, progress);
    match with_tile_bar(progress, || shooter.take(&view, file, args.hash))? {
        Some(hash) => print(hash),
        None => Ok(()),
    }
}

fn view(args: &RenderArgs, stage: &Stage) -> Result<View, Failure> {
    if let Some(corners) = args.camera {
        let camera = Camera::from(corners);
        return Ok(stage.view(camera, camera));
    }
    let last = stage.last_frame();
    match args.frame {
        Some(frame) if frame > last => Err(Failure::Usage(format!(
            "--frame {frame} is beyond the last frame, {last}"
        ))),
        frame => Ok(stage.view_of_frame(frame.unwrap_or(last))),
    }
}
