//! A display between the program and the X server, whose half that hears the program can be closed alone: what the
//! server says still arrives, and the first word of the program's own finds nobody. A server that dies looks like this
//! for a moment, which no test can hit by killing it.

use std::io::{Read, Write};
use std::net::Shutdown;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::PathBuf;
use std::sync::{Arc, Mutex};

/// The display, until it is dropped.
pub struct Proxy {
    /// What `DISPLAY` is to be.
    pub display: String,
    socket: PathBuf,
    programs: Arc<Mutex<Vec<UnixStream>>>,
}

impl Proxy {
    /// Passes everything on to and from the local display `to`, `:N`.
    pub fn to(display: &str) -> Proxy {
        let folder = PathBuf::from("/tmp/.X11-unix");
        let server = folder.join(display.replace(':', "X"));
        // Higher than those that servers choose for themselves.
        let (number, listener) = (9000..9999)
            .find_map(|number| {
                let socket = folder.join(format!("X{number}"));
                Some((number, UnixListener::bind(socket).ok()?))
            })
            .expect("a free number");
        let programs = Arc::new(Mutex::new(Vec::new()));
        let heard = Arc::clone(&programs);
        std::thread::spawn(move || {
            for program in listener.incoming().map_while(Result::ok) {
                let Ok(server) = UnixStream::connect(&server) else {
                    return;
                };
                let twin = |stream: &UnixStream| stream.try_clone().expect("another handle");
                heard.lock().expect("no panic").push(twin(&program));
                pass(twin(&program), twin(&server));
                pass(server, program);
            }
        });
        Proxy {
            display: format!(":{number}"),
            socket: folder.join(format!("X{number}")),
            programs,
        }
    }

    /// From now on nobody hears what programs say.
    pub fn go_deaf(&self) {
        for program in &*self.programs.lock().expect("no panic") {
            // Those that have ended do not mind.
            let _ = program.shutdown(Shutdown::Read);
        }
    }
}

impl Drop for Proxy {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.socket);
    }
}

/// Passes on what is said, on a thread of its own. The end of it ends nothing.
fn pass(mut from: UnixStream, mut to: UnixStream) {
    std::thread::spawn(move || {
        let mut bytes = [0; 1 << 16];
        while let Ok(count @ 1..) = from.read(&mut bytes) {
            if to.write_all(&bytes[..count]).is_err() {
                return;
            }
        }
    });
}
