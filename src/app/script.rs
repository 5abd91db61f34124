//! Sessions as text: a line for each action, and lines that wait.
//!
//! ```text
//! wait 0.25          # let so many seconds go by
//! orbit 12 -7        # an action, see action.rs
//! resize 640 480     # the window takes another size
//! settle             # wait until the picture stands in full, and say so
//! fault worker       # for tests: a thread that renders the next picture panics
//! ```
//!
//! While a script plays, time is the script's: it moves by its `wait` lines alone, so that a session is the same
//! however fast the machine is.

use std::collections::VecDeque;
use std::fmt;
use std::io::{self, Write};
use std::str::FromStr;
use std::time::Duration;

use super::action::Action;

/// A line of a script.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Line {
    /// So much time goes by.
    Wait(Duration),
    /// The window takes this size, in pixels.
    Resize(u32, u32),
    /// The picture that the state wants is shown.
    Settle,
    /// A thread that renders the next picture panics: for tests of what comes after that.
    Fault,
    /// An action.
    Act(Action),
}

impl fmt::Display for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Line::Wait(dt) => write!(f, "wait {}.{:09}", dt.as_secs(), dt.subsec_nanos()),
            Line::Resize(width, height) => write!(f, "resize {width} {height}"),
            Line::Settle => f.write_str("settle"),
            Line::Fault => f.write_str("fault worker"),
            Line::Act(action) => action.fmt(f),
        }
    }
}

impl FromStr for Line {
    type Err = String;

    fn from_str(line: &str) -> Result<Line, String> {
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        match words[..] {
            ["settle"] => Ok(Line::Settle),
            ["fault", "worker"] => Ok(Line::Fault),
            ["wait", seconds] => seconds
                .parse()
                .ok()
                .filter(|s| (0.0..=1e6).contains(s))
                .map(|s| Line::Wait(Duration::from_secs_f64(s)))
                .ok_or_else(|| format!("wait: needs seconds up to 1e6, has {seconds:?}")),
            ["resize", width, height] => {
                let side = |word: &str| word.parse().ok().filter(|n| (1..=16384).contains(n));
                match (side(width), side(height)) {
                    (Some(width), Some(height)) => Ok(Line::Resize(width, height)),
                    _ => Err("resize: needs width and height, each 1 to 16384".to_owned()),
                }
            }
            _ => line.parse().map(Line::Act),
        }
    }
}

/// The line of a script without its comment; `None` when nothing is left.
///
/// # Errors
/// What is wrong with it.
pub fn read_line(text: &str) -> Result<Option<Line>, String> {
    let line = text.split('#').next().unwrap_or("").trim();
    if line.is_empty() {
        return Ok(None);
    }
    line.parse().map(Some)
}

/// Plays a script whose lines come one by one. Times called real are the caller's clock.
#[derive(Debug, Default)]
pub struct Player {
    lines: VecDeque<Line>,
    /// No more lines will come.
    closed: bool,
    /// The script's time up to the line that is next.
    time: Duration,
    /// When the line that is next, a wait, began; or when the script ended.
    since: Option<Duration>,
}

impl Player {
    /// One more line; `None`: that was the last.
    pub fn push(&mut self, line: Option<Line>) {
        match line {
            Some(line) => self.lines.push_back(line),
            None => self.closed = true,
        }
    }

    /// True when all is played.
    #[must_use]
    pub fn has_ended(&self) -> bool {
        self.closed && self.lines.is_empty()
    }

    /// The script's time: it stands, but in a wait and after the end.
    #[must_use]
    pub fn now(&self, real: Duration) -> Duration {
        let passed = self
            .since
            .map_or(Duration::ZERO, |since| real.saturating_sub(since));
        match self.lines.front() {
            Some(Line::Wait(dt)) => self.time + passed.min(*dt),
            None if self.closed => self.time + passed,
            _ => self.time,
        }
    }

    /// The next line that is due; `settled` tells whether the picture stands. Never a wait: those are waited for
    /// here.
    pub fn next(&mut self, real: Duration, settled: bool) -> Option<Line> {
        while let Some(Line::Wait(dt)) = self.lines.front().copied() {
            let since = *self.since.get_or_insert(real);
            if real.saturating_sub(since) < dt {
                return None;
            }
            self.time += dt;
            self.since = None;
            self.lines.pop_front();
        }
        if self.has_ended() {
            self.since.get_or_insert(real);
        }
        match self.lines.front()? {
            Line::Settle if !settled => None,
            _ => self.lines.pop_front(),
        }
    }

    /// True in a wait and after the end.
    #[must_use]
    pub fn time_moves(&self) -> bool {
        self.since.is_some()
    }

    /// When, on the caller's clock, a wait is over.
    #[must_use]
    pub fn wakes_at(&self) -> Option<Duration> {
        match self.lines.front()? {
            Line::Wait(dt) => Some(self.since? + *dt),
            _ => None,
        }
    }
}

/// Writes down what is done, as a script.
pub struct Recorder {
    out: Box<dyn Write>,
    last: Duration,
    /// Something was done since the picture last stood.
    open: bool,
}

impl fmt::Debug for Recorder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Recorder")
            .field("last", &self.last)
            .finish()
    }
}

impl Recorder {
    /// From time 0 on.
    #[must_use]
    pub fn new(out: Box<dyn Write>) -> Recorder {
        Recorder {
            out,
            last: Duration::ZERO,
            open: false,
        }
    }

    /// `line` is done at `now`.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn note(&mut self, now: Duration, line: Line) -> io::Result<()> {
        let dt = now.saturating_sub(self.last);
        if !dt.is_zero() {
            writeln!(self.out, "{}", Line::Wait(dt))?;
            self.last = now;
        }
        writeln!(self.out, "{line}")?;
        self.open = true;
        self.out.flush()
    }

    /// The picture stands: said once after what was done.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn settled(&mut self) -> io::Result<()> {
        if !std::mem::take(&mut self.open) {
            return Ok(());
        }
        writeln!(self.out, "{}", Line::Settle)?;
        self.out.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ms(ms: u64) -> Duration {
        Duration::from_millis(ms)
    }

    #[test]
    fn lines_read_back_and_comments_are_skipped() {
        for line in [
            Line::Wait(Duration::new(3, 7)),
            Line::Resize(640, 480),
            Line::Settle,
            Line::Fault,
            Line::Act(Action::Undo),
        ] {
            assert_eq!(read_line(&format!(" {line} # so")), Ok(Some(line)));
        }
        assert_eq!(read_line("  # nothing"), Ok(None));
        for bad in [
            "wait -1",
            "wait",
            "wait nan",
            "resize 0 5",
            "settle now",
            "fault",
        ] {
            assert!(read_line(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn time_is_the_scripts_and_stands_between_waits() {
        let mut p = Player::default();
        let act = Line::Act(Action::Undo);
        for line in [act, Line::Wait(ms(100)), Line::Settle, act] {
            p.push(Some(line));
        }
        assert_eq!(p.next(ms(5000), false), Some(act));
        assert_eq!(p.now(ms(6000)), ms(0));
        assert_eq!(p.next(ms(7000), true), None);
        assert_eq!(p.wakes_at(), Some(ms(7100)));
        assert_eq!(p.now(ms(7040)), ms(40));
        assert_eq!(p.now(ms(9000)), ms(100));
        assert_eq!(p.next(ms(9000), false), None);
        assert_eq!(p.now(ms(9500)), ms(100));
        assert_eq!(p.next(ms(9600), true), Some(Line::Settle));
        assert_eq!(p.next(ms(9600), true), Some(act));
        assert_eq!(p.next(ms(9700), true), None);
        p.push(None);
        assert!(p.has_ended());
        assert_eq!(p.next(ms(9800), true), None);
        assert_eq!(p.now(ms(9900)), ms(200));
    }

    #[test]
    fn a_recorded_session_is_a_script() {
        let path = tempfile::NamedTempFile::new().expect("a file");
        let out = path.reopen().expect("the file");
        let mut recorder = Recorder::new(Box::new(out));
        let noted = recorder
            .note(ms(40), Line::Act(Action::Undo))
            .and_then(|()| recorder.settled())
            .and_then(|()| recorder.settled())
            .and_then(|()| recorder.note(ms(40), Line::Resize(3, 4)));
        assert!(noted.is_ok());
        let text = std::fs::read_to_string(path.path()).expect("text");
        assert_eq!(text, "wait 0.040000000\nundo\nsettle\nresize 3 4\n");
    }
}
