//! The viewer: a window that shows the scene, turns with the hand and plays the operations.
//!
//! Events become [`action`]s, actions change the [`state`], the state wishes for a picture, [`pace`] decides when and
//! how fine, the [`painter`] thread renders it (and a [`companion`], bit by bit, what slow engines make of it), the
//! [`window`] shows it whole. Scenes come by way of the [`opener`],
//! which loads and watches files on other threads. Everything but the window itself is plain data that tests reach.
//! The picture is rendered by the same `Renderer` as a file's, from the same camera of the same frame number: the
//! window's pixels are the file's, to the bit. What the hand does to the camera is kept as it would be saved
//! ([`moves`]), so that stays true of scenes saved from the window; a [`journal`] keeps it from crashes.

mod action;
mod backend;
mod bindings;
mod companion;
#[cfg(all(unix, not(target_vendor = "apple")))]
mod display;
pub mod folders;
mod governor;
mod input;
mod journal;
#[cfg(all(unix, not(target_vendor = "apple")))]
mod keyboard;
mod keymap;
mod keys;
mod kiosk;
mod latency;
mod loader;
mod memory;
mod moves;
#[cfg(all(unix, not(target_vendor = "apple")))]
mod opacity;
mod opener;
mod orbit;
mod overlay;
mod pace;
mod painter;
mod panics;
mod present;
mod save;
mod scenes;
mod screen;
mod screenshot;
mod script;
mod scrub;
mod session;
mod side;
mod state;
mod statistics;
#[cfg(all(unix, not(target_vendor = "apple")))]
mod surface_limit;
mod watch;
mod window;

use std::fmt;
use std::path::PathBuf;

use crate::camera::{Camera, Pivot};
use crate::geometry::Aabb;
use crate::render::{Samples, Settings};
use crate::scene::CameraSetting;
use crate::simd::Kernel;
use crate::timeline::Timing;

/// What to show and how.
#[derive(Debug)]
pub struct AppOptions {
    /// Where the scene comes from.
    pub source: Source,
    /// The picture's size in physical pixels; `None`: the projection plane's shape.
    pub size: Option<(usize, usize)>,
    /// How to render, to begin with.
    pub settings: Settings,
    /// Samples a pixel when nothing moves.
    pub samples: Samples,
    /// Pictures a second while something moves: those that would be late are coarser.
    pub target_fps: f64,
    /// Threads that render; 0: one a core.
    pub threads: usize,
    /// How operations become frames.
    pub timing: Timing,
    /// Map the projection plane onto the picture as it is.
    pub stretch: bool,
    /// What operations and hands turn the camera about.
    pub pivot: Pivot,
    /// Scenes to be shown in turn, after `source`, which is the first of them, and nothing that hands do.
    pub kiosk: Option<Vec<Source>>,
    /// Begin by playing the operations.
    pub play: bool,
    /// Something may be drawn over the picture when it is asked for.
    pub overlay: bool,
    /// Print each pick, one JSON object a line.
    pub print_picks: bool,
    /// Which chord does what.
    pub keymap: Keymap,
    /// Where to remember the window's size and place and the moves that no file has; `None`: nowhere.
    pub memory: Option<PathBuf>,
    /// A file of actions to play; `-` is the standard input.
    pub play_actions: Option<PathBuf>,
    /// A file that takes the actions of the session.
    pub record_actions: Option<PathBuf>,
}

impl AppOptions {
    /// The state before there is a scene, with the size that the window opens with.
    fn initial_state(&self) -> state::State {
        let base = Camera::default_for(Aabb::EMPTY);
        let setting = state::Setting {
            camera: CameraSetting::Default,
            base,
            operations: Vec::new(),
            timing: self.timing,
            pivot: self.pivot.point(Aabb::EMPTY),
            bounds: Aabb::EMPTY,
            stretch: self.stretch,
            overlay: self.overlay,
            print_picks: self.print_picks,
            kernels: Kernel::available(),
        };
        let size = self.size.or_else(|| self.source.default_size());
        let size = size.unwrap_or_else(|| base.default_size());
        state::State::new(setting, self.settings, size)
    }
}

/// Why there is no window, or no longer one.
#[derive(Clone, Debug, PartialEq)]
pub enum AppError {
    /// No display answers, or it gives no window: the one failure that says nothing against the scene.
    NoWindow {
        /// What was tried.
        why: String,
    },
    /// There is no scene to show.
    NoScene(LoadError),
    /// Something that a window needs failed.
    Broken {
        /// What.
        why: String,
    },
}

impl fmt::Display for AppError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            AppError::NoWindow { why } => write!(
                f,
                "no window to be had: {why}\nhint: `raybomb render SCENE -o picture.png` needs no window"
            ),
            AppError::NoScene(e) => e.fmt(f),
            AppError::Broken { why } => f.write_str(why),
        }
    }
}

impl std::error::Error for AppError {}

pub use journal::interrupted;
pub use keymap::{Keymap, Rebinding, names as names_of_keys};
pub use loader::{LoadError, Source, read_file};
pub use opener::scenes_in;
pub use window::run;
