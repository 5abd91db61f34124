//! A client of its own on the server: does what a desktop does to windows, and what xdotool cannot.

use std::path::Path;

use x11rb::connection::Connection as _;
use x11rb::protocol::Event;
use x11rb::protocol::xproto::{
    ClientMessageEvent, ConfigureWindowAux, ConnectionExt as _, CreateWindowAux, EventMask,
    ImageFormat, ImageOrder, PropMode, SELECTION_NOTIFY_EVENT, SelectionNotifyEvent, WindowClass,
};
use x11rb::rust_connection::RustConnection;
use x11rb::wrapper::ConnectionExt as _;
use x11rb::{COPY_DEPTH_FROM_PARENT, COPY_FROM_PARENT, CURRENT_TIME};

use crate::support::until;

/// A connection to the server.
pub struct Client {
    connection: RustConnection,
    root: u32,
}

impl Client {
    pub fn of(display: &str) -> Client {
        let (connection, screen) = x11rb::connect(Some(display)).expect("a server");
        let root = connection.setup().roots[screen].root;
        Client { connection, root }
    }

    /// Gives a window one size after the other, as fast as the server takes them.
    pub fn resize(&self, window: u32, sizes: impl IntoIterator<Item = (u32, u32)>) {
        for (width, height) in sizes {
            let size = ConfigureWindowAux::new().width(width).height(height);
            self.connection
                .configure_window(window, &size)
                .expect("sent");
        }
        self.connection.sync().expect("done");
    }

    /// The highest byte of each pixel of a window.
    pub fn highest_bytes(&self, window: u32) -> Vec<u8> {
        let asked = self.connection.get_geometry(window).expect("sent");
        let size = asked.reply().expect("an answer");
        let (format, planes) = (ImageFormat::Z_PIXMAP, !0);
        let (width, height) = (size.width, size.height);
        let asked = self
            .connection
            .get_image(format, window, 0, 0, width, height, planes);
        let pixels = asked.expect("sent").reply().expect("a picture").data;
        let order = self.connection.setup().image_byte_order;
        let highest = if order == ImageOrder::LSB_FIRST { 3 } else { 0 };
        pixels.iter().skip(highest).step_by(4).copied().collect()
    }

    /// Takes a window from the screen, as minimising does, or puts it back.
    pub fn show(&self, window: u32, shown: bool) {
        let sent = if shown {
            self.connection.map_window(window)
        } else {
            self.connection.unmap_window(window)
        };
        sent.expect("sent").check().expect("done");
    }

    /// Becomes the desktop's settings daemon (XSETTINGS). Programs look for it when they start.
    pub fn begin_settings(&self) -> Settings<'_> {
        let window = self.hidden_window();
        let settings = Settings {
            client: self,
            window,
        };
        settings.set_dpi(96);
        let selection = self.atom("_XSETTINGS_S0");
        self.connection
            .set_selection_owner(window, selection, CURRENT_TIME)
            .expect("sent")
            .check()
            .expect("done");
        settings
    }

    /// Asks a window to close, as the button in its frame does.
    pub fn close(&self, window: u32) {
        let [protocols, delete] = ["WM_PROTOCOLS", "WM_DELETE_WINDOW"].map(|name| self.atom(name));
        self.send(window, protocols, [delete, CURRENT_TIME, 0, 0, 0]);
    }

    /// Asks the window manager to let a window fill the screen.
    pub fn maximize(&self, window: u32) {
        let [state, wide, high] = [
            "_NET_WM_STATE",
            "_NET_WM_STATE_MAXIMIZED_HORZ",
            "_NET_WM_STATE_MAXIMIZED_VERT",
        ]
        .map(|name| self.atom(name));
        let add = 1;
        let message = ClientMessageEvent::new(32, window, state, [add, wide, high, 1, 0]);
        let to_manager = EventMask::SUBSTRUCTURE_REDIRECT | EventMask::SUBSTRUCTURE_NOTIFY;
        self.connection
            .send_event(false, self.root, to_manager, message)
            .expect("sent")
            .check()
            .expect("done");
    }

    fn send(&self, window: u32, kind: u32, data: [u32; 5]) {
        let message = ClientMessageEvent::new(32, window, kind, data);
        self.connection
            .send_event(false, window, EventMask::NO_EVENT, message)
            .expect("sent")
            .check()
            .expect("done");
    }

    /// A window that nobody sees.
    fn hidden_window(&self) -> u32 {
        let window = self.connection.generate_id().expect("a number");
        let (depth, class, visual) = (
            COPY_DEPTH_FROM_PARENT,
            WindowClass::INPUT_OUTPUT,
            COPY_FROM_PARENT,
        );
        let plain = CreateWindowAux::new();
        self.connection
            .create_window(
                depth, window, self.root, 0, 0, 1, 1, 0, class, visual, &plain,
            )
            .expect("sent")
            .check()
            .expect("done");
        window
    }

    /// Whether there is a window manager.
    pub fn is_managed(&self) -> bool {
        let manager = self.atom("WM_S0");
        let asked = self.connection.get_selection_owner(manager).expect("sent");
        asked.reply().expect("an answer").owner != x11rb::NONE
    }

    fn atom(&self, name: &str) -> u32 {
        let asked = self
            .connection
            .intern_atom(false, name.as_bytes())
            .expect("sent");
        asked.reply().expect("an atom").atom
    }

    /// Drags a file over a window and lets it go there, by the protocol of file managers (XDND 5).
    pub fn drop_file(&self, window: u32, file: &Path) {
        let source = self.hidden_window();
        let [selection, list, copy] =
            ["XdndSelection", "text/uri-list", "XdndActionCopy"].map(|name| self.atom(name));
        self.connection
            .set_selection_owner(source, selection, CURRENT_TIME)
            .expect("sent");
        let send = |kind: &str, data| self.send(window, self.atom(kind), data);
        send("XdndEnter", [source, 5 << 24, list, 0, 0]);
        send(
            "XdndPosition",
            [source, 0, (10 << 16) | 10, CURRENT_TIME, copy],
        );
        // It asks for the name before anything is let go.
        until("the question what is dragged", || {
            let Some(Event::SelectionRequest(asked)) =
                self.connection.poll_for_event().expect("a server")
            else {
                return None;
            };
            let uri = format!("file://{}\r\n", file.display());
            self.connection
                .change_property8(
                    PropMode::REPLACE,
                    asked.requestor,
                    asked.property,
                    list,
                    uri.as_bytes(),
                )
                .expect("sent");
            let answer = SelectionNotifyEvent {
                response_type: SELECTION_NOTIFY_EVENT,
                sequence: 0,
                time: asked.time,
                requestor: asked.requestor,
                selection: asked.selection,
                target: asked.target,
                property: asked.property,
            };
            self.connection
                .send_event(false, asked.requestor, EventMask::NO_EVENT, answer)
                .expect("sent");
            self.connection.flush().expect("sent");
            Some(())
        });
        send("XdndDrop", [source, 0, CURRENT_TIME, 0, 0]);
    }
}

/// The settings of a desktop.
pub struct Settings<'a> {
    client: &'a Client,
    window: u32,
}

impl Settings<'_> {
    /// The dots per inch: 96 is scale factor 1.
    pub fn set_dpi(&self, dpi: u32) {
        let name = b"Xft/DPI";
        let mut bytes = vec![0, 0, 0, 0];
        // A serial number, and how many settings follow; then its kind, a number, and its name, padded.
        bytes.extend([dpi, 1].map(u32::to_le_bytes).concat());
        bytes.extend([0, 0, 7, 0]);
        bytes.extend(name);
        bytes.push(0);
        bytes.extend([dpi, dpi * 1024].map(u32::to_le_bytes).concat());
        let kind = self.client.atom("_XSETTINGS_SETTINGS");
        self.client
            .connection
            .change_property8(PropMode::REPLACE, self.window, kind, kind, &bytes)
            .expect("sent")
            .check()
            .expect("done");
    }
}
