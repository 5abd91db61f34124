//! README.md and docs/ tell the truth: their scenes are scenes, their mistakes are told so, their options are there.

use std::collections::BTreeSet;
use std::path::Path;

use crate::help::{COMMANDS, help, options};
use crate::support::Folder;

const PAGES: [&str; 4] = [
    "README.md",
    "docs/format.md",
    "docs/tracer.md",
    "docs/viewer.md",
];

/// Options of `cargo` and of the programs in `benches/`.
const OF_OTHERS: [&str; 8] = [
    "--f3d",
    "--first",
    "--help",
    "--idle",
    "--locked",
    "--path",
    "--release",
    "--teapot",
];

fn page(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(name);
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// The ```` ```text ```` blocks of a page.
fn blocks(page: &str) -> Vec<&str> {
    let starts = page.split("\n```text\n").skip(1);
    starts
        .map(|rest| rest.split("```").next().expect("a first part"))
        .collect()
}

/// Those blocks that are scenes, of which there must be one.
fn scene_of(page: &str) -> &str {
    let scenes: Vec<&str> = blocks(page)
        .into_iter()
        .filter(|block| block.starts_with("<"))
        .collect();
    assert_eq!(scenes.len(), 1, "{scenes:?}");
    scenes[0]
}

#[test]
fn the_scenes_of_the_pages_are_scenes_and_show_something() {
    let folder = Folder::new();
    for name in ["README.md", "docs/format.md"] {
        folder.write("page.txt", scene_of(&page(name)));
        let checked = folder.run(&["check", "page.txt"]).ok();
        assert_eq!(checked.stderr, "", "{name}");
        let picture = ["render", "page.txt", "--size", "40x30", "--hash"];
        folder.write("none.txt", "<d 0 0 -1 0");
        let none = ["render", "none.txt", "--size", "40x30", "--hash"];
        assert_ne!(folder.hash(&picture), folder.hash(&none), "{name}");
    }
}

#[test]
fn the_mistake_in_the_readme_is_told_as_it_says() {
    let readme = page("README.md");
    let told = blocks(&readme)
        .into_iter()
        .find(|block| block.starts_with("scene.txt:"))
        .expect("a mistake");
    let folder = Folder::new();
    folder.write("scene.txt", scene_of(&readme).replace("0 1.5 0", "0 1,5 0"));
    let run = folder.run(&["check", "scene.txt"]).code_is(3);
    assert_eq!(run.stderr, told);
}

#[test]
fn the_pages_name_no_option_that_is_not_there() {
    let mut known: BTreeSet<String> = OF_OTHERS.map(str::to_owned).into();
    for command in [&[][..]]
        .into_iter()
        .chain(COMMANDS.iter().map(std::slice::from_ref))
    {
        known.extend(options(&help(command)));
    }
    for name in PAGES {
        let unknown: Vec<String> = options(&page(name)).difference(&known).cloned().collect();
        assert_eq!(unknown, [""; 0], "{name}");
    }
}
