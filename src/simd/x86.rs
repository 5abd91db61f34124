//! The lane operations of AVX2 and AVX-512.

#[cfg(target_arch = "x86")]
use std::arch::x86::*;
#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::*;

use fearless_simd::{Avx2, Avx512, f32x16, kernel, u8x16, u32x8, u32x16};

use super::*;
use crate::raw::{CacheLine, wide};

/// What a macro makes of each lane, without a closure: that may not be inlined.
macro_rules! each {
    ($row:ident: $($lane:literal)+) => {
        [$($row!($lane)),+]
    };
}

kernel!(
    /// Rows of 8 lanes as four columns.
    #[inline(always)]
    fn transpose8(token: Avx2, rows: [f32x4<Avx2>; 8]) -> [f32x8<Avx2>; 4] {
        macro_rules! pair {
            ($i:expr) => {
                _mm256_set_m128(rows[$i + 4].into(), rows[$i].into())
            };
        }
        let (a, b, c, d) = (pair!(0), pair!(1), pair!(2), pair!(3));
        let (ab0, ab1) = (_mm256_unpacklo_ps(a, b), _mm256_unpackhi_ps(a, b));
        let (cd0, cd1) = (_mm256_unpacklo_ps(c, d), _mm256_unpackhi_ps(c, d));
        [
            _mm256_shuffle_ps::<0x44>(ab0, cd0).simd_into(token),
            _mm256_shuffle_ps::<0xee>(ab0, cd0).simd_into(token),
            _mm256_shuffle_ps::<0x44>(ab1, cd1).simd_into(token),
            _mm256_shuffle_ps::<0xee>(ab1, cd1).simd_into(token),
        ]
    }
);

kernel!(
    /// Four columns of 8 lanes as 8 rows, two a vector.
    #[inline(always)]
    fn rows8(token: Avx2, columns: [f32x8<Avx2>; 4]) -> [f32x8<Avx2>; 4] {
        let [a, b, c, d] = columns.map(|v| -> __m256 { v.into() });
        let (ab0, ab1) = (_mm256_unpacklo_ps(a, b), _mm256_unpackhi_ps(a, b));
        let (cd0, cd1) = (_mm256_unpacklo_ps(c, d), _mm256_unpackhi_ps(c, d));
        let (r0, r1) = (
            _mm256_shuffle_ps::<0x44>(ab0, cd0),
            _mm256_shuffle_ps::<0xee>(ab0, cd0),
        );
        let (r2, r3) = (
            _mm256_shuffle_ps::<0x44>(ab1, cd1),
            _mm256_shuffle_ps::<0xee>(ab1, cd1),
        );
        [
            _mm256_permute2f128_ps::<0x20>(r0, r1).simd_into(token),
            _mm256_permute2f128_ps::<0x20>(r2, r3).simd_into(token),
            _mm256_permute2f128_ps::<0x31>(r0, r1).simd_into(token),
            _mm256_permute2f128_ps::<0x31>(r2, r3).simd_into(token),
        ]
    }
);

kernel!(
    /// Four units of two rows by 4 pixels as two rows of 16.
    #[inline(always)]
    fn in_rows8(token: Avx2, units: [u32x8<Avx2>; 4]) -> [u32x8<Avx2>; 4] {
        let [a, b, c, d] = units.map(|v| -> __m256i { v.into() });
        [
            _mm256_permute2x128_si256::<0x20>(a, b).simd_into(token),
            _mm256_permute2x128_si256::<0x20>(c, d).simd_into(token),
            _mm256_permute2x128_si256::<0x31>(a, b).simd_into(token),
            _mm256_permute2x128_si256::<0x31>(c, d).simd_into(token),
        ]
    }
);

impl Lanes for Avx2 {
    #[inline(always)]
    fn in_rows(self, units: [Self::u32s; 4]) -> [Self::u32s; 4] {
        in_rows8(self, units)
    }

    #[inline(always)]
    fn gather4(self, table: &[[f32; 4]], index: &[u32]) -> [Self::f32s; 4] {
        let (last, index) = (last_row(table), &index[..8]);
        macro_rules! row {
            ($lane:expr) => {
                f32x4::load_array(self, table[(index[$lane] as usize).min(last)])
            };
        }
        transpose8(self, each!(row: 0 1 2 3 4 5 6 7))
    }

    #[inline(always)]
    fn runs4(self, table: &[f32; 272], start: Self::u32s) -> [Self::f32s; 4] {
        macro_rules! row {
            ($lane:expr) => {{
                let at = start[$lane] as usize & 255;
                f32x4::from_slice(self, &table[at..at + 4])
            }};
        }
        transpose8(self, each!(row: 0 1 2 3 4 5 6 7))
    }

    #[inline(always)]
    fn put_vertices(self, scratch: &mut VertexScratch, first: usize, numbers: [Self::f32s; 4]) {
        let [a, b, c, d] = rows8(self, numbers);
        let at = first >> 2 & 14;
        a.store_slice(&mut scratch.0[at][..8]);
        b.store_slice(&mut scratch.0[at][8..]);
        c.store_slice(&mut scratch.0[at + 1][..8]);
        d.store_slice(&mut scratch.0[at + 1][8..]);
    }

    #[inline(always)]
    fn corners(
        self,
        scratch: &VertexScratch,
        words: [u32; 4],
        first: usize,
        _: usize,
    ) -> [Self::f32s; 4] {
        macro_rules! row {
            ($lane:expr) => {
                f32x4::load_array(self, scratch.aos(byte(words, first + $lane)))
            };
        }
        transpose8(self, each!(row: 0 1 2 3 4 5 6 7))
    }

    #[inline(always)]
    fn vertex(self, scratch: &VertexScratch, vertex: usize) -> [f32; 4] {
        scratch.aos(vertex)
    }

    #[inline(always)]
    fn look_up(self, table: &[u32], index: &[u32], missing: u32) -> Self::u32s {
        let index = u32x8::from_slice(self, index);
        look_up8(self, table, index, u32x8::splat(self, missing))
    }

    #[inline(always)]
    fn stream(self, to: &mut [u32], from: &[u32]) {
        raw::stream(to, from, |to, from| stream_line8(self, to, from));
    }
}

kernel!(
    /// `table[index]`, or `missing`.
    #[inline(always)]
    fn look_up8(
        token: Avx2,
        table: &[u32],
        index: u32x8<Avx2>,
        missing: u32x8<Avx2>,
    ) -> u32x8<Avx2> {
        wide::look_up8(table, index.into(), missing.into()).simd_into(token)
    }
);

kernel!(
    /// A line past the caches.
    #[inline(always)]
    fn stream_line8(_token: Avx2, to: &mut CacheLine, from: &[u32; 16]) {
        wide::stream_line8(to, from);
    }
);

kernel!(
    /// A line past the caches.
    #[inline(always)]
    fn stream_line16(_token: Avx512, to: &mut CacheLine, from: &[u32; 16]) {
        wide::stream_line16(to, from);
    }
);

kernel!(
    /// `table[index]`, or `missing`.
    #[inline(always)]
    fn look_up16(
        token: Avx512,
        table: &[u32],
        index: u32x16<Avx512>,
        missing: u32x16<Avx512>,
    ) -> u32x16<Avx512> {
        wide::look_up16(table, index.into(), missing.into()).simd_into(token)
    }
);

kernel!(
    /// The lower halves of two vectors, and the upper ones.
    #[inline(always)]
    fn halves(token: Avx512, a: u32x16<Avx512>, b: u32x16<Avx512>) -> [u32x16<Avx512>; 2] {
        let (a, b) = (a.into(), b.into());
        [
            _mm512_shuffle_i64x2::<0x44>(a, b).simd_into(token),
            _mm512_shuffle_i64x2::<0xee>(a, b).simd_into(token),
        ]
    }
);

kernel!(
    /// Four rows side by side. One by one: an array of all 16 rows would go through memory, and come back as
    /// wider loads than the stores were, which have to wait for them.
    #[inline(always)]
    fn side_by_side(
        token: Avx512,
        a: f32x4<Avx512>,
        b: f32x4<Avx512>,
        c: f32x4<Avx512>,
        d: f32x4<Avx512>,
    ) -> f32x16<Avx512> {
        let low = _mm256_set_m128(b.into(), a.into());
        let high = _mm256_set_m128(d.into(), c.into());
        _mm512_insertf32x8::<1>(_mm512_castps256_ps512(low), high).simd_into(token)
    }
);

/// What a macro makes of 16 lanes, four rows as one vector: see [`transpose16`].
macro_rules! fours {
    ($token:expr, $row:ident) => {
        [
            side_by_side($token, $row!(0), $row!(4), $row!(8), $row!(12)),
            side_by_side($token, $row!(1), $row!(5), $row!(9), $row!(13)),
            side_by_side($token, $row!(2), $row!(6), $row!(10), $row!(14)),
            side_by_side($token, $row!(3), $row!(7), $row!(11), $row!(15)),
        ]
    };
}

kernel!(
    /// Rows of 16 lanes as four columns. Vector k has rows k, k + 4, k + 8 and k + 12.
    #[inline(always)]
    fn transpose16(token: Avx512, fours: [f32x16<Avx512>; 4]) -> [f32x16<Avx512>; 4] {
        let [a, b, c, d] = fours.map(|v| -> __m512 { v.into() });
        let (ab0, ab1) = (_mm512_unpacklo_ps(a, b), _mm512_unpackhi_ps(a, b));
        let (cd0, cd1) = (_mm512_unpacklo_ps(c, d), _mm512_unpackhi_ps(c, d));
        [
            _mm512_shuffle_ps::<0x44>(ab0, cd0).simd_into(token),
            _mm512_shuffle_ps::<0xee>(ab0, cd0).simd_into(token),
            _mm512_shuffle_ps::<0x44>(ab1, cd1).simd_into(token),
            _mm512_shuffle_ps::<0xee>(ab1, cd1).simd_into(token),
        ]
    }
);

kernel!(
    /// `table[index]` for 16 lanes out of 16 numbers.
    #[inline(always)]
    fn permute16(token: Avx512, table: f32x16<Avx512>, index: u8x16<Avx512>) -> f32x16<Avx512> {
        _mm512_permutexvar_ps(_mm512_cvtepu8_epi32(index.into()), table.into()).simd_into(token)
    }
);

kernel!(
    /// `table[index]` for 16 lanes out of 48 numbers.
    #[inline(always)]
    fn permute48(
        token: Avx512,
        table: [f32x16<Avx512>; 3],
        index: u8x16<Avx512>,
    ) -> f32x16<Avx512> {
        let index = _mm512_cvtepu8_epi32(index.into());
        let low = _mm512_permutex2var_ps(table[0].into(), index, table[1].into());
        let third = _mm512_cmpge_epi32_mask(index, _mm512_set1_epi32(32));
        _mm512_mask_permutexvar_ps(low, third, index, table[2].into()).simd_into(token)
    }
);

kernel!(
    /// Four units of 4x4 pixels as four rows of 16.
    #[inline(always)]
    fn in_rows16(token: Avx512, units: [u32x16<Avx512>; 4]) -> [u32x16<Avx512>; 4] {
        let [a, b, c, d] = units.map(|v| -> __m512i { v.into() });
        let (ab01, ab23) = (
            _mm512_shuffle_i32x4::<0x44>(a, b),
            _mm512_shuffle_i32x4::<0xee>(a, b),
        );
        let (cd01, cd23) = (
            _mm512_shuffle_i32x4::<0x44>(c, d),
            _mm512_shuffle_i32x4::<0xee>(c, d),
        );
        [
            _mm512_shuffle_i32x4::<0x88>(ab01, cd01).simd_into(token),
            _mm512_shuffle_i32x4::<0xdd>(ab01, cd01).simd_into(token),
            _mm512_shuffle_i32x4::<0x88>(ab23, cd23).simd_into(token),
            _mm512_shuffle_i32x4::<0xdd>(ab23, cd23).simd_into(token),
        ]
    }
);

impl Lanes for Avx512 {
    #[inline(always)]
    fn in_rows(self, units: [Self::u32s; 4]) -> [Self::u32s; 4] {
        in_rows16(self, units)
    }

    #[inline(always)]
    fn gather4(self, table: &[[f32; 4]], index: &[u32]) -> [Self::f32s; 4] {
        let (last, index) = (last_row(table), &index[..16]);
        macro_rules! row {
            ($lane:expr) => {
                f32x4::load_array(self, table[(index[$lane] as usize).min(last)])
            };
        }
        transpose16(self, fours!(self, row))
    }

    #[inline(always)]
    fn runs4(self, table: &[f32; 272], start: Self::u32s) -> [Self::f32s; 4] {
        macro_rules! row {
            ($lane:expr) => {{
                let at = start[$lane] as usize & 255;
                f32x4::from_slice(self, &table[at..at + 4])
            }};
        }
        transpose16(self, fours!(self, row))
    }

    #[inline(always)]
    fn put_vertices(self, scratch: &mut VertexScratch, first: usize, numbers: [Self::f32s; 4]) {
        for (i, v) in numbers.into_iter().enumerate() {
            v.store_slice(&mut scratch.0[(i * 4 + (first >> 4)) & 15]);
        }
    }

    #[inline(always)]
    fn corners(
        self,
        scratch: &VertexScratch,
        words: [u32; 4],
        _: usize,
        chunks: usize,
    ) -> [Self::f32s; 4] {
        let index: u8x16<Avx512> = fearless_simd::u32x4::load_array(self, words).bitcast();
        macro_rules! row {
            ($number:expr, $chunk:expr) => {
                f32x16::load_array_ref(self, scratch.soa($number, $chunk))
            };
        }
        if chunks == 1 {
            macro_rules! column {
                ($number:expr) => {
                    permute16(self, row!($number, 0), index)
                };
            }
            [column!(0), column!(1), column!(2), column!(3)]
        } else {
            macro_rules! column {
                ($number:expr) => {
                    permute48(
                        self,
                        [row!($number, 0), row!($number, 1), row!($number, 2)],
                        index,
                    )
                };
            }
            [column!(0), column!(1), column!(2), column!(3)]
        }
    }

    #[inline(always)]
    fn vertex(self, scratch: &VertexScratch, vertex: usize) -> [f32; 4] {
        [0, 1, 2, 3].map(|number| scratch.soa(number, vertex >> 4)[vertex & 15])
    }

    #[inline(always)]
    fn put_pairs(self, a: [Self::u32s; 2], b: [Self::u32s; 2], rows: &mut [[u32; 16]]) {
        let [row0, row1] = halves(self, a[0].zip_low(b[0]), a[1].zip_low(b[1]));
        let [row2, row3] = halves(self, a[0].zip_high(b[0]), a[1].zip_high(b[1]));
        row0.store_slice(&mut rows[0]);
        row1.store_slice(&mut rows[1]);
        row2.store_slice(&mut rows[2]);
        row3.store_slice(&mut rows[3]);
    }

    #[inline(always)]
    fn look_up(self, table: &[u32], index: &[u32], missing: u32) -> Self::u32s {
        let index = u32x16::from_slice(self, index);
        look_up16(self, table, index, u32x16::splat(self, missing))
    }

    #[inline(always)]
    fn stream(self, to: &mut [u32], from: &[u32]) {
        raw::stream(to, from, |to, from| stream_line16(self, to, from));
    }
}
