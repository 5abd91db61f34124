//! Which triangle each pixel's ray hits, and how far away: one tile of 64x64 pixels at a time.
//! Beside them, rays that do not come from the camera: [`free`] ones and those toward the [`light`].
//!
//! What counts as a hit is exact arithmetic in the tile's own frame ([`space`], [`exact`]); how near it is, a fixed
//! sequence of `f32` operations ([`depth`]). So every engine, width and thread count gives the same bits, and the
//! kernels are free in how they find out.

pub mod brute;
mod coverage;
pub mod depth;
mod doubt;
pub mod exact;
pub mod free;
mod frustum;
mod leaf;
pub mod light;
pub mod probe;
mod raster;
pub mod space;
pub mod tile;
mod vec3s;
mod walk;

pub use probe::StageTicks;
pub use space::{Rig, TILE, TileSpace};
pub use tile::Tile;
pub use walk::Tracer;
