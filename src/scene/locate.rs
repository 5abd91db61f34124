//! Lines and columns, of errors and of triangles.

use std::ops::Range;

use super::error::Expected;
use super::lexer::BOM;
use super::parallel::Plan;
use super::parser::{Parser, WORDS_PER_TRIANGLE};

/// A place in a scene file's text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Location {
    /// From 1; lines end at LF.
    pub line: usize,
    /// From 1, in characters; a byte that is not UTF-8 counts as one, a byte-order mark as none.
    pub column: usize,
    /// The bytes meant, counted from the start of the text (byte-order mark included). Empty at the end of
    /// the file. May reach over several lines; pictures of it stop at the end of the first.
    pub span: Range<usize>,
}

impl Location {
    /// The place of the bytes `span` of `text`. O(bytes before it).
    #[must_use]
    pub fn of(text: &[u8], span: Range<usize>) -> Location {
        Locator::new(text).locate(span)
    }
}

/// Where the triangles with the given ids stand in a text that [`super::parse`] accepts: from the first to the last of
/// their twelve words. `ids` must ascend; reading stops at the first that is not there. One pass over the
/// text.
#[must_use]
pub fn locate_triangles(text: &[u8], ids: impl IntoIterator<Item = usize>) -> Vec<Location> {
    let mut parser = Parser::new(text, Plan::default());
    let header = (|| {
        parser.camera()?;
        parser.light()?;
        parser.count(Expected::TriangleCount)
    })();
    let count = header.ok().flatten().unwrap_or(0);
    let mut cursor = parser.cursor;
    let mut locator = Locator::new(text);
    let mut next = 0;
    let locate = |id: usize| {
        assert!(id >= next, "ids must ascend");
        if id as u64 >= count {
            return None;
        }
        cursor.skip_words((id - next) * WORDS_PER_TRIANGLE);
        next = id + 1;
        let start = cursor.word()?.start;
        cursor.skip_words(WORDS_PER_TRIANGLE - 1);
        Some(locator.locate(start..cursor.offset()))
    };
    ids.into_iter().map_while(locate).collect()
}

/// Turns offsets into lines and columns; fast when they ascend.
pub(super) struct Locator<'t> {
    text: &'t [u8],
    /// Line number and first byte of the line last asked for.
    line: usize,
    line_start: usize,
}

impl<'t> Locator<'t> {
    pub(super) fn new(text: &'t [u8]) -> Locator<'t> {
        Locator {
            text,
            line: 1,
            line_start: 0,
        }
    }

    /// The place of `span`. O(bytes since the last one).
    pub(super) fn locate(&mut self, span: Range<usize>) -> Location {
        if span.start < self.line_start {
            *self = Locator::new(self.text);
        }
        let passed = &self.text[self.line_start..span.start];
        self.line += passed.iter().filter(|b| **b == b'\n').count();
        if let Some(last) = passed.iter().rposition(|b| *b == b'\n') {
            self.line_start += last + 1;
        }
        let before = &self.text[self.line_start..span.start];
        let before = before
            .strip_prefix(BOM)
            .filter(|_| self.line == 1)
            .unwrap_or(before);
        Location {
            line: self.line,
            column: 1 + count_chars(before),
            span,
        }
    }
}

/// Characters of `bytes`; each broken sequence counts as one.
fn count_chars(bytes: &[u8]) -> usize {
    bytes
        .utf8_chunks()
        .map(|chunk| chunk.valid().chars().count() + usize::from(!chunk.invalid().is_empty()))
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_count_characters() {
        let text = "\u{feff}é\tx\r\nüx".as_bytes();
        let mut locator = Locator::new(text);
        let mut place = |needle: usize| {
            let at = locator.locate(needle..needle);
            (at.line, at.column)
        };
        assert_eq!(place(3), (1, 1));
        assert_eq!(place(6), (1, 3));
        assert_eq!(place(11), (2, 2));
        assert_eq!(place(6), (1, 3));
        assert_eq!(Locator::new(b"\xff\xff9").locate(2..3).column, 3);
    }
}
