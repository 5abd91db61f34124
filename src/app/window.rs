//! The program between events, and the only place that names winit's event loop: events in, whole pictures out.
//!
//! `events.rs` hears what happens and passes it on. Nothing is rendered or loaded here. Events change the [`State`]; when
//! the loop has run out of them, the picture that the state wants goes to the [`Painter`] when the [`Pace`] says so,
//! and the loop sleeps until something happens or is due.

mod events;
mod kiosk;
mod memory;
mod pictures;
mod scene;
mod session;
mod sides;

use std::io::{self, Write};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use winit::dpi::PhysicalSize;
use winit::event::{ElementState, InnerSizeWriter, KeyEvent};
use winit::event_loop::{ActiveEventLoop, EventLoop, EventLoopProxy};
use winit::window::{CursorIcon, Fullscreen};

use self::session::Held;
use self::sides::SlowSides;
use super::action::Action;
use super::bindings::Chord;
use super::companion::News;
use super::input::Input;
use super::journal::Journal;
use super::kiosk::Kiosk;
use super::loader::Source;
use super::memory::Memory;
use super::opener::{Heard, Opener};
use super::overlay::{Line, Overlay};
use super::pace::Pace;
use super::painter::{Notice, Painter, Picture};
use super::save::Saver;
use super::screen::Stage;
use super::session::{NextLine, Session, print};
use super::state::{Command, OverlayWish, State};
use super::statistics::Statistics;
use super::{AppError, AppOptions, backend, keymap, keys, panics, script};
use crate::camera::Pivot;
use crate::render::Renderer;

/// What other threads tell the event loop.
#[derive(Debug)]
enum Message {
    /// From the render thread.
    Painter(Notice),
    /// From the thread of a slow side.
    Companion(usize, News),
    /// From the threads that load and watch.
    Opener(Heard),
    /// A screenshot is saved, or not.
    Saved(io::Result<String>),
    /// The scene is saved, or not.
    SceneSaved(Box<scene::SaveEnding>),
    /// The script has another line.
    Script(NextLine),
}

/// Opens the window and shows the scene until the user quits.
///
/// # Errors
/// See [`AppError`].
pub fn run(options: AppOptions) -> Result<(), AppError> {
    panics::tell_in_one_line();
    let event_loop = backend::event_loop::<Message>()?;
    let mut viewer = Viewer::new(options, event_loop.create_proxy())?;
    let ended = run_loop(event_loop, &mut viewer);
    let keeps_moves = viewer.journal.keeps_any();
    viewer.outcome.and(ended).map_err(|e| match e {
        AppError::Broken { why } if keeps_moves => AppError::Broken {
            why: format!("{why}; the moves are kept, and offered at the next start"),
        },
        other => other,
    })
}

fn run_loop(event_loop: EventLoop<Message>, viewer: &mut Viewer) -> Result<(), AppError> {
    let ended = panics::catch_winits(|| event_loop.run_app(viewer));
    let why = match ended {
        Ok(Ok(())) => return Ok(()),
        Ok(Err(e)) => e.to_string(),
        Err(panicked) => backend::panic_in_words(panicked),
    };
    Err(AppError::Broken {
        why: format!("the window system failed: {why}"),
    })
}

/// The program between two events.
struct Viewer {
    stage: Stage,
    opener: Opener,
    input: Input,
    state: State,
    pace: Pace,
    overlay: Overlay,
    statistics: Statistics,
    threads: usize,
    pivot: Pivot,
    /// A size was asked for: the scene's shape does not decide it.
    has_own_size: bool,
    /// Begin by playing.
    play: bool,
    kiosk: Option<Kiosk>,
    /// When the window was last drawn.
    redrawn: Instant,
    painter: Painter,
    slow: SlowSides,
    /// What the painter took for each side.
    side_times: [Duration; 2],
    session: Session,
    /// Where the scene on screen comes from.
    origin: Source,
    /// Counts the scenes that were opened.
    opened: u64,
    /// Answers that the state waits for.
    pending: usize,
    /// What the left button holds, other than the picture.
    held: Held,
    /// What the mouse looks like.
    cursor: CursorIcon,
    /// Moves that no file has.
    journal: Journal,
    /// The window's size and place.
    memory: Memory,
    proxy: EventLoopProxy<Message>,
    /// The newest whole picture.
    picture: Option<Box<Picture>>,
    /// So many pictures failed.
    failures: usize,
    /// The next one is in the making and will come.
    is_awaited: bool,
    /// It has not been on screen.
    is_new: bool,
    /// How long it took to show the last one.
    present: Duration,
    /// What was drawn over it.
    drawn: (OverlayWish, Option<Vec<Line>>),
    /// The user wants a file of the picture, which is coarse yet.
    to_be_saved: bool,
    /// The window was too large for its window system, and that was said.
    said_too_large: bool,
    /// Time starts with the first picture.
    epoch: Option<Instant>,
    saver: Saver,
    /// Pictures.
    saving: Vec<JoinHandle<()>>,
    outcome: Result<(), AppError>,
}

impl Viewer {
    fn new(mut options: AppOptions, proxy: EventLoopProxy<Message>) -> Result<Viewer, AppError> {
        let threads_failed = |why: String| AppError::Broken { why };
        let renderer = Renderer::new(options.threads)
            .map_err(|e| threads_failed(format!("the system gives no threads: {e}")))?;
        let threads = renderer.threads();
        // A kiosk fills the screen: no hand has chosen that, and what hands chose for windows is not for it.
        let is_window = options.kiosk.is_none();
        let memory = Memory::of(options.memory.clone().filter(|_| is_window));
        // A window's size fits in memory.
        let size = memory.size().map(|(w, h)| (w as usize, h as usize));
        options.size = options.size.or(size);
        let mut state = options.initial_state();
        let keymap = Arc::new(options.keymap);
        state.set_keymap(Arc::clone(&keymap));
        // Sending fails when the loop has ended: nobody waits any more.
        let to_loop = proxy.clone();
        let (play, record) = (&options.play_actions, &options.record_actions);
        let scene = match &options.source {
            Source::File(path) => Some(path.as_path()),
            _ => None,
        };
        let (play, record) = (play.as_deref(), record.as_deref());
        let session = Session::open(play, record, scene, move |line| {
            let _ = to_loop.send_event(Message::Script(line));
        })?;
        let to_loop = proxy.clone();
        let saver = Saver::start(move |job, result| {
            let ending = scene::SaveEnding { job, result };
            let _ = to_loop.send_event(Message::SceneSaved(Box::new(ending)));
        })
        .map_err(|e| threads_failed(format!("the system gives no thread: {e}")))?;
        let to_loop = proxy.clone();
        let painter = Painter::start(renderer, move |notice| {
            let _ = to_loop.send_event(Message::Painter(notice));
        })
        .map_err(|e| threads_failed(format!("the system gives no thread: {e}")))?;
        let to_loop = proxy.clone();
        let slow = SlowSides::start(options.threads, &painter.at_work(), move |side, news| {
            let _ = to_loop.send_event(Message::Companion(side, news));
        })
        .map_err(|e| threads_failed(format!("the system gives no thread: {e}")))?;
        let to_loop = proxy.clone();
        let origin = options.source.clone();
        let mut opener = Opener::new(options.source, options.threads, move |heard| {
            let _ = to_loop.send_event(Message::Opener(heard));
        });
        if let Some(chord) = keymap.chord_of(Action::Back) {
            opener.set_cancel_key(chord.to_string());
        }
        opener.begin().map_err(AppError::NoScene)?;
        Ok(Viewer {
            stage: Stage::Waiting,
            opener,
            input: Input::new(Arc::clone(&keymap)),
            state,
            pace: Pace::new(options.target_fps, options.samples),
            overlay: Overlay::new(1.0, &keymap),
            statistics: Statistics::new(threads, 0),
            threads,
            pivot: options.pivot,
            has_own_size: options.size.is_some(),
            play: options.play,
            kiosk: options.kiosk.map(Kiosk::new),
            redrawn: Instant::now(),
            painter,
            slow,
            side_times: [Duration::ZERO; 2],
            session,
            origin,
            opened: 0,
            pending: 0,
            held: Held::Nothing,
            cursor: CursorIcon::Default,
            journal: Journal::new(options.memory.map(|folder| folder.join("moves"))),
            memory,
            proxy,
            picture: None,
            failures: 0,
            is_awaited: false,
            is_new: false,
            present: Duration::ZERO,
            drawn: (OverlayWish::default(), None),
            to_be_saved: false,
            said_too_large: false,
            epoch: None,
            saver,
            saving: Vec::new(),
            outcome: Ok(()),
        })
    }

    /// The clock.
    fn real(&self) -> Duration {
        self.epoch.map_or(Duration::ZERO, |epoch| epoch.elapsed())
    }

    /// The session's time.
    fn now(&self) -> Duration {
        self.session.now(self.real())
    }

    fn fail(&mut self, event_loop: &ActiveEventLoop, error: AppError) {
        self.outcome = Err(error);
        event_loop.exit();
    }

    /// Brings the state to the present, then lets `action` change it. Before there is a scene, only what concerns
    /// the window is done.
    fn act(&mut self, action: Option<Action>) {
        let Some(action) = action else { return };
        if self.kiosk.is_some() && action != Action::Quit {
            return;
        }
        let concerns_window = matches!(
            action,
            Action::Back
                | Action::Quit
                | Action::ToggleFullscreen
                | Action::ToggleSheet
                | Action::ToggleStatistics
                | Action::NextView
                | Action::NextKernel
        );
        if !self.opener.has_scene() && !concerns_window {
            return;
        }
        if action == Action::Back && self.opener.cancel() {
            return self.tell("loading cancelled");
        }
        if action == Action::Back && self.state.may_overlay() && self.opener.dismiss() {
            return;
        }
        // What was done before there was a picture is not answered late.
        if self.epoch.is_some() {
            self.pace.input(Instant::now());
        }
        let now = self.now();
        self.state.advance(now);
        self.note(now, script::Line::Act(action));
        self.state.apply(action);
    }

    /// Writes down what is done, if somebody wants that.
    fn note(&mut self, now: Duration, line: script::Line) {
        if let Some(e) = self.session.note(now, line) {
            self.tell(&format!("cannot record the session: {e}"));
        }
    }

    fn key(&mut self, event: &KeyEvent, is_synthetic: bool) {
        let id = keys::key_id(event);
        let action = match event.state {
            // A key that was down before the window had the keyboard is not meant for it.
            ElementState::Pressed if is_synthetic => None,
            ElementState::Pressed => keys::key_of(event).and_then(|key| {
                let answer = keymap::answer(key).filter(|_| self.state.is_asking());
                let unbound = self.input.unbound(key);
                if let Some(chord) = unbound.filter(|_| answer.is_none() && !event.repeat) {
                    self.say_unbound(chord);
                }
                answer.or_else(|| self.input.key_down(id, key, event.repeat))
            }),
            ElementState::Released => self.input.key_up(id),
        };
        if action == Some(Action::Back) && self.opener.was_just_loading(Instant::now()) {
            return self.tell("it is loaded already");
        }
        self.act(action);
        if event.state == ElementState::Released {
            self.pace.let_go();
        }
    }

    /// A key does nothing: the hand that tried it may like to know where the keys are.
    fn say_unbound(&mut self, chord: Chord) {
        if self.kiosk.is_none() {
            let sheet = self.input.chord_of(Action::ToggleSheet);
            let help = sheet.map_or(String::new(), |sheet| format!("; {sheet} shows the keys"));
            self.state.advance(self.now());
            self.state.say(format!("{chord} does nothing{help}"));
        }
    }

    fn resized(&mut self, size: PhysicalSize<u32>) {
        self.memory.sized(size.into());
        self.session.sized(size.into());
        let fitted = match self.stage.screen() {
            Some(screen) => screen.resize(size),
            None => (size.width, size.height),
        };
        // A window's size fits in memory.
        let (width, height) = (fitted.0 as usize, fitted.1 as usize);
        if self.state.size_px() != (width, height) {
            self.note(self.now(), script::Line::Resize(fitted.0, fitted.1));
        }
        self.state.resize(width, height);
        if fitted != (size.width, size.height) && !std::mem::replace(&mut self.said_too_large, true)
        {
            let (width, height) = fitted;
            self.tell(&format!(
                "the X server shares no memory with us: the picture is {width}x{height} at most"
            ));
        }
        self.stage.settle();
    }

    fn rescaled(&mut self, scale_factor: f64, mut size: InnerSizeWriter) {
        self.overlay.set_scale_factor(scale_factor);
        self.state.set_scale_factor(scale_factor);
        self.memory.rescaled();
        let is_first = self.stage.screen().is_some_and(|s| !s.has_monitor());
        // The window was opened as if a logical pixel were a physical one: here it gets the size that was meant.
        if let Some(given) = self.memory.given().filter(|_| is_first) {
            // Fails when the window is gone.
            let _ = size.request_inner_size(given.into());
        }
    }

    fn occluded(&mut self, occluded: bool) {
        if let Some(screen) = self.stage.screen() {
            screen.set_occluded(occluded);
        }
        self.stage.settle();
    }

    /// Does what the state asks for.
    fn obey(&mut self, event_loop: &ActiveEventLoop) {
        for command in self.state.take_commands() {
            match command {
                // Nobody at a kiosk reads the terminal.
                Command::Report(_) if self.kiosk.is_some() => {}
                Command::Report(line) => report(&line),
                Command::Print(text) => print(&text),
                Command::Probe(probe) => {
                    self.pending += 1;
                    self.painter.probe(probe);
                }
                Command::Save(document) => self.save_scene(document),
                Command::Screenshot => self.ask_for_picture(),
                Command::TakeBack(kept) => self.take_back(*kept),
                Command::DropMoves => self.drop_moves(),
                Command::Quit => {
                    self.journal.forget();
                    self.keep_placement();
                    event_loop.exit();
                }
                Command::Browse { forward } => self.browse(event_loop, forward),
                Command::Open(path) => self.open_source(event_loop, Source::File(path)),
                Command::Fullscreen(on) => {
                    if let Some(screen) = self.stage.screen() {
                        let mode = on.then_some(Fullscreen::Borderless(None));
                        screen.window.set_fullscreen(mode);
                    }
                }
            }
        }
    }

    /// Says a line on the terminal and in the window.
    fn tell(&mut self, line: &str) {
        report(line);
        self.state.advance(self.now());
        self.state.say(line.to_string());
    }

    /// When the state changes without an event.
    fn next_change(&self) -> Option<Instant> {
        let epoch = self.epoch?;
        let script = self.session.wakes_at().and_then(|t| epoch.checked_add(t));
        if !self.session.time_moves() {
            return script;
        }
        if let (true, Stage::Running(screen)) = (self.state.is_turning(), &self.stage) {
            let next = Instant::now() + screen.interval;
            return Some(script.map_or(next, |script| script.min(next)));
        }
        let change = self.state.next_change().and_then(|t| {
            let wait = t.saturating_sub(self.now());
            Instant::now().checked_add(wait)
        });
        change.into_iter().chain(script).min()
    }
}

fn title(opener: &Opener) -> String {
    format!("{} - Ray Bomb 3D", opener.shown_name())
}

fn physical(width: usize, height: usize) -> PhysicalSize<u32> {
    let side = |n| u32::try_from(n).unwrap_or(u32::MAX);
    PhysicalSize::new(side(width), side(height))
}

/// Says a line on the terminal; a terminal that is gone is no reason to stop.
pub(super) fn report(line: &str) {
    let _ = writeln!(io::stderr(), "{line}");
}
