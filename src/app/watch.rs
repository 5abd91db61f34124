//! Tells when a file is saved, by notification.
//!
//! The folder is watched, not the file: editors that write a new file and rename it leave the old one behind. So is the
//! folder's own: programs that build a folder anew leave the old one behind. Where the file is a link, what it points to
//! is watched too. Where there is no such folder, the nearest one above is watched for it.
//!
//! What a watch looks at is found out when it starts. Folders that were made since, and where a link points now, are seen
//! by the next one: after a change, start anew.

use std::ffi::OsString;
use std::path::{self, Path, PathBuf};
use std::{fs, io};

use notify::event::{AccessKind, AccessMode, ModifyKind};
use notify::{Event, EventKind, RecommendedWatcher, RecursiveMode, Watcher};

/// Watches until it is dropped.
#[derive(Debug)]
pub struct Watch {
    /// Its threads end with it.
    _watcher: RecommendedWatcher,
}

impl Watch {
    /// Calls `changed`, on another thread and perhaps several times a change, when `file` is written, replaced,
    /// removed or made.
    ///
    /// # Errors
    /// Why it cannot be watched, in words.
    pub fn start(file: &Path, changed: impl Fn() + Send + 'static) -> Result<Watch, String> {
        let places = places(file).map_err(|e| e.to_string())?;
        let names: Vec<OsString> = places.iter().map(|(_, name)| name.clone()).collect();
        let on_event = move |event: notify::Result<Event>| {
            // An error, such as too many events to be told, may hide one of ours.
            if event.map_or(true, |e| concerns(&e, &names)) {
                changed();
            }
        };
        let words = |e: notify::Error| e.to_string();
        let mut watcher = notify::recommended_watcher(on_event).map_err(words)?;
        let mut watch = |(folder, _): &(PathBuf, OsString)| {
            let watched = watcher.watch(folder, RecursiveMode::NonRecursive);
            watched.map_err(words)
        };
        let mut watched = Err("there is no such folder".to_owned());
        for place in &places {
            // One that may not be looked into does not spoil the others.
            watched = watch(place).or(watched);
        }
        watched.map(|()| Watch { _watcher: watcher })
    }
}

/// Folders that there are, each with the name in it to look for: `file` or the way to it, and the same of what `file` points
/// to, if that is another place.
fn places(file: &Path) -> io::Result<Vec<(PathBuf, OsString)>> {
    let mut places = Vec::new();
    let mut add = |file: &Path| {
        let mut way = file.ancestors().filter_map(|at| {
            let (folder, name) = (at.parent()?, at.file_name()?);
            folder
                .is_dir()
                .then(|| (folder.to_owned(), name.to_owned()))
        });
        places.extend(way.next());
        places.extend(way.next());
    };
    add(&path::absolute(file)?);
    let is_link = fs::symlink_metadata(file).is_ok_and(|m| m.is_symlink());
    if is_link && let Ok(target) = file.canonicalize() {
        add(&target);
    }
    Ok(places)
}

/// Whether `event` may have changed the text of one of the files. Reading does not, nor do times and rights.
fn concerns(event: &Event, names: &[OsString]) -> bool {
    let changes = match event.kind {
        EventKind::Access(access) => access == AccessKind::Close(AccessMode::Write),
        EventKind::Modify(ModifyKind::Metadata(_)) => false,
        _ => true,
    };
    let ours = |path: &PathBuf| {
        path.file_name()
            .is_some_and(|n| names.iter().any(|m| m == n))
    };
    changes && event.paths.iter().any(ours)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc::{Receiver, channel};
    use std::time::Duration;

    fn watch(file: &Path) -> (Watch, Receiver<()>) {
        let (send, receive) = channel();
        let watch = Watch::start(file, move || {
            let _ = send.send(());
        });
        (watch.expect("a watch"), receive)
    }

    fn told(changes: &Receiver<()>) {
        changes
            .recv_timeout(Duration::from_secs(20))
            .expect("a change is told");
        while changes.recv_timeout(Duration::from_millis(100)).is_ok() {}
    }

    fn silent(changes: &Receiver<()>) {
        let told = changes.recv_timeout(Duration::from_millis(150));
        assert!(told.is_err(), "told without a change");
    }

    #[test]
    fn writing_renaming_and_removing_are_told_and_reading_is_not() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("a.txt");
        fs::write(&file, "1").expect("written");
        let (_watch, changes) = watch(&file);
        fs::read(&file).expect("read");
        fs::write(folder.path().join("b.txt"), "other").expect("written");
        silent(&changes);
        fs::write(&file, "2").expect("written");
        told(&changes);
        for _ in 0..2 {
            fs::rename(folder.path().join("b.txt"), &file).expect("renamed");
            told(&changes);
            fs::write(folder.path().join("b.txt"), "other").expect("written");
        }
        fs::remove_file(&file).expect("removed");
        told(&changes);
        fs::write(&file, "3").expect("written");
        told(&changes);
    }

    #[cfg(unix)]
    #[test]
    fn what_a_link_points_to_is_watched() {
        let [here, there] = [0, 1].map(|_| tempfile::tempdir().expect("a folder"));
        let file = there.path().join("real.txt");
        fs::write(&file, "1").expect("written");
        let link = here.path().join("link.txt");
        std::os::unix::fs::symlink(&file, &link).expect("a link");
        let (_watch, changes) = watch(&link);
        fs::write(&file, "2").expect("written");
        told(&changes);
    }

    #[test]
    fn a_folder_that_is_made_anew_or_for_the_first_time_is_told() {
        let top = tempfile::tempdir().expect("a folder");
        let folder = top.path().join("a/b");
        let file = folder.join("c.txt");
        fs::create_dir_all(&folder).expect("made");
        fs::write(&file, "1").expect("written");
        let (_watch, changes) = watch(&file);
        fs::rename(&folder, top.path().join("a/old")).expect("renamed");
        told(&changes);
        fs::create_dir(&folder).expect("made");
        told(&changes);
        let (_watch, changes) = watch(&file);
        fs::write(&file, "2").expect("written");
        told(&changes);
        fs::remove_dir_all(top.path().join("a")).expect("removed");
        told(&changes);
        let (_watch, changes) = watch(&file);
        fs::write(top.path().join("b"), "other").expect("written");
        silent(&changes);
        fs::create_dir_all(&folder).expect("made");
        told(&changes);
    }
}
