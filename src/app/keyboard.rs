//! The keyboard on an X server without a window manager: nobody gives it to a new window.

use winit::raw_window_handle::{HasWindowHandle, RawWindowHandle};
use x11rb::CURRENT_TIME;
use x11rb::connection::Connection as _;
use x11rb::protocol::xproto::{ConnectionExt as _, InputFocus};

/// Gives `window` the keyboard if there is no window manager and no window has it. Whatever stands in the way, the
/// window goes on without.
pub fn take(window: &impl HasWindowHandle) {
    let handle = window.window_handle().map(|handle| handle.as_raw());
    let id = match handle {
        Ok(RawWindowHandle::Xlib(handle)) => u32::try_from(handle.window).ok(),
        Ok(RawWindowHandle::Xcb(handle)) => Some(handle.window.get()),
        _ => None,
    };
    if let Some(id) = id {
        let _ = take_for(id);
    }
}

fn take_for(window: u32) -> Option<()> {
    // A connection of our own: errors of it, about a window that is gone, are nobody's end.
    let (connection, screen) = x11rb::connect(None).ok()?;
    let manager = format!("WM_S{screen}");
    let manager = connection
        .intern_atom(false, manager.as_bytes())
        .ok()?
        .reply()
        .ok()?;
    let owner = connection
        .get_selection_owner(manager.atom)
        .ok()?
        .reply()
        .ok()?
        .owner;
    let focus = connection.get_input_focus().ok()?.reply().ok()?.focus;
    // No window of a program: none at all, whichever is under the mouse, or what remains when the last one went.
    let root = connection.setup().roots.get(screen)?.root;
    let is_free = [
        InputFocus::NONE.into(),
        InputFocus::POINTER_ROOT.into(),
        root,
    ]
    .contains(&focus);
    if owner != x11rb::NONE || !is_free {
        return None;
    }
    let asked = connection.set_input_focus(InputFocus::POINTER_ROOT, window, CURRENT_TIME);
    asked.ok()?.check().ok()?;
    connection.flush().ok()
}
