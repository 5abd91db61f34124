//! The window, and the only file that names winit's event loop: events in, whole pictures out.
//!
//! Nothing is rendered here. Events change the [`State`]; when the loop has run out of them, the picture that
//! the state wants goes to the [`Painter`], and the loop sleeps until something happens or is due.

mod session;

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{ElementState, KeyEvent, WindowEvent};
use winit::event_loop::{
    ActiveEventLoop, ControlFlow, EventLoop, EventLoopProxy, OwnedDisplayHandle,
};
use winit::window::{Fullscreen, Window, WindowAttributes, WindowId};

use super::action::Action;
use super::input::Input;
use super::overlay::Overlay;
use super::painter::{Notice, Painter, Picture};
use super::present::Presenter;
use super::save::Origin;
use super::script::Line;
use super::session::{NextLine, Session, print};
use super::state::{Command, OverlayWish, State, Wish};
use super::statistics::Statistics;
use super::{AppError, AppOptions, backend, keys, moves, screenshot};
use crate::render::Renderer;

/// Pictures follow one another at the screen's rate, or at this one where it is not told.
const DEFAULT_INTERVAL: Duration = Duration::from_nanos(16_666_667);

/// What other threads tell the event loop.
#[derive(Debug)]
enum Message {
    /// From the render thread.
    Painter(Notice),
    /// A screenshot is saved, or not.
    Saved(io::Result<String>),
    /// The scene is saved with what was recorded then, or not.
    SceneSaved(moves::Recorded, io::Result<PathBuf>),
    /// The script has another line.
    Script(NextLine),
}

/// Opens the window and shows the scene until the user quits.
///
/// # Errors
/// See [`AppError`].
pub fn run(options: AppOptions) -> Result<(), AppError> {
    let event_loop = backend::event_loop::<Message>()?;
    let mut viewer = Viewer::new(options, event_loop.create_proxy())?;
    let ended = run_loop(event_loop, &mut viewer);
    viewer.outcome.and(ended)
}

fn run_loop(event_loop: EventLoop<Message>, viewer: &mut Viewer) -> Result<(), AppError> {
    event_loop.run_app(viewer).map_err(|e| AppError::Broken {
        why: format!("the window system failed: {e}"),
    })
}

/// The window and its surface.
struct Screen {
    window: Arc<Window>,
    presenter: Presenter<OwnedDisplayHandle, Arc<Window>>,
    size: PhysicalSize<u32>,
    occluded: bool,
    interval: Duration,
}

impl Screen {
    fn open(
        event_loop: &ActiveEventLoop,
        attributes: WindowAttributes,
    ) -> Result<Screen, AppError> {
        let window = event_loop
            .create_window(attributes)
            .map_err(|e| backend::no_window(&e))?;
        let window = Arc::new(window);
        let display = event_loop.owned_display_handle();
        let presenter = Presenter::new(display, Arc::clone(&window)).map_err(cannot_show)?;
        Ok(Screen {
            size: window.inner_size(),
            interval: refresh_interval(&window),
            occluded: false,
            window,
            presenter,
        })
    }

    fn is_visible(&self) -> bool {
        !self.occluded && self.size.width > 0 && self.size.height > 0
    }
}

/// How long the screen shows a picture.
fn refresh_interval(window: &Window) -> Duration {
    window
        .current_monitor()
        .and_then(|monitor| monitor.refresh_rate_millihertz())
        .filter(|rate| (20_000..=500_000).contains(rate))
        .map_or(DEFAULT_INTERVAL, |rate| {
            Duration::from_secs_f64(1e3 / f64::from(rate))
        })
}

fn cannot_show(e: super::present::PresentError) -> AppError {
    AppError::Broken {
        why: format!("the window takes no picture: {e}"),
    }
}

/// What there is of a window.
enum Stage {
    /// None yet, or none any more.
    Waiting,
    /// One that shows pictures.
    Running(Screen),
    /// One that nobody can see: no picture is rendered for it.
    Suspended(Screen),
}

impl Stage {
    fn screen(&mut self) -> Option<&mut Screen> {
        match self {
            Stage::Waiting => None,
            Stage::Running(screen) | Stage::Suspended(screen) => Some(screen),
        }
    }

    /// Moves between running and suspended after a change of the screen.
    fn settle(&mut self) {
        *self = match std::mem::replace(self, Stage::Waiting) {
            Stage::Suspended(screen) if screen.is_visible() => {
                screen.window.request_redraw();
                Stage::Running(screen)
            }
            Stage::Running(screen) if !screen.is_visible() => Stage::Suspended(screen),
            same => same,
        };
    }
}

/// The program between two events.
struct Viewer {
    title: String,
    stage: Stage,
    input: Input,
    state: State,
    overlay: Overlay,
    statistics: Statistics,
    painter: Painter,
    session: Session,
    origin: Origin,
    /// Answers that the state waits for.
    pending: usize,
    /// The left button holds the bar of frames.
    scrubbing: bool,
    proxy: EventLoopProxy<Message>,
    /// The newest whole picture.
    picture: Option<Box<Picture>>,
    /// It has not been on screen.
    is_new: bool,
    /// What was drawn over it.
    drawn: OverlayWish,
    wished: Option<(Wish, Instant)>,
    /// Time starts with the first picture.
    epoch: Option<Instant>,
    saving: Vec<JoinHandle<()>>,
    outcome: Result<(), AppError>,
}

impl Viewer {
    fn new(options: AppOptions, proxy: EventLoopProxy<Message>) -> Result<Viewer, AppError> {
        let threads_failed = |why: String| AppError::Broken { why };
        let renderer = Renderer::new(options.threads)
            .map_err(|e| threads_failed(format!("the system gives no threads: {e}")))?;
        let statistics = Statistics::new(renderer.threads(), options.scene.triangles.len());
        let title = format!("{} - Ray Bomb 3D", options.name);
        let state = options.initial_state();
        let to_loop = proxy.clone();
        let play = options.play_actions.as_deref();
        let session = Session::open(play, options.record_actions.as_deref(), move |line| {
            // Fails when the loop has ended: nobody plays the script.
            let _ = to_loop.send_event(Message::Script(line));
        })?;
        let origin = options.origin;
        let to_loop = proxy.clone();
        let painter = Painter::start(options.scene, renderer, move |notice| {
            // Fails when the loop has ended: nobody waits for the picture.
            let _ = to_loop.send_event(Message::Painter(notice));
        })
        .map_err(|e| threads_failed(format!("the system gives no thread: {e}")))?;
        Ok(Viewer {
            title,
            stage: Stage::Waiting,
            input: Input::default(),
            state,
            overlay: Overlay::new(1.0),
            statistics,
            painter,
            session,
            origin,
            pending: 0,
            scrubbing: false,
            proxy,
            picture: None,
            is_new: false,
            drawn: OverlayWish::default(),
            wished: None,
            epoch: None,
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

    /// Brings the state to the present, then lets `action` change it.
    fn act(&mut self, action: Option<Action>) {
        if let Some(action) = action {
            let now = self.now();
            self.state.advance(now);
            self.note(now, Line::Act(action));
            self.state.apply(action);
        }
    }

    /// Writes down what is done, if somebody wants that.
    fn note(&mut self, now: Duration, line: Line) {
        if let Some(e) = self.session.note(now, line) {
            self.tell(&format!("cannot record the session: {e}"));
        }
    }

    fn key(&mut self, event: &KeyEvent, is_synthetic: bool) {
        let id = keys::key_id(event);
        let action = match event.state {
            // A key that was down before the window had the keyboard is not meant for it.
            ElementState::Pressed if is_synthetic => None,
            ElementState::Pressed => {
                keys::key_of(event).and_then(|key| self.input.key_down(id, key, event.repeat))
            }
            ElementState::Released => self.input.key_up(id),
        };
        self.act(action);
    }

    fn resized(&mut self, size: PhysicalSize<u32>) {
        // A window's size fits in memory.
        let (width, height) = (size.width as usize, size.height as usize);
        if self.state.size_px() != (width, height) {
            self.note(self.now(), Line::Resize(size.width, size.height));
        }
        self.state.resize(width, height);
        if let Some(screen) = self.stage.screen() {
            screen.size = size;
            screen.window.request_redraw();
        }
        self.stage.settle();
    }

    fn occluded(&mut self, occluded: bool) {
        if let Some(screen) = self.stage.screen() {
            screen.occluded = occluded;
        }
        self.stage.settle();
    }

    /// Shows the newest picture, whole, with what is to be drawn over it.
    fn redraw(&mut self, event_loop: &ActiveEventLoop) {
        let start = Instant::now();
        self.state.advance(self.now());
        let Stage::Running(screen) = &mut self.stage else {
            return;
        };
        self.drawn = self.state.overlay();
        let picture = self.picture.as_deref();
        let figures = if self.drawn.statistics {
            self.statistics.lines(picture, self.state.frame())
        } else {
            Vec::new()
        };
        let size = (screen.size.width, screen.size.height);
        let frame = picture.map(|p| &p.frame);
        let shown = screen.presenter.present(size, frame, |canvas| {
            self.overlay.draw(canvas, &self.drawn, &figures);
        });
        if let Err(e) = shown {
            return self.fail(event_loop, cannot_show(e));
        }
        if std::mem::take(&mut self.is_new) {
            self.statistics.count(self.now(), start.elapsed());
        }
    }

    /// A picture came: the one before goes back to the render thread.
    fn take_picture(&mut self, picture: Box<Picture>) {
        self.epoch.get_or_insert_with(Instant::now);
        if let Some(old) = self.picture.replace(picture) {
            self.painter.give_back(old.frame);
        }
        self.is_new = true;
        if let Stage::Running(screen) = &self.stage {
            screen.window.request_redraw();
        }
    }

    /// Does what the state asks for.
    fn obey(&mut self, event_loop: &ActiveEventLoop) {
        for command in self.state.take_commands() {
            match command {
                Command::Report(line) => report(&line),
                Command::Print(text) => print(&text),
                Command::Probe(probe) => {
                    self.pending += 1;
                    self.painter.probe(probe);
                }
                Command::Save(document) => self.save_scene(document),
                Command::Screenshot => self.save_picture(),
                Command::Quit => event_loop.exit(),
                Command::Fullscreen(on) => {
                    if let Some(screen) = self.stage.screen() {
                        let mode = on.then_some(Fullscreen::Borderless(None));
                        screen.window.set_fullscreen(mode);
                    }
                }
            }
        }
    }

    /// Saves a copy of the picture, on a thread of its own.
    fn save_picture(&mut self) {
        self.saving.retain(|thread| !thread.is_finished());
        let Some(picture) = &self.picture else {
            return self.tell("no picture to save yet");
        };
        let frame = picture.frame.clone();
        let proxy = self.proxy.clone();
        self.saving.push(std::thread::spawn(move || {
            let saved = screenshot::save(&frame, Path::new("."));
            // Fails when the loop has ended: the file is there all the same.
            let _ = proxy.send_event(Message::Saved(saved));
        }));
    }

    /// Says a line on the terminal and in the window.
    fn tell(&mut self, line: &str) {
        report(line);
        self.state.advance(self.now());
        self.state.say(line.to_string());
    }

    /// Sends the picture that the state wants to the render thread, at the screen's rate at most.
    /// Returns when to come back for that, if it was too early.
    fn wish(&mut self) -> Option<Instant> {
        let Stage::Running(screen) = &self.stage else {
            return None;
        };
        let wish = self.state.wish();
        if let Some((last, at)) = self.wished {
            let due = at + screen.interval;
            if last == wish {
                return None;
            }
            if Instant::now() < due {
                return Some(due);
            }
        }
        self.wished = Some((wish, Instant::now()));
        self.painter.wish(wish);
        None
    }

    fn redraw_overlay_if_changed(&mut self) {
        if let Stage::Running(screen) = &self.stage
            && self.drawn != self.state.overlay()
        {
            screen.window.request_redraw();
        }
    }

    /// When the state changes without an event.
    fn next_change(&self) -> Option<Instant> {
        let epoch = self.epoch?;
        let script = self.session.wakes_at().and_then(|t| epoch.checked_add(t));
        if !self.session.time_moves() {
            return script;
        }
        if self.state.is_turning() {
            let interval = match &self.stage {
                Stage::Running(screen) => screen.interval,
                _ => DEFAULT_INTERVAL,
            };
            return script
                .into_iter()
                .chain(Some(Instant::now() + interval))
                .min();
        }
        let change = self.state.next_change().and_then(|t| {
            let wait = t.saturating_sub(self.now());
            Instant::now().checked_add(wait)
        });
        change.into_iter().chain(script).min()
    }
}

/// Says a line on the terminal; a terminal that is gone is no reason to stop.
fn report(line: &str) {
    let _ = writeln!(io::stderr(), "{line}");
}

impl ApplicationHandler<Message> for Viewer {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        let (width, height) = self.state.size_px();
        let size = PhysicalSize::new(
            u32::try_from(width).unwrap_or(u32::MAX),
            u32::try_from(height).unwrap_or(u32::MAX),
        );
        let attributes = backend::named(
            Window::default_attributes()
                .with_title(&self.title)
                .with_inner_size(size),
        );
        match Screen::open(event_loop, attributes) {
            Ok(screen) => {
                let size = screen.size;
                self.overlay.set_scale_factor(screen.window.scale_factor());
                self.state.set_scale_factor(screen.window.scale_factor());
                self.stage = Stage::Running(screen);
                self.resized(size);
            }
            Err(e) => self.fail(event_loop, e),
        }
    }

    fn suspended(&mut self, _event_loop: &ActiveEventLoop) {
        self.stage = Stage::Waiting;
    }

    fn user_event(&mut self, event_loop: &ActiveEventLoop, message: Message) {
        match message {
            Message::Painter(Notice::Picture(picture)) => self.take_picture(picture),
            Message::Painter(Notice::Failed(why)) => {
                self.tell(&format!("a picture failed: {why}"));
            }
            Message::Painter(Notice::Broken(why)) => {
                self.fail(event_loop, AppError::Broken { why })
            }
            Message::Painter(Notice::Probed(answer)) => {
                let (probe, found) = *answer;
                self.pending -= 1;
                self.state.advance(self.now());
                self.state.probed(&probe, found);
            }
            Message::SceneSaved(recorded, saved) => self.scene_saved(recorded, saved),
            Message::Script(Ok(line)) => self.session.push(line),
            Message::Script(Err(why)) => self.fail(event_loop, AppError::Broken { why }),
            Message::Saved(Ok(name)) => self.tell(&format!("saved {name}")),
            Message::Saved(Err(e)) => self.tell(&format!("cannot save the picture: {e}")),
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        match event {
            // By another program, behind our back.
            WindowEvent::Destroyed => event_loop.exit(),
            WindowEvent::CloseRequested => self.act(Some(Action::Quit)),
            WindowEvent::RedrawRequested => self.redraw(event_loop),
            WindowEvent::Resized(size) => self.resized(size),
            WindowEvent::Occluded(occluded) => self.occluded(occluded),
            WindowEvent::ScaleFactorChanged { scale_factor, .. } => {
                self.overlay.set_scale_factor(scale_factor);
                self.state.set_scale_factor(scale_factor);
            }
            WindowEvent::Focused(false) => {
                self.scrubbing = false;
                let action = self.input.focus_lost();
                self.act(Some(action));
            }
            WindowEvent::ModifiersChanged(modifiers) => {
                self.input
                    .set_modifiers(keys::modifiers_of(modifiers.state()));
            }
            WindowEvent::KeyboardInput {
                event,
                is_synthetic,
                ..
            } => self.key(&event, is_synthetic),
            WindowEvent::MouseInput { state, button, .. } => {
                if let Some(button) = keys::button_of(button) {
                    self.button(state, button);
                }
            }
            WindowEvent::CursorMoved { position, .. } => self.cursor_moved(position.x, position.y),
            WindowEvent::MouseWheel { delta, .. } => {
                let scale_factor = self
                    .stage
                    .screen()
                    .map_or(1.0, |screen| screen.window.scale_factor());
                let action = self.input.wheel(keys::notches_of(delta, scale_factor));
                self.act(action);
            }
            _ => {}
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        self.state.advance(self.now());
        self.play_script();
        self.obey(event_loop);
        if event_loop.exiting() {
            return;
        }
        self.note_settled();
        let too_early = self.wish();
        self.redraw_overlay_if_changed();
        let wake = too_early.into_iter().chain(self.next_change()).min();
        event_loop.set_control_flow(wake.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
    }

    fn exiting(&mut self, _event_loop: &ActiveEventLoop) {
        // The surface and the window go before the connection that they live on; files are finished.
        self.stage = Stage::Waiting;
        for thread in self.saving.drain(..) {
            let _ = thread.join();
        }
    }
}
