//! The only file that names softbuffer: whole pictures into the window.

use std::fmt;
use std::num::NonZeroU32;

use softbuffer::{Context, SoftBufferError, Surface};
use winit::raw_window_handle::{HasDisplayHandle, HasWindowHandle};

use super::overlay::Canvas;
use crate::frame::Frame;

/// A pixel's opacity, where it has one: nothing is seen through it.
const OPAQUE: u32 = 0xff00_0000;

/// The window's surface.
pub struct Presenter<D, W> {
    surface: Surface<D, W>,
    has_opacity: bool,
}

/// The window system would not take the picture.
#[derive(Debug)]
pub struct PresentError(SoftBufferError);

impl fmt::Display for PresentError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            // Its own text shows the first part as Rust's debug output.
            SoftBufferError::PlatformError(Some(what), Some(why)) => write!(f, "{what}: {why}"),
            SoftBufferError::PlatformError(Some(what), None) => f.write_str(what),
            other => other.fmt(f),
        }
    }
}

impl<D: HasDisplayHandle, W: HasWindowHandle> Presenter<D, W> {
    /// A surface for `window`; `has_opacity` tells whether the highest byte of its pixels is their opacity.
    ///
    /// # Errors
    /// When the window system has no pixels to offer.
    pub fn new(display: D, window: W, has_opacity: bool) -> Result<Presenter<D, W>, PresentError> {
        let context = Context::new(display).map_err(PresentError)?;
        let surface = Surface::new(&context, window).map_err(PresentError)?;
        Ok(Presenter {
            surface,
            has_opacity,
        })
    }

    /// Copies `frame` (none: black) into the window, each of its pixels as a square of `pixel_size`, lets `draw`
    /// draw over the copy, shows it. A frame of another size is cut off, or stands on black, at the upper left. A
    /// window without pixels shows nothing.
    ///
    /// # Errors
    /// When the window system does not take it.
    pub fn present(
        &mut self,
        (width, height): (u32, u32),
        frame: Option<&Frame>,
        pixel_size: usize,
        draw: impl FnOnce(&mut Canvas<'_>),
    ) -> Result<(), PresentError> {
        let (Some(columns), Some(rows)) = (NonZeroU32::new(width), NonZeroU32::new(height)) else {
            return Ok(());
        };
        self.surface.resize(columns, rows).map_err(PresentError)?;
        let mut buffer = self.surface.buffer_mut().map_err(PresentError)?;
        let mut canvas = Canvas {
            pixels: &mut buffer,
            // A window's size fits in memory.
            width: width as usize,
            height: height as usize,
        };
        copy(frame, pixel_size, &mut canvas);
        draw(&mut canvas);
        if self.has_opacity {
            canvas.pixels.iter_mut().for_each(|pixel| *pixel |= OPAQUE);
        }
        buffer.present().map_err(PresentError)
    }
}

/// Fills the canvas with the frame, and with black where there is none.
fn copy(frame: Option<&Frame>, pixel_size: usize, canvas: &mut Canvas<'_>) {
    let Some(frame) = frame.filter(|f| f.width > 0 && f.height > 0) else {
        canvas.pixels.fill(0);
        return;
    };
    if pixel_size == 1 && (frame.width, frame.height) == (canvas.width, canvas.height) {
        canvas.pixels.copy_from_slice(&frame.pixels);
        return;
    }
    let covered = (frame.width * pixel_size, frame.height * pixel_size);
    if covered.0 < canvas.width || covered.1 < canvas.height {
        canvas.pixels.fill(0);
    }
    let columns = covered.0.min(canvas.width);
    let from = frame.pixels.chunks_exact(frame.width);
    let to = canvas.pixels.chunks_mut(canvas.width * pixel_size);
    for (from, band) in from.zip(to) {
        let (first, others) = band.split_at_mut(canvas.width);
        enlarge(from, pixel_size, &mut first[..columns]);
        for row in others.chunks_exact_mut(canvas.width) {
            row[..columns].copy_from_slice(&first[..columns]);
        }
    }
}

/// Writes each pixel of `from` `pixel_size` times, as far as `to` goes.
fn enlarge(from: &[u32], pixel_size: usize, to: &mut [u32]) {
    if pixel_size == 1 {
        return to.copy_from_slice(&from[..to.len()]);
    }
    for (run, &pixel) in to.chunks_mut(pixel_size).zip(from) {
        run.fill(pixel);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn copied(frame: Option<&Frame>, width: usize, height: usize) -> Vec<u32> {
        enlarged(frame, 1, width, height)
    }

    fn enlarged(frame: Option<&Frame>, pixel_size: usize, width: usize, height: usize) -> Vec<u32> {
        let mut pixels = vec![9; width * height];
        let mut canvas = Canvas {
            pixels: &mut pixels,
            width,
            height,
        };
        copy(frame, pixel_size, &mut canvas);
        pixels
    }

    #[test]
    fn frames_of_another_size_are_cut_off_or_stand_on_black() {
        let frame = Frame {
            width: 2,
            height: 2,
            pixels: vec![1, 2, 3, 4],
        };
        assert_eq!(copied(Some(&frame), 2, 2), [1, 2, 3, 4]);
        assert_eq!(copied(Some(&frame), 1, 3), [1, 3, 0]);
        assert_eq!(copied(Some(&frame), 3, 1), [1, 2, 0]);
        assert_eq!(copied(None, 2, 1), [0, 0]);
        assert_eq!(copied(Some(&Frame::default()), 1, 1), [0]);
    }

    #[test]
    fn coarse_pixels_become_squares_that_are_cut_off_at_the_window() {
        let frame = Frame {
            width: 2,
            height: 2,
            pixels: vec![1, 2, 3, 4],
        };
        let shown = enlarged(Some(&frame), 2, 3, 3);
        assert_eq!(shown, [1, 1, 2, 1, 1, 2, 3, 3, 4]);
        assert_eq!(enlarged(Some(&frame), 3, 2, 1), [1, 1]);
        let wide = enlarged(Some(&frame), 2, 5, 1);
        assert_eq!(wide, [1, 1, 2, 2, 0]);
    }
}
