//! The values of the options: text to meaning, with messages that say what is allowed.

use std::fmt;
use std::ops::RangeInclusive;
use std::str::FromStr;

use clap::builder::{PossibleValuesParser, TypedValueParser};

use crate::camera::{MAX_SIZE, Pivot};
use crate::render::{Engine, Reflection, Samples, ViewMode};
use crate::scene::{self, CameraCorners, CameraSetting, Scene};
use crate::simd::Kernel;
use crate::timeline::Ease;

/// The most threads that can be asked for: far above any machine, far below what exhausts one.
const MAX_THREADS: usize = 1024;

/// The largest `--fps` and `--seconds-per-op`: frame numbers stay exact far beyond.
const MAX_TIMING: f64 = 1e6;

/// The names of an option's values, in the order in which `--help` shows them.
type Names<T> = &'static [(&'static str, T)];

/// `--view`
pub const VIEWS: Names<ViewMode> = &[
    ("shaded", ViewMode::Shaded),
    ("id", ViewMode::Id),
    ("normal", ViewMode::Normal),
    ("depth", ViewMode::Depth),
    ("cost", ViewMode::Cost),
];

/// `--engine`
pub const ENGINES: Names<Engine> = &[
    ("fast", Engine::Fast),
    ("brute", Engine::Brute),
    ("report", Engine::Report),
];

/// `--reflection`
pub const REFLECTIONS: Names<Reflection> = &[
    ("mirror", Reflection::Mirror),
    ("as-printed", Reflection::AsPrinted),
];

/// `--pivot`
pub const PIVOTS: Names<Pivot> = &[("origin", Pivot::Origin), ("centre", Pivot::Centre)];

/// `--ease`
pub const EASES: Names<Ease> = &[("linear", Ease::Linear), ("smooth", Ease::Smooth)];

/// A parser for one of `names`.
pub fn one_of<T: Copy + Send + Sync + 'static>(
    names: Names<T>,
) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(names.iter().map(|(name, _)| *name)).map(move |text: String| {
        let (_, value) = names
            .iter()
            .find(|(name, _)| *name == text)
            .expect("clap lets only the possible values pass");
        *value
    })
}

/// What `--help`, messages and `bench --json` call `value`.
pub fn name_of<T: Copy + PartialEq>(names: Names<T>, value: T) -> &'static str {
    let found = names.iter().find(|(_, v)| *v == value);
    found.expect("every value has a name").0
}

/// The one of `known` that `word` is most like, if it is like any.
pub fn nearest<'a>(word: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let near = known.map(|k| (strsim::jaro_winkler(word, k), k));
    let (likeness, nearest) = near.max_by(|a, b| a.0.total_cmp(&b.0))?;
    (likeness > 0.75).then_some(nearest)
}

/// A parser for `auto` and the kernels that this CPU has.
pub fn kernel() -> impl TypedValueParser<Value = Kernel> {
    let names = Kernel::ALL.map(Kernel::name).into_iter().chain(["auto"]);
    PossibleValuesParser::new(names).try_map(|text: String| {
        let available = Kernel::available();
        let found = available.iter().find(|k| k.name() == text);
        match found {
            _ if text == "auto" => Ok(Kernel::best()),
            Some(kernel) => Ok(*kernel),
            None => {
                let names: Vec<&str> = available.iter().map(|k| k.name()).collect();
                Err(format!("this CPU has only {}", names.join(", ")))
            }
        }
    })
}

/// Width and height of a picture, each 1..=16384.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Pixels a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Size, String> {
        let side = |text: &str| match digits(text) {
            Some(n) if (1..=MAX_SIZE).contains(&n) => Ok(n),
            _ => Err(format!(
                "must be WIDTHxHEIGHT, each from 1 to {MAX_SIZE}, like 640x480"
            )),
        };
        let (width, height) = text.split_once('x').unwrap_or((text, ""));
        Ok(Size {
            width: side(width)?,
            height: side(height)?,
        })
    }
}

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.width, self.height)
    }
}

/// A number without a sign.
fn digits<T: FromStr>(text: &str) -> Option<T> {
    let plain = !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    if plain { text.parse().ok() } else { None }
}

/// `--threads`: 0 (all cores) to [`MAX_THREADS`].
pub fn threads(text: &str) -> Result<usize, String> {
    digits(text)
        .filter(|n| *n <= MAX_THREADS)
        .ok_or_else(|| format!("must be a number from 0 (all cores) to {MAX_THREADS}"))
}

/// `--aa`
pub fn samples(text: &str) -> Result<Samples, String> {
    digits(text).and_then(Samples::new).ok_or_else(|| {
        let most = Samples::MAX.count();
        format!("must be a power of two from 1 to {most}")
    })
}

/// `--frame`
pub fn frame(text: &str) -> Result<u64, String> {
    digits(text).ok_or_else(|| "must be a frame's number, 0 or more".to_owned())
}

/// `bench --frames`: 1 to 100,000 measurements.
pub fn count(text: &str) -> Result<u32, String> {
    digits(text)
        .filter(|n| (1..=100_000).contains(n))
        .ok_or_else(|| "must be a number from 1 to 100000".to_owned())
}

/// `--cost-scale`: 1 to 1,048,576 tests.
pub fn cost_scale(text: &str) -> Result<u32, String> {
    digits(text)
        .filter(|n| (1..=1 << 20).contains(n))
        .ok_or_else(|| "must be a number from 1 to 1048576".to_owned())
}

/// `--fps` and `--seconds-per-op`: above 0, at most [`MAX_TIMING`].
pub fn timing(text: &str) -> Result<f64, String> {
    plain_number(text)
        .filter(|x| *x > 0.0 && *x <= MAX_TIMING)
        .ok_or_else(|| format!("must be a number above 0, at most {MAX_TIMING}"))
}

/// `A..B`, both included.
pub fn frames(text: &str) -> Result<RangeInclusive<u64>, String> {
    let both = text.split_once("..");
    let ends = both.and_then(|(a, b)| Some((digits::<u64>(a)?, digits::<u64>(b)?)));
    match ends {
        Some((a, b)) if a <= b => Ok(a..=b),
        Some(_) => Err("the first frame comes after the last one".to_owned()),
        None => Err("must be FIRST..LAST, like 0..16 (both included)".to_owned()),
    }
}

/// A number as the scene format writes it: no `inf` or `nan`.
fn plain_number(text: &str) -> Option<f64> {
    // The rest of the grammar is that of Rust's own parser.
    let plain = |b: u8| b.is_ascii_digit() || b"+-.eE".contains(&b);
    if text.bytes().all(plain) {
        text.parse().ok()
    } else {
        None
    }
}

/// `--camera`: E, O, A, B as the format orders them and by all its rules.
pub fn camera(text: &str) -> Result<CameraCorners, String> {
    let words: Vec<&str> = text.split_ascii_whitespace().collect();
    if words.len() != 12 {
        let n = words.len();
        return Err(format!("needs 12 numbers (E, O, A, B), has {n}"));
    }
    // The parser knows the rules: it reads a scene with this camera and nothing else.
    let scene = format!("<s {} 0 0 -1 0", words.join(" "));
    match scene::parse(scene.as_bytes()) {
        Ok(Scene {
            camera: CameraSetting::Set(corners),
            ..
        }) => Ok(corners),
        Ok(_) => Err("is no camera".to_owned()),
        Err(e) => Err(e.errors[0].kind.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_two_sides_within_the_limits() {
        let size = |width, height| Ok(Size { width, height });
        assert_eq!("640x480".parse(), size(640, 480));
        assert_eq!("1x16384".parse(), size(1, 16384));
        for bad in [
            "",
            "x",
            "640",
            "640x",
            "x480",
            "0x1",
            "1x0",
            "16385x1",
            "1x1x1",
            "+1x1",
            "1X1",
            "-1x1",
            "1 x1",
            "99999999999999999999x1",
            "１x1",
        ] {
            assert!(bad.parse::<Size>().is_err(), "{bad}");
        }
    }

    #[test]
    fn numbers_keep_to_their_ranges() {
        assert_eq!(threads("0"), Ok(0));
        assert_eq!(threads("1024"), Ok(1024));
        assert!(threads("1025").is_err() && threads("-1").is_err() && threads("two").is_err());
        assert_eq!(timing("1e-3"), Ok(0.001));
        for bad in ["0", "-1", "nan", "inf", "1e7", "", "0x10", "1,5"] {
            assert!(timing(bad).is_err(), "{bad}");
        }
        assert_eq!(frames("3..5"), Ok(3..=5));
        for bad in ["5..3", "3", "..", "1..", "..1", "1...3", "-1..3", "1..=3"] {
            assert!(frames(bad).is_err(), "{bad}");
        }
        assert_eq!(samples("16").map(Samples::count), Ok(16));
        for bad in ["0", "3", "128", "-1", "1.0", ""] {
            assert!(samples(bad).is_err(), "{bad}");
        }
        assert_eq!(cost_scale("1048576"), Ok(1 << 20));
        assert!(cost_scale("0").is_err() && cost_scale("1048577").is_err());
        assert!(count("0").is_err() && count("30") == Ok(30));
    }

    #[test]
    fn cameras_have_twelve_numbers_and_a_plane_apart_from_the_eye() {
        let good = camera("0 0 5  -1 1 0  1 1 0  -1 -1.e0 0").unwrap();
        assert_eq!(good.eye.to_array(), [0.0, 0.0, 5.0]);
        assert_eq!(good.bottom_left.to_array(), [-1.0, -1.0, 0.0]);
        let text = |s: &str| camera(s).unwrap_err();
        assert_eq!(text("1 2 3"), "needs 12 numbers (E, O, A, B), has 3");
        assert_eq!(
            text("0 0 5 -1 1 0 1 1 0 -1 -1 0 7"),
            "needs 12 numbers (E, O, A, B), has 13"
        );
        for (bad, why) in [
            ("0 0 nan -1 1 0 1 1 0 -1 -1 0", "z of the eye"),
            ("0 0 1e99 -1 1 0 1 1 0 -1 -1 0", "found \"1e99\""),
            ("0 0 5 -1 1 0 1 1 0 3 1 0", "one line"),
            ("9 9 0 -1 1 0 1 1 0 -1 -1 0", "in that plane"),
            ("0 0 5 -1 1 0 1 1 0 -1 -1 #", "expected"),
        ] {
            assert!(text(bad).contains(why), "{bad}: {}", text(bad));
        }
    }
}
