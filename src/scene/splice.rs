//! Another camera and other operations into a scene's text, and every other byte as it was.
//!
//! Who keeps a scene by hand has comments and columns in it: saving what the viewer's hand did must not touch
//! them. Operations that stay stay as they are written; new ones go to the end of the text.

use std::io;
use std::ops::Range;

use super::error::{Expected, ParseErrors};
use super::model::{CameraSetting, Operation};
use super::parallel::Plan;
use super::parser::{Parser, WORDS_PER_TRIANGLE, parse};
use super::writer::{camera_text, operation_lines};

/// `text`, a scene file, with this camera and these operations.
///
/// # Errors
/// [`io::ErrorKind::InvalidData`] when `text` is no scene file, with the text of what is wrong;
/// [`io::ErrorKind::InvalidInput`] when a number is infinite or NaN.
pub fn with_moves(
    text: &[u8],
    camera: CameraSetting,
    operations: &[Operation],
) -> io::Result<Vec<u8>> {
    let scene = parse(text).map_err(|e| not_a_scene(&e))?;
    let spans = Spans::of(text, scene.triangles.len(), scene.operations.len());
    let same = scene.operations.iter().zip(operations);
    let kept = same.take_while(|(old, new)| old == new).count();
    let mut edits: Vec<(Range<usize>, String)> = Vec::new();
    if scene.camera != camera {
        let block = match camera {
            CameraSetting::Default => "<d".to_owned(),
            CameraSetting::Set(corners) => camera_text(&corners)?.trim_end().to_owned(),
        };
        edits.push((spans.camera, block));
    }
    let new = operation_lines(&operations[kept..])?;
    let mut at_end = String::new();
    if let Some((tail, count)) = spans.tail {
        let head = match operations.len() {
            0 => "<n".to_owned(),
            n if count.is_empty() => format!("<o {n}"),
            n => n.to_string(),
        };
        let place = match (operations.len(), count.is_empty()) {
            (0, false) => tail.start..count.end,
            (_, true) => tail,
            _ => count,
        };
        if scene.operations.len() != operations.len() {
            edits.push((place, head));
        }
        if let (Some(first), Some(last)) = (spans.operations.get(kept), spans.operations.last()) {
            edits.push((first.start..last.end, new.trim_end().to_owned()));
        } else {
            at_end = new;
        }
    } else if !operations.is_empty() {
        at_end = format!("<o\n{}\n{new}", operations.len());
    }
    Ok(edited(text, &edits, &at_end))
}

fn not_a_scene(errors: &ParseErrors) -> io::Error {
    let first = &errors.errors[0];
    let text = format!(
        "it is no scene any more: {}:{}: {}",
        first.line, first.column, first.kind
    );
    io::Error::new(io::ErrorKind::InvalidData, text)
}

/// Puts `edits`, which ascend, in their places, and `at_end` on lines of its own. Lines end as the first one of `text` does.
fn edited(text: &[u8], edits: &[(Range<usize>, String)], at_end: &str) -> Vec<u8> {
    let first = text.iter().position(|b| *b == b'\n');
    let line_end = match first {
        Some(at) if text[..at].ends_with(b"\r") => "\r\n",
        _ => "\n",
    };
    let own = |words: &str| words.replace('\n', line_end);
    let mut new = Vec::with_capacity(text.len() + 1024);
    let mut done = 0;
    for (place, words) in edits {
        new.extend_from_slice(&text[done..place.start]);
        new.extend_from_slice(own(words).as_bytes());
        done = place.end;
    }
    new.extend_from_slice(&text[done..]);
    if !at_end.is_empty() {
        if new.last().is_some_and(|b| *b != b'\n') {
            new.extend_from_slice(line_end.as_bytes());
        }
        new.extend_from_slice(own(at_end).as_bytes());
    }
    new
}

/// Where the parts of a good scene file stand.
struct Spans {
    camera: Range<usize>,
    /// `<n` or `<o`, and the number of operations (empty for none).
    tail: Option<(Range<usize>, Range<usize>)>,
    operations: Vec<Range<usize>>,
}

impl Spans {
    /// Of a text that the parser accepts.
    fn of(text: &[u8], triangles: usize, operations: usize) -> Spans {
        let mut parser = Parser::new(text, Plan::default());
        let start = parser.cursor.peek().map_or(0, |w| w.start);
        let _ = parser.camera();
        let camera = start..parser.cursor.offset();
        let _ = parser.light();
        let _ = parser.count(Expected::TriangleCount);
        for _ in 0..triangles {
            parser.cursor.skip_words(WORDS_PER_TRIANGLE);
        }
        let mut spans = Spans {
            camera,
            tail: None,
            operations: Vec::with_capacity(operations),
        };
        if parser.cursor.peek().is_none() {
            return spans;
        }
        let Ok((tail, letter)) = parser.keyword(Expected::Tail(0)) else {
            return spans;
        };
        let count = match parser.cursor.word() {
            Some(count) if letter == Some(b'o') => count,
            _ => 0..0,
        };
        spans.tail = Some((tail, count));
        for _ in 0..operations {
            if let Ok((axis, _)) = parser.keyword(Expected::Operation(0))
                && let Some(angle) = parser.cursor.word()
            {
                spans.operations.push(axis.start..angle.end);
            }
        }
        spans
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Axis, CameraCorners};
    use glam::Vec3;

    const TOP: &str = "\u{feff}# mine\n<d # above\n0 0 -1 # light\r\n2\n0 0 0  1 0 0  0 1 0  1 2 3\n\t1 0 0  1 1 0  0 1 0  # second\n 4 5 6\n";

    fn op(axis: Axis, angle_rad: f64) -> Operation {
        Operation { axis, angle_rad }
    }

    fn spliced(tail: &str, operations: &[Operation]) -> String {
        let text = format!("{TOP}{tail}");
        let new =
            with_moves(text.as_bytes(), CameraSetting::Default, operations).expect("a good scene");
        let new = String::from_utf8(new).expect("text");
        assert_eq!(parse(new.as_bytes()).expect("good").operations, operations);
        new.strip_prefix(TOP)
            .expect("the rest is as it was")
            .to_owned()
    }

    #[test]
    fn operations_that_stay_keep_their_text_and_new_ones_follow() {
        let (x, y) = (op(Axis::X, 0.5), op(Axis::Y, -0.25));
        let tail = "< o 1 # one\n  X 5e-1 # half\n# end";
        assert_eq!(spliced(tail, &[x]), tail);
        assert_eq!(
            spliced(tail, &[x, y]),
            "< o 2 # one\n  X 5e-1 # half\n# end\n<y -0.25\n"
        );
        assert_eq!(spliced(tail, &[y]), "< o 1 # one\n  <y -0.25 # half\n# end");
        assert_eq!(spliced(tail, &[]), "<n # one\n   # half\n# end");
    }

    #[test]
    fn every_kind_of_tail_takes_operations() {
        let x = op(Axis::X, 0.5);
        assert_eq!(spliced("<n # none", &[x]), "<o 1 # none\n<x 0.5\n");
        assert_eq!(spliced("n", &[]), "n");
        assert_eq!(spliced("", &[x]), "<o\n1\n<x 0.5\n");
        assert_eq!(spliced("<o 0", &[x, x]), "<o 2\n<x 0.5\n<x 0.5\n");
        assert_eq!(spliced("", &[]), "");
    }

    #[test]
    fn lines_end_as_those_of_the_file_do() {
        let x = op(Axis::X, 0.5);
        let text = "<d\r\n0 0 -1\n0";
        let new = with_moves(text.as_bytes(), CameraSetting::Default, &[x]).expect("a scene");
        assert_eq!(new, b"<d\r\n0 0 -1\n0\r\n<o\r\n1\r\n<x 0.5\r\n");
    }

    #[test]
    fn another_camera_takes_the_place_of_the_old_one_alone() {
        let set = CameraSetting::Set(CameraCorners {
            eye: Vec3::new(0.0, 0.0, 5.0),
            top_left: Vec3::new(-1.0, 1.0, 1.0),
            top_right: Vec3::new(1.0, 1.0, 1.0),
            bottom_left: Vec3::new(-1.0, -1.0, 0.1),
        });
        let once = with_moves(TOP.as_bytes(), set, &[]).expect("good");
        let scene = parse(&once).expect("good");
        assert_eq!(scene.camera, set);
        let text = String::from_utf8(once.clone()).expect("text");
        assert_eq!(
            text,
            TOP.replace("<d", "<s\n0 0 5\n-1 1 1\n1 1 1\n-1 -1 0.1")
        );
        assert_eq!(with_moves(&once, set, &[]).expect("good"), once);
        let back = with_moves(&once, CameraSetting::Default, &[]).expect("good");
        assert_eq!(back, TOP.as_bytes());
    }

    #[test]
    fn what_is_no_scene_is_refused() {
        let refused =
            with_moves(b"<d 0 0 -1 1", CameraSetting::Default, &[]).expect_err("no triangle");
        assert_eq!(refused.kind(), io::ErrorKind::InvalidData);
        let nan = with_moves(
            TOP.as_bytes(),
            CameraSetting::Default,
            &[op(Axis::X, f64::NAN)],
        );
        assert!(nan.is_err());
    }
}
