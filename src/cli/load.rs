//! From a file's name to a scene that is ready to be rendered.

use std::io::{self, Read};
use std::path::Path;

use glam::DVec3;

use super::args::{PictureOptions, TimeOptions};
use super::console::{color, say, with_part_bar};
use super::exit::Failure;
use super::values::Size;
use crate::app::read_file;
use crate::bvh::Quality;
use crate::camera::{Camera, View};
use crate::render::{Renderer, Samples, Settings};
use crate::scene::{self, Scene};
use crate::timeline::{Timing, camera_at};
use crate::watch::Watch;
use crate::world::World;

/// The text of a scene file and what to call it.
#[derive(Debug)]
pub struct Source {
    /// For messages: the path as given, `<stdin>` for `-`.
    pub name: String,
    /// The whole file.
    pub text: Vec<u8>,
}

impl Source {
    /// Reads the file `path`, or the standard input for `-`.
    ///
    /// # Errors
    /// When there is no such file, or a folder instead.
    pub fn read(path: &Path) -> Result<Source, Failure> {
        let cannot = |why: &dyn std::fmt::Display| Err(Failure::file("read", path, why));
        if is_stdin(path) {
            let mut text = Vec::new();
            return match io::stdin().lock().read_to_end(&mut text) {
                Ok(_) => Ok(Source {
                    name: "<stdin>".to_owned(),
                    text,
                }),
                Err(e) => Err(Failure::Failed(format!(
                    "cannot read the standard input: {e}"
                ))),
            };
        }
        match read_file(path) {
            Ok(text) => Ok(Source {
                name: path.display().to_string(),
                text,
            }),
            Err(e) => cannot(&e),
        }
    }

    /// Parses the text, on the current threads.
    ///
    /// # Errors
    /// The text of all problems found, each with its place.
    pub fn parse(&self, watch: Watch<'_>) -> Result<Scene, Failure> {
        scene::parse_watched(&self.text, watch)?
            .map_err(|e| Failure::BadScene(e.render(&self.name, &self.text, color())))
    }
}

/// Parses a text, on the threads of `renderer`; on a terminal a large one gets a bar.
///
/// # Errors
/// Those of [`Source::parse`].
pub fn parse(renderer: &Renderer, source: &Source) -> Result<Scene, Failure> {
    with_part_bar("parsing", |watch| renderer.install(|| source.parse(watch)))
}

/// Compiles a scene, on the threads of `renderer`; on a terminal a large one gets a bar.
#[must_use]
pub fn compile(renderer: &Renderer, scene: &Scene) -> World {
    with_part_bar("building the tree", |watch| {
        renderer.install(|| World::with_quality_watched(scene, Quality::Fine, watch))
    })
    .expect("nobody cancels")
}

/// True for `-`.
#[must_use]
pub fn is_stdin(path: &Path) -> bool {
    path == Path::new("-")
}

/// Threads to render on.
///
/// # Errors
/// When the system gives none.
pub fn renderer(threads: usize) -> Result<Renderer, Failure> {
    Renderer::new(threads).map_err(|e| Failure::Failed(format!("cannot start the threads: {e}")))
}

/// A scene, compiled, with threads to render it and the answers to where the camera stands.
#[derive(Debug)]
pub struct Stage {
    /// As the file states it.
    pub scene: Scene,
    /// The scene for the kernels.
    pub world: World,
    /// The threads.
    pub renderer: Renderer,
    /// What the pictures show.
    pub settings: Settings,
    /// Samples a pixel.
    pub samples: Samples,
    /// The scene's camera before any operation.
    pub base: Camera,
    /// What the operations turn about.
    pub pivot: DVec3,
    /// How operations become frames.
    pub timing: Timing,
    size: Option<Size>,
    stretch: bool,
}

impl Stage {
    /// Reads, parses and compiles the scene file `path`; words about it go to the error stream.
    ///
    /// # Errors
    /// Those of the file and of its text.
    pub fn load(
        path: &Path,
        picture: &PictureOptions,
        time: &TimeOptions,
    ) -> Result<Stage, Failure> {
        let renderer = renderer(picture.machine.threads)?;
        let source = Source::read(path)?;
        let scene = parse(&renderer, &source)?;
        let world = compile(&renderer, &scene);
        warn_of_degenerate(&source.name, world.degenerate_count());
        let base = Camera::of_scene(&scene, world.bounds());
        Ok(Stage {
            settings: picture.settings(),
            samples: picture.aa,
            pivot: picture.pivot.point(world.bounds()),
            timing: time.timing(),
            size: picture.size,
            stretch: picture.stretch,
            scene,
            world,
            renderer,
            base,
        })
    }

    /// The number of the last frame, which is the still picture.
    #[must_use]
    pub fn last_frame(&self) -> u64 {
        self.timing.last_frame(&self.scene.operations)
    }

    /// The rays of frame `frame`.
    #[must_use]
    pub fn view_of_frame(&self, frame: u64) -> View {
        let operations = &self.scene.operations;
        let camera = camera_at(self.base, operations, self.timing, frame, self.pivot);
        self.view(camera, self.base)
    }

    /// The rays of `camera`; `shape` gives the picture's size when none was asked for.
    #[must_use]
    pub fn view(&self, camera: Camera, shape: Camera) -> View {
        let (width, height) = match self.size {
            Some(size) => (size.width, size.height),
            None => shape.default_size(),
        };
        camera.view(width, height, self.stretch)
    }
}

fn warn_of_degenerate(name: &str, count: usize) {
    match count {
        0 => {}
        1 => say(format_args!(
            "{name}: warning: 1 triangle has no area and is never hit (raybomb check tells where)"
        )),
        n => say(format_args!(
            "{name}: warning: {n} triangles have no area and are never hit (raybomb check tells where)"
        )),
    }
}
