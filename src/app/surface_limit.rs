//! The largest picture that an X server takes when it shares no memory with us.
//!
//! Then a picture travels in one request, which has a largest size; softbuffer 0.4.8 sends it all the same, and the
//! server hangs up. So whoever has a large picture asks here first.

use winit::raw_window_handle::{HasWindowHandle, RawWindowHandle};
use x11rb::connection::{Connection as _, RequestConnection as _};
use x11rb::protocol::shm;

/// Bytes of a request that are not the picture's, rounded up.
const HEADER: usize = 64;

/// How many bytes of pixels `window` takes at most; `None`: as many as it has.
#[must_use]
pub fn of(window: &impl HasWindowHandle) -> Option<usize> {
    let handle = window.window_handle().ok()?.as_raw();
    let is_x11 = matches!(handle, RawWindowHandle::Xlib(_) | RawWindowHandle::Xcb(_));
    // A connection of our own: it costs a few round trips, and only where a picture is large.
    let (connection, _) = x11rb::connect(None).ok().filter(|_| is_x11)?;
    let shares = connection.extension_information(shm::X11_EXTENSION_NAME);
    let is_local = std::env::var("DISPLAY").is_ok_and(|d| d.starts_with([':', '/']));
    match shares {
        Ok(Some(_)) if is_local => None,
        _ => {
            connection.flush().ok()?;
            Some(connection.maximum_request_bytes().saturating_sub(HEADER))
        }
    }
}

/// The largest size of the shape of `width` x `height` whose pixels, of 4 bytes each, fit into `limit`.
#[must_use]
pub fn fitted((width, height): (u32, u32), limit: Option<usize>) -> (u32, u32) {
    let bytes = 4.0 * f64::from(width) * f64::from(height);
    match limit {
        Some(limit) if bytes > limit as f64 => {
            let scale = (limit as f64 / bytes).sqrt();
            // Rounded down; a window one pixel high keeps it, and gives up more of its width.
            let side = |n: u32| ((f64::from(n) * scale) as u32).max(1);
            let (width, height) = (side(width), side(height));
            let most = u32::try_from(limit / 4).unwrap_or(u32::MAX);
            (
                width.min((most / height).max(1)),
                height.min((most / width).max(1)),
            )
        }
        _ => (width, height),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_that_fit_stay_and_others_keep_their_shape() {
        assert_eq!(fitted((640, 480), None), (640, 480));
        assert_eq!(fitted((640, 480), Some(640 * 480 * 4)), (640, 480));
        let (w, h) = fitted((4096, 2160), Some(1 << 24));
        assert!(4 * w * h <= 1 << 24 && 4 * w * h > (1 << 24) - 40_000);
        let shape = f64::from(w) / f64::from(h) * 2160.0 / 4096.0;
        assert!((shape - 1.0).abs() < 1e-3, "{w}x{h}");
        assert_eq!(fitted((1, 60_000), Some(4000)), (1, 1000));
        assert_eq!(fitted((60_000, 1), Some(4000)), (1000, 1));
    }
}
