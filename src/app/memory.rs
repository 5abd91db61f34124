//! The window's size and place, remembered from one start to the next.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::export::write_whole;

const FILE: &str = "window.json";
/// A window below that is too small to be meant.
const MIN_SIDE: u32 = 64;
const MAX_SIDE: u32 = 16384;
/// So much of a window must lie on a screen, each way.
const ON_SCREEN_PX: i32 = 32;

/// Where a window stands, and how large it is, in physical pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Placement {
    size: Option<(u32, u32)>,
    place: Option<(i32, i32)>,
}

impl Placement {
    /// What is not understood is not there.
    fn of_text(text: &str) -> Placement {
        let value: Value = serde_json::from_str(text).unwrap_or_default();
        let number = |key: &str, i: usize| value[key][i].as_i64();
        let pair = |key: &str| Some((number(key, 0)?, number(key, 1)?));
        let side = |n: i64| u32::try_from(n).ok().filter(|n| is_side(*n));
        let size = pair("size").and_then(|(w, h)| Some((side(w)?, side(h)?)));
        let place = pair("place");
        let place = place.and_then(|(x, y)| Some((x.try_into().ok()?, y.try_into().ok()?)));
        Placement { size, place }
    }

    fn text(self) -> String {
        let mut value = json!({});
        if let Some((width, height)) = self.size {
            value["size"] = json!([width, height]);
        }
        if let Some((x, y)) = self.place {
            value["place"] = json!([x, y]);
        }
        format!("{value}\n")
    }
}

fn is_side(n: u32) -> bool {
    (MIN_SIDE..=MAX_SIDE).contains(&n)
}

/// A screen: its corner and its size.
pub type Screen = ((i32, i32), (u32, u32));

/// What is known of the window, and was known at the start.
#[derive(Debug, Default)]
pub struct Memory {
    /// Where it is kept; `None`: it is not.
    folder: Option<PathBuf>,
    before: Placement,
    now: Placement,
    /// The size that the program gave the window.
    given: Option<(u32, u32)>,
    /// The next size is given too.
    is_rescaled: bool,
}

impl Memory {
    /// What is remembered in that folder.
    #[must_use]
    pub fn of(folder: Option<PathBuf>) -> Memory {
        let text = folder
            .as_ref()
            .and_then(|f| fs::read_to_string(f.join(FILE)).ok());
        Memory {
            folder,
            before: text.map_or(Placement::default(), |text| Placement::of_text(&text)),
            ..Memory::default()
        }
    }

    /// The size that a hand gave the last window.
    #[must_use]
    pub fn size(&self) -> Option<(u32, u32)> {
        self.before.size
    }

    /// The place of the last window, if it is on one of the `screens` that there are.
    #[must_use]
    pub fn place(&self, screens: impl IntoIterator<Item = Screen>) -> Option<(i32, i32)> {
        let (x, y) = self.before.place?;
        let holds = |((left, top), (width, height)): Screen| {
            let within = |at: i32, from: i32, length: u32| {
                let after = i64::from(at) - i64::from(from);
                (0..=i64::from(length) - i64::from(ON_SCREEN_PX)).contains(&after)
            };
            within(x, left, width) && within(y, top, height)
        };
        screens.into_iter().any(holds).then_some((x, y))
    }

    /// The program gives the window a size.
    pub fn gives(&mut self, size: (u32, u32)) {
        self.given = Some(size);
    }

    /// The size that the program gave the window, unless a hand has given it another.
    #[must_use]
    pub fn given(&self) -> Option<(u32, u32)> {
        self.given.filter(|_| self.given == self.now.size)
    }

    /// The window's screen has another scale factor. The size that follows from it is no hand's choice.
    pub fn rescaled(&mut self) {
        self.is_rescaled = self.given().is_some();
    }

    /// The window has that size.
    pub fn sized(&mut self, size: (u32, u32)) {
        if std::mem::take(&mut self.is_rescaled) {
            self.given = Some(size);
        }
        self.now.size = Some(size);
    }

    /// The window stands there.
    pub fn moved(&mut self, place: (i32, i32)) {
        self.now.place = Some(place);
    }

    /// The program ends: the place is kept, and the size if a hand chose it.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn keep(&self) -> io::Result<()> {
        let chosen = self.now.size.filter(|size| {
            let is_sane = is_side(size.0) && is_side(size.1);
            is_sane && self.given != Some(*size)
        });
        let after = Placement {
            size: chosen.or(self.before.size),
            place: self.now.place.or(self.before.place),
        };
        match &self.folder {
            Some(folder) if after != self.before => write(folder, after),
            _ => Ok(()),
        }
    }
}

fn write(folder: &Path, placement: Placement) -> io::Result<()> {
    fs::create_dir_all(folder)?;
    let text = placement.text();
    write_whole(&folder.join(FILE), |out| out.write_all(text.as_bytes()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCREEN: Screen = ((100, 0), (1000, 800));

    #[test]
    fn a_chosen_size_and_the_place_come_back_and_a_given_size_does_not() {
        let folder = tempfile::tempdir().expect("a folder");
        let folder = Some(folder.path().join("not/yet/there"));
        let mut memory = Memory::of(folder.clone());
        assert_eq!((memory.size(), memory.place([SCREEN])), (None, None));
        memory.gives((640, 480));
        memory.sized((640, 480));
        memory.moved((130, 20));
        memory.keep().expect("kept");
        let mut memory = Memory::of(folder.clone());
        assert_eq!(memory.size(), None);
        assert_eq!(memory.place([SCREEN]), Some((130, 20)));
        memory.gives((640, 480));
        memory.sized((700, 500));
        memory.keep().expect("kept");
        let mut memory = Memory::of(folder.clone());
        assert_eq!(memory.size(), Some((700, 500)));
        assert_eq!(memory.place([SCREEN]), Some((130, 20)));
        for tiny in [(1, 1), (0, 500)] {
            memory.sized(tiny);
            memory.keep().expect("kept");
        }
        assert_eq!(Memory::of(folder).size(), Some((700, 500)));
    }

    #[test]
    fn a_size_that_follows_from_another_scale_factor_is_nobodys_choice() {
        let folder = tempfile::tempdir().expect("a folder");
        let kept = |sizes: &[(u32, u32)]| {
            let folder = folder.path().join(format!("{}", sizes.len()));
            let mut memory = Memory::of(Some(folder.clone()));
            memory.gives((640, 480));
            memory.sized((640, 480));
            for &size in sizes {
                memory.sized(size);
                memory.rescaled();
                memory.sized((2 * size.0, 2 * size.1));
            }
            memory.keep().expect("kept");
            Memory::of(Some(folder)).size()
        };
        assert_eq!(kept(&[(640, 480)]), None);
        assert_eq!(kept(&[(640, 480), (1280, 960)]), None);
        assert_eq!(
            kept(&[(640, 480), (1280, 960), (700, 500)]),
            Some((1400, 1000))
        );
    }

    #[test]
    fn a_place_that_no_screen_shows_is_forgotten() {
        let at = |x: i32, y: i32| {
            let text = format!("{{\"place\": [{x}, {y}]}}");
            let before = Placement::of_text(&text);
            let memory = Memory {
                before,
                ..Memory::default()
            };
            memory.place([SCREEN])
        };
        assert_eq!(at(100, 0), Some((100, 0)));
        assert_eq!(at(1068, 768), Some((1068, 768)));
        for (x, y) in [
            (99, 0),
            (1069, 0),
            (100, 769),
            (100, -1),
            (i32::MIN, i32::MAX),
        ] {
            assert_eq!(at(x, y), None);
        }
    }

    #[test]
    fn a_file_that_says_something_else_says_nothing() {
        for text in [
            "",
            "{",
            "7",
            "{\"size\": [1, 1]}",
            "{\"size\": [700.5, 500], \"place\": [1]}",
            "{\"size\": [-700, 500], \"place\": [1, 99999999999]}",
            "{\"size\": [99999999999, 500]}",
        ] {
            assert_eq!(Placement::of_text(text), Placement::default(), "{text}");
        }
    }

    #[test]
    fn without_a_folder_nothing_is_kept() {
        let mut memory = Memory::of(None);
        memory.moved((1, 2));
        assert!(memory.keep().is_ok());
    }
}
