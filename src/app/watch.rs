//! Tells when a file is saved, by notification.
//!
//! The folder is watched, not the file: editors that write a new file and rename it leave the old one behind. Where
//! the file is a link, the folder of what it points to is watched too.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

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
        let places = places(file);
        let names: Vec<OsString> = places.iter().map(|(_, name)| name.clone()).collect();
        let on_event = move |event: notify::Result<Event>| {
            // An error, such as too many events to be told, may hide one of ours.
            if event.map_or(true, |e| concerns(&e, &names)) {
                changed();
            }
        };
        let words = |e: notify::Error| e.to_string();
        let mut watcher = notify::recommended_watcher(on_event).map_err(words)?;
        for (folder, _) in &places {
            watcher
                .watch(folder, RecursiveMode::NonRecursive)
                .map_err(words)?;
        }
        Ok(Watch { _watcher: watcher })
    }
}

/// The folder and name of `file`, and of what it points to if that is another place.
fn places(file: &Path) -> Vec<(PathBuf, OsString)> {
    let place = |file: &Path| {
        let folder = match file.parent() {
            Some(folder) if folder != Path::new("") => folder,
            _ => Path::new("."),
        };
        Some((folder.to_path_buf(), file.file_name()?.to_owned()))
    };
    let mut places: Vec<_> = place(file).into_iter().collect();
    let is_link = std::fs::symlink_metadata(file).is_ok_and(|m| m.is_symlink());
    if is_link && let Ok(target) = file.canonicalize() {
        places.extend(place(&target));
    }
    places
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
    use std::fs;
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
    fn a_folder_that_is_not_there_cannot_be_watched() {
        assert!(Watch::start(Path::new("no/such/file.txt"), || ()).is_err());
    }
}
