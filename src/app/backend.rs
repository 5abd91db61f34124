//! winit's event loop for the display that answers, and what is special about each kind of display.

use std::panic;

use winit::event_loop::{EventLoop, EventLoopBuilder};
use winit::raw_window_handle::{HasWindowHandle, RawWindowHandle};
use winit::window::{Window, WindowAttributes};

use super::AppError;

/// What desktops call the program when they match windows to icons and rules.
#[cfg(all(unix, not(target_vendor = "apple")))]
const APP_ID: &str = "raybomb";

/// An event loop on the display that answers.
///
/// # Errors
/// [`AppError::NoWindow`] when none does, or winit makes nothing of it.
pub fn event_loop<T: 'static>() -> Result<EventLoop<T>, AppError> {
    let mut builder = EventLoop::with_user_event();
    choose_display(&mut builder)?;
    match quietly(move || builder.build()) {
        Ok(Ok(event_loop)) => Ok(event_loop),
        Ok(Err(e)) => Err(no_window(&e)),
        Err(panicked) => Err(AppError::NoWindow { why: panicked }),
    }
}

/// winit's error without the place in winit's source that it begins with.
pub fn no_window(error: &impl ToString) -> AppError {
    let text = error.to_string();
    let why = match text.split_once(": ") {
        Some((place, why)) if place.starts_with("os error at ") => why,
        _ => &text,
    };
    AppError::NoWindow { why: why.into() }
}

/// What winit panicked with, for people: where the connection to an X server is broken, Rust's debug output says so.
pub fn panic_in_words(panicked: String) -> String {
    if panicked.contains(": Connection(") {
        "the connection to the display is broken".into()
    } else {
        panicked
    }
}

/// Runs `work`, and turns a panic into its message: winit panics on X servers that lack an extension, and about windows
/// that are gone.
pub fn quietly<R>(work: impl FnOnce() -> R) -> Result<R, String> {
    let hook = panic::take_hook();
    panic::set_hook(Box::new(|_| {}));
    let result = panic::catch_unwind(panic::AssertUnwindSafe(work));
    panic::set_hook(hook);
    result.map_err(|panicked| super::painter::message_of(&*panicked))
}

#[cfg(all(unix, not(target_vendor = "apple")))]
fn choose_display<T>(builder: &mut EventLoopBuilder<T>) -> Result<(), AppError> {
    use super::display::{self, Display};
    use winit::platform::{wayland::EventLoopBuilderExtWayland, x11::EventLoopBuilderExtX11};
    match display::find(|name| std::env::var_os(name)) {
        Ok(Display::Wayland) => builder.with_wayland(),
        Ok(Display::X11) => builder.with_x11(),
        Err(why) => return Err(AppError::NoWindow { why }),
    };
    Ok(())
}

#[cfg(not(all(unix, not(target_vendor = "apple"))))]
fn choose_display<T>(_builder: &mut EventLoopBuilder<T>) -> Result<(), AppError> {
    Ok(())
}

/// The window with the program's name on it.
#[cfg(all(unix, not(target_vendor = "apple")))]
pub fn named(attributes: WindowAttributes) -> WindowAttributes {
    use winit::platform::{wayland, x11};
    let attributes = wayland::WindowAttributesExtWayland::with_name(attributes, APP_ID, APP_ID);
    x11::WindowAttributesExtX11::with_name(attributes, APP_ID, APP_ID)
}

/// The window with the program's name on it.
#[cfg(not(all(unix, not(target_vendor = "apple"))))]
pub fn named(attributes: WindowAttributes) -> WindowAttributes {
    attributes
}

/// The size of the picture for a window of this size: smaller only where an X server takes no larger one.
#[cfg(all(unix, not(target_vendor = "apple")))]
pub fn fitted(window: &Window, size: (u32, u32)) -> (u32, u32) {
    use super::surface_limit;
    // Every server takes this much, in any way.
    const SMALL: u64 = 1 << 24;
    if 4 * u64::from(size.0) * u64::from(size.1) + 4096 < SMALL {
        return size;
    }
    surface_limit::fitted(size, surface_limit::of(window))
}

/// The size of the picture for a window of this size.
#[cfg(not(all(unix, not(target_vendor = "apple"))))]
pub fn fitted(_window: &Window, size: (u32, u32)) -> (u32, u32) {
    size
}

/// True where a pixel that is shown has an opacity in its highest byte.
#[cfg(all(unix, not(target_vendor = "apple")))]
pub fn has_opacity(window: &Window) -> bool {
    super::opacity::is_in_pixels_of(window)
}

/// True where a pixel that is shown has an opacity in its highest byte.
#[cfg(not(all(unix, not(target_vendor = "apple"))))]
pub fn has_opacity(_window: &Window) -> bool {
    false
}

/// True where the window system tells when it takes the next picture: Wayland, by frame callbacks.
pub fn tells_when(window: &Window) -> bool {
    let handle = window.window_handle().map(|handle| handle.as_raw());
    matches!(handle, Ok(RawWindowHandle::Wayland(_)))
}

/// Sees to it that keys reach a new window that can be seen.
#[cfg(all(unix, not(target_vendor = "apple")))]
pub fn take_keyboard(window: &Window) {
    super::keyboard::take(window);
}

/// Sees to it that keys reach a new window that can be seen.
#[cfg(not(all(unix, not(target_vendor = "apple"))))]
pub fn take_keyboard(_window: &Window) {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_place_in_winits_source_is_left_out() {
        let why = |text: &str| match no_window(&text) {
            AppError::NoWindow { why } => why,
            other => panic!("{other}"),
        };
        assert_eq!(why("os error at src/x.rs:7: no X: none"), "no X: none");
        assert_eq!(why("os error"), "os error");
    }

    #[test]
    fn a_panic_over_a_broken_connection_is_put_in_words() {
        let words = |panicked: &str| panic_in_words(panicked.into());
        let broken = "Failed to set cursor: Connection(IoError(Custom { kind: Other, error: UnknownError }))";
        assert_eq!(words(broken), "the connection to the display is broken");
        assert_eq!(words("Failed to set cursor"), "Failed to set cursor");
    }

    #[test]
    fn a_panic_becomes_its_message() {
        assert_eq!(quietly(|| 1), Ok(1));
        let panicked: Result<(), String> = quietly(|| panic!("no {}", "XInput"));
        assert_eq!(panicked, Err("no XInput".into()));
    }
}
