//! The session's script and its recording, at work: files, threads and the settled picture's report.

use std::fmt;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::path::Path;
use std::thread;
use std::time::Duration;

use serde_json::json;

use super::AppError;
use super::action::Action;
use super::loader::why_not;
use super::pace::Pace;
use super::script::{Line, Player, Recorder, read_line};
use super::side::Side;
use super::state::{State, word};

/// A window has so long to take the size that a script asks for.
const PATIENCE: Duration = Duration::from_secs(2);

/// The next line of the script; `None` after the last; or what is wrong with it.
pub type NextLine = Result<Option<Line>, String>;

/// What plays, and what is written down.
#[derive(Debug, Default)]
pub struct Session {
    player: Option<Player>,
    recorder: Option<Recorder>,
    settles: u64,
    /// The window's size that the script asked for last, and until when, on the clock, it waits for that.
    wanted_px: Option<((u32, u32), Duration)>,
    /// The window's size.
    size_px: (u32, u32),
}

impl Session {
    /// Plays `play` (`-`: the standard input), whose lines come through `send`, and records to `record`, which may be neither
    /// that nor the `scene`.
    ///
    /// # Errors
    /// When a file cannot be opened.
    pub fn open(
        play: Option<&Path>,
        record: Option<&Path>,
        scene: Option<&Path>,
        send: impl Fn(NextLine) + Send + 'static,
    ) -> Result<Session, AppError> {
        let broken = |what: &str, path: &Path, why: &dyn fmt::Display| AppError::Broken {
            why: format!("cannot {what} {}: {why}", path.display()),
        };
        let mut session = Session::default();
        if let Some(path) = play {
            let (source, name): (Box<dyn Read + Send>, _) = if path == Path::new("-") {
                (Box::new(io::stdin()), "<stdin>".to_owned())
            } else {
                let file = File::open(path).map_err(|e| broken("read", path, &why_not(&e)))?;
                (Box::new(file), path.display().to_string())
            };
            thread::Builder::new()
                .name("script".into())
                .spawn(move || read(source, &name, send))
                .map_err(|e| broken("read", path, &e))?;
            session.player = Some(Player::default());
        }
        if let Some(path) = record {
            let file = path.canonicalize();
            let is = |other: &Path| file.as_ref().ok() == other.canonicalize().ok().as_ref();
            for (read, what) in [(scene, "the scene"), (play, "the script that is played")] {
                if file.is_ok() && read.is_some_and(is) {
                    return Err(broken("write", path, &format!("it is {what}")));
                }
            }
            let file = File::create(path).map_err(|e| broken("write", path, &e))?;
            session.recorder = Some(Recorder::new(Box::new(file)));
        }
        Ok(session)
    }

    /// One more line of the script.
    pub fn push(&mut self, line: Option<Line>) {
        if let Some(player) = &mut self.player {
            player.push(line);
        }
    }

    /// The session's time when the clock shows `real`.
    #[must_use]
    pub fn now(&self, real: Duration) -> Duration {
        self.player.as_ref().map_or(real, |p| p.now(real))
    }

    /// True while the session's time moves with the clock.
    #[must_use]
    pub fn time_moves(&self) -> bool {
        self.player.as_ref().is_none_or(Player::time_moves)
    }

    /// The next line that is due.
    pub fn next(&mut self, real: Duration, settled: bool) -> Option<Line> {
        let line = self.player.as_mut()?.next(real, settled)?;
        match line {
            Line::Resize(width, height) => {
                self.wanted_px = Some(((width, height), real.saturating_add(PATIENCE)));
            }
            // The size before is wanted no more.
            Line::Act(Action::ToggleFullscreen) => self.wanted_px = None,
            _ => {}
        }
        Some(line)
    }

    /// The window has that size. Its picture may be smaller, where the window system takes no larger one.
    pub fn sized(&mut self, size_px: (u32, u32)) {
        self.size_px = size_px;
    }

    /// True unless the script waits for a size of the window.
    #[must_use]
    pub fn has_size(&self) -> bool {
        self.wanted_px
            .is_none_or(|(wanted, _)| wanted == self.size_px)
    }

    /// The size that the window has not taken until `real`, told once: the script goes on without.
    pub fn give_up_size(&mut self, real: Duration) -> Option<(u32, u32)> {
        let (wanted, until) = self.wanted_px.filter(|_| !self.has_size())?;
        (until <= real).then(|| {
            self.wanted_px = None;
            wanted
        })
    }

    /// When, on the clock, the script goes on by itself.
    #[must_use]
    pub fn wakes_at(&self) -> Option<Duration> {
        let gives_up = self.wanted_px.filter(|_| !self.has_size());
        let gives_up = gives_up.map(|(_, until)| until);
        let wakes = self.player.as_ref()?.wakes_at();
        wakes.into_iter().chain(gives_up).min()
    }

    /// Writes down that `line` is done at the session's time `now`.
    pub fn note(&mut self, now: Duration, line: Line) -> Option<io::Error> {
        let failed = self.recorder.as_mut()?.note(now, line).err();
        self.give_up_after(failed)
    }

    /// The picture stands.
    pub fn settled(&mut self) -> Option<io::Error> {
        let failed = self.recorder.as_mut()?.settled().err();
        self.give_up_after(failed)
    }

    /// Nothing more is written to a file that failed.
    fn give_up_after(&mut self, failed: Option<io::Error>) -> Option<io::Error> {
        if failed.is_some() {
            self.recorder = None;
        }
        failed
    }

    /// What a `settle` line prints: everything that `raybomb render` needs for the same picture.
    pub fn settle_report(&mut self, state: &State, pace: &mut Pace) -> String {
        self.settles += 1;
        let ms = |time: Option<Duration>| time.map(|d| d.as_secs_f64() * 1e3);
        let (tally, fine_after) = pace.take_tally();
        let (refreshes, missed) = tally.refreshes();
        let percentile = |percent| ms(tally.percentile(percent));
        let wish = state.wish();
        let [left, right] = wish.sides();
        let side = |side: &Side| {
            json!({
                "engine": word(side.settings.engine),
                "view": word(side.settings.mode),
                "columns": [side.columns.start, side.columns.end],
                "aa": if side.is_fast() { pace.samples_of(&wish).count() } else { 1 },
            })
        };
        let (width, height) = state.size_px();
        let (camera, operations) = state.scene_text();
        let (frame, last) = state.frame();
        let report = json!({
            "settled": self.settles,
            "size": [width, height],
            "view": word(wish.settings.mode),
            "engine": word(wish.settings.engine),
            "aa": pace.samples_of(&wish).count(),
            "cost_scale": wish.settings.cost_scale,
            "sides": wish.split.map(|_| [side(&left), side(&right)]),
            "moved": {
                "pictures": tally.pictures(),
                "pixel_sizes": tally.sizes(),
                "refreshes": refreshes,
                "missed": missed,
                "input_ms": { "p50": percentile(50), "p99": percentile(99), "max": percentile(100) },
                "fine_after_ms": ms(fine_after),
            },
            "frame": frame,
            "last_frame": last,
            "camera": camera,
            "operations": operations,
        });
        format!("{report}\n")
    }
}

/// Sends the script line by line, and ends after the first bad one.
fn read(source: impl Read, name: &str, send: impl Fn(NextLine)) {
    for (number, text) in BufReader::new(source).lines().enumerate() {
        let line = text
            .map_err(|e| e.to_string())
            .and_then(|text| read_line(&text))
            .map_err(|why| format!("{name}:{}: {why}", number + 1));
        match line {
            Ok(None) => {}
            Ok(line) => send(Ok(line)),
            Err(why) => return send(Err(why)),
        }
    }
    send(Ok(None));
}

/// Prints on the standard output; one that is closed is no reason to stop.
pub fn print(text: &str) {
    let mut out = io::stdout().lock();
    let _ = out.write_all(text.as_bytes()).and_then(|()| out.flush());
}

#[cfg(test)]
mod tests {
    use super::*;

    fn playing(lines: &[Line]) -> Session {
        let mut session = Session {
            player: Some(Player::default()),
            ..Session::default()
        };
        session.sized((640, 480));
        for &line in lines {
            session.push(Some(line));
        }
        session
    }

    #[test]
    fn a_size_that_the_window_does_not_take_is_given_up_once() {
        let mut session = playing(&[Line::Resize(300, 200), Line::Settle]);
        let start = Duration::from_secs(5);
        assert_eq!(session.next(start, false), Some(Line::Resize(300, 200)));
        assert!(!session.has_size());
        assert_eq!(session.give_up_size(start), None);
        assert_eq!(session.wakes_at(), Some(start + PATIENCE));
        let late = start + PATIENCE;
        assert_eq!(session.give_up_size(late), Some((300, 200)));
        assert!(session.has_size() && session.wakes_at().is_none());
        assert_eq!(session.give_up_size(late), None);
    }

    #[test]
    fn a_size_that_was_taken_is_wanted_until_the_script_fills_the_screen() {
        let fullscreen = Line::Act(Action::ToggleFullscreen);
        let mut session = playing(&[Line::Resize(300, 200), fullscreen]);
        session.next(Duration::ZERO, true);
        session.sized((300, 200));
        assert!(session.has_size());
        assert_eq!(session.give_up_size(Duration::MAX), None);
        assert_eq!(session.next(Duration::ZERO, true), Some(fullscreen));
        session.sized((1600, 1200));
        assert!(session.has_size());
    }
}
