//! What `bench` repeats: one method for each workload.

use std::hint::black_box;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use rayon::prelude::*;

use super::measured::{Extra, Measured, RayCounts, hits_hash, median_ms, timed};
use super::{Bench, Failure, parse_file, quality, rays};
use crate::camera::View;
use crate::export::{Hasher, picture_hash};
use crate::frame::{Frame, Hit, Hits};
use crate::render::RenderStats;
use crate::scene::Scene;
use crate::trace::free::{self, FreeTracer, Ray, RayTree};
use crate::trace::light::LightGrid;
use crate::world::World;

/// Origins that a thread takes at once.
const STARTS_AT_ONCE: usize = 8192;

impl Bench<'_> {
    /// One ray a pixel into numbers and distances.
    pub(super) fn primary(&self) -> Result<Measured, Failure> {
        let frame = |hits: &mut Hits| timed(|| self.trace(&self.world, hits));
        let (times, hits) = self.repeat(Hits::default(), frame, |h| hits_hash(&h.pixels))?;
        Ok(Measured::of_hits(times, &hits.pixels))
    }

    /// Rays to the light.
    pub(super) fn shadow(&self) -> Result<Measured, Failure> {
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
            fill_ms: None,
        })
    }

    /// Mirror rays.
    pub(super) fn bounce(&self) -> Result<Measured, Failure> {
        self.closest(&self.of_picture(rays::mirrored)?)
    }

    /// Rays that have nothing in common.
    pub(super) fn random(&self) -> Result<Measured, Failure> {
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
    pub(super) fn shaded(&self) -> Result<Measured, Failure> {
        let picture = |frame: &mut Frame| timed(|| self.picture(frame));
        let (times, mut frame) = self.repeat(Frame::default(), picture, picture_hash)?;
        let (rays, hash) = (frame.pixels.len(), picture_hash(&frame));
        Ok(Measured {
            times,
            rays: Some(RayCounts {
                rays,
                hits: None,
                hash,
            }),
            extra: Extra::default(),
            fill_ms: Some(self.fill_ms(&mut frame.pixels)),
        })
    }

    /// What a picture would take if all of it were stores: see [`Measured::fill_ms`].
    fn fill_ms(&self, pixels: &mut [u32]) -> f64 {
        let share = pixels.len().div_ceil(self.renderer.threads()).max(1);
        let mut times: Vec<_> = (0..self.args.frames)
            .map(|color| {
                let start = Instant::now();
                self.renderer.install(|| {
                    let shares = pixels.par_chunks_mut(share);
                    shares.for_each(|share| black_box(share).fill(color));
                });
                start.elapsed()
            })
            .collect();
        times.sort();
        median_ms(&times)
    }

    /// From the scene to the world; what is compared is what its rays hit.
    pub(super) fn build(&self) -> Result<Measured, Failure> {
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
    pub(super) fn load_again(&self) -> Result<Measured, Failure> {
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

    pub(super) fn trace(&self, world: &World, hits: &mut Hits) -> Result<RenderStats, Failure> {
        let machine = &self.args.machine;
        let (engine, kernel) = (machine.engine, machine.kernel);
        Ok(self
            .renderer
            .hits(world, &self.view, engine, kernel, hits, self.progress)?)
    }

    pub(super) fn picture(&self, frame: &mut Frame) -> Result<RenderStats, Failure> {
        Ok(self.renderer.picture(
            &self.world,
            &self.view,
            &self.settings(),
            frame,
            self.progress,
        )?)
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
}
