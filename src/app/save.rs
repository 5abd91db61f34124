//! Scenes with the hand's moves, as files: whole or not at all, and every byte of the triangles as it was.

use std::fs;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Sender, channel};
use std::thread::{self, JoinHandle};
use std::time::SystemTime;

use super::loader::{Source, why_not};
use super::painter::message_of;
use super::state::Document;
use crate::export::{write_new, write_whole};
use crate::scene;

/// What was written.
#[derive(Debug)]
pub struct Saved {
    /// The file.
    pub path: PathBuf,
    /// All of it.
    pub text: Vec<u8>,
    /// The text that the moves were put into.
    pub from: Option<Stamp>,
}

/// Tells a file that was changed from what it was, without reading it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stamp {
    bytes: u64,
    modified: Option<SystemTime>,
}

impl Stamp {
    /// The file as it is now; `None` where there is none.
    #[must_use]
    pub fn of(source: &Source) -> Option<Stamp> {
        let Source::File(path) = source else {
            return None;
        };
        let now = fs::metadata(path).ok()?;
        Some(Stamp {
            bytes: now.len(),
            modified: now.modified().ok(),
        })
    }
}

/// Writes `document` to the scene's own file, or where there is none or a new name is wanted, to
/// `NAME-0001.txt` and so on beside it or in the current folder. Returns what is in which file.
///
/// # Errors
/// When the text cannot be read or is no scene any more, and when the file cannot be written.
pub fn save(source: &Source, document: &Document) -> io::Result<Saved> {
    let text = match source {
        Source::File(path) => fs::read(path).map_err(naming("cannot read ", path))?,
        Source::Text { text, .. } => text.to_vec(),
        Source::Demo(demo) => {
            let mut text = Vec::new();
            scene::write(&demo.scene(), &mut text)?;
            text
        }
    };
    let from = Stamp::of(source);
    let text = scene::with_moves(&text, document.camera, &document.operations)?;
    let (folder, stem) = match source {
        Source::File(path) if !document.new_name => {
            write_whole(path, |out| out.write_all(&text)).map_err(naming("", path))?;
            let path = path.clone();
            return Ok(Saved { path, text, from });
        }
        Source::File(path) => (
            path.parent()
                .filter(|p| *p != Path::new(""))
                .unwrap_or(Path::new(".")),
            path.file_stem()
                .map_or("scene".into(), |s| s.to_string_lossy()),
        ),
        Source::Text { .. } => (Path::new("."), "scene".into()),
        Source::Demo(demo) => (Path::new("."), demo.name.into()),
    };
    let stem = unnumbered(&stem);
    let names = (1..=9999).map(|number| format!("{stem}-{number:04}.txt"));
    let saved = write_new(folder, names, |out| out.write_all(&text))?;
    let name = saved.ok_or_else(|| {
        let text = format!("{stem}-0001.txt to {stem}-9999.txt are all there already");
        io::Error::new(io::ErrorKind::AlreadyExists, text)
    })?;
    let here = folder == Path::new(".");
    let path = if here { name.into() } else { folder.join(name) };
    Ok(Saved { path, text, from })
}

/// Errors with the file in their words, after `what`.
fn naming(what: &str, path: &Path) -> impl Fn(io::Error) -> io::Error {
    let file = format!("{what}{}", path.display());
    move |e| io::Error::new(e.kind(), format!("{file}: {}", why_not(&e)))
}

/// A scene to save.
#[derive(Debug)]
pub struct Job {
    /// The number of the scene.
    pub opened: u64,
    /// Where it comes from, or was saved last as far as is known.
    pub origin: Source,
    /// What to write.
    pub document: Document,
}

/// Saves scenes one after the other, on a thread of its own: the last one is what a file has in the end, and one that follows
/// on a new name goes to the new file.
#[derive(Debug)]
pub struct Saver {
    jobs: Option<Sender<Job>>,
    thread: Option<JoinHandle<()>>,
}

impl Saver {
    /// `tell` is called by its thread, with each job that is done.
    ///
    /// # Errors
    /// When the system gives no thread.
    pub fn start(tell: impl Fn(Job, io::Result<Saved>) + Send + 'static) -> io::Result<Saver> {
        let (jobs, to_do) = channel::<Job>();
        let work = move || {
            let mut last: Option<(u64, PathBuf)> = None;
            for job in to_do {
                let origin = match &last {
                    Some((opened, path)) if *opened == job.opened => Source::File(path.clone()),
                    _ => job.origin.clone(),
                };
                let result = catch_unwind(AssertUnwindSafe(|| save(&origin, &job.document)))
                    .unwrap_or_else(|panic| Err(io::Error::other(message_of(&*panic))));
                if let Ok(saved) = &result {
                    last = Some((job.opened, saved.path.clone()));
                }
                tell(job, result);
            }
        };
        let thread = thread::Builder::new().name("saver".into()).spawn(work)?;
        Ok(Saver {
            jobs: Some(jobs),
            thread: Some(thread),
        })
    }

    /// Will save.
    pub fn save(&self, job: Job) {
        // Its thread ends with it, not before.
        if let Some(jobs) = &self.jobs {
            let _ = jobs.send(job);
        }
    }

    /// Waits until everything is saved; nothing can be saved afterwards.
    pub fn finish(&mut self) {
        self.jobs = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// The name without the number that a save under a new name gave it: the next one counts on. From 1000 on it may be a
/// year.
fn unnumbered(stem: &str) -> &str {
    match stem.rsplit_once('-') {
        Some((name, number))
            if !name.is_empty()
                && number.len() == 4
                && number.starts_with('0')
                && number.bytes().all(|b| b.is_ascii_digit()) =>
        {
            name
        }
        _ => stem,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::moves::Moves;
    use crate::scene::{Axis, CameraSetting, Operation};

    const TEXT: &str = "<d\n0 0 -1\n1 # one\n0 0 0  1 0 0  0 1 0  1 2 3";

    fn document(new_name: bool) -> Document {
        let (axis, angle_rad) = (Axis::X, 0.25);
        Document {
            camera: CameraSetting::Default,
            operations: vec![Operation { axis, angle_rad }],
            new_name,
            moves: Moves::default().to_write(true),
        }
    }

    #[test]
    fn the_files_own_text_stays_and_a_new_name_leaves_it_alone() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.b.txt");
        fs::write(&path, TEXT).expect("written");
        let expected = format!("{TEXT}\n<o\n1\n<x 0.25\n");
        let source = Source::File(path.clone());
        let saved = save(&source, &document(true)).expect("saved");
        assert_eq!(saved.text, expected.as_bytes());
        let new = saved.path;
        assert_eq!(new, folder.path().join("a.b-0001.txt"));
        assert_eq!(fs::read_to_string(&new).expect("read"), expected);
        assert_eq!(fs::read_to_string(&path).expect("read"), TEXT);
        let again = save(&Source::File(new), &document(true)).expect("saved");
        assert_eq!(again.path, folder.path().join("a.b-0002.txt"));
        let saved = save(&source, &document(false)).expect("saved");
        assert_eq!(saved.path, path);
        assert_eq!(fs::read_to_string(&path).expect("read"), expected);
    }

    #[test]
    fn saves_come_one_after_the_other_and_follow_a_new_name() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.txt");
        fs::write(&path, TEXT).expect("written");
        let (send, done) = channel();
        let mut saver = Saver::start(move |job, result| {
            let path = result.map(|saved| saved.path);
            let _ = send.send((job.opened, path.map_err(|e| e.to_string())));
        })
        .expect("a thread");
        // Nobody waits for what the one before says.
        for (opened, new_name) in [(1, true), (1, false), (2, false), (1, true)] {
            saver.save(Job {
                opened,
                origin: Source::File(path.clone()),
                document: document(new_name),
            });
        }
        saver.finish();
        let names = done.iter().map(|(opened, path)| {
            let path = path.expect("saved");
            (
                opened,
                path.file_name().map(|n| n.to_owned()).expect("a name"),
            )
        });
        let expected = [
            (1, "a-0001.txt"),
            (1, "a-0001.txt"),
            (2, "a.txt"),
            (1, "a-0002.txt"),
        ];
        assert_eq!(
            names.collect::<Vec<_>>(),
            expected.map(|(n, name)| (n, name.into()))
        );
    }

    #[test]
    fn only_our_own_numbers_are_left_out_of_a_new_name() {
        assert_eq!(unnumbered("gears-0012"), "gears");
        for own in ["gears", "gears-12", "gears-001a", "gears-2026", "-0001"] {
            assert_eq!(unnumbered(own), own);
        }
    }

    #[test]
    fn a_file_that_is_gone_or_broken_is_an_error_and_stays_as_it_is() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.txt");
        let source = Source::File(path.clone());
        let error = save(&source, &document(false)).expect_err("no file");
        let words = format!("cannot read {}: no such file", path.display());
        assert_eq!(error.to_string(), words);
        fs::write(&path, "<d 0 0").expect("written");
        let error = save(&source, &document(false)).expect_err("no scene");
        assert!(error.to_string().starts_with("it is no scene any more: 1:"));
        assert_eq!(fs::read_to_string(&path).expect("read"), "<d 0 0");
    }
}
