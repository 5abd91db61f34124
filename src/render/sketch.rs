//! Pictures that come bit by bit: for the engines that test every triangle at every pixel.
//!
//! Such a picture may take hours, and somebody is looking: first one pixel of each tile stands for all of them, then
//! the ones between follow, at half the distance each time. Every pixel is traced once, and in the end each is, to the
//! bit, what [`Renderer::picture`] makes of it. Work can stop before any triangle or pixel and go on later; only
//! the columns that are wanted are worked on.

use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::{EngineAtWork, Renderer, Settings, Wanted};
use crate::camera::View;
use crate::frame::Frame;
use crate::raw::PlaneTile;
use crate::simd::Kernel;
use crate::trace::{TILE, Tracer};
use crate::world::World;

/// Distances of the pixels of each pass, in pixels. A tile is a multiple of each.
const STEPS: [usize; 7] = [TILE, 32, 16, 8, 4, 2, 1];
/// The passes after which one guesses what the picture is of.
const ROUGH: usize = 2;
/// And after which one sees it.
const OUTLINE: usize = 3;

/// A picture in the making.
#[derive(Debug)]
pub struct Sketch {
    view: View,
    settings: Settings,
    columns: Range<usize>,
    frame: Frame,
    /// Pass by pass, tile by tile.
    jobs: Vec<State>,
}

/// How far a job is: a pass in a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Open,
    Taken,
    Done,
}

/// A pass in a tile.
#[derive(Clone, Copy, Debug)]
struct Job {
    pass: usize,
    tile: usize,
    /// First column and row of the tile.
    x: usize,
    y: usize,
    /// Its size inside of the picture.
    width: usize,
    height: usize,
}

impl Job {
    /// The pixels to be traced, in the tile's columns and rows.
    fn pixels(&self) -> Vec<(usize, usize)> {
        let step = STEPS[self.pass];
        let rows = (0..self.height).step_by(step);
        rows.flat_map(|y| (0..self.width).step_by(step).map(move |x| (x, y)))
            .filter(|&(x, y)| pass_of(x, y) == self.pass)
            .collect()
    }
}

/// The pass that traces a pixel: the first that comes upon it.
fn pass_of(x: usize, y: usize) -> usize {
    let falls_on = |step: &usize| x.is_multiple_of(*step) && y.is_multiple_of(*step);
    STEPS.iter().position(falls_on).unwrap_or(STEPS.len() - 1)
}

impl Sketch {
    /// A black picture of which nothing is done; the memory of `frame` is used again.
    #[must_use]
    pub fn new(view: &View, settings: Settings, mut frame: Frame) -> Sketch {
        frame.resize(view.width, view.height);
        frame.pixels.fill(0);
        let tiles = view.width.div_ceil(TILE) * view.height.div_ceil(TILE);
        Sketch {
            view: *view,
            settings,
            columns: 0..view.width,
            frame,
            jobs: vec![State::Open; STEPS.len() * tiles],
        }
    }

    /// Only these columns are wanted. What is done of others stays.
    pub fn want(&mut self, columns: Range<usize>) {
        self.columns = columns;
    }

    /// The pixels so far.
    #[must_use]
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// The part of the wanted pixels that is done: 0 to 1.
    #[must_use]
    pub fn done(&self) -> f64 {
        let (mut done, mut all) = (0.0, 0.0);
        for (index, state) in self.jobs.iter().enumerate() {
            let job = self.job(index);
            if self.is_wanted(&job) {
                // A pass has three quarters of the pixels of its grid, but the first has all.
                let share = if job.pass == 0 { 1.0 } else { 0.75 };
                let step = STEPS[job.pass] as f64;
                let weight = share * (job.width * job.height) as f64 / (step * step);
                all += weight;
                done += if *state == State::Done { weight } else { 0.0 };
            }
        }
        if all > 0.0 { done / all } else { 1.0 }
    }

    /// True when every wanted pixel is done.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.are_done(0..self.jobs.len())
    }

    /// True when one guesses what the picture is of: every wanted square of 32x32 pixels has a colour.
    #[must_use]
    pub fn is_rough(&self) -> bool {
        self.are_done(0..ROUGH * self.tiles())
    }

    /// True when one sees what the picture is of: every wanted square of 16x16 pixels has a colour.
    #[must_use]
    pub fn is_outlined(&self) -> bool {
        self.are_done(0..OUTLINE * self.tiles())
    }

    fn are_done(&self, jobs: Range<usize>) -> bool {
        let wanted = |i: &usize| self.is_wanted(&self.job(*i));
        jobs.filter(wanted).all(|i| self.jobs[i] == State::Done)
    }

    fn tiles(&self) -> usize {
        self.jobs.len() / STEPS.len()
    }

    fn job(&self, index: usize) -> Job {
        let (pass, tile) = (index / self.tiles(), index % self.tiles());
        let columns = self.view.width.div_ceil(TILE);
        let (x, y) = (tile % columns * TILE, tile / columns * TILE);
        Job {
            pass,
            tile,
            x,
            y,
            width: TILE.min(self.view.width - x),
            height: TILE.min(self.view.height - y),
        }
    }

    fn is_wanted(&self, job: &Job) -> bool {
        job.x < self.columns.end && job.x + job.width > self.columns.start
    }

    /// The next job that is wanted and that nobody has.
    fn take(&mut self) -> Option<(usize, Job)> {
        let open = |i: &usize| self.jobs[*i] == State::Open && self.is_wanted(&self.job(*i));
        let index = (0..self.jobs.len()).find(open)?;
        self.jobs[index] = State::Taken;
        Some((index, self.job(index)))
    }

    /// The job is done: each of its pixels, in the colour that `colors` (the tile's pixels) says, stands for those
    /// after it that are not done.
    fn put(&mut self, index: usize, colors: &[u32]) {
        self.jobs[index] = State::Done;
        let job = self.job(index);
        let is_done: [bool; STEPS.len()] = std::array::from_fn(|pass| {
            pass > job.pass && self.jobs[pass * self.tiles() + job.tile] == State::Done
        });
        let step = STEPS[job.pass];
        for (px, py) in job.pixels() {
            for y in py..job.height.min(py + step) {
                let row = (job.y + y) * self.frame.width + job.x;
                for x in px..job.width.min(px + step) {
                    if !is_done[pass_of(x, y)] {
                        self.frame.pixels[row + x] = colors[py * job.width + px];
                    }
                }
            }
        }
    }
}

impl Renderer {
    /// Works on `sketch` until all that is wanted of it is done, or until `go_on` says no, which is asked
    /// every few triangles. `told` is called after each job.
    pub fn work_on(
        &self,
        world: &World,
        sketch: &Mutex<Sketch>,
        go_on: &(impl Fn() -> bool + Sync),
        told: &(impl Fn(&Sketch) + Sync),
    ) {
        let (view, settings) = {
            let sketch = lock(sketch);
            (sketch.view, sketch.settings)
        };
        if !go_on() {
            return;
        }
        let engine = EngineAtWork::new(world, &view, settings.engine);
        let shader = settings.shader(world, &view, engine.t_per_w());
        let wanted = Wanted::of(&shader);
        self.pool.broadcast(|thread| {
            let mut tracer = lock(&self.tracers[thread.index()]);
            let mut colors = Vec::new();
            while go_on() {
                let Some((index, job)) = lock(sketch).take() else {
                    break;
                };
                let done = engine.job(&mut tracer, settings.kernel, wanted, &job, go_on);
                if !done {
                    lock(sketch).jobs[index] = State::Open;
                    break;
                }
                colors.resize(job.width * job.height, 0);
                let mut out = PlaneTile::alone(&mut colors, job.x, job.y, job.width, job.height);
                shader.shade(tracer.tile(), &mut out);
                let mut sketch = lock(sketch);
                sketch.put(index, &colors);
                told(&sketch);
            }
        });
    }
}

impl EngineAtWork<'_> {
    /// Traces the pixels of a job, and leaves the others of the tile without a hit; false when it was stopped.
    fn job(
        &self,
        tracer: &mut Tracer,
        kernel: Kernel,
        wanted: Wanted,
        job: &Job,
        go_on: &impl Fn() -> bool,
    ) -> bool {
        if self.goes_by_tiles() {
            self.trace(tracer, kernel, job.x, job.y, wanted);
            return true;
        }
        self.trace_pixels(tracer.cleared_tile(), job.x, job.y, &job.pixels(), go_on)
    }
}

/// What a thread that panicked leaves is whole: a job is done or not.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo;
    use crate::render::{Engine, Progress};
    use crate::shade::ViewMode;
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// The bomb's corner of a picture that is no multiple of a tile.
    fn stage() -> (World, View) {
        let scene = demo::all()[0].scene();
        let mut few = scene.clone();
        few.triangles.truncate(60);
        let world = World::compile(&few);
        let view = crate::camera::Camera::of_scene(&few, world.bounds()).view(90, 70, false);
        (world, view)
    }

    fn settings(engine: Engine) -> Settings {
        Settings {
            engine,
            ..Settings::default()
        }
    }

    fn whole(world: &World, view: &View, settings: &Settings) -> Frame {
        let mut frame = Frame::default();
        Renderer::new(1)
            .expect("a thread")
            .picture(world, view, settings, &mut frame, &Progress::new())
            .expect("nobody cancels");
        frame
    }

    #[test]
    fn bit_by_bit_it_becomes_the_picture_however_often_it_is_stopped() {
        let (world, view) = stage();
        let renderer = Renderer::new(2).expect("threads");
        for engine in [Engine::Brute, Engine::Report, Engine::Fast] {
            for mode in [ViewMode::Shaded, ViewMode::Id] {
                let settings = Settings {
                    mode,
                    ..settings(engine)
                };
                let sketch = Mutex::new(Sketch::new(&view, settings, Frame::default()));
                let (mut rounds, mut done) = (0, 0.0);
                while !lock(&sketch).is_whole() {
                    let asked = AtomicUsize::new(0);
                    // Stopped after more and more questions, at last never.
                    let go_on = || asked.fetch_add(1, Ordering::Relaxed) < 200 << rounds;
                    renderer.work_on(&world, &sketch, &go_on, &|_| ());
                    assert!(lock(&sketch).done() >= done);
                    done = lock(&sketch).done();
                    rounds += 1;
                }
                assert!(done == 1.0 && (rounds > 2 || engine == Engine::Fast));
                assert!(*lock(&sketch).frame() == whole(&world, &view, &settings));
            }
        }
    }

    #[test]
    fn only_wanted_columns_are_worked_on_and_others_can_follow() {
        let (world, view) = stage();
        let renderer = Renderer::new(1).expect("a thread");
        let settings = settings(Engine::Report);
        let mut sketch = Sketch::new(&view, settings, Frame::default());
        sketch.want(70..90);
        let sketch = Mutex::new(sketch);
        renderer.work_on(&world, &sketch, &|| true, &|_| ());
        let expected = whole(&world, &view, &settings);
        assert!(lock(&sketch).is_whole());
        let same = |columns: Range<usize>| {
            let sketch = lock(&sketch);
            let (a, b) = (&sketch.frame().pixels, &expected.pixels);
            let mut rows = a.chunks_exact(90).zip(b.chunks_exact(90));
            rows.all(|(a, b)| a[columns.clone()] == b[columns.clone()])
        };
        assert!(same(64..90) && !same(0..64));
        lock(&sketch).want(0..90);
        assert!(!lock(&sketch).is_whole());
        renderer.work_on(&world, &sketch, &|| true, &|_| ());
        assert!(same(0..90));
    }

    #[test]
    fn the_outline_comes_first_and_in_squares() {
        let (world, view) = stage();
        let renderer = Renderer::new(1).expect("a thread");
        let sketch = Mutex::new(Sketch::new(
            &view,
            settings(Engine::Brute),
            Frame::default(),
        ));
        let outline = Mutex::new(None);
        renderer.work_on(&world, &sketch, &|| true, &|sketch| {
            if sketch.is_outlined() {
                let mut outline = lock(&outline);
                outline.get_or_insert_with(|| sketch.frame().clone());
            }
        });
        let outline = lock(&outline).take().expect("an outline");
        let fine = whole(&world, &view, &settings(Engine::Brute));
        for y in 0..70 {
            for x in 0..90 {
                let pixel = outline.pixels[y * 90 + x];
                assert_eq!(pixel, fine.pixels[y / 16 * 16 * 90 + x / 16 * 16]);
            }
        }
    }
}
