//! Text over the picture: figures, key sheet, messages.
//!
//! It is drawn on the copy that goes to the screen, never on the frame, and nothing is drawn unless asked
//! for: the window shows the very bits that files get.

mod canvas;
mod font;

pub use canvas::Canvas;

use canvas::Rect;
use font::Font;

use super::action;
use super::state::OverlayWish;

const WHITE: u32 = 0xff_ffff;
/// Chords, and the names of figures.
const AMBER: u32 = 0xff_c860;
/// Height of the letters at scale factor 1.
const TEXT_PX: f64 = 16.0;
/// Below this letters are no letters.
const MIN_TEXT_PX: u32 = 9;

/// Draws panels of text; keeps what letters look like.
#[derive(Debug)]
pub struct Overlay {
    font: Font,
    scale_factor: f64,
    sheet: Vec<Line>,
}

/// A line in two colours: what it is about, and what it says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Line {
    /// The left column.
    pub name: String,
    /// The right column.
    pub text: String,
}

impl Line {
    /// A line of the two.
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> Line {
        Line {
            name: name.into(),
            text: text.into(),
        }
    }
}

/// Where a panel stands.
#[derive(Clone, Copy, Debug)]
enum Place {
    TopLeft,
    Middle,
    BottomLeft,
}

impl Overlay {
    /// For a screen with that many physical pixels a logical one.
    #[must_use]
    pub fn new(scale_factor: f64) -> Overlay {
        let line = |(chords, says): (String, &'static str)| Line::new(chords, says);
        Overlay {
            font: Font::new(TEXT_PX as u32),
            scale_factor,
            sheet: action::sheet().into_iter().map(line).collect(),
        }
    }

    /// The window moved to a screen with another scale factor.
    pub fn set_scale_factor(&mut self, scale_factor: f64) {
        self.scale_factor = scale_factor;
    }

    /// Draws what `wish` asks for; `statistics` are the figures.
    pub fn draw(&mut self, canvas: &mut Canvas<'_>, wish: &OverlayWish, statistics: &[Line]) {
        // The sheet may need all the room: where it stands there are no figures.
        if wish.sheet {
            let sheet = std::mem::take(&mut self.sheet);
            self.panel(canvas, &sheet, Place::Middle);
            self.sheet = sheet;
        } else if wish.statistics {
            self.panel(canvas, statistics, Place::TopLeft);
        }
        if let Some(message) = &wish.message {
            let lines = [Line::new("", message)];
            self.panel(canvas, &lines, Place::BottomLeft);
        }
    }

    /// Draws lines in the middle, over everything else.
    pub fn board(&mut self, canvas: &mut Canvas<'_>, lines: &[Line]) {
        self.panel(canvas, lines, Place::Middle);
    }

    fn panel(&mut self, canvas: &mut Canvas<'_>, lines: &[Line], place: Place) {
        let layout = self.layout(canvas, lines);
        let rect = layout.place(canvas, place);
        canvas.darken(rect);
        let (cell_width, cell_height) = self.font.cell();
        let x = rect.x + layout.margin;
        let mut y = rect.y + layout.margin;
        for line in lines {
            let text_x = x + layout.name_columns * cell_width;
            self.text(canvas, x, y, &line.name, AMBER);
            self.text(canvas, text_x, y, &line.text, WHITE);
            y += cell_height;
        }
    }

    fn text(&mut self, canvas: &mut Canvas<'_>, x: i32, y: i32, text: &str, color: u32) {
        let (cell_width, _) = self.font.cell();
        let mut x = x;
        for c in text.chars() {
            canvas.glyph(x, y, self.font.glyph(c), color);
            x += cell_width;
        }
    }

    /// Picks the largest size, up to the screen's, at which `lines` fit on the canvas.
    fn layout(&mut self, canvas: &Canvas<'_>, lines: &[Line]) -> Layout {
        // A scale factor is a small positive number.
        let mut size_px = (TEXT_PX * self.scale_factor).round() as u32;
        loop {
            self.font.resize(size_px.max(MIN_TEXT_PX));
            let layout = Layout::of(lines, self.font.cell());
            if self.font.size_px() == MIN_TEXT_PX || layout.fits(canvas) {
                return layout;
            }
            size_px -= 1;
        }
    }
}

/// The measures of a panel, in pixels unless said otherwise.
#[derive(Clone, Copy, Debug)]
struct Layout {
    margin: i32,
    width: i32,
    height: i32,
    /// Letters that the left column takes, with the gap after it.
    name_columns: i32,
}

impl Layout {
    fn of(lines: &[Line], (cell_width, cell_height): (i32, i32)) -> Layout {
        let longest = |of: fn(&Line) -> &String| {
            let letters = lines.iter().map(|l| of(l).chars().count()).max();
            i32::try_from(letters.unwrap_or(0)).unwrap_or(i32::MAX / 4096)
        };
        let name_columns = match longest(|l| &l.name) {
            0 => 0,
            letters => letters + 2,
        };
        let columns = name_columns + longest(|l| &l.text);
        let rows = i32::try_from(lines.len()).unwrap_or(i32::MAX / 4096);
        let margin = cell_width;
        Layout {
            margin,
            width: columns * cell_width + 2 * margin,
            height: rows * cell_height + 2 * margin,
            name_columns,
        }
    }

    fn fits(self, canvas: &Canvas<'_>) -> bool {
        let (width, height) = extent(canvas);
        self.width <= width && self.height <= height
    }

    fn place(self, canvas: &Canvas<'_>, place: Place) -> Rect {
        let (canvas_width, canvas_height) = extent(canvas);
        // What does not fit shows its beginning.
        let (x, y) = match place {
            Place::TopLeft => (0, 0),
            Place::Middle => (
                ((canvas_width - self.width) / 2).max(0),
                ((canvas_height - self.height) / 2).max(0),
            ),
            Place::BottomLeft => (0, (canvas_height - self.height).max(0)),
        };
        Rect {
            x,
            y,
            width: self.width,
            height: self.height,
        }
    }
}

/// The canvas's size in the type of coordinates.
fn extent(canvas: &Canvas<'_>) -> (i32, i32) {
    let int = |n: usize| i32::try_from(n).unwrap_or(i32::MAX);
    (int(canvas.width), int(canvas.height))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn everything() -> OverlayWish {
        OverlayWish {
            statistics: true,
            sheet: true,
            message: Some("saved raybomb-0001.png".into()),
        }
    }

    fn draw(overlay: &mut Overlay, wish: &OverlayWish, width: usize, height: usize) -> Vec<u32> {
        let mut pixels = vec![0xff_ffff; width * height];
        let mut canvas = Canvas {
            pixels: &mut pixels,
            width,
            height,
        };
        overlay.draw(&mut canvas, wish, &[Line::new("fps", "60")]);
        pixels
    }

    #[test]
    fn nothing_asked_for_changes_no_pixel() {
        let pixels = draw(&mut Overlay::new(1.0), &OverlayWish::default(), 320, 200);
        assert!(pixels.iter().all(|&p| p == 0xff_ffff));
    }

    #[test]
    fn every_size_and_scale_factor_is_survived() {
        for scale_factor in [0.5, 1.0, 1.25, 3.0] {
            let mut overlay = Overlay::new(scale_factor);
            for (width, height) in [(1, 1), (1, 500), (500, 1), (70, 40), (1200, 800)] {
                let pixels = draw(&mut overlay, &everything(), width, height);
                assert!(pixels.iter().any(|&p| p != 0xff_ffff));
            }
        }
    }

    #[test]
    fn the_whole_sheet_fits_in_the_default_window() {
        let mut overlay = Overlay::new(1.0);
        let mut pixels = vec![0; 640 * 480];
        let canvas = Canvas {
            pixels: &mut pixels,
            width: 640,
            height: 480,
        };
        let sheet = overlay.sheet.clone();
        assert!(overlay.layout(&canvas, &sheet).fits(&canvas));
    }
}
