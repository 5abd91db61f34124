//! Pictures from files and from the screen.

/// Pixels as R, G, B, from top to bottom.
#[derive(Clone, PartialEq, Eq)]
pub struct Picture {
    pub width: usize,
    pub height: usize,
    pub rgb: Vec<u8>,
}

impl Picture {
    /// What two pictures differ in.
    pub fn difference(&self, other: &Picture) -> String {
        if (self.width, self.height) != (other.width, other.height) {
            return format!(
                "{}x{} instead of {}x{}",
                self.width, self.height, other.width, other.height
            );
        }
        let pixels = self.rgb.chunks(3).zip(other.rgb.chunks(3));
        let count = pixels.filter(|(a, b)| a != b).count();
        format!("{count} of {} pixels differ", self.width * self.height)
    }

    /// The upper left part.
    pub fn corner(&self, width: usize, height: usize) -> Picture {
        let (width, height) = (width.min(self.width), height.min(self.height));
        let rows = self.rgb.chunks_exact(self.width * 3).take(height);
        Picture {
            width,
            height,
            rgb: rows.flat_map(|row| &row[..width * 3]).copied().collect(),
        }
    }

    /// Where the other picture is a part of this one, to the bit.
    pub fn place_of(&self, part: &Picture) -> Option<(usize, usize)> {
        let row = |p: &Picture, x: usize, y: usize| {
            let start = (y * p.width + x) * 3;
            p.rgb[start..start + part.width * 3].to_vec()
        };
        let is_at =
            |x: usize, y: usize| (0..part.height).all(|i| row(self, x, y + i) == row(part, 0, i));
        let columns = (self.width + 1).checked_sub(part.width)?;
        let rows = (self.height + 1).checked_sub(part.height)?;
        let places = (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y)));
        places.into_iter().find(|&(x, y)| is_at(x, y))
    }

    /// This picture left of `column`, and `right` from there on.
    pub fn beside(&self, right: &Picture, column: usize) -> Picture {
        let row = self.width * 3;
        let rows = self.rgb.chunks_exact(row).zip(right.rgb.chunks_exact(row));
        let rgb = rows
            .flat_map(|(left, right)| [&left[..column * 3], &right[column * 3..]])
            .flatten()
            .copied()
            .collect();
        Picture { rgb, ..*self }
    }

    /// Whether every square of `size` pixels each way has one colour.
    pub fn is_made_of_squares(&self, size: usize) -> bool {
        let rows: Vec<&[u8]> = self.rgb.chunks_exact(self.width * 3).collect();
        rows.chunks(size).all(|band| {
            let one_color = |run: &[u8]| run.chunks(3).all(|p| *p == run[..3]);
            band.iter().all(|row| *row == band[0]) && band[0].chunks(size * 3).all(one_color)
        })
    }

    /// Reads a BMP file of ours.
    pub fn from_bmp(file: &[u8]) -> Picture {
        let int = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().expect("4 bytes"));
        let (width, height) = (int(18) as usize, int(22) as usize);
        let rows = file[54..].chunks_exact((width * 3).next_multiple_of(4));
        let rgb = rows
            .rev()
            .flat_map(|row| row[..width * 3].chunks_exact(3))
            .flat_map(|c| [c[2], c[1], c[0]])
            .collect();
        Picture { width, height, rgb }
    }

    /// Reads a PNG file of ours.
    pub fn from_png(file: &[u8]) -> Picture {
        let mut reader = png::Decoder::new(std::io::Cursor::new(file))
            .read_info()
            .expect("a PNG file");
        let mut rgb = vec![0; reader.output_buffer_size().expect("a size")];
        let info = reader.next_frame(&mut rgb).expect("a whole picture");
        Picture {
            width: info.width as usize,
            height: info.height as usize,
            rgb,
        }
    }

    /// Reads what xwd writes of a window with 32 bits a pixel.
    pub fn from_xwd(file: &[u8]) -> Picture {
        let int = |i: usize| {
            let bytes = file[i * 4..i * 4 + 4].try_into().expect("4 bytes");
            u32::from_be_bytes(bytes)
        };
        let size = |i: usize| int(i) as usize;
        let (width, height, row_bytes) = (size(4), size(5), size(12));
        assert_eq!(int(11), 32, "bits a pixel");
        assert_eq!([int(14), int(15), int(16)], [0xff_0000, 0xff00, 0xff]);
        let big_endian = int(7) == 1;
        let pixels = &file[size(0) + size(19) * 12..];
        let rgb = pixels
            .chunks_exact(row_bytes)
            .take(height)
            .flat_map(|row| row[..width * 4].chunks_exact(4))
            .flat_map(|p| {
                if big_endian {
                    [p[1], p[2], p[3]]
                } else {
                    [p[2], p[1], p[0]]
                }
            })
            .collect();
        Picture { width, height, rgb }
    }
}
