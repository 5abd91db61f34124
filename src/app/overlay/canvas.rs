//! Drawing on pixels `0x00RRGGBB`: dark panels and letters. Everything is cut off at the borders.

use super::font::Glyph;

/// The pixels that are about to be presented.
#[derive(Debug)]
pub struct Canvas<'a> {
    /// Rows from top to bottom.
    pub pixels: &'a mut [u32],
    /// Pixels a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

/// A rectangle in pixels; may reach beyond the canvas.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rect {
    /// Left border.
    pub x: i32,
    /// Upper border.
    pub y: i32,
    /// To the right.
    pub width: i32,
    /// Down.
    pub height: i32,
}

impl Rect {
    /// Whether the two have no pixel in common.
    #[must_use]
    pub fn is_apart(&self, other: &Rect) -> bool {
        let before = |first: i32, size: i32, next: i32| first.saturating_add(size) <= next;
        before(self.x, self.width, other.x)
            || before(other.x, other.width, self.x)
            || before(self.y, self.height, other.y)
            || before(other.y, other.height, self.y)
    }
}

impl Canvas<'_> {
    /// Leaves a quarter of the light in `rect`: white letters stand out on whatever is below.
    pub fn darken(&mut self, rect: Rect) {
        let columns = clip(rect.x, rect.width, self.width);
        for y in clip(rect.y, rect.height, self.height) {
            let row = y * self.width;
            for p in &mut self.pixels[row + columns.start..row + columns.end] {
                *p = (*p >> 2) & 0x3f_3f3f;
            }
        }
    }

    /// Fills `rect`.
    pub fn fill(&mut self, rect: Rect, color: u32) {
        let columns = clip(rect.x, rect.width, self.width);
        for y in clip(rect.y, rect.height, self.height) {
            let row = y * self.width;
            self.pixels[row + columns.start..row + columns.end].fill(color);
        }
    }

    /// Draws a line of that thickness with round ends, smooth at its borders.
    pub fn line(&mut self, from: (f64, f64), to: (f64, f64), thickness: f64, color: u32) {
        let (along_x, along_y) = (to.0 - from.0, to.1 - from.1);
        let squared = along_x * along_x + along_y * along_y;
        let reach = thickness / 2.0 + 1.0;
        // Casts saturate.
        let span = |a: f64, b: f64, limit: usize| {
            let first = (a.min(b) - reach).floor() as i32;
            let last = (a.max(b) + reach).ceil() as i32;
            clip(first, last.saturating_sub(first), limit)
        };
        let columns = span(from.0, to.0, self.width);
        let along = 1.0 / squared.max(1e-9);
        // Squared distances of a pixel that is all covered, and of one that is just not.
        let (inner, outer) = ((thickness / 2.0 - 0.5).max(0.0), thickness / 2.0 + 0.5);
        let (inner, outer) = (inner * inner, outer * outer);
        for y in span(from.1, to.1, self.height) {
            for x in columns.clone() {
                let (dx, dy) = (x as f64 + 0.5 - from.0, y as f64 + 0.5 - from.1);
                let part = (dx * along_x + dy * along_y) * along;
                let part = part.clamp(0.0, 1.0);
                let (dx, dy) = (dx - part * along_x, dy - part * along_y);
                let distance = dx * dx + dy * dy;
                // Most pixels of the rectangle lie far from the line.
                if distance >= outer {
                    continue;
                }
                let pixel = &mut self.pixels[y * self.width + x];
                if distance <= inner {
                    *pixel = color;
                } else {
                    let alpha = (thickness / 2.0 + 0.5 - distance.sqrt()).clamp(0.0, 1.0) * 255.0;
                    *pixel = mix(*pixel, color, alpha.round() as u8);
                }
            }
        }
    }

    /// Leaves `part` of 256 of all light.
    pub fn fade(&mut self, part: u32) {
        for pixel in self.pixels.iter_mut() {
            let channels = |mask: u32| ((*pixel & mask) * part.min(256)) >> 8 & mask;
            let green = ((*pixel >> 8 & 0xff) * part.min(256)) & 0xff00;
            *pixel = channels(0xff_00ff) | green;
        }
    }

    /// Lays `color` over the pixels where the glyph is, its corner at (`x`, `y`).
    pub fn glyph(&mut self, x: i32, y: i32, glyph: &Glyph, color: u32) {
        let (x, y) = (x + glyph.left, y + glyph.top);
        let columns = clip(x, glyph.width, self.width);
        if columns.is_empty() {
            return;
        }
        for py in clip(y, glyph.height, self.height) {
            // Inside the glyph by the clipping, so not negative.
            let from = (py as i32 - y) * glyph.width + (columns.start as i32 - x);
            let coverage = &glyph.coverage[from as usize..][..columns.len()];
            let row = &mut self.pixels[py * self.width..][columns.clone()];
            for (p, &alpha) in row.iter_mut().zip(coverage) {
                *p = mix(*p, color, alpha);
            }
        }
    }
}

/// The part of `start..start + length` that lies in `0..limit`.
fn clip(start: i32, length: i32, limit: usize) -> std::ops::Range<usize> {
    let limit = i32::try_from(limit).unwrap_or(i32::MAX);
    let end = start.saturating_add(length).clamp(0, limit);
    // Both lie in 0..=limit.
    start.clamp(0, end) as usize..end as usize
}

/// `alpha`/255 of `top` over `bottom`, two channels at a time.
fn mix(bottom: u32, top: u32, alpha: u8) -> u32 {
    // 0..=256, so that the division is a shift.
    let a = u32::from(alpha) + u32::from(alpha >> 7);
    let channels = |mask: u32| ((bottom & mask) * (256 - a) + (top & mask) * a) >> 8 & mask;
    let green = ((bottom >> 8 & 0xff) * (256 - a) + (top >> 8 & 0xff) * a) & 0xff00;
    channels(0xff_00ff) | green
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mixing_ends_exactly_on_both_colours() {
        for c in [0x000000, 0xffffff, 0x123456, 0xff00ff, 0x00ff00] {
            assert_eq!(mix(c, 0xabcdef, 0), c);
            assert_eq!(mix(c, 0xabcdef, 255), 0xabcdef);
        }
    }

    #[test]
    fn lines_are_smooth_and_cut_off_at_every_border() {
        let mut pixels = vec![0; 40 * 30];
        let mut canvas = Canvas {
            pixels: &mut pixels,
            width: 40,
            height: 30,
        };
        canvas.line((-500.0, 10.0), (500.0, 10.0), 2.0, 0xff_ffff);
        canvas.line((5.0, 20.0), (30.0, 27.0), 2.0, 0xff_0000);
        canvas.line((f64::NAN, 0.0), (1e300, -1e300), 2.0, 0xff_ffff);
        let row = |y: usize| &pixels[y * 40..][..40];
        assert!(row(9).iter().chain(row(10)).all(|&p| p == 0xff_ffff));
        assert!(row(8).iter().chain(row(11)).all(|&p| p == 0));
        let reds = pixels[20 * 40..]
            .iter()
            .filter(|p| (1..255).contains(&(**p >> 16)));
        assert!(reds.count() > 10, "no smooth border");
    }

    #[test]
    fn fading_ends_exactly_at_both_ends() {
        for (part, expected) in [(256, [0x12_3456, 0xff_ffff]), (0, [0, 0])] {
            let mut pixels = [0x12_3456, 0xff_ffff];
            let mut canvas = Canvas {
                pixels: &mut pixels,
                width: 2,
                height: 1,
            };
            canvas.fade(part);
            assert_eq!(pixels, expected);
        }
    }

    #[test]
    fn what_lies_outside_is_cut_off() {
        let mut pixels = vec![0xffffff; 6];
        let mut canvas = Canvas {
            pixels: &mut pixels,
            width: 3,
            height: 2,
        };
        let rect = |x, y, width, height| Rect {
            x,
            y,
            width,
            height,
        };
        canvas.darken(rect(10, 10, 5, 5));
        canvas.darken(rect(-9, 0, 5, 5));
        canvas.darken(rect(0, 0, -1, 5));
        assert!(canvas.pixels.iter().all(|&p| p == 0xffffff));
        canvas.darken(rect(-1, 1, 3, i32::MAX));
        let dark = 0x3f3f3f;
        assert_eq!(pixels[3..], [dark, dark, 0xffffff]);
    }

    #[test]
    fn glyphs_are_cut_off_at_every_border() {
        let glyph = Glyph {
            left: 0,
            top: 0,
            width: 2,
            height: 2,
            coverage: vec![255; 4],
        };
        for (x, y, touched) in [(-1, -1, 1), (2, 1, 1), (0, -1, 2), (5, 5, 0), (-5, 0, 0)] {
            let mut pixels = vec![0; 6];
            let mut canvas = Canvas {
                pixels: &mut pixels,
                width: 3,
                height: 2,
            };
            canvas.glyph(x, y, &glyph, 0xffffff);
            let count = pixels.iter().filter(|&&p| p != 0).count();
            assert_eq!(count, touched, "at {x}, {y}");
        }
    }
}
