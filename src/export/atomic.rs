//! Files that appear whole or not at all.
//!
//! The bytes go to a temporary file in the same folder, which takes the name of the wanted one in a single
//! step at the end. Whatever goes wrong before leaves the folder as it was.

use std::fs::{self, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use tempfile::NamedTempFile;

/// Held while a temporary file exists.
static TEMPORARY_FILE: Mutex<()> = Mutex::new(());

/// What `write` writes becomes the file `path`, whole; on any error `path` is left as it was.
///
/// Pipes, devices and the standard streams (`/dev/stdout`) cannot be replaced and are written directly. A
/// symbolic link is followed, also to a file that is not there yet; the permissions of an existing file are kept.
///
/// # Errors
/// Those of `write` and of the file system; the text does not name `path`.
pub fn write_whole(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    if path == Path::new("/dev/stdout") {
        // Opening it anew would start at the beginning of a file that the shell has opened to append.
        return write_to(io::stdout().lock(), write);
    }
    match fs::metadata(path) {
        Ok(existing) if existing.is_dir() => Err(message(
            io::ErrorKind::IsADirectory,
            "it is a folder".to_owned(),
        )),
        Ok(_) if !is_regular(path) => write_to(OpenOptions::new().write(true).open(path)?, write),
        Ok(existing) => {
            // Replacing needs no right to write the file, but who protects a file means it.
            OpenOptions::new().write(true).open(path)?;
            replace(&fs::canonicalize(path)?, Some(&existing), write)
        }
        Err(e) if e.kind() == io::ErrorKind::NotFound => match fs::read_link(path) {
            // Links in a circle are another kind of error, so this comes to an end.
            Ok(target) => write_whole(&path.with_file_name(target), write),
            Err(_) => replace(path, None, write),
        },
        Err(e) => Err(e),
    }
}

/// What `write` writes becomes a new file in `folder` under the first of `names` that is free, whole or not at
/// all; `None` when all are taken. No file is ever replaced.
///
/// # Errors
/// Those of `write` and of the file system.
pub fn write_new(
    folder: &Path,
    names: impl Iterator<Item = String>,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<Option<String>> {
    when_no_file_is_open(|| {
        let mut temporary = temporary_in(folder)?;
        write_to(temporary.as_file_mut(), write)?;
        for name in names {
            match temporary.persist_noclobber(folder.join(&name)) {
                Ok(_) => return Ok(Some(name)),
                Err(e) if e.error.kind() == io::ErrorKind::AlreadyExists => temporary = e.file,
                Err(e) => return Err(e.error),
            }
        }
        Ok(None)
    })
}

/// False for what exists and is no plain file: pipes, devices, standard streams, also by the names of `/dev/fd`
/// and `/proc`. Such a target is written directly.
#[must_use]
pub fn is_regular(path: &Path) -> bool {
    let stream = ["/dev/stdout", "/dev/stderr", "/dev/fd", "/proc"];
    !stream.iter().any(|s| path.starts_with(s)) && fs::metadata(path).map_or(true, |m| m.is_file())
}

/// Runs `then` (which may end the program) at a moment at which no temporary file exists, and keeps others from
/// making one meanwhile.
pub fn when_no_file_is_open<R>(then: impl FnOnce() -> R) -> R {
    let _none = TEMPORARY_FILE
        .lock()
        .unwrap_or_else(PoisonError::into_inner);
    then()
}

fn replace(
    path: &Path,
    existing: Option<&fs::Metadata>,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    let folder = folder_of(path)?;
    when_no_file_is_open(|| {
        let mut temporary = temporary_in(&folder)?;
        write_to(temporary.as_file_mut(), write)?;
        if let Some(existing) = existing {
            temporary
                .as_file()
                .set_permissions(existing.permissions())?;
        }
        temporary.persist(path).map_err(|e| e.error)?;
        Ok(())
    })
}

/// The folder that holds `path`, which must exist.
fn folder_of(path: &Path) -> io::Result<PathBuf> {
    let folder = match path.parent() {
        Some(p) if p != Path::new("") => p.to_owned(),
        _ => PathBuf::from("."),
    };
    if folder.is_dir() {
        return Ok(folder);
    }
    let what = if folder.exists() {
        "is not a folder"
    } else {
        "does not exist"
    };
    let text = format!("the folder {} {what}", folder.display());
    Err(message(io::ErrorKind::NotFound, text))
}

fn temporary_in(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".raybomb-").suffix(".tmp");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // As for any new file: the umask takes from these.
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    // The error's own text names the temporary file, which nobody asked for.
    builder.tempfile_in(folder).map_err(|e| {
        let text = format!(
            "the folder {} takes no new file: {}",
            folder.display(),
            e.kind()
        );
        message(e.kind(), text)
    })
}

/// Buffers what `write` writes and hands all of it to the system.
fn write_to(
    out: impl Write,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 18, out);
    let result = write(&mut out).and_then(|()| out.flush());
    // Not flushed again on the way out: after an error the rest is of no use.
    drop(out.into_parts());
    result
}

fn message(kind: io::ErrorKind, text: String) -> io::Error {
    io::Error::new(kind, text)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let name = |e: io::Result<fs::DirEntry>| e.unwrap().file_name().into_string().unwrap();
        let mut names: Vec<String> = folder.read_dir().unwrap().map(name).collect();
        names.sort();
        names
    }

    #[test]
    fn a_new_file_has_the_bytes_and_an_old_one_is_replaced() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a");
        for text in ["first", "second"] {
            write_whole(&path, |out| out.write_all(text.as_bytes())).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), text);
        }
        assert_eq!(names(dir.path()), ["a"]);
    }

    #[test]
    fn an_error_midway_leaves_the_old_file_and_nothing_else() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a");
        fs::write(&path, "old").unwrap();
        let failed = write_whole(&path, |out| {
            out.write_all(&[0; 1 << 20])?;
            Err(io::Error::other("no more"))
        });
        assert_eq!(failed.unwrap_err().to_string(), "no more");
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(names(dir.path()), ["a"]);
    }

    #[test]
    fn folders_and_missing_folders_are_told_apart() {
        let dir = tempfile::tempdir().unwrap();
        let text = |p: &Path| write_whole(p, |_| Ok(())).unwrap_err().to_string();
        assert_eq!(text(dir.path()), "it is a folder");
        assert!(text(&dir.path().join("no/a")).ends_with("no does not exist"));
        assert_eq!(names(dir.path()), [""; 0]);
    }

    #[cfg(unix)]
    #[test]
    fn permissions_are_those_of_the_umask_or_of_the_old_file() {
        use std::os::unix::fs::PermissionsExt;
        let dir = tempfile::tempdir().unwrap();
        let mode = |p: &Path| p.metadata().unwrap().permissions().mode() & 0o777;
        let (ours, plain) = (dir.path().join("ours"), dir.path().join("plain"));
        fs::File::create(&plain).unwrap();
        write_whole(&ours, |_| Ok(())).unwrap();
        assert_eq!(mode(&ours), mode(&plain));
        fs::set_permissions(&ours, fs::Permissions::from_mode(0o640)).unwrap();
        write_whole(&ours, |_| Ok(())).unwrap();
        assert_eq!(mode(&ours), 0o640);
    }

    #[cfg(unix)]
    #[test]
    fn a_symbolic_link_stays_a_link() {
        let dir = tempfile::tempdir().unwrap();
        let (file, link) = (dir.path().join("file"), dir.path().join("link"));
        fs::write(&file, "old").unwrap();
        std::os::unix::fs::symlink("file", &link).unwrap();
        write_whole(&link, |out| out.write_all(b"new")).unwrap();
        assert!(link.symlink_metadata().unwrap().is_symlink());
        assert_eq!(fs::read_to_string(&file).unwrap(), "new");
    }

    #[cfg(unix)]
    #[test]
    fn what_a_symbolic_link_points_to_is_made() {
        use std::os::unix::fs::symlink;
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        symlink(at("file"), at("b")).unwrap();
        symlink("b", at("a")).unwrap();
        write_whole(&at("a"), |out| out.write_all(b"new")).unwrap();
        assert_eq!(names(dir.path()), ["a", "b", "file"]);
        assert!(at("a").is_symlink() && at("b").is_symlink());
        assert_eq!(fs::read_to_string(at("file")).unwrap(), "new");

        symlink("no/file", at("c")).unwrap();
        let missing = write_whole(&at("c"), |_| Ok(())).unwrap_err();
        assert!(
            missing.to_string().ends_with("no does not exist"),
            "{missing}"
        );
        symlink("d", at("d")).unwrap();
        assert!(write_whole(&at("d"), |_| Ok(())).is_err());
    }
}
