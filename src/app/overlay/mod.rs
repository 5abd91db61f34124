//! Over the picture: figures, key sheet, picks, questions, messages, and the bar of frames.
//!
//! It is drawn on the copy that goes to the screen, never on the frame, and nothing is drawn unless asked
//! for: the window shows the very bits that files get. Panels make room for each other ([`room`]).

mod axes;
mod canvas;
mod font;
mod room;

pub use canvas::Canvas;

use std::borrow::Cow;
use std::rc::Rc;

use canvas::Rect;
use font::Font;
use room::Room;

use super::keymap::Keymap;
use super::scrub::BarWish;
use super::state::OverlayWish;
use crate::camera::View;
use crate::frame::Frame;
use crate::simd::{Kernel, dispatch};

const WHITE: u32 = 0xff_ffff;
/// Chords, and the names of figures.
const AMBER: u32 = 0xff_c860;
/// Says that moves are recorded.
pub const RECORDING: &str = "recording";
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
    /// As the hand wants it, beside the screen's.
    zoom: f64,
    /// Its first line is for a message.
    sheet: Rc<[Line]>,
    kept: Kept,
}

/// The panel through which nothing shines, as pixels: it is the same over every picture.
#[derive(Debug, Default)]
struct Kept {
    lines: Vec<Line>,
    layout: Option<Layout>,
    frame: Frame,
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

/// What is told beside what the state wishes for.
#[derive(Clone, Copy, Debug, Default)]
pub struct Told<'a> {
    /// The figures.
    pub statistics: &'a [Line],
    /// What each side of the picture is made by.
    pub labels: Option<&'a Labels>,
    /// How far a load is, or what is wrong with a file.
    pub board: Option<&'a [Line]>,
}

/// What is said of the two sides of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Labels {
    /// The first column right of the divider; `None`: the left side is all there is.
    pub column: Option<usize>,
    /// Engine and view, and what it has done.
    pub lines: [Vec<Line>; 2],
}

/// Where a panel stands if nothing else stands there.
#[derive(Clone, Copy, Debug)]
enum Place {
    TopLeft,
    TopRight,
    /// With its right border there, as long as it lies in the window.
    TopBefore(i32),
    /// With its left border there, as long as it lies in the window.
    TopAfter(i32),
    Middle,
    /// That many pixels above the lower border.
    BottomLeft(i32),
}

impl Overlay {
    /// For a screen with that many physical pixels a logical one, and the sheet of these keys.
    #[must_use]
    pub fn new(scale_factor: f64, keymap: &Keymap) -> Overlay {
        let line = |(chords, says): (String, &'static str)| Line::new(brief(&chords), says);
        Overlay {
            font: Font::new(TEXT_PX as u32),
            scale_factor,
            zoom: 1.0,
            sheet: std::iter::once(Line::new("", ""))
                .chain(keymap.sheet().into_iter().map(line))
                .collect(),
            kept: Kept::default(),
        }
    }

    /// The window moved to a screen with another scale factor.
    pub fn set_scale_factor(&mut self, scale_factor: f64) {
        self.scale_factor = scale_factor;
    }

    /// Draws what `wish` asks for, and what is `told`.
    pub fn draw(&mut self, canvas: &mut Canvas<'_>, wish: &OverlayWish, told: &Told<'_>) {
        self.zoom = zoom_factor(wish.zoom);
        if let Some(column) = wish.divider {
            self.divider(canvas, column);
        }
        let mut room = Room::new(extent(canvas));
        // The sheet may need all the room: where it stands there is nothing else, and where something is urgent there is
        // no sheet.
        let sheet = wish.sheet && told.board.is_none() && wish.question.is_none();
        let bar = wish.bar.as_ref().filter(|_| !sheet);
        if !sheet {
            for &place in &wish.marks {
                self.mark(canvas, place);
            }
            if wish.axes {
                room.take(axes::place(extent(canvas), self.scale(), above(bar)));
            }
        }
        if let Some(bar) = bar {
            room.take(draw_bar(canvas, bar));
        }
        // The most urgent first: it stands where it likes to.
        let mut panels: Vec<(Cow<'_, [Line]>, Place)> = Vec::new();
        let mut add = |lines, place| panels.push((lines, place));
        add(told.board.unwrap_or_default().into(), Place::Middle);
        let question = wish.question.iter().map(|text| Line::new("", text));
        add(question.collect(), Place::Middle);
        if let Some(Labels { column, lines }) = told.labels {
            let [left, right] = lines;
            match column {
                None => add(left.into(), Place::TopLeft),
                Some(column) => {
                    let gap = (4.0 * self.scale()).ceil() as i32;
                    let x = i32::try_from(*column).unwrap_or(i32::MAX / 2);
                    add(left.into(), Place::TopBefore(x - gap));
                    add(right.into(), Place::TopAfter(x.saturating_add(gap)));
                }
            }
        }
        let message = wish.message.iter().map(|text| Line::new("", text));
        let keys = Rc::clone(&self.sheet);
        if sheet {
            add(keys[..].into(), Place::Middle);
        } else {
            // Where there is no room above the bar, the number would hide it.
            let frame = bar.filter(|b| b.bar.top_px >= 2 * b.bar.height_px);
            let frame = frame.map(|b| Line::new("frame", format!("{} of {}", b.frame, b.bar.last)));
            let lines = frame.into_iter().chain(message).collect();
            add(lines, Place::BottomLeft(above(bar)));
            let recording = wish.recording.iter().map(|text| Line::new(text, ""));
            let picked = wish.picked.iter().map(|(name, text)| Line::new(name, text));
            add(recording.chain(picked).collect(), Place::TopRight);
            if wish.statistics {
                add(told.statistics.into(), Place::TopLeft);
            }
        }
        panels.retain(|(lines, _)| !lines.is_empty());
        let layouts: Vec<Layout> = panels
            .iter()
            .map(|(lines, place)| self.layout(&mut room, lines, *place))
            .collect();
        // Where there is no room for all, nothing shines through what is more urgent. What stands in the middle was
        // asked for just now.
        for (i, ((lines, place), layout)) in panels.iter().zip(&layouts).enumerate() {
            let is_apart = |other: &Layout| layout.rect.is_apart(&other.rect);
            if sheet && matches!(place, Place::Middle) {
                // However long it is, the keys stay where they are.
                let mut lines = lines.clone();
                if let Some(message) = &wish.message {
                    lines.to_mut()[0] = Line::new(message, "");
                }
                self.keep(&lines, layout, extent(canvas));
                canvas.stamp((layout.rect.x, layout.rect.y), &self.kept.frame);
            } else if matches!(place, Place::Middle) || layouts[..i].iter().all(is_apart) {
                self.panel(canvas, lines, layout);
            }
        }
    }

    /// Draws where the axes of the world point in the picture of `view`; `above` is what is at the lower border.
    pub fn axes(&mut self, canvas: &mut Canvas<'_>, view: &View, wish: &OverlayWish) {
        self.zoom = zoom_factor(wish.zoom);
        let above = above(wish.bar.as_ref());
        // A small positive number.
        let size_px = (TEXT_PX * self.scale()).round() as u32;
        self.font.resize(size_px.max(MIN_TEXT_PX));
        let (cell_width, cell_height) = self.font.cell();
        let scale = self.scale();
        axes::draw(canvas, view, scale, above, |canvas, (x, y), c, color| {
            // In the window, or cut off.
            let (x, y) = (x.round() as i32, y.round() as i32);
            let glyph = self.font.glyph(c);
            let corner = (x - cell_width / 2, y - cell_height / 2);
            for (dx, dy) in [(-1, 0), (1, 0), (0, -1), (0, 1)] {
                canvas.glyph(corner.0 + dx, corner.1 + dy, glyph, 0);
            }
            canvas.glyph(corner.0, corner.1, glyph, color);
        });
    }

    /// A line with dark borders between the sides, and something to hold in the middle of it.
    fn divider(&self, canvas: &mut Canvas<'_>, column: usize) {
        let (_, height) = extent(canvas);
        let x = i32::try_from(column).unwrap_or(i32::MAX / 2);
        // A scale is a small positive number.
        let unit = self.scale().ceil() as i32;
        let mut block = |half_width: i32, y: i32, height: i32, color: u32| {
            let rect = Rect {
                x: x - half_width,
                y,
                width: 2 * half_width,
                height,
            };
            canvas.fill(rect, color);
        };
        block(2 * unit, 0, height, 0);
        block(unit, 0, height, WHITE);
        let handle = (24 * unit).min(height);
        let top = (height - handle) / 2;
        block(5 * unit, top, handle, 0);
        block(4 * unit, top + unit, handle - 2 * unit, WHITE);
    }

    /// Pixels of the screen for each of the design.
    fn scale(&self) -> f64 {
        self.scale_factor * self.zoom
    }

    /// A cross with a dark rim: seen on any colour.
    fn mark(&self, canvas: &mut Canvas<'_>, (x, y): (i32, i32)) {
        // A scale factor is a small positive number.
        let arm = (5.0 * self.scale()).ceil() as i32;
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

    /// Draws a panel as it would look over grey, if the one that is kept is another.
    fn keep(&mut self, lines: &[Line], layout: &Layout, (width, height): (i32, i32)) {
        let Rect { x, y, .. } = layout.rect;
        let rect = Rect {
            x: 0,
            y: 0,
            width: layout.rect.width.min(width - x),
            height: layout.rect.height.min(height - y),
        };
        let layout = Layout { rect, ..*layout };
        if self.kept.layout == Some(layout) && self.kept.lines == lines {
            return;
        }
        self.kept.lines = lines.to_vec();
        self.kept.layout = Some(layout);
        let mut grey = Frame::new(rect.width as usize, rect.height as usize);
        grey.pixels.fill(GREY);
        let mut frame = std::mem::take(&mut self.kept.frame);
        frame.resize(grey.width, grey.height);
        let mut canvas = Canvas::over(Some(&grey), 1, &mut frame.pixels, grey.width);
        self.panel(&mut canvas, lines, &layout);
        canvas.pixels();
        self.kept.frame = frame;
    }

    fn panel(&mut self, canvas: &mut Canvas<'_>, lines: &[Line], layout: &Layout) {
        dispatch!(Kernel::best(), _simd => self.panel_on(canvas, lines, layout));
    }

    /// Compiled for each width of vectors.
    #[inline(always)]
    fn panel_on(&mut self, canvas: &mut Canvas<'_>, lines: &[Line], layout: &Layout) {
        let Layout { rect, margin, .. } = *layout;
        self.font.resize(layout.size_px);
        let (cell_width, cell_height) = self.font.cell();
        let x = rect.x + margin;
        let (width, height) = extent(canvas);
        let room = (
            (width - x) / cell_width,
            (height - rect.y - margin) / cell_height,
        );
        let text_x = x + layout.name_columns * cell_width;
        // Line by line: what is darkened is still in a near cache when the letters come.
        let mut darkened = rect.y;
        let mut y = rect.y + margin;
        for [name, text] in cut(lines, layout.name_columns, room) {
            let color = if name == RECORDING { RED } else { AMBER };
            canvas.darken(rect.between(darkened, y + cell_height));
            darkened = y + cell_height;
            self.text(canvas, x, y, &name, color);
            self.text(canvas, text_x, y, &text, WHITE);
            y += cell_height;
        }
        canvas.darken(rect.between(darkened, rect.y + rect.height));
    }

    #[inline(always)]
    fn text(&mut self, canvas: &mut Canvas<'_>, x: i32, y: i32, text: &str, color: u32) {
        let (cell_width, _) = self.font.cell();
        let mut x = x;
        for c in text.chars() {
            canvas.glyph(x, y, self.font.glyph(c), color);
            x += cell_width;
        }
    }

    /// Picks the largest size, up to the screen's, at which `lines` fit into the width of `place` and between what is
    /// there, as near to `place` as may be; the smallest may be wider than that. Where no size is small enough: the
    /// largest that fits into the window, at `place` all the same.
    fn layout(&self, room: &mut Room, lines: &[Line], place: Place) -> Layout {
        // A scale factor is a small positive number.
        let largest = ((TEXT_PX * self.scale()).round() as u32).max(MIN_TEXT_PX);
        let mut fallback = None;
        for size_px in (MIN_TEXT_PX..=largest).rev() {
            let mut layout = Layout::of(lines, size_px, self.font.cell_of(size_px));
            let rect = layout.rect;
            let is_smallest = size_px == MIN_TEXT_PX;
            let width = match is_smallest {
                true => room.width(),
                false => place.width(room),
            };
            let fits = rect.width <= width && rect.height <= room.height();
            layout.rect = place.put(rect, room);
            if fits && let Some(rect) = room.find(layout.rect) {
                layout.rect = rect;
                fallback = Some(layout);
                break;
            }
            if fallback.is_none() && (fits || is_smallest) {
                fallback = Some(layout);
            }
        }
        let layout = fallback.expect("there is a smallest size");
        room.take(layout.rect);
        layout
    }
}

/// What there is room for, in letters and lines; where something is missing it says so. The names take `name_columns`
/// letters.
fn cut(lines: &[Line], name_columns: i32, (columns, rows): (i32, i32)) -> Vec<[Cow<'_, str>; 2]> {
    // Below no room there is none.
    let [name_columns, columns, rows] =
        [name_columns, columns, rows].map(|n| usize::try_from(n).unwrap_or(0));
    let kept = match lines.len() <= rows {
        true => lines.len(),
        false => rows.saturating_sub(1),
    };
    let more = lines.len() - kept;
    let last = (more > 0).then(|| {
        let says = format!("… {more} more lines");
        [short(&says, columns).into_owned().into(), "".into()]
    });
    let shown = lines[..kept].iter().map(|line| {
        let text_columns = columns.saturating_sub(name_columns);
        [short(&line.name, columns), short(&line.text, text_columns)]
    });
    shown.chain(last).collect()
}

/// As many letters as there are columns.
fn short(text: &str, columns: usize) -> Cow<'_, str> {
    // So many bytes are at most so many letters.
    if text.len() <= columns || text.chars().count() <= columns {
        return text.into();
    }
    let kept = text.chars().take(columns.saturating_sub(1));
    kept.chain(['…']).collect()
}

/// The same chords, three or more function keys in a row by the first and the last of them: what is narrower leaves
/// more of the picture.
fn brief(chords: &str) -> String {
    let chords: Vec<&str> = chords.split(' ').collect();
    let function_key = |chord: &'_ &str| {
        let (modifiers, number) = chord.rsplit_once('F')?;
        Some((modifiers.to_owned(), number.parse::<u32>().ok()?))
    };
    let runs = chords.chunk_by(|a, b| match (function_key(a), function_key(b)) {
        (Some(a), Some(b)) => a.0 == b.0 && b.1.checked_sub(a.1) == Some(1),
        _ => false,
    });
    let runs = runs.map(|run| match run {
        [first, _, .., last] => {
            let key = last.rsplit('+').next().unwrap_or_default();
            format!("{first}…{key}")
        }
        few => few.join(" "),
    });
    runs.collect::<Vec<_>>().join(" ")
}

/// How many times as large as usual things are after so many steps.
#[must_use]
pub fn zoom_factor(steps: i32) -> f64 {
    libm::pow(1.25, f64::from(steps))
}

/// Draws the bar of frames: a line, a tick for each operation, what is played in amber, a handle at the frame. Returns
/// its place.
fn draw_bar(canvas: &mut Canvas<'_>, wish: &BarWish) -> Rect {
    let bar = wish.bar;
    // All lie in the window, whose size fits.
    let (top, height) = (bar.top_px as i32, bar.height_px as i32);
    let place = Rect {
        x: 0,
        y: top,
        width: bar.width_px as i32,
        height,
    };
    canvas.darken(place);
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
    place
}

/// How high over the lower border panels end.
fn above(bar: Option<&BarWish>) -> i32 {
    // A window's height, and less.
    bar.map_or(0, |b| b.bar.height_px as i32)
}

/// The measures of a panel, in pixels unless said otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Layout {
    size_px: u32,
    margin: i32,
    rect: Rect,
    /// Letters that the left column takes, with the gap after it.
    name_columns: i32,
}

impl Layout {
    /// At the origin.
    fn of(lines: &[Line], size_px: u32, (cell_width, cell_height): (i32, i32)) -> Layout {
        let longest = |of: fn(&Line) -> &String| {
            let letters = lines.iter().map(|l| of(l).chars().count()).max();
            i32::try_from(letters.unwrap_or(0)).unwrap_or(i32::MAX / 4096)
        };
        let (names, texts) = (longest(|l| &l.name), longest(|l| &l.text));
        let gap = if names > 0 && texts > 0 { 2 } else { 0 };
        let name_columns = names + gap;
        let columns = name_columns + texts;
        let rows = i32::try_from(lines.len()).unwrap_or(i32::MAX / 4096);
        let margin = cell_width;
        Layout {
            size_px,
            margin,
            rect: Rect {
                x: 0,
                y: 0,
                width: columns * cell_width + 2 * margin,
                height: rows * cell_height + 2 * margin,
            },
            name_columns,
        }
    }
}

impl Place {
    /// The width that it is meant to keep to.
    fn width(self, room: &Room) -> i32 {
        match self {
            Place::TopBefore(x) => x.min(room.width()),
            Place::TopAfter(x) => room.width() - x.max(0),
            _ => room.width(),
        }
    }

    /// Moves `rect` there.
    fn put(self, rect: Rect, room: &Room) -> Rect {
        let (right, below) = (room.width() - rect.width, room.height() - rect.height);
        // What does not fit shows its beginning.
        let (x, y) = match self {
            Place::TopLeft => (0, 0),
            Place::TopRight => (right.max(0), 0),
            Place::TopBefore(x) => ((x - rect.width).clamp(0, right.max(0)), 0),
            Place::TopAfter(x) => (x.clamp(0, right.max(0)), 0),
            Place::Middle => ((right / 2).max(0), (below / 2).max(0)),
            Place::BottomLeft(above) => (0, (below - above).max(0)),
        };
        Rect { x, y, ..rect }
    }
}

/// The canvas's size in the type of coordinates.
fn extent(canvas: &Canvas<'_>) -> (i32, i32) {
    let int = |n: usize| i32::try_from(n).unwrap_or(i32::MAX);
    (int(canvas.width), int(canvas.height))
}

#[cfg(test)]
mod tests;
