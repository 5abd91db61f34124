//! Over the picture: figures, key sheet, picks, questions, messages, and the bar of frames.
//!
//! It is drawn on the copy that goes to the screen, never on the frame, and nothing is drawn unless asked
//! for: the window shows the very bits that files get.

mod canvas;
mod font;

pub use canvas::Canvas;

use canvas::Rect;
use font::Font;

use super::keymap::Keymap;
use super::scrub::BarWish;
use super::state::OverlayWish;

const WHITE: u32 = 0xff_ffff;
/// Chords, and the names of figures.
const AMBER: u32 = 0xff_c860;
/// Says that moves are recorded.
const RECORDING: &str = "recording";
const RED: u32 = 0xff_4030;
const GREY: u32 = 0x80_8080;
/// Height of the letters at scale factor 1.
const TEXT_PX: f64 = 16.0;
/// Below this letters are no letters.
const MIN_TEXT_PX: u32 = 9;

/// Draws panels of text; keeps what letters look like.
#[derive(Debug)]
pub struct Overlay {
    font: Font,
    scale_factor: f64,
    /// Its first line is for a message.
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
    TopRight,
    Middle,
    /// That many pixels above the lower border.
    BottomLeft(i32),
}

impl Overlay {
    /// For a screen with that many physical pixels a logical one, and the sheet of these keys.
    #[must_use]
    pub fn new(scale_factor: f64, keymap: &Keymap) -> Overlay {
        let line = |(chords, says): (String, &'static str)| Line::new(chords, says);
        Overlay {
            font: Font::new(TEXT_PX as u32),
            scale_factor,
            sheet: std::iter::once(Line::new("", ""))
                .chain(keymap.sheet().into_iter().map(line))
                .collect(),
        }
    }

    /// The window moved to a screen with another scale factor.
    pub fn set_scale_factor(&mut self, scale_factor: f64) {
        self.scale_factor = scale_factor;
    }

    /// Draws what `wish` asks for; `statistics` are the figures.
    pub fn draw(&mut self, canvas: &mut Canvas<'_>, wish: &OverlayWish, statistics: &[Line]) {
        // The sheet may need all the room: where it stands there is nothing else.
        if wish.sheet {
            let mut sheet = std::mem::take(&mut self.sheet);
            sheet[0].text = wish.message.clone().unwrap_or_default();
            self.panel(canvas, &sheet, Place::Middle);
            self.sheet = sheet;
        } else {
            if wish.statistics {
                self.panel(canvas, statistics, Place::TopLeft);
            }
            for &place in &wish.marks {
                self.mark(canvas, place);
            }
            let recording = wish.recording.then(|| Line::new(RECORDING, ""));
            let picked = wish.picked.iter().map(|(name, text)| Line::new(name, text));
            let right: Vec<Line> = recording.into_iter().chain(picked).collect();
            if !right.is_empty() {
                self.panel(canvas, &right, Place::TopRight);
            }
        }
        let bar = wish.bar.as_ref().filter(|_| !wish.sheet);
        if let Some(bar) = bar {
            draw_bar(canvas, bar);
        }
        if let Some(question) = &wish.question {
            self.panel(canvas, &[Line::new("", question)], Place::Middle);
        }
        if let Some(message) = wish.message.as_ref().filter(|_| !wish.sheet) {
            let lines = [Line::new("", message)];
            // A window's height, and less.
            let above = bar.map_or(0, |b| b.bar.height_px as i32);
            self.panel(canvas, &lines, Place::BottomLeft(above));
        }
    }

    /// A cross with a dark rim: seen on any colour.
    fn mark(&self, canvas: &mut Canvas<'_>, (x, y): (i32, i32)) {
        // A scale factor is a small positive number.
        let arm = (5.0 * self.scale_factor).ceil() as i32;
        for (rim, color) in [(1, 0), (0, AMBER)] {
            for (across, along) in [(rim, arm + rim), (arm + rim, rim)] {
                let rect = Rect {
                    x: x.saturating_sub(across),
                    y: y.saturating_sub(along),
                    width: 2 * across + 1,
                    height: 2 * along + 1,
                };
                canvas.fill(rect, color);
            }
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
            let color = if line.name == RECORDING { RED } else { AMBER };
            self.text(canvas, x, y, &line.name, color);
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

/// Draws the bar of frames: a line, a tick for each operation, what is played in amber, a handle at the frame.
fn draw_bar(canvas: &mut Canvas<'_>, wish: &BarWish) {
    let bar = wish.bar;
    // All lie in the window, whose size fits.
    let (top, height) = (bar.top_px as i32, bar.height_px as i32);
    canvas.darken(Rect {
        x: 0,
        y: top,
        width: bar.width_px as i32,
        height,
    });
    let thick = (height / 9).max(1);
    let x_of = |frame: u64| bar.x_of(frame).round() as i32;
    let mut block = |from: i32, to: i32, tall: i32, color: u32| {
        let rect = Rect {
            x: from,
            y: top + (height - tall) / 2,
            width: to - from,
            height: tall,
        };
        canvas.fill(rect, color);
    };
    let (first, last) = wish.section.unwrap_or((0, bar.last));
    block(x_of(0), x_of(bar.last), thick, GREY);
    block(x_of(first), x_of(last), thick, AMBER);
    let ticks = bar.last / wish.frames_per_op.max(1);
    // Ticks that would touch are no ticks.
    if ticks * 3 <= bar.width_px as u64 {
        for i in 0..=ticks {
            let x = x_of(i * wish.frames_per_op);
            block(x, x + thick.min(2), height / 2, GREY);
        }
    }
    let x = x_of(wish.frame);
    block(x - thick, x + thick, height * 3 / 4, WHITE);
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
            Place::TopRight => ((canvas_width - self.width).max(0), 0),
            Place::Middle => (
                ((canvas_width - self.width) / 2).max(0),
                ((canvas_height - self.height) / 2).max(0),
            ),
            Place::BottomLeft(above) => (0, (canvas_height - above - self.height).max(0)),
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
    use crate::app::scrub::Bar;

    fn overlay(scale_factor: f64) -> Overlay {
        Overlay::new(scale_factor, &Keymap::default())
    }

    fn everything() -> OverlayWish {
        OverlayWish {
            statistics: true,
            sheet: true,
            picked: vec![("triangle".into(), "7".into())],
            marks: vec![(0, 0), (i32::MIN, i32::MAX)],
            recording: true,
            bar: Some(BarWish {
                bar: Bar::new((70, 40), 1.0, 48),
                frame: 20,
                frames_per_op: 16,
                section: Some((3, 30)),
            }),
            question: Some("really?".into()),
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
        let pixels = draw(&mut overlay(1.0), &OverlayWish::default(), 320, 200);
        assert!(pixels.iter().all(|&p| p == 0xff_ffff));
    }

    #[test]
    fn every_size_and_scale_factor_is_survived() {
        for scale_factor in [0.5, 1.0, 1.25, 3.0] {
            let mut overlay = overlay(scale_factor);
            for (width, height) in [(1, 1), (1, 500), (500, 1), (70, 40), (1200, 800)] {
                let pixels = draw(&mut overlay, &everything(), width, height);
                assert!(pixels.iter().any(|&p| p != 0xff_ffff));
            }
        }
    }

    #[test]
    fn the_bar_has_a_tick_for_each_operation() {
        let (width, height) = (200, 40);
        let bar = Bar::new((width, height), 1.0, 48);
        let wish = OverlayWish {
            bar: Some(BarWish {
                bar,
                frame: 0,
                frames_per_op: 16,
                section: None,
            }),
            ..OverlayWish::default()
        };
        let pixels = draw(&mut overlay(1.0), &wish, width, height);
        // Above the line, where ticks reach and the handle at frame 0 too.
        let row = &pixels[(bar.top_px + 9) * width..][..width];
        let ticks = (1..width).filter(|&x| row[x] == GREY && row[x - 1] != GREY);
        assert_eq!(ticks.count(), 3);
        assert!(row[bar.x_of(0) as usize] == WHITE);
    }

    #[test]
    fn a_message_covers_no_line_of_the_sheet() {
        let (width, height) = (640, 480);
        let mut overlay = overlay(1.0);
        let mut with = |message: Option<&str>| {
            let wish = OverlayWish {
                sheet: true,
                message: message.map(str::to_owned),
                ..OverlayWish::default()
            };
            draw(&mut overlay, &wish, width, height)
        };
        let (alone, told) = (with(None), with(Some("trackball")));
        let rows = alone.chunks(width).zip(told.chunks(width));
        let changed: Vec<usize> = rows
            .enumerate()
            .filter(|(_, (a, b))| a != b)
            .map(|(y, _)| y)
            .collect();
        let (_, cell_height) = overlay.font.cell();
        let last = changed.last().expect("a message");
        assert!(last - changed[0] < cell_height as usize, "{changed:?}");
        let layout = Layout::of(&overlay.sheet, overlay.font.cell());
        let top = (height as i32 - layout.height) / 2 + layout.margin;
        assert!((*last as i32) < top + cell_height, "{changed:?}");
    }

    #[test]
    fn the_whole_sheet_fits_in_the_default_window() {
        let mut overlay = overlay(1.0);
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
