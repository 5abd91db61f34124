//! The window's scene: opened, loaded again, left for another one, saved.

use std::io;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use winit::event_loop::ActiveEventLoop;

use super::session::Held;
use super::{Viewer, physical, report, title};
use crate::app::AppError;
use crate::app::journal::Ground;
use crate::app::loader::{Loaded, Source};
use crate::app::opener::{Heard, Outcome};
use crate::app::save::{Job, Saved};
use crate::app::scenes::first_scene;
use crate::app::state::{Command, Document, Subject};
use crate::app::statistics::Statistics;
use crate::camera::Camera;
use crate::world::World;

/// How saving a scene ended.
#[derive(Debug)]
pub(super) struct SaveEnding {
    pub(super) job: Job,
    pub(super) result: io::Result<Saved>,
}

impl Viewer {
    /// The opener heard something.
    pub(super) fn hear(&mut self, event_loop: &ActiveEventLoop, heard: Heard) {
        if self.drawn.0.statistics && self.opener.is_improving() {
            // They tell how far the better tree is.
            self.stage.request_redraw();
        }
        let outcome = self.opener.hear(heard, Instant::now());
        if self.kiosk.is_some() {
            return outcome
                .into_iter()
                .for_each(|outcome| self.hear_in_kiosk(event_loop, outcome));
        }
        match outcome {
            Some(Outcome::Show { loaded, again }) => self.open(*loaded, again),
            Some(Outcome::Better(world)) => self.improve(world),
            Some(Outcome::Fatal(e)) => self.fail(event_loop, AppError::NoScene(e)),
            Some(Outcome::Kept(e)) => report(&e.words(false)),
            None => {}
        }
    }

    /// Shows another scene, or the same one saved `again`.
    pub(super) fn open(&mut self, loaded: Loaded, again: bool) {
        let ground = Ground::of(self.opener.source(), &loaded);
        let Loaded {
            camera,
            base,
            operations,
            bounds,
            world,
            ..
        } = loaded;
        let subject = Subject {
            camera,
            base,
            operations,
            pivot: self.pivot.point(bounds),
            bounds,
        };
        self.state.advance(self.now());
        if again {
            let offering = self.state.withdraw_offer();
            self.state.reload(subject);
            self.journal.set_ground(ground);
            if offering {
                // They may not fit the scene any more.
                self.offer_moves();
            }
        } else {
            self.origin = self.opener.source().clone();
            self.opened += 1;
            self.held = Held::Nothing;
            self.state.open(subject);
            self.begin_journal(ground);
            self.take_shape(&base);
        }
        if std::mem::take(&mut self.play) {
            self.state.play();
        }
        self.statistics = Statistics::new(self.threads, world.triangle_count());
        self.slow.open(&world);
        self.painter.set_world(world);
        self.pace.forget();
        self.set_title();
    }

    /// Pictures to come are traced in a better tree of the same scene. Only the view of the work done looks different.
    pub(super) fn improve(&mut self, world: Arc<World>) {
        self.slow.improve(&world);
        self.painter.set_world(world);
        self.pace.improved(self.state.wish().shows_cost());
    }

    pub(super) fn set_title(&mut self) {
        if let Some(screen) = self.stage.screen() {
            screen.window.set_title(&title(&self.opener));
        }
    }

    /// The first scene gives a window its shape, unless a size was asked for.
    pub(super) fn take_shape(&mut self, camera: &Camera) {
        let (width, height) = camera.default_size();
        if self.has_own_size
            || self.kiosk.is_some()
            || self.picture.is_some()
            || self.state.size_px() == (width, height)
        {
            return;
        }
        let size = physical(width, height);
        self.memory.gives(size.into());
        let mut resized = None;
        if let Some(screen) = self.stage.screen() {
            resized = screen.window.request_inner_size(size);
        }
        // Where the answer comes later, it comes as an event.
        if let Some(size) = resized {
            self.resized(size);
        }
    }

    /// Opens another source, while the scene before it stays until that is ready.
    pub(super) fn open_source(&mut self, event_loop: &ActiveEventLoop, source: Source) {
        if let Err(e) = self.opener.open(source) {
            self.fail(event_loop, AppError::NoScene(e));
        }
    }

    pub(super) fn dropped(&mut self, path: PathBuf) {
        if self.kiosk.is_some() {
            return;
        }
        self.state.advance(self.now());
        self.state.leave(Command::Open(first_scene(path)));
    }

    pub(super) fn browse(&mut self, event_loop: &ActiveEventLoop, forward: bool) {
        match self.opener.neighbour(forward) {
            Some(source) => self.open_source(event_loop, source),
            None => self.tell("there is no other scene in the folder"),
        }
    }

    /// Saves the scene with the hand's moves, on a thread of its own.
    pub(super) fn save_scene(&mut self, document: Document) {
        self.pending += 1;
        self.opener.begin_saving();
        self.saver.save(Job {
            opened: self.opened,
            origin: self.origin.clone(),
            document,
        });
    }

    pub(super) fn scene_saved(&mut self, ending: SaveEnding) {
        let SaveEnding { job, result } = ending;
        let Job {
            opened, document, ..
        } = job;
        self.pending -= 1;
        let is_open = opened == self.opened;
        let name = match &result {
            Ok(saved) => Ok(saved.path.display().to_string()),
            Err(e) => Err(e.to_string()),
        };
        if let (true, Ok(saved)) = (is_open, &result) {
            self.origin = Source::File(saved.path.clone());
            let Document {
                camera, operations, ..
            } = document;
            let ground = self.journal.ground();
            let ground = ground.map(|ground| ground.saved(&saved.path, camera, operations));
            self.journal.set_ground(ground);
        }
        self.opener.end_saving(result.ok().filter(|_| is_open));
        self.set_title();
        self.state.advance(self.now());
        self.state.saved(is_open.then_some(document.moves), name);
    }
}
