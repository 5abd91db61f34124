//! From the hits of a tile to its pixels.
//!
//! Every view has the same definition at every width, tile and thread: a pixel's colour depends on its hit, its
//! integer coordinates and the picture's rays alone. The view `cost` is the exception: it shows the work done.

mod cost_view;
mod depth_view;
mod id_view;
mod normal_view;
mod reflection;

use glam::DVec3;

use crate::camera::View;
use crate::color::Rgb;
use crate::math::power_of_two_below;
use crate::raw::PlaneTile;
use crate::simd::{Kernel, Lanes, lanes};
use crate::trace::tile::{BLOCKS, block_offset};
use crate::trace::{TILE, Tile};
use crate::world::World;
pub use cost_view::COST_SCALE;

/// What a picture shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ViewMode {
    /// The reflection method.
    #[default]
    Shaded,
    /// A colour for each triangle's number.
    Id,
    /// The side turned to the eye.
    Normal,
    /// Near is bright.
    Depth,
    /// Tests per 4x4 pixels; may differ between kernels.
    Cost,
}

/// Which formula the `Shaded` view uses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Reflection {
    /// The mirror image that the report's figure shows.
    #[default]
    Mirror,
    /// The formula that the report prints.
    AsPrinted,
}

/// The directions of a picture's rays in `f32`, brought near length 1 by a power of two: no view depends on their
/// length, and squares stay in range.
#[derive(Clone, Copy, Debug)]
pub struct Rays {
    /// Of pixel (0, 0).
    base: [f32; 3],
    /// Change a pixel to the right.
    dx: [f32; 3],
    /// Change a pixel down.
    dy: [f32; 3],
    /// Length of a direction in space over its length here.
    scale: f32,
}

impl Rays {
    /// The rays of `view`.
    #[must_use]
    pub fn new(view: &View) -> Rays {
        let size = view.base.abs().max_element();
        let scale = if size > 0.0 && size.is_finite() {
            power_of_two_below(size)
        } else {
            1.0
        };
        let round = |v: DVec3| (v / scale).as_vec3().to_array();
        Rays {
            base: round(view.base),
            dx: round(view.dx),
            dy: round(view.dy),
            scale: scale as f32,
        }
    }

    /// The direction of a pixel: the same operations in the same order as the kernels.
    #[inline(always)]
    fn at(&self, x: usize, y: usize) -> [f32; 3] {
        let (x, y) = (x as f32, y as f32);
        [0, 1, 2].map(|k| (self.base[k] + y * self.dy[k]) + x * self.dx[k])
    }
}

/// Sum of products, left to right.
#[inline(always)]
fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]
}

/// A number of 0..=255 to the nearest whole one, ties to even; outside it, the nearest end.
#[inline(always)]
fn channel(value: f32) -> u32 {
    value.round_ties_even().clamp(0.0, 255.0) as u32
}

/// A grey or coloured pixel from three numbers of 0..=255.
#[inline(always)]
fn pixel(r: f32, g: f32, b: f32) -> u32 {
    channel(r) << 16 | channel(g) << 8 | channel(b)
}

/// Four rows of a tile's pixels: what one row of 4x4 blocks becomes.
type BlockRow = [[u32; TILE]; 4];

/// Everything that shading a tile depends on.
#[derive(Clone, Copy, Debug)]
pub struct Shader<'a> {
    /// The scene.
    pub world: &'a World,
    /// The picture's rays.
    pub rays: Rays,
    /// What to show.
    pub mode: ViewMode,
    /// For [`ViewMode::Shaded`].
    pub reflection: Reflection,
    /// For [`ViewMode::Cost`]: so many tests are white.
    pub cost_scale: u32,
    /// `t` of a hit is 1/z times this.
    pub t_per_w: f32,
    /// Nearest and farthest distance that the view `depth` tells apart.
    pub depth_range: (f32, f32),
    /// The instructions to use.
    pub kernel: Kernel,
}

impl<'a> Shader<'a> {
    /// A shader of one picture.
    #[must_use]
    pub fn new(
        world: &'a World,
        view: &View,
        kernel: Kernel,
        mode: ViewMode,
        reflection: Reflection,
        cost_scale: u32,
        t_per_w: f32,
    ) -> Shader<'a> {
        Shader {
            world,
            rays: Rays::new(view),
            mode,
            reflection,
            cost_scale,
            t_per_w,
            depth_range: depth_view::range(world, view),
            kernel,
        }
    }

    /// Whether [`Shader::shade`] also colours a tile by its [`Tile::whole`].
    #[must_use]
    pub fn knows_whole(&self) -> bool {
        (self.mode, self.reflection) == (ViewMode::Shaded, Reflection::Mirror)
    }

    /// Colours one tile.
    pub fn shade(&self, tile: &Tile, out: &mut PlaneTile<'_, u32>) {
        if self.knows_whole() {
            return reflection::mirror(self, tile, out);
        }
        let mut rows: BlockRow = [[0; TILE]; 4];
        for by in 0..out.height().div_ceil(4) {
            let place = BlockRowPlace {
                x: out.x(),
                y: out.y() + 4 * by,
                by,
            };
            match self.mode {
                ViewMode::Shaded => {
                    let normals = self.world.normals();
                    each_hit(tile, place, &mut rows, |x, y, id, _| {
                        reflection::as_printed(self, normals, x, y, id)
                    });
                }
                ViewMode::Id => {
                    let ids = &self.world.bvh().file_ids;
                    each_hit(tile, place, &mut rows, |_, _, id, _| {
                        id_view::color(ids[id as usize])
                    });
                }
                ViewMode::Normal => {
                    let normals = self.world.normals();
                    each_hit(tile, place, &mut rows, |x, y, id, _| {
                        normal_view::color(normals[id as usize], self.rays.at(x, y))
                    });
                }
                ViewMode::Depth => {
                    each_hit(tile, place, &mut rows, |x, y, _, z| {
                        depth_view::color(self, x, y, z)
                    });
                }
                ViewMode::Cost => cost_view::row(tile, by, self.cost_scale, &mut rows),
            }
            for (y, row) in rows.iter().enumerate().take(out.height() - 4 * by) {
                let width = out.width();
                out.row(4 * by + y).copy_from_slice(&row[..width]);
            }
        }
    }
}

/// Colours a tile without hits, through the caches: see [`write_row`].
pub fn background(out: &mut PlaneTile<'_, u32>) {
    for y in 0..out.height() {
        out.row(y).fill(Rgb::BLACK.packed());
    }
}

/// Writes a row of pixels that were computed. Narrow stores to a line that is not in the caches wait for it, so they
/// go past these; wide ones, of 16 lanes or of the copy of a whole row, do not, and leave the picture where the next
/// one to read it is quick.
#[inline(always)]
fn write_row<S: Lanes>(simd: S, to: &mut [u32], row: &[u32]) {
    if lanes::<S>() < 16 {
        simd.stream(to, row);
    } else if let (Some(to), Some(row)) = (to.first_chunk_mut::<TILE>(), row.first_chunk()) {
        *to = *row;
    } else {
        to.copy_from_slice(row);
    }
}

/// Where a row of 4x4 blocks lies.
#[derive(Clone, Copy, Debug)]
struct BlockRowPlace {
    /// Column of its first pixel in the picture.
    x: usize,
    /// Row of it.
    y: usize,
    /// Number of the row of blocks in the tile.
    by: usize,
}

/// Colours every pixel with a hit by `color` (x, y, triangle in leaf order, 1/w), the others black.
#[inline(always)]
fn each_hit(
    tile: &Tile,
    place: BlockRowPlace,
    rows: &mut BlockRow,
    color: impl Fn(usize, usize, u32, f32) -> u32,
) {
    for bx in 0..BLOCKS {
        let at = block_offset(bx, place.by);
        for lane in 0..16 {
            let z = tile.z[at + lane];
            let (x, y) = (4 * bx + lane % 4, lane / 4);
            rows[y][x] = if z > 0.0 {
                color(place.x + x, place.y + y, tile.id[at + lane], z)
            } else {
                0
            };
        }
    }
}
