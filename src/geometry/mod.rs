//! The triangle is the only primitive: what is degenerate, what a box is.

mod aabb;
mod triangle;

pub use aabb::Aabb;
pub use triangle::{corner_lanes, edge_cross, have_area_for_sure, is_degenerate, unit_normal};
