//! One picture or array: what has to be computed for it, and into which file it goes.

use std::io::{self, Write};
use std::path::Path;

use super::exit::{Failure, Outcome};
use super::load::Stage;
use crate::camera::View;
use crate::export::{Contents, Format, is_regular, picture_hash, write_whole};
use crate::frame::{Frame, Hits};
use crate::render::{Progress, Refinement, Samples, ViewMode};

/// The format that the name of an output file asks for.
///
/// # Errors
/// Usage: an extension that is none of ours, or `.npy` for a view that has no numbers, or whose numbers have no mean.
pub fn format_of(path: &Path, mode: ViewMode, samples: Samples) -> Result<Format, Failure> {
    let path = target(path);
    let known = || {
        Format::ALL
            .map(|f| format!(".{}", f.extension()))
            .join(", ")
    };
    let format = match Format::of_path(path) {
        Some(format) => format,
        None if path.extension().is_none() && !is_regular(path) => Format::Bmp,
        None => {
            return Err(Failure::Usage(format!(
                "cannot tell the format of {}: its extension must be one of {}",
                path.display(),
                known()
            )));
        }
    };
    if format == Format::Npy && mode == ViewMode::Cost {
        return Err(Failure::Usage(
            ".npy files hold the views id, depth, normal and shaded, not cost".to_owned(),
        ));
    }
    if format == Format::Npy && mode != ViewMode::Shaded && samples != Samples::ONE {
        return Err(Failure::Usage(
            "--aa is for colours: the numbers in .npy files have one sample a pixel".to_owned(),
        ));
    }
    Ok(format)
}

/// Takes pictures, one after the other, into the same memory.
#[derive(Debug)]
pub struct Shooter<'a> {
    stage: &'a Stage,
    progress: &'a Progress,
    frame: Frame,
    hits: Hits,
    refinement: Refinement,
}

impl<'a> Shooter<'a> {
    /// Nothing taken yet.
    #[must_use]
    pub fn new(stage: &'a Stage, progress: &'a Progress) -> Shooter<'a> {
        Shooter {
            stage,
            progress,
            frame: Frame::default(),
            hits: Hits::default(),
            refinement: Refinement::default(),
        }
    }

    /// Renders what `view` sees, writes it to `file` if there is one, and gives the picture's hash if `hash`.
    ///
    /// # Errors
    /// When the file cannot be written, and when the user has stopped it.
    pub fn take(
        &mut self,
        view: &View,
        file: Option<(&Path, Format)>,
        hash: bool,
    ) -> Result<Option<String>, Failure> {
        let Stage {
            scene,
            world,
            renderer,
            settings,
            samples,
            ..
        } = self.stage;
        let numbers = file
            .is_some_and(|(_, format)| format == Format::Npy && settings.mode != ViewMode::Shaded);
        if numbers {
            let (engine, kernel) = (settings.engine, settings.kernel);
            renderer.hits(world, view, engine, kernel, &mut self.hits, self.progress)?;
        }
        if hash || !numbers {
            self.refinement.restart();
            self.refinement.picture(
                renderer,
                world,
                view,
                settings,
                *samples,
                &mut self.frame,
                self.progress,
            )?;
        }
        if let Some((path, format)) = file {
            let contents = match (numbers, settings.mode) {
                (true, ViewMode::Id) => Contents::Ids(&self.hits),
                (true, ViewMode::Depth) => Contents::Depth(&self.hits, view),
                (true, ViewMode::Normal) => Contents::Normals(&self.hits, view, &scene.triangles),
                _ => Contents::Picture(&self.frame),
            };
            save(path, format, contents, self.progress)?;
        }
        Ok(hash.then(|| picture_hash(&self.frame)))
    }
}

/// Writes `contents` to `path`, whole or not at all.
fn save(path: &Path, format: Format, contents: Contents<'_>, progress: &Progress) -> Outcome {
    write_file(path, progress, |out| contents.write(format, out))
}

/// Writes a file, whole or not at all, until `progress` is cancelled.
///
/// # Errors
/// When it cannot be written, and when the user has stopped it.
pub fn write_file(
    path: &Path,
    progress: &Progress,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Outcome {
    let result = write_whole(target(path), |out| {
        write(&mut Cancellable { out, progress })
    });
    match result {
        Ok(()) => Ok(()),
        Err(_) if progress.is_cancelled() => Err(Failure::Interrupted),
        Err(e) if e.kind() == io::ErrorKind::BrokenPipe && is_stdout(path) => {
            Err(Failure::OutputClosed)
        }
        Err(e) => Err(Failure::file("write", path, &e)),
    }
}

/// The standard output by the name that [`write_whole`] knows.
const STDOUT: &str = "/dev/stdout";

/// True for `-` and what it stands for.
#[must_use]
pub fn is_stdout(path: &Path) -> bool {
    target(path) == Path::new(STDOUT)
}

/// `-` is the standard output.
fn target(path: &Path) -> &Path {
    if path == Path::new("-") {
        Path::new(STDOUT)
    } else {
        path
    }
}

/// A writer that fails as soon as the user wants to stop.
struct Cancellable<'a> {
    out: &'a mut dyn Write,
    progress: &'a Progress,
}

impl Write for Cancellable<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.progress.is_cancelled() {
            // Not `Interrupted`: that one means "try again".
            return Err(io::Error::other("stopped"));
        }
        self.out.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}
