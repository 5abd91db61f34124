//! `raybomb bench`: how fast, and whether the result is the same each time.
//!
//! One thread is steadier on a busy machine when the system pins it: `taskset -c 1 raybomb bench --threads 1 ..`.

mod measured;
mod memory;
mod rays;
mod report;
mod scaling;
mod workloads;

use std::path::Path;
use std::time::{Duration, Instant};

use measured::{Measured, median_ms, ms};
use report::{Report, StagesReport};
use scaling::ScalingReport;

use super::args::{BenchArgs, Workload};
use super::console::print;
use super::exit::{Failure, Outcome};
use super::load::{Source, is_stdin, renderer};
use super::values::{ENGINES, name_of};
use crate::bvh::Quality;
use crate::camera::{Camera, Pivot, View};
use crate::frame::{Frame, Hits};
use crate::raw::ticks;
use crate::render::{Engine, Progress, Renderer, Settings};
use crate::scene::Scene;
use crate::timeline::{Timing, camera_at};
use crate::watch::Watch;
use crate::world::World;

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

    fn report(&self, measured: Measured) -> Report {
        let Measured {
            mut times,
            rays,
            extra,
            fill_ms,
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
            fill_ms,
            stages: None,
            scaling: None,
        }
    }
}

fn parse_file(renderer: &Renderer, path: &Path) -> Result<Scene, Failure> {
    let source = Source::read(path)?;
    // Without a bar: this is measured.
    renderer.install(|| source.parse(Watch::NOBODY))
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

/// The file's name without folder and extension.
fn scene_name(path: &Path) -> String {
    path.file_stem()
        .map_or_else(String::new, |s| s.to_string_lossy().into_owned())
}
