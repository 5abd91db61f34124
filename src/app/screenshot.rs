//! Saves the picture shown as `raybomb-0001.png`, `raybomb-0002.png` and so on in the current folder.

use std::fs::Permissions;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use crate::frame::Frame;

/// Saves `frame` in `folder` under the first name that is free, and returns that name. The file appears whole
/// or not at all, and never takes the place of another.
///
/// # Errors
/// When the file cannot be written, or all 9999 names are taken.
pub fn save(frame: &Frame, folder: &Path) -> io::Result<PathBuf> {
    let mut file = new_file(folder)?;
    encode(frame, &mut BufWriter::new(&mut file))?;
    for number in 1..=9999 {
        let name = PathBuf::from(format!("raybomb-{number:04}.png"));
        match file.persist_noclobber(folder.join(&name)) {
            Ok(_) => return Ok(name),
            Err(e) if e.error.kind() == io::ErrorKind::AlreadyExists => file = e.file,
            Err(e) => return Err(e.error),
        }
    }
    Err(io::Error::new(
        io::ErrorKind::AlreadyExists,
        "raybomb-0001.png to raybomb-9999.png are all there already",
    ))
}

/// A temporary file which, once it has its name, is as readable as any other.
fn new_file(folder: &Path) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".raybomb-");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder)
}

/// The frame as PNG.
fn encode(frame: &Frame, out: &mut impl Write) -> io::Result<()> {
    let size = |n: usize| u32::try_from(n).map_err(io::Error::other);
    let mut encoder = png::Encoder::new(&mut *out, size(frame.width)?, size(frame.height)?);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let rgb: Vec<u8> = frame
        .pixels
        .iter()
        .flat_map(|p| {
            let [_, r, g, b] = p.to_be_bytes();
            [r, g, b]
        })
        .collect();
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&rgb)?;
    writer.finish()?;
    out.flush()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn takes_the_first_free_name_and_never_overwrites() {
        let folder = tempfile::tempdir().expect("a folder");
        fs::write(folder.path().join("raybomb-0001.png"), "mine").expect("written");
        let frame = Frame::new(3, 2);
        for expected in ["raybomb-0002.png", "raybomb-0003.png"] {
            let name = save(&frame, folder.path()).expect("saved");
            assert_eq!(name.to_str(), Some(expected));
        }
        let mine = fs::read(folder.path().join("raybomb-0001.png")).expect("read");
        assert_eq!(mine, b"mine");
        assert_eq!(fs::read_dir(folder.path()).expect("listed").count(), 3);
    }

    #[test]
    fn a_folder_that_is_not_there_is_an_error_and_leaves_nothing() {
        let folder = tempfile::tempdir().expect("a folder");
        assert!(save(&Frame::new(1, 1), &folder.path().join("none")).is_err());
        assert_eq!(fs::read_dir(folder.path()).expect("listed").count(), 0);
    }
}
