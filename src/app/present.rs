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
        // A window's size fits in memory.
        let mut canvas = Canvas::over(frame, pixel_size, &mut buffer, width as usize);
        draw(&mut canvas);
        let pixels = canvas.pixels();
        if self.has_opacity {
            pixels.iter_mut().for_each(|pixel| *pixel |= OPAQUE);
        }
        buffer.present().map_err(PresentError)
    }
}
