//! A journal of moves: what the hand did and no file has yet outlives a crash, and a display server that goes away.
//!
//! Each finished move is a line at the end of a file in the folder of remembered things; the file goes when nothing is
//! left to lose. Its name tells what the moves rest on: the scene's path, its camera and operations, its bounds and
//! the number of its triangles. (The triangles themselves are not read again for it: that would take seconds where
//! there are millions, and moves outlive another colour.)
//!
//! The file is locked while its window lives. So a journal that can be locked is left over, and windows on the same
//! scene do not take each other's. Every line carries a checksum; a line that was cut off at the end does not count.
//! A signal that ends the program leaves what was recorded, about which the window would have asked, and nothing else.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use super::loader::{Loaded, Source};
use super::moves::{List, camera_of, camera_word};
use crate::camera::Camera;
use crate::export::{Hasher, when_no_file_is_open};
use crate::geometry::Aabb;
use crate::scene::{CameraCorners, CameraSetting, Operation, camera_text, operations_text};

const HEAD: &str = "raybomb moves 1";
/// Letters of a hash that a line and a name carry.
const CHECK: usize = 8;
const KEY: usize = 32;
/// The journal of a window in which nothing was recorded.
static UNRECORDED: Mutex<Option<PathBuf>> = Mutex::new(None);

/// The user ends the program by a signal, and would not have been asked about moves that are not recorded.
pub fn interrupted() {
    if let Some(path) = replace_unrecorded(None) {
        // What cannot be removed is offered at the next start.
        let _ = fs::remove_file(path);
    }
}

fn replace_unrecorded(path: Option<PathBuf>) -> Option<PathBuf> {
    let mut unrecorded = UNRECORDED.lock().unwrap_or_else(PoisonError::into_inner);
    std::mem::replace(&mut *unrecorded, path)
}

/// No journal of a hand is larger.
const MAX_BYTES: u64 = 1 << 28;

/// The scene that moves rest on.
#[derive(Clone, Debug, PartialEq)]
pub struct Ground {
    path: PathBuf,
    camera: CameraSetting,
    operations: Vec<Operation>,
    bounds: Aabb,
    triangles: usize,
}

impl Ground {
    /// The scene as it was loaded; `None` where it comes from no file.
    #[must_use]
    pub fn of(source: &Source, loaded: &Loaded) -> Option<Ground> {
        let Source::File(path) = source else {
            return None;
        };
        Some(Ground {
            path: whole(path),
            camera: loaded.camera,
            operations: loaded.operations.clone(),
            bounds: loaded.bounds,
            triangles: loaded.world.triangle_count(),
        })
    }

    /// The same, saved with moves.
    #[must_use]
    pub fn saved(&self, path: &Path, camera: CameraSetting, operations: Vec<Operation>) -> Ground {
        Ground {
            path: whole(path),
            camera,
            operations,
            ..self.clone()
        }
    }

    fn key(&self) -> String {
        let camera = match &self.camera {
            CameraSetting::Default => Ok(String::new()),
            CameraSetting::Set(corners) => camera_text(corners),
        };
        let operations = operations_text(&self.operations);
        let mut hasher = Hasher::default();
        // What was read from a file can be written.
        for text in [camera.unwrap_or_default(), operations.unwrap_or_default()] {
            hasher.update(text.as_bytes());
            hasher.update(b"\0");
        }
        for number in [self.bounds.min, self.bounds.max]
            .map(|p| p.to_array())
            .concat()
        {
            hasher.update(&number.to_le_bytes());
        }
        hasher.update(&(self.triangles as u64).to_le_bytes());
        hasher.update(self.path.as_os_str().as_encoded_bytes());
        hasher.finish()[..KEY].to_owned()
    }
}

/// However the user names the file.
fn whole(path: &Path) -> PathBuf {
    fs::canonicalize(path).unwrap_or_else(|_| path.to_owned())
}

/// All moves, and what they begin from: without those that a file has.
#[derive(Clone, Debug, PartialEq)]
pub struct Kept {
    /// So many of the file's operations are no moves.
    pub own_operations: usize,
    /// The camera before all moves as a scene states it.
    pub camera: CameraSetting,
    /// The same.
    pub base: Camera,
    /// The moves.
    pub list: List,
    /// The frame shown.
    pub frame: u64,
}

impl Kept {
    /// The first line of a journal.
    fn head(&self) -> String {
        let camera = match &self.camera {
            CameraSetting::Default => "d".to_owned(),
            CameraSetting::Set(corners) => camera_word(&Camera::from(*corners)),
        };
        let base = camera_word(&self.base);
        checked(&format!("{HEAD} {} {camera} {base}", self.own_operations))
    }

    /// What leads from `before` to these.
    fn line(&self, before: &List) -> String {
        let moves = self.list.line_after(before);
        checked(&format!("{} {moves}", self.frame))
    }

    fn of_head(line: &str) -> Option<Kept> {
        let mut words = unchecked(line)?.strip_prefix(HEAD)?.split(' ').skip(1);
        let own_operations = words.next()?.parse().ok()?;
        let camera = match words.next()? {
            "d" => CameraSetting::Default,
            word => CameraSetting::Set(corners_of(&camera_of(word)?)),
        };
        let base = camera_of(words.next()?)?;
        Some(Kept {
            own_operations,
            camera,
            base,
            list: List::default(),
            frame: 0,
        })
    }

    fn after_line(&mut self, line: &str) -> Option<()> {
        let (frame, moves) = unchecked(line)?.split_once(' ')?;
        self.frame = frame.parse().ok()?;
        self.list = self.list.after_line(moves)?;
        Some(())
    }

    /// Reads a journal. Returns also where its last whole line ends. `None` when it is none, or damaged.
    fn of_text(text: &str) -> Option<(Kept, usize)> {
        let whole = &text[..text.rfind('\n')? + 1];
        let mut lines = whole.lines();
        let mut kept = Kept::of_head(lines.next()?)?;
        lines.try_for_each(|line| kept.after_line(line))?;
        Some((kept, whole.len()))
    }
}

/// They were `f32` when they were written.
fn corners_of(camera: &Camera) -> CameraCorners {
    CameraCorners {
        eye: camera.eye.as_vec3(),
        top_left: camera.top_left.as_vec3(),
        top_right: camera.top_right.as_vec3(),
        bottom_left: camera.bottom_left.as_vec3(),
    }
}

fn check(text: &str) -> String {
    let mut hasher = Hasher::default();
    hasher.update(text.as_bytes());
    hasher.finish()[..CHECK].to_owned()
}

/// The line with its checksum and its end.
fn checked(text: &str) -> String {
    format!("{text} {}\n", check(text))
}

/// The line without its checksum, if that is right.
fn unchecked(line: &str) -> Option<&str> {
    let (text, sum) = line.rsplit_once(' ')?;
    (check(text) == sum).then_some(text)
}

/// A journal's file, locked.
#[derive(Debug)]
struct Held {
    path: PathBuf,
    file: File,
    /// The moves that it tells.
    list: List,
}

impl Held {
    fn create(folder: &Path, key: &str, kept: &Kept) -> io::Result<Held> {
        fs::create_dir_all(folder)?;
        when_no_file_is_open(|| {
            let mut builder = tempfile::Builder::new();
            let mut temporary = builder.prefix(".moves-").tempfile_in(folder)?;
            // Locked before it has a name that others look for.
            temporary.as_file().lock()?;
            let text = kept.head() + &kept.line(&List::default());
            temporary.write_all(text.as_bytes())?;
            for number in 1_u32.. {
                let path = folder.join(format!("{key}-{number}.moves"));
                match temporary.persist_noclobber(&path) {
                    Ok(file) => {
                        let list = kept.list.clone();
                        return Ok(Held { path, file, list });
                    }
                    Err(e) if e.error.kind() == io::ErrorKind::AlreadyExists => temporary = e.file,
                    Err(e) => return Err(e.error),
                }
            }
            unreachable!("a folder does not hold that many files")
        })
    }

    fn append(&mut self, kept: &Kept) -> io::Result<()> {
        self.file.write_all(kept.line(&self.list).as_bytes())?;
        self.list.clone_from(&kept.list);
        Ok(())
    }

    /// Removes the file, then the lock.
    fn remove(self) {
        replace_unrecorded(None);
        // What cannot be removed is offered at the next start.
        let _ = fs::remove_file(&self.path);
    }
}

/// Keeps the moves of the open scene, and finds those that were left over.
#[derive(Debug)]
pub struct Journal {
    /// Where journals are kept; `None`: they are not.
    folder: Option<PathBuf>,
    ground: Option<Ground>,
    held: Option<Held>,
    /// Of a scene that is no longer the one: it goes when the new one is written.
    stale: Option<Held>,
    /// The moves as they were written last.
    noted: Option<u64>,
    /// Found, and the user is asked about it.
    offered: Option<Held>,
}

impl Journal {
    /// Journals are in this folder.
    #[must_use]
    pub fn new(folder: Option<PathBuf>) -> Journal {
        Journal {
            folder,
            ground: None,
            held: None,
            stale: None,
            noted: None,
            offered: None,
        }
    }

    /// Another scene is open: moves of the one before are not kept.
    pub fn open(&mut self, ground: Option<Ground>) {
        self.forget();
        self.put_off();
        self.ground = ground;
    }

    /// What the moves rest on.
    #[must_use]
    pub fn ground(&self) -> Option<&Ground> {
        self.ground.as_ref()
    }

    /// The scene changed under its moves.
    pub fn set_ground(&mut self, ground: Option<Ground>) {
        if ground != self.ground {
            self.ground = ground;
            self.noted = None;
            if let Some(held) = self.held.take()
                && let Some(older) = self.stale.replace(held)
            {
                older.remove();
            }
        }
    }

    /// Writes down the moves of that revision, unless they are; `None`: there is nothing to lose.
    ///
    /// # Errors
    /// When the file system will not; then no more is written.
    pub fn note(&mut self, revision: u64, kept: impl FnOnce() -> Option<Kept>) -> io::Result<()> {
        if self.noted == Some(revision) {
            return Ok(());
        }
        let (Some(folder), Some(ground)) = (&self.folder, &self.ground) else {
            return Ok(());
        };
        let kept = kept();
        let is_recorded = kept.as_ref().is_some_and(|kept| kept.list.has_recorded());
        let written = match (kept, &mut self.held) {
            (None, held) => {
                held.take().into_iter().for_each(Held::remove);
                Ok(())
            }
            (Some(kept), Some(held)) => held.append(&kept),
            (Some(kept), held) => Held::create(folder, &ground.key(), &kept).map(|new| {
                *held = Some(new);
            }),
        };
        self.noted = Some(revision);
        if written.is_ok() {
            self.stale.take().into_iter().for_each(Held::remove);
            let held = self.held.as_ref().filter(|_| !is_recorded);
            replace_unrecorded(held.map(|held| held.path.clone()));
        } else {
            self.folder = None;
        }
        written
    }

    /// Whether moves would be offered if the program ended now.
    #[must_use]
    pub fn keeps_any(&self) -> bool {
        self.held.is_some() || self.stale.is_some()
    }

    /// There is nothing to lose.
    pub fn forget(&mut self) {
        let all = self.held.take().into_iter().chain(self.stale.take());
        all.for_each(Held::remove);
        self.noted = None;
    }

    /// The newest journal that was left over from this scene, if any; damaged ones are put aside, and `tell` hears of
    /// it.
    pub fn find(&mut self, mut tell: impl FnMut(&str)) -> Option<Kept> {
        let (folder, ground) = (self.folder.as_ref()?, self.ground.as_ref()?);
        for path in journals(folder, &ground.key()) {
            let Some(mut file) = left_over(&path) else {
                continue;
            };
            let mut text = String::new();
            let read = (&mut file).take(MAX_BYTES).read_to_string(&mut text);
            let kept = read.ok().and_then(|_| Kept::of_text(&text));
            let kept = kept.filter(|(kept, _)| kept.own_operations <= ground.operations.len());
            let Some((kept, end)) = kept else {
                let aside = path.with_extension("damaged");
                let moved = fs::rename(&path, &aside).map_or(path, |()| aside);
                tell(&format!(
                    "a damaged journal of moves is ignored: {}",
                    moved.display()
                ));
                continue;
            };
            let cut = file.set_len(end as u64);
            if cut.and_then(|()| file.seek(SeekFrom::End(0))).is_err() {
                continue;
            }
            let list = kept.list.clone();
            self.offered = Some(Held { path, file, list });
            return Some(kept);
        }
        None
    }

    /// The moves that were found are the window's again: their journal goes on.
    pub fn adopt(&mut self) {
        self.forget();
        self.held = self.offered.take();
    }

    /// Nobody wants the moves that were found.
    pub fn drop_offered(&mut self) {
        self.offered.take().into_iter().for_each(Held::remove);
    }

    /// The moves that were found are offered again another time.
    pub fn put_off(&mut self) {
        self.offered = None;
    }
}

/// The journals with that key, the newest first.
fn journals(folder: &Path, key: &str) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(folder) else {
        return Vec::new();
    };
    let of_key = entries.flatten().filter(|entry| {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        name.starts_with(key) && name.ends_with(".moves")
    });
    let mut found: Vec<_> = of_key
        .map(|entry| {
            let time = entry.metadata().and_then(|m| m.modified()).ok();
            (std::cmp::Reverse(time), entry.path())
        })
        .collect();
    found.sort();
    found.into_iter().map(|(_, path)| path).collect()
}

/// The file, locked, if no window has it.
fn left_over(path: &Path) -> Option<File> {
    let file = OpenOptions::new().read(true).write(true).open(path).ok()?;
    file.try_lock().ok()?;
    // Its window may have removed it just now.
    path.exists().then_some(file)
}

#[cfg(test)]
mod tests;
