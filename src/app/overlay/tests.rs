use super::*;
use crate::app::scrub::Bar;
use crate::frame::Frame;

fn overlay(scale_factor: f64) -> Overlay {
    Overlay::new(scale_factor, &Keymap::default())
}

fn everything() -> OverlayWish {
    OverlayWish {
        statistics: true,
        axes: true,
        divider: Some(30),
        zoom: 1,
        sheet: true,
        picked: vec![("triangle".into(), "7".into())],
        marks: vec![(0, 0), (i32::MIN, i32::MAX)],
        recording: Some(RECORDING.into()),
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

/// A white picture with what `draw` draws over it.
fn on_white(width: usize, height: usize, draw: impl FnOnce(&mut Canvas<'_>)) -> Vec<u32> {
    let mut white = Frame::default();
    white.resize(width, height);
    white.pixels.fill(WHITE);
    let mut pixels = vec![0; width * height];
    let mut canvas = Canvas::over(Some(&white), 1, &mut pixels, width);
    draw(&mut canvas);
    canvas.pixels();
    pixels
}

fn draw(overlay: &mut Overlay, wish: &OverlayWish, width: usize, height: usize) -> Vec<u32> {
    let told = Told {
        statistics: &[Line::new("fps", "60")],
        ..Told::default()
    };
    on_white(width, height, |canvas| overlay.draw(canvas, wish, &told))
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
fn labels_and_axes_survive_every_size_and_stay_at_their_sides() {
    let label = [Line::new("report", "shaded"), Line::new("", "12.0 s")];
    let view = crate::camera::Camera::default_for(crate::geometry::Aabb::EMPTY);
    let view = view.view(64, 48, false);
    for (width, height) in [(1, 1), (1, 300), (300, 1), (640, 300)] {
        let pixels = on_white(width, height, |canvas| {
            let mut overlay = overlay(1.0);
            overlay.axes(canvas, &view, &OverlayWish::default());
            for column in [None, Some(0), Some(320), Some(usize::MAX)] {
                let lines = [label.to_vec(), label.to_vec()];
                let labels = Some(&Labels { column, lines });
                let told = Told {
                    labels,
                    ..Told::default()
                };
                overlay.draw(canvas, &OverlayWish::default(), &told);
            }
        });
        assert!(pixels.iter().any(|&p| p != 0xff_ffff));
    }
    let lines = [label.to_vec(), vec![Line::new("", "")]];
    let labels = Some(&Labels {
        column: Some(320),
        lines,
    });
    let told = Told {
        labels,
        ..Told::default()
    };
    let pixels = on_white(640, 300, |canvas| {
        overlay(1.0).draw(canvas, &OverlayWish::default(), &told);
    });
    let row = &pixels[5 * 640..][..640];
    assert!(row[310] != 0xff_ffff && row[318] == 0xff_ffff);
}

#[test]
fn above_the_bar_stand_the_frame_and_the_message() {
    let (width, height) = (320, 200);
    let bar = Bar::new((width, height), 1.0, 48);
    let covered = |frame: u64, message: Option<&str>| {
        let wish = OverlayWish {
            bar: Some(BarWish {
                bar,
                frame,
                frames_per_op: 16,
                section: None,
            }),
            message: message.map(str::to_owned),
            ..OverlayWish::default()
        };
        let mut pixels = draw(&mut overlay(1.0), &wish, width, height);
        pixels.truncate(bar.top_px * width);
        pixels
    };
    let lines = |pixels: &[u32]| pixels.iter().filter(|&&p| p != 0xff_ffff).count() / width;
    let alone = covered(7, None);
    assert!(lines(&alone) > 0);
    assert!(alone != covered(8, None));
    let both = covered(7, Some("recording on"));
    assert!(lines(&both) > lines(&alone));
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
    let layout = Layout::of(&overlay.sheet, MIN_TEXT_PX, overlay.font.cell());
    let top = (height as i32 - layout.rect.height) / 2 + layout.margin;
    assert!((*last as i32) < top + cell_height, "{changed:?}");
}

#[test]
fn the_sheet_is_kept_from_picture_to_picture_and_drawn_anew_when_it_changes() {
    let mut kept = overlay(1.0);
    // Zoom, message and size of one picture after the other; what comes twice is kept.
    let pictures = [
        (0, None, (640, 480)),
        (0, None, (640, 480)),
        (0, Some("trackball"), (640, 480)),
        (2, Some("trackball"), (1600, 900)),
        (2, Some("trackball"), (1600, 901)),
        (2, None, (200, 150)),
        (2, None, (201, 150)),
        (0, None, (640, 480)),
    ];
    for (zoom, message, (width, height)) in pictures {
        let wish = OverlayWish {
            sheet: true,
            zoom,
            message: message.map(str::to_owned),
            ..OverlayWish::default()
        };
        let pixels = draw(&mut kept, &wish, width, height);
        let fresh = draw(&mut overlay(1.0), &wish, width, height);
        assert!(
            pixels == fresh,
            "zoom {zoom}, {message:?}, {width}x{height}"
        );
        let mut over_black = || {
            let mut pixels = vec![WHITE; width * height];
            let mut canvas = Canvas::over(None, 1, &mut pixels, width);
            kept.draw(&mut canvas, &wish, &Told::default());
            canvas.pixels();
            pixels
        };
        // Nothing shines through.
        let (seen, through) = (over_black(), pixels);
        let is_either = seen
            .iter()
            .zip(&through)
            .all(|(seen, through)| seen == through || (*seen, *through) == (0, WHITE));
        assert!(is_either && seen[height / 2 * width + width / 2] != 0);
    }
}

#[test]
fn an_error_and_a_question_are_drawn_instead_of_the_sheet() {
    let mut overlay = overlay(1.0);
    let board = [Line::new("", "scene.txt:1:5: expected a number")];
    let mut drawn = |sheet: bool, board: Option<&[Line]>, question: Option<&str>| {
        let wish = OverlayWish {
            sheet,
            question: question.map(str::to_owned),
            ..OverlayWish::default()
        };
        let told = Told {
            board,
            ..Told::default()
        };
        on_white(640, 480, |canvas| overlay.draw(canvas, &wish, &told))
    };
    for (board, question) in [(Some(&board[..]), None), (None, Some("really?"))] {
        let alone = drawn(false, board, question);
        assert!(drawn(true, board, question) == alone);
    }
    assert!(drawn(true, None, None) != drawn(false, None, None));
}

#[test]
fn the_whole_sheet_fits_in_the_default_window() {
    let overlay = overlay(1.0);
    let sheet = overlay.sheet.clone();
    let layout = overlay.layout(&mut Room::new((640, 480)), &sheet, Place::Middle);
    assert!(layout.rect.width <= 640 && layout.rect.height <= 480);
}

#[test]
fn panels_make_room_for_each_other() {
    let lines = |count: usize, letters: usize| -> Vec<Line> {
        let line = || Line::new("name", "m".repeat(letters));
        std::iter::repeat_with(line).take(count).collect()
    };
    let panels = [
        (lines(3, 20), Place::Middle),
        (lines(1, 20), Place::TopBefore(150)),
        (lines(1, 20), Place::TopAfter(158)),
        (lines(9, 22), Place::TopLeft),
        (lines(7, 18), Place::TopRight),
        (lines(2, 20), Place::BottomLeft(0)),
    ];
    for (size, zoom) in [((1920, 1080), 4), ((800, 600), 1), ((640, 480), 0)] {
        let mut overlay = overlay(1.0);
        overlay.zoom = zoom_factor(zoom);
        let mut room = Room::new(size);
        let mut before: Vec<Rect> = Vec::new();
        for (lines, place) in &panels {
            let rect = overlay.layout(&mut room, lines, *place).rect;
            for other in &before {
                let apart = rect.is_apart(other);
                assert!(apart, "{size:?}: {place:?} at {rect:?} covers {other:?}");
            }
            before.push(rect);
        }
    }
}

#[test]
fn labels_of_narrow_sides_are_whole_and_side_by_side() {
    let label = [
        Line::new("report", "shaded"),
        Line::new("", "12.0 s"),
        Line::new("", "1200 times as long"),
    ];
    for (width, divider) in [(800, 640), (800, 160), (800, 0), (800, 800), (320, 160)] {
        let overlay = overlay(1.0);
        let mut room = Room::new((width, 240));
        let mut rect = |place| overlay.layout(&mut room, &label, place).rect;
        let (left, right) = (
            rect(Place::TopBefore(divider - 4)),
            rect(Place::TopAfter(divider + 4)),
        );
        for rect in [left, right] {
            let is_inside = rect.x >= 0 && rect.x + rect.width <= width;
            assert!(is_inside, "{rect:?} in {width}, divider at {divider}");
        }
        assert!(left.is_apart(&right), "{left:?}, {right:?}");
    }
    let mut room = Room::new((800, 600));
    let wide = overlay(1.0).layout(&mut room, &label, Place::TopAfter(640));
    assert!(wide.rect.x >= 640, "smaller letters keep it to its side");
}

#[test]
fn what_was_picked_hides_the_statistics_where_both_have_no_room() {
    let mut overlay = overlay(1.0);
    let (width, height) = (300, 200);
    let statistics: Vec<Line> = (0..14).map(|_| Line::new("render", "1.23 ms")).collect();
    let picked = OverlayWish {
        picked: vec![("point".into(), "-0.00324 0.11796 0.03925".into()); 7],
        ..OverlayWish::default()
    };
    let both = OverlayWish {
        statistics: true,
        ..picked.clone()
    };
    let told = Told {
        statistics: &statistics,
        ..Told::default()
    };
    let mut pixels =
        |wish: &OverlayWish| on_white(width, height, |canvas| overlay.draw(canvas, wish, &told));
    assert!(pixels(&both) == pixels(&picked));
}

#[test]
fn what_does_not_fit_says_so() {
    let lines = [
        Line::new("x y z", "turn about an axis"),
        Line::new("wheel", "dolly"),
        Line::new("q", "quit"),
    ];
    let whole = lines.each_ref().map(|l| [&l.name[..], &l.text[..]]);
    assert_eq!(cut(&lines, 7, (25, 3)), whole);
    assert_eq!(
        cut(&lines, 7, (14, 2)),
        [["x y z", "turn a…"], ["… 2 more lines", ""]]
    );
    assert_eq!(cut(&lines, 7, (4, 1)), [["… 3…", ""]]);
    assert_eq!(cut(&lines, 7, (-3, 9))[0], ["…", "…"]);
}

#[test]
fn letters_alone_have_the_same_margin_on_both_sides() {
    let columns = |line: Line| Layout::of(&[line], 16, (1, 1)).rect.width - 2;
    assert_eq!(columns(Line::new("recording", "")), 9);
    assert_eq!(columns(Line::new("", "saved a.txt")), 11);
    assert_eq!(columns(Line::new("fps", "60")), 3 + 2 + 2);
}

#[test]
fn runs_of_function_keys_are_told_by_their_ends() {
    for (chords, expected) in [
        ("F1 F2 F3 F4 F5", "F1…F5"),
        ("a Shift+F9 Shift+F10 Shift+F11 F", "a Shift+F9…F11 F"),
        ("F9 F10", "F9 F10"),
        ("F1 Shift+F2 F3", "F1 Shift+F2 F3"),
        ("F3 F2 F1", "F3 F2 F1"),
        ("", ""),
    ] {
        assert_eq!(brief(chords), expected);
    }
}
