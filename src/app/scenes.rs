//! The order of a folder's scenes, and the one that stands for all of them.

use std::path::{Path, PathBuf};

use super::opener::scenes_in;

/// A part of a name.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    /// How many digits, without zeros in front, and which: compared as the number.
    Number(usize, String),
    /// In lower case.
    Text(String),
}

/// Sorts names as people do: `s2` before `s10`, capitals among the others.
#[must_use]
pub fn by_name(path: &Path) -> (Vec<Part>, PathBuf) {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let mut parts = Vec::new();
    let mut rest = &*name;
    while let Some(first) = rest.chars().next() {
        let is_number = first.is_ascii_digit();
        let end = rest.find(|c: char| c.is_ascii_digit() != is_number);
        let (part, after) = rest.split_at(end.unwrap_or(rest.len()));
        parts.push(if is_number {
            let digits = part.trim_start_matches('0');
            Part::Number(digits.len(), digits.to_owned())
        } else {
            Part::Text(part.to_lowercase())
        });
        rest = after;
    }
    (parts, path.to_owned())
}

/// The first scene of a folder; any other path as it is.
#[must_use]
pub fn first_scene(path: PathBuf) -> PathBuf {
    let scenes = scenes_in(&path).unwrap_or_default();
    scenes.into_iter().next().unwrap_or(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_come_in_the_order_of_people_and_the_first_stands_for_the_folder() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = |name: &str| folder.path().join(name);
        assert_eq!(first_scene(folder.path().to_owned()), folder.path());
        let sorted = ["a.txt", "B.txt", "s2.txt", "S02b.txt", "s10.txt", "Z.TXT"];
        for name in sorted {
            std::fs::write(path(name), "").expect("written");
        }
        let expected: Vec<PathBuf> = sorted.iter().map(|name| path(name)).collect();
        assert_eq!(scenes_in(folder.path()).expect("a list"), expected);
        assert_eq!(first_scene(folder.path().to_owned()), path("a.txt"));
        assert_eq!(first_scene(path("B.txt")), path("B.txt"));
    }
}
