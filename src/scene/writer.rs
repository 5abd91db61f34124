//! Plain data to text that reads back to the same bits.

use std::io::{self, Write};

use glam::Vec3;
use rayon::prelude::*;

use super::error::axis_letter;
use super::model::{CameraCorners, CameraSetting, Operation, Scene, Triangle};

/// Triangles that one thread writes at a time.
const PIECE: usize = 1 << 12;

/// Pieces in memory at a time.
const PIECES: usize = 16;

/// Writes `scene` as a scene file: no comments, lines end with LF, a triangle a line, each number with the fewest
/// digits that read back to it. [`super::parse`] gives the same bits again, down to the sign of zero, for
/// every scene that it could have given itself. Large scenes are formatted
/// on the current rayon pool.
///
/// # Errors
/// When `out` fails; [`io::ErrorKind::InvalidInput`] when a number of the scene is infinite or NaN, which the
/// format cannot say. `out` may then have part of the text.
pub fn write(scene: &Scene, out: &mut impl Write) -> io::Result<()> {
    let mut head = Text::default();
    match &scene.camera {
        CameraSetting::Default => head.0 += "<d\n",
        CameraSetting::Set(corners) => head.camera(corners)?,
    }
    head.point(scene.light)?;
    head.end_line();
    head.0 += &format!("{}\n", scene.triangles.len());
    out.write_all(head.0.as_bytes())?;
    for batch in scene.triangles.chunks(PIECE * PIECES) {
        // A small scene does not start a pool of threads.
        let texts: Vec<Text> = if batch.len() <= PIECE {
            vec![Text::triangles(batch)?]
        } else {
            let pieces = batch.par_chunks(PIECE).map(Text::triangles);
            pieces.collect::<Result<_, _>>()?
        };
        for text in texts {
            out.write_all(text.0.as_bytes())?;
        }
    }
    let mut tail = Text::default();
    tail.operations(&scene.operations)?;
    out.write_all(tail.0.as_bytes())
}

/// The `<s` block of a scene file with this camera: five lines.
///
/// # Errors
/// [`io::ErrorKind::InvalidInput`] when a number is infinite or NaN.
pub fn camera_text(corners: &CameraCorners) -> io::Result<String> {
    let mut text = Text::default();
    text.camera(corners)?;
    Ok(text.0)
}

/// The tail of a scene file with these operations: `<n`, or `<o` with their number and a line each.
///
/// # Errors
/// [`io::ErrorKind::InvalidInput`] when an angle is infinite or NaN.
pub fn operations_text(operations: &[Operation]) -> io::Result<String> {
    let mut text = Text::default();
    text.operations(operations)?;
    Ok(text.0)
}

/// The lines of these operations alone.
pub(super) fn operation_lines(operations: &[Operation]) -> io::Result<String> {
    let mut text = Text::default();
    operations.iter().try_for_each(|op| text.operation(op))?;
    Ok(text.0)
}

/// Text under construction.
#[derive(Default)]
struct Text(String);

impl Text {
    fn camera(&mut self, corners: &CameraCorners) -> io::Result<()> {
        self.0 += "<s\n";
        for point in [
            corners.eye,
            corners.top_left,
            corners.top_right,
            corners.bottom_left,
        ] {
            self.point(point)?;
            self.end_line();
        }
        Ok(())
    }

    fn triangles(triangles: &[Triangle]) -> io::Result<Text> {
        let mut text = Text(String::with_capacity(triangles.len() * 100));
        for Triangle { corners, color } in triangles {
            for corner in corners {
                text.point(*corner)?;
            }
            for channel in [color.r, color.g, color.b] {
                text.color(channel);
            }
            text.end_line();
        }
        Ok(text)
    }

    fn operations(&mut self, operations: &[Operation]) -> io::Result<()> {
        if operations.is_empty() {
            self.0 += "<n\n";
            return Ok(());
        }
        self.0 += &format!("<o\n{}\n", operations.len());
        operations.iter().try_for_each(|op| self.operation(op))
    }

    fn operation(&mut self, Operation { axis, angle_rad }: &Operation) -> io::Result<()> {
        finite(angle_rad.is_finite())?;
        let letter = axis_letter(*axis);
        let angle = if plain(angle_rad.abs()) {
            format!("{angle_rad}")
        } else {
            format!("{angle_rad:e}")
        };
        self.0 += &format!("<{letter} {angle}\n");
        Ok(())
    }

    /// Three numbers, each with a blank behind it.
    fn point(&mut self, point: Vec3) -> io::Result<()> {
        use std::fmt::Write;
        finite(point.is_finite())?;
        for value in point.to_array() {
            let written = if plain(f64::from(value.abs())) {
                write!(self.0, "{value} ")
            } else {
                write!(self.0, "{value:e} ")
            };
            written.expect("a String takes everything");
        }
        Ok(())
    }

    /// A number from 0 to 255 and a blank.
    fn color(&mut self, value: u8) {
        let digit = |n: u8| char::from(b'0' + n);
        if value >= 100 {
            self.0.push(digit(value / 100));
        }
        if value >= 10 {
            self.0.push(digit(value / 10 % 10));
        }
        self.0.push(digit(value % 10));
        self.0.push(' ');
    }

    /// A line feed in place of the last blank.
    fn end_line(&mut self) {
        self.0.pop();
        self.0.push('\n');
    }
}

/// True when a number of this size is shorter, or easier on the eye, without an exponent.
fn plain(size: f64) -> bool {
    size == 0.0 || (1e-4..1e9).contains(&size)
}

fn finite(finite: bool) -> io::Result<()> {
    if finite {
        return Ok(());
    }
    let message = "the scene holds a number that is not finite, which a scene file cannot say";
    Err(io::Error::new(io::ErrorKind::InvalidInput, message))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_take_few_digits() {
        let mut text = Text::default();
        text.point(Vec3::new(1.0, -0.0, 0.1)).unwrap();
        text.point(Vec3::new(-1e-45, f32::MAX, 0.000_25)).unwrap();
        assert_eq!(text.0, "1 -0 0.1 -1e-45 3.4028235e38 0.00025 ");
    }

    #[test]
    fn colours_are_written_without_leading_zeros() {
        let mut text = Text::default();
        for value in [0, 9, 10, 99, 100, 205, 255] {
            text.color(value);
        }
        text.end_line();
        assert_eq!(text.0, "0 9 10 99 100 205 255\n");
    }
}
