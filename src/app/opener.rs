//! Opens scenes and keeps what there is to know of the open one: where it comes from, whether it is being loaded, what
//! is wrong with it, and the file's neighbours. The window asks it what to show and tells it what it hears.

mod error;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::loader::{LoadError, Loaded, Loader, Source, Stage, Told};
use super::overlay::Line;
use super::save::{Saved, Stamp};
use super::scenes::by_name;
use super::watch::Watch;
use crate::demo;
use crate::world::World;

/// A file that is saved may be written in several goes: it is read when it has been left alone for so long.
const SETTLE: Duration = Duration::from_millis(60);
/// A load that is done sooner is not spoken of.
const PATIENCE: Duration = Duration::from_millis(150);
/// A hand that is about to cancel a load does not see at once that it is done.
const REACTION: Duration = Duration::from_millis(500);
/// How often the time of a load is told anew.
const TICK: Duration = Duration::from_millis(100);

/// What other threads tell it, by way of the event loop.
#[derive(Debug)]
pub enum Heard {
    /// The loader, about the load of that number.
    Load(u64, Told),
    /// The file may have changed.
    FileChanged,
}

/// What follows from it for the window.
#[derive(Debug)]
pub enum Outcome {
    /// Show this scene.
    Show {
        /// The scene.
        loaded: Box<Loaded>,
        /// It is the same file as before, saved again.
        again: bool,
    },
    /// The scene on screen has a better tree now: nothing looks different.
    Better(Arc<World>),
    /// There is nothing to show, and will not be.
    Fatal(LoadError),
    /// It is not shown; the terminal may be told why.
    Kept(LoadError),
}

/// A load under way.
#[derive(Clone, Copy, Debug)]
struct Loading {
    stage: Stage,
    since: Instant,
}

/// What is known of a scene that was asked for.
struct Known {
    source: Source,
    /// What we wrote to the file ourselves: the scene shown, with its moves.
    written: Option<Arc<Vec<u8>>>,
    /// The file as it was before the scene shown was read from it.
    stamp: Option<Stamp>,
}

impl Known {
    fn new(source: Source) -> Known {
        Known {
            source,
            written: None,
            stamp: None,
        }
    }

    /// The scene was saved: the file has what is on screen, unless another program changed it just before.
    fn saved(&mut self, Saved { path, text, from }: Saved) {
        self.source = Source::File(path);
        let is_on_screen = from == self.stamp;
        self.written = is_on_screen.then(|| Arc::new(text));
        // No stamp is one that no file has: it is to be read.
        self.stamp = Stamp::of(&self.source).filter(|_| is_on_screen);
    }
}

/// The open scene.
pub struct Opener {
    /// The one that was asked for last.
    scene: Known,
    loader: Loader,
    loading: Option<Loading>,
    /// When a load ended that could have been cancelled, and said so.
    loaded_at: Option<Instant>,
    /// `scene` has been shown.
    is_shown: bool,
    /// Some scene has been shown.
    has_any: bool,
    /// While it has not been shown: the one before, which has.
    before: Option<Known>,
    /// So many percent are there of a better tree of it.
    improving: Option<u8>,
    error: Option<Vec<Line>>,
    reload_at: Option<Instant>,
    /// As [`Known::stamp`], of the load under way.
    next_stamp: Option<Stamp>,
    /// What cancels a load.
    cancel_key: String,
    /// We may be writing to the file: so many threads are.
    writers: usize,
    watch: Option<Watch>,
    tell: Arc<dyn Fn(Heard) + Send + Sync>,
}

impl Opener {
    /// Will load `source` with so many threads (0: one a core); `tell` is called by other threads.
    #[must_use]
    pub fn new(
        source: Source,
        threads: usize,
        tell: impl Fn(Heard) + Send + Sync + 'static,
    ) -> Opener {
        Opener {
            scene: Known::new(source),
            loader: Loader::new(threads),
            loading: None,
            loaded_at: None,
            is_shown: false,
            has_any: false,
            before: None,
            improving: None,
            error: None,
            reload_at: None,
            next_stamp: None,
            cancel_key: "Esc".to_owned(),
            writers: 0,
            watch: None,
            tell: Arc::new(tell),
        }
    }

    /// The name of the scene that was asked for last.
    #[must_use]
    pub fn name(&self) -> String {
        self.scene.source.name()
    }

    /// The name of the scene on screen; of the first one before there is any.
    #[must_use]
    pub fn shown_name(&self) -> String {
        self.before.as_ref().unwrap_or(&self.scene).source.name()
    }

    /// Where the scene comes from that was asked for last.
    #[must_use]
    pub fn source(&self) -> &Source {
        &self.scene.source
    }

    /// True while a scene is on its way.
    #[must_use]
    pub fn is_loading(&self) -> bool {
        self.loading.is_some()
    }

    /// True once there was something to show.
    #[must_use]
    pub fn has_scene(&self) -> bool {
        self.has_any
    }

    /// True while a better tree of the scene on screen is on its way.
    #[must_use]
    pub fn is_improving(&self) -> bool {
        self.improving.is_some()
    }

    /// What to say of the tree of the scene on screen while a better one is on its way.
    #[must_use]
    pub fn improvement(&self) -> Option<Line> {
        let percent = self.improving?;
        Some(Line::new("tree", format!("coarse; better one {percent} %")))
    }

    /// Loads the scene and watches its file.
    ///
    /// # Errors
    /// When the system gives no thread.
    pub fn open(&mut self, source: Source) -> Result<(), LoadError> {
        let before = std::mem::replace(&mut self.scene, Known::new(source));
        if std::mem::take(&mut self.is_shown) {
            self.before = Some(before);
        }
        self.error = None;
        self.watch();
        self.load()
    }

    fn watch(&mut self) {
        self.watch = None;
        // A pipe is read once: what is written into it is no change.
        if let Source::File(path) = &self.scene.source
            && (path.is_file() || !path.exists())
        {
            let tell = Arc::clone(&self.tell);
            // Some file systems tell nothing: then nothing is reloaded.
            self.watch = Watch::start(path, move || tell(Heard::FileChanged)).ok();
        }
    }

    /// The scene is being saved: what happens to its file is our own doing.
    pub fn begin_saving(&mut self) {
        self.writers += 1;
    }

    /// That is over. The scene on screen is now what is in the file `saved`, if any: that is no reason to load it, but
    /// another text in it is.
    pub fn end_saving(&mut self, saved: Option<Saved>) {
        self.writers -= 1;
        // While another one is loaded, this one may be gone back to.
        let on_screen = if self.is_shown {
            Some(&mut self.scene)
        } else {
            self.before.as_mut()
        };
        let (Some(saved), Some(on_screen)) = (saved, on_screen) else {
            return;
        };
        let keeps_name = matches!(&on_screen.source, Source::File(same) if *same == saved.path);
        on_screen.saved(saved);
        if !self.is_shown {
            return;
        }
        if self.scene.written.is_none() {
            self.reload_at = Some(Instant::now());
        }
        if !keeps_name {
            self.watch();
        }
    }

    /// The keys that cancel a load are called so.
    pub fn set_cancel_key(&mut self, name: String) {
        self.cancel_key = name;
    }

    /// Loads the scene that it was made with.
    ///
    /// # Errors
    /// When the system gives no thread.
    pub fn begin(&mut self) -> Result<(), LoadError> {
        self.open(self.scene.source.clone())
    }

    fn load(&mut self) -> Result<(), LoadError> {
        self.reload_at = None;
        self.next_stamp = Stamp::of(&self.scene.source);
        let tell = Arc::clone(&self.tell);
        let told = move |number, told| tell(Heard::Load(number, told));
        self.loader
            .start(self.scene.source.clone(), self.scene.written.clone(), told)
            .map_err(|e| LoadError::Broken(format!("the system gives no thread: {e}")))?;
        self.loading = Some(Loading {
            stage: Stage::Reading(None),
            since: Instant::now(),
        });
        Ok(())
    }

    /// Gives up the load under way, and goes on with the scene on screen; false when there is none of both.
    pub fn cancel(&mut self) -> bool {
        if self.loading.is_none() || !self.has_any {
            return false;
        }
        self.loader.cancel();
        self.loading = None;
        self.go_back();
        true
    }

    fn end_loading(&mut self, now: Instant) {
        let told = self.loading.take().filter(|l| now >= l.since + PATIENCE);
        self.loaded_at = told.filter(|_| self.has_any).map(|_| now);
    }

    /// True for a moment after a load that could have been cancelled: who wants to cancel it now comes too late, and
    /// wants nothing else.
    #[must_use]
    pub fn was_just_loading(&self, now: Instant) -> bool {
        self.loaded_at.is_some_and(|then| now < then + REACTION)
    }

    /// Takes the error from the screen that is there, and goes on with the scene under it; false when there is none.
    pub fn dismiss(&mut self) -> bool {
        let is_there = self.error.take().is_some();
        if is_there {
            self.go_back();
        }
        is_there
    }

    /// The scene on screen is the one of interest again, if another one was asked for.
    fn go_back(&mut self) {
        let Some(before) = self.before.take() else {
            return;
        };
        self.scene = before;
        self.is_shown = true;
        self.watch();
        let was_saved = Stamp::of(&self.scene.source) != self.scene.stamp;
        self.reload_at = was_saved.then(Instant::now);
    }

    /// Takes in what another thread tells.
    pub fn hear(&mut self, heard: Heard, now: Instant) -> Option<Outcome> {
        match heard {
            Heard::FileChanged => {
                self.reload_at = Some(now + SETTLE);
                None
            }
            Heard::Load(number, _) if !self.loader.is_wanted(number) => None,
            Heard::Load(_, Told::At(stage)) => {
                if let Some(loading) = &mut self.loading {
                    loading.stage = stage;
                }
                None
            }
            Heard::Load(_, Told::Known) => {
                self.end_loading(now);
                self.error = None;
                self.scene.stamp = self.next_stamp;
                None
            }
            Heard::Load(_, Told::Done(done)) => {
                match done {
                    Ok(_) => self.end_loading(now),
                    Err(_) => self.loading = None,
                }
                Some(self.done(done))
            }
            Heard::Load(_, Told::Improving(percent)) => {
                self.improving = Some(percent);
                None
            }
            Heard::Load(_, Told::Better(world)) => {
                self.improving = None;
                Some(Outcome::Better(world))
            }
        }
    }

    fn done(&mut self, done: Result<Box<Loaded>, LoadError>) -> Outcome {
        match done {
            Ok(loaded) => {
                self.loader.show();
                self.error = None;
                self.scene.written = None;
                self.scene.stamp = self.next_stamp;
                self.has_any = true;
                self.before = None;
                self.improving = loaded.is_coarse.then_some(0);
                let again = std::mem::replace(&mut self.is_shown, true);
                Outcome::Show { loaded, again }
            }
            Err(e) if !self.has_any => Outcome::Fatal(e),
            Err(e) => {
                self.error = Some(error::lines_of(&e));
                Outcome::Kept(e)
            }
        }
    }

    /// Loads the file again when it has been left alone after a change.
    ///
    /// # Errors
    /// When the system gives no thread.
    pub fn tick(&mut self, now: Instant) -> Result<(), LoadError> {
        match self.reload_at {
            Some(due) if due <= now && self.writers == 0 => {
                // Its folder may be another one, or the place that it points to. Before it is read: what happens from now on
                // is told.
                self.watch();
                self.load()
            }
            _ => Ok(()),
        }
    }

    /// When to call [`Opener::tick`] and look at [`Opener::board`] again.
    #[must_use]
    pub fn wake(&self, now: Instant) -> Option<Instant> {
        let progress = self.loading.map(|l| match l.since + PATIENCE {
            first if now < first => first,
            _ => now + TICK,
        });
        let reload = self.reload_at.filter(|_| self.writers == 0);
        progress.into_iter().chain(reload).min()
    }

    /// What to write over the picture: how far the load is, or what is wrong with the file.
    #[must_use]
    pub fn board(&self, now: Instant) -> Option<Vec<Line>> {
        let loading = self.loading.filter(|l| now >= l.since + PATIENCE);
        let Some(Loading { stage, since }) = loading else {
            return self.error.clone();
        };
        let ticks = now.saturating_duration_since(since).as_millis() / TICK.as_millis();
        let seconds = ticks as f64 * TICK.as_secs_f64();
        let esc = if self.has_any { "cancels" } else { "quits" };
        Some(vec![
            Line::new("loading", self.name()),
            Line::new("", format!("{stage}, {seconds:.1} s")),
            Line::new(&*self.cancel_key, esc),
        ])
    }

    /// The next or the previous scene in the file's folder, by name, round and round; of a demo, among the demos.
    #[must_use]
    pub fn neighbour(&self, forward: bool) -> Option<Source> {
        match &self.scene.source {
            Source::File(path) => neighbour(path, forward).map(Source::File),
            Source::Demo(shown) => {
                let all = demo::all();
                let at = all.iter().position(|demo| demo.name == shown.name)?;
                let step = if forward { 1 } else { all.len() - 1 };
                Some(Source::Demo(&all[(at + step) % all.len()]))
            }
            Source::Text { .. } => None,
        }
    }
}

/// The scene files (`.txt`) of a folder, by name.
///
/// # Errors
/// When it cannot be listed.
pub fn scenes_in(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let is_scene =
        |p: &PathBuf| p.extension().is_some_and(|e| e.eq_ignore_ascii_case("txt")) && p.is_file();
    let entries = std::fs::read_dir(folder)?;
    let mut scenes: Vec<PathBuf> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(is_scene)
        .collect();
    scenes.sort_by_cached_key(|path| by_name(path));
    Ok(scenes)
}

fn neighbour(path: &Path, forward: bool) -> Option<PathBuf> {
    let folder = match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    let mut others = scenes_in(folder).ok()?;
    // Named as the file is: without a folder, if it has none.
    for other in &mut others {
        *other = path.with_file_name(other.file_name()?);
    }
    others.retain(|p| p.as_path() != path);
    let next = others.partition_point(|p| p.as_path() < path);
    match (forward, others.is_empty()) {
        (_, true) => None,
        (true, _) => Some(others.swap_remove(next % others.len())),
        (false, _) => Some(others.swap_remove((next + others.len() - 1) % others.len())),
    }
}

#[cfg(test)]
mod tests;
