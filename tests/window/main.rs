//! The window, by the real program on a real X server (Xvfb) with real keys (xdotool), no window manager.
//! What the window shows is compared to the bit with what `raybomb render` writes.
//!
//! Needs Xvfb, xdotool and xwd (Debian: `xvfb xdotool x11-apps`). Where they are missing the tests say that they
//! are skipped; with `CI=true` they fail.
#![cfg(target_os = "linux")]

mod display;
mod faults;
mod hands;
mod kiosk;
mod opening;
mod playing;
mod recording;
mod refining;
mod sessions;
mod shown;
mod sides;
mod support;
