//! What more cores would bring: the measured times of a picture's tiles, handed out to more threads than there are.

use std::time::Duration;

use serde::Serialize;

/// How many threads are simulated.
const THREADS: [usize; 5] = [2, 8, 32, 64, 128];

/// What is expected of more cores of the same speed that share nothing: memory's rate and the clock's fall under load
/// come on top.
#[derive(Debug, Serialize)]
pub struct ScalingReport {
    /// Tiles of a picture.
    pub tiles: usize,
    /// All tiles, one after the other, in ms.
    pub total_ms: f64,
    /// The longest of them, in ms: no number of threads gets below.
    pub longest_ms: f64,
    /// How many times as fast, by threads.
    pub speedups: Vec<(usize, f64)>,
}

impl ScalingReport {
    /// From each tile's time, in the order in which tiles are taken.
    pub fn of(tiles: &[Duration]) -> ScalingReport {
        let ms = |time: Duration| time.as_secs_f64() * 1e3;
        ScalingReport {
            tiles: tiles.len(),
            total_ms: ms(tiles.iter().sum()),
            longest_ms: ms(tiles.iter().max().copied().unwrap_or_default()),
            speedups: THREADS.map(|n| (n, speedup(tiles, n))).to_vec(),
        }
    }

    /// For people.
    pub fn words(&self) -> String {
        let speedups: Vec<String> = self
            .speedups
            .iter()
            .map(|(threads, times)| format!("{threads}: {times:.1}x"))
            .collect();
        format!(
            "\n{} tiles, {:.3} ms in all, the longest {:.3} ms; expected of threads {}",
            self.tiles,
            self.total_ms,
            self.longest_ms,
            speedups.join(", ")
        )
    }
}

/// How many times as fast `threads` threads are, each taking the next tile when it is free. 1 without any time.
fn speedup(tiles: &[Duration], threads: usize) -> f64 {
    let mut ends = vec![Duration::ZERO; threads];
    for tile in tiles {
        if let Some(first) = ends.iter_mut().min() {
            *first += *tile;
        }
    }
    let last = ends.iter().max().copied().unwrap_or_default();
    let total: Duration = tiles.iter().sum();
    if last.is_zero() {
        return 1.0;
    }
    total.as_secs_f64() / last.as_secs_f64()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_tiles_scale_until_there_are_too_few() {
        let tiles = [Duration::from_millis(2); 12];
        for (threads, times) in [(1, 1.0), (4, 4.0), (8, 6.0), (100, 12.0)] {
            assert!((speedup(&tiles, threads) - times).abs() < 1e-9, "{threads}");
        }
        assert_eq!(speedup(&[], 8), 1.0);
    }

    #[test]
    fn the_longest_tile_is_the_limit() {
        let mut tiles = [Duration::from_millis(1); 10];
        tiles[9] = Duration::from_millis(11);
        // The nine small ones first, then the long one on a thread that is free from the start or from 1 ms on.
        let is = |a: f64, b: f64| (a - b).abs() < 1e-9;
        assert!(is(speedup(&tiles, 9), 20.0 / 12.0));
        assert!(is(speedup(&tiles, 10), 20.0 / 11.0));
        let report = ScalingReport::of(&tiles);
        assert!(is(report.longest_ms, 11.0));
        assert!(is(report.total_ms, 20.0));
    }
}
