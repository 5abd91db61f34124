//! Embree on the rays of `raybomb bench --workload shadow`: from every point of the picture that is turned to the
//! light, toward it, any hit. The picture, the points and their order are those of our own bench.
//!
//!   EMBREE_LIB=libembree4.so.4 lit-peers SCENE.txt [--threads 1] [--frames 9] [--modes i1,i4,i4+coh,..]
//!       [--quality med,high]
//!
//! One JSON line for each mode (rays a packet, with or without the coherent flag) and quality of the tree. Threads
//! stay where the caller pins the process. Embree is not linked, it is opened when the program starts.

mod embree;

use std::num::NonZero;
use std::path::Path;
use std::sync::Mutex;
use std::time::Instant;

use embree::{Embree, Mode, Rays, Tree};
use raybomb::camera::{Camera, Pivot, View};
use raybomb::frame::Hits;
use raybomb::render::{Engine, Progress, Renderer, each_point};
use raybomb::scene::{self, Scene};
use raybomb::simd::Kernel;
use raybomb::timeline::{Timing, camera_at};
use raybomb::world::World;

/// Rays that a thread takes at once, as in our bench.
const AT_ONCE: usize = 8192;

fn main() {
    if let Err(message) = run(std::env::args().skip(1).collect()) {
        eprintln!("lit-peers: {message}");
        std::process::exit(1);
    }
}

fn run(args: Vec<String>) -> Result<(), String> {
    let option = |name: &str, default: &str| {
        let at = args.iter().position(|arg| arg == name);
        at.and_then(|at| args.get(at + 1))
            .map_or_else(|| default.to_owned(), Clone::clone)
    };
    let number = |name: &str, default: &str| {
        let text = option(name, default);
        text.parse::<NonZero<usize>>()
            .map_err(|_| format!("{name} {text}: expected a number above 0"))
    };
    let path = args
        .first()
        .filter(|arg| !arg.starts_with("--"))
        .ok_or("which scene file?")?;
    let (threads, frames) = (
        number("--threads", "1")?.get(),
        number("--frames", "9")?.get(),
    );
    let library = std::env::var("EMBREE_LIB").map_err(|_| {
        "set EMBREE_LIB to Embree 4's shared library (libembree4.so.4; the Python wheel `embreex` has one)"
    })?;
    let modes = option("--modes", "i1,i4,i8,i16,i4+coh,i8+coh,i16+coh");
    let modes = modes
        .split(',')
        .map(Mode::parse)
        .collect::<Result<Vec<_>, _>>()?;

    let text = std::fs::read(path).map_err(|e| format!("{path}: {e}"))?;
    let scene = scene::parse(&text).map_err(|e| e.render(path, &text, false))?;
    let rays = lit(&scene)?;
    let name = Path::new(path).file_stem().unwrap_or_default();
    let embree = Embree::open(&library, threads)?;
    for quality in option("--quality", "med,high").split(',') {
        let tree = embree.build(&scene, quality)?;
        for &mode in &modes {
            let (mut times, hits) = measure(&tree, mode, &rays, threads, frames);
            times.sort_by(f64::total_cmp);
            let rate = |seconds: f64| rays.count as f64 / seconds / 1e6;
            println!(
                r#"{{"scene":{:?},"peer":"embree","workload":"shadow","mode":"{mode}","quality":"{quality}","threads":{threads},"tris":{},"rays":{},"hits":{hits},"mrays_s":{:.3},"best_mrays_s":{:.3},"build_s":{:.4}}}"#,
                name.to_string_lossy(),
                scene.triangles.len(),
                rays.count,
                rate(times[times.len() / 2]),
                rate(times[0]),
                tree.build_s
            );
        }
    }
    Ok(())
}

/// Seconds of each of `frames` rounds over all rays, after one that does not count; and how many rays hit.
fn measure(
    tree: &Tree,
    mode: Mode,
    rays: &Rays,
    threads: usize,
    frames: usize,
) -> (Vec<f64>, usize) {
    let mut hidden = vec![false; rays.count];
    let mut round = || {
        let start = Instant::now();
        let chunks = Mutex::new(hidden.chunks_mut(AT_ONCE).enumerate());
        let work = || {
            embree::flush_denormals();
            loop {
                let next = chunks.lock().expect("no thread panicked").next();
                let Some((i, hidden)) = next else { break };
                tree.occluded(mode, rays, i * AT_ONCE, hidden);
            }
        };
        std::thread::scope(|scope| {
            for _ in 1..threads {
                scope.spawn(work);
            }
            work();
        });
        start.elapsed().as_secs_f64()
    };
    round();
    let times = (0..frames).map(|_| round()).collect();
    (times, hidden.iter().filter(|&&hidden| hidden).count())
}

/// The rays, in the order of our own bench.
fn lit(scene: &Scene) -> Result<Rays, String> {
    let world = World::compile(scene);
    let view = still_view(scene, &world);
    let mut hits = Hits::default();
    let renderer = Renderer::new(1).map_err(|e| e.to_string())?;
    renderer
        .hits(
            &world,
            &view,
            Engine::Fast,
            Kernel::best(),
            &mut hits,
            &Progress::new(),
        )
        .map_err(|_| "the picture was cancelled")?;
    let to_light = -world.light();
    let mut rays = Rays::new(to_light.as_vec3());
    each_point(scene, &world, &view, &hits, |point| {
        if point.normal.dot(to_light) > 0.0 {
            rays.push(point.origin);
        }
    });
    rays.finish();
    Ok(rays)
}

/// The still picture at 1920x1080.
fn still_view(scene: &Scene, world: &World) -> View {
    let timing = Timing::default();
    let last = timing.last_frame(&scene.operations);
    let pivot = Pivot::default().point(world.bounds());
    let base = Camera::of_scene(scene, world.bounds());
    camera_at(base, &scene.operations, timing, last, pivot).view(1920, 1080, false)
}
