//! What the viewer shows: plain data that actions change and time moves. No window, no clock, no files.
//!
//! `hand.rs` moves the camera, `film.rs` plays, `picks.rs` tells what is seen at a place, `scene.rs` takes another
//! scene, `sides.rs` says how the picture is made, `keep.rs` gives a journal
//! what it keeps, `document.rs` writes the picture shown as a scene, `question.rs` asks before moves are lost.

mod document;
mod film;
mod hand;
mod keep;
mod picks;
mod question;
mod scene;
mod sides;

use std::cell::RefCell;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use glam::{DMat3, DVec3};

use super::action::Action;
use super::bindings::Spot;
use super::journal::Kept;
use super::keymap::Keymap;
use super::moves::Moves;
use super::overlay::zoom_factor;
use super::scrub::BarWish;
use super::side::Split;
use crate::camera::{Camera, View};
use crate::geometry::Aabb;
use crate::render::{Picked, Settings, ViewMode};
use crate::scene::{Axis, CameraSetting, Operation};
use crate::simd::Kernel;
use crate::timeline::{Composer, Playback, Timing, operations_at};

pub use document::Document;
pub use scene::Subject;
pub use sides::word;

/// The overlay is at most so many steps larger or smaller than usual.
const MAX_ZOOM: i32 = 8;
/// Letters of half the size are hardly to be read.
const MIN_ZOOM: i32 = -3;
/// How long a message stays.
const MESSAGE: Duration = Duration::from_secs(3);

const MODES: [ViewMode; 5] = [
    ViewMode::Shaded,
    ViewMode::Id,
    ViewMode::Normal,
    ViewMode::Depth,
    ViewMode::Cost,
];

/// What never changes while a scene is open.
#[derive(Clone, Debug)]
pub struct Setting {
    /// As the scene states it.
    pub camera: CameraSetting,
    /// The same, before any operation.
    pub base: Camera,
    /// The scene's.
    pub operations: Vec<Operation>,
    /// How they become frames.
    pub timing: Timing,
    /// What they turn the camera about, and hands to begin with.
    pub pivot: DVec3,
    /// The box of all triangles.
    pub bounds: Aabb,
    /// The plane is mapped onto the window as it is.
    pub stretch: bool,
    /// Something may be drawn over the picture.
    pub overlay: bool,
    /// Picks are printed.
    pub print_picks: bool,
    /// The kernels to choose from.
    pub kernels: Vec<Kernel>,
}

/// Something to do outside, that an action or the time asks for.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// Save the picture shown.
    Screenshot,
    /// Tell the user on the terminal.
    Report(String),
    /// Print on the standard output, ends of lines included.
    Print(String),
    /// Find out what is seen, and come back with it ([`State::probed`]).
    Probe(Probe),
    /// Write the scene's file, and come back ([`State::saved`]).
    Save(Document),
    /// Open another scene of the folder.
    Browse {
        /// The next one by name; otherwise the one before.
        forward: bool,
    },
    /// Open the scene of this file.
    Open(PathBuf),
    /// Fill the screen, or do not.
    Fullscreen(bool),
    /// Go on with moves that were left over ([`State::take_back`]).
    TakeBack(Box<Kept>),
    /// Nobody wants them.
    DropMoves,
    /// End the program.
    Quit,
}

/// The question what one pixel of a picture shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Probe {
    /// The number of the scene, see [`State::probed`].
    pub scene: u64,
    /// The picture.
    pub wish: Wish,
    /// Column and row.
    pub pixel: (usize, usize),
    /// What the answer is for.
    pub spot: Spot,
}

/// What to render.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wish {
    /// From where, and how large.
    pub view: View,
    /// How.
    pub settings: Settings,
    /// How the right part of it, if that is made in another way.
    pub split: Option<Split>,
}

/// What to draw over the picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OverlayWish {
    /// The figures.
    pub statistics: bool,
    /// The cross of the axes.
    pub axes: bool,
    /// The first column right of the divider.
    pub divider: Option<usize>,
    /// The key sheet.
    pub sheet: bool,
    /// What was picked, line by line.
    pub picked: Vec<(String, String)>,
    /// Where the points that were picked are seen, in pixels.
    pub marks: Vec<(i32, i32)>,
    /// Whether moves are recorded, in words; `None`: nobody wants that.
    pub recording: Option<String>,
    /// The bar of frames.
    pub bar: Option<BarWish>,
    /// A line that waits for an answer.
    pub question: Option<String>,
    /// A line of text.
    pub message: Option<String>,
    /// Steps by which all of it is larger than usual.
    pub zoom: i32,
}

/// An axis key that is down.
#[derive(Clone, Copy, Debug)]
struct Turning {
    axis: Axis,
    reverse: bool,
    /// Until here the first step was enough.
    on_from: Duration,
}

/// The viewer's state at a time.
#[derive(Debug)]
pub struct State {
    setting: Setting,
    /// What messages call the keys.
    keymap: Arc<Keymap>,
    size_px: (usize, usize),
    scale_factor: f64,
    settings: Settings,
    playback: Playback,
    /// The scene's operations and the recorded ones: what is played.
    film: Vec<Operation>,
    moves: Moves,
    /// Counts the scenes, and the same one loaded again.
    scene: u64,
    composer: RefCell<Composer>,
    halves: sides::Halves,
    recording: bool,
    /// What the hand orbits about, when it is not the format's pivot.
    pivot: Option<DVec3>,
    turntable: bool,
    turning: Vec<Turning>,
    dragging: bool,
    /// The first end of a loop, when the second is not set.
    section_start: Option<u64>,
    bar_until: Option<Duration>,
    picked: Option<Picked>,
    /// The other end of what was measured.
    measured: Option<DVec3>,
    picked_lines: Vec<(String, String)>,
    statistics: bool,
    axes: bool,
    /// Steps by which the overlay is larger than usual.
    zoom: i32,
    sheet: bool,
    fullscreen: bool,
    /// What was asked for, while recorded moves would be lost by it.
    asking: Option<Command>,
    message: Option<(String, Duration)>,
    now: Duration,
    commands: Vec<Command>,
}

impl State {
    /// Stands on the still picture at time 0.
    #[must_use]
    pub fn new(setting: Setting, settings: Settings, size_px: (usize, usize)) -> State {
        let film = setting.operations.clone();
        State {
            playback: Playback::new(setting.timing.fps, setting.timing.last_frame(&film)),
            film,
            setting,
            keymap: Arc::default(),
            size_px,
            scale_factor: 1.0,
            settings,
            moves: Moves::default(),
            scene: 0,
            composer: RefCell::default(),
            halves: sides::Halves::default(),
            recording: false,
            pivot: None,
            turntable: false,
            turning: Vec::new(),
            dragging: false,
            section_start: None,
            bar_until: None,
            picked: None,
            measured: None,
            picked_lines: Vec::new(),
            statistics: false,
            axes: false,
            zoom: 0,
            sheet: false,
            fullscreen: false,
            asking: None,
            message: None,
            now: Duration::ZERO,
            commands: Vec::new(),
        }
    }

    /// Messages name the keys by these chords.
    pub fn set_keymap(&mut self, keymap: Arc<Keymap>) {
        self.keymap = keymap;
    }

    /// The picture takes another size; a size without pixels is ignored.
    pub fn resize(&mut self, width: usize, height: usize) {
        if width > 0 && height > 0 {
            self.size_px = (width, height);
        }
    }

    /// The picture's size, at least 1x1.
    #[must_use]
    pub fn size_px(&self) -> (usize, usize) {
        self.size_px
    }

    /// Physical pixels a logical one.
    pub fn set_scale_factor(&mut self, scale_factor: f64) {
        self.scale_factor = scale_factor;
    }

    /// Moves on to the time `now`, counted from the start; an earlier one changes nothing.
    pub fn advance(&mut self, now: Duration) {
        let before = self.now;
        self.now = now.max(before);
        self.turn_on(before);
        if !self.holds_bar() && self.playback.advance(self.now - before) {
            let frame = self.playback.frame();
            self.report(format!("playback ended at frame {frame}"));
        }
        if self.message.as_ref().is_some_and(|(_, end)| *end <= now) {
            self.message = None;
        }
        self.bar_until = self.bar_until.filter(|end| *end > now);
    }

    /// Does what `action` says, at the time of the last [`State::advance`].
    pub fn apply(&mut self, action: Action) {
        if self.asking.is_some() {
            return self.answer(action);
        }
        match action {
            Action::StartTurn { axis, reverse } => self.start_turn(axis, reverse),
            Action::StopTurn(axis) => self.stop_turn(axis),
            Action::StopTurns => self.let_go_of_all(),
            Action::Orbit { dx_px, dy_px, only } => self.orbit(dx_px, dy_px, only),
            Action::Roll { dx_px } => self.roll(dx_px),
            Action::Pan { dx_px, dy_px } => self.pan(dx_px, dy_px),
            Action::DollyDrag { dy_px, at } => self.dolly_drag(dy_px, at),
            Action::Dolly { notches, at } => self.dolly(notches, at),
            Action::LetGo => self.let_go(),
            Action::Look { from, opposite } => self.look(from, opposite),
            Action::Fit => self.fit(),
            Action::ToggleTurntable => self.toggle_turntable(),
            // What lies below it cannot be meant.
            Action::Pick(_) | Action::Measure(_) if self.shows_sheet() => self.sheet = false,
            Action::Pick(at) => self.probe(at, Spot::Pick),
            Action::Measure(at) => self.probe(at, Spot::Measure),
            Action::SetPivot(at) => self.probe(at, Spot::Pivot),
            Action::TogglePlayback => self.toggle_playback(false),
            Action::TogglePlaybackBackwards => self.toggle_playback(true),
            Action::StepFrames(frames) => self.playback.step(frames),
            Action::StepOperation { back } => self.step_operation(back),
            Action::GoToStart => self.playback.seek(0),
            Action::GoToEnd => self.playback.stop(),
            Action::Seek(frame) => self.playback.seek(frame),
            Action::ScaleSpeed(factor) => self.set_speed(self.playback.speed() * factor),
            Action::NormalSpeed => self.set_speed(1.0),
            Action::MarkSection => self.mark_section(),
            Action::NextOrder => self.next_order(),
            Action::ToggleRecording => self.toggle_recording(),
            Action::Undo => self.undo(),
            Action::Redo => self.redo(),
            Action::Save => self.save(false),
            Action::SaveAs => self.save(true),
            Action::PrintCamera => self.print_camera(),
            Action::Accept | Action::Decline => {}
            Action::ReturnToScene => self.return_to_scene(),
            Action::NextView => self.settings.mode = next(&MODES, self.settings.mode),
            Action::ShowView(mode) => self.settings.mode = mode,
            Action::NextEngine => self.next_engine(),
            Action::ToggleSplit => self.toggle_split(),
            Action::SetDivider(part) => self.set_divider(part),
            Action::NextRightEngine => self.next_right_engine(),
            Action::NextRightView => self.next_right_view(),
            Action::ShowRightView(mode) => self.show_right_view(mode),
            Action::ScaleCost(factor) => self.scale_cost(factor),
            Action::NextKernel => self.next_kernel(),
            Action::ToggleStatistics => self.statistics = !self.statistics,
            Action::ToggleAxes => self.axes = !self.axes,
            Action::Zoom(steps) => self.zoom(steps),
            Action::ToggleSheet => self.sheet = !self.sheet,
            Action::Screenshot => self.commands.push(Command::Screenshot),
            Action::ToggleFullscreen => self.set_fullscreen(!self.fullscreen),
            Action::Browse { forward } => self.leave(Command::Browse { forward }),
            Action::Back => self.back(),
            Action::Quit => self.leave(Command::Quit),
        }
    }

    /// Shows a line in the window for a while.
    pub fn say(&mut self, message: String) {
        self.message = Some((message, self.now + MESSAGE));
    }

    /// What is to be done outside since the last call.
    pub fn take_commands(&mut self) -> Vec<Command> {
        std::mem::take(&mut self.commands)
    }

    /// The picture to show.
    #[must_use]
    pub fn wish(&self) -> Wish {
        Wish {
            view: self.view(),
            settings: self.settings,
            split: self.split(),
        }
    }

    /// What to draw over it.
    #[must_use]
    pub fn overlay(&self) -> OverlayWish {
        if !self.setting.overlay {
            return OverlayWish::default();
        }
        OverlayWish {
            statistics: self.statistics,
            axes: self.axes,
            divider: self.split().map(|split| split.column),
            sheet: self.sheet,
            picked: self.picked_lines.clone(),
            marks: self.marks(),
            recording: self.recording_in_words(),
            bar: self.bar_wish(),
            question: self.question(),
            message: self.message.as_ref().map(|(text, _)| text.clone()),
            zoom: self.zoom,
        }
    }

    /// The number of the frame under the hand's moves, and of the last one.
    #[must_use]
    pub fn frame(&self) -> (u64, u64) {
        (self.playback.frame(), self.playback.last_frame())
    }

    /// True while every moment has its own picture.
    #[must_use]
    pub fn is_turning(&self) -> bool {
        self.turning.iter().any(|t| t.on_from <= self.now)
    }

    /// True while time or a hand is moving the picture.
    #[must_use]
    pub fn is_moving(&self) -> bool {
        self.playback.is_playing() || self.dragging || !self.turning.is_empty()
    }

    /// When the state next changes by itself, unless [`State::is_turning`]; `None`: never.
    #[must_use]
    pub fn next_change(&self) -> Option<Duration> {
        let frame = self
            .playback
            .next_frame_in()
            .and_then(|dt| self.now.checked_add(dt));
        let message = self.message.as_ref().map(|(_, end)| *end);
        let turns = self.turning.iter().map(|t| t.on_from);
        let others = frame.into_iter().chain(message).chain(self.bar_until);
        turns.chain(others).min()
    }

    /// Starts playing at frame 0.
    pub fn play(&mut self) {
        self.playback.stop();
        self.playback.play(false);
    }

    fn camera(&self) -> Camera {
        let base = self.moves.base(self.setting.base);
        base.turned(self.turn(), self.setting.pivot)
    }

    /// What turns the base camera: the film up to the frame, and what is on top of it.
    fn operations(&self) -> impl Iterator<Item = Operation> {
        let frame = self.playback.frame();
        operations_at(&self.film, self.setting.timing, frame).chain(self.moves.on_top())
    }

    fn turn(&self) -> DMat3 {
        self.composer.borrow_mut().compose(self.operations())
    }

    fn view(&self) -> View {
        let (width, height) = self.size_px;
        self.camera().view(width, height, self.setting.stretch)
    }

    fn set_fullscreen(&mut self, on: bool) {
        self.fullscreen = on;
        self.commands.push(Command::Fullscreen(on));
    }

    fn shows_sheet(&self) -> bool {
        self.sheet && self.setting.overlay
    }

    fn zoom(&mut self, steps: i32) {
        self.zoom = (self.zoom + steps).clamp(MIN_ZOOM, MAX_ZOOM);
        let percent = 100.0 * zoom_factor(self.zoom);
        let end = match self.zoom {
            MIN_ZOOM => ", the smallest",
            MAX_ZOOM => ", the largest",
            _ => "",
        };
        self.say(format!("letters: {percent:.0} %{end}"));
    }

    fn back(&mut self) {
        if self.shows_sheet() {
            self.sheet = false;
        } else if !self.picked_lines.is_empty() && self.setting.overlay {
            self.drop_pick();
        } else if self.split().is_some() {
            self.toggle_split();
        } else if self.fullscreen {
            self.set_fullscreen(false);
        } else {
            self.leave(Command::Quit);
        }
    }

    /// True while the picture fills the screen.
    #[must_use]
    pub fn is_fullscreen(&self) -> bool {
        self.fullscreen
    }

    fn report(&mut self, line: String) {
        self.commands.push(Command::Report(line));
    }
}

/// The one after `current`, round and round; the first when `current` is not in the list.
fn next<T: Copy + PartialEq>(all: &[T], current: T) -> T {
    let at = all.iter().position(|&one| one == current);
    all[at.map_or(0, |i| (i + 1) % all.len())]
}

#[cfg(test)]
mod tests;
