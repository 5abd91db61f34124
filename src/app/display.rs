//! Is there a display to open a window on, and of which kind?
//!
//! winit tries one kind and cannot be asked again after a failure. So both are knocked at first: a
//! `WAYLAND_DISPLAY` that is left over from a session long gone must not hide a working X server.

use std::ffi::OsString;
use std::fs;
use std::net::{TcpStream, ToSocketAddrs};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// How long an X server on another machine may take to answer.
const TCP_TIMEOUT: Duration = Duration::from_secs(3);

/// A kind of display.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Display {
    /// A Wayland compositor.
    Wayland,
    /// An X server.
    X11,
}

/// The display that answers, Wayland first. `env` looks up environment variables.
///
/// # Errors
/// What was tried, in words.
pub fn find(env: impl Fn(&str) -> Option<OsString>) -> Result<Display, String> {
    let env = |name: &str| env(name).filter(|value| !value.is_empty());
    let wayland = match wayland(&env) {
        Ok(()) => return Ok(Display::Wayland),
        Err(why) => why,
    };
    match x11(&env) {
        Ok(()) => Ok(Display::X11),
        Err(x11) => Err(format!("{wayland}; {x11}")),
    }
}

/// Knocks where the Wayland library would, in its order.
fn wayland(env: &impl Fn(&str) -> Option<OsString>) -> Result<(), String> {
    if let Some(fd) = env("WAYLAND_SOCKET") {
        // An open socket handed over by the parent; to look is safe, to talk would use it up.
        return match fs::metadata(Path::new("/proc/self/fd").join(&fd)) {
            Ok(_) => Ok(()),
            Err(_) => Err(format!("WAYLAND_SOCKET={} is not open", fd.display())),
        };
    }
    let name = PathBuf::from(env("WAYLAND_DISPLAY").ok_or("WAYLAND_DISPLAY is not set")?);
    let path = if name.is_absolute() {
        name
    } else {
        let folder = env("XDG_RUNTIME_DIR").ok_or("XDG_RUNTIME_DIR is not set")?;
        Path::new(&folder).join(name)
    };
    let no_answer = |e| format!("no Wayland compositor at {}: {e}", path.display());
    UnixStream::connect(&path).map(drop).map_err(no_answer)
}

/// Knocks at the X server that `DISPLAY` names.
fn x11(env: &impl Fn(&str) -> Option<OsString>) -> Result<(), String> {
    let display = env("DISPLAY").ok_or("DISPLAY is not set")?;
    let display = display.to_string_lossy();
    let (host, number) =
        parse_x11(&display).ok_or_else(|| format!("DISPLAY={display} names no display"))?;
    let answers = if host.is_empty() {
        local_x11(number)
    } else {
        remote_x11(host, number)
    };
    answers.ok_or_else(|| format!("no X server at DISPLAY={display}"))
}

/// `host:number.screen` to host (empty: this machine) and number.
fn parse_x11(display: &str) -> Option<(&str, u16)> {
    let (host, rest) = display.rsplit_once(':')?;
    let number = rest.split('.').next()?.parse().ok()?;
    let host = host.strip_suffix("/unix").map_or(host, |_| "");
    let host = host.strip_prefix("tcp/").unwrap_or(host);
    let host = host.trim_start_matches('[').trim_end_matches(']');
    Some((if host == "unix" { "" } else { host }, number))
}

fn local_x11(number: u16) -> Option<()> {
    let path = format!("/tmp/.X11-unix/X{number}");
    abstract_socket(&path)
        .or_else(|| UnixStream::connect(&path).ok())
        .map(drop)
        .or_else(|| remote_x11("localhost", number))
}

#[cfg(any(target_os = "linux", target_os = "android"))]
fn abstract_socket(name: &str) -> Option<UnixStream> {
    use std::os::linux::net::SocketAddrExt;
    use std::os::unix::net::SocketAddr;
    let address = SocketAddr::from_abstract_name(name).ok()?;
    UnixStream::connect_addr(&address).ok()
}

#[cfg(not(any(target_os = "linux", target_os = "android")))]
fn abstract_socket(_name: &str) -> Option<UnixStream> {
    None
}

fn remote_x11(host: &str, number: u16) -> Option<()> {
    let port = number.checked_add(6000)?;
    let mut addresses = (host, port).to_socket_addrs().ok()?;
    addresses
        .find_map(|address| TcpStream::connect_timeout(&address, TCP_TIMEOUT).ok())
        .map(drop)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::net::UnixListener;

    fn find_with(vars: &[(&str, &str)]) -> Result<Display, String> {
        find(|name| {
            let var = vars.iter().find(|(n, _)| *n == name);
            var.map(|(_, value)| value.into())
        })
    }

    #[test]
    fn display_names_are_read_as_the_x_library_does() {
        assert_eq!(parse_x11(":7"), Some(("", 7)));
        assert_eq!(parse_x11(":7.1"), Some(("", 7)));
        assert_eq!(parse_x11("unix:0"), Some(("", 0)));
        assert_eq!(parse_x11("me/unix:3"), Some(("", 3)));
        assert_eq!(parse_x11("localhost:10.0"), Some(("localhost", 10)));
        assert_eq!(parse_x11("tcp/there:1"), Some(("there", 1)));
        assert_eq!(parse_x11("[::1]:0"), Some(("::1", 0)));
        assert_eq!(parse_x11("nonsense"), None);
        assert_eq!(parse_x11(":x"), None);
    }

    #[test]
    fn nothing_set_and_empty_variables_are_no_display() {
        let why = find_with(&[]).unwrap_err();
        assert_eq!(why, "WAYLAND_DISPLAY is not set; DISPLAY is not set");
        assert!(find_with(&[("DISPLAY", ""), ("WAYLAND_DISPLAY", "")]).is_err());
    }

    #[test]
    fn a_compositor_that_listens_is_found_and_a_stale_one_is_not() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("wayland-9");
        let listener = UnixListener::bind(&path).expect("a socket");
        let runtime = folder.path().to_str().expect("a plain path");
        let vars = [
            ("XDG_RUNTIME_DIR", runtime),
            ("WAYLAND_DISPLAY", "wayland-9"),
        ];
        assert!(matches!(find_with(&vars), Ok(Display::Wayland)));
        let absolute = path.to_str().expect("a plain path");
        let found = find_with(&[("WAYLAND_DISPLAY", absolute)]);
        assert!(matches!(found, Ok(Display::Wayland)));
        drop(listener);
        let why = find_with(&vars).unwrap_err();
        assert!(why.contains("no Wayland compositor at"), "{why}");
    }

    #[test]
    fn a_closed_wayland_socket_is_no_display() {
        assert!(find_with(&[("WAYLAND_SOCKET", "9999")]).is_err());
    }
}
