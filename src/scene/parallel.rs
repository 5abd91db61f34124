//! The triangles of a large text, read on all threads.
//!
//! A comment ends with its line, so the text can be cut at any line feed and the words of each piece counted
//! on their own. The sums tell which word of which triangle begins each piece, and each is then read by itself
//! (over its end, where a triangle does not care for lines). Anything irregular, from a bad number to a
//! missing triangle, makes the whole attempt void: the sequential reader then finds the exact errors.

use rayon::prelude::*;

use super::lexer::{Cursor, count_words};
use super::model::Triangle;
use super::parser::{NO_TRIANGLE, WORDS_PER_TRIANGLE, triangle};

/// When and how to read in parallel. Any plan gives the same result.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plan {
    /// Texts shorter than this are read by one thread.
    pub(super) min_bytes: usize,
    /// About how long a piece is.
    pub(super) piece_bytes: usize,
}

impl Default for Plan {
    /// By measurement: small enough to share well, large enough that starting one costs nothing.
    fn default() -> Plan {
        let alone = rayon::current_num_threads() == 1;
        Plan {
            min_bytes: if alone { usize::MAX } else { 1 << 18 },
            piece_bytes: 1 << 18,
        }
    }
}

/// A piece of the text, from a line's start.
struct Piece {
    start: usize,
    /// Words of the triangles in front of it.
    words_before: usize,
}

/// The next `count` triangles and the cursor behind them; `None` when the text is small, or when anything is
/// wrong.
pub(super) fn triangles<'t>(
    cursor: Cursor<'t>,
    count: u64,
    plan: Plan,
) -> Option<(Vec<Triangle>, Cursor<'t>)> {
    let text = cursor.text();
    if text.len() - cursor.offset() < plan.min_bytes {
        return None;
    }
    let ranges = cut_at_lines(cursor, plan.piece_bytes);
    let counts: Vec<usize> = ranges
        .par_iter()
        .map(|r| count_words(&text[r.clone()]))
        .collect();
    let words: usize = counts.iter().sum();
    // From here on the count is more than a claim: so many words are there.
    let count = usize::try_from(count)
        .ok()
        .filter(|c| *c <= words / WORDS_PER_TRIANGLE)?;
    let mut triangles = vec![NO_TRIANGLE; count];
    let mut rest = triangles.as_mut_slice();
    let mut jobs = Vec::with_capacity(ranges.len());
    let mut words_before = 0;
    let mut first = 0;
    for (range, words) in ranges.iter().zip(counts) {
        let piece = Piece {
            start: range.start,
            words_before,
        };
        words_before += words;
        let end = words_before.div_ceil(WORDS_PER_TRIANGLE).min(count);
        let (own, others) = rest.split_at_mut(end - first);
        rest = others;
        if !own.is_empty() {
            jobs.push((piece, first, own));
        }
        first = end;
    }
    let cursors: Vec<Cursor> = jobs
        .into_par_iter()
        .map(|(piece, first, own)| read_piece(text, &piece, first, own))
        .collect::<Option<_>>()?;
    Some((triangles, cursors.last().copied().unwrap_or(cursor)))
}

/// Reads the triangles that begin in `piece`, of which the first is number `first`.
fn read_piece<'t>(
    text: &'t [u8],
    piece: &Piece,
    first: usize,
    triangles: &mut [Triangle],
) -> Option<Cursor<'t>> {
    let mut cursor = Cursor::at(text, piece.start);
    cursor.skip_words(first * WORDS_PER_TRIANGLE - piece.words_before);
    for slot in triangles {
        *slot = triangle(&mut cursor)?;
    }
    Some(cursor)
}

/// The text from the cursor on, in pieces of about `bytes` that end with lines.
fn cut_at_lines(cursor: Cursor, bytes: usize) -> Vec<std::ops::Range<usize>> {
    let text = cursor.text();
    let mut pieces = Vec::new();
    let mut start = cursor.offset();
    while start < text.len() {
        let near = text.len().min(start + bytes);
        let end = text[near..]
            .iter()
            .position(|b| *b == b'\n')
            .map_or(text.len(), |i| near + i + 1);
        pieces.push(start..end);
        start = end;
    }
    pieces
}
