//! The planes of one picture in memory.

use crate::raw::large_pages;

/// The id of a pixel whose ray hits nothing.
pub const MISS: u32 = u32::MAX;

/// A picture: rows from top to bottom, pixels `0x00RRGGBB`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Frame {
    /// Pixels a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `width * height` pixels.
    pub pixels: Vec<u32>,
}

impl Frame {
    /// A black picture.
    #[must_use]
    pub fn new(width: usize, height: usize) -> Frame {
        Frame {
            width,
            height,
            pixels: vec![0; width * height],
        }
    }

    /// Changes the size; the pixels are whatever is left over. Does nothing when the size is the same.
    pub fn resize(&mut self, width: usize, height: usize) {
        self.width = width;
        self.height = height;
        resize(&mut self.pixels, width * height, 0);
    }
}

/// What one pixel's ray hits.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The triangle's number in the file, or [`MISS`].
    pub id: u32,
    /// How far away, in lengths of the pixel's (not normalised) direction; infinite for a miss.
    pub t: f32,
}

impl Hit {
    /// Nothing.
    pub const NONE: Hit = Hit {
        id: MISS,
        t: f32::INFINITY,
    };
}

/// What the rays of a picture hit: rows from top to bottom.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hits {
    /// Pixels a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `width * height` pixels.
    pub pixels: Vec<Hit>,
}

impl Hits {
    /// Changes the size; the pixels are whatever is left over. Does nothing when the size is the same.
    pub fn resize(&mut self, width: usize, height: usize) {
        self.width = width;
        self.height = height;
        resize(&mut self.pixels, width * height, Hit::NONE);
    }
}

/// Resizes a plane; tiles write a few words in each of many rows, which goes faster where these share a page.
fn resize<T: Clone>(pixels: &mut Vec<T>, count: usize, value: T) {
    if count > pixels.capacity() {
        pixels.reserve_exact(count - pixels.len());
        large_pages(pixels.spare_capacity_mut());
    }
    pixels.resize(count, value);
}
