//! What is wrong with a file, in lines for the window: long ones are wrapped, and what is left out says so.

use crate::app::loader::LoadError;
use crate::app::overlay::Line;

/// The most lines and letters of a line that are shown.
const MAX_LINES: usize = 14;
const MAX_LETTERS: usize = 80;

/// The error as the window shows it.
pub(super) fn lines_of(error: &LoadError) -> Vec<Line> {
    let words = error.words(false);
    let mut lines: Vec<String> = words.lines().flat_map(fitted).collect();
    if lines.len() > MAX_LINES {
        let more = lines.len() - (MAX_LINES - 1);
        lines.truncate(MAX_LINES - 1);
        lines.push(format!("… {more} more lines"));
    }
    lines.iter().map(|line| Line::new("", line)).collect()
}

/// A line of the error in as many as it takes. One of the text stays above its caret: it is cut, far behind that.
fn fitted(line: &str) -> Vec<String> {
    let is_of_text = line
        .trim_start_matches(|c: char| c == ' ' || c.is_ascii_digit())
        .starts_with('|');
    let letters = line.chars().count();
    if letters <= MAX_LETTERS {
        vec![line.to_owned()]
    } else if is_of_text {
        vec![line.chars().take(MAX_LETTERS - 1).chain(['…']).collect()]
    } else {
        wrapped(line)
    }
}

/// Breaks a line between words, or in a word that is longer than a line.
fn wrapped(line: &str) -> Vec<String> {
    let mut rest: Vec<char> = line.chars().collect();
    let mut lines = Vec::new();
    while rest.len() > MAX_LETTERS {
        // Spaces in front are no place to break.
        let is_break = |at: &usize| rest[*at] == ' ' && rest[..*at].iter().any(|&c| c != ' ');
        let end = (1..=MAX_LETTERS).rev().find(is_break);
        let tail = rest.split_off(end.unwrap_or(MAX_LETTERS));
        lines.push(rest.into_iter().collect());
        rest = tail.into_iter().skip_while(|&c| c == ' ').collect();
    }
    lines.push(rest.into_iter().collect());
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(words: &str) -> Vec<String> {
        let lines = lines_of(&LoadError::Unreadable(words.to_owned()));
        lines.into_iter().map(|line| line.text).collect()
    }

    #[test]
    fn every_word_of_a_long_error_is_there_and_no_line_is_longer_than_may_be() {
        let words = "scene.txt:7:1: ".to_owned() + &"expected a number, found \"abc\" ".repeat(7);
        let lines = shown(&words);
        assert!(lines.len() > 1 && lines.iter().all(|l| l.chars().count() <= MAX_LETTERS));
        assert_eq!(lines.join(" ").trim_end(), words.trim_end());
        let path = "/a".repeat(100);
        assert_eq!(shown(&path).concat(), path);
    }

    #[test]
    fn a_line_of_the_text_stays_above_its_caret() {
        let source = format!("12 | {}", "9 ".repeat(60));
        let caret = "   | ^".to_owned();
        let lines = shown(&format!("scene.txt:12:1: no\n{source}\n{caret}"));
        assert_eq!(lines.len(), 3);
        assert!(source.starts_with(lines[1].trim_end_matches('…')) && lines[1].ends_with('…'));
        assert_eq!(lines[2], caret);
    }

    #[test]
    fn an_error_of_many_lines_says_how_many_are_left_out() {
        let lines = shown(&"no\n".repeat(20));
        assert_eq!(lines.len(), MAX_LINES);
        assert_eq!(lines[MAX_LINES - 1], "… 7 more lines");
        assert_eq!(shown(&"no\n".repeat(MAX_LINES)).len(), MAX_LINES);
    }
}
