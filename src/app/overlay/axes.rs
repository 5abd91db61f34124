//! The cross of the axes: where x, y and z point, as the camera sees them.

use glam::DVec3;

use super::canvas::Rect;
use super::{Canvas, GREY, WHITE};
use crate::camera::View;
use crate::scene::Axis;

/// Length of an axis at scale factor 1.
const ARM_PX: f64 = 36.0;
/// From the middle to the window's borders, in arms.
const MARGIN: f64 = 1.5;
/// The middle of a letter, in arms from that of the cross.
const LETTER: f64 = 1.28;
/// Letters whose middles are nearer than that, in arms across and down, cover each other.
const LETTER_ROOM: (f64, f64) = (0.3, 0.4);
/// The end that points away from the eye is so much darker.
const FAR: u32 = 0x3f_3f3f;

/// The axes with their letters and colours.
const AXES: [(Axis, char, u32); 3] = [
    (Axis::X, 'x', 0xff_5048),
    (Axis::Y, 'y', 0x50_d850),
    (Axis::Z, 'z', 0x60_98ff),
];

/// An end of an axis on the screen, in arms from the middle.
#[derive(Clone, Copy, Debug, PartialEq)]
struct End {
    right: f64,
    down: f64,
    /// Away from the eye.
    depth: f64,
    color: u32,
    letter: Option<char>,
    /// A nearer letter lies over this one.
    is_covered: bool,
}

/// The six ends, the farthest first.
fn ends(view: &View) -> Vec<End> {
    let right = view.dx.normalize_or_zero();
    let down = view.dy.normalize_or_zero();
    let away = right.cross(down).normalize_or_zero();
    let end = |direction: DVec3, color, letter| End {
        right: direction.dot(right),
        down: direction.dot(down),
        depth: direction.dot(away),
        color,
        letter,
        is_covered: false,
    };
    let mut ends: Vec<End> = AXES
        .into_iter()
        .flat_map(|(axis, letter, color)| {
            let direction = crate::app::orbit::direction(axis);
            [
                end(direction, color, Some(letter)),
                end(-direction, GREY, None),
            ]
        })
        .collect();
    ends.sort_by(|a, b| b.depth.total_cmp(&a.depth));
    find_covered_letters(&mut ends);
    ends
}

/// Finds the letters that nearer ones would cover: of two in one place none can be read.
fn find_covered_letters(ends: &mut [End]) {
    for i in 0..ends.len() {
        let (before, nearer) = ends.split_at_mut(i + 1);
        let end = &mut before[i];
        let covers = |other: &End| {
            let across = (other.right - end.right).abs() * LETTER;
            let along = (other.down - end.down).abs() * LETTER;
            other.letter.is_some() && across < LETTER_ROOM.0 && along < LETTER_ROOM.1
        };
        end.is_covered = end.letter.is_some() && nearer.iter().any(covers);
    }
}

/// What the cross takes of a window of that size.
pub fn place((width, height): (i32, i32), scale: f64, above: i32) -> Rect {
    // A few dozen pixels.
    let side = (2.0 * MARGIN * ARM_PX * scale).ceil() as i32;
    Rect {
        x: width - side,
        y: height - above - side,
        width: side,
        height: side,
    }
}

/// Draws the cross at the lower right, `above` pixels over the border. Letters are the caller's: it gets each with its
/// middle and its colour.
pub fn draw(
    canvas: &mut Canvas<'_>,
    view: &View,
    scale: f64,
    above: i32,
    mut letter: impl FnMut(&mut Canvas<'_>, (f64, f64), char, u32),
) {
    let arm = ARM_PX * scale;
    // A window's size is exact in `f64`.
    let middle = (
        canvas.width as f64 - MARGIN * arm,
        canvas.height as f64 - MARGIN * arm - f64::from(above),
    );
    for end in ends(view) {
        let at = |part: f64| {
            (
                middle.0 + end.right * arm * part,
                middle.1 + end.down * arm * part,
            )
        };
        // What points away is darker; the ends without a letter are thin and short.
        let color = if end.depth > 0.05 {
            end.color - (end.color >> 2 & FAR)
        } else {
            end.color
        };
        let (length, thick) = match end.letter {
            Some(_) => (1.0, 3.0),
            None => (0.5, 1.5),
        };
        canvas.line(middle, at(length), (thick + 2.0) * scale, 0);
        canvas.line(middle, at(length), thick * scale, color);
        if let Some(c) = end.letter.filter(|_| !end.is_covered) {
            letter(canvas, at(LETTER), c, color);
        }
    }
    canvas.line(middle, middle, 4.0 * scale, WHITE);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::geometry::Aabb;

    #[test]
    fn from_above_x_points_right_y_up_and_z_at_the_eye() {
        let view = Camera::default_for(Aabb::EMPTY).view(64, 48, false);
        let ends = ends(&view);
        let of = |letter| ends.iter().find(|e| e.letter == Some(letter));
        let near = |value: f64, expected: f64| (value - expected).abs() < 1e-12;
        let [x, y, z] = ['x', 'y', 'z'].map(|c| of(c).expect("an axis"));
        assert!(near(x.right, 1.0) && near(x.down, 0.0));
        assert!(near(y.right, 0.0) && near(y.down, -1.0));
        assert!(near(z.depth, -1.0) && *z == ends[5], "the nearest is last");
        assert!(ends.iter().all(|end| !end.is_covered));
    }

    #[test]
    fn of_two_letters_in_one_place_the_nearer_one_is_drawn() {
        let end = |right, letter| End {
            right,
            down: 0.0,
            depth: 0.0,
            color: 0,
            letter,
            is_covered: false,
        };
        let covered = |ends: &mut [End]| {
            find_covered_letters(ends);
            ends.iter().map(|end| end.is_covered).collect::<Vec<bool>>()
        };
        let mut near = [end(0.9, Some('x')), end(0.8, Some('y'))];
        assert_eq!(covered(&mut near), [true, false]);
        let mut apart = [end(0.9, Some('x')), end(0.5, Some('y')), end(0.5, None)];
        assert_eq!(covered(&mut apart), [false; 3]);
    }
}
