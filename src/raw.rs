//! The one module with `unsafe` code: what safe Rust has no form for and a measurement pays for.
//!
//! Prefetching, large pages ([`Pages`]), stores past the caches, gathers ([`wide`]), the time stamp counter, pictures
//! whose tiles are written by several threads at once, and hits seen as words. All have a safe face.
#![allow(unsafe_code)]

mod pages;
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
pub mod wide;

use std::marker::PhantomData;
use std::sync::atomic::{AtomicUsize, Ordering};

pub use pages::Pages;

use crate::frame::Hit;

/// Asks for the 64-byte cache line number `line` behind the start of element `index` of `slice`. A hint: any index
/// is allowed.
#[inline(always)]
pub fn prefetch<T>(slice: &[T], index: usize, line: usize) {
    let address = slice
        .as_ptr()
        .wrapping_add(index)
        .cast::<u8>()
        .wrapping_add(64 * line);
    #[cfg(target_arch = "x86_64")]
    // SAFETY: a prefetch reads nothing that the program can see and never faults, whatever the address; SSE, its
    // instruction set, is part of every x86-64.
    unsafe {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        _mm_prefetch::<_MM_HINT_T0>(address.cast());
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = address;
}

/// Bytes of a large page.
const LARGE_PAGE: usize = 2 << 20;

/// Asks for large pages (2 MiB in place of 4 KiB) under memory that is about to be filled: the system then clears
/// and maps it with a fraction of the interruptions, and two million triangles are built in 7 % less time. A hint, for
/// Linux only; small slices are left alone.
pub fn large_pages<T>(memory: &mut [T]) {
    #[cfg(target_os = "linux")]
    {
        use rustix::mm::{Advice, madvise};
        let start = memory.as_mut_ptr().cast::<u8>();
        let head = start.align_offset(LARGE_PAGE);
        let length = size_of_val(memory).saturating_sub(head) / LARGE_PAGE * LARGE_PAGE;
        if length > 0 {
            let first = start.wrapping_add(head).cast();
            // SAFETY: this advice changes no content; `first` and `length` are those of whole large pages inside
            // `memory`, which is borrowed meanwhile.
            let advised = unsafe { madvise(first, length, Advice::LinuxHugepage) };
            // That it may be refused is no fault.
            let _ = advised;
        }
    }
    #[cfg(not(target_os = "linux"))]
    let _ = memory;
}

/// The processor's time stamp counter, where there is one; nanoseconds elsewhere. Only differences mean something.
#[inline(always)]
#[must_use]
pub fn ticks() -> u64 {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: reads a counter that every x86-64 has and that systems leave open to programs.
    unsafe {
        std::arch::x86_64::_rdtsc()
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        static START: std::sync::OnceLock<std::time::Instant> = std::sync::OnceLock::new();
        let start = START.get_or_init(std::time::Instant::now);
        u64::try_from(start.elapsed().as_nanos()).unwrap_or(u64::MAX)
    }
}

/// A line of the caches.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub struct CacheLine(pub [u32; 16]);

/// Copies a line past the caches, on x86-64 (see [`wide`] for fewer and wider stores); a plain copy elsewhere.
#[inline(always)]
pub fn stream_line(to: &mut CacheLine, from: &[u32; 16]) {
    #[cfg(target_arch = "x86_64")]
    for (to, from) in to.0.chunks_exact_mut(4).zip(from.chunks_exact(4)) {
        use std::arch::x86_64::{_mm_loadu_si128, _mm_stream_si128};
        // SAFETY: both chunks hold four words, the 16 bytes that are read and written; `to` is aligned: a line is, to
        // 64 bytes, and chunks follow each other 16 bytes apart. SSE2 is part of every x86-64. The order among such
        // stores is settled by `streamed`.
        unsafe {
            let words = _mm_loadu_si128(from.as_ptr().cast());
            _mm_stream_si128(to.as_mut_ptr().cast(), words);
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    to.0.copy_from_slice(from);
}

/// Copies `from` to `to` past the caches: for planes that are larger than they are and not read again soon. A plain
/// store would first fetch each line that it is about to overwrite. `line`: what copies a line, [`stream_line`] or one of
/// [`wide`].
///
/// # Panics
/// When the lengths differ.
#[inline(always)]
pub fn stream(to: &mut [u32], from: &[u32], line: impl Fn(&mut CacheLine, &[u32; 16])) {
    assert_eq!(to.len(), from.len(), "lengths differ");
    // Whole lines only: half of one costs more past the caches than through them.
    // SAFETY: a line is 16 words without padding; every bit pattern is a value of both.
    let (head, lines, tail) = unsafe { to.align_to_mut::<CacheLine>() };
    let (from_head, from) = from.split_at(head.len());
    let (from_lines, from_tail) = from.as_chunks();
    head.copy_from_slice(from_head);
    for (to, from) in lines.iter_mut().zip(from_lines) {
        line(to, from);
    }
    tail.copy_from_slice(from_tail);
}

/// Puts what this thread wrote by [`stream`] before whatever it writes next: to be called before another thread is
/// told of it.
#[inline(always)]
pub fn streamed() {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: a fence has no conditions; SSE is part of every x86-64.
    unsafe {
        std::arch::x86_64::_mm_sfence();
    }
}

/// The words of hits: the triangle's number, then the bits of `t`, hit by hit.
pub fn hit_words(hits: &mut [Hit]) -> &mut [u32] {
    const { assert!(size_of::<Hit>() == 8 && align_of::<Hit>() == align_of::<u32>()) };
    // SAFETY: a `Hit` is `repr(C)`, a `u32` and an `f32`: 8 bytes without padding, aligned like a `u32`, and every
    // bit pattern is a value of both. The slice covers the same bytes, borrowed for as long.
    unsafe { std::slice::from_raw_parts_mut(hits.as_mut_ptr().cast::<u32>(), 2 * hits.len()) }
}

/// A plane of pixels that is handed out tile by tile, each tile once, to any number of threads.
///
/// Rows of a tile are ordinary slices; a safe form would have to cut the plane into one slice for every row of
/// every tile, which takes longer than filling it.
#[derive(Debug)]
pub struct TiledPlane<'a, T> {
    first: *mut T,
    width: usize,
    height: usize,
    tile: usize,
    next: AtomicUsize,
    plane: PhantomData<&'a mut [T]>,
}

// SAFETY: a shared plane gives access to its pixels only through `next`, which hands every tile to one caller
// alone; tiles do not overlap. So threads never reach the same pixel, and sending a `T` between them is enough.
unsafe impl<T: Send> Sync for TiledPlane<'_, T> {}
// SAFETY: as for the `&mut [T]` that it stands for.
unsafe impl<T: Send> Send for TiledPlane<'_, T> {}

/// One tile of a [`TiledPlane`]: the part of it that lies inside the plane.
#[derive(Debug)]
pub struct PlaneTile<'a, T> {
    first: *mut T,
    stride: usize,
    x: usize,
    y: usize,
    width: usize,
    height: usize,
    plane: PhantomData<&'a mut [T]>,
}

impl<'a, T> TiledPlane<'a, T> {
    /// `plane` has `width * height` pixels, row by row; tiles measure `tile` pixels each way.
    ///
    /// # Panics
    /// When the sizes do not fit together.
    pub fn new(plane: &'a mut [T], width: usize, height: usize, tile: usize) -> TiledPlane<'a, T> {
        assert_eq!(
            width.checked_mul(height),
            Some(plane.len()),
            "plane and size differ"
        );
        assert!(tile > 0, "a tile has a size");
        TiledPlane {
            first: plane.as_mut_ptr(),
            width,
            height,
            tile,
            next: AtomicUsize::new(0),
            plane: PhantomData,
        }
    }

    /// How many tiles there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.width.div_ceil(self.tile) * self.height.div_ceil(self.tile)
    }

    /// The next tile that nobody has taken yet, row by row; `None` when all are taken.
    pub fn next(&self) -> Option<PlaneTile<'a, T>> {
        let index = self.next.fetch_add(1, Ordering::Relaxed);
        // Stops the counter from wrapping round to tiles that are taken: a thread adds at most one too many.
        if index >= self.count() {
            self.next.fetch_sub(1, Ordering::Relaxed);
            return None;
        }
        let columns = self.width.div_ceil(self.tile);
        let (x, y) = (index % columns * self.tile, index / columns * self.tile);
        Some(PlaneTile {
            // SAFETY: index < count, so x < width and y < height: the pixel is inside the plane.
            first: unsafe { self.first.add(y * self.width + x) },
            stride: self.width,
            x,
            y,
            width: self.tile.min(self.width - x),
            height: self.tile.min(self.height - y),
            plane: PhantomData,
        })
    }
}

impl<'a, T> PlaneTile<'a, T> {
    /// A tile in memory of its own, `width * height` pixels row by row, which says that its first pixel is in column
    /// `x` and row `y` of a plane.
    ///
    /// # Panics
    /// When the sizes do not fit together.
    pub fn alone(
        pixels: &'a mut [T],
        x: usize,
        y: usize,
        width: usize,
        height: usize,
    ) -> PlaneTile<'a, T> {
        assert_eq!(
            width.checked_mul(height),
            Some(pixels.len()),
            "tile and size differ"
        );
        PlaneTile {
            first: pixels.as_mut_ptr(),
            stride: width,
            x,
            y,
            width,
            height,
            plane: PhantomData,
        }
    }
}

// The sizes are read-only from outside: `row` relies on them.
impl<T> PlaneTile<'_, T> {
    /// Column of the tile's first pixel in the plane.
    #[must_use]
    pub fn x(&self) -> usize {
        self.x
    }

    /// Row of the tile's first pixel in the plane.
    #[must_use]
    pub fn y(&self) -> usize {
        self.y
    }

    /// Pixels a row, at least 1.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows, at least 1.
    #[must_use]
    pub fn height(&self) -> usize {
        self.height
    }

    /// Row `row` of the tile, `width` pixels.
    ///
    /// # Panics
    /// When there is no such row.
    #[inline(always)]
    pub fn row(&mut self, row: usize) -> &mut [T] {
        assert!(row < self.height, "no such row");
        // SAFETY: `row < height` and `width` keep inside the tile, the tile lies inside the plane, or is all of it, which is
        // borrowed for `'a`; no one else has this tile, and `&mut self` keeps its rows from being lent twice.
        unsafe { std::slice::from_raw_parts_mut(self.first.add(row * self.stride), self.width) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_is_in_exactly_one_tile() {
        for (w, h, size) in [
            (130, 65, 64),
            (64, 64, 64),
            (1, 1, 64),
            (7, 5, 2),
            (0, 3, 4),
        ] {
            let mut plane = vec![0u8; w * h];
            let tiles = TiledPlane::new(&mut plane, w, h, size);
            std::thread::scope(|s| {
                for _ in 0..3 {
                    s.spawn(|| {
                        while let Some(mut tile) = tiles.next() {
                            for y in 0..tile.height {
                                tile.row(y).iter_mut().for_each(|p| *p += 1);
                            }
                        }
                    });
                }
            });
            assert!(tiles.next().is_none());
            assert!(plane.iter().all(|&p| p == 1), "{w}x{h} in tiles of {size}");
        }
    }

    #[test]
    fn a_tile_alone_has_its_rows_and_says_where_it_lies() {
        let mut pixels = [0u8; 6];
        let mut tile = PlaneTile::alone(&mut pixels, 64, 128, 3, 2);
        assert_eq!((tile.x(), tile.y()), (64, 128));
        tile.row(1).copy_from_slice(&[7, 8, 9]);
        assert_eq!(pixels, [0, 0, 0, 7, 8, 9]);
    }

    #[test]
    fn words_of_hits_are_number_and_distance() {
        let mut hits = [Hit { id: 7, t: 1.5 }, Hit::NONE];
        hit_words(&mut hits)[0] = 8;
        let infinity = f32::INFINITY.to_bits();
        assert_eq!(
            hit_words(&mut hits),
            [8, 1.5f32.to_bits(), u32::MAX, infinity]
        );
        assert_eq!(hits[0].id, 8);
    }

    #[test]
    fn memory_in_large_pages_keeps_what_it_holds() {
        let mut words: Vec<u32> = (0..3 << 20).collect();
        large_pages(&mut words);
        assert!(words.iter().copied().eq(0..3 << 20));
        large_pages::<u64>(&mut []);
    }

    #[test]
    fn prefetching_beyond_the_end_is_harmless() {
        prefetch(&[1u8, 2], usize::MAX / 2, 3);
        prefetch::<u64>(&[], 0, 0);
    }
}
