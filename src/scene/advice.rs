//! Guesses at what led to an error, for the help under its message.

use std::ops::Range;

use super::error::Expected;
use super::lexer::count_words;
use super::number::Decimal;
use super::parser::WORDS_PER_TRIANGLE;
use super::snippet::line_bytes;

/// Advice for mistakes that are easily made.
pub(super) fn hint(word: &[u8], expected: Expected) -> Option<String> {
    let number = matches!(
        expected,
        Expected::Coordinate(..) | Expected::Angle(_) | Expected::Color { .. }
    );
    let text = String::from_utf8_lossy(&word[..word.len().min(100)]);
    let advice = if number && text.contains(',') {
        "decimals take a point, and white space stands between numbers"
    } else if text.chars().any(|c| c.is_whitespace() && !c.is_ascii()) {
        "only blanks, tabs and line ends count as white space"
    } else if matches!(word, [b'<', letter, _, ..] if letter.is_ascii_alphabetic()) {
        "white space must follow the letter"
    } else {
        return None;
    };
    Some(String::from(advice))
}

/// What may have led to a number after the last triangle.
pub(super) fn tail_help(text: &[u8], word: &Range<usize>, triangles: u64) -> Option<String> {
    Decimal::scan(&text[word.clone()])?;
    if triangles == 0 {
        return Some(String::from(
            "the 0 before it was read as the number of triangles",
        ));
    }
    let line = line_bytes(text, word.start);
    let words_before = count_words(&text[line.start..word.start]);
    let shifted = !words_before.is_multiple_of(WORDS_PER_TRIANGLE);
    shifted.then(|| {
        String::from(
            "the last triangle ends within this line: an earlier one may have a number too many",
        )
    })
}
