//! Letters as small grey pictures: each is drawn once a size, at whole pixels, and kept. A window has few sizes.

use std::collections::BTreeMap;

use ab_glyph::{Font as _, FontRef, PxScale, ScaleFont, point};

/// A letter as coverage.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Glyph {
    /// Pixels from the cell's left border.
    pub left: i32,
    /// Pixels from the cell's upper border.
    pub top: i32,
    /// Pixels a row.
    pub width: i32,
    /// Rows.
    pub height: i32,
    /// How much is covered, 0 to 256, of eight pixels of a row. The last ones of a row may lie beyond the letter.
    pub octets: Vec<[u16; 8]>,
}

impl Glyph {
    /// Row `y` of [`Glyph::octets`].
    #[must_use]
    pub fn row(&self, y: usize) -> &[[u16; 8]] {
        let length = self.octets_a_row();
        &self.octets[y * length..][..length]
    }

    fn octets_a_row(&self) -> usize {
        // A letter has a small positive width.
        (self.width as usize).div_ceil(8)
    }
}

/// The Hack font at one size. All letters have the same width.
#[derive(Debug)]
pub struct Font {
    font: FontRef<'static>,
    size_px: u32,
    sizes: BTreeMap<u32, Letters>,
}

/// What letters of one size look like: those of ASCII, which are found at once, and others.
#[derive(Debug, Default)]
struct Letters {
    ascii: Vec<Option<Glyph>>,
    others: BTreeMap<char, Option<Glyph>>,
}

impl Letters {
    /// The place for the picture of `c`.
    fn place(&mut self, c: char) -> &mut Option<Glyph> {
        if !c.is_ascii() {
            return self.others.entry(c).or_default();
        }
        self.ascii.resize(128, None);
        &mut self.ascii[c as usize]
    }
}

impl Font {
    /// The font at `size_px` pixels from the top of the tallest letter to the bottom of the lowest.
    #[must_use]
    pub fn new(size_px: u32) -> Font {
        let font = FontRef::try_from_slice(epaint_default_fonts::HACK_REGULAR)
            .expect("the built-in font is a font");
        Font {
            font,
            size_px,
            sizes: BTreeMap::new(),
        }
    }

    /// Changes the size. Letters of the others are kept: one picture has panels of several sizes.
    pub fn resize(&mut self, size_px: u32) {
        self.size_px = size_px;
    }

    /// Width of a letter and height of a line, in pixels.
    #[must_use]
    pub fn cell(&self) -> (i32, i32) {
        self.cell_of(self.size_px)
    }

    /// The same at another size.
    #[must_use]
    pub fn cell_of(&self, size_px: u32) -> (i32, i32) {
        let scaled = self.font.as_scaled(scale_of(size_px));
        let advance = scaled.h_advance(self.font.glyph_id('0'));
        // Small positive numbers.
        (
            advance.round() as i32,
            (scaled.height() * 1.15).round() as i32,
        )
    }

    /// The picture of `c`; empty for a blank.
    pub fn glyph(&mut self, c: char) -> &Glyph {
        let (font, size_px) = (&self.font, self.size_px);
        let place = self.sizes.entry(size_px).or_default().place(c);
        place.get_or_insert_with(|| draw(font, size_px, c))
    }
}

fn draw(font: &FontRef<'_>, size_px: u32, c: char) -> Glyph {
    let baseline = font.as_scaled(scale_of(size_px)).ascent().round();
    let placed = font
        .glyph_id(c)
        .with_scale_and_position(scale_of(size_px), point(0.0, baseline));
    let Some(outline) = font.outline_glyph(placed) else {
        return Glyph::default();
    };
    let bounds = outline.px_bounds();
    let mut glyph = Glyph {
        left: bounds.min.x as i32,
        top: bounds.min.y as i32,
        width: bounds.width() as i32,
        height: bounds.height() as i32,
        octets: Vec::new(),
    };
    let row = glyph.octets_a_row();
    // Its height is small and positive, too.
    glyph.octets.resize(row * glyph.height as usize, [0; 8]);
    outline.draw(|x, y, coverage| {
        // x and y lie inside the bounds; the cast saturates.
        let (x, y) = (x as usize, y as usize);
        glyph.octets[y * row + x / 8][x % 8] = (coverage.min(1.0) * 256.0).round() as u16;
    });
    glyph
}

fn scale_of(size_px: u32) -> PxScale {
    // A few dozen pixels: exact.
    PxScale::from(size_px as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_have_ink_and_blanks_have_none() {
        let mut font = Font::new(16);
        assert!(font.glyph('M').octets.iter().flatten().any(|&a| a > 200));
        assert!(font.glyph(' ').octets.is_empty());
        let (width, height) = font.cell();
        assert!(width >= 6 && height > width);
    }

    #[test]
    fn letters_of_every_size_are_drawn_once() {
        let mut font = Font::new(12);
        let small = font.glyph('g').clone();
        font.resize(24);
        assert!(font.glyph('g').height > small.height);
        font.resize(12);
        assert!(font.sizes.get_mut(&12).expect("kept").place('g').is_some());
        assert_eq!(*font.glyph('g'), small);
    }
}
