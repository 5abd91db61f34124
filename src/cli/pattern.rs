//! Names of an animation's files: `frames/{frame:04}.png`.

use std::path::PathBuf;
use std::str::FromStr;

/// The most digits that a pattern can ask for: those of the largest frame number.
const MAX_DIGITS: usize = 20;

/// A file name with a place for the frame's number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pattern {
    before: String,
    digits: usize,
    after: String,
}

impl Pattern {
    /// The file of frame `frame`.
    #[must_use]
    pub fn file(&self, frame: u64) -> PathBuf {
        let Pattern {
            before,
            digits,
            after,
        } = self;
        PathBuf::from(format!("{before}{frame:0digits$}{after}"))
    }
}

impl FromStr for Pattern {
    type Err = String;

    /// `{frame}` is the number, `{frame:04}` the number with leading zeros to at least four digits; other braces
    /// stand for themselves.
    fn from_str(text: &str) -> Result<Pattern, String> {
        const OPEN: &str = "{frame";
        let missing = || "must contain {frame} or, for 4 digits, {frame:04}".to_owned();
        let (before, rest) = text.split_once(OPEN).ok_or_else(missing)?;
        let (format, after) = rest.split_once('}').ok_or_else(missing)?;
        if after.contains(OPEN) {
            return Err("must contain {frame} once".to_owned());
        }
        let digits = match format {
            "" => Some(0),
            _ => format
                .strip_prefix(":0")
                .filter(|n| !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit()))
                .and_then(|n| n.parse().ok())
                .filter(|n| *n <= MAX_DIGITS),
        };
        Ok(Pattern {
            before: before.to_owned(),
            digits: digits.ok_or_else(missing)?,
            after: after.to_owned(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_number_takes_its_place() {
        let file = |pattern: &str, frame| pattern.parse::<Pattern>().unwrap().file(frame);
        assert_eq!(file("{frame}.bmp", 7), PathBuf::from("7.bmp"));
        assert_eq!(file("a/{frame:04}.png", 7), PathBuf::from("a/0007.png"));
        assert_eq!(
            file("a/{frame:04}.png", 12345),
            PathBuf::from("a/12345.png")
        );
        assert_eq!(file("{x}{frame:03}{y}", 1), PathBuf::from("{x}001{y}"));
    }

    #[test]
    fn bad_patterns_are_refused() {
        for bad in [
            "",
            "a.png",
            "{fram}.png",
            "{frame",
            "{frame:4}",
            "{frame:0}",
            "{frame:0x}",
            "{frame:099}",
            "{frames}",
            "{frame}{frame}",
            "{frame:04",
            "{frame:-04}",
        ] {
            assert!(bad.parse::<Pattern>().is_err(), "{bad}");
        }
    }
}
