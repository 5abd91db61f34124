//! `raybomb anim`: the operations as pictures, one a frame.

use std::fs;
use std::ops::RangeInclusive;
use std::path::Path;

use super::args::AnimArgs;
use super::console::{bar, print};
use super::exit::{Failure, Outcome};
use super::load::Stage;
use super::pattern::Pattern;
use super::shot::{Shooter, format_of};
use crate::export::Format;
use crate::render::Progress;

/// Renders the frames that `args` ask for, one after the other, each with all threads.
///
/// # Errors
/// Those of the arguments, the scene and the output files.
pub fn run(args: &AnimArgs, progress: &Progress) -> Outcome {
    let files = match &args.output {
        Some(pattern) => {
            let format = format_of(&pattern.file(0), args.picture.view, args.picture.aa)?;
            Some((pattern, format))
        }
        None => None,
    };
    let stage = Stage::load(&args.scene, &args.picture, &args.time)?;
    let frames = frames(args, stage.last_frame())?;
    shoot(&stage, frames, files, args.hash, progress)
}

fn shoot(
    stage: &Stage,
    frames: RangeInclusive<u64>,
    files: Option<(&Pattern, Format)>,
    hash: bool,
    progress: &Progress,
) -> Outcome {
    let mut shooter = Shooter::new(stage, progress);
    let bar = bar((frames.end() - frames.start()).saturating_add(1), "frames");
    for frame in frames {
        let path = files.map(|(pattern, _)| pattern.file(frame));
        if let Some(path) = &path {
            make_folder(path)?;
        }
        let file = path.as_deref().zip(files.map(|(_, format)| format));
        let hash = shooter.take(&stage.view_of_frame(frame), file, hash)?;
        bar.inc(1);
        if let Some(hash) = hash {
            bar.suspend(|| print(format_args!("{frame} {hash}")))?;
        }
    }
    bar.finish_and_clear();
    Ok(())
}

fn frames(args: &AnimArgs, last: u64) -> Result<RangeInclusive<u64>, Failure> {
    match &args.frames {
        None => Ok(0..=last),
        Some(frames) if *frames.end() <= last => Ok(frames.clone()),
        Some(frames) => Err(Failure::Usage(format!(
            "--frames {}..{} goes beyond the last frame, {last}",
            frames.start(),
            frames.end()
        ))),
    }
}

/// Makes the folders above `path` that are missing.
fn make_folder(path: &Path) -> Outcome {
    match path.parent() {
        Some(folder) if folder != Path::new("") => {
            fs::create_dir_all(folder).map_err(|e| Failure::file("make the folder", folder, &e))
        }
        _ => Ok(()),
    }
}
