//! The triangles of a large text, read on all threads.
//!
//! A comment ends with its line, so the text can be cut at any line feed and the words of each piece counted
//! on their own. The sums tell which word of which triangle begins each piece, and each is then read by itself
//! (over its end, where a triangle does not care for lines). Anything irregular, from a bad number to a
//! missing triangle, makes the whole attempt void: the sequential reader then finds the exact errors.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::lexer::{Cursor, count_words};
use super::model::Triangle;
use super::parser::{NO_TRIANGLE, WORDS_PER_TRIANGLE, triangle};
use crate::watch::{Cancelled, Watch};

/// When and how to read in parallel. Any plan gives the same result.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plan {
    /// Texts shorter than this are read by one thread.
    pub(super) min_bytes: usize,
    /// About how long a piece is.
    pub(super) piece_bytes: usize,
    /// Whether a pool of one thread reads in pieces, too: slower, but a test.
    pub(super) even_alone: bool,
}

impl Default for Plan {
    /// Pieces small enough to share well, and so large (1 ms) that starting one costs nothing.
    fn default() -> Plan {
        Plan {
            min_bytes: 1 << 18,
            piece_bytes: 1 << 18,
            even_alone: false,
        }
    }
}

impl Plan {
    /// Asks for the pool, and so perhaps starts one, only for a large text.
    fn is_worthwhile(self, bytes: usize) -> bool {
        bytes >= self.min_bytes && (self.even_alone || rayon::current_num_threads() > 1)
    }
}

/// A piece of the text, from a line's start.
struct Piece {
    start: usize,
    /// Words of the triangles in front of it.
    words_before: usize,
}

/// The next `count` triangles and the cursor behind them; `None` when the text is small, when anything is
/// wrong, or when nobody wants them any more.
pub(super) fn triangles<'t>(
    cursor: Cursor<'t>,
    count: u64,
    plan: Plan,
    watch: Watch<'_>,
) -> Option<(Vec<Triangle>, Cursor<'t>)> {
    let text = cursor.text();
    if !plan.is_worthwhile(text.len() - cursor.offset()) {
        return None;
    }
    let ranges = cut_at_lines(cursor, plan.piece_bytes);
    let counts: Vec<usize> = ranges
        .par_iter()
        .map(|r| watch.check().map(|()| count_words(&text[r.clone()])))
        .collect::<Result<_, Cancelled>>()
        .ok()?;
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
    let done = AtomicUsize::new(0);
    let cursors: Vec<Cursor> = jobs
        .into_par_iter()
        .map(|(piece, first, own)| {
            watch.check().ok()?;
            let read = own.len();
            let cursor = read_piece(text, &piece, first, own)?;
            watch.tell(done.fetch_add(read, Ordering::Relaxed) + read, count);
            Some(cursor)
        })
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

#[cfg(test)]
mod tests {
    use std::fmt::Write;

    use super::*;
    use crate::math::Random;
    use crate::scene::parser::parse_with;

    const SEQUENTIAL: Plan = Plan {
        min_bytes: usize::MAX,
        piece_bytes: 1,
        even_alone: false,
    };

    /// A scene of up to 60 triangles, in a layout of its own: any white space, comments here and there.
    fn random_text(rng: &mut Random) -> Vec<u8> {
        const GAPS: [&str; 8] = [" ", " ", " ", "\t ", "\r\n", "\n\n", " # 1 2 3\n", "#é\n  "];
        let count = rng.below(60);
        let mut text = format!("<d 0 0 1 {count}");
        let one_a_line = rng.below(2) == 0;
        let gap = |rng: &mut Random| GAPS[rng.below(if one_a_line { 4 } else { 8 }) as usize];
        for _ in 0..count {
            text += if one_a_line { "\n" } else { gap(rng) };
            for word in 0..WORDS_PER_TRIANGLE {
                let value = rng.below(256);
                let written = match word {
                    0..9 => write!(text, "{}.{value}", rng.below(100)),
                    _ => write!(text, "{value}"),
                };
                written.unwrap();
                text += gap(rng);
            }
        }
        text += ["", "<n", "\n<o 1 <x 0.5\n", "<o 2 <y 1"][rng.below(4) as usize];
        text.into_bytes()
    }

    /// Up to two bytes changed, removed or doubled.
    fn mutate(text: &mut Vec<u8>, rng: &mut Random) {
        const BYTES: &[u8] = b"0 \n#<x,.-9\0\xff";
        for _ in 0..rng.below(3) {
            let at = rng.below(text.len() as u32) as usize;
            match rng.below(3) {
                0 => text[at] = BYTES[rng.below(BYTES.len() as u32) as usize],
                1 => drop(text.remove(at)),
                _ => text.insert(at, text[at]),
            }
        }
    }

    #[test]
    fn parallel_reading_gives_the_same_scene_and_the_same_errors() {
        let (mut good, mut bad) = (0, 0);
        for seed in 0..3000 {
            let mut rng = Random::new(seed);
            let mut text = random_text(&mut rng);
            mutate(&mut text, &mut rng);
            let plan = Plan {
                min_bytes: 0,
                piece_bytes: 1 + rng.below(500) as usize,
                even_alone: true,
            };
            let expected = parse_with(&text, SEQUENTIAL, Watch::NOBODY).expect("nobody cancels");
            *if expected.is_ok() {
                &mut good
            } else {
                &mut bad
            } += 1;
            assert_eq!(
                parse_with(&text, plan, Watch::NOBODY).expect("nobody cancels"),
                expected,
                "seed {seed}, {plan:?}"
            );
        }
        assert!(good > 500 && bad > 500, "one-sided: {good} good, {bad} bad");
    }

    #[test]
    fn good_texts_are_read_in_parallel_without_falling_back() {
        for (piece_bytes, lines) in [(1, 40), (7, 40), (100, 40), (100, 0), (1 << 20, 40)] {
            let mut text = String::from("<d 0 0 1 40 ");
            for i in 0..40 {
                let end = if i < lines { '\n' } else { ' ' };
                write!(text, "{i} 0 0 1 0 0 0 1 0 1 2 3{end}").unwrap();
            }
            let mut cursor = Cursor::new(text.as_bytes());
            cursor.skip_words(5);
            let plan = Plan {
                min_bytes: 0,
                piece_bytes,
                even_alone: true,
            };
            let told = std::sync::Mutex::new(Vec::new());
            let tell = |done, of| told.lock().unwrap().push((done, of));
            let (triangles, end) =
                triangles(cursor, 40, plan, Watch::of(&tell)).expect("nothing is wrong with it");
            assert_eq!(triangles.len(), 40);
            assert_eq!(triangles[39].corners[0].x, 39.0);
            assert_eq!(end.peek(), None);
            assert_eq!(told.into_inner().unwrap().iter().max(), Some(&(40, 40)));
        }
    }

    #[test]
    fn a_claim_beyond_the_words_is_no_capacity() {
        let cursor = Cursor::new(b"0 0 0 1 0 0 0 1 0 1 2 3");
        let plan = Plan {
            min_bytes: 0,
            piece_bytes: 8,
            even_alone: true,
        };
        assert!(triangles(cursor, 2, plan, Watch::NOBODY).is_none());
        assert!(triangles(cursor, u64::MAX, plan, Watch::NOBODY).is_none());
        assert!(triangles(cursor, 1, plan, Watch::NOBODY).is_some());
    }
}
