//! The render thread: at most one picture in the making and one order waiting, and the newest order wins.
//!
//! Events never wait for a picture, and a slow picture never builds up a queue. A picture of what moves is always
//! finished, so that something is seen of the way; the fine picture of what stands, and its refinement, stops at the
//! next tile when another order comes. Frames go round: the window gives back the one that it no longer shows, so
//! memory does not grow.

use std::any::Any;
use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use super::side::compose;
use super::state::{Probe, Wish};
use crate::camera::View;
use crate::frame::Frame;
use crate::render::{Cancelled, Picked, Progress, Refinement, RenderStats, Renderer, Samples};
use crate::world::World;

/// What to paint, and how well.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Order {
    /// The number of the scene that it is of.
    pub scene: u64,
    /// The picture.
    pub wish: Wish,
    /// Pixels of the window, each way, that a pixel of the picture stands for.
    pub pixel_size: usize,
    /// Refine it up to so many samples a pixel; 1 where pixels are larger.
    pub samples: Samples,
    /// It is one of many: the next order must not stop it.
    pub moving: bool,
    /// When a hand asked for it.
    pub asked: Option<Instant>,
}

/// A whole picture. Sides of slow engines are whatever is left over.
#[derive(Debug)]
pub struct Picture {
    /// Its pixels.
    pub frame: Frame,
    /// What was asked for; refinements were not asked for by a hand.
    pub order: Order,
    /// How fine it is.
    pub samples: Samples,
    /// What it took.
    pub stats: RenderStats,
    /// What each side took of that.
    pub side_times: [Duration; 2],
}

impl Picture {
    /// The same picture as `other`, and not as fine.
    #[must_use]
    pub fn is_coarser_than(&self, other: &Picture) -> bool {
        let (own, others) = (&self.order, &other.order);
        let is_same = own.scene == others.scene && own.wish == others.wish;
        is_same && (own.pixel_size > others.pixel_size || self.samples < other.samples)
    }
}

/// What the render thread has to tell.
#[derive(Debug)]
pub enum Notice {
    /// A picture is done.
    Picture(Box<Picture>),
    /// What a pixel shows.
    Probed(Box<(Probe, Option<Picked>)>),
    /// A picture failed; the next one may do.
    Failed(String),
}

/// The handle on the render thread. Dropped, the thread stops at the next tile; nobody waits for it.
#[derive(Debug)]
pub struct Painter {
    shared: Arc<Shared>,
}

#[derive(Debug, Default)]
struct Shared {
    desk: Mutex<Desk>,
    bell: Condvar,
    /// A picture is in the making.
    is_at_work: Arc<AtomicBool>,
    /// The next picture shall fail.
    fault: AtomicBool,
}

/// What lies between the window and the render thread.
#[derive(Debug, Default)]
struct Desk {
    order: Option<Order>,
    probes: VecDeque<Probe>,
    world: Option<Arc<World>>,
    /// The picture in the making, if another order may stop it.
    interruptible: Option<Arc<Progress>>,
    spare: Vec<Frame>,
    /// Nobody sees the window: what is being refined is not wanted.
    rests: bool,
    closed: bool,
}

/// What the thread does next, and with which world.
enum Job {
    Paint(Order, Arc<World>),
    Probe(Probe, Arc<World>),
}

impl Desk {
    fn has_job(&self) -> bool {
        self.world.is_some() && (self.order.is_some() || !self.probes.is_empty())
    }

    /// Stops the picture in the making, if that may be.
    fn interrupt(&mut self) {
        if let Some(progress) = self.interruptible.take() {
            progress.cancel();
        }
    }
}

impl Shared {
    /// A thread that panicked leaves the desk in order: every change of it is one assignment.
    fn desk(&self) -> MutexGuard<'_, Desk> {
        self.desk.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for a question or an order, and a world; `None` when the window is gone. Questions come first.
    fn next_job(&self) -> Option<Job> {
        let desk = self.desk();
        let mut desk = self
            .bell
            .wait_while(desk, |d| !d.closed && !d.has_job())
            .unwrap_or_else(PoisonError::into_inner);
        if desk.closed {
            return None;
        }
        let world = desk.world.clone()?;
        if let Some(probe) = desk.probes.pop_front() {
            return Some(Job::Probe(probe, world));
        }
        Some(Job::Paint(desk.order.take()?, world))
    }

    /// A question that waits for an answer.
    fn next_probe(&self) -> Option<(Probe, Arc<World>)> {
        let mut desk = self.desk();
        let world = desk.world.clone()?;
        Some((desk.probes.pop_front()?, world))
    }

    /// A picture of `order` begins. What came since the order was taken stops it at its first tile.
    fn begin(&self, order: &Order) -> Arc<Progress> {
        let progress = Arc::new(Progress::new());
        if self.fault.swap(false, Ordering::Relaxed) {
            progress.inject_fault();
        }
        let mut desk = self.desk();
        desk.interruptible = (!order.moving).then(|| Arc::clone(&progress));
        if desk.closed || desk.rests || desk.has_job() {
            desk.interrupt();
        }
        progress
    }

    /// True when the picture in the making is not wanted any more.
    fn is_superseded(&self) -> bool {
        let desk = self.desk();
        desk.closed || desk.rests || desk.order.is_some()
    }
}

impl Painter {
    /// Starts the thread. It paints as soon as it has a world and an order, and calls `notify` for each picture.
    ///
    /// # Errors
    /// When the system gives no thread.
    pub fn start(
        renderer: Renderer,
        notify: impl Fn(Notice) + Send + 'static,
    ) -> std::io::Result<Painter> {
        let shared = Arc::new(Shared::default());
        let painter = Painter {
            shared: Arc::clone(&shared),
        };
        thread::Builder::new()
            .name("painter".into())
            .spawn(move || paint(&renderer, &shared, &notify))?;
        Ok(painter)
    }

    /// Set while a picture is in the making: others on the same cores may want to wait.
    #[must_use]
    pub fn at_work(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.shared.is_at_work)
    }

    /// Pictures that are begun from now on show `world`: another scene, or a better tree of the same.
    pub fn set_world(&self, world: Arc<World>) {
        let old = self.shared.desk().world.replace(world);
        self.shared.bell.notify_one();
        // Millions of triangles take their time to go, and the next picture must not wait for it. Without a thread
        // they go here.
        let _ = thread::Builder::new().spawn(move || drop(old));
    }

    /// Asks for a picture, instead of one that was asked for and not begun.
    pub fn order(&self, order: Order) {
        let mut desk = self.shared.desk();
        let waited = desk.order.and_then(|old| old.asked);
        let asked = waited.into_iter().chain(order.asked).min();
        desk.order = Some(Order { asked, ..order });
        desk.rests = false;
        desk.interrupt();
        self.shared.bell.notify_one();
    }

    /// Stops work until the next order. A picture of what moves is finished.
    pub fn rest(&self) {
        let mut desk = self.shared.desk();
        desk.order = None;
        desk.rests = true;
        desk.interrupt();
    }

    /// Asks what a pixel shows. What is being refined waits for the answer.
    pub fn probe(&self, probe: Probe) {
        let mut desk = self.shared.desk();
        desk.probes.push_back(probe);
        desk.interrupt();
        self.shared.bell.notify_one();
    }

    /// For tests of what comes after a panic: a thread that renders the next picture panics.
    pub fn inject_fault(&self) {
        self.shared.fault.store(true, Ordering::Relaxed);
    }

    /// Gives back a frame that is no longer shown.
    pub fn give_back(&self, frame: Frame) {
        self.shared.desk().spare.push(frame);
    }
}

impl Drop for Painter {
    fn drop(&mut self) {
        let mut desk = self.shared.desk();
        desk.closed = true;
        desk.interrupt();
        self.shared.bell.notify_one();
    }
}

/// The thread: paints order after order, and answers questions.
fn paint(renderer: &Renderer, shared: &Shared, notify: &impl Fn(Notice)) {
    let mut refinement = Refinement::default();
    let mut scratch = Frame::default();
    while let Some(job) = shared.next_job() {
        let (order, world) = match job {
            Job::Paint(order, world) => (order, world),
            Job::Probe(probe, world) => {
                answer(renderer, &world, probe, notify);
                continue;
            }
        };
        refinement.restart();
        let view = coarse(&order.wish.view, order.pixel_size);
        let mut samples = Some(Samples::ONE);
        while let Some(now) = samples {
            let progress = shared.begin(&order);
            let mut frame = shared.desk().spare.pop().unwrap_or_default();
            let mut side_times = [Duration::ZERO; 2];
            shared.is_at_work.store(true, Ordering::Relaxed);
            let result = catch_unwind(AssertUnwindSafe(|| {
                refinement.refine(renderer, &view, now, &mut frame, |view, frame| {
                    let easel = Easel {
                        renderer,
                        world: &world,
                        progress: &progress,
                    };
                    let (stats, times) = easel.sides(&order, view, frame, &mut scratch)?;
                    (0..2).for_each(|i| side_times[i] += times[i]);
                    Ok(stats)
                })
            }));
            shared.is_at_work.store(false, Ordering::Relaxed);
            match result {
                Ok(Ok(stats)) => {
                    samples = now.refined(order.samples);
                    notify(Notice::Picture(Box::new(Picture {
                        frame,
                        order: Order {
                            asked: order.asked.filter(|_| now == Samples::ONE),
                            ..order
                        },
                        samples: now,
                        stats,
                        side_times,
                    })));
                }
                Ok(Err(Cancelled)) => {
                    shared.desk().spare.push(frame);
                    // After a question the same picture goes on: the samples that it has stay.
                    if shared.is_superseded() {
                        samples = None;
                    }
                }
                Err(panic) => {
                    notify(Notice::Failed(message_of(&*panic)));
                    samples = None;
                }
            }
            while let Some((probe, world)) = shared.next_probe() {
                answer(renderer, &world, probe, notify);
            }
        }
    }
}

/// What pictures are made with.
struct Easel<'a> {
    renderer: &'a Renderer,
    world: &'a World,
    progress: &'a Progress,
}

impl Easel<'_> {
    /// Paints the sides of a picture that are not slow, from the rays of `view`, and tells what each took.
    fn sides(
        &self,
        order: &Order,
        view: &View,
        frame: &mut Frame,
        scratch: &mut Frame,
    ) -> Result<(RenderStats, [Duration; 2]), Cancelled> {
        let mut stats = RenderStats::default();
        let mut times = [Duration::ZERO; 2];
        let mut is_first = true;
        frame.resize(view.width, view.height);
        for (side, time) in order.wish.sides().iter().zip(&mut times) {
            if !side.is_fast() {
                continue;
            }
            // Where pixels are large the border lies between two of them.
            let first = side.columns.start.div_ceil(order.pixel_size);
            let columns = first..side.columns.end.div_ceil(order.pixel_size);
            // The first one may paint beyond its border: the second is laid over that.
            let to = if is_first { &mut *frame } else { &mut *scratch };
            let one = self.renderer.columns(
                self.world,
                view,
                &side.settings,
                columns.clone(),
                to,
                self.progress,
            )?;
            if !std::mem::take(&mut is_first) {
                compose(&mut frame.pixels, view.width, Some(scratch), columns);
            }
            stats = stats + one;
            *time = one.total;
        }
        Ok((stats, times))
    }
}

/// Finds out what a pixel shows.
fn answer(renderer: &Renderer, world: &World, probe: Probe, notify: &impl Fn(Notice)) {
    let view = probe.wish.view;
    let settings = probe.wish.settings_at(probe.pixel.0);
    let (engine, kernel) = (settings.engine, settings.kernel);
    let found = catch_unwind(AssertUnwindSafe(|| {
        renderer.pick(world, &view, engine, kernel, probe.pixel)
    }));
    let found = found.unwrap_or_else(|panic| {
        notify(Notice::Failed(message_of(&*panic)));
        None
    });
    notify(Notice::Probed(Box::new((probe, found))));
}

/// The same picture in pixels of `size` times `size`: each ray goes through the middle of what its pixel stands for.
/// The last column and row may reach beyond the picture.
fn coarse(view: &View, size: usize) -> View {
    if size == 1 {
        return *view;
    }
    let to_middle = (size - 1) as f64 / 2.0;
    View {
        width: view.width.div_ceil(size),
        height: view.height.div_ceil(size),
        base: view.base + (view.dx + view.dy) * to_middle,
        dx: view.dx * size as f64,
        dy: view.dy * size as f64,
        ..*view
    }
}

/// What a panic said.
pub(super) fn message_of(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| panic.downcast_ref::<&str>().copied())
        .unwrap_or("a thread panicked")
        .to_string()
}

#[cfg(test)]
mod tests;
