//! Words to a [`Scene`], section by section: camera, light, triangles, operations.
//!
//! Reading goes on after an error where the rest still means something (a bad number, a bad colour), and stops
//! where it would be guesswork. The triangles, which are nearly all of a large file, are read by code that
//! knows only right and wrong; what is wrong is then read again by `recover.rs`, which knows the words for it. The
//! camera and what it must not be stand in `corners.rs`.

use std::ops::Range;

use glam::Vec3;

use super::advice::{hint, tail_help};
use super::error::{Expected, Found, ParseError, ParseErrorKind, ParseErrors, Point};
use super::lexer::{Cursor, is_blank};
use super::locate::Locator;
use super::model::{Operation, Scene, Triangle};
use super::number::{Decimal, Whole, whole};
use super::parallel::{self, Plan};
use crate::color::Rgb;
use crate::math::Axis;
use crate::watch::{Cancelled, Watch};

/// Words of a triangle: nine coordinates and three colours.
pub(super) const WORDS_PER_TRIANGLE: usize = 12;

/// The fewest bytes that a triangle takes: twelve words of one digit, each behind one blank.
const MIN_TRIANGLE_BYTES: usize = 24;

/// After so many triangles the one thread that reads a small text tells how far it is.
const WATCH_EVERY: usize = 1 << 12;

/// The scene that `text` describes.
///
/// Large texts are read in parallel on the current rayon pool; the result and the errors are the same for any
/// number of threads. Memory is taken for what the text holds, never for what it claims; the text is not
/// copied. Bytes that are not UTF-8 are allowed in comments and an error elsewhere.
///
/// # Errors
/// At least one and at most [`ParseErrors::MAX`], each with its place. An error at the end of the file is placed
/// behind its last word or comment.
pub fn parse(text: &[u8]) -> Result<Scene, ParseErrors> {
    parse_with(text, Plan::default(), Watch::NOBODY).expect("nobody cancels")
}

/// [`parse`], which tells `watch` now and then how many triangles it has read, and how many there are to be.
///
/// # Errors
/// [`Cancelled`] when `watch` says so. Inside of that, what [`parse`] gives.
pub fn parse_watched(
    text: &[u8],
    watch: Watch<'_>,
) -> Result<Result<Scene, ParseErrors>, Cancelled> {
    parse_with(text, Plan::default(), watch)
}

/// [`parse_watched`], large texts as `plan` says.
pub(super) fn parse_with(
    text: &[u8],
    plan: Plan,
    watch: Watch<'_>,
) -> Result<Result<Scene, ParseErrors>, Cancelled> {
    let mut parser = Parser {
        watch,
        ..Parser::new(text, plan)
    };
    let scene = parser.scene();
    watch.check()?;
    Ok(match scene {
        Ok(scene) if parser.faults.is_empty() => Ok(scene),
        _ => Err(parser.into_errors()),
    })
}

/// Reading cannot go on; the reason has been noted, unless it was cancelled.
#[derive(Debug)]
pub(super) struct Halt;

/// An error whose line and column are not worked out yet.
struct Fault {
    span: Range<usize>,
    kind: ParseErrorKind,
    help: Option<String>,
}

/// Where reading is, and what was wrong so far.
pub(super) struct Parser<'t> {
    pub(super) cursor: Cursor<'t>,
    faults: Vec<Fault>,
    more: bool,
    plan: Plan,
    watch: Watch<'t>,
}

impl<'t> Parser<'t> {
    pub(super) fn new(text: &'t [u8], plan: Plan) -> Parser<'t> {
        Parser {
            cursor: Cursor::new(text),
            faults: Vec::new(),
            more: false,
            plan,
            watch: Watch::NOBODY,
        }
    }

    fn into_errors(self) -> ParseErrors {
        let mut locator = Locator::new(self.cursor.text());
        let errors = self
            .faults
            .into_iter()
            .map(|f| ParseError::new(locator.locate(f.span), f.kind, f.help))
            .collect();
        ParseErrors {
            errors,
            more: self.more,
        }
    }

    /// Notes an error. `Err` when there are too many.
    pub(super) fn note(
        &mut self,
        span: Range<usize>,
        kind: ParseErrorKind,
        help: Option<String>,
    ) -> Result<(), Halt> {
        if self.faults.len() == ParseErrors::MAX {
            self.more = true;
            return Err(Halt);
        }
        self.faults.push(Fault { span, kind, help });
        Ok(())
    }

    fn scene(&mut self) -> Result<Scene, Halt> {
        self.refuse_utf16()?;
        let camera = self.camera()?;
        let light = self.light()?;
        let triangles = self.triangles()?;
        let operations = self.operations(triangles.len() as u64)?;
        Ok(Scene {
            camera,
            light,
            triangles,
            operations,
        })
    }

    fn refuse_utf16(&mut self) -> Result<(), Halt> {
        let text = self.cursor.text();
        if text.starts_with(b"\xff\xfe") || text.starts_with(b"\xfe\xff") {
            self.note(0..2, ParseErrorKind::Utf16, None)?;
            return Err(Halt);
        }
        Ok(())
    }

    pub(super) fn light(&mut self) -> Result<Vec3, Halt> {
        let (light, span) = self.point(Point::Light)?;
        if light == Vec3::ZERO {
            let mut words = Cursor::at(&self.cursor.text()[..span.end], span.start);
            let rounded = std::iter::from_fn(|| words.decimal()).any(|d| !d.is_zero());
            let help = rounded.then(|| String::from("numbers below 7e-46 are read as 0"));
            self.note(span, ParseErrorKind::ZeroLight, help)?;
        }
        Ok(light)
    }

    fn triangles(&mut self) -> Result<Vec<Triangle>, Halt> {
        let Some(count) = self.count(Expected::TriangleCount)? else {
            self.skip_to_tail();
            return Ok(Vec::new());
        };
        let parallel = parallel::triangles(self.cursor, count, self.plan, self.watch);
        if let Some((triangles, cursor)) = parallel {
            self.cursor = cursor;
            return Ok(triangles);
        }
        let rest = self.cursor.text().len() - self.cursor.offset();
        let possible = rest / MIN_TRIANGLE_BYTES + 1;
        let capacity = usize::try_from(count).map_or(possible, |c| c.min(possible));
        let mut triangles = Vec::with_capacity(capacity);
        while (triangles.len() as u64) < count {
            if triangles.len().is_multiple_of(WATCH_EVERY) {
                self.watch.check().map_err(|Cancelled| Halt)?;
                self.watch.tell(triangles.len(), capacity);
            }
            let start = self.cursor;
            if let Some(triangle) = triangle(&mut self.cursor) {
                triangles.push(triangle);
                continue;
            }
            self.cursor = start;
            if !self.bad_triangle(triangles.len() as u64, count)? {
                break;
            }
            triangles.push(NO_TRIANGLE);
        }
        Ok(triangles)
    }

    /// Moves to what looks like the tail, or to the end.
    pub(super) fn skip_to_tail(&mut self) {
        while let Some(word) = self.cursor.peek() {
            if is_tail(self.bytes(&word)) {
                break;
            }
            self.cursor.skip_words(1);
        }
    }

    /// The tail, after this many triangles, and the end.
    fn operations(&mut self, triangles: u64) -> Result<Vec<Operation>, Halt> {
        if self.cursor.peek().is_none() {
            return Ok(Vec::new());
        }
        let expected = Expected::Tail(triangles);
        let (span, letter) = self.keyword(expected)?;
        match letter {
            Some(b'n') => {
                self.end(Expected::EndAfterNone)?;
                Ok(Vec::new())
            }
            Some(b'o') => {
                let count = self.count(Expected::OperationCount)?.ok_or(Halt)?;
                // Not reserved: few, and the count is only a claim.
                let operations = (0..count)
                    .map(|index| self.operation(index, count))
                    .collect::<Result<_, _>>()?;
                self.end(Expected::EndAfter(count))?;
                Ok(operations)
            }
            _ => {
                let help = tail_help(self.cursor.text(), &span, triangles);
                self.unexpected_with_help(span, expected, help)?;
                Err(Halt)
            }
        }
    }

    fn operation(&mut self, index: u64, count: u64) -> Result<Operation, Halt> {
        let expected = Expected::Operation(index);
        if self.cursor.peek().is_none() {
            let span = self.end_span();
            return self.halt_kind(span, fewer(expected, count, Found::End));
        }
        let (span, letter) = self.keyword(expected)?;
        let axis = match letter {
            Some(b'x') => Axis::X,
            Some(b'y') => Axis::Y,
            Some(b'z') => Axis::Z,
            _ if matches!(self.bytes(&span), [b'<', _]) => {
                self.unexpected(span, expected)?;
                Axis::X
            }
            _ => return self.halt(span, expected),
        };
        Ok(Operation {
            axis,
            angle_rad: self.angle(Expected::Angle(index))?,
        })
    }

    /// The next word as an angle; NaN when it is not one, which is noted.
    fn angle(&mut self, expected: Expected) -> Result<f64, Halt> {
        let start = self.cursor;
        if let Some(angle) = self.cursor.f64() {
            return Ok(angle);
        }
        self.cursor = start;
        self.bad_number(expected)?;
        Ok(f64::NAN)
    }

    fn end(&mut self, expected: Expected) -> Result<(), Halt> {
        match self.cursor.word() {
            None => Ok(()),
            Some(word) => self.unexpected(word, expected),
        }
    }

    /// The next three words as coordinates (NaN for each bad one, which is noted), and where they stand.
    pub(super) fn point(&mut self, point: Point) -> Result<(Vec3, Range<usize>), Halt> {
        let first = self.cursor.peek().map_or(0, |w| w.start);
        let mut coordinate = |axis| -> Result<f32, Halt> {
            let start = self.cursor;
            if let Some(value) = self.cursor.f32() {
                return Ok(value);
            }
            self.cursor = start;
            self.bad_number(Expected::Coordinate(axis, point))?;
            Ok(f32::NAN)
        };
        let p = Vec3::new(
            coordinate(Axis::X)?,
            coordinate(Axis::Y)?,
            coordinate(Axis::Z)?,
        );
        Ok((p, first..self.cursor.offset()))
    }

    /// Notes that the next word is not the number that should stand there. A word with `<` is left for
    /// whoever comes next, but only an operation comes: without one, reading halts.
    fn bad_number(&mut self, expected: Expected) -> Result<(), Halt> {
        let Some(word) = self.cursor.peek() else {
            let span = self.end_span();
            let found = Found::End;
            return self.halt_kind(span, ParseErrorKind::Unexpected { expected, found });
        };
        if self.bytes(&word).starts_with(b"<") {
            self.unexpected(word, expected)?;
            let operations_follow = matches!(expected, Expected::Angle(_));
            return if operations_follow { Ok(()) } else { Err(Halt) };
        }
        self.cursor.skip_words(1);
        self.unexpected(word, expected)
    }

    /// The next word as a count; `None` when it is not one, which is noted.
    pub(super) fn count(&mut self, expected: Expected) -> Result<Option<u64>, Halt> {
        let Some(word) = self.cursor.peek() else {
            let span = self.end_span();
            let found = Found::End;
            return self.halt_kind(span, ParseErrorKind::Unexpected { expected, found });
        };
        if let Some(Whole::Value(count)) = whole(self.bytes(&word)) {
            self.cursor.skip_words(1);
            return Ok(Some(count));
        }
        self.unexpected(word, expected)?;
        Ok(None)
    }

    /// The letter, in lower case, of `<d`, `< d` or `d`, and where it stands; no letter when the next word is
    /// something else. `expected` is for the error at the end of the file.
    pub(super) fn keyword(
        &mut self,
        expected: Expected,
    ) -> Result<(Range<usize>, Option<u8>), Halt> {
        let Some(mut span) = self.cursor.word() else {
            let span = self.end_span();
            let found = Found::End;
            return self.halt_kind(span, ParseErrorKind::Unexpected { expected, found });
        };
        let mut letter = self.bytes(&span);
        if let Some(rest) = letter.strip_prefix(b"<") {
            letter = rest;
            if rest.is_empty()
                && let Some(next) = self.cursor.word()
            {
                letter = self.bytes(&next);
                span.end = next.end;
            }
        }
        let letter = match letter {
            [letter] => Some(letter.to_ascii_lowercase()),
            _ => None,
        };
        Ok((span, letter))
    }

    pub(super) fn bytes(&self, word: &Range<usize>) -> &'t [u8] {
        &self.cursor.text()[word.clone()]
    }

    /// Behind the last word or comment.
    pub(super) fn end_span(&self) -> Range<usize> {
        let text = self.cursor.text();
        let end = text
            .iter()
            .rposition(|b| !is_blank(*b))
            .map_or(0, |i| i + 1);
        end..end
    }

    pub(super) fn halt<T>(&mut self, word: Range<usize>, expected: Expected) -> Result<T, Halt> {
        self.unexpected(word, expected)?;
        Err(Halt)
    }

    fn halt_kind<T>(&mut self, span: Range<usize>, kind: ParseErrorKind) -> Result<T, Halt> {
        self.note(span, kind, None)?;
        Err(Halt)
    }

    /// Notes that `word` stands where something else should.
    pub(super) fn unexpected(
        &mut self,
        word: Range<usize>,
        expected: Expected,
    ) -> Result<(), Halt> {
        let help = hint(self.bytes(&word), expected);
        self.unexpected_with_help(word, expected, help)
    }

    /// [`Parser::unexpected`], with a help of the caller's.
    pub(super) fn unexpected_with_help(
        &mut self,
        word: Range<usize>,
        expected: Expected,
        help: Option<String>,
    ) -> Result<(), Halt> {
        let bytes = self.bytes(&word);
        if let Err(error) = std::str::from_utf8(bytes) {
            let at = word.start + error.valid_up_to();
            let end = error.error_len().map_or(word.end, |len| at + len);
            let byte = self.cursor.text()[at];
            return self.note(at..end, ParseErrorKind::NotUtf8 { expected, byte }, None);
        }
        let found = Found::word(bytes);
        let kind = if is_right_kind(bytes, expected) {
            ParseErrorKind::OutOfRange { expected, found }
        } else {
            ParseErrorKind::Unexpected { expected, found }
        };
        self.note(word, kind, help)
    }
}

/// What stands for a bad triangle until its errors are returned.
pub(super) const NO_TRIANGLE: Triangle = Triangle {
    corners: [Vec3::ZERO; 3],
    color: Rgb::BLACK,
};

/// The next twelve words as a triangle. `None` when they are not one: then the cursor may stand anywhere.
#[inline]
pub(super) fn triangle(cursor: &mut Cursor) -> Option<Triangle> {
    let mut point = || Some(Vec3::new(cursor.f32()?, cursor.f32()?, cursor.f32()?));
    let corners = [point()?, point()?, point()?];
    let color = Rgb::new(cursor.u8()?, cursor.u8()?, cursor.u8()?);
    Some(Triangle { corners, color })
}

pub(super) fn fewer(expected: Expected, claimed: u64, found: Found) -> ParseErrorKind {
    ParseErrorKind::FewerThanClaimed {
        expected,
        claimed,
        found,
    }
}

/// True for a word that can only begin the tail.
pub(super) fn is_tail(word: &[u8]) -> bool {
    word.starts_with(b"<") || matches!(word, b"o" | b"O" | b"n" | b"N")
}

/// True when `word` has the form that is expected, so that only its size can be wrong.
fn is_right_kind(word: &[u8], expected: Expected) -> bool {
    match expected {
        Expected::Coordinate(..) | Expected::Angle(_) => {
            Decimal::scan(word).is_some_and(|d| d.len() == word.len())
        }
        Expected::TriangleCount | Expected::OperationCount | Expected::Color { .. } => {
            whole(word).is_some()
        }
        _ => false,
    }
}
