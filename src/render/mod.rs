//! Camera to tiles to hits to colours, in parallel: whole pictures.
//!
//! The window and the files get their pictures from the same [`Renderer`], so they are the same bits.

mod hit_plane;
mod pick;
mod points;
mod samples;
mod sketch;

use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use crate::bvh::Bvh;
use crate::camera::View;
use crate::frame::{Frame, Hit, Hits};
use crate::raw::{PlaneTile, TiledPlane};
use crate::report::ReportTracer;
use crate::shade::{self, Shader};
pub use crate::shade::{COST_SCALE, Reflection, ViewMode};
use crate::simd::Kernel;
use crate::trace::tile::pixel_offset;
use crate::trace::{Rig, StageTicks, TILE, Tile, TileSpace, Tracer, brute, probe};
pub use crate::watch::Cancelled;
use crate::world::World;
pub use pick::Picked;
pub use points::{Point, each_point};
pub use samples::{Refinement, Samples};
pub use sketch::Sketch;

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
    /// For [`ViewMode::Cost`]: so many tests per 4x4 pixels are shown white.
    pub cost_scale: u32,
}

impl Default for Settings {
    fn default() -> Settings {
        Settings {
            engine: Engine::default(),
            kernel: Kernel::best(),
            mode: ViewMode::default(),
            reflection: Reflection::default(),
            cost_scale: COST_SCALE,
        }
    }
}

impl Settings {
    fn shader<'a>(&self, world: &'a World, view: &View, t_per_w: f32) -> Shader<'a> {
        Shader::new(
            world,
            view,
            self.kernel,
            self.mode,
            self.reflection,
            self.cost_scale,
            t_per_w,
        )
    }
}

/// What a panic says that a test asked for.
pub(crate) const FAULT: &str = "a fault was asked for";

/// How far a picture is, and the wish to stop it; shared between threads.
#[derive(Debug, Default)]
pub struct Progress {
    cancelled: AtomicBool,
    done: AtomicUsize,
    total: AtomicUsize,
    /// The next tile that is done shall fail.
    fault: AtomicBool,
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

    /// For tests of what comes after a panic: the thread that does the next tile panics after it.
    pub(crate) fn inject_fault(&self) {
        self.fault.store(true, Ordering::Relaxed);
    }

    /// One more tile is done.
    fn step(&self) {
        self.done.fetch_add(1, Ordering::Relaxed);
        if self.fault.load(Ordering::Relaxed) && self.fault.swap(false, Ordering::Relaxed) {
            panic!("{FAULT}");
        }
    }

    fn start(&self, tiles: usize) {
        self.done.store(0, Ordering::Relaxed);
        self.total.store(tiles, Ordering::Relaxed);
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

/// What one picture took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RenderStats {
    /// Wall-clock time of the whole picture.
    pub total: Duration,
    /// Time spent finding hits, averaged over the threads.
    pub trace: Duration,
    /// Time spent colouring them or writing them down, averaged over the threads.
    pub shade: Duration,
}

impl std::ops::Add for RenderStats {
    type Output = RenderStats;

    /// What both took, one after the other.
    fn add(self, other: RenderStats) -> RenderStats {
        RenderStats {
            total: self.total + other.total,
            trace: self.trace + other.trace,
            shade: self.shade + other.shade,
        }
    }
}

/// Renders pictures on its own threads.
#[derive(Debug)]
pub struct Renderer {
    pool: rayon::ThreadPool,
    /// One for each thread; a thread only ever locks its own.
    tracers: Vec<Mutex<Tracer>>,
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
        let tracers = (0..pool.current_num_threads())
            .map(|_| Mutex::default())
            .collect();
        Ok(Renderer { pool, tracers })
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
        self.columns(world, view, settings, 0..view.width, frame, progress)
    }

    /// Renders the tiles of a picture that have a part in `columns`. The other pixels of `frame`, which takes the
    /// view's size, are whatever is left over.
    ///
    /// # Errors
    /// [`Cancelled`] when `progress` was told so; `frame` is then unfinished.
    pub fn columns(
        &self,
        world: &World,
        view: &View,
        settings: &Settings,
        columns: Range<usize>,
        frame: &mut Frame,
        progress: &Progress,
    ) -> Result<RenderStats, Cancelled> {
        frame.resize(view.width, view.height);
        let engine = EngineAtWork::new(world, view, settings.engine);
        let shader = settings.shader(world, view, engine.t_per_w());
        let wanted = Wanted::of(&shader);
        let plane = TiledPlane::new(&mut frame.pixels, view.width, view.height, TILE);
        self.each_tile(&plane, progress, |tracer, out, clock| {
            if out.x() >= columns.end || out.x() + out.width() <= columns.start {
                return;
            }
            let hit = engine.trace(tracer, settings.kernel, out.x(), out.y(), wanted);
            clock.traced();
            if hit || wanted == Wanted::Costs {
                shader.shade(tracer.tile(), out);
            } else {
                shade::background(out);
            }
            clock.shaded();
        })
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
        hits.resize(view.width, view.height);
        let engine = EngineAtWork::new(world, view, engine);
        let plane = TiledPlane::new(&mut hits.pixels, view.width, view.height, TILE);
        self.each_tile(&plane, progress, |tracer, out, clock| {
            let hit = engine.trace(tracer, kernel, out.x(), out.y(), Wanted::Hits);
            clock.traced();
            engine.write_hits(hit, tracer, kernel, out);
            clock.shaded();
        })
    }

    /// What the stages of the fast engine take for one picture, on one thread and without any output. Looking at the
    /// clock takes time itself: use the proportions.
    #[must_use]
    pub fn stages(&self, world: &World, view: &View, kernel: Kernel) -> StageTicks {
        let rig = Rig::new(view, world.bvh().bounds);
        let mut tracer = Tracer::default();
        for y in (0..view.height).step_by(TILE) {
            for x in (0..view.width).step_by(TILE) {
                tracer.trace::<probe::Timing>(kernel, world.bvh(), &rig.tile(x, y));
            }
        }
        tracer.take_stages()
    }

    /// The time that the fast engine takes for each tile of a picture, row by row, on one thread, output included.
    #[must_use]
    pub fn tile_times(&self, world: &World, view: &View, kernel: Kernel) -> Vec<Duration> {
        let mut hits = Hits::default();
        hits.resize(view.width, view.height);
        let engine = EngineAtWork::new(world, view, Engine::Fast);
        let plane = TiledPlane::new(&mut hits.pixels, view.width, view.height, TILE);
        let mut tracer = Tracer::default();
        let mut times = Vec::with_capacity(plane.count());
        while let Some(mut out) = plane.next() {
            let start = Instant::now();
            let hit = engine.trace(&mut tracer, kernel, out.x(), out.y(), Wanted::Hits);
            engine.write_hits(hit, &tracer, kernel, &mut out);
            times.push(start.elapsed());
        }
        times
    }

    /// Does `work` for every tile of `plane`: one parallel section, each thread taking the next free tile.
    fn each_tile<T: Send>(
        &self,
        plane: &TiledPlane<'_, T>,
        progress: &Progress,
        work: impl Fn(&mut Tracer, &mut PlaneTile<'_, T>, &mut Clock) + Sync,
    ) -> Result<RenderStats, Cancelled> {
        let start = Instant::now();
        progress.start(plane.count());
        let clocks = self.pool.broadcast(|thread| {
            let mut tracer = self.tracers[thread.index()]
                .lock()
                .unwrap_or_else(|poisoned| poisoned.into_inner());
            let mut clock = Clock::start();
            while !progress.is_cancelled()
                && let Some(mut out) = plane.next()
            {
                work(&mut tracer, &mut out, &mut clock);
                progress.step();
            }
            clock
        });
        if progress.is_cancelled() && progress.tiles().0 < plane.count() {
            return Err(Cancelled);
        }
        let threads = clocks.len() as u32;
        let sum =
            |part: fn(&Clock) -> Duration| clocks.iter().map(part).sum::<Duration>() / threads;
        Ok(RenderStats {
            total: start.elapsed(),
            trace: sum(|c| c.trace),
            shade: sum(|c| c.shade),
        })
    }
}

/// Adds up what a thread spends its time on.
struct Clock {
    last: Instant,
    trace: Duration,
    shade: Duration,
}

impl Clock {
    fn start() -> Clock {
        Clock {
            last: Instant::now(),
            trace: Duration::ZERO,
            shade: Duration::ZERO,
        }
    }

    fn lap(&mut self) -> Duration {
        let now = Instant::now();
        now - std::mem::replace(&mut self.last, now)
    }

    fn traced(&mut self) {
        let lap = self.lap();
        self.trace += lap;
    }

    fn shaded(&mut self) {
        let lap = self.lap();
        self.shade += lap;
    }
}

/// What is wanted of a tile.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Wanted {
    /// What each pixel hits.
    Hits,
    /// That, and the work that was done.
    Costs,
    /// What each pixel hits, or [`Tile::whole`](crate::trace::Tile::whole).
    Whole,
}

impl Wanted {
    /// By what colours it.
    fn of(shader: &Shader<'_>) -> Wanted {
        if shader.mode == ViewMode::Cost {
            Wanted::Costs
        } else if shader.knows_whole() {
            Wanted::Whole
        } else {
            Wanted::Hits
        }
    }
}

/// An engine ready for one picture.
struct EngineAtWork<'a> {
    bvh: &'a Bvh,
    view: &'a View,
    rig: Rig,
    kind: Kind<'a>,
}

enum Kind<'a> {
    Fast,
    Brute(&'a [[glam::Vec3; 3]]),
    Report(ReportTracer),
}

impl<'a> EngineAtWork<'a> {
    fn new(world: &'a World, view: &'a View, engine: Engine) -> EngineAtWork<'a> {
        EngineAtWork {
            bvh: world.bvh(),
            view,
            rig: Rig::new(view, world.bvh().bounds),
            kind: match engine {
                Engine::Fast => Kind::Fast,
                Engine::Brute => Kind::Brute(world.corners()),
                Engine::Report => Kind::Report(ReportTracer::new(world.corners())),
            },
        }
    }

    /// Writes what [`EngineAtWork::trace`] found, `hit` its answer.
    fn write_hits(&self, hit: bool, tracer: &Tracer, kernel: Kernel, out: &mut PlaneTile<'_, Hit>) {
        if hit {
            let ids = &self.bvh.file_ids;
            hit_plane::write(kernel, tracer.tile(), ids, self.t_per_w(), out);
        } else {
            hit_plane::write_misses(kernel, out);
        }
    }

    fn t_per_w(&self) -> f32 {
        self.rig.t_per_w()
    }

    /// Fills the tracer's tile with the hits of the tile whose first pixel is (`x`, `y`); false when there is none.
    fn trace(
        &self,
        tracer: &mut Tracer,
        kernel: Kernel,
        x: usize,
        y: usize,
        wanted: Wanted,
    ) -> bool {
        let space: TileSpace = self.rig.tile(x, y);
        match &self.kind {
            Kind::Fast => {
                return match wanted {
                    Wanted::Hits => tracer.trace::<probe::Silent>(kernel, self.bvh, &space),
                    Wanted::Costs => tracer.trace::<probe::Counting>(kernel, self.bvh, &space),
                    Wanted::Whole => tracer.trace_whole::<probe::Silent>(kernel, self.bvh, &space),
                };
            }
            Kind::Brute(corners) => {
                brute::trace(corners, &self.bvh.file_ids, &space, tracer.cleared_tile());
            }
            Kind::Report(_) => {
                let inside = |first: usize, size: usize| (size - first).min(TILE);
                let columns = inside(x, self.view.width);
                let rows = 0..inside(y, self.view.height);
                let pixels = rows.flat_map(|y| (0..columns).map(move |x| (x, y)));
                let pixels: Vec<_> = pixels.collect();
                self.trace_pixels(tracer.cleared_tile(), x, y, &pixels, &|| true);
            }
        }
        true
    }

    /// True for the engine that finds the hits of a whole tile at once.
    fn goes_by_tiles(&self) -> bool {
        matches!(self.kind, Kind::Fast)
    }

    /// Fills a cleared tile, whose first pixel is (`x0`, `y0`), with the hits of `pixels`, in its columns and rows, by
    /// an engine that goes from pixel to pixel; false when `go_on` said no.
    fn trace_pixels(
        &self,
        tile: &mut Tile,
        x0: usize,
        y0: usize,
        pixels: &[(usize, usize)],
        go_on: &impl Fn() -> bool,
    ) -> bool {
        let ids = &self.bvh.file_ids;
        match &self.kind {
            Kind::Fast => {}
            Kind::Brute(corners) => {
                let space = self.rig.tile(x0, y0);
                return brute::trace_pixels(corners, ids, &space, pixels, go_on, tile);
            }
            Kind::Report(report) => {
                for &(x, y) in pixels {
                    let hit = report.trace_while(self.view, x0 + x, y0 + y, ids, go_on);
                    let Some(hit) = hit else { return false };
                    if let Some(hit) = hit {
                        let at = pixel_offset(x, y);
                        tile.z[at] = (f64::from(self.t_per_w()) / hit.t) as f32;
                        tile.id[at] = hit.index;
                    }
                }
                tile.cost.fill(u32::try_from(ids.len()).unwrap_or(u32::MAX));
            }
        }
        true
    }
}
