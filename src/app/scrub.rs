//! The bar of frames at the lower border: where it is, and which frame lies where.

/// Height of the bar at scale factor 1.
const HEIGHT_PX: f64 = 28.0;

/// The bar of a window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bar {
    /// Of the window.
    pub width_px: usize,
    /// Its upper border.
    pub top_px: usize,
    /// Its height.
    pub height_px: usize,
    /// The last frame, at least 1.
    pub last: u64,
}

/// The bar as it is to be drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BarWish {
    /// Where.
    pub bar: Bar,
    /// The frame shown.
    pub frame: u64,
    /// A tick for each operation.
    pub frames_per_op: u64,
    /// The frames that are played, or would be if their other end were marked here; `None`: all.
    pub section: Option<(u64, u64)>,
}

impl Bar {
    /// In a window of that size, for frames 0 to `last`.
    #[must_use]
    pub fn new((width, height): (usize, usize), scale_factor: f64, last: u64) -> Bar {
        // A small positive number.
        let height_px = ((HEIGHT_PX * scale_factor) as usize).clamp(1, height);
        Bar {
            width_px: width,
            top_px: height - height_px,
            height_px,
            last,
        }
    }

    /// True when the place, in pixels, lies in the bar.
    #[must_use]
    pub fn contains(&self, (x, y): (f64, f64)) -> bool {
        // A window's size is exact in `f64`.
        let (width, top) = (self.width_px as f64, self.top_px as f64);
        (0.0..width).contains(&x) && y >= top && y < top + self.height_px as f64
    }

    /// The frame at that column, also outside.
    #[must_use]
    pub fn frame_at(&self, x_px: f64) -> u64 {
        let (left, right) = self.ends();
        let part = ((x_px - left) / (right - left).max(1.0)).clamp(0.0, 1.0);
        // Frame numbers of any film that one waits for are exact.
        (part * self.last as f64).round() as u64
    }

    /// The column of a frame.
    #[must_use]
    pub fn x_of(&self, frame: u64) -> f64 {
        let (left, right) = self.ends();
        left + (right - left) * (frame.min(self.last) as f64 / self.last as f64)
    }

    fn ends(&self) -> (f64, f64) {
        let margin = self.height_px as f64 / 2.0;
        (margin, self.width_px as f64 - margin)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_found_where_they_are_drawn() {
        let bar = Bar::new((640, 480), 1.0, 48);
        for frame in 0..=48 {
            assert_eq!(bar.frame_at(bar.x_of(frame)), frame);
        }
        assert_eq!((bar.frame_at(-99.0), bar.frame_at(9999.0)), (0, 48));
    }

    #[test]
    fn it_lies_at_the_lower_border_of_every_window() {
        for size in [(1, 1), (640, 480), (3, 9000)] {
            for scale in [0.1, 1.0, 4.0] {
                let bar = Bar::new(size, scale, 1);
                assert_eq!(bar.top_px + bar.height_px, size.1);
                assert!(bar.contains((0.0, size.1 as f64 - 0.5)));
                assert!(!bar.contains((0.0, size.1 as f64)));
                assert!(bar.frame_at(0.5) <= 1);
            }
        }
    }
}
