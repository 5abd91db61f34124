//! Whether the pixels of an X11 window have an opacity.
//!
//! Windows have the depth of their screen: 24, as a rule. Where that is 32, compositors read the fourth byte of a pixel
//! as its opacity, and ours is 0: nothing would be seen of the picture but what lies behind it.

use winit::raw_window_handle::{HasWindowHandle, RawWindowHandle};
use x11rb::connection::Connection as _;

/// True where a pixel's fourth byte has a meaning.
#[must_use]
pub fn is_in_pixels_of(window: &impl HasWindowHandle) -> bool {
    let visual = match window.window_handle().map(|handle| handle.as_raw()) {
        Ok(RawWindowHandle::Xlib(handle)) => u32::try_from(handle.visual_id).ok(),
        Ok(RawWindowHandle::Xcb(handle)) => handle.visual_id.map(u32::from),
        _ => None,
    };
    visual.is_some_and(|visual| depth_of(visual) == Some(32))
}

/// Bits of a pixel that are in use, by a connection of our own: what it needs is in the server's greeting.
fn depth_of(visual: u32) -> Option<u8> {
    let (connection, screen) = x11rb::connect(None).ok()?;
    let depths = &connection.setup().roots.get(screen)?.allowed_depths;
    let has_visual = |v: &x11rb::protocol::xproto::Visualtype| v.visual_id == visual;
    let found = depths.iter().find(|d| d.visuals.iter().any(has_visual));
    found.map(|d| d.depth)
}
