//! Words: what stands between white space and comments.
//!
//! White space is what C's `isspace` calls so (the original read its file with C): blank, tab, LF, CR,
//! vertical tab, form feed. A comment runs from `#`, also in the middle of a word, to the next LF, and may
//! hold any bytes. All words of a good file are ASCII; whether a word is UTF-8 matters only for the message
//! about a bad one. A line ends at LF, and a CR before it is white space.

use std::ops::Range;

use super::number::Decimal;

/// The UTF-8 byte-order mark, skipped at the start of a text.
pub(super) const BOM: &[u8] = b"\xef\xbb\xbf";

/// A place in the text from which words are read.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cursor<'t> {
    text: &'t [u8],
    at: usize,
}

#[inline]
pub(super) const fn is_blank(byte: u8) -> bool {
    byte == b' ' || byte.wrapping_sub(b'\t') < 5
}

#[inline]
const fn ends_word(byte: u8) -> bool {
    is_blank(byte) || byte == b'#'
}

impl<'t> Cursor<'t> {
    /// At the start of `text`, behind a byte-order mark.
    pub(super) fn new(text: &'t [u8]) -> Cursor<'t> {
        let at = if text.starts_with(BOM) { BOM.len() } else { 0 };
        Cursor { text, at }
    }

    /// At byte `at` of `text`, which must not lie in a comment.
    pub(super) fn at(text: &'t [u8], at: usize) -> Cursor<'t> {
        Cursor { text, at }
    }

    /// The whole text.
    pub(super) fn text(&self) -> &'t [u8] {
        self.text
    }

    /// Bytes from the start of the text to here.
    pub(super) fn offset(&self) -> usize {
        self.at
    }

    /// Moves over white space and comments.
    #[inline]
    fn skip_blank(&mut self) {
        while let Some(&byte) = self.text.get(self.at) {
            if is_blank(byte) {
                self.at += 1;
            } else if byte == b'#' {
                let rest = &self.text[self.at..];
                self.at += rest.iter().position(|b| *b == b'\n').unwrap_or(rest.len());
            } else {
                break;
            }
        }
    }

    /// The next word, as a range of bytes of the text; `None` at its end.
    #[inline]
    pub(super) fn word(&mut self) -> Option<Range<usize>> {
        self.skip_blank();
        let rest = &self.text[self.at..];
        if rest.is_empty() {
            return None;
        }
        let len = rest
            .iter()
            .position(|b| ends_word(*b))
            .unwrap_or(rest.len());
        let word = self.at..self.at + len;
        self.at = word.end;
        Some(word)
    }

    /// The next word without moving over it.
    pub(super) fn peek(&self) -> Option<Range<usize>> {
        self.clone().word()
    }

    /// Moves over the next `count` words, or to the end of the text.
    pub(super) fn skip_words(&mut self, count: usize) {
        for _ in 0..count {
            if self.word().is_none() {
                break;
            }
        }
    }

    /// Moves over the next word when it is a number, and gives it. After `None` the cursor stands at the word.
    #[inline]
    pub(super) fn decimal(&mut self) -> Option<Decimal<'t>> {
        self.skip_blank();
        let rest = &self.text[self.at..];
        let decimal = Decimal::scan(rest)?;
        if rest.get(decimal.len()).is_some_and(|b| !ends_word(*b)) {
            return None;
        }
        self.at += decimal.len();
        Some(decimal)
    }

    /// The next word as the nearest `f32`. `None` when it is no number or beyond the range of `f32`: then the
    /// cursor may stand anywhere.
    #[inline]
    pub(super) fn f32(&mut self) -> Option<f32> {
        let value = self.decimal()?.to_f32();
        value.is_finite().then_some(value)
    }

    /// The next word as the nearest `f64`; otherwise like [`Cursor::f32`].
    pub(super) fn f64(&mut self) -> Option<f64> {
        let value = self.decimal()?.to_f64();
        value.is_finite().then_some(value)
    }

    /// The next word as 0..=255, digits only. `None` otherwise: then the cursor may stand anywhere.
    #[inline]
    pub(super) fn u8(&mut self) -> Option<u8> {
        self.skip_blank();
        let rest = &self.text[self.at..];
        let mut value = 0u8;
        let mut len = 0;
        for &byte in rest {
            let digit = byte.wrapping_sub(b'0');
            if digit >= 10 {
                break;
            }
            value = value.checked_mul(10)?.checked_add(digit)?;
            len += 1;
        }
        if len == 0 || rest.get(len).is_some_and(|b| !ends_word(*b)) {
            return None;
        }
        self.at += len;
        Some(value)
    }
}

/// How many words `text` holds, which must not begin in a comment or in a word that began before. O(n), at
/// memory speed when there is no comment.
pub(super) fn count_words(text: &[u8]) -> usize {
    if text.contains(&b'#') {
        let mut cursor = Cursor::at(text, 0);
        return std::iter::from_fn(|| cursor.word()).count();
    }
    let Some(&first) = text.first() else {
        return 0;
    };
    // A word begins where a blank is followed by something else. Sums of up to 255 fit a byte, which keeps
    // the loop in byte lanes.
    let begins: usize = text[..text.len() - 1]
        .chunks(255)
        .zip(text[1..].chunks(255))
        .map(|(before, here)| {
            let sum: u8 = before
                .iter()
                .zip(here)
                .map(|(b, h)| u8::from(is_blank(*b) & !is_blank(*h)))
                .sum();
            usize::from(sum)
        })
        .sum();
    begins + usize::from(!is_blank(first))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Random;

    fn words(text: &str) -> Vec<&str> {
        let mut cursor = Cursor::new(text.as_bytes());
        std::iter::from_fn(|| cursor.word())
            .map(|w| &text[w])
            .collect()
    }

    #[test]
    fn words_stand_between_white_space_and_comments() {
        assert_eq!(
            words("\u{feff}<d\t1\r\n2#x 3\n\x0b4 # end"),
            ["<d", "1", "2", "4"]
        );
        assert_eq!(words(" # only\n"), [""; 0]);
    }

    #[test]
    fn a_number_must_fill_its_word() {
        let read = |text: &'static str| Cursor::new(text.as_bytes()).f32();
        assert_eq!(read(" 1.5#c"), Some(1.5));
        assert_eq!(read("-0").map(f32::to_bits), Some((-0.0f32).to_bits()));
        for bad in ["1.5x", "1,5", "", "<", "1e39", "nan"] {
            assert_eq!(read(bad), None, "{bad}");
        }
    }

    #[test]
    fn a_colour_is_digits_up_to_255() {
        let read = |text: &'static str| Cursor::new(text.as_bytes()).u8();
        assert_eq!(read(" 255 "), Some(255));
        assert_eq!(read("0007"), Some(7));
        for bad in [
            "256",
            "-1",
            "1.5",
            "+1",
            "",
            "1x",
            "99999999999999999999999",
        ] {
            assert_eq!(read(bad), None, "{bad}");
        }
    }

    #[test]
    fn counting_words_agrees_with_reading_them() {
        for seed in 0..2000 {
            let mut rng = Random::new(seed);
            let alphabet = if seed % 2 == 0 {
                &b"ab \n\t\r"[..]
            } else {
                &b"ab \n#"[..]
            };
            let text: Vec<u8> = (0..rng.below(1000))
                .map(|_| alphabet[rng.below(alphabet.len() as u32) as usize])
                .collect();
            let mut cursor = Cursor::at(&text, 0);
            let read = std::iter::from_fn(|| cursor.word()).count();
            assert_eq!(count_words(&text), read, "seed {seed}");
        }
    }
}
