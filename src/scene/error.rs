//! What can be wrong with a scene file, and how it is told.

use std::fmt;
use std::ops::Range;

use super::locate::Location;
use super::snippet::{Severity, annotate};
use crate::math::Axis;

/// Everything found wrong with one file, in the order in which it was found.
#[derive(Clone, Debug, PartialEq)]
pub struct ParseErrors {
    /// At least one, at most [`ParseErrors::MAX`].
    pub errors: Vec<ParseError>,
    /// True when reading stopped because there were more than [`ParseErrors::MAX`].
    pub more: bool,
}

/// One thing wrong with a scene file.
#[derive(Clone, Debug, PartialEq)]
pub struct ParseError {
    /// From 1; lines end at LF.
    pub line: usize,
    /// From 1, in characters; see [`Location::column`].
    pub column: usize,
    /// The bytes meant; see [`Location::span`].
    pub span: Range<usize>,
    /// What is wrong.
    pub kind: ParseErrorKind,
    /// What may have led to it, for the reader of the message.
    pub help: Option<String>,
}

/// What is wrong at a place.
#[derive(Clone, Debug, PartialEq)]
pub enum ParseErrorKind {
    /// Something else stands where `expected` should.
    Unexpected {
        /// What should stand there.
        expected: Expected,
        /// What stands there.
        found: Found,
    },
    /// The right kind of number, but too large for its purpose.
    OutOfRange {
        /// What should stand there.
        expected: Expected,
        /// The number as written.
        found: Found,
    },
    /// The tail or the end of the file stands where one more of the triangles or operations that the file
    /// claims should.
    FewerThanClaimed {
        /// What should stand there.
        expected: Expected,
        /// How many the file claims.
        claimed: u64,
        /// What stands there.
        found: Found,
    },
    /// A byte outside of comments that is not UTF-8.
    NotUtf8 {
        /// What should stand there.
        expected: Expected,
        /// The first such byte of the word.
        byte: u8,
    },
    /// The text begins with a byte-order mark of UTF-16.
    Utf16,
    /// The light's direction is 0 0 0 (perhaps only after rounding to `f32`).
    ZeroLight,
    /// The corners of the projection plane lie on one line, so there is no plane.
    PlaneOnOneLine,
    /// The eye lies in the projection plane, so nothing can be seen.
    EyeInPlane,
}

/// What may stand at a place. All numbers of triangles and operations count from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Expected {
    /// `<d` or `<s`.
    Camera,
    /// One of three numbers.
    Coordinate(Axis, Point),
    /// How many triangles follow.
    TriangleCount,
    /// 0..=255.
    Color {
        /// Which of the three.
        channel: Channel,
        /// Whose.
        triangle: u64,
    },
    /// `<o`, `<n` or the end, after this many triangles.
    Tail(u64),
    /// How many operations follow.
    OperationCount,
    /// `<x`, `<y` or `<z` of this operation.
    Operation(u64),
    /// The angle of this operation.
    Angle(u64),
    /// The end of the file, after `<n`.
    EndAfterNone,
    /// The end of the file, after this many operations.
    EndAfter(u64),
}

/// Something with three coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Point {
    /// E.
    Eye,
    /// O, of the projection plane.
    TopLeft,
    /// A, of the projection plane.
    TopRight,
    /// B, of the projection plane.
    BottomLeft,
    /// The light's direction.
    Light,
    /// A corner of a triangle.
    Corner {
        /// 0 for A, 1 for B, 2 for C.
        corner: usize,
        /// Whose.
        triangle: u64,
    },
}

/// A channel of a colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// The first.
    Red,
    /// The second.
    Green,
    /// The third.
    Blue,
}

/// What stands at a place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Found {
    /// A word, in UTF-8, shortened to [`Found::MAX_CHARS`] characters.
    Word(String),
    /// Nothing more.
    End,
}

impl Found {
    /// Longer words are shortened.
    pub const MAX_CHARS: usize = 40;

    /// The word that `bytes` is.
    pub(super) fn word(bytes: &[u8]) -> Found {
        // Four bytes a character at most: no need to look at all of a word of 10 MB.
        let head = &bytes[..bytes.len().min(4 * Found::MAX_CHARS + 4)];
        let text = String::from_utf8_lossy(head);
        if text.chars().count() <= Found::MAX_CHARS {
            return Found::Word(text.into_owned());
        }
        let short = text.chars().take(Found::MAX_CHARS - 1);
        Found::Word(short.chain(['…']).collect())
    }
}

impl fmt::Display for Found {
    /// A word in quotation marks, what cannot be seen in it escaped.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Found::Word(word) => write!(f, "\"{}\"", word.escape_debug()),
            Found::End => f.write_str("the end of the file"),
        }
    }
}

impl Point {
    fn describe(self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Point::Eye => f.write_str("the eye"),
            Point::TopLeft => f.write_str("the top-left corner O"),
            Point::TopRight => f.write_str("the top-right corner A"),
            Point::BottomLeft => f.write_str("the bottom-left corner B"),
            Point::Light => f.write_str("the light"),
            Point::Corner { corner, triangle } => {
                write!(
                    f,
                    "corner {} of triangle {triangle}",
                    ['A', 'B', 'C'][corner]
                )
            }
        }
    }
}

impl Expected {
    /// The kind of thing that may stand there.
    fn noun(self) -> &'static str {
        match self {
            Expected::Camera => "<d or <s",
            Expected::Coordinate(..) | Expected::Angle(_) => "a number",
            Expected::TriangleCount => "the number of triangles",
            Expected::OperationCount => "the number of operations",
            Expected::Color { .. } => "a whole number from 0 to 255",
            Expected::Tail(_) => "<o, <n or the end of the file",
            Expected::Operation(_) => "<x, <y or <z",
            Expected::EndAfterNone | Expected::EndAfter(_) => "the end of the file",
        }
    }

    /// The range within which a number must lie.
    fn range(self) -> &'static str {
        match self {
            Expected::Coordinate(..) => " within ±3.4028235e38",
            Expected::Angle(_) => " within ±1.7976931348623157e308",
            Expected::TriangleCount | Expected::OperationCount => " (at most 18446744073709551615)",
            _ => "",
        }
    }

    /// Which one of its kind it is; without brackets.
    fn which(self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Expected::Camera => f.write_str("the camera"),
            Expected::Coordinate(axis, point) => {
                write!(f, "{} of ", axis_letter(axis))?;
                point.describe(f)
            }
            Expected::TriangleCount | Expected::OperationCount => f.write_str("digits only"),
            Expected::Color { channel, triangle } => {
                let channel = match channel {
                    Channel::Red => "red",
                    Channel::Green => "green",
                    Channel::Blue => "blue",
                };
                write!(f, "{channel} of triangle {triangle}")
            }
            Expected::Tail(n) => write!(f, "after {}, as many as claimed", triangles(n)),
            Expected::Operation(n) => write!(f, "operation {n}"),
            Expected::Angle(n) => write!(f, "angle in radians of operation {n}"),
            Expected::EndAfterNone => f.write_str("after <n"),
            Expected::EndAfter(n) => write!(f, "after {}, as many as claimed", operations(n)),
        }
    }
}

impl fmt::Display for Expected {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{} (", self.noun())?;
        self.which(f)?;
        f.write_str(")")
    }
}

pub(super) fn axis_letter(axis: Axis) -> char {
    match axis {
        Axis::X => 'x',
        Axis::Y => 'y',
        Axis::Z => 'z',
    }
}

fn triangles(n: u64) -> String {
    format!("{n} triangle{}", if n == 1 { "" } else { "s" })
}

fn operations(n: u64) -> String {
    format!("{n} operation{}", if n == 1 { "" } else { "s" })
}

impl fmt::Display for ParseErrorKind {
    /// `expected X, found Y`, one line.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("expected ")?;
        match self {
            ParseErrorKind::Unexpected { expected, found } => {
                write!(f, "{expected}, found {found}")
            }
            ParseErrorKind::OutOfRange { expected, found } => {
                write!(f, "{}{}", expected.noun(), expected.range())?;
                if !matches!(expected, Expected::TriangleCount | Expected::OperationCount) {
                    f.write_str(" (")?;
                    expected.which(f)?;
                    f.write_str(")")?;
                }
                write!(f, ", found {found}")
            }
            ParseErrorKind::FewerThanClaimed {
                expected,
                claimed,
                found,
            } => {
                write!(f, "{} (", expected.noun())?;
                expected.which(f)?;
                let claim = match expected {
                    Expected::Operation(_) | Expected::Angle(_) => operations(*claimed),
                    _ => triangles(*claimed),
                };
                write!(f, "; the file claims {claim}), found {found}")
            }
            ParseErrorKind::NotUtf8 { expected, byte } => {
                write!(
                    f,
                    "{expected}, found the byte 0x{byte:02x}, which is not UTF-8"
                )
            }
            ParseErrorKind::Utf16 => f.write_str("text in UTF-8, found text in UTF-16"),
            ParseErrorKind::ZeroLight => {
                f.write_str("the direction in which the light travels, found 0 0 0")
            }
            ParseErrorKind::PlaneOnOneLine => f.write_str(
                "three corners of a projection plane (O, A, B), found three points on one line",
            ),
            ParseErrorKind::EyeInPlane => {
                f.write_str("an eye outside of the projection plane, found one in that plane")
            }
        }
    }
}

impl ParseError {
    /// The error at `span` of `text`.
    pub(super) fn new(at: Location, kind: ParseErrorKind, help: Option<String>) -> ParseError {
        ParseError {
            line: at.line,
            column: at.column,
            span: at.span,
            kind,
            help,
        }
    }

    /// Where it is.
    #[must_use]
    pub fn location(&self) -> Location {
        Location {
            line: self.line,
            column: self.column,
            span: self.span.clone(),
        }
    }

    /// `NAME:LINE:COLUMN: expected X, found Y`, then the line of `text` with a caret (a long line in part), then
    /// help where there is some; no line feed at the end. `text` is what was parsed, `name` what the user
    /// calls it.
    #[must_use]
    pub fn render(&self, name: &str, text: &[u8], color: bool) -> String {
        let help = self.help.as_deref();
        annotate(
            Severity::Error,
            name,
            text,
            &self.location(),
            &self.kind.to_string(),
            help,
            color,
        )
    }
}

impl fmt::Display for ParseError {
    /// `LINE:COLUMN: expected X, found Y`.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}:{}: {}", self.line, self.column, self.kind)
    }
}

impl std::error::Error for ParseError {}

impl ParseErrors {
    /// Reading stops after this many errors.
    pub const MAX: usize = 20;

    /// All errors as [`ParseError::render`] shows them, and a last line `… and more` where that is so.
    #[must_use]
    pub fn render(&self, name: &str, text: &[u8], color: bool) -> String {
        let more = self.more.then(|| String::from(AND_MORE));
        let errors = self.errors.iter().map(|e| e.render(name, text, color));
        errors.chain(more).collect::<Vec<_>>().join("\n")
    }
}

const AND_MORE: &str = "… and more";

impl fmt::Display for ParseErrors {
    /// One line an error: `LINE:COLUMN: expected X, found Y`.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        for (i, error) in self.errors.iter().enumerate() {
            let separator = if i == 0 { "" } else { "\n" };
            write!(f, "{separator}{error}")?;
        }
        if self.more {
            write!(f, "\n{AND_MORE}")?;
        }
        Ok(())
    }
}

impl std::error::Error for ParseErrors {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_and_unprintable_words_are_told_briefly() {
        let long = "7".repeat(1000);
        let found = Found::word(long.as_bytes()).to_string();
        assert_eq!(found, format!("\"{}…\"", "7".repeat(39)));
        assert_eq!(Found::word(b"a\0\x1b\"").to_string(), r#""a\0\u{1b}\"""#);
    }
}
