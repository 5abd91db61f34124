//! The window and what shows pictures in it.

use std::sync::Arc;
use std::time::{Duration, Instant};

use winit::dpi::PhysicalSize;
use winit::event_loop::{ActiveEventLoop, OwnedDisplayHandle};
use winit::window::{Window, WindowAttributes};

use super::overlay::Canvas;
use super::painter::Picture;
use super::present::{PresentError, Presenter};
use super::{AppError, backend};

/// Pictures follow one another at the screen's rate, or at this one where it is not told.
const DEFAULT_INTERVAL: Duration = Duration::from_nanos(16_666_667);

/// A window that takes no picture for so long is seen by nobody. Wayland does not tell it in another way.
const UNSEEN: Duration = Duration::from_millis(250);

/// The window and its surface.
pub struct Screen {
    /// The window.
    pub window: Arc<Window>,
    /// The shortest time between two pictures.
    pub interval: Duration,
    /// The window system tells when it takes the next picture.
    pub tells_when: bool,
    presenter: Presenter<OwnedDisplayHandle, Arc<Window>>,
    /// On which screen the window is, is known: on Wayland only when it is shown.
    has_monitor: bool,
    /// The picture's size, which is the window's where the window system takes that.
    size: (u32, u32),
    occluded: bool,
    /// Since when it is asked for a redraw that has not come.
    waits_since: Option<Instant>,
}

impl Screen {
    /// Opens the window.
    ///
    /// # Errors
    /// When there is none to be had, or it takes no pictures.
    pub fn open(
        event_loop: &ActiveEventLoop,
        attributes: WindowAttributes,
    ) -> Result<Screen, AppError> {
        let window = event_loop
            .create_window(attributes)
            .map_err(|e| backend::no_window(&e))?;
        let window = Arc::new(window);
        let display = event_loop.owned_display_handle();
        let has_opacity = backend::has_opacity(&window);
        let presenter =
            Presenter::new(display, Arc::clone(&window), has_opacity).map_err(cannot_show)?;
        let size = window.inner_size();
        Ok(Screen {
            size: (size.width, size.height),
            interval: refresh_interval(&window),
            has_monitor: window.current_monitor().is_some(),
            tells_when: backend::tells_when(&window),
            occluded: false,
            waits_since: None,
            window,
            presenter,
        })
    }

    /// The window has another size. Returns the size of its picture, smaller where the window system takes no
    /// larger one.
    pub fn resize(&mut self, size: PhysicalSize<u32>) -> (u32, u32) {
        self.size = backend::fitted(&self.window, (size.width, size.height));
        self.request_redraw();
        self.size
    }

    /// Asks for a redraw. It comes when the window system takes a picture: on Wayland that may be never.
    pub fn request_redraw(&mut self) {
        self.waits_since.get_or_insert_with(Instant::now);
        self.window.request_redraw();
    }

    /// When it is clear that nobody sees the window, unless a redraw comes before.
    #[must_use]
    pub fn unseen_at(&self) -> Option<Instant> {
        self.waits_since.map(|since| since + UNSEEN)
    }

    /// Whether the window system has told on which screen the window is. Before that the scale factor is 1.
    #[must_use]
    pub fn has_monitor(&self) -> bool {
        self.has_monitor
    }

    /// Nothing of the window can be seen, or something can.
    pub fn set_occluded(&mut self, occluded: bool) {
        self.occluded = occluded;
    }

    fn is_visible(&self) -> bool {
        !self.occluded && self.size.0 > 0 && self.size.1 > 0
    }

    /// Shows the picture, whole, with what `draw` draws over it. Returns how long that took.
    ///
    /// # Errors
    /// When the window system does not take it.
    pub fn show(
        &mut self,
        picture: Option<&Picture>,
        draw: impl FnOnce(&mut Canvas<'_>),
    ) -> Result<Duration, AppError> {
        let start = Instant::now();
        self.waits_since = None;
        if !self.has_monitor && self.window.current_monitor().is_some() {
            self.has_monitor = true;
            self.interval = refresh_interval(&self.window);
        }
        let frame = picture.map(|p| &p.frame);
        // The first pictures need not wait: what is learned from showing them may give the window another size.
        if self.has_monitor {
            self.window.pre_present_notify();
        }
        let pixel_size = picture.map_or(1, |p| p.order.pixel_size);
        self.presenter
            .present(self.size, frame, pixel_size, draw)
            .map_err(cannot_show)?;
        Ok(start.elapsed())
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

fn cannot_show(e: PresentError) -> AppError {
    AppError::Broken {
        why: format!("the window takes no picture: {e}"),
    }
}

/// What there is of a window.
pub enum Stage {
    /// None yet, or none any more.
    Waiting,
    /// One that shows pictures.
    Running(Screen),
    /// One that nobody can see: no picture is rendered for it.
    Suspended(Screen),
}

impl Stage {
    /// The window, seen or not.
    pub fn screen(&mut self) -> Option<&mut Screen> {
        match self {
            Stage::Waiting => None,
            Stage::Running(screen) | Stage::Suspended(screen) => Some(screen),
        }
    }

    /// Asks for a redraw of a window that can be seen.
    pub fn request_redraw(&mut self) {
        if let Stage::Running(screen) = self {
            screen.request_redraw();
        }
    }

    /// Moves between running and suspended after a change of the screen.
    pub fn settle(&mut self) {
        *self = match std::mem::replace(self, Stage::Waiting) {
            Stage::Suspended(mut screen) if screen.is_visible() => {
                screen.request_redraw();
                Stage::Running(screen)
            }
            Stage::Running(screen) if !screen.is_visible() => Stage::Suspended(screen),
            same => same,
        };
    }
}
