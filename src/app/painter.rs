//! The render thread: at most one picture in the making and one wish waiting, and the newest wish wins.
//!
//! Events never wait for a picture, and a slow picture never builds up a queue. Frames go round: the window
//! gives back the one that it no longer shows, so memory does not grow.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;

use super::state::{Probe, Wish};
use crate::frame::Frame;
use crate::render::{Picked, Progress, RenderStats, Renderer};
use crate::scene::Scene;
use crate::world::World;

/// A whole picture.
#[derive(Debug)]
pub struct Picture {
    /// Its pixels.
    pub frame: Frame,
    /// What was asked for.
    pub wish: Wish,
    /// What it took.
    pub stats: RenderStats,
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
    /// There will be no pictures.
    Broken(String),
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
    progress: Progress,
}

/// What lies between the window and the render thread.
#[derive(Debug, Default)]
struct Desk {
    wish: Option<Wish>,
    probes: Vec<Probe>,
    spare: Vec<Frame>,
    closed: bool,
}

/// What the thread does next.
enum Job {
    Paint(Wish, Frame),
    Probe(Probe),
}

impl Shared {
    /// A thread that panicked leaves the desk in order: every change of it is one assignment.
    fn desk(&self) -> MutexGuard<'_, Desk> {
        self.desk.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for something to do; `None` when the window is gone.
    fn next_job(&self) -> Option<Job> {
        let desk = self.desk();
        let mut desk = self
            .bell
            .wait_while(desk, |d| {
                d.wish.is_none() && d.probes.is_empty() && !d.closed
            })
            .unwrap_or_else(PoisonError::into_inner);
        if desk.closed {
            return None;
        }
        if let Some(probe) = desk.probes.pop() {
            return Some(Job::Probe(probe));
        }
        let wish = desk.wish.take()?;
        let frame = desk.spare.pop().unwrap_or_default();
        Some(Job::Paint(wish, frame))
    }
}

impl Painter {
    /// Starts the thread, which compiles `scene` first. It calls `notify` for each picture.
    ///
    /// # Errors
    /// When the system gives no thread.
    pub fn start(
        scene: Scene,
        renderer: Renderer,
        notify: impl Fn(Notice) + Send + 'static,
    ) -> std::io::Result<Painter> {
        let shared = Arc::new(Shared::default());
        let painter = Painter {
            shared: Arc::clone(&shared),
        };
        thread::Builder::new()
            .name("painter".into())
            .spawn(move || paint(scene, &renderer, &shared, &notify))?;
        Ok(painter)
    }

    /// Asks for a picture, instead of one that was asked for and not begun.
    pub fn wish(&self, wish: Wish) {
        self.shared.desk().wish = Some(wish);
        self.shared.bell.notify_one();
    }

    /// Asks what a pixel shows.
    pub fn probe(&self, probe: Probe) {
        self.shared.desk().probes.push(probe);
        self.shared.bell.notify_one();
    }

    /// Gives back a frame that is no longer shown.
    pub fn give_back(&self, frame: Frame) {
        self.shared.desk().spare.push(frame);
    }
}

impl Drop for Painter {
    fn drop(&mut self) {
        self.shared.desk().closed = true;
        self.shared.progress.cancel();
        self.shared.bell.notify_one();
    }
}

/// The thread: compiles the scene, then paints wish after wish.
fn paint(scene: Scene, renderer: &Renderer, shared: &Shared, notify: &impl Fn(Notice)) {
    let compiled = catch_unwind(AssertUnwindSafe(|| {
        renderer.install(|| World::compile(&scene))
    }));
    drop(scene);
    let world = match compiled {
        Ok(world) => world,
        Err(panic) => return notify(Notice::Broken(message_of(&*panic))),
    };
    while let Some(job) = shared.next_job() {
        let (wish, mut frame) = match job {
            Job::Paint(wish, frame) => (wish, frame),
            Job::Probe(probe) => {
                let Wish { view, settings } = probe.wish;
                let (engine, kernel) = (settings.engine, settings.kernel);
                let found = catch_unwind(AssertUnwindSafe(|| {
                    renderer.pick(&world, &view, engine, kernel, probe.pixel)
                }));
                let found = found.unwrap_or_else(|panic| {
                    notify(Notice::Failed(message_of(&*panic)));
                    None
                });
                notify(Notice::Probed(Box::new((probe, found))));
                continue;
            }
        };
        let result = catch_unwind(AssertUnwindSafe(|| {
            renderer.picture(
                &world,
                &wish.view,
                &wish.settings,
                &mut frame,
                &shared.progress,
            )
        }));
        match result {
            Ok(Ok(stats)) => notify(Notice::Picture(Box::new(Picture { frame, wish, stats }))),
            Ok(Err(_cancelled)) => return,
            Err(panic) => notify(Notice::Failed(message_of(&*panic))),
        }
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
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::geometry::Aabb;
    use crate::render::Settings;
    use crate::scene::CameraSetting;
    use std::sync::mpsc::{Receiver, channel};
    use std::time::Duration;

    fn wish(width: usize) -> Wish {
        Wish {
            view: Camera::default_for(Aabb::EMPTY).view(width, 8, false),
            settings: Settings::default(),
        }
    }

    fn painter() -> (Painter, Receiver<Notice>) {
        let scene = Scene {
            camera: CameraSetting::Default,
            light: glam::Vec3::NEG_Z,
            triangles: Vec::new(),
            operations: Vec::new(),
        };
        let (send, receive) = channel();
        let renderer = Renderer::new(1).expect("one thread");
        let painter = Painter::start(scene, renderer, move |n| {
            let _ = send.send(n);
        });
        (painter.expect("one more"), receive)
    }

    fn next_picture(notices: &Receiver<Notice>) -> Box<Picture> {
        match notices.recv_timeout(Duration::from_secs(20)) {
            Ok(Notice::Picture(picture)) => picture,
            other => panic!("no picture: {other:?}"),
        }
    }

    #[test]
    fn the_newest_wish_is_painted_last_and_none_is_invented() {
        let (painter, notices) = painter();
        for width in 1..=50 {
            painter.wish(wish(width));
        }
        let mut painted = 0;
        loop {
            painted += 1;
            let picture = next_picture(&notices);
            assert_eq!(picture.frame.width, picture.wish.view.width);
            if picture.frame.width == 50 {
                break;
            }
        }
        assert!(painted <= 50);
        assert!(notices.recv_timeout(Duration::from_millis(50)).is_err());
    }

    #[test]
    fn a_frame_given_back_is_painted_again() {
        let (painter, notices) = painter();
        painter.wish(wish(16));
        let frame = next_picture(&notices).frame;
        let place = frame.pixels.as_ptr();
        painter.give_back(frame);
        painter.wish(wish(16));
        assert_eq!(next_picture(&notices).frame.pixels.as_ptr(), place);
    }

    #[test]
    fn dropping_the_handle_ends_the_thread() {
        let (painter, notices) = painter();
        drop(painter);
        // The thread held the sender.
        assert!(notices.recv_timeout(Duration::from_secs(20)).is_err());
    }
}
