//! What the viewer shows: plain data that actions change and time moves. No window, no clock, no files.

use std::time::Duration;

use glam::DVec3;

use super::action::Action;
use super::orbit::{self, Pose};
use crate::camera::{Camera, View};
use crate::render::{Settings, ViewMode};
use crate::scene::{Axis, Operation};
use crate::simd::Kernel;
use crate::timeline::{Playback, Timing, camera_at};

/// The turn of a tapped axis key, at once.
const TAP_RAD: f64 = 5.0 * std::f64::consts::PI / 180.0;
/// A key held longer than this turns on; a tap is shorter.
const TAP: Duration = Duration::from_millis(250);
/// How fast a held key turns: a quarter in a second and a half.
const HELD_RAD_PER_S: f64 = std::f64::consts::FRAC_PI_3;
/// Notches of the wheel that a drag over the whole window is worth.
const DOLLY_NOTCHES_PER_HEIGHT: f64 = 40.0;
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
    /// Before any operation.
    pub base: Camera,
    /// The scene's.
    pub operations: Vec<Operation>,
    /// How they become frames.
    pub timing: Timing,
    /// What they, and hands, turn the camera about.
    pub pivot: DVec3,
    /// The plane is mapped onto the window as it is.
    pub stretch: bool,
    /// Something may be drawn over the picture.
    pub overlay: bool,
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
    /// Open another scene of the folder.
    Browse {
        /// The next one by name; otherwise the one before.
        forward: bool,
    },
    /// Fill the screen, or do not.
    Fullscreen(bool),
    /// End the program.
    Quit,
}

/// What to render.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wish {
    /// From where, and how large.
    pub view: View,
    /// How.
    pub settings: Settings,
}

/// What to draw over the picture.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct OverlayWish {
    /// The figures.
    pub statistics: bool,
    /// The key sheet.
    pub sheet: bool,
    /// A line of text.
    pub message: Option<String>,
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
    size_px: (usize, usize),
    settings: Settings,
    playback: Playback,
    /// What the hand did, on top of the frame's camera.
    hand: Pose,
    turning: Vec<Turning>,
    statistics: bool,
    sheet: bool,
    fullscreen: bool,
    message: Option<(String, Duration)>,
    now: Duration,
    commands: Vec<Command>,
}

impl State {
    /// Stands on the still picture at time 0.
    #[must_use]
    pub fn new(setting: Setting, settings: Settings, size_px: (usize, usize)) -> State {
        State {
            playback: Playback::new(setting.timing, &setting.operations),
            setting,
            size_px,
            settings,
            hand: Pose::IDENTITY,
            turning: Vec::new(),
            statistics: false,
            sheet: false,
            fullscreen: false,
            message: None,
            now: Duration::ZERO,
            commands: Vec::new(),
        }
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

    /// Moves on to the time `now`, counted from the start; an earlier one changes nothing.
    pub fn advance(&mut self, now: Duration) {
        let before = self.now;
        self.now = now.max(before);
        self.turn_on(before);
        if self.playback.advance((self.now - before).as_secs_f64()) {
            self.report_end();
        }
        if self.message.as_ref().is_some_and(|(_, end)| *end <= now) {
            self.message = None;
        }
    }

    /// Does what `action` says, at the time of the last [`State::advance`].
    pub fn apply(&mut self, action: Action) {
        match action {
            Action::StartTurn { axis, reverse } => self.start_turn(axis, reverse),
            Action::StopTurn(axis) => self.turning.retain(|t| t.axis != axis),
            Action::StopTurns => self.turning.clear(),
            Action::Orbit { dx_px, dy_px } => self.orbit(dx_px, dy_px),
            Action::Pan { dx_px, dy_px } => self.pan(dx_px, dy_px),
            Action::DollyDrag { dy_px } => {
                self.dolly(-dy_px / self.size_px.1 as f64 * DOLLY_NOTCHES_PER_HEIGHT);
            }
            Action::Dolly { notches } => self.dolly(notches),
            Action::TogglePlayback => self.toggle_playback(),
            Action::ReturnToScene => self.return_to_scene(),
            Action::NextView => self.settings.mode = next(&MODES, self.settings.mode),
            Action::NextKernel => {
                self.settings.kernel = next(&self.setting.kernels, self.settings.kernel);
            }
            Action::ToggleStatistics => self.statistics = !self.statistics,
            Action::ToggleSheet => self.sheet = !self.sheet,
            Action::Screenshot => self.commands.push(Command::Screenshot),
            Action::ToggleFullscreen => self.set_fullscreen(!self.fullscreen),
            Action::Browse { forward } => self.commands.push(Command::Browse { forward }),
            Action::Back => self.back(),
            Action::Quit => self.commands.push(Command::Quit),
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
            sheet: self.sheet,
            message: self.message.as_ref().map(|(text, _)| text.clone()),
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

    /// When the state next changes by itself, unless [`State::is_turning`]; `None`: never.
    #[must_use]
    pub fn next_change(&self) -> Option<Duration> {
        let frame = self
            .playback
            .next_frame_in_s()
            .and_then(|s| self.now.checked_add(Duration::try_from_secs_f64(s).ok()?));
        let message = self.message.as_ref().map(|(_, end)| *end);
        let turns = self.turning.iter().map(|t| t.on_from);
        turns.chain(frame).chain(message).min()
    }

    /// Starts playing at frame 0.
    pub fn play(&mut self) {
        self.playback.stop();
        self.playback.play();
    }

    fn camera(&self) -> Camera {
        let s = &self.setting;
        let frame = self.playback.frame();
        let camera = camera_at(s.base, &s.operations, s.timing, frame, s.pivot);
        self.hand.apply(camera)
    }

    fn view(&self) -> View {
        let (width, height) = self.size_px;
        self.camera().view(width, height, self.setting.stretch)
    }

    fn start_turn(&mut self, axis: Axis, reverse: bool) {
        self.turning.retain(|t| t.axis != axis);
        self.turning.push(Turning {
            axis,
            reverse,
            on_from: self.now + TAP,
        });
        self.turn(axis, reverse, TAP_RAD);
    }

    fn turn(&mut self, axis: Axis, reverse: bool, angle_rad: f64) {
        let angle_rad = if reverse { -angle_rad } else { angle_rad };
        let turn = orbit::axis_turn(axis, angle_rad, self.setting.pivot);
        self.hand = self.hand.then(turn);
    }

    /// Turns by what the held keys are worth between `before` and now.
    fn turn_on(&mut self, before: Duration) {
        for i in 0..self.turning.len() {
            let t = self.turning[i];
            let held = self.now.saturating_sub(before.max(t.on_from));
            if !held.is_zero() {
                self.turn(t.axis, t.reverse, HELD_RAD_PER_S * held.as_secs_f64());
            }
        }
    }

    fn orbit(&mut self, dx_px: f64, dy_px: f64) {
        let height = self.size_px.1 as f64;
        let turn = orbit::orbit(&self.camera(), self.setting.pivot, dx_px, dy_px, height);
        self.hand = self.hand.then(turn);
    }

    fn pan(&mut self, dx_px: f64, dy_px: f64) {
        let view = self.view();
        let step = view.dx * dx_px + view.dy * dy_px;
        let shift = orbit::pan(&self.camera(), self.setting.pivot, step);
        self.hand = self.hand.then(shift);
    }

    fn dolly(&mut self, notches: f64) {
        let shift = orbit::dolly(&self.camera(), self.setting.pivot, notches);
        self.hand = self.hand.then(shift);
    }

    fn toggle_playback(&mut self) {
        if self.playback.is_playing() {
            let frame = self.playback.pause();
            self.report(format!("paused at frame {frame}"));
            return;
        }
        self.playback.play();
        // Nothing to play ends here.
        if self.playback.advance(0.0) {
            self.report_end();
        }
    }

    fn return_to_scene(&mut self) {
        self.playback.stop();
        self.turning.clear();
        self.hand = Pose::IDENTITY;
    }

    fn set_fullscreen(&mut self, on: bool) {
        self.fullscreen = on;
        self.commands.push(Command::Fullscreen(on));
    }

    fn back(&mut self) {
        if self.sheet && self.setting.overlay {
            self.sheet = false;
        } else if self.fullscreen {
            self.set_fullscreen(false);
        } else {
            self.commands.push(Command::Quit);
        }
    }

    fn report_end(&mut self) {
        let last = self.playback.last_frame();
        self.report(format!("playback ended at frame {last}"));
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

mod scene;
#[cfg(test)]
mod tests;
