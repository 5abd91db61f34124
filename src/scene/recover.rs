//! A triangle that cannot be read: what is wrong with it, and where to go on.
//!
//! One number too few or too many shifts all that follow, and every later triangle would look wrong. Most
//! files give each triangle a line of its own, so lines tell the cases apart: a line with twelve words keeps its
//! errors to itself; otherwise only the first word that betrays the shift is an error, and reading goes on
//! with a later line or with the tail.

use std::ops::Range;

use super::advice::hint;
use super::error::{Channel, Expected, Found, Point};
use super::lexer::{Cursor, count_words};
use super::number::{Decimal, Whole, whole};
use super::parser::{Halt, Parser, WORDS_PER_TRIANGLE, fewer, is_tail};
use super::snippet::line_bytes;
use crate::math::Axis;

/// Help about a line's number of words is given up to this many words too few or too many.
const NEARLY: usize = 3;

impl Parser<'_> {
    /// Notes the errors of the next triangle, number `triangle` of `claimed`. True when the cursor stands where
    /// the next one should begin, false when it stands at the tail.
    pub(super) fn bad_triangle(&mut self, triangle: u64, claimed: u64) -> Result<bool, Halt> {
        let start = self.cursor;
        let line = Line::around(&start);
        let own_line = line.is_one_triangle();
        let mut given = None;
        for word_index in 0..WORDS_PER_TRIANGLE {
            let expected = expected(triangle, word_index);
            let Some(word) = self.cursor.peek() else {
                let kind = fewer(expected, claimed, Found::End);
                let span = self.end_span();
                self.note(span, kind, line.help())?;
                return Err(Halt);
            };
            let bytes = self.bytes(&word);
            if is_tail(bytes) {
                let kind = fewer(expected, claimed, Found::word(bytes));
                self.note(word, kind, line.help())?;
                return Ok(false);
            }
            self.cursor.skip_words(1);
            let verdict = Verdict::on(bytes, expected);
            if verdict == Verdict::Good {
                continue;
            }
            let shifted = verdict == Verdict::Shifted && !own_line;
            if !shifted {
                // The same advice once a triangle: commas tend to stand behind all of its numbers.
                let advice = hint(bytes, expected);
                if advice.is_none() || advice != given {
                    self.unexpected_with_help(word, expected, advice.clone())?;
                    given = advice;
                }
                continue;
            }
            self.unexpected_with_help(word, expected, line.help())?;
            let goes_on = line.next_triangle();
            match goes_on {
                Some(cursor) => self.cursor = cursor,
                None => self.skip_to_tail(),
            }
            return Ok(goes_on.is_some());
        }
        Ok(true)
    }
}

/// What to think of a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Verdict {
    /// It may stand here.
    Good,
    /// It may stand nowhere among the triangles.
    Broken,
    /// It may stand at another place: perhaps it does.
    Shifted,
}

impl Verdict {
    fn on(word: &[u8], expected: Expected) -> Verdict {
        let number = Decimal::scan(word).filter(|d| d.len() == word.len());
        let finite = number.is_some_and(|d| d.to_f32().is_finite());
        match expected {
            _ if !finite => Verdict::Broken,
            Expected::Color { .. } => match whole(word) {
                Some(Whole::Value(0..=255)) => Verdict::Good,
                _ => Verdict::Shifted,
            },
            _ => Verdict::Good,
        }
    }
}

/// The line of text on which a triangle's first word stands.
struct Line<'t> {
    text: &'t [u8],
    range: Range<usize>,
    /// Words in front of the triangle's first.
    words_before: usize,
    words: usize,
}

impl<'t> Line<'t> {
    /// The line of the next word.
    fn around(cursor: &Cursor<'t>) -> Line<'t> {
        let text = cursor.text();
        let at = cursor.peek().map_or(text.len(), |w| w.start);
        let range = line_bytes(text, at);
        let words_before = count_words(&text[range.start..at]);
        Line {
            text,
            words: words_before + count_words(&text[at..range.end]),
            words_before,
            range,
        }
    }

    /// True when it holds the twelve words of the triangle and no others.
    fn is_one_triangle(&self) -> bool {
        self.words_before == 0 && self.words == WORDS_PER_TRIANGLE
    }

    /// The start of the next line, when this one was to hold one triangle and the next one does.
    fn next_triangle(&self) -> Option<Cursor<'t>> {
        let next = Cursor::at(self.text, self.range.end);
        let nearly = self.words_before == 0 && self.words.abs_diff(WORDS_PER_TRIANGLE) <= NEARLY;
        (nearly && Line::around(&next).is_one_triangle()).then_some(next)
    }

    /// What may have led to an error, when the line holds nearly the right number of words.
    fn help(&self) -> Option<String> {
        let off = self.words.abs_diff(WORDS_PER_TRIANGLE);
        (1..=NEARLY).contains(&off).then(|| {
            format!(
                "the triangle begins in a line of {} words; a triangle has 12",
                self.words
            )
        })
    }
}

/// What the word number `index` of a triangle must be.
fn expected(triangle: u64, index: usize) -> Expected {
    const AXES: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];
    const CHANNELS: [Channel; 3] = [Channel::Red, Channel::Green, Channel::Blue];
    match index {
        0..9 => {
            let corner = index / 3;
            Expected::Coordinate(AXES[index % 3], Point::Corner { corner, triangle })
        }
        _ => Expected::Color {
            channel: CHANNELS[index % 3],
            triangle,
        },
    }
}
