//! Drawing over a picture that is on its way to the window: dark panels and letters. Everything is cut off at the borders.

use std::array;
use std::ops::Range;

use super::font::Glyph;
use crate::frame::Frame;

/// The pixels `0x00RRGGBB` that are about to be presented.
///
/// Rows of the picture are copied when something is drawn on them, the rest at the end: what is darkened is so on its
/// way, and a panel over half of the window costs little more than the picture below.
#[derive(Debug)]
pub struct Canvas<'a> {
    /// Pixels a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Rows from top to bottom.
    pixels: &'a mut [u32],
    /// What is below.
    picture: Picture<'a>,
    /// For each row, whether it is still to be copied.
    is_bare: Vec<bool>,
}

/// A frame (none: black), each of its pixels as a square. One of another size than the canvas is cut off, or stands on
/// black, at the upper left.
#[derive(Debug)]
struct Picture<'a> {
    frame: Option<&'a Frame>,
    pixel_size: usize,
    /// The frame's row that was enlarged last, and what it became.
    enlarged: (usize, Vec<u32>),
}

impl<'a> Picture<'a> {
    /// Its pixels, if they lie in memory as those of a canvas of that size do.
    fn like(&self, width: usize, height: usize) -> Option<&'a [u32]> {
        let frame = self.frame?;
        let is_like = self.pixel_size == 1 && (frame.width, frame.height) == (width, height);
        is_like.then_some(&frame.pixels[..])
    }

    /// Row `y` as far as the frame goes, at most `width` pixels.
    fn row(&mut self, y: usize, width: usize) -> &[u32] {
        let Some(frame) = self.frame else {
            return &[];
        };
        let row = y / self.pixel_size;
        if row >= frame.height {
            return &[];
        }
        let from = &frame.pixels[row * frame.width..][..frame.width];
        if self.pixel_size == 1 {
            return &from[..frame.width.min(width)];
        }
        let (of, enlarged) = &mut self.enlarged;
        if *of != row {
            *of = row;
            enlarged.resize(width.min(frame.width * self.pixel_size), 0);
            for (square, &pixel) in enlarged.chunks_mut(self.pixel_size).zip(from) {
                square.fill(pixel);
            }
        }
        enlarged
    }
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
    /// The rows of it from `top` to `bottom`.
    #[must_use]
    pub fn between(self, top: i32, bottom: i32) -> Rect {
        Rect {
            y: top,
            height: bottom - top,
            ..self
        }
    }

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

impl<'a> Canvas<'a> {
    /// `pixels` in rows of `width`, to be covered by `frame` in squares of `pixel_size`, and by what is drawn over it.
    pub fn over(
        frame: Option<&'a Frame>,
        pixel_size: usize,
        pixels: &'a mut [u32],
        width: usize,
    ) -> Canvas<'a> {
        let height = pixels.len() / width.max(1);
        Canvas {
            width,
            height,
            pixels,
            picture: Picture {
                frame: frame.filter(|f| f.width > 0),
                pixel_size,
                enlarged: (usize::MAX, Vec::new()),
            },
            is_bare: vec![true; height],
        }
    }

    /// All pixels, after copying what is not copied yet.
    pub fn pixels(&mut self) -> &mut [u32] {
        self.cover(0..self.height);
        self.pixels
    }

    /// Copies those of the rows that are not copied yet.
    fn cover(&mut self, rows: Range<usize>) {
        for y in rows {
            if std::mem::take(&mut self.is_bare[y]) {
                let to = &mut self.pixels[y * self.width..][..self.width];
                lay(self.picture.row(y, self.width), to, 0..0);
            }
        }
    }

    /// Leaves a quarter of the light in `rect`: white letters stand out on whatever is below.
    #[inline(always)]
    pub fn darken(&mut self, rect: Rect) {
        let columns = clip(rect.x, rect.width, self.width);
        for y in clip(rect.y, rect.height, self.height) {
            let to = &mut self.pixels[y * self.width..][..self.width];
            if std::mem::take(&mut self.is_bare[y]) {
                lay(self.picture.row(y, self.width), to, columns.clone());
            } else {
                to[columns.clone()].iter_mut().for_each(|p| *p = dark(*p));
            }
        }
    }

    /// Lays `stamp` over what is there, its upper left pixel at (`x`, `y`).
    pub fn stamp(&mut self, (x, y): (i32, i32), stamp: &Frame) {
        let size = |n: usize| i32::try_from(n).unwrap_or(i32::MAX);
        let columns = clip(x, size(stamp.width), self.width);
        let rows = clip(y, size(stamp.height), self.height);
        if columns.is_empty() {
            return;
        }
        let are_bare = self.is_bare[rows.clone()].iter().all(|&bare| bare);
        let below = self.picture.like(self.width, self.height);
        let below = below.filter(|_| are_bare);
        if below.is_some() {
            self.is_bare[rows.clone()].fill(false);
        } else {
            self.cover(rows.clone());
        }
        // From the stamp's end in a row to its start in the next is one copy: copies start slowly.
        let mut copied = rows.start * self.width;
        let mut copy_up_to = |end: usize, pixels: &mut [u32]| {
            if let Some(below) = below {
                pixels[copied..end].copy_from_slice(&below[copied..end]);
            }
            copied = end + columns.len();
        };
        for row in rows.clone() {
            let start = row * self.width + columns.start;
            copy_up_to(start, self.pixels);
            // Inside the stamp by the clipping, so not negative.
            let [dx, dy] = [(columns.start, x), (row, y)].map(|(a, b)| (a as i32 - b) as usize);
            let stamped = &stamp.pixels[dy * stamp.width + dx..][..columns.len()];
            self.pixels[start..][..columns.len()].copy_from_slice(stamped);
        }
        copy_up_to(rows.end * self.width, self.pixels);
    }

    /// Fills `rect`.
    pub fn fill(&mut self, rect: Rect, color: u32) {
        let columns = clip(rect.x, rect.width, self.width);
        let rows = clip(rect.y, rect.height, self.height);
        self.cover(rows.clone());
        for y in rows {
            self.pixels[y * self.width..][columns.clone()].fill(color);
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
        let rows = span(from.1, to.1, self.height);
        self.cover(rows.clone());
        for y in rows {
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
                    let alpha = (thickness / 2.0 + 0.5 - distance.sqrt()).clamp(0.0, 1.0) * 256.0;
                    let alpha = [alpha.round() as u16; 8];
                    *pixel = mix([*pixel; 8], lanes([color; 8]), alpha)[0];
                }
            }
        }
    }

    /// Leaves `part` of 256 of all light.
    pub fn fade(&mut self, part: u32) {
        for pixel in self.pixels() {
            let channels = |mask: u32| ((*pixel & mask) * part.min(256)) >> 8 & mask;
            let green = ((*pixel >> 8 & 0xff) * part.min(256)) & 0xff00;
            *pixel = channels(0xff_00ff) | green;
        }
    }

    /// Lays `color` over the pixels where the glyph is, its corner at (`x`, `y`).
    #[inline(always)]
    pub fn glyph(&mut self, x: i32, y: i32, glyph: &Glyph, color: u32) {
        let (x, y) = (x + glyph.left, y + glyph.top);
        let columns = clip(x, glyph.width, self.width);
        let rows = clip(y, glyph.height, self.height);
        let color = lanes([color; 8]);
        for py in rows {
            if self.is_bare[py] {
                self.cover(py..py + 1);
            }
            let row = &mut self.pixels[py * self.width..][..self.width];
            // Inside the glyph by the clipping, so not negative.
            let octets = glyph.row((py as i32 - y) as usize);
            let place = usize::try_from(x).ok();
            let place = place.and_then(|x| row.get_mut(x..x + 8 * octets.len()));
            if let Some(place) = place {
                let (place, _) = place.as_chunks_mut();
                for (pixels, octet) in place.iter_mut().zip(octets) {
                    *pixels = mix(*pixels, color, *octet);
                }
                continue;
            }
            for px in columns.clone() {
                let i = (px as i32 - x) as usize;
                row[px] = mix([row[px]; 8], color, octets[i / 8])[i % 8];
            }
        }
    }
}

/// Copies a row of a picture, on black where it is shorter, and darkens some columns.
#[inline(always)]
fn lay(from: &[u32], to: &mut [u32], darkened: Range<usize>) {
    let (covered, rest) = to.split_at_mut(from.len());
    // Mostly there is none, and a call for nothing has its price.
    if !rest.is_empty() {
        rest.fill(0);
    }
    let [start, end] = [darkened.start, darkened.end].map(|column| column.min(from.len()));
    if start == end {
        return covered.copy_from_slice(from);
    }
    let (left, others) = covered.split_at_mut(start);
    let (middle, right) = others.split_at_mut(end - start);
    // The mask keeps the loops from becoming calls: three short copies take longer than the whole row.
    let mask = |pixel: u32| pixel & 0xff_ffff;
    each(left, &from[..start], mask);
    each(middle, &from[start..end], dark);
    each(right, &from[end..], mask);
}

/// Writes what `change` makes of each pixel.
#[inline(always)]
fn each(to: &mut [u32], from: &[u32], change: impl Fn(u32) -> u32) {
    to.iter_mut()
        .zip(from)
        .for_each(|(to, from)| *to = change(*from));
}

/// A quarter of the light.
#[inline(always)]
fn dark(pixel: u32) -> u32 {
    pixel >> 2 & 0x3f_3f3f
}

/// The part of `start..start + length` that lies in `0..limit`.
fn clip(start: i32, length: i32, limit: usize) -> Range<usize> {
    let limit = i32::try_from(limit).unwrap_or(i32::MAX);
    let end = start.saturating_add(length).clamp(0, limit);
    // Both lie in 0..=limit.
    start.clamp(0, end) as usize..end as usize
}

/// `alpha`/256 of `top` over `bottom`, in lanes of two channels: compilers make vectors of it.
#[inline(always)]
fn mix(bottom: [u32; 8], top: [u16; 16], alpha: [u16; 8]) -> [u32; 8] {
    let bottom = lanes(bottom);
    let mut mixed = [0; 16];
    for i in 0..16 {
        let (a, rest) = (alpha[i / 2], 256 - alpha[i / 2]);
        let sum = |bottom: u16, top: u16| bottom * rest + top * a;
        let low = sum(bottom[i] & 0xff, top[i] & 0xff) >> 8;
        mixed[i] = low | sum(bottom[i] >> 8, top[i] >> 8) & 0xff00;
    }
    array::from_fn(|i| u32::from(mixed[2 * i]) | u32::from(mixed[2 * i + 1]) << 16)
}

/// The halves of eight pixels.
#[inline(always)]
fn lanes(pixels: [u32; 8]) -> [u16; 16] {
    array::from_fn(|i| (pixels[i / 2] >> (16 * (i % 2))) as u16)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mixing_ends_exactly_on_both_colours_and_keeps_channels_apart() {
        let top = 0xab_cdef;
        for c in [0x000000, 0xffffff, 0x123456, 0xff00ff, 0x00ff00] {
            for alpha in 0..=256 {
                let a = u32::from(alpha);
                let channel = |shift: u32| {
                    let of = |pixel: u32| pixel >> shift & 0xff;
                    (of(c) * (256 - a) + of(top) * a) >> 8 << shift
                };
                let each = channel(0) | channel(8) | channel(16);
                let mixed = mix([c, 0, c, 0, c, 0, 0, c], lanes([top; 8]), [alpha; 8]);
                assert_eq!([0, 2, 4, 7].map(|i| mixed[i]), [each; 4]);
            }
            assert_eq!(mix([c; 8], lanes([top; 8]), [0; 8]), [c; 8]);
            assert_eq!(mix([c; 8], lanes([top; 8]), [256; 8]), [top; 8]);
        }
    }

    #[test]
    fn lines_are_smooth_and_cut_off_at_every_border() {
        let mut pixels = vec![0; 40 * 30];
        let mut canvas = Canvas::over(None, 1, &mut pixels, 40);
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

    fn frame(width: usize, pixels: &[u32]) -> Frame {
        Frame {
            width,
            height: pixels.len() / width,
            pixels: pixels.to_vec(),
        }
    }

    #[test]
    fn fading_ends_exactly_at_both_ends() {
        let white = frame(2, &[0x12_3456, 0xff_ffff]);
        for (part, expected) in [(256, [0x12_3456, 0xff_ffff]), (0, [0, 0])] {
            let mut pixels = [7; 2];
            Canvas::over(Some(&white), 1, &mut pixels, 2).fade(part);
            assert_eq!(pixels, expected);
        }
    }

    fn enlarged(frame: Option<&Frame>, pixel_size: usize, width: usize, height: usize) -> Vec<u32> {
        let mut pixels = vec![9; width * height];
        Canvas::over(frame, pixel_size, &mut pixels, width).pixels();
        pixels
    }

    #[test]
    fn frames_of_another_size_are_cut_off_or_stand_on_black() {
        let frame = frame(2, &[1, 2, 3, 4]);
        assert_eq!(enlarged(Some(&frame), 1, 2, 2), [1, 2, 3, 4]);
        assert_eq!(enlarged(Some(&frame), 1, 1, 3), [1, 3, 0]);
        assert_eq!(enlarged(Some(&frame), 1, 3, 1), [1, 2, 0]);
        assert_eq!(enlarged(None, 1, 2, 1), [0, 0]);
        assert_eq!(enlarged(Some(&Frame::default()), 1, 1, 1), [0]);
    }

    #[test]
    fn coarse_pixels_become_squares_that_are_cut_off_at_the_window() {
        let frame = frame(2, &[1, 2, 3, 4]);
        let shown = enlarged(Some(&frame), 2, 3, 3);
        assert_eq!(shown, [1, 1, 2, 1, 1, 2, 3, 3, 4]);
        assert_eq!(enlarged(Some(&frame), 3, 2, 1), [1, 1]);
        let wide = enlarged(Some(&frame), 2, 5, 1);
        assert_eq!(wide, [1, 1, 2, 2, 0]);
    }

    #[test]
    fn what_lies_outside_is_cut_off() {
        let white = frame(3, &[0xff_ffff; 6]);
        let rect = |x, y, width, height| Rect {
            x,
            y,
            width,
            height,
        };
        let dark = 0x3f_3f3f;
        // Rows that are copied before, and rows that are not.
        for is_covered in [false, true] {
            let mut pixels = vec![7; 6];
            let mut canvas = Canvas::over(Some(&white), 1, &mut pixels, 3);
            if is_covered {
                canvas.pixels();
            }
            canvas.darken(rect(10, 10, 5, 5));
            canvas.darken(rect(-9, 0, 5, 5));
            canvas.darken(rect(0, 0, -1, 5));
            assert!(canvas.pixels().iter().all(|&p| p == 0xff_ffff));
            canvas.darken(rect(-1, 1, 3, i32::MAX));
            assert_eq!(pixels[3..], [dark, dark, 0xff_ffff]);
        }
    }

    #[test]
    fn stamps_lie_over_the_picture_and_are_cut_off_at_every_border() {
        let pictures = [
            frame(4, &(1..=12).collect::<Vec<u32>>()),
            frame(3, &(1..=12).collect::<Vec<u32>>()),
            frame(2, &[1, 2, 3, 4]),
        ];
        let stamp = frame(2, &[50, 60, 70, 80]);
        for (picture, pixel_size) in pictures.iter().zip([1, 1, 2]) {
            let bare = enlarged(Some(picture), pixel_size, 4, 3);
            for (x, y) in (-3..6).flat_map(|x| (-3..5).map(move |y| (x, y))) {
                // No row, one, or all are copied before.
                for covered in [0, 1, 3] {
                    let mut pixels = vec![9; 12];
                    let mut canvas = Canvas::over(Some(picture), pixel_size, &mut pixels, 4);
                    canvas.cover(0..covered);
                    canvas.stamp((x, y), &stamp);
                    canvas.pixels();
                    let expected = |i: i32| {
                        let (column, row) = (i % 4 - x, i / 4 - y);
                        let is_stamped = (0..2).contains(&column) && (0..2).contains(&row);
                        match is_stamped {
                            true => stamp.pixels[(row * 2 + column) as usize],
                            false => bare[i as usize],
                        }
                    };
                    assert_eq!(pixels, (0..12).map(expected).collect::<Vec<u32>>());
                }
            }
        }
    }

    #[test]
    fn what_is_drawn_lies_over_the_picture_whatever_comes_first() {
        let picture = frame(3, &[0x10_0000, 0x20_0000, 0x30_0000]);
        let (mut pixels, mut expected) = (vec![7; 9 * 9], vec![7; 9 * 9]);
        let glyph = Glyph {
            width: 1,
            height: 1,
            octets: vec![[256, 0, 0, 0, 0, 0, 0, 0]],
            ..Glyph::default()
        };
        let rect = |x, y| Rect {
            x,
            y,
            width: 3,
            height: 3,
        };
        let draw = |canvas: &mut Canvas<'_>| {
            canvas.glyph(8, 8, &glyph, 0x55_5555);
            canvas.darken(rect(1, 1));
            canvas.fill(rect(2, 2), 0x99_9999);
            canvas.darken(rect(4, 3));
            canvas.glyph(4, 2, &glyph, 0x77_7777);
            canvas.line((0.0, 7.0), (5.0, 7.0), 2.0, 0x44_4444);
            canvas.pixels();
        };
        draw(&mut Canvas::over(Some(&picture), 3, &mut pixels, 9));
        let mut canvas = Canvas::over(Some(&picture), 3, &mut expected, 9);
        canvas.pixels();
        draw(&mut canvas);
        assert_eq!(pixels, expected);
        assert!(
            [0x04_0000, 0x26_2626, 0x77_7777, 0x10_0000]
                .iter()
                .all(|p| pixels.contains(p))
        );
    }

    #[test]
    fn glyphs_are_cut_off_at_every_border() {
        let glyph = Glyph {
            width: 2,
            height: 2,
            octets: vec![[256, 256, 0, 0, 0, 0, 0, 0]; 2],
            ..Glyph::default()
        };
        for (x, y, touched) in [(-1, -1, 1), (2, 1, 1), (0, -1, 2), (5, 5, 0), (-5, 0, 0)] {
            let mut pixels = vec![7; 6];
            let mut canvas = Canvas::over(None, 1, &mut pixels, 3);
            canvas.glyph(x, y, &glyph, 0xff_ffff);
            let count = canvas.pixels().iter().filter(|&&p| p != 0).count();
            assert_eq!(count, touched, "at {x}, {y}");
        }
    }
}
