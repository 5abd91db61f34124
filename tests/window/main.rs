//! The window, by the real program on a real X server (Xvfb) with real keys (xdotool), mostly without a window manager,
//! and on a Wayland compositor (weston). What the window shows is compared to the bit with what `raybomb render` writes.
//!
//! Needs Xvfb, Xtigervnc, xdotool, xwd, openbox and weston (Debian: `xvfb tigervnc-standalone-server xdotool x11-apps
//! openbox weston`). Where they are missing the tests say that they are skipped; with `CI=true` they fail.
#![cfg(target_os = "linux")]

mod display;
mod faults;
mod hands;
mod kiosk;
mod managed;
mod opening;
mod picture;
mod playing;
mod proxy;
mod recording;
mod refining;
mod remembered;
mod sessions;
mod shown;
mod sides;
mod support;
mod wayland;
mod x11;
