//! Letters as small grey pictures: each is drawn once a size, at whole pixels, and kept. A window has few sizes.

use std::collections::HashMap;

use ab_glyph::{Font as _, FontRef, PxScale, ScaleFont, point};

/// A letter as coverage, 0 to 255.
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
    /// `width * height` values.
    pub coverage: Vec<u8>,
}

/// The Hack font at one size. All letters have the same width.
#[derive(Debug)]
pub struct Font {
    font: FontRef<'static>,
    size_px: u32,
    glyphs: HashMap<(u32, char), Glyph>,
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
            glyphs: HashMap::new(),
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
        let glyph = self.glyphs.entry((size_px, c));
        glyph.or_insert_with(|| draw(font, size_px, c))
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
        coverage: Vec::new(),
    };
    let pixels = usize::try_from(glyph.width * glyph.height).unwrap_or(0);
    glyph.coverage.resize(pixels, 0);
    outline.draw(|x, y, coverage| {
        // x and y lie inside the bounds; the cast saturates.
        glyph.coverage[(y as i32 * glyph.width + x as i32) as usize] =
            (coverage * 255.0).round() as u8;
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
        assert!(font.glyph('M').coverage.iter().any(|&c| c > 200));
        assert!(font.glyph(' ').coverage.is_empty());
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
        assert!(font.glyphs.contains_key(&(12, 'g')));
        assert_eq!(*font.glyph('g'), small);
    }
}
