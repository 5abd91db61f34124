//! The only door to the SIMD crate: which widths there are, lane vectors, missing lane operations.
//!
//! A kernel is generic over `S: Lanes`; a value of type `S` is the proof that this CPU has the instructions, so
//! kernels contain no `unsafe` and no lane count. [`dispatch`] turns a [`Kernel`] into such a proof, once a tile.
//! Functions below it are `#[inline(always)]`: one that is not would be compiled without the wide instructions.

#[cfg(test)]
mod tests;
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
mod x86;

pub use fearless_simd::prelude::*;
use fearless_simd::{Fallback, Level};

pub use fearless_simd::{Simd, f32x4, f32x8, f64x4, i32x4, i32x8, mask32x8, u16x8, u32x4, u64x2};

use crate::raw;

/// Runs an expression with the proof for a [`Kernel`]: `dispatch!(kernel, simd => work(simd))`.
///
/// # Panics
/// When this CPU lacks the kernel: choose from [`Kernel::available`].
macro_rules! dispatch {
    ($kernel:expr, $simd:ident => $work:expr) => {{
        use fearless_simd::Simd as _;
        match $crate::simd::Token::of($kernel).expect("a kernel that this CPU has") {
            $crate::simd::Token::Scalar($simd) => $simd.vectorize(
                #[inline(always)]
                || $work,
            ),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            $crate::simd::Token::Sse4($simd) => $simd.vectorize(
                #[inline(always)]
                || $work,
            ),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            $crate::simd::Token::Avx2($simd) => $simd.vectorize(
                #[inline(always)]
                || $work,
            ),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            $crate::simd::Token::Avx512($simd) => $simd.vectorize(
                #[inline(always)]
                || $work,
            ),
        }
    }};
}
pub(crate) use dispatch;

/// The proof that this CPU has the instructions of a [`Kernel`].
#[derive(Clone, Copy, Debug)]
pub enum Token {
    /// [`Kernel::Scalar`]
    Scalar(Fallback),
    /// [`Kernel::Sse4`]
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    Sse4(fearless_simd::Sse4_2),
    /// [`Kernel::Avx2`]
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    Avx2(fearless_simd::Avx2),
    /// [`Kernel::Avx512`]
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    Avx512(fearless_simd::Avx512),
}

impl Token {
    /// The proof, or `None` when this CPU lacks the instructions.
    #[must_use]
    pub fn of(kernel: Kernel) -> Option<Token> {
        let level = Level::new();
        match kernel {
            Kernel::Scalar => match Level::fallback() {
                Level::Fallback(token) => Some(Token::Scalar(token)),
                _ => None,
            },
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Kernel::Sse4 => level.as_sse4_2().map(Token::Sse4),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Kernel::Avx2 => level.as_avx2().map(Token::Avx2),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Kernel::Avx512 => level.as_avx512().map(Token::Avx512),
            #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
            _ => {
                let _ = level;
                None
            }
        }
    }
}

/// An instruction set that the kernels can be told to use. Every one of them computes the same bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kernel {
    /// Plain code, four lanes at a time in arrays.
    Scalar,
    /// 4 lanes: SSE up to 4.2, the project's baseline.
    Sse4,
    /// 8 lanes: AVX2.
    Avx2,
    /// 16 lanes: AVX-512 as of Ice Lake and Zen 4.
    Avx512,
}

impl Kernel {
    /// All, weakest first.
    pub const ALL: [Kernel; 4] = [Kernel::Scalar, Kernel::Sse4, Kernel::Avx2, Kernel::Avx512];

    /// What the command line and the overlay call it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Kernel::Scalar => "scalar",
            Kernel::Sse4 => "sse4",
            Kernel::Avx2 => "avx2",
            Kernel::Avx512 => "avx512",
        }
    }

    /// The strongest one that this CPU has.
    #[must_use]
    pub fn best() -> Kernel {
        *Kernel::available()
            .last()
            .expect("the scalar kernel runs everywhere")
    }

    /// Those that this CPU has, weakest first; never empty.
    #[must_use]
    pub fn available() -> Vec<Kernel> {
        Kernel::ALL
            .into_iter()
            .filter(|&k| Token::of(k).is_some())
            .collect()
    }
}

/// Vertices of a leaf in a tile's frame, four numbers each (u, v, w, 1/w), in the order that suits the width:
/// read and written by [`Lanes`] alone.
#[repr(C, align(64))]
#[derive(Clone, Debug)]
pub struct VertexScratch([[f32; 16]; 16]);

impl VertexScratch {
    /// Zeros.
    pub const NEW: VertexScratch = VertexScratch([[0.0; 16]; 16]);

    /// Vertex by vertex: 4 vertices a row.
    #[inline(always)]
    fn aos(&self, vertex: usize) -> [f32; 4] {
        let row = &self.0[vertex >> 2 & 15];
        let at = (vertex & 3) * 4;
        [row[at], row[at + 1], row[at + 2], row[at + 3]]
    }

    /// Number by number: a row for each 16 vertices, 4 rows apart for each of the four numbers.
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    #[inline(always)]
    fn soa(&self, number: usize, chunk: usize) -> &[f32; 16] {
        &self.0[(number * 4 + chunk) & 15]
    }
}

/// The number of lanes of `S`.
pub const fn lanes<S: Simd>() -> usize {
    <S::f32s as SimdBase<S>>::LEN
}

/// The number of each lane.
pub const LANE_NUMBERS: [u32; 16] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];

/// All lanes, as [`bits`].
pub const fn all_lanes<S: Simd>() -> u32 {
    u32::MAX >> (32 - lanes::<S>())
}

/// The lanes of a mask as bits, lane 0 lowest.
#[inline(always)]
pub fn bits<S: Simd>(mask: S::mask32s) -> u32 {
    mask.to_bitmask() as u32
}

/// The first lanes of `from`, as many as the width has.
#[inline(always)]
pub fn load<S: Simd>(simd: S, from: &[f32], at: usize) -> S::f32s {
    S::f32s::from_slice(simd, &from[at..at + lanes::<S>()])
}

/// Writes all lanes to `to[at..]`.
#[inline(always)]
pub fn store<S: Simd>(lanes_of: S::f32s, to: &mut [f32], at: usize) {
    lanes_of.store_slice(&mut to[at..at + lanes::<S>()]);
}

/// What the SIMD crate has no portable form for.
pub trait Lanes: Simd {
    /// Rows of four numbers, one for each lane, as four vectors: `table[index[lane]][k]` in lane `lane` of vector k.
    ///
    /// For an index beyond the table, its last row.
    ///
    /// # Panics
    /// When the table is empty, or `index` shorter than the lanes.
    fn gather4(self, table: &[[f32; 4]], index: &[u32]) -> [Self::f32s; 4];

    /// Four neighbours for each lane as four vectors: `table[start[lane] + k]` in lane `lane` of vector k.
    /// Starts are taken modulo 256.
    fn runs4(self, table: &[f32; 272], start: Self::u32s) -> [Self::f32s; 4];

    /// Puts the four numbers of as many vertices as there are lanes, from vertex `first` on (a multiple).
    fn put_vertices(self, scratch: &mut VertexScratch, first: usize, numbers: [Self::f32s; 4]);

    /// The four numbers of the vertices `words[lane]` (bytes, 4 a word) for as many lanes as there are, from lane
    /// `first` on. `chunks`: into how many times 16 vertices they reach.
    fn corners(
        self,
        scratch: &VertexScratch,
        words: [u32; 4],
        first: usize,
        chunks: usize,
    ) -> [Self::f32s; 4];

    /// The four numbers of one vertex.
    fn vertex(self, scratch: &VertexScratch, vertex: usize) -> [f32; 4];

    /// Two numbers a pixel, `a` and `b`, for the pixels of two units side by side, each 4 pixels wide: in turn, row by
    /// row, 8 pixels a row.
    #[inline(always)]
    fn put_pairs(self, a: [Self::u32s; 2], b: [Self::u32s; 2], rows: &mut [[u32; 16]]) {
        for unit in 0..2 {
            let halves = [a[unit].zip_low(b[unit]), a[unit].zip_high(b[unit])];
            for (half, words) in halves.into_iter().enumerate() {
                let at = half * lanes::<Self>();
                let column = 8 * unit + at % 8;
                words.store_slice(&mut rows[at / 8][column..column + lanes::<Self>()]);
            }
        }
    }

    /// The pixels of four units side by side, each 4 pixels wide: row by row, 16 pixels a row, which the vectors then
    /// hold one after the other.
    fn in_rows(self, units: [Self::u32s; 4]) -> [Self::u32s; 4];

    /// `table[index[lane]]`, or `missing` where the table ends before.
    #[inline(always)]
    fn look_up(self, table: &[u32], index: &[u32], missing: u32) -> Self::u32s {
        let mut found = [missing; 16];
        for (to, &index) in found[..lanes::<Self>()].iter_mut().zip(index) {
            *to = table.get(index as usize).copied().unwrap_or(missing);
        }
        Self::u32s::from_slice(self, &found[..lanes::<Self>()])
    }

    /// Copies to `to` past the caches, see [`raw::stream`].
    fn stream(self, to: &mut [u32], from: &[u32]);
}

/// Four rows become four columns.
#[inline(always)]
pub fn transpose4<S: Simd>(rows: [f32x4<S>; 4]) -> [f32x4<S>; 4] {
    let [a, b, c, d] = rows;
    let (ac0, ac1) = (a.zip_low(c), a.zip_high(c));
    let (bd0, bd1) = (b.zip_low(d), b.zip_high(d));
    [
        ac0.zip_low(bd0),
        ac0.zip_high(bd0),
        ac1.zip_low(bd1),
        ac1.zip_high(bd1),
    ]
}

/// The number of the last row.
#[inline(always)]
fn last_row(table: &[[f32; 4]]) -> usize {
    assert!(!table.is_empty(), "no rows");
    table.len() - 1
}

/// Byte `i` of 16 bytes in four words.
#[inline(always)]
fn byte(words: [u32; 4], i: usize) -> usize {
    (words[i >> 2 & 3] >> (8 * (i & 3)) & 63) as usize
}

macro_rules! four_lanes {
    ($($token:ty),*) => {$(
        impl Lanes for $token {
            #[inline(always)]
            fn gather4(self, table: &[[f32; 4]], index: &[u32]) -> [Self::f32s; 4] {
                let last = last_row(table);
                macro_rules! row {
                    ($lane:expr) => {
                        f32x4::load_array(self, table[(index[$lane] as usize).min(last)])
                    };
                }
                transpose4([row!(0), row!(1), row!(2), row!(3)])
            }

            #[inline(always)]
            fn runs4(self, table: &[f32; 272], start: Self::u32s) -> [Self::f32s; 4] {
                macro_rules! row {
                    ($lane:expr) => {{
                        let at = start[$lane] as usize & 255;
                        f32x4::from_slice(self, &table[at..at + 4])
                    }};
                }
                transpose4([row!(0), row!(1), row!(2), row!(3)])
            }

            #[inline(always)]
            fn put_vertices(self, scratch: &mut VertexScratch, first: usize, numbers: [Self::f32s; 4]) {
                let row = &mut scratch.0[first >> 2 & 15];
                for (to, from) in row.chunks_exact_mut(4).zip(transpose4(numbers)) {
                    from.store_slice(to);
                }
            }

            #[inline(always)]
            fn corners(self, scratch: &VertexScratch, words: [u32; 4], first: usize, _: usize) -> [Self::f32s; 4] {
                macro_rules! row {
                    ($lane:expr) => {
                        f32x4::load_array(self, scratch.aos(byte(words, first + $lane)))
                    };
                }
                transpose4([row!(0), row!(1), row!(2), row!(3)])
            }

            #[inline(always)]
            fn vertex(self, scratch: &VertexScratch, vertex: usize) -> [f32; 4] {
                scratch.aos(vertex)
            }

            #[inline(always)]
            fn in_rows(self, units: [Self::u32s; 4]) -> [Self::u32s; 4] {
                // A unit is four pixels of one row.
                units
            }

            #[inline(always)]
            fn stream(self, to: &mut [u32], from: &[u32]) {
                raw::stream(to, from, raw::stream_line);
            }
        }
    )*};
}

four_lanes!(Fallback);
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
four_lanes!(fearless_simd::Sse2, fearless_simd::Sse4_2);
#[cfg(target_arch = "aarch64")]
four_lanes!(fearless_simd::Neon);
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
four_lanes!(fearless_simd::WasmSimd128);
