//! PNG, 8-bit RGB without an alpha channel.

use std::io::{self, Write};

use png::{BitDepth, ColorType, Compression, Encoder};

use super::for_each_rgb_row;
use crate::frame::Frame;

/// Writes `frame` as a PNG file.
///
/// # Errors
/// Those of `out`.
pub(super) fn write(frame: &Frame, out: &mut dyn Write) -> io::Result<()> {
    let size = |n: usize| u32::try_from(n).expect("a picture's sides are at most 16384");
    let mut encoder = Encoder::new(out, size(frame.width), size(frame.height));
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(Compression::Fast);
    let mut writer = encoder.write_header()?;
    let mut stream = writer.stream_writer_with_size(1 << 16)?;
    for_each_rgb_row(frame, |row| stream.write_all(row))?;
    stream.finish()?;
    Ok(writer.finish()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_decoder_reads_the_same_pixels() {
        let mut frame = Frame::new(37, 21);
        for (i, p) in frame.pixels.iter_mut().enumerate() {
            *p = (i as u32).wrapping_mul(2_654_435_761) >> 8;
        }
        let mut file = Vec::new();
        write(&frame, &mut file).unwrap();
        let mut reader = png::Decoder::new(io::Cursor::new(file))
            .read_info()
            .unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut bytes).unwrap();
        assert_eq!((info.width, info.height), (37, 21));
        assert_eq!(
            (info.color_type, info.bit_depth),
            (ColorType::Rgb, BitDepth::Eight)
        );
        let pixels: Vec<u32> = bytes
            .chunks_exact(3)
            .map(|c| u32::from_be_bytes([0, c[0], c[1], c[2]]))
            .collect();
        assert_eq!(pixels, frame.pixels);
    }
}
