//! One picture, two ways to make it: a wish split at a column, and how the halves become one picture.
//!
//! A window that is not split has one side, the left one, over all columns. Sides of slow engines, which test every
//! triangle at every pixel, are painted by a [`Companion`](super::companion::Companion), bit by bit; the others by the
//! [`Painter`](super::painter::Painter), whole.

use std::ops::Range;

use super::state::Wish;
use crate::frame::Frame;
use crate::render::{Engine, Settings, ViewMode};

/// How the right part of a picture is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Split {
    /// By what.
    pub settings: Settings,
    /// Its first column.
    pub column: usize,
}

/// A part of a picture and how it is made.
#[derive(Clone, Debug, PartialEq)]
pub struct Side {
    /// By what.
    pub settings: Settings,
    /// The columns; there may be none.
    pub columns: Range<usize>,
}

impl Side {
    /// It has pixels, and an engine that takes its time over them.
    #[must_use]
    pub fn is_slow(&self) -> bool {
        self.settings.engine != Engine::Fast && !self.columns.is_empty()
    }

    /// It has pixels, and the engine that has them at once.
    #[must_use]
    pub fn is_fast(&self) -> bool {
        self.settings.engine == Engine::Fast && !self.columns.is_empty()
    }
}

impl Wish {
    /// The left and the right side.
    #[must_use]
    pub fn sides(&self) -> [Side; 2] {
        let width = self.view.width;
        let column = self.split.map_or(width, |split| split.column.min(width));
        let right = self.split.map_or(self.settings, |split| split.settings);
        let (settings, columns) = (self.settings, 0..column);
        let left = Side { settings, columns };
        let (settings, columns) = (right, column..width);
        [left, Side { settings, columns }]
    }

    /// How the pixels of a column are made.
    #[must_use]
    pub fn settings_at(&self, column: usize) -> Settings {
        match self.split {
            Some(split) if column >= split.column => split.settings,
            _ => self.settings,
        }
    }

    /// Some of it is painted whole.
    #[must_use]
    pub fn has_fast_side(&self) -> bool {
        self.sides().iter().any(Side::is_fast)
    }

    /// The work done is shown, which depends on the tree.
    #[must_use]
    pub fn shows_cost(&self) -> bool {
        let shows = |side: &Side| side.is_fast() && side.settings.mode == ViewMode::Cost;
        self.sides().iter().any(shows)
    }
}

/// Lays `columns` of `frame` over `pixels`, rows of `width`; black where there is none.
pub fn compose(pixels: &mut [u32], width: usize, frame: Option<&Frame>, columns: Range<usize>) {
    let columns = columns.start.min(width)..columns.end.min(width);
    if columns.is_empty() {
        return;
    }
    let mut rows = frame.map(|f| f.pixels.chunks_exact(f.width.max(1)));
    for to in pixels.chunks_exact_mut(width) {
        let to = &mut to[columns.clone()];
        let from = rows.as_mut().and_then(Iterator::next).unwrap_or_default();
        let from = from.get(columns.start..).unwrap_or_default();
        let known = to.len().min(from.len());
        to[..known].copy_from_slice(&from[..known]);
        to[known..].fill(0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::geometry::Aabb;

    fn wish(split: Option<usize>) -> Wish {
        let report = Settings {
            engine: Engine::Report,
            ..Settings::default()
        };
        Wish {
            view: Camera::default_for(Aabb::EMPTY).view(30, 8, false),
            settings: Settings::default(),
            split: split.map(|column| Split {
                settings: report,
                column,
            }),
        }
    }

    #[test]
    fn sides_share_out_all_columns_and_there_is_always_a_left_one() {
        for (column, left, right) in [
            (None, 0..30, 30..30),
            (Some(0), 0..0, 0..30),
            (Some(12), 0..12, 12..30),
            (Some(99), 0..30, 30..30),
        ] {
            let [l, r] = wish(column).sides();
            assert_eq!((l.columns, r.columns), (left, right));
        }
        assert!(wish(Some(12)).sides()[1].is_slow() && !wish(Some(30)).sides()[1].is_slow());
        assert!(wish(Some(1)).has_fast_side() && !wish(Some(0)).has_fast_side());
    }

    #[test]
    fn each_column_is_made_by_its_side() {
        let wish = wish(Some(12));
        assert_eq!(wish.settings_at(11).engine, Engine::Fast);
        assert_eq!(wish.settings_at(12).engine, Engine::Report);
    }

    #[test]
    fn columns_of_one_frame_are_laid_over_another_and_what_is_missing_is_black() {
        let frame = Frame {
            width: 3,
            height: 2,
            pixels: vec![1, 2, 3, 4, 5, 6],
        };
        let composed = |columns| {
            let mut pixels = vec![9; 12];
            compose(&mut pixels, 4, Some(&frame), columns);
            pixels
        };
        assert_eq!(composed(0..0), [9; 12]);
        assert_eq!(composed(1..2), [9, 2, 9, 9, 9, 5, 9, 9, 9, 0, 9, 9]);
        assert_eq!(composed(2..9), [9, 9, 3, 0, 9, 9, 6, 0, 9, 9, 0, 0]);
        let mut pixels = [9; 4];
        compose(&mut pixels, 2, None, 1..2);
        assert_eq!(pixels, [9, 0, 9, 0]);
        compose(&mut pixels, 2, Some(&Frame::default()), 0..2);
        assert_eq!(pixels, [0; 4]);
    }
}
