//! Saves the picture shown as `raybomb-0001.png`, `raybomb-0002.png` and so on in the current folder.

use std::io;
use std::path::Path;

use crate::export::{Contents, Format, write_new};
use crate::frame::Frame;

/// Saves `frame` in `folder` under the first name that is free, and returns that name. The file appears whole
/// or not at all, and never takes the place of another.
///
/// # Errors
/// When the file cannot be written, or all 9999 names are taken.
pub fn save(frame: &Frame, folder: &Path) -> io::Result<String> {
    let names = (1..=9999).map(|number| format!("raybomb-{number:04}.png"));
    let saved = write_new(folder, names, |out| {
        Contents::Picture(frame).write(Format::Png, out)
    })?;
    saved.ok_or_else(|| {
        let text = "raybomb-0001.png to raybomb-9999.png are all there already";
        io::Error::new(io::ErrorKind::AlreadyExists, text)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn takes_the_first_free_name_and_never_overwrites() {
        let folder = tempfile::tempdir().expect("a folder");
        fs::write(folder.path().join("raybomb-0001.png"), "mine").expect("written");
        let mut frame = Frame::default();
        frame.resize(3, 2);
        for expected in ["raybomb-0002.png", "raybomb-0003.png"] {
            assert_eq!(save(&frame, folder.path()).expect("saved"), expected);
        }
        let mine = fs::read(folder.path().join("raybomb-0001.png")).expect("read");
        assert_eq!(mine, b"mine");
        assert_eq!(fs::read_dir(folder.path()).expect("listed").count(), 3);
    }

    #[test]
    fn a_folder_that_is_not_there_is_an_error_and_leaves_nothing() {
        let folder = tempfile::tempdir().expect("a folder");
        assert!(save(&Frame::default(), &folder.path().join("none")).is_err());
        assert_eq!(fs::read_dir(folder.path()).expect("listed").count(), 0);
    }
}
