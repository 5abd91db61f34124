//! The render thread: at most one picture in the making and one order waiting, and the newest order wins.
//!
//! Events never wait for a picture, and a slow picture never builds up a queue. A picture of what moves is always
//! finished, so that something is seen of the way; the fine picture of what stands, and its refinement, stops at the
//! next tile when another order comes. Frames go round: the window gives back the one that it no longer shows, so
//! memory does not grow.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Instant;

use super::state::Wish;
use crate::camera::View;
use crate::frame::Frame;
use crate::render::{Cancelled, Progress, Refinement, RenderStats, Renderer, Samples};
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

/// A whole picture.
#[derive(Debug)]
pub struct Picture {
    /// Its pixels.
    pub frame: Frame,
    /// The number of the scene that was asked for.
    pub scene: u64,
    /// What was asked for.
    pub wish: Wish,
    /// Pixels of the window, each way, that one of its pixels stands for.
    pub pixel_size: usize,
    /// How fine it is.
    pub samples: Samples,
    /// It was one of many.
    pub moving: bool,
    /// When a hand asked for it; refinements are not asked for.
    pub asked: Option<Instant>,
    /// What it took.
    pub stats: RenderStats,
}

/// What the render thread has to tell.
#[derive(Debug)]
pub enum Notice {
    /// A picture is done.
    Picture(Box<Picture>),
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
}

/// What lies between the window and the render thread.
#[derive(Debug, Default)]
struct Desk {
    order: Option<Order>,
    world: Option<Arc<World>>,
    /// The picture in the making, if another order may stop it.
    interruptible: Option<Arc<Progress>>,
    spare: Vec<Frame>,
    closed: bool,
}

/// What the thread needs for an order.
struct Job {
    order: Order,
    world: Arc<World>,
    progress: Arc<Progress>,
}

impl Shared {
    /// A thread that panicked leaves the desk in order: every change of it is one assignment.
    fn desk(&self) -> MutexGuard<'_, Desk> {
        self.desk.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for an order and a world; `None` when the window is gone.
    fn next_job(&self) -> Option<Job> {
        let desk = self.desk();
        let idle = |d: &mut Desk| (d.order.is_none() || d.world.is_none()) && !d.closed;
        let mut desk = self
            .bell
            .wait_while(desk, idle)
            .unwrap_or_else(PoisonError::into_inner);
        if desk.closed {
            return None;
        }
        let world = desk.world.clone()?;
        let order = desk.order.take()?;
        let progress = Arc::new(Progress::new());
        desk.interruptible = (!order.moving).then(|| Arc::clone(&progress));
        Some(Job {
            order,
            world,
            progress,
        })
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
        if let Some(progress) = desk.interruptible.take() {
            progress.cancel();
        }
        self.shared.bell.notify_one();
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
        if let Some(progress) = desk.interruptible.take() {
            progress.cancel();
        }
        self.shared.bell.notify_one();
    }
}

/// The thread: paints order after order.
fn paint(renderer: &Renderer, shared: &Shared, notify: &impl Fn(Notice)) {
    let mut refinement = Refinement::default();
    while let Some(job) = shared.next_job() {
        refinement.restart();
        let mut samples = Some(Samples::ONE);
        while let Some(now) = samples {
            let mut frame = shared.desk().spare.pop().unwrap_or_default();
            let result = catch_unwind(AssertUnwindSafe(|| {
                picture(renderer, &job, &mut refinement, now, &mut frame)
            }));
            samples = now.refined(job.order.samples);
            match result {
                Ok(Ok(stats)) => notify(Notice::Picture(Box::new(Picture {
                    frame,
                    scene: job.order.scene,
                    wish: job.order.wish,
                    pixel_size: job.order.pixel_size,
                    samples: now,
                    moving: job.order.moving,
                    asked: job.order.asked.filter(|_| now == Samples::ONE),
                    stats,
                }))),
                Ok(Err(Cancelled)) => {
                    shared.desk().spare.push(frame);
                    samples = None;
                }
                Err(panic) => {
                    notify(Notice::Failed(message_of(&*panic)));
                    samples = None;
                }
            }
        }
    }
}

/// The picture of `job` with `samples` samples.
fn picture(
    renderer: &Renderer,
    job: &Job,
    refinement: &mut Refinement,
    samples: Samples,
    frame: &mut Frame,
) -> Result<RenderStats, Cancelled> {
    let Wish { view, settings } = &job.order.wish;
    let view = coarse(view, job.order.pixel_size);
    let progress = &job.progress;
    refinement.picture(
        renderer, &job.world, &view, settings, samples, frame, progress,
    )
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
