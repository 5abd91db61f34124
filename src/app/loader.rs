//! Reads, parses and compiles scenes on threads of its own, while the window goes on.
//!
//! One load at a time: the next one makes the one before void. A load that is cancelled ends at its next stage, and
//! what it still says is known by its number and not listened to. A large scene comes twice: with a coarse tree, so
//! that a picture stands as soon as may be, and then with the better one, which is built meanwhile. Whoever listens
//! swaps them between two pictures, which are the same to the bit.

use std::fmt;
use std::fs;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use super::painter::message_of;
use crate::bvh::Quality;
use crate::camera::Camera;
use crate::demo::{self, Demo};
use crate::geometry::Aabb;
use crate::scene::{self, CameraSetting, Operation, ParseErrors, Scene};
use crate::world::World;

/// Where the text of a scene begins, read ahead to learn its camera.
const HEAD_BYTES: usize = 1 << 14;

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
    /// Bytes come from the file.
    Reading,
    /// A demo is being made.
    Making,
    /// So many bytes become triangles.
    Parsing(usize),
    /// So many triangles become a tree.
    Building(usize),
}

impl fmt::Display for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Stage::Reading => f.write_str("reading the file"),
            Stage::Making => f.write_str("making the scene"),
            Stage::Parsing(bytes) => write!(f, "parsing {:.1} MB", *bytes as f64 / 1e6),
            Stage::Building(triangles) => write!(f, "building a tree of {triangles} triangles"),
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
    /// The same scene in a better tree, after [`Loaded::is_coarse`].
    Better(Arc<World>),
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
        let parsed = self.parse(None, &|_| ())?;
        Ok(parsed.expect("no text is known"))
    }

    /// The scene; `None` when its text is the `known` one.
    fn parse(&self, known: Option<&[u8]>, at: &impl Fn(Stage)) -> Result<Option<Scene>, LoadError> {
        let text = match self {
            Source::Demo(demo) => {
                at(Stage::Making);
                return Ok(Some(demo.scene()));
            }
            Source::Text { text, .. } => Arc::clone(text),
            Source::File(path) => {
                at(Stage::Reading);
                let why = |why| format!("cannot read {}: {why}", path.display());
                let text = read_file(path).map_err(|e| LoadError::Unreadable(why(e)))?;
                Arc::new(text)
            }
        };
        if known == Some(&text[..]) {
            return Ok(None);
        }
        at(Stage::Parsing(text.len()));
        let name = self.name();
        scene::parse(&text)
            .map(Some)
            .map_err(|errors| LoadError::Bad { name, text, errors })
    }
}

/// All bytes of a file.
///
/// # Errors
/// Why not, in words.
pub fn read_file(path: &Path) -> Result<Vec<u8>, String> {
    match fs::metadata(path) {
        Ok(m) if m.is_dir() => return Err("it is a folder".to_owned()),
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Err("no such file".to_owned()),
        _ => {}
    }
    fs::read(path).map_err(|e| e.to_string())
}

/// The first bytes of an ordinary file; a pipe can be read only once.
fn head_of(path: &Path) -> io::Result<Vec<u8>> {
    use std::io::Read as _;
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

/// Loads scenes, one at a time.
#[derive(Debug)]
pub struct Loader {
    threads: usize,
    newest: u64,
    cancelled: Arc<AtomicBool>,
}

impl Loader {
    /// Loads with so many threads; 0: one a core.
    #[must_use]
    pub fn new(threads: usize) -> Loader {
        Loader {
            threads,
            newest: 0,
            cancelled: Arc::default(),
        }
    }

    /// Loads `source`, instead of whatever is being loaded, unless its text is the `known` one. `tell` is called with the number of this load, which
    /// [`Loader::is_newest`] knows, on another thread.
    ///
    /// # Errors
    /// When the system gives no thread.
    pub fn start(
        &mut self,
        source: Source,
        known: Option<Arc<Vec<u8>>>,
        tell: impl Fn(u64, Told) + Send + Sync + 'static,
    ) -> io::Result<()> {
        self.cancel();
        let (number, threads) = (self.newest, self.threads);
        let cancelled = Arc::clone(&self.cancelled);
        let work = move || {
            let tell = |told| tell(number, told);
            let known = known.as_ref().map(|text| &text[..]);
            let ended = catch_unwind(AssertUnwindSafe(|| {
                load(&source, known, threads, &cancelled, &tell);
            }));
            if let Err(panic) = ended {
                tell(Told::Done(Err(LoadError::Broken(message_of(&*panic)))));
            }
        };
        thread::Builder::new()
            .name("loader".into())
            .spawn(work)
            .map(drop)
    }

    /// What is being loaded is no longer wanted.
    pub fn cancel(&mut self) {
        self.cancelled.store(true, Ordering::Relaxed);
        self.cancelled = Arc::default();
        self.newest += 1;
    }

    /// True for the number of the load that was started last and not cancelled.
    #[must_use]
    pub fn is_newest(&self, number: u64) -> bool {
        number == self.newest
    }
}

/// The whole way from a source to a world, told step by step; it ends early when it is cancelled.
fn load(
    source: &Source,
    known: Option<&[u8]>,
    threads: usize,
    cancelled: &AtomicBool,
    tell: &(impl Fn(Told) + Sync),
) {
    let is_cancelled = || cancelled.load(Ordering::Relaxed);
    // Threads of its own: those that render have pictures to make meanwhile.
    let pool = match pool(threads) {
        Ok(pool) => pool,
        Err(e) => return tell(Told::Done(Err(e))),
    };
    let at = |stage| tell(Told::At(stage));
    let scene = match pool.install(|| source.parse(known, &at)) {
        Ok(Some(scene)) => scene,
        Ok(None) => return tell(Told::Known),
        Err(e) => return tell(Told::Done(Err(e))),
    };
    if is_cancelled() {
        return;
    }
    let is_coarse = scene.triangles.len() >= LARGE;
    let quality = match is_coarse {
        true => Quality::Coarse,
        false => Quality::Fine,
    };
    at(Stage::Building(scene.triangles.len()));
    let world = Arc::new(pool.install(|| World::with_quality(&scene, quality)));
    let bounds = world.bounds();
    tell(Told::Done(Ok(Box::new(Loaded {
        camera: scene.camera,
        base: Camera::of_scene(&scene, bounds),
        operations: scene.operations.clone(),
        bounds,
        world,
        is_coarse,
    }))));
    if !is_coarse || is_cancelled() {
        return;
    }
    // Half of the threads: the hand has begun to turn the scene.
    let half = pool.current_num_threads().div_ceil(2);
    drop(pool);
    let better = self::pool(half).map(|pool| pool.install(|| World::compile(&scene)));
    // Without threads the coarse tree stays: it shows the same.
    if let Ok(world) = better {
        tell(Told::Better(Arc::new(world)));
    }
}

fn pool(threads: usize) -> Result<rayon::ThreadPool, LoadError> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|e| LoadError::Broken(format!("the system gives no threads: {e}")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc::{Receiver, channel};
    use std::time::Duration;

    const CAMERA: &str = "<s 0 0 5 -1.6 0.9 3 1.6 0.9 3 -1.6 -0.9 3";

    fn text(text: &str) -> Source {
        Source::Text {
            name: "it".into(),
            text: Arc::new(text.into()),
        }
    }

    fn start(loader: &mut Loader, source: Source) -> Receiver<(u64, Told)> {
        let (send, receive) = channel();
        let tell = move |number, told| {
            let _ = send.send((number, told));
        };
        loader.start(source, None, tell).expect("a thread");
        receive
    }

    fn done(told: &Receiver<(u64, Told)>) -> (u64, Result<Box<Loaded>, LoadError>) {
        loop {
            match told.recv_timeout(Duration::from_secs(20)).expect("an end") {
                (number, Told::Done(done)) => return (number, done),
                (_, Told::At(_) | Told::Known | Told::Better(_)) => {}
            }
        }
    }

    #[test]
    fn a_scene_comes_with_its_stages_and_its_world() {
        let mut loader = Loader::new(1);
        let scene = format!("{CAMERA} 0 0 -1 1 0 0 0 1 0 0 0 1 0 9 9 9 <o 1 <x 0.5");
        let told = start(&mut loader, text(&scene));
        let stages: Vec<String> = std::iter::from_fn(|| match told.recv() {
            Ok((_, Told::At(stage))) => Some(stage.to_string()),
            Ok((number, Told::Done(Ok(loaded)))) => {
                assert!(loader.is_newest(number));
                assert_eq!(loaded.operations.len(), 1);
                assert_eq!(loaded.world.triangle_count(), 1);
                None
            }
            other => panic!("{other:?}"),
        })
        .collect();
        assert_eq!(stages, ["parsing 0.0 MB", "building a tree of 1 triangles"]);
    }

    /// The picture of a world, by the fast engine.
    fn picture(world: &World, base: Camera) -> crate::frame::Frame {
        let mut frame = crate::frame::Frame::default();
        crate::render::Renderer::new(1)
            .expect("a thread")
            .picture(
                world,
                &base.view(160, 90, false),
                &crate::render::Settings::default(),
                &mut frame,
                &crate::render::Progress::new(),
            )
            .expect("nobody cancels");
        frame
    }

    #[test]
    fn a_large_scene_comes_with_a_coarse_tree_and_then_with_a_better_one_of_the_same_picture() {
        let mut random = crate::math::Random::new(3);
        let mut scene = format!("{CAMERA} 0.3 -1 -1 {LARGE}");
        for _ in 0..LARGE {
            let p = random.point();
            for corner in [p, p + random.point() * 0.1, p + random.point() * 0.1] {
                scene += &format!(" {} {} {}", corner.x, corner.y, corner.z);
            }
            scene += " 250 200 90";
        }
        let mut loader = Loader::new(2);
        let told = start(&mut loader, text(&scene));
        let (_, loaded) = done(&told);
        let loaded = loaded.expect("a scene");
        assert!(loaded.is_coarse);
        let Ok((number, Told::Better(better))) = told.recv() else {
            panic!("no better tree");
        };
        assert!(loader.is_newest(number) && told.recv().is_err());
        let cost = |world: &World| world.bvh_stats().sah_cost;
        assert!(cost(&better) < cost(&loaded.world));
        let shown = picture(&loaded.world, loaded.base);
        assert!(shown.pixels.iter().any(|&p| p != 0));
        assert!(shown == picture(&better, loaded.base));
    }

    #[test]
    fn a_bad_text_is_told_with_its_place_and_a_missing_file_with_its_name() {
        let mut loader = Loader::new(1);
        let (_, bad) = done(&start(&mut loader, text("<d\n0 0 -1\n1\nx")));
        let words = bad.expect_err("not a scene").to_string();
        assert!(words.starts_with("it:4:1: expected"), "{words}");
        assert!(words.contains('^'), "{words}");
        let missing = Source::File("there/is/none.txt".into());
        let (_, missing) = done(&start(&mut loader, missing));
        let words = missing.expect_err("no file").to_string();
        assert_eq!(words, "cannot read there/is/none.txt: no such file");
    }

    #[test]
    fn a_text_that_is_known_is_not_loaded() {
        let mut loader = Loader::new(1);
        let scene = format!("{CAMERA} 0 0 -1 0");
        for (known, is_loaded) in [(scene.clone(), false), (scene.clone() + " ", true)] {
            let (send, receive) = channel();
            let tell = move |_, told| {
                let _ = send.send(told);
            };
            let known = Some(Arc::new(known.into_bytes()));
            loader.start(text(&scene), known, tell).expect("a thread");
            let last = receive.iter().last();
            assert_eq!(matches!(last, Some(Told::Known)), !is_loaded, "{last:?}");
            assert_eq!(matches!(last, Some(Told::Done(Ok(_)))), is_loaded);
        }
    }

    #[test]
    fn only_the_newest_load_counts_and_none_after_a_cancel() {
        let mut loader = Loader::new(1);
        let first = start(&mut loader, text(CAMERA));
        let second = start(&mut loader, text(CAMERA));
        let (number, _) = done(&second);
        assert!(loader.is_newest(number));
        loader.cancel();
        assert!(!loader.is_newest(number));
        for (number, _) in first.iter().chain(second.try_iter()) {
            assert!(!loader.is_newest(number));
        }
    }

    #[test]
    fn the_head_of_a_text_tells_the_size_of_its_picture() {
        let size = |s: &str| text(s).default_size();
        assert_eq!(
            size(&format!("# a\n{CAMERA} 0 0 -1 7 .. ")),
            Some((853, 480))
        );
        let apart = CAMERA.replace("<s", "< S").replace("0 5", "0 5 # eye\n");
        assert_eq!(size(&apart), Some((853, 480)));
        assert_eq!(size("<d 0 0 -1 0"), None);
        assert_eq!(size("<s 1 2"), None);
        assert_eq!(size(""), None);
    }
}
