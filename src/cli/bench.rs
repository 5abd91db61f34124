//! `raybomb bench`: how fast, and whether the result is the same each time.
//!
//! One thread is steadier on a busy machine when the system pins it: `taskset -c 1 raybomb bench --threads 1 ..`.

mod rays;

use std::path::Path;
use std::time::{Duration, Instant};

use rayon::prelude::*;
use serde::Serialize;

use super::args::{BenchArgs, Workload};
use super::console::print;
use super::exit::{Failure, Outcome};
use super::load::{Source, is_stdin, renderer};
use super::values::{ENGINES, name_of};
use crate::camera::{Camera, Pivot, View};
use crate::export::{Hasher, picture_hash};
use crate::frame::{Frame, Hit, Hits, MISS};
use crate::render::{Engine, Progress, Renderer, Settings};
use crate::scene::Scene;
use crate::timeline::{Timing, camera_at};
use crate::trace::free::{FreeTracer, Ray};
use crate::trace::light::LightGrid;
use crate::world::World;

/// Rays that a thread takes at once.
const RAYS_AT_ONCE: usize = 8192;

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
    let report = bench.report(measured);
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
}

impl<'a> Bench<'a> {
    fn load(args: &'a BenchArgs, progress: &'a Progress) -> Result<Bench<'a>, Failure> {
        let renderer = renderer(args.machine.threads)?;
        let scene = parse_file(&renderer, &args.scene)?;
        let start = Instant::now();
        let world = renderer.install(|| World::compile(&scene));
        let build_time = start.elapsed();
        Ok(Bench {
            view: still_view(args, &scene, &world),
            args,
            progress,
            renderer,
            scene,
            world,
            build_time,
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
        let mut hits = Hits::default();
        let times = self.repeat(|| {
            let start = Instant::now();
            self.trace(&self.world, &mut hits)?;
            Ok((start.elapsed(), hits_hash(&hits.pixels)))
        })?;
        Ok(Measured::of_hits(times, &hits.pixels))
    }

    /// Rays to the light.
    fn shadow(&self) -> Result<Measured, Failure> {
        let origins = self.of_picture(rays::lit)?;
        let start = Instant::now();
        let grid = self.renderer.install(|| LightGrid::build(&self.world));
        let build_time = start.elapsed();
        let mut hits = vec![false; origins.len()];
        let times = self.repeat(|| {
            let start = Instant::now();
            self.each_chunk(&origins, &mut hits, |tracer, origins, hits| {
                grid.hidden(self.args.machine.kernel, &self.world, tracer, origins, hits);
            });
            Ok((start.elapsed(), hits.clone()))
        })?;
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
        let mut hits = vec![Hit::NONE; rays.len()];
        let times = self.repeat(|| {
            let start = Instant::now();
            self.each_chunk(rays, &mut hits, |tracer, rays, hits| {
                tracer.closest_hits(self.args.machine.kernel, self.world.bvh(), rays, hits);
            });
            Ok((start.elapsed(), hits_hash(&hits)))
        })?;
        Ok(Measured::of_hits(times, &hits))
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

    /// Traces all rays on all threads.
    fn each_chunk<R: Sync, H: Send>(
        &self,
        rays: &[R],
        hits: &mut [H],
        trace: impl Fn(&mut FreeTracer, &[R], &mut [H]) + Sync,
    ) {
        self.renderer.install(|| {
            rays.par_chunks(RAYS_AT_ONCE)
                .zip(hits.par_chunks_mut(RAYS_AT_ONCE))
                .with_max_len(1)
                .for_each_init(FreeTracer::default, |tracer, (rays, hits)| {
                    trace(tracer, rays, hits);
                });
        });
    }

    /// The whole picture.
    fn shaded(&self) -> Result<Measured, Failure> {
        let mut frame = Frame::default();
        let settings = self.settings();
        let times = self.repeat(|| {
            let start = Instant::now();
            self.renderer.picture(
                &self.world,
                &self.view,
                &settings,
                &mut frame,
                self.progress,
            )?;
            Ok((start.elapsed(), picture_hash(&frame)))
        })?;
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
        let mut hits = Hits::default();
        let times = self.repeat(|| {
            let start = Instant::now();
            let world = self.renderer.install(|| World::compile(&self.scene));
            let time = start.elapsed();
            self.trace(&world, &mut hits)?;
            Ok((time, hits_hash(&hits.pixels)))
        })?;
        Ok(Measured {
            times,
            rays: None,
            extra: Extra::default(),
        })
    }

    /// From the file to the scene.
    fn load_again(&self) -> Result<Measured, Failure> {
        let times = self.repeat(|| {
            let start = Instant::now();
            let scene = parse_file(&self.renderer, &self.args.scene)?;
            let time = start.elapsed();
            let same = scene == self.scene;
            Ok((time, same))
        })?;
        Ok(Measured {
            times,
            rays: None,
            extra: Extra::default(),
        })
    }

    fn trace(&self, world: &World, hits: &mut Hits) -> Outcome {
        let machine = &self.args.machine;
        let (engine, kernel) = (machine.engine, machine.kernel);
        self.renderer
            .hits(world, &self.view, engine, kernel, hits, self.progress)?;
        Ok(())
    }

    /// `measure` gives a time and its result; the first time does not count, all results must be equal.
    fn repeat<R: PartialEq>(
        &self,
        mut measure: impl FnMut() -> Result<(Duration, R), Failure>,
    ) -> Result<Vec<Duration>, Failure> {
        let (_, expected) = measure()?;
        let mut times = Vec::new();
        for frame in 0..self.args.frames {
            let (time, result) = measure()?;
            if result != expected {
                return Err(Failure::Differs(format!(
                    "the result of measurement {frame} differs from the first one"
                )));
            }
            times.push(time);
        }
        Ok(times)
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
            rays: rays.as_ref().map(|r| r.rays),
            hits: rays.as_ref().and_then(|r| r.hits),
            hash: rays.map(|r| r.hash),
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

/// One line of `bench --json`: scripts rely on names and order.
#[derive(Debug, Serialize)]
struct Report {
    scene: String,
    workload: &'static str,
    engine: &'static str,
    kernel: &'static str,
    threads: usize,
    width: usize,
    height: usize,
    triangles: usize,
    frames: u32,
    median_ms: f64,
    min_ms: f64,
    /// From the median; `null` where no rays are measured.
    mrays_s: Option<f64>,
    build_ms: f64,
    bytes_per_triangle: f64,
    /// `null` where none are measured.
    rays: Option<usize>,
    /// How many of them hit something; `null` where it is not counted.
    hits: Option<usize>,
    /// SHA-256 of the results.
    hash: Option<String>,
}

impl Report {
    fn words(&self) -> String {
        let rays = self
            .mrays_s
            .map_or_else(String::new, |m| format!(", {m:.1} Mray/s"));
        let counts = match (self.rays, self.hits) {
            (Some(rays), Some(hits)) => format!("\n{rays} rays, {hits} hits"),
            _ => String::new(),
        };
        format!(
            "{}: {} triangles, {}x{}\n\
             {}, engine {}, kernel {}, threads {}: median {:.3} ms, best {:.3} ms of {}{rays}\n\
             build {:.1} ms, {:.1} bytes a triangle{counts}",
            self.scene,
            self.triangles,
            self.width,
            self.height,
            self.workload,
            self.engine,
            self.kernel,
            self.threads,
            self.median_ms,
            self.min_ms,
            self.frames,
            self.build_ms,
            self.bytes_per_triangle
        )
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
