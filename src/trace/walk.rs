//! A tile's way down the tree: nearest boxes first, nothing that is hidden, leaves when their lines have arrived.

use super::brute;
use super::coverage::Scratch;
use super::frustum::{Frustum, Spot, Survivors, block_mask};
use super::leaf::{self, Guard, LeafContext, TAME};
use super::probe::{Probe, StageTicks, Stopwatch};
use super::space::{TILE, TileSpace};
use super::tile::{BLOCKS, TABLES, Tile};
use crate::bvh::{Bvh, Child, Node};
use crate::simd::{Kernel, Lanes, SimdBase, SimdMask, dispatch, f32x8, lanes, load};

/// Leaves wait here until their lines have come from memory; more than 4 does not help.
const WAITING: usize = 4;

/// A node or leaf to visit.
#[derive(Clone, Copy, Debug)]
struct Entry {
    /// Nearest distance of its box. Negative, also for zero, where `part` holds a [`Spot`].
    near: f32,
    child: Child,
    /// The 8x8 blocks of the tile that it can cover, or the bytes of a spot.
    part: u64,
}

/// Which pixels an [`Entry`] can cover.
enum Part {
    /// Those of some 8x8 blocks.
    Blocks(u64),
    /// A few.
    Spot(Spot),
}

impl Entry {
    const NONE: Entry = Entry {
        near: 0.0,
        child: Child::NONE,
        part: 0,
    };

    /// An entry for child `i` of `node`, a survivor.
    #[inline(always)]
    fn new<const BY_PIXEL: bool>(node: &Node, survivors: &Survivors<BY_PIXEL>, i: usize) -> Entry {
        let (near, child) = (survivors.near[i], node.children[i]);
        if let Some(Spot([x0, x1, y0, y1])) = survivors.spot(i) {
            return Entry {
                near: -near,
                child,
                part: u64::from(u32::from_le_bytes([x0, x1, y0, y1])),
            };
        }
        Entry {
            near,
            child,
            part: survivors.block_mask(i),
        }
    }

    #[inline(always)]
    fn part(&self) -> Part {
        if self.near.is_sign_negative() {
            Part::Spot(Spot((self.part as u32).to_le_bytes()))
        } else {
            Part::Blocks(self.part)
        }
    }

    /// The 8x8 blocks that it can cover.
    #[inline(always)]
    fn blocks(&self) -> u64 {
        match self.part() {
            Part::Blocks(blocks) => blocks,
            Part::Spot(Spot(ends)) => block_mask(ends.map(|end| u32::from(end) / 8)),
        }
    }
}

/// True when every pixel of a spot holds something nearer than distance `near`.
#[inline(always)]
fn is_hidden(tile: &Tile, Spot(ends): Spot, near: f32) -> bool {
    let [x0, x1, y0, y1] = ends.map(usize::from);
    let z = |x, y| tile.z[TABLES.pixel(x, y)];
    let lowest = (z(x0, y0).min(z(x1, y0))).min(z(x0, y1).min(z(x1, y1)));
    // Both are rounded, and what could tie must not be hidden.
    lowest * near > 1.0001
}

/// How far each 8x8 block of a tile can be seen. Old values are too large, never too small.
#[repr(C, align(64))]
#[derive(Clone, Debug)]
struct Horizon {
    /// By block, row by row; infinite while a pixel is open.
    far: [f32; 64],
    /// Blocks with open pixels.
    open: u64,
    /// Blocks whose value is old.
    dirty: u64,
    /// The largest of all.
    tile_far: f32,
}

impl Horizon {
    /// All open in `blocks`; in the others nothing can be seen.
    fn open_in(blocks: u64) -> Horizon {
        let is_open = |block: usize| blocks >> block & 1 != 0;
        Horizon {
            far: std::array::from_fn(|block| if is_open(block) { f32::INFINITY } else { 0.0 }),
            open: blocks,
            dirty: 0,
            tile_far: f32::INFINITY,
        }
    }

    /// True when something at distance `near` in one of `blocks` could be seen.
    #[inline(always)]
    fn sees<S: Lanes>(&mut self, simd: S, near: f32, blocks: u64, tile: &mut Tile) -> bool {
        // No need to compare where a pixel is known to be open.
        if blocks & self.open & !self.dirty != 0 {
            return true;
        }
        let nears = S::f32s::splat(simd, near);
        let mut visible = 0u64;
        let mut i = 0;
        while i < 64 {
            visible |= load(simd, &self.far, i).simd_ge(nears).to_bitmask() << i;
            i += lanes::<S>();
        }
        visible &= blocks;
        if visible & !self.dirty != 0 {
            return true;
        }
        // Only old values speak for it: renew them until one holds.
        while visible != 0 {
            let block = visible.trailing_zeros() as usize;
            visible &= visible - 1;
            self.renew(simd, block, tile);
            if self.far[block & 63] >= near {
                return true;
            }
        }
        false
    }

    #[inline(always)]
    fn renew<S: Lanes>(&mut self, simd: S, block: usize, tile: &mut Tile) {
        self.dirty &= !(1 << block);
        let lowest = tile.renew_floor(simd, block);
        // A little farther than exact: what could tie must not be hidden.
        let far = 1.0 / lowest * 1.00001;
        self.far[block & 63] = far;
        if far < f32::INFINITY {
            self.open &= !(1 << block);
            if self.open == 0 {
                let mut highest = load(simd, &self.far, 0);
                let mut i = lanes::<S>();
                while i < 64 {
                    highest = highest.max(load(simd, &self.far, i));
                    i += lanes::<S>();
                }
                self.tile_far = highest.reduce_max();
            }
        }
    }
}

/// What one thread needs to trace tiles: the hits of the tile at work and room for the way down.
#[derive(Clone, Debug)]
pub struct Tracer {
    tile: Box<Tile>,
    stack: Vec<Entry>,
    waiting: [Entry; WAITING],
    horizon: Horizon,
    scratch: Box<Scratch>,
    guard: Guard,
    stages: StageTicks,
}

impl Default for Tracer {
    fn default() -> Tracer {
        Tracer {
            tile: Tile::new(),
            stack: vec![Entry::NONE; 256],
            waiting: [Entry::NONE; WAITING],
            horizon: Horizon::open_in(u64::MAX),
            scratch: Box::new(Scratch::NEW),
            guard: Guard::ON,
            stages: StageTicks::default(),
        }
    }
}

impl Tracer {
    /// A tracer that trusts its rounded edge functions and never asks the exact test. Its pictures have holes: it
    /// exists for the test that shows that such holes are noticed.
    #[doc(hidden)]
    #[must_use]
    pub fn without_guard() -> Tracer {
        Tracer {
            guard: Guard::OFF,
            ..Tracer::default()
        }
    }

    /// The hits of the last tile.
    #[must_use]
    pub fn tile(&self) -> &Tile {
        &self.tile
    }

    /// What the tiles traced with [`Timing`](super::probe::Timing) took since the last call.
    pub fn take_stages(&mut self) -> StageTicks {
        std::mem::take(&mut self.stages)
    }

    /// The tile, all misses, to be filled by another engine.
    pub fn cleared_tile(&mut self) -> &mut Tile {
        self.tile.clear();
        // Whatever the caller does to it.
        self.tile.touched = u64::MAX;
        &mut self.tile
    }

    /// Traces one tile; the hits are in [`Tracer::tile`]. `P`: what is measured beside them. Returns false when nothing was
    /// hit.
    ///
    /// # Panics
    /// When this CPU lacks `kernel`.
    pub fn trace<P: Probe>(&mut self, kernel: Kernel, bvh: &Bvh, space: &TileSpace) -> bool {
        self.trace_tile::<P>(kernel, bvh, space, false)
    }

    /// The same, but where one triangle is all there is, [`Tile::whole`] may tell.
    ///
    /// # Panics
    /// When this CPU lacks `kernel`.
    pub fn trace_whole<P: Probe>(&mut self, kernel: Kernel, bvh: &Bvh, space: &TileSpace) -> bool {
        self.trace_tile::<P>(kernel, bvh, space, true)
    }

    #[inline(never)]
    fn trace_tile<P: Probe>(
        &mut self,
        kernel: Kernel,
        bvh: &Bvh,
        space: &TileSpace,
        may_be_whole: bool,
    ) -> bool {
        if !bvh.nodes.is_empty() && !is_tame(bvh, space) {
            brute::trace(&bvh.corners(), &bvh.file_ids, space, self.cleared_tile());
            return true;
        }
        if P::COUNTS {
            self.tile.cost.fill(0);
        }
        if bvh.nodes.is_empty() {
            self.tile.clear();
            return false;
        }
        dispatch!(kernel, simd => {
            // Here, where stores are wide.
            self.tile.clear();
            self.walk::<_, P>(simd, bvh, space);
            if !may_be_whole {
                self.tile.write_out(simd);
            }
        });
        self.tile.touched != 0
    }

    #[inline(always)]
    fn walk<S: Lanes, P: Probe>(&mut self, simd: S, bvh: &Bvh, space: &TileSpace) {
        let Tracer {
            tile,
            stack,
            waiting,
            horizon,
            scratch,
            guard,
            stages,
        } = self;
        let mut watch = Stopwatch::start::<P>();
        let blocks = blocks_in_picture(space);
        *horizon = Horizon::open_in(blocks);
        let frustum = &Frustum::new(space);
        let mut context = LeafContext {
            space,
            file_ids: &bvh.file_ids,
            tile_far: f32::INFINITY,
            guard: *guard,
            overdrawn: false,
        };
        stack[0] = Entry {
            near: 0.0,
            child: Child::node(0),
            part: blocks,
        };
        let mut depth = 1;
        // A ring of leaves that wait.
        let (mut oldest, mut waits) = (0, 0);
        let mut node_came = false;
        (scratch.won, scratch.lost) = (0, 0);
        (scratch.leaves, scratch.missed) = (0, 0);
        let mut by_pixel = false;
        loop {
            let leaf_next = waits == WAITING || (waits > 0 && (node_came || depth == 0));
            let entry = if leaf_next {
                node_came = false;
                let entry = waiting[oldest % WAITING];
                oldest += 1;
                waits -= 1;
                entry
            } else if depth == 0 {
                break;
            } else {
                depth -= 1;
                let entry = stack[depth];
                if entry.child.is_leaf() {
                    waiting[(oldest + waits) % WAITING] = entry;
                    waits += 1;
                    continue;
                }
                entry
            };
            let seen = match entry.part() {
                Part::Blocks(blocks) => horizon.sees(simd, entry.near, blocks, tile),
                Part::Spot(spot) => {
                    tile.write_out(simd);
                    !is_hidden(tile, spot, -entry.near)
                }
            };
            if !seen {
                continue;
            }
            if P::COUNTS {
                count_visit(tile, entry.blocks());
            }
            if leaf_next {
                // Where much turns out to be hidden it pays to know each block as it is now.
                context.overdrawn |= scratch.lost > 64 && scratch.lost > scratch.won;
                if context.overdrawn {
                    let mut old = horizon.dirty & entry.blocks();
                    while old != 0 {
                        horizon.renew(simd, old.trailing_zeros() as usize, tile);
                        old &= old - 1;
                    }
                }
                tile.write_out(simd);
                context.tile_far = horizon.tile_far;
                let leaf = bvh.leaf(entry.child.index());
                stages.traversal += watch.lap::<P>();
                let won = leaf::trace::<S, P>(simd, &context, leaf, scratch, stages, tile);
                watch.lap::<P>();
                horizon.dirty |= won;
                tile.touched |= won;
                continue;
            }
            node_came = true;
            let node = &bvh.nodes[entry.child.index()];
            // Where every fourth leaf lies between the pixels, so do boxes; elsewhere it does not pay to ask.
            by_pixel |= scratch.missed > 16 && scratch.missed > scratch.leaves / 4;
            if depth + 8 > stack.len() {
                stack.resize(2 * stack.len(), Entry::NONE);
            }
            let stack = &mut stack[depth..];
            depth += if by_pixel {
                push_children::<S, true>(simd, bvh, frustum, node, horizon.tile_far, stack)
            } else {
                push_children::<S, false>(simd, bvh, frustum, node, horizon.tile_far, stack)
            };
        }
        stages.traversal += watch.lap::<P>();
    }
}

/// Puts the children of `node` that `frustum` meets up to the distance `far` on a stack with room for 8, the nearest
/// on top; how many there are. `BY_PIXEL`: see [`Frustum::test`].
#[inline(always)]
fn push_children<S: Lanes, const BY_PIXEL: bool>(
    simd: S,
    bvh: &Bvh,
    frustum: &Frustum,
    node: &Node,
    far: f32,
    stack: &mut [Entry],
) -> usize {
    let survivors = frustum.test::<S, BY_PIXEL>(simd, node, far);
    let keys = f32x8::load_array_ref(simd, &survivors.order);
    let mut left = survivors.mask;
    while left != 0 {
        let i = left.trailing_zeros() as usize & 7;
        left &= left - 1;
        bvh.prefetch(node.children[i]);
        // First on top: as deep as there are later ones; of equals, the one with the higher number lies deeper.
        let key = f32x8::splat(simd, survivors.order[i]);
        let later = keys.simd_gt(key).to_bitmask() as u32;
        let not_before = keys.simd_ge(key).to_bitmask() as u32;
        let below = (later | not_before & (u32::MAX << i << 1)) & survivors.mask;
        stack[below.count_ones() as usize] = Entry::new::<BY_PIXEL>(node, &survivors, i);
    }
    survivors.mask.count_ones() as usize
}

/// The 8x8 blocks of a tile that have a pixel in the picture, as bits, row by row.
fn blocks_in_picture(space: &TileSpace) -> u64 {
    let [column, row] = space.last.map(|last| u32::from(last) / 8);
    block_mask([0, column, 0, row])
}

/// Whether the kernels' error bounds hold for every vertex of the scene (they do, but for absurd cameras).
fn is_tame(bvh: &Bvh, space: &TileSpace) -> bool {
    let reach = bvh
        .bounds
        .min
        .as_dvec3()
        .abs()
        .max(bvh.bounds.max.as_dvec3().abs());
    let [u, v, w] = space
        .rows
        .map(|r| r.as_dvec3().abs().dot(space.eye.as_dvec3().abs() + reach));
    u + v + w * (TILE as f64 / 2.0) <= TAME
}

/// Counts a visit for every 4x4 block of some 8x8 blocks.
fn count_visit(tile: &mut Tile, blocks: u64) {
    for block in (0..64).filter(|b| blocks >> b & 1 != 0) {
        let (x, y) = (block % 8 * 2, block / 8 * 2);
        for at in [y * BLOCKS + x, (y + 1) * BLOCKS + x] {
            tile.cost[at] += 1;
            tile.cost[at + 1] += 1;
        }
    }
}
