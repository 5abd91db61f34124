//! The work done for each 4x4 block as a heat map: a diagnostic of the engine, not of the scene.

use super::{BlockRow, pixel};
use crate::trace::Tile;
use crate::trace::tile::BLOCKS;

/// Tests per 4x4 pixels that are shown white, unless told otherwise; the scale is logarithmic.
pub const COST_SCALE: u32 = 1024;

/// Black, blue, cyan, green, yellow, red, white at equal steps.
const HEAT: [[f32; 3]; 7] = [
    [0.0, 0.0, 0.0],
    [32.0, 48.0, 200.0],
    [32.0, 190.0, 220.0],
    [48.0, 200.0, 64.0],
    [240.0, 220.0, 48.0],
    [230.0, 48.0, 32.0],
    [255.0, 255.0, 255.0],
];

/// Colours one row of blocks; `scale` tests are white.
pub fn row(tile: &Tile, by: usize, scale: u32, rows: &mut BlockRow) {
    for bx in 0..BLOCKS {
        let color = heat(tile.cost[by * BLOCKS + bx], scale);
        for row in rows.iter_mut() {
            row[4 * bx..4 * bx + 4].fill(color);
        }
    }
}

fn heat(tests: u32, scale: u32) -> u32 {
    let level = libm::log2f(1.0 + tests as f32) / libm::log2f(1.0 + scale as f32);
    let at = level.min(1.0) * (HEAT.len() - 1) as f32;
    let i = (at as usize).min(HEAT.len() - 2);
    let part = at - i as f32;
    let [r, g, b] = [0, 1, 2].map(|c| HEAT[i][c] + (HEAT[i + 1][c] - HEAT[i][c]) * part);
    pixel(r, g, b)
}

#[cfg(test)]
mod tests {
    use super::{COST_SCALE, heat};

    #[test]
    fn no_work_is_black_and_much_is_white() {
        assert_eq!(heat(0, COST_SCALE), 0);
        assert_eq!(heat(1_000_000, COST_SCALE), 0x00ff_ffff);
    }

    #[test]
    fn the_scale_says_what_is_white() {
        for scale in [1, 64, 1 << 20] {
            assert_eq!(heat(scale, scale), 0x00ff_ffff);
            assert!(heat(scale / 2, scale) < 0x00ff_ffff);
        }
    }
}
