//! Pictures as files: BMP, PNG, NPY arrays, and the hash that names a picture.
//!
//! The encoders write to any [`std::io::Write`]; only [`write_whole`] opens files, and a file that it makes
//! appears whole or not at all.

mod atomic;
mod bmp;
mod hash;
mod npy;
mod png;

use std::io::{self, Write};
use std::path::Path;
use std::slice::ChunksExact;

use crate::camera::View;
use crate::frame::{Frame, Hits};
use crate::scene::Triangle;

pub use atomic::{is_regular, when_no_file_is_open, write_new, write_whole};
pub use hash::{Hasher, picture_hash};

/// A kind of file that we write, chosen by the extension of its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// 24 bits a pixel, not compressed.
    Bmp,
    /// 8 bits a channel, compressed without loss.
    Png,
    /// An array for NumPy.
    Npy,
}

impl Format {
    /// All of them.
    pub const ALL: [Format; 3] = [Format::Bmp, Format::Png, Format::Npy];

    /// The extension of its files, without the dot.
    #[must_use]
    pub const fn extension(self) -> &'static str {
        match self {
            Format::Bmp => "bmp",
            Format::Png => "png",
            Format::Npy => "npy",
        }
    }

    /// What the extension of `path` says, upper or lower case; `None` for any other and for none.
    #[must_use]
    pub fn of_path(path: &Path) -> Option<Format> {
        let extension = path.extension()?.to_str()?;
        Format::ALL
            .into_iter()
            .find(|f| extension.eq_ignore_ascii_case(f.extension()))
    }
}

/// What goes into a file.
#[derive(Clone, Copy, Debug)]
pub enum Contents<'a> {
    /// The colours: any format.
    Picture(&'a Frame),
    /// The number of each pixel's triangle: NPY.
    Ids(&'a Hits),
    /// The distance from the eye to each pixel's hit: NPY.
    Depth(&'a Hits, &'a View),
    /// The normal of each pixel's triangle, which is one of these (all of the file's): NPY.
    Normals(&'a Hits, &'a View, &'a [Triangle]),
}

impl Contents<'_> {
    /// Encodes all of it.
    ///
    /// # Errors
    /// Those of `out`, and [`io::ErrorKind::Unsupported`] for what the format cannot hold.
    pub fn write(&self, format: Format, out: &mut dyn Write) -> io::Result<()> {
        match (format, self) {
            (Format::Bmp, Contents::Picture(frame)) => bmp::write(frame, out),
            (Format::Png, Contents::Picture(frame)) => png::write(frame, out),
            (Format::Npy, Contents::Picture(frame)) => npy::write_colors(frame, out),
            (Format::Npy, Contents::Ids(hits)) => npy::write_ids(hits, out),
            (Format::Npy, Contents::Depth(hits, view)) => npy::write_depth(hits, view, out),
            (Format::Npy, Contents::Normals(hits, view, triangles)) => {
                npy::write_normals(hits, view, triangles, out)
            }
            _ => Err(io::Error::new(
                io::ErrorKind::Unsupported,
                "only NPY files hold arrays of numbers",
            )),
        }
    }
}

/// Writes `frame` to `path` in the format of its extension, whole or not at all.
///
/// # Errors
/// When the extension is none of ours, and when the file cannot be written.
pub fn save_picture(path: &Path, frame: &Frame) -> io::Result<()> {
    let format = Format::of_path(path).ok_or_else(|| {
        io::Error::new(
            io::ErrorKind::Unsupported,
            "its extension is none of bmp, png, npy",
        )
    })?;
    write_whole(path, |out| Contents::Picture(frame).write(format, out))
}

/// Calls `each` with the R, G, B bytes of every row, from top to bottom.
fn for_each_rgb_row(
    frame: &Frame,
    mut each: impl FnMut(&[u8]) -> io::Result<()>,
) -> io::Result<()> {
    let mut row = Vec::with_capacity(frame.width * 3);
    for pixels in rows(&frame.pixels, frame.width) {
        row.clear();
        for p in pixels {
            let [_, r, g, b] = p.to_be_bytes();
            row.extend([r, g, b]);
        }
        each(&row)?;
    }
    Ok(())
}

/// The rows of a plane, from top to bottom; none where it has no pixels.
fn rows<T>(pixels: &[T], width: usize) -> ChunksExact<'_, T> {
    pixels.chunks_exact(width.max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_extension_chooses_the_format() {
        let of = |p: &str| Format::of_path(Path::new(p));
        assert_eq!(of("a/b.PNG"), Some(Format::Png));
        assert_eq!(of("b.bmp"), Some(Format::Bmp));
        assert_eq!(of("x.y.npy"), Some(Format::Npy));
        assert_eq!(of("png"), None);
        assert_eq!(of("a.jpg"), None);
    }

    #[test]
    fn pictures_without_pixels_are_files_or_errors() {
        let empty = Frame::default();
        let written = |format| {
            let mut file = Vec::new();
            Contents::Picture(&empty)
                .write(format, &mut file)
                .map(|()| file.len())
        };
        assert_eq!(written(Format::Bmp).expect("a header"), 54);
        assert_eq!(written(Format::Npy).expect("a header"), 128);
        assert!(written(Format::Png).is_err(), "the format needs a pixel");
        assert_eq!(picture_hash(&empty).len(), 64);
        let mut file = Vec::new();
        Contents::Ids(&Hits::default())
            .write(Format::Npy, &mut file)
            .expect("a header");
    }

    #[test]
    fn saved_pictures_are_whole_files_and_unknown_extensions_are_errors() {
        let dir = tempfile::tempdir().unwrap();
        let frame = Frame::new(3, 2);
        for format in Format::ALL {
            let path = dir.path().join(format!("x.{}", format.extension()));
            save_picture(&path, &frame).unwrap();
            assert!(path.metadata().unwrap().len() > 18);
        }
        assert!(save_picture(&dir.path().join("x.jpg"), &frame).is_err());
        assert_eq!(dir.path().read_dir().unwrap().count(), 3);
    }
}
