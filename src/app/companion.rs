//! The slow engines' own thread: it paints one side of the picture bit by bit, while the painter goes on.
//!
//! A newer task stops an older one as soon as that has an outline, or has had a moment for a coarser one, and what there
//! is of it is shown: so the slow side limps after the hand and the film, and is never stuck. While the painter is at work
//! it holds still, so that nothing moves less smoothly because of it. What is shown of it is a copy, made a few times a
//! second; the first one when the picture can be made out, so that pictures of two cameras are never mixed.

use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicU8, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use super::painter::message_of;
use crate::camera::View;
use crate::frame::Frame;
use crate::render::{FAULT, Renderer, Settings, Sketch};
use crate::world::World;

/// A rough picture, without an outline yet, is shown after so long, and given up for a newer one.
const PATIENCE_MS: u64 = 250;
/// One that is not even rough, of very many triangles, after so long.
const LIMIT_MS: u64 = 1000;
/// Between two copies.
const SHOW: Duration = Duration::from_millis(60);
/// Between two looks whether the painter is done.
const LOOK: Duration = Duration::from_micros(300);

/// Which side of which picture to paint.
#[derive(Clone, Debug, PartialEq)]
pub struct Task {
    /// The number of the scene.
    pub scene: u64,
    /// The picture.
    pub view: View,
    /// How it is made.
    pub settings: Settings,
    /// What is wanted of it.
    pub columns: Range<usize>,
}

impl Task {
    /// The same picture, whatever is wanted of it.
    fn is_of_same_picture(&self, other: &Task) -> bool {
        let key = |task: &Task| (task.scene, task.view, task.settings);
        key(self) == key(other)
    }
}

/// What there is of a picture.
#[derive(Debug)]
pub struct Snapshot {
    /// Its pixels.
    pub frame: Frame,
    /// What was asked for.
    pub task: Task,
    /// The part of it that is done: 0 to 1.
    pub done: f64,
    /// Nothing is missing.
    pub is_whole: bool,
    /// What it took so far.
    pub time: Duration,
}

/// What the thread has to tell.
#[derive(Debug)]
pub enum News {
    /// There is more to see.
    Snapshot(Box<Snapshot>),
    /// A picture failed; the next one may do.
    Failed(String),
}

/// What the work under way is to do.
mod signal {
    /// Go on.
    pub const GO: u8 = 0;
    /// End soon: there is a newer task.
    pub const NEWER: u8 = 1;
    /// End now: nobody waits for it.
    pub const STOP: u8 = 2;
}

/// The handle on the thread. Dropped, the work ends at the next pixel; nobody waits for it.
#[derive(Debug)]
pub struct Companion {
    shared: Arc<Shared>,
}

#[derive(Debug)]
struct Shared {
    desk: Mutex<Desk>,
    bell: Condvar,
    signal: AtomicU8,
    /// The painter is at work.
    right_of_way: Arc<AtomicBool>,
    /// The next picture shall fail.
    fault: AtomicBool,
}

#[derive(Debug, Default)]
struct Desk {
    /// A task that is not begun.
    task: Option<Task>,
    /// The number of the scene of the task that was begun last.
    scene: Option<u64>,
    world: Option<Arc<World>>,
    spare: Option<Frame>,
    closed: bool,
}

impl Shared {
    /// A thread that panicked leaves the desk in order: every change of it is one assignment.
    fn desk(&self) -> MutexGuard<'_, Desk> {
        self.desk.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for a task and a world; `None` when the window is gone.
    fn next_task(&self) -> Option<(Task, Arc<World>)> {
        let mut desk = self
            .bell
            .wait_while(self.desk(), |d| {
                !d.closed && (d.task.is_none() || d.world.is_none())
            })
            .unwrap_or_else(PoisonError::into_inner);
        if desk.closed {
            return None;
        }
        self.signal.store(signal::GO, Ordering::Relaxed);
        let task = desk.task.take()?;
        desk.scene = Some(task.scene);
        Some((task, desk.world.clone()?))
    }

    /// Lets the painter pass. True while the work is wanted; `may_end` tells whether a newer task may end it.
    fn go_on(&self, may_end: impl Fn() -> bool) -> bool {
        if self.fault.load(Ordering::Relaxed) && self.fault.swap(false, Ordering::Relaxed) {
            panic!("{FAULT}");
        }
        loop {
            match self.signal.load(Ordering::Relaxed) {
                signal::STOP => return false,
                signal::NEWER if may_end() => return false,
                _ if !self.right_of_way.load(Ordering::Relaxed) => return true,
                _ => thread::sleep(LOOK),
            }
        }
    }
}

impl Companion {
    /// Starts the thread, which makes itself `threads` more (0: one a core) when it has something to do. It holds still
    /// while `right_of_way` is set.
    ///
    /// # Errors
    /// When the system gives no thread.
    pub fn start(
        threads: usize,
        right_of_way: Arc<AtomicBool>,
        notify: impl Fn(News) + Send + Sync + 'static,
    ) -> std::io::Result<Companion> {
        let shared = Arc::new(Shared {
            desk: Mutex::default(),
            bell: Condvar::new(),
            signal: AtomicU8::new(signal::GO),
            right_of_way,
            fault: AtomicBool::new(false),
        });
        let companion = Companion {
            shared: Arc::clone(&shared),
        };
        thread::Builder::new()
            .name("companion".into())
            .spawn(move || work(threads, &shared, &notify))?;
        Ok(companion)
    }

    /// Tasks that are begun from now on show `world`.
    pub fn set_world(&self, world: Arc<World>) {
        let old = self.shared.desk().world.replace(world);
        self.shared.bell.notify_one();
        // See `Painter::set_world`.
        let _ = thread::Builder::new().spawn(move || drop(old));
    }

    /// Asks for `task` instead of all others; `None`: for nothing.
    pub fn order(&self, task: Option<Task>) {
        let mut desk = self.shared.desk();
        let goes_on = task.as_ref().is_some_and(|t| desk.scene == Some(t.scene));
        let signal = if goes_on { signal::NEWER } else { signal::STOP };
        self.shared.signal.store(signal, Ordering::Relaxed);
        desk.task = task;
        self.shared.bell.notify_one();
    }

    /// For tests of what comes after a panic: a thread that works on the next picture panics.
    pub fn inject_fault(&self) {
        self.shared.fault.store(true, Ordering::Relaxed);
    }

    /// Gives back a frame that is no longer shown.
    pub fn give_back(&self, frame: Frame) {
        self.shared.desk().spare = Some(frame);
    }
}

impl Drop for Companion {
    fn drop(&mut self) {
        self.shared.desk().closed = true;
        self.shared.signal.store(signal::STOP, Ordering::Relaxed);
        self.shared.bell.notify_one();
    }
}

/// A picture on the easel.
struct Easel {
    task: Task,
    sketch: Mutex<Sketch>,
    /// What was spent on it before.
    spent: Duration,
}

impl Easel {
    fn new(task: Task, frame: Frame) -> Easel {
        Easel {
            sketch: Mutex::new(Sketch::new(&task.view, task.settings, frame)),
            task,
            spent: Duration::ZERO,
        }
    }

    fn sketch(&self) -> MutexGuard<'_, Sketch> {
        self.sketch.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The thread: works on task after task.
fn work(threads: usize, shared: &Shared, notify: &(impl Fn(News) + Sync)) {
    let mut renderer = None;
    let mut easel: Option<Easel> = None;
    while let Some((task, world)) = shared.next_task() {
        if renderer.is_none() {
            renderer = Renderer::new(threads).ok();
        }
        let Some(renderer) = &renderer else {
            notify(News::Failed("the system gives no threads".to_owned()));
            continue;
        };
        let painted = catch_unwind(AssertUnwindSafe(|| {
            let mut now = match easel.take() {
                Some(old) if old.task.is_of_same_picture(&task) => old,
                _ => Easel::new(task.clone(), Frame::default()),
            };
            now.task = task;
            now.sketch().want(now.task.columns.clone());
            now.spent = paint(renderer, &world, &now, shared, notify);
            now
        }));
        match painted {
            Ok(on_the_easel) => easel = Some(on_the_easel),
            Err(panic) => notify(News::Failed(message_of(&*panic))),
        }
    }
}

/// Goes on with a picture until it is whole or not wanted any more. Returns what was spent on it: it may be wanted
/// again.
fn paint(
    renderer: &Renderer,
    world: &World,
    easel: &Easel,
    shared: &Shared,
    notify: &(impl Fn(News) + Sync),
) -> Duration {
    let began = Instant::now();
    let patience_ms = AtomicU64::new(patience_ms_of(&easel.sketch()));
    let may_be_seen =
        || began.elapsed() >= Duration::from_millis(patience_ms.load(Ordering::Relaxed));
    let shown = Mutex::new(None::<Instant>);
    let show = |sketch: &Sketch| {
        let mut frame = shared.desk().spare.take().unwrap_or_default();
        frame.clone_from(sketch.frame());
        notify(News::Snapshot(Box::new(Snapshot {
            frame,
            task: easel.task.clone(),
            done: sketch.done(),
            is_whole: sketch.is_whole(),
            time: easel.spent + began.elapsed(),
        })));
    };
    let told = |sketch: &Sketch| {
        patience_ms.store(patience_ms_of(sketch), Ordering::Relaxed);
        let mut shown = shown.lock().unwrap_or_else(PoisonError::into_inner);
        let is_due = shown.is_none_or(|at| at.elapsed() >= SHOW);
        if is_due && may_be_seen() && !sketch.is_whole() {
            *shown = Some(Instant::now());
            show(sketch);
        }
    };
    let go_on = || shared.go_on(may_be_seen);
    renderer.work_on(world, &easel.sketch, &go_on, &told);
    let sketch = easel.sketch();
    let is_wanted = shared.signal.load(Ordering::Relaxed) != signal::STOP;
    let shown = shown.into_inner().unwrap_or_else(PoisonError::into_inner);
    // What a newer task ends is seen once.
    let is_due = is_wanted && shown.is_none() && sketch.done() > 0.0;
    if is_due || sketch.is_whole() {
        show(&sketch);
    }
    easel.spent + began.elapsed()
}

/// How long a picture is worked on before it may be seen as it is.
fn patience_ms_of(sketch: &Sketch) -> u64 {
    match (sketch.is_rough(), sketch.is_outlined()) {
        (false, _) => LIMIT_MS,
        (true, false) => PATIENCE_MS,
        (true, true) => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::demo;
    use crate::render::{Engine, Progress};
    use std::sync::mpsc::{Receiver, channel};

    fn stage(triangles: usize) -> (Arc<World>, View) {
        let mut scene = demo::all()[0].scene();
        scene.triangles.truncate(triangles);
        let world = World::compile(&scene);
        let view = Camera::of_scene(&scene, world.bounds()).view(100, 70, false);
        (Arc::new(world), view)
    }

    fn task(view: View) -> Task {
        Task {
            scene: 0,
            view,
            settings: Settings {
                engine: Engine::Report,
                ..Settings::default()
            },
            columns: 0..view.width,
        }
    }

    fn companion(right_of_way: &Arc<AtomicBool>) -> (Companion, Receiver<News>) {
        let (send, receive) = channel();
        let companion = Companion::start(1, Arc::clone(right_of_way), move |news| {
            let _ = send.send(news);
        });
        (companion.expect("a thread"), receive)
    }

    fn next(news: &Receiver<News>) -> Box<Snapshot> {
        match news.recv_timeout(Duration::from_secs(20)) {
            Ok(News::Snapshot(snapshot)) => snapshot,
            other => panic!("{other:?}"),
        }
    }

    /// The whole picture, after whatever there is before it.
    fn whole(news: &Receiver<News>) -> Box<Snapshot> {
        std::iter::repeat_with(|| next(news))
            .find(|snapshot| snapshot.is_whole)
            .expect("it ends")
    }

    fn expected(world: &World, task: &Task) -> Frame {
        let mut frame = Frame::default();
        Renderer::new(1)
            .expect("a thread")
            .picture(
                world,
                &task.view,
                &task.settings,
                &mut frame,
                &Progress::new(),
            )
            .expect("nobody cancels");
        frame
    }

    #[test]
    fn a_task_becomes_the_picture_of_render_to_the_bit() {
        let (companion, news) = companion(&Arc::default());
        let (world, view) = stage(100);
        companion.order(Some(task(view)));
        companion.set_world(Arc::clone(&world));
        let snapshot = whole(&news);
        assert!(snapshot.done == 1.0 && snapshot.time > Duration::ZERO);
        assert!(snapshot.frame == expected(&world, &snapshot.task));
        assert!(news.recv_timeout(Duration::from_millis(50)).is_err());
    }

    #[test]
    fn the_newest_task_is_the_one_that_is_finished() {
        let (companion, news) = companion(&Arc::default());
        let (world, view) = stage(300);
        companion.set_world(Arc::clone(&world));
        let moved = |i: u32| View {
            base: view.base + view.dx * f64::from(i),
            ..view
        };
        for i in 0..30 {
            companion.order(Some(task(moved(i))));
            thread::sleep(Duration::from_millis(1));
        }
        let last = task(moved(29));
        let mut snapshot = whole(&news);
        while snapshot.task != last {
            snapshot = whole(&news);
        }
        assert!(snapshot.frame == expected(&world, &last));
    }

    #[test]
    fn a_film_that_is_too_fast_for_outlines_is_followed_all_the_same() {
        let (companion, news) = companion(&Arc::default());
        let scene = demo::all()[0].scene();
        let world = World::compile(&scene);
        let view = Camera::of_scene(&scene, world.bounds()).view(1600, 1200, false);
        companion.set_world(Arc::new(world));
        let moved = |i: u32| View {
            base: view.base + view.dx * f64::from(i),
            ..view
        };
        // A new frame each few milliseconds, for a minute at most.
        let snapshots = (0..12_000).filter_map(|i| {
            companion.order(Some(task(moved(i))));
            let snapshot = news.recv_timeout(Duration::from_millis(5)).ok()?;
            let News::Snapshot(snapshot) = snapshot else {
                panic!("{snapshot:?}");
            };
            Some(snapshot.task.view)
        });
        let mut views: Vec<View> = snapshots.take(6).collect();
        views.dedup();
        assert!(views.len() >= 2, "{}", views.len());
    }

    #[test]
    fn what_is_done_stays_when_more_columns_are_wanted() {
        let (companion, news) = companion(&Arc::default());
        let (world, view) = stage(100);
        companion.set_world(Arc::clone(&world));
        let part = Task {
            columns: 64..100,
            ..task(view)
        };
        companion.order(Some(part));
        let first = whole(&news).time;
        companion.order(Some(task(view)));
        let all = whole(&news);
        assert!(all.time > first);
        assert!(all.frame == expected(&world, &all.task));
    }

    #[test]
    fn it_holds_still_while_the_painter_works_and_ends_when_nothing_is_wanted() {
        let right_of_way = Arc::new(AtomicBool::new(true));
        let (companion, news) = companion(&right_of_way);
        let (world, view) = stage(100);
        companion.set_world(world);
        companion.order(Some(task(view)));
        let quiet = Duration::from_millis(100);
        assert!(news.recv_timeout(quiet).is_err());
        companion.order(None);
        right_of_way.store(false, Ordering::Relaxed);
        assert!(news.recv_timeout(quiet).is_err());
        companion.order(Some(task(view)));
        whole(&news);
        drop(companion);
        // The thread held the sender.
        assert!(news.recv_timeout(Duration::from_secs(20)).is_err());
    }

    #[test]
    fn what_is_stopped_goes_on_where_it_was() {
        let (companion, news) = companion(&Arc::default());
        let (world, view) = stage(1000);
        companion.set_world(world);
        companion.order(Some(task(view)));
        let before = next(&news);
        companion.order(None);
        // What was on its way may still come.
        while news.recv_timeout(Duration::from_millis(100)).is_ok() {}
        companion.order(Some(task(view)));
        let after = next(&news);
        assert!(after.done >= before.done && after.time > before.time);
    }

    #[test]
    fn after_a_panic_the_next_picture_is_right() {
        let (companion, news) = companion(&Arc::default());
        let (world, view) = stage(10);
        companion.set_world(Arc::clone(&world));
        let mut absurd = task(view);
        absurd.view.width = usize::MAX;
        companion.order(Some(absurd));
        match news.recv_timeout(Duration::from_secs(20)) {
            Ok(News::Failed(why)) => assert!(!why.is_empty()),
            other => panic!("{other:?}"),
        }
        companion.order(Some(task(view)));
        let snapshot = whole(&news);
        assert!(snapshot.frame == expected(&world, &snapshot.task));
    }
}
