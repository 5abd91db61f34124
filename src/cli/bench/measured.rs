//! What a workload took, and what came out of it.

use std::time::{Duration, Instant};

use super::Failure;
use crate::export::Hasher;
use crate::frame::{Hit, MISS};

/// What a workload took, and what came out.
pub struct Measured {
    /// One for each frame.
    pub times: Vec<Duration>,
    /// `None` where none are measured.
    pub rays: Option<RayCounts>,
    /// What was built before the rays.
    pub extra: Extra,
    /// Milliseconds that `slice::fill` takes for the same framebuffer on as many threads, the median of as many.
    pub fill_ms: Option<f64>,
}

/// What a workload builds beside the world.
#[derive(Default)]
pub struct Extra {
    /// How long that took.
    pub build_time: Duration,
    /// Its size in memory.
    pub bytes: usize,
}

/// Rays and what they hit.
pub struct RayCounts {
    /// How many.
    pub rays: usize,
    /// How many hit something, where it is counted.
    pub hits: Option<usize>,
    /// Of all results: the same for every kernel and number of threads.
    pub hash: String,
}

impl Measured {
    /// Of a workload that is no tracing.
    pub fn without_rays(times: Vec<Duration>) -> Measured {
        Measured {
            times,
            rays: None,
            extra: Extra::default(),
            fill_ms: None,
        }
    }

    /// Of the hits of the last frame.
    pub fn of_hits(times: Vec<Duration>, hits: &[Hit]) -> Measured {
        Measured {
            times,
            rays: Some(RayCounts {
                rays: hits.len(),
                hits: Some(hits.iter().filter(|hit| hit.id != MISS).count()),
                hash: hits_hash(hits),
            }),
            extra: Extra::default(),
            fill_ms: None,
        }
    }
}

/// How long `work` takes.
pub fn timed<T>(work: impl FnOnce() -> Result<T, Failure>) -> Result<Duration, Failure> {
    let start = Instant::now();
    work()?;
    Ok(start.elapsed())
}

/// SHA-256 of numbers and distances.
pub fn hits_hash(hits: &[Hit]) -> String {
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

/// Milliseconds.
pub fn ms(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

/// The median of `times`, in milliseconds; they must be sorted, and not empty.
pub fn median_ms(times: &[Duration]) -> f64 {
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
    use crate::frame::Hits;

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
