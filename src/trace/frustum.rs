//! Which children of a node a tile's rays can meet, and which part of the tile each of them can cover.
//!
//! This only culls: it may keep too much, never too little. Fused multiply-adds are allowed here for that reason.

use super::space::{HALF, TILE, TileSpace};
use crate::bvh::Node;
use crate::simd::{Lanes, Select, SimdBase, SimdFloat, SimdMask, f32x8};

/// Pixels that a box reaches beyond the exact outline of what it holds: far more than the rounding of a vertex.
const MARGIN_PX: f32 = 1.0 / 16.0;

/// Boxes are visited in the order of the distance at this part of the way from their near to their far end. What a
/// large box holds lies seldom at its nearest corner: a small one behind that corner comes first.
const DEPTH_OF_ORDER: f32 = 0.25;

/// The part of space that a tile's rays pass through, ready for tests of boxes.
#[derive(Clone, Copy, Debug)]
pub struct Frustum {
    /// The transform to u, v, w.
    rows: [[f32; 3]; 3],
    /// For each row and axis, which row of [`Node::bounds`] makes it smallest.
    low: [[usize; 3]; 3],
    /// See [`TileSpace::offset`].
    offset: [f32; 3],
    /// See [`TileSpace::slack`].
    slack: [f32; 3],
    /// x′ and y′ up to which a box may lie: those of the last column and row in the picture, and a margin.
    reach: [f32; 2],
    /// The last column and row of pixels.
    last: [f32; 2],
}

/// The children that survive.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug)]
pub struct Survivors<const BY_PIXEL: bool> {
    /// Nearest distance of each child's box, at least 0.
    pub near: [f32; 8],
    /// A distance within each box, toward its near end: the lowest is to be visited first.
    pub order: [f32; 8],
    /// Its part of the tile: first and last column, first and last row. In blocks of 8x8 pixels, or in pixels where
    /// [`Frustum::test`] looked for these.
    ends: [[i32; 8]; 4],
    /// Which children survive, child 0 lowest.
    pub mask: u32,
}

/// A part of a tile of at most two columns and two rows of pixels: first and last column, first and last row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Spot(pub [u8; 4]);

impl Frustum {
    /// The frustum of a tile.
    #[must_use]
    pub fn new(space: &TileSpace) -> Frustum {
        let rows = space.rows.map(|r| r.to_array());
        let low = rows.map(|r| [0, 1, 2].map(|axis| if r[axis] >= 0.0 { axis } else { axis + 3 }));
        Frustum {
            rows,
            low,
            offset: space.offset.to_array(),
            slack: space.slack.to_array(),
            reach: space.last.map(|last| f32::from(last) - HALF + MARGIN_PX),
            last: space.last.map(f32::from),
        }
    }

    /// The children of `node` whose box meets the frustum, in front of the eye and not beyond `far`. `BY_PIXEL`: not
    /// those either that lie between the centres of pixels.
    #[inline(always)]
    pub fn test<S: Lanes, const BY_PIXEL: bool>(
        &self,
        simd: S,
        node: &Node,
        far: f32,
    ) -> Survivors<BY_PIXEL> {
        macro_rules! splat {
            ($x:expr) => {
                f32x8::splat(simd, $x)
            };
        }
        // Each row's smallest and largest value over each box.
        let mut low = [splat!(0.0); 3];
        let mut high = low;
        for k in 0..3 {
            let mut l = splat!(self.offset[k] - self.slack[k]);
            let mut h = splat!(self.offset[k] + self.slack[k]);
            for axis in 0..3 {
                let r = splat!(self.rows[k][axis]);
                let at = self.low[k][axis];
                let opposite = if at >= 3 { at - 3 } else { at + 3 };
                l = r.mul_add(f32x8::load_array_ref(simd, &node.bounds[at % 6]), l);
                h = r.mul_add(f32x8::load_array_ref(simd, &node.bounds[opposite % 6]), h);
            }
            low[k] = l;
            high[k] = h;
        }
        let (near, w_max) = (low[2], high[2]);
        let zero = splat!(0.0);
        let left_or_top = zero - w_max * splat!(HALF + MARGIN_PX);
        // The most that x′·w and y′·w can be over the box: where x′ or y′ is negative, at its near end.
        let [right, bottom] = self.reach;
        let right = if right < 0.0 { near } else { w_max } * splat!(right);
        let bottom = if bottom < 0.0 { near } else { w_max } * splat!(bottom);
        let clamped_near = near.max(zero);
        let inside = low[0].simd_le(right)
            & high[0].simd_ge(left_or_top)
            & low[1].simd_le(bottom)
            & high[1].simd_ge(left_or_top)
            & w_max.simd_gt(zero)
            & clamped_near.simd_le(splat!(far));
        let mut out = Survivors {
            near: [0.0; 8],
            order: [0.0; 8],
            ends: [[0; 8]; 4],
            mask: inside.to_bitmask() as u32,
        };
        clamped_near.store_array(&mut out.near);
        // Of numbers that are not negative: even infinite ones give an order.
        let order = clamped_near * splat!(1.0 - DEPTH_OF_ORDER) + w_max * splat!(DEPTH_OF_ORDER);
        order.store_array(&mut out.order);
        if out.mask == 0 {
            return out;
        }
        // Interval division: the screen rectangle of each box, then its columns and rows of 8x8 blocks.
        let one = splat!(1.0);
        let far_inverse = one / w_max;
        let near_inverse = near.simd_gt(splat!(1e-30)).select(one / near, splat!(1e30));
        let eighth = splat!(0.125);
        for k in 0..2 {
            let l = (low[k] * near_inverse).min(low[k] * far_inverse);
            let h = (high[k] * near_inverse).max(high[k] * far_inverse);
            let l = l + splat!(TILE as f32 / 2.0 - MARGIN_PX);
            let h = h + splat!(TILE as f32 / 2.0 + MARGIN_PX);
            let (first, past, last) = if BY_PIXEL {
                // Pixels' centres lie at halves.
                let half = splat!(0.5);
                let (first, past) = ((l - half).ceil(), (h - half).floor());
                out.mask &= first.simd_le(past).to_bitmask() as u32;
                (first, past, splat!(self.last[k]))
            } else {
                (l * eighth, h * eighth, splat!(self.last[k] * 0.125))
            };
            let first: crate::simd::i32x8<S> = first.max(zero).min(last).to_int();
            let past: crate::simd::i32x8<S> = past.max(zero).min(last).to_int();
            first.store_array(&mut out.ends[2 * k]);
            past.store_array(&mut out.ends[2 * k + 1]);
        }
        out
    }
}

impl<const BY_PIXEL: bool> Survivors<BY_PIXEL> {
    /// The 8x8 blocks that child `child` can cover, as bits, row by row.
    #[inline(always)]
    pub fn block_mask(&self, child: usize) -> u64 {
        let shift = if BY_PIXEL { 3 } else { 0 };
        block_mask(self.ends.map(|row| row[child & 7] as u32 >> shift))
    }

    /// The pixels that child `child` can cover, if they are known and few.
    #[inline(always)]
    pub fn spot(&self, child: usize) -> Option<Spot> {
        let [x0, x1, y0, y1] = self.ends.map(|row| row[child & 7]);
        let small = BY_PIXEL && x1 - x0 < 2 && y1 - y0 < 2;
        small.then_some(Spot([x0 as u8, x1 as u8, y0 as u8, y1 as u8]))
    }
}

/// The 8x8 blocks from first to last column and first to last row (each 0 to 7), as bits, row by row.
#[inline(always)]
pub fn block_mask(ends: [u32; 4]) -> u64 {
    let [x0, x1, y0, y1] = ends.map(|end| end & 7);
    let columns = ((2u64 << x1) - 1) & !((1u64 << x0) - 1);
    let rows = (u64::MAX >> (56 - 8 * y1)) & !((1u64 << (8 * y0)) - 1);
    columns.wrapping_mul(0x0101_0101_0101_0101) & rows
}
