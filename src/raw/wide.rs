//! Instructions of AVX2 and AVX-512 that go by a pointer: wide stores past the caches, and gathers.
//!
//! A function here is safe to call where its instructions are known to be there: in a function with the same
//! `target_feature`, such as a kernel that was given the proof.

#[cfg(target_arch = "x86")]
use std::arch::x86::*;
#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::*;

use super::CacheLine;

/// Copies a line past the caches in two stores. The fewer stores make a line, the more lines can be on their way while
/// the program computes on.
///
/// # Safety
/// The CPU has AVX.
#[target_feature(enable = "avx")]
#[inline]
pub fn stream_line8(to: &mut CacheLine, from: &[u32; 16]) {
    for (to, from) in to.0.chunks_exact_mut(8).zip(from.chunks_exact(8)) {
        // SAFETY: both chunks hold eight words, the 32 bytes that are read and written; `to` is aligned: a line is, to
        // 64 bytes, and chunks follow each other 32 bytes apart. The order among such stores is settled by
        // `streamed`.
        unsafe {
            let words = _mm256_loadu_si256(from.as_ptr().cast());
            _mm256_stream_si256(to.as_mut_ptr().cast(), words);
        }
    }
}

/// Copies a line past the caches in one store.
///
/// # Safety
/// The CPU has AVX-512F.
#[target_feature(enable = "avx512f")]
#[inline]
pub fn stream_line16(to: &mut CacheLine, from: &[u32; 16]) {
    // SAFETY: both are 64 bytes, which are read and written; `to` is aligned to 64 bytes. The order among such stores
    // is settled by `streamed`.
    unsafe {
        let words = _mm512_loadu_si512(from.as_ptr().cast());
        _mm512_stream_si512(to.0.as_mut_ptr().cast(), words);
    }
}

/// `table[index]` for 8 lanes; `missing` where the table has no such number. Of a table with more than 2³¹ numbers those
/// above are not found.
///
/// # Safety
/// The CPU has AVX2.
#[target_feature(enable = "avx2")]
#[inline]
pub fn look_up8(table: &[u32], index: __m256i, missing: __m256i) -> __m256i {
    let count = i32::try_from(table.len()).unwrap_or(i32::MAX);
    // `index < count` without a sign: there is only an instruction for numbers that have one.
    let flip = _mm256_set1_epi32(i32::MIN);
    let inside = _mm256_cmpgt_epi32(
        _mm256_set1_epi32(count ^ i32::MIN),
        _mm256_xor_si256(index, flip),
    );
    // SAFETY: only the lanes in `inside` are read, from the table's start and less than its length on; as whole
    // numbers with a sign, which the instruction takes them for, they are not negative.
    unsafe { _mm256_mask_i32gather_epi32::<4>(missing, table.as_ptr().cast(), index, inside) }
}

/// [`look_up8`] for 16 lanes.
///
/// # Safety
/// The CPU has AVX-512F.
#[target_feature(enable = "avx512f")]
#[inline]
pub fn look_up16(table: &[u32], index: __m512i, missing: __m512i) -> __m512i {
    let count = i32::try_from(table.len()).unwrap_or(i32::MAX);
    let inside = _mm512_cmplt_epu32_mask(index, _mm512_set1_epi32(count));
    // SAFETY: as in `look_up8`.
    unsafe { _mm512_mask_i32gather_epi32::<4>(missing, inside, index, table.as_ptr().cast()) }
}
