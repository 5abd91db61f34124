//! Reads, parses and compiles scenes on threads of its own, while the window goes on.
//!
//! One load at a time: the next one makes the one before void. A load that is cancelled ends as soon as it asks, in
//! the midst of parsing or building, and what it still says is known by its number and not listened to. A large scene
//! comes twice: with a coarse tree, so that a picture stands as soon as may be, and then with the better one, which is
//! built meanwhile, until another scene is there to be shown. Whoever listens swaps them between two pictures, which
//! are the same to the bit.

use std::fmt;
use std::fs;
use std::io::{self, Read as _};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use super::painter::message_of;
use crate::bvh::Quality;
use crate::camera::Camera;
use crate::demo::{self, Demo};
use crate::geometry::Aabb;
use crate::scene::{self, CameraSetting, Operation, ParseErrors, Scene};
use crate::watch::{Cancelled, Watch};
use crate::world::World;

/// Where the text of a scene begins, read ahead to learn its camera.
const HEAD_BYTES: usize = 1 << 14;

/// So much of a file is read between two words about it.
const READ_BYTES: u64 = 1 << 24;

/// So long nothing new is told of how far the work is.
const NEWS: Duration = Duration::from_millis(100);

/// Scenes with so many triangles are shown with a coarse tree first: the better one of fewer is there at once.
const LARGE: usize = 50_000;

/// Where a scene comes from.
#[derive(Clone, Debug)]
pub enum Source {
    /// A file, read when it is loaded.
    File(PathBuf),
    /// A text that cannot be read again.
    Text {
        /// What messages call it.
        name: String,
        /// All of it.
        text: Arc<Vec<u8>>,
    },
    /// One that comes with the program.
    Demo(&'static Demo),
}

/// Why there is no scene.
#[derive(Clone, Debug, PartialEq)]
pub enum LoadError {
    /// The file cannot be read: `cannot read PATH: WHY`.
    Unreadable(String),
    /// The text is not a scene.
    Bad {
        /// What messages call it.
        name: String,
        /// All of it.
        text: Arc<Vec<u8>>,
        /// What is wrong.
        errors: ParseErrors,
    },
    /// Something failed that is not the file's fault.
    Broken(String),
}

impl LoadError {
    /// In words, with the places in the text; with `color`, there are ANSI escapes in them.
    #[must_use]
    pub fn words(&self, color: bool) -> String {
        match self {
            LoadError::Unreadable(why) | LoadError::Broken(why) => why.clone(),
            LoadError::Bad { name, text, errors } => errors.render(name, text, color),
        }
    }
}

impl fmt::Display for LoadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.words(false))
    }
}

/// A scene that is ready to be shown.
#[derive(Debug)]
pub struct Loaded {
    /// The camera as the scene states it.
    pub camera: CameraSetting,
    /// The same, before any operation.
    pub base: Camera,
    /// The scene's.
    pub operations: Vec<Operation>,
    /// The box of all triangles.
    pub bounds: Aabb,
    /// The scene for the kernels.
    pub world: Arc<World>,
    /// Its tree is a coarse one: [`Told::Better`] follows.
    pub is_coarse: bool,
}

/// What a load is busy with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Bytes come from the file: so many percent of them, if its length is known.
    Reading(Option<u8>),
    /// A demo is being made.
    Making,
    /// So many bytes become triangles: so many percent are done.
    Parsing(usize, u8),
    /// So many triangles become a tree: so many percent are in their place.
    Building(usize, u8),
}

impl fmt::Display for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Stage::Reading(None) => f.write_str("reading the file"),
            Stage::Reading(Some(percent)) => write!(f, "reading the file, {percent} %"),
            Stage::Making => f.write_str("making the scene"),
            Stage::Parsing(bytes, percent) => {
                write!(f, "parsing {:.1} MB, {percent} %", *bytes as f64 / 1e6)
            }
            Stage::Building(triangles, percent) => {
                write!(f, "building a tree of {triangles} triangles, {percent} %")
            }
        }
    }
}

/// What a load has to tell.
#[derive(Debug)]
pub enum Told {
    /// It goes on with this.
    At(Stage),
    /// The text is the known one: there is nothing to load.
    Known,
    /// There is something to show, or never will be.
    Done(Result<Box<Loaded>, LoadError>),
    /// So many percent of the better tree are there.
    Improving(u8),
    /// The same scene in a better tree, after [`Loaded::is_coarse`].
    Better(Arc<World>),
}

/// Why a load has come to its end without a scene.
#[derive(Debug)]
enum End {
    /// The text is the known one.
    Known,
    /// Nobody waits for the scene any more.
    Cancelled,
    /// There is none.
    Failed(LoadError),
}

impl From<LoadError> for End {
    fn from(error: LoadError) -> End {
        End::Failed(error)
    }
}

impl From<Cancelled> for End {
    fn from(_: Cancelled) -> End {
        End::Cancelled
    }
}

/// Tells how much is done, whichever threads come with it in whichever order; but not often, since the window is drawn
/// anew each time, and what it takes the load is longer by.
#[derive(Default)]
struct Percent(Mutex<(u8, Option<Instant>)>);

impl Percent {
    /// The percentage, when it is a higher one than before and the time has come.
    fn news(&self, done: usize, of: usize) -> Option<u8> {
        self.news_at(done, of, Instant::now())
    }

    fn news_at(&self, done: usize, of: usize, now: Instant) -> Option<u8> {
        // Otherwise another thread has the news.
        let mut last = self.0.try_lock().ok()?;
        // A percentage fits.
        let percent = (done as u128 * 100 / of.max(1) as u128).min(100) as u8;
        let is_due = |last| now.saturating_duration_since(last) >= NEWS;
        let is_news = percent > last.0 && last.1.is_none_or(is_due);
        is_news.then(|| {
            *last = (percent, Some(now));
            percent
        })
    }
}

impl Source {
    /// What messages and the title call it.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Source::File(path) => path.display().to_string(),
            Source::Text { name, .. } => name.clone(),
            Source::Demo(demo) => demo.title.to_owned(),
        }
    }

    /// The picture's size when none is asked for, from the first few numbers of the text; `None` when they do not
    /// tell.
    #[must_use]
    pub fn default_size(&self) -> Option<(usize, usize)> {
        let head = match self {
            Source::File(path) => head_of(path).ok()?,
            Source::Text { text, .. } => text[..text.len().min(HEAD_BYTES)].to_vec(),
            Source::Demo(_) => return Some(demo::DEFAULT_SIZE),
        };
        let camera = camera_in(&String::from_utf8_lossy(&head))?;
        Some(camera.default_size())
    }

    /// The scene as it is in the text.
    ///
    /// # Errors
    /// When it cannot be read, or is none.
    pub fn scene(&self) -> Result<Scene, LoadError> {
        match self.parse(None, &|_| (), &AtomicBool::new(false)) {
            Ok(scene) => Ok(scene),
            Err(End::Failed(error)) => Err(error),
            Err(End::Known | End::Cancelled) => unreachable!("no text is known, nobody cancels"),
        }
    }

    /// The scene, unless its text is the `known` one.
    fn parse(
        &self,
        known: Option<&[u8]>,
        at: &(impl Fn(Stage) + Sync),
        cancelled: &AtomicBool,
    ) -> Result<Scene, End> {
        let text = match self {
            Source::Demo(demo) => {
                at(Stage::Making);
                return Ok(demo.scene());
            }
            Source::Text { text, .. } => Arc::clone(text),
            Source::File(path) => {
                at(Stage::Reading(None));
                let unreadable =
                    |why| LoadError::Unreadable(format!("cannot read {}: {why}", path.display()));
                // A pipe has no length; a file may grow.
                let tell = |done: usize, of: usize| {
                    let percent = (done as u64 * 100).checked_div(of as u64);
                    at(Stage::Reading(percent.map(|p| p.min(100) as u8)));
                };
                let text = read(path, Watch::with_cancel(&tell, cancelled))?;
                Arc::new(text.map_err(unreadable)?)
            }
        };
        if known == Some(&text[..]) {
            return Err(End::Known);
        }
        let bytes = text.len();
        at(Stage::Parsing(bytes, 0));
        let percent = Percent::default();
        let tell = |done: usize, of: usize| {
            if let Some(percent) = percent.news(done, of) {
                at(Stage::Parsing(bytes, percent));
            }
        };
        let parsed = scene::parse_watched(&text, Watch::with_cancel(&tell, cancelled))?;
        let name = self.name();
        Ok(parsed.map_err(|errors| LoadError::Bad { name, text, errors })?)
    }
}

/// Why something was not read.
pub fn why_not(e: &io::Error) -> String {
    match e.kind() {
        io::ErrorKind::NotFound => "no such file".to_owned(),
        _ => e.to_string(),
    }
}

/// All bytes of a file.
///
/// # Errors
/// Why not, in words.
pub fn read_file(path: &Path) -> Result<Vec<u8>, String> {
    read(path, Watch::NOBODY).expect("nobody cancels")
}

/// The same, telling how many bytes of how many are there. Inside: why not, in words.
fn read(path: &Path, watch: Watch<'_>) -> Result<Result<Vec<u8>, String>, Cancelled> {
    let length = match fs::metadata(path) {
        Ok(m) if m.is_dir() => return Ok(Err("it is a folder".to_owned())),
        Ok(m) => usize::try_from(m.len()).unwrap_or(usize::MAX),
        Err(e) => return Ok(Err(why_not(&e))),
    };
    let mut text = Vec::new();
    let mut read_all = || -> io::Result<Result<(), Cancelled>> {
        let mut file = fs::File::open(path)?;
        text.try_reserve(length)?;
        while file.by_ref().take(READ_BYTES).read_to_end(&mut text)? > 0 {
            watch.tell(text.len(), length);
            if let Err(cancelled) = watch.check() {
                return Ok(Err(cancelled));
            }
        }
        Ok(Ok(()))
    };
    match read_all() {
        Ok(end) => end.map(|()| Ok(text)),
        Err(e) => Ok(Err(e.to_string())),
    }
}

/// The first bytes of an ordinary file; a pipe can be read only once.
fn head_of(path: &Path) -> io::Result<Vec<u8>> {
    let mut head = Vec::new();
    if fs::metadata(path)?.is_file() {
        let file = fs::File::open(path)?;
        file.take(HEAD_BYTES as u64).read_to_end(&mut head)?;
    }
    Ok(head)
}

/// The camera that a text begins with, if it sets one.
fn camera_in(head: &str) -> Option<Camera> {
    let code = head.lines().flat_map(|line| line.split('#').next());
    let words: Vec<&str> = code
        .flat_map(str::split_ascii_whitespace)
        .take(14)
        .collect();
    // The parser knows the rules, and whether the camera's letter stands in one word with the `<` or apart from it.
    [13, 14].into_iter().find_map(|count| {
        let text = format!("{} 0 0 -1 0", words.get(..count)?.join(" "));
        match scene::parse(text.as_bytes()).ok()?.camera {
            CameraSetting::Set(corners) => Some(Camera::from(corners)),
            CameraSetting::Default => None,
        }
    })
}

/// A load that was started: what it tells bears the number.
#[derive(Debug, Default)]
struct Ticket {
    number: u64,
    cancelled: Arc<AtomicBool>,
}

impl Drop for Ticket {
    /// Nobody waits for it any more.
    fn drop(&mut self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }
}

/// Loads scenes, one at a time. What it does ends with it.
#[derive(Debug)]
pub struct Loader {
    threads: usize,
    /// Loads that were started.
    count: u64,
    loading: Option<Ticket>,
    /// The load whose scene is shown: a better tree of it may follow.
    shown: Option<Ticket>,
}

impl Loader {
    /// Loads with so many threads; 0: one a core.
    #[must_use]
    pub fn new(threads: usize) -> Loader {
        Loader {
            threads,
            count: 0,
            loading: None,
            shown: None,
        }
    }

    /// Loads `source`, instead of whatever is being loaded, unless its text is the `known` one. `tell` is called with
    /// the number of this load, which [`Loader::is_wanted`] knows, on another thread.
    ///
    /// # Errors
    /// When the system gives no thread.
    pub fn start(
        &mut self,
        source: Source,
        known: Option<Arc<Vec<u8>>>,
        tell: impl Fn(u64, Told) + Send + Sync + 'static,
    ) -> io::Result<()> {
        self.count += 1;
        let (number, threads) = (self.count, self.threads);
        let cancelled = Arc::default();
        self.loading = Some(Ticket {
            number,
            cancelled: Arc::clone(&cancelled),
        });
        let work = move || {
            let tell = |told| tell(number, told);
            let known = known.as_ref().map(|text| &text[..]);
            let ended = catch_unwind(AssertUnwindSafe(|| {
                load(&source, known, threads, &cancelled, &tell)
            }));
            match ended {
                Ok(Ok(()) | Err(End::Cancelled)) => {}
                Ok(Err(End::Known)) => tell(Told::Known),
                Ok(Err(End::Failed(error))) => tell(Told::Done(Err(error))),
                Err(panic) => tell(Told::Done(Err(LoadError::Broken(message_of(&*panic))))),
            }
        };
        thread::Builder::new()
            .name("loader".into())
            .spawn(work)
            .map(drop)
    }

    /// What is being loaded is no longer wanted.
    pub fn cancel(&mut self) {
        self.loading = None;
    }

    /// The scene that is being loaded has come and is shown: no better tree of the one before is wanted.
    pub fn show(&mut self) {
        self.shown = self.loading.take();
    }

    /// True for the number of the load under way, and of the one whose scene is shown.
    #[must_use]
    pub fn is_wanted(&self, number: u64) -> bool {
        let tickets = self.loading.iter().chain(&self.shown);
        tickets.into_iter().any(|ticket| ticket.number == number)
    }
}

/// The whole way from a source to a world, told step by step; it ends early when it is cancelled.
fn load(
    source: &Source,
    known: Option<&[u8]>,
    threads: usize,
    cancelled: &AtomicBool,
    tell: &(impl Fn(Told) + Sync),
) -> Result<(), End> {
    // Threads of its own: those that render have pictures to make meanwhile.
    let pool = pool(threads)?;
    let at = |stage| tell(Told::At(stage));
    let scene = pool.install(|| source.parse(known, &at, cancelled))?;
    let is_coarse = scene.triangles.len() >= LARGE;
    let quality = match is_coarse {
        true => Quality::Coarse,
        false => Quality::Fine,
    };
    let count = scene.triangles.len();
    at(Stage::Building(count, 0));
    let percent = Percent::default();
    let percent_built = |done: usize, of: usize| {
        if let Some(percent) = percent.news(done, of) {
            at(Stage::Building(count, percent));
        }
    };
    let watch = Watch::with_cancel(&percent_built, cancelled);
    let world = pool.install(|| World::with_quality_watched(&scene, quality, watch))?;
    let world = Arc::new(world);
    let bounds = world.bounds();
    tell(Told::Done(Ok(Box::new(Loaded {
        camera: scene.camera,
        base: Camera::of_scene(&scene, bounds),
        operations: scene.operations.clone(),
        bounds,
        world,
        is_coarse,
    }))));
    if !is_coarse {
        return Ok(());
    }
    // The hand has begun to turn the scene: half of the threads, and those only when nobody else wants the cores.
    let half = pool.current_num_threads().div_ceil(2);
    drop(pool);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(half)
        .start_handler(|_| step_back())
        .build();
    let percent = Percent::default();
    let percent_built = |done: usize, of: usize| {
        if let Some(percent) = percent.news(done, of) {
            tell(Told::Improving(percent));
        }
    };
    let watch = Watch::with_cancel(&percent_built, cancelled);
    // Without threads the coarse tree stays: it shows the same.
    if let Ok(pool) = pool {
        let better = pool.install(|| World::with_quality_watched(&scene, Quality::Fine, watch))?;
        tell(Told::Better(Arc::new(better)));
    }
    Ok(())
}

/// The calling thread leaves the cores to others that want them, where the system knows that of single threads.
fn step_back() {
    #[cfg(target_os = "linux")]
    // That it may be refused is no fault.
    let _ = rustix::process::nice(19);
}

fn pool(threads: usize) -> Result<rayon::ThreadPool, LoadError> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|e| LoadError::Broken(format!("the system gives no threads: {e}")))
}

#[cfg(test)]
mod tests;
