//! 24-bit BMP, the original's format: a 54-byte header, rows bottom-up, each padded to 4 bytes, B, G, R.

use std::io::{self, Write};

use super::rows;
use crate::frame::Frame;

/// Bytes before the pixels: the file header (14) and the info header (40).
const HEADER_BYTES: u32 = 54;

/// Writes `frame` as a BMP file.
///
/// # Errors
/// Those of `out`, and a picture whose file would not fit in the format's 32-bit size.
pub(super) fn write(frame: &Frame, out: &mut dyn Write) -> io::Result<()> {
    let padding = (4 - frame.width * 3 % 4) % 4;
    out.write_all(&header(frame, padding)?)?;
    let mut row = Vec::with_capacity(frame.width * 3 + padding);
    for pixels in rows(&frame.pixels, frame.width).rev() {
        row.clear();
        for p in pixels {
            let [b, g, r, _] = p.to_le_bytes();
            row.extend([b, g, r]);
        }
        row.extend_from_slice(&[0; 3][..padding]);
        out.write_all(&row)?;
    }
    Ok(())
}

/// Everything that docs/format.md does not name is zero: no compression, no palette, no resolution.
fn header(frame: &Frame, padding: usize) -> io::Result<[u8; HEADER_BYTES as usize]> {
    let too_large = |_| io::Error::new(io::ErrorKind::Unsupported, "too large for a BMP file");
    let row_bytes = frame.width * 3 + padding;
    let file_bytes = row_bytes * frame.height + HEADER_BYTES as usize;
    let mut header = [0; HEADER_BYTES as usize];
    let mut put = |at: usize, bytes: &[u8]| header[at..at + bytes.len()].copy_from_slice(bytes);
    put(0, b"BM");
    put(
        2,
        &u32::try_from(file_bytes).map_err(too_large)?.to_le_bytes(),
    );
    put(10, &HEADER_BYTES.to_le_bytes());
    put(14, &40u32.to_le_bytes());
    put(
        18,
        &i32::try_from(frame.width).map_err(too_large)?.to_le_bytes(),
    );
    put(
        22,
        &i32::try_from(frame.height)
            .map_err(too_large)?
            .to_le_bytes(),
    );
    put(26, &1u16.to_le_bytes());
    put(28, &24u16.to_le_bytes());
    Ok(header)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_exactly_those_of_the_format() {
        let frame = Frame {
            width: 2,
            height: 2,
            pixels: vec![0xff0000, 0x00ff00, 0x0000ff, 0x010203],
        };
        let mut file = Vec::new();
        write(&frame, &mut file).unwrap();
        let mut expected = Vec::new();
        expected
            .extend(b"BM\x46\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0\x02\0\0\0\x02\0\0\0\x01\0\x18\0");
        expected.extend([0; 24]);
        expected.extend([255, 0, 0, 3, 2, 1, 0, 0]); // the bottom row: blue, then 1, 2, 3; padding
        expected.extend([0, 0, 255, 0, 255, 0, 0, 0]); // the top row: red, green; padding
        assert_eq!(file, expected);
    }

    #[test]
    fn rows_are_padded_to_four_bytes() {
        for (width, row_bytes) in [(1, 4), (2, 8), (3, 12), (4, 12), (5, 16)] {
            let mut file = Vec::new();
            write(&Frame::new(width, 3), &mut file).unwrap();
            assert_eq!(file.len(), 54 + 3 * row_bytes, "width {width}");
        }
    }
}
