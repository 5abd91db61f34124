//! `raybomb bench`: how fast, and whether the result is the same each time.
//!
//! One thread is steadier on a busy machine when the system pins it: `taskset -c 1 raybomb bench --threads 1 ..`.

mod memory;
mod rays;
mod report;
mod scaling;

use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use rayon::prelude::*;

use report::{Report, StagesReport};
use scaling::ScalingReport;

use super::args::{BenchArgs, Workload};
use super::console::print;
use super::exit::{Failure, Outcome};
use super::load::{Source, is_stdin, renderer};
use super::values::{ENGINES, name_of};
use crate::bvh::Quality;
use crate::camera::{Camera, Pivot, View};
use crate::export::{Hasher, picture_hash};
use crate::frame::{Frame, Hit, Hits, MISS};
use crate::raw::ticks;
use crate::render::{Engine, Progress, RenderStats, Renderer, Settings};
use crate::scene::Scene;
use crate::timeline::{Timing, camera_at};
use crate::trace::free::{self, FreeTracer, Ray, RayTree};
use crate::trace::light::LightGrid;
use crate::world::World;

/// Origins that a thread takes at once.
const STARTS_AT_ONCE: usize = 8192;

/// Measures what `args` ask for and prints it.
///
/// # Errors
/// Those of the scene, and [`Failure::Differs`] when two measurements give different results.
pub fn run(args: &BenchArgs, progress: &Progress) -> Outcome {
    if args.workload == Workload::Load && is_stdin(&args.scene) {
        return Err(Failure::Usage(
            "--workload load reads its file again and again: the standard input cannot be"
                .to_owned(),
        ));
    }
    let pictures = matches!(args.workload, Workload::Primary | Workload::Shaded);
    if args.stages && !(pictures && args.machine.engine == Engine::Fast) {
        return Err(Failure::Usage(
            "--stages needs --workload primary or shaded and --engine fast".to_owned(),
        ));
    }
    if args.scaling && !(args.workload == Workload::Primary && args.machine.engine == Engine::Fast)
    {
        return Err(Failure::Usage(
            "--scaling needs --workload primary and --engine fast".to_owned(),
        ));
    }
    let free = matches!(
        args.workload,
        Workload::Shadow | Workload::Bounce | Workload::Random
    );
    if free && args.machine.engine != Engine::Fast {
        return Err(Failure::Usage(
            "--workload shadow, bounce and random: only --engine fast traces such rays".to_owned(),
        ));
    }
    let bench = Bench::load(args, progress)?;
    let measured = match args.workload {
        Workload::Primary => bench.primary()?,
        Workload::Shaded => bench.shaded()?,
        Workload::Shadow => bench.shadow()?,
        Workload::Bounce => bench.bounce()?,
        Workload::Random => bench.random()?,
        Workload::Build => bench.build()?,
        Workload::Load => bench.load_again()?,
    };
    let mut report = bench.report(measured);
    if args.stages {
        report.stages = Some(bench.stages()?);
    }
    if args.scaling {
        let kernel = args.machine.kernel;
        let runs =
            (0..args.frames).map(|_| bench.renderer.tile_times(&bench.world, &bench.view, kernel));
        // Each tile's best: another program's slice is not the tile's.
        let best = runs.reduce(|a, b| a.into_iter().zip(b).map(|(a, b)| a.min(b)).collect());
        report.scaling = Some(ScalingReport::of(&best.unwrap_or_default()));
    }
    if args.json {
        let json = serde_json::to_string(&report)
            .map_err(|e| Failure::Failed(format!("cannot write JSON: {e}")))?;
        print(json)
    } else {
        print(report.words())
    }
}

/// What is measured.
struct Bench<'a> {
    args: &'a BenchArgs,
    progress: &'a Progress,
    renderer: Renderer,
    scene: Scene,
    world: World,
    view: View,
    build_time: Duration,
    /// Bytes while the world was built.
    build_peak: Option<usize>,
}

/// The scene with a few of its triangles.
fn beginning(scene: &Scene) -> Scene {
    Scene {
        triangles: scene.triangles.iter().take(100).copied().collect(),
        operations: scene.operations.clone(),
        ..*scene
    }
}

impl<'a> Bench<'a> {
    fn load(args: &'a BenchArgs, progress: &'a Progress) -> Result<Bench<'a>, Failure> {
        let renderer = renderer(args.machine.threads)?;
        let scene = parse_file(&renderer, &args.scene)?;
        let quality = quality(args);
        // The first use of code brings it into memory, which would count as held by the world.
        drop(renderer.install(|| World::with_quality(&beginning(&scene), quality)));
        let ((world, build_time), build_peak) = memory::peak_of(|| {
            let start = Instant::now();
            let world = renderer.install(|| World::with_quality(&scene, quality));
            (world, start.elapsed())
        });
        Ok(Bench {
            view: still_view(args, &scene, &world),
            args,
            progress,
            renderer,
            scene,
            world,
            build_time,
            build_peak,
        })
    }

    fn settings(&self) -> Settings {
        Settings {
            engine: self.args.machine.engine,
            kernel: self.args.machine.kernel,
            ..Settings::default()
        }
    }

    /// One ray a pixel into numbers and distances.
    fn primary(&self) -> Result<Measured, Failure> {
        let frame = |hits: &mut Hits| timed(|| self.trace(&self.world, hits));
        let (times, hits) = self.repeat(Hits::default(), frame, |h| hits_hash(&h.pixels))?;
        Ok(Measured::of_hits(times, &hits.pixels))
    }

    /// Rays to the light.
    fn shadow(&self) -> Result<Measured, Failure> {
        let starts = self.of_picture(rays::lit)?;
        let start = Instant::now();
        let grid = self.renderer.install(|| LightGrid::build(&self.world));
        let build_time = start.elapsed();
        let tracers = self.tracers();
        let trace = |hits: &mut Vec<bool>| {
            timed(|| {
                self.each_chunk(
                    STARTS_AT_ONCE,
                    &tracers,
                    &starts,
                    hits,
                    |tracer, starts, hits| {
                        grid.hidden(self.args.machine.kernel, &self.world, tracer, starts, hits);
                    },
                );
                Ok(())
            })
        };
        let (times, hits) = self.repeat(vec![false; starts.len()], trace, Vec::clone)?;
        let mut hasher = Hasher::default();
        hasher.update(&hits.iter().map(|&hit| u8::from(hit)).collect::<Vec<_>>());
        Ok(Measured {
            times,
            rays: Some(RayCounts {
                rays: hits.len(),
                hits: Some(hits.iter().filter(|&&hit| hit).count()),
                hash: hasher.finish(),
            }),
            extra: Extra {
                build_time,
                bytes: grid.bytes(),
            },
        })
    }

    /// Mirror rays.
    fn bounce(&self) -> Result<Measured, Failure> {
        self.closest(&self.of_picture(rays::mirrored)?)
    }

    /// Rays that have nothing in common.
    fn random(&self) -> Result<Measured, Failure> {
        let pixels = self.args.size.width * self.args.size.height;
        self.closest(&rays::random(self.world.bounds(), pixels))
    }

    fn closest(&self, rays: &[Ray]) -> Result<Measured, Failure> {
        let start = Instant::now();
        let tree = self.renderer.install(|| RayTree::build(&self.world));
        let build_time = start.elapsed();
        let tracers = self.tracers();
        let trace = |hits: &mut Vec<Hit>| {
            timed(|| {
                self.each_chunk(free::AT_ONCE, &tracers, rays, hits, |tracer, rays, hits| {
                    tree.closest_hits(self.args.machine.kernel, tracer, rays, hits);
                });
                Ok(())
            })
        };
        let (times, hits) =
            self.repeat(vec![Hit::NONE; rays.len()], trace, |hits| hits_hash(hits))?;
        Ok(Measured {
            extra: Extra {
                build_time,
                bytes: tree.bytes(),
            },
            ..Measured::of_hits(times, &hits)
        })
    }

    /// Rays or origins made from what the picture shows.
    fn of_picture<R>(
        &self,
        make: fn(&Scene, &World, &View, &Hits) -> Vec<R>,
    ) -> Result<Vec<R>, Failure> {
        let mut hits = Hits::default();
        self.trace(&self.world, &mut hits)?;
        Ok(make(&self.scene, &self.world, &self.view, &hits))
    }

    /// Traces all rays on all threads, each of which takes `at_once` at most; `tracers`: one for each thread, with the room
    /// that earlier rays made.
    fn each_chunk<R: Sync, H: Send>(
        &self,
        at_once: usize,
        tracers: &[Mutex<FreeTracer>],
        rays: &[R],
        hits: &mut [H],
        trace: impl Fn(&mut FreeTracer, &[R], &mut [H]) + Sync,
    ) {
        // A share for every thread, also of few rays.
        let share = rays.len().div_ceil(4 * self.renderer.threads());
        let at_once = share.next_multiple_of(64).clamp(64, at_once);
        self.renderer.install(|| {
            rays.par_chunks(at_once)
                .zip(hits.par_chunks_mut(at_once))
                .with_max_len(1)
                .for_each(|(rays, hits)| {
                    let thread = rayon::current_thread_index().unwrap_or(0);
                    let mut tracer = tracers[thread]
                        .lock()
                        .unwrap_or_else(PoisonError::into_inner);
                    trace(&mut tracer, rays, hits);
                });
        });
    }

    /// A tracer for each thread.
    fn tracers(&self) -> Vec<Mutex<FreeTracer>> {
        (0..self.renderer.threads())
            .map(|_| Mutex::default())
            .collect()
    }

    /// The whole picture.
    fn shaded(&self) -> Result<Measured, Failure> {
        let picture = |frame: &mut Frame| timed(|| self.picture(frame));
        let (times, frame) = self.repeat(Frame::default(), picture, picture_hash)?;
        Ok(Measured {
            times,
            rays: Some(RayCounts {
                rays: frame.pixels.len(),
                hits: None,
                hash: picture_hash(&frame),
            }),
            extra: Extra::default(),
        })
    }

    /// From the scene to the world; what is compared is what its rays hit.
    fn build(&self) -> Result<Measured, Failure> {
        let build = |world: &mut Option<World>| {
            // The last one goes before the time starts.
            *world = None;
            timed(|| {
                *world = Some(
                    self.renderer
                        .install(|| World::with_quality(&self.scene, quality(self.args))),
                );
                Ok(())
            })
        };
        let (times, _) = self.repeat(None, build, |world| {
            let mut hits = Hits::default();
            let traced = world.as_ref().map(|world| self.trace(world, &mut hits));
            traced
                .is_some_and(|t| t.is_ok())
                .then(|| hits_hash(&hits.pixels))
        })?;
        Ok(Measured::without_rays(times))
    }

    /// From the file to the scene.
    fn load_again(&self) -> Result<Measured, Failure> {
        let load = |scene: &mut Option<Scene>| {
            *scene = None;
            timed(|| {
                *scene = Some(parse_file(&self.renderer, &self.args.scene)?);
                Ok(())
            })
        };
        let same = |scene: &Option<Scene>| scene.as_ref() == Some(&self.scene);
        let (times, _) = self.repeat(None, load, same)?;
        Ok(Measured::without_rays(times))
    }

    fn trace(&self, world: &World, hits: &mut Hits) -> Result<RenderStats, Failure> {
        let machine = &self.args.machine;
        let (engine, kernel) = (machine.engine, machine.kernel);
        Ok(self
            .renderer
            .hits(world, &self.view, engine, kernel, hits, self.progress)?)
    }

    fn picture(&self, frame: &mut Frame) -> Result<RenderStats, Failure> {
        Ok(self.renderer.picture(
            &self.world,
            &self.view,
            &self.settings(),
            frame,
            self.progress,
        )?)
    }

    /// Where the ticks of a picture go: the stages of the tracer by themselves, the output from a second run.
    fn stages(&self) -> Result<StagesReport, Failure> {
        let (time, first) = (Instant::now(), ticks());
        let stages = self
            .renderer
            .stages(&self.world, &self.view, self.args.machine.kernel);
        let ticks_a_second = (ticks() - first) as f64 / time.elapsed().as_secs_f64();
        let stats = if self.args.workload == Workload::Shaded {
            let mut frame = Frame::default();
            self.picture(&mut frame)?;
            self.picture(&mut frame)?
        } else {
            let mut hits = Hits::default();
            self.trace(&self.world, &mut hits)?;
            self.trace(&self.world, &mut hits)?
        };
        let output = stats.shade.as_secs_f64() * self.renderer.threads() as f64 * ticks_a_second;
        let pixels = (self.args.size.width * self.args.size.height) as f64;
        Ok(StagesReport {
            traversal: stages.traversal as f64 / pixels,
            setup: stages.setup as f64 / pixels,
            coverage: stages.coverage as f64 / pixels,
            output: output / pixels,
        })
    }

    /// `run` works on the state and gives the time it took; the first time does not count. The results of the first
    /// and the last run must be equal: looking at those between would empty the caches that a row of frames has.
    fn repeat<T, R: PartialEq>(
        &self,
        mut state: T,
        run: impl Fn(&mut T) -> Result<Duration, Failure>,
        result: impl Fn(&T) -> R,
    ) -> Result<(Vec<Duration>, T), Failure> {
        run(&mut state)?;
        let expected = result(&state);
        let times = (0..self.args.frames)
            .map(|_| run(&mut state))
            .collect::<Result<Vec<_>, _>>()?;
        if result(&state) != expected {
            return Err(Failure::Differs(
                "the result of the last run differs from that of the first".to_owned(),
            ));
        }
        Ok((times, state))
    }

    fn report(&self, measured: Measured) -> Report {
        let Measured {
            mut times,
            rays,
            extra,
        } = measured;
        times.sort();
        let median_ms = median_ms(&times);
        let args = self.args;
        let triangles = self.world.triangle_count();
        let build = args.workload == Workload::Build;
        Report {
            scene: scene_name(&args.scene),
            workload: match args.workload {
                Workload::Primary => "primary",
                Workload::Shaded => "shaded",
                Workload::Shadow => "shadow",
                Workload::Bounce => "bounce",
                Workload::Random => "random",
                Workload::Build => "build",
                Workload::Load => "load",
            },
            engine: name_of(ENGINES, args.machine.engine),
            kernel: args.machine.kernel.name(),
            threads: self.renderer.threads(),
            width: args.size.width,
            height: args.size.height,
            triangles,
            frames: args.frames,
            median_ms,
            min_ms: ms(times[0]),
            mrays_s: rays.as_ref().map(|r| r.rays as f64 / median_ms / 1e3),
            build_ms: if build {
                median_ms
            } else {
                ms(self.build_time + extra.build_time)
            },
            bytes_per_triangle: (self.world.bytes() + extra.bytes) as f64 / triangles.max(1) as f64,
            coarse: args.coarse,
            mtris_s: build.then(|| triangles as f64 / median_ms / 1e3),
            rays: rays.as_ref().map(|r| r.rays),
            hits: rays.as_ref().and_then(|r| r.hits),
            hash: rays.map(|r| r.hash),
            peak_bytes_per_triangle: self
                .build_peak
                .filter(|_| build)
                .map(|bytes| bytes as f64 / triangles.max(1) as f64),
            stages: None,
            scaling: None,
        }
    }
}

/// What a workload took, and what came out.
struct Measured {
    times: Vec<Duration>,
    rays: Option<RayCounts>,
    extra: Extra,
}

/// What a workload builds beside the world.
#[derive(Default)]
struct Extra {
    build_time: Duration,
    bytes: usize,
}

/// Rays and what they hit.
struct RayCounts {
    rays: usize,
    hits: Option<usize>,
    /// Of all results: the same for every kernel and number of threads.
    hash: String,
}

impl Measured {
    fn without_rays(times: Vec<Duration>) -> Measured {
        Measured {
            times,
            rays: None,
            extra: Extra::default(),
        }
    }

    fn of_hits(times: Vec<Duration>, hits: &[Hit]) -> Measured {
        Measured {
            times,
            rays: Some(RayCounts {
                rays: hits.len(),
                hits: Some(hits.iter().filter(|hit| hit.id != MISS).count()),
                hash: hits_hash(hits),
            }),
            extra: Extra::default(),
        }
    }
}

fn parse_file(renderer: &Renderer, path: &Path) -> Result<Scene, Failure> {
    let source = Source::read(path)?;
    renderer.install(|| source.parse())
}

fn quality(args: &BenchArgs) -> Quality {
    if args.coarse {
        Quality::Coarse
    } else {
        Quality::Fine
    }
}

/// The still picture: what `render` shows.
fn still_view(args: &BenchArgs, scene: &Scene, world: &World) -> View {
    let base = Camera::of_scene(scene, world.bounds());
    let timing = Timing::default();
    let last = timing.last_frame(&scene.operations);
    let pivot = Pivot::default().point(world.bounds());
    camera_at(base, &scene.operations, timing, last, pivot).view(
        args.size.width,
        args.size.height,
        false,
    )
}

/// How long `work` takes.
fn timed<T>(work: impl FnOnce() -> Result<T, Failure>) -> Result<Duration, Failure> {
    let start = Instant::now();
    work()?;
    Ok(start.elapsed())
}

fn hits_hash(hits: &[Hit]) -> String {
    let mut hasher = Hasher::default();
    let mut bytes = Vec::new();
    for hits in hits.chunks(4096) {
        bytes.clear();
        for hit in hits {
            bytes.extend(hit.id.to_le_bytes());
            bytes.extend(hit.t.to_le_bytes());
        }
        hasher.update(&bytes);
    }
    hasher.finish()
}

/// The file's name without folder and extension.
fn scene_name(path: &Path) -> String {
    path.file_stem()
        .map_or_else(String::new, |s| s.to_string_lossy().into_owned())
}

fn ms(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

/// `times` must be sorted and not empty.
fn median_ms(times: &[Duration]) -> f64 {
    let middle = times.len() / 2;
    if times.len().is_multiple_of(2) {
        (ms(times[middle - 1]) + ms(times[middle])) / 2.0
    } else {
        ms(times[middle])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_of_an_even_number_is_the_mean_of_the_middle_two() {
        let times = [1, 2, 4, 100].map(Duration::from_millis);
        assert_eq!(median_ms(&times), 3.0);
        assert_eq!(median_ms(&times[..3]), 2.0);
        assert_eq!(median_ms(&times[..1]), 1.0);
    }

    #[test]
    fn hits_that_differ_in_one_distance_hash_differently() {
        let mut hits = Hits::default();
        hits.resize(3, 2);
        let before = hits_hash(&hits.pixels);
        hits.pixels[5].t = 1.0;
        assert_ne!(hits_hash(&hits.pixels), before);
    }
}
