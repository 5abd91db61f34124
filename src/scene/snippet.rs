//! A place in a text, shown: the line with a caret under what is meant.

use std::ops::Range;

use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};

use super::lexer::BOM;
use super::locate::Location;

/// How bad it is; decides the caret's colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// The file cannot be used.
    Error,
    /// It can.
    Warning,
}

/// A line is shown up to this many bytes before the place ...
const BYTES_BEFORE: usize = 60;
/// ... and this many from its start on.
const BYTES_AFTER: usize = 60;

/// Shows a place in `text`, which the user knows as `name`:
///
/// ```text
/// input.txt:7:12: expected a number (z of corner B of triangle 17), found "abc"
///   |
/// 7 | 0 0 0  1 0 abc  0 1 0  255 0 0
///   |            ^^^
///   = help: ..
/// ```
///
/// No line feed at the end. Of a long line only the part around the place is shown, with `…` where it is cut.
/// Characters that cannot be seen are shown as pictures of themselves, broken UTF-8 as U+FFFD. With
/// `color`, there are ANSI escapes in it.
#[must_use]
pub fn annotate(
    severity: Severity,
    name: &str,
    text: &[u8],
    at: &Location,
    message: &str,
    help: Option<&str>,
    color: bool,
) -> String {
    let (source, span) = window(text, &at.span);
    let level = match severity {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
    };
    let header = format!("{name}:{}:{}: {message}", at.line, at.column);
    let snippet = Snippet::source(source)
        .line_start(at.line)
        .annotation(AnnotationKind::Primary.span(span));
    let mut group = level.no_name().primary_title(header).element(snippet);
    if let Some(help) = help {
        group = group.element(Level::HELP.message(help));
    }
    let renderer = if color {
        Renderer::styled()
    } else {
        Renderer::plain()
    };
    // Wider than any window: it is cut here already.
    renderer.term_width(1000).render(&[group])
}

/// The part of the line around `span`, as text, and where `span` is in it.
fn window(text: &[u8], span: &Range<usize>) -> (String, Range<usize>) {
    let line = line_of(text, span.start);
    let start = match span.start - line.start {
        0..=BYTES_BEFORE => line.start,
        _ => char_start(text, span.start - BYTES_BEFORE),
    };
    let end = match line.end - span.start {
        0..=BYTES_AFTER => line.end,
        _ => char_start(text, span.start + BYTES_AFTER),
    };
    let show = |range: Range<usize>| String::from_utf8_lossy(&text[range]);
    let mut source = String::from(if start > line.start { "…" } else { "" });
    source += &show(start..span.start);
    let shown_start = source.len();
    let span_end = span.end.clamp(span.start, end);
    source += &show(span.start..span_end);
    let shown_end = source.len();
    source += &show(span_end..end);
    source += if end < line.end { "…" } else { "" };
    (source, shown_start..shown_end)
}

/// The line around byte `at`, without its line feed.
pub(super) fn line_bytes(text: &[u8], at: usize) -> Range<usize> {
    let start = text[..at]
        .iter()
        .rposition(|b| *b == b'\n')
        .map_or(0, |i| i + 1);
    let len = text[at..]
        .iter()
        .position(|b| *b == b'\n')
        .unwrap_or(text.len() - at);
    start..at + len
}

/// The line around byte `at`, without its end and without a byte-order mark.
fn line_of(text: &[u8], at: usize) -> Range<usize> {
    let Range { start, end } = line_bytes(text, at);
    let start = if start == 0 && at >= BOM.len() && text.starts_with(BOM) {
        BOM.len()
    } else {
        start
    };
    let end = if end > at && text[end - 1] == b'\r' {
        end - 1
    } else {
        end
    };
    start..end
}

/// `at`, or up to three bytes less, so that no character is cut.
fn char_start(text: &[u8], at: usize) -> usize {
    let is_start = |i: usize| text[i] & 0xc0 != 0x80;
    (at.saturating_sub(3)..=at)
        .rev()
        .find(|i| is_start(*i))
        .unwrap_or(at)
}
