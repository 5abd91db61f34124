//! Sorting keys by their codes: buckets piece by piece, then two passes of counting within each bucket.
//!
//! Pieces go in parallel, then buckets do; equal codes keep the order of their pieces, so that the threads never
//! decide anything. Every pass stays in the second-level cache.

use rayon::prelude::*;

use super::copies::is_crowded;
use crate::raw::Pages;

/// Bits of a code.
pub(super) const CODE_BITS: u32 = 30;
/// Bits that choose the bucket in the first pass of the sort: as many as there are in a bucket of a flat scene fit
/// the second-level cache.
const BUCKET_BITS: u32 = 11;
/// Bits that the second pass sorts by; the third, by those between.
const LOW_BITS: u32 = 10;
/// Buckets of the first pass.
pub(super) const BUCKETS: usize = 1 << BUCKET_BITS;
/// Below this the library's sort is faster than counting.
const SMALL_BUCKET: usize = 1 << 7;

/// A code above the number of its triangle.
pub(super) type Key = u64;

/// The number of the triangle of `key`.
#[inline(always)]
pub(super) fn number(key: Key) -> u32 {
    key as u32
}

/// The code of `key`.
#[inline(always)]
pub(super) fn code(key: Key) -> u32 {
    (key >> 32) as u32
}

/// The keys of a piece, bucket by bucket.
pub(super) struct Runs<'a> {
    keys: &'a [Key],
    /// Where each bucket starts; one more for the end.
    starts: Vec<u32>,
}

/// The bucket that `key` belongs to.
#[inline(always)]
pub(super) fn bucket(key: Key) -> usize {
    (key >> (32 + CODE_BITS - BUCKET_BITS)) as usize % BUCKETS
}

impl<'a> Runs<'a> {
    /// Puts the keys `unsorted`, `counts` of which each bucket has, into `room`.
    #[inline(always)]
    pub(super) fn new(
        unsorted: &[Key],
        mut counts: [u32; BUCKETS],
        room: &'a mut [Key],
    ) -> Runs<'a> {
        let keys = &mut room[..unsorted.len()];
        starts_of(&mut counts);
        let mut starts = counts.to_vec();
        starts.push(unsorted.len() as u32);
        scatter(unsorted, keys, &mut counts, bucket);
        Runs { keys, starts }
    }

    #[inline(always)]
    fn of(&self, bucket: usize) -> &[Key] {
        &self.keys[self.starts[bucket] as usize..self.starts[bucket + 1] as usize]
    }
}

/// From how many keys each digit has to where its keys start.
#[inline(always)]
fn starts_of(counts: &mut [u32]) {
    let mut start = 0;
    for count in counts {
        (*count, start) = (start, start + *count);
    }
}

/// Copies `from` to `to`, each key to the place that `starts` says for its `digit` (below `N`), equal ones in the
/// order they had. Starts become ends.
#[inline(always)]
fn scatter<const N: usize>(
    from: &[Key],
    to: &mut [Key],
    starts: &mut [u32; N],
    digit: impl Fn(Key) -> usize,
) {
    for &key in from {
        let place = &mut starts[digit(key) % N];
        to[*place as usize] = key;
        *place += 1;
    }
}

/// All keys in order, and whether there are crowded cells.
pub(super) fn merge(runs: &[Runs]) -> (Pages<Key>, bool) {
    let mut keys = Pages::zeros(runs.iter().map(|r| r.keys.len()).sum(), 0);
    let mut rest = &mut keys[..];
    let mut buckets = Vec::new();
    for bucket in 0..BUCKETS {
        let len = runs.iter().map(|r| r.of(bucket).len()).sum();
        let (this, behind) = rest.split_at_mut(len);
        if len > 0 {
            buckets.push((bucket, this));
        }
        rest = behind;
    }
    let crowded = buckets
        .into_par_iter()
        .map_init(Vec::new, |scratch, (bucket, keys)| {
            sort_bucket(runs, bucket, keys, scratch);
            is_crowded(keys)
        })
        .reduce(|| false, |a, b| a | b);
    (keys, crowded)
}

/// Puts the keys of one bucket into `to`, sorted by their other bits. `scratch`: memory to use.
fn sort_bucket(runs: &[Runs], bucket: usize, to: &mut [Key], scratch: &mut Vec<Key>) {
    const LOW: usize = 1 << LOW_BITS;
    const HIGH: usize = 1 << (CODE_BITS - BUCKET_BITS - LOW_BITS);
    let runs = || runs.iter().map(|runs| runs.of(bucket));
    if to.len() < SMALL_BUCKET {
        let mut rest = &mut *to;
        for run in runs() {
            let (this, behind) = rest.split_at_mut(run.len());
            this.copy_from_slice(run);
            rest = behind;
        }
        to.sort_unstable();
        return;
    }
    if scratch.len() < to.len() {
        scratch.resize(to.len(), 0);
    }
    let scratch = &mut scratch[..to.len()];
    let (mut lows, mut highs) = ([0; LOW], [0; HIGH]);
    let low = |key: Key| (key >> 32) as usize % LOW;
    let high = |key: Key| (key >> (32 + LOW_BITS)) as usize % HIGH;
    for &key in runs().flatten() {
        lows[low(key)] += 1;
        highs[high(key)] += 1;
    }
    starts_of(&mut lows);
    starts_of(&mut highs);
    for run in runs() {
        scatter(run, scratch, &mut lows, low);
    }
    scatter(scratch, to, &mut highs, high);
}
