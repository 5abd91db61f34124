//! The work done for each 4x4 block as a heat map: a diagnostic of the engine, not of the scene.

use super::{BlockRow, pixel};
use crate::trace::Tile;
use crate::trace::tile::BLOCKS;

/// Tests that are shown white; the scale is logarithmic.
const HOTTEST: f32 = 1024.0;

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

/// Colours one row of blocks.
pub fn row(tile: &Tile, by: usize, rows: &mut BlockRow) {
    for bx in 0..BLOCKS {
        let color = heat(tile.cost[by * BLOCKS + bx]);
        for row in rows.iter_mut() {
            row[4 * bx..4 * bx + 4].fill(color);
        }
    }
}

fn heat(tests: u32) -> u32 {
    let level = libm::log2f(1.0 + tests as f32) / libm::log2f(1.0 + HOTTEST);
    let at = level.min(1.0) * (HEAT.len() - 1) as f32;
    let i = (at as usize).min(HEAT.len() - 2);
    let part = at - i as f32;
    let [r, g, b] = [0, 1, 2].map(|c| HEAT[i][c] + (HEAT[i + 1][c] - HEAT[i][c]) * part);
    pixel(r, g, b)
}

#[cfg(test)]
mod tests {
    use super::heat;

    #[test]
    fn no_work_is_black_and_much_is_white() {
        assert_eq!(heat(0), 0);
        assert_eq!(heat(1_000_000), 0x00ff_ffff);
    }
}
