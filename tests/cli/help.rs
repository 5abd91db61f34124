//! `--help`: complete, and in agreement with the README.

use std::collections::BTreeSet;

use crate::support::Folder;

pub const COMMANDS: [&str; 7] = ["view", "render", "anim", "check", "info", "bench", "demo"];

const PICTURE: [&str; 10] = [
    "--size",
    "--view",
    "--aa",
    "--engine",
    "--kernel",
    "--threads",
    "--reflection",
    "--cost-scale",
    "--stretch",
    "--pivot",
];
const TIME: [&str; 4] = ["--fps", "--seconds-per-op", "--ease", "--steps"];
const WINDOW: [&str; 10] = [
    "--play",
    "--kiosk",
    "--no-overlay",
    "--target-fps",
    "--print-picks",
    "--list-bindings",
    "--play-actions",
    "--record-actions",
    "--config",
    "--no-config",
];

/// What `--help` prints behind `args`.
pub fn help(args: &[&str]) -> String {
    let run = Folder::new().run(&[args, &["--help"]].concat()).ok();
    assert_eq!(run.stderr, "");
    run.stdout
}

/// All `--options` in `text`.
pub fn options(text: &str) -> BTreeSet<String> {
    text.split(|c: char| c.is_whitespace() || "`,[]|()".contains(c))
        .map(|word| word.trim_end_matches(['.', ':', ';']))
        .filter(|word| {
            word.strip_prefix("--")
                .is_some_and(|w| w.starts_with(char::is_alphabetic))
        })
        .map(str::to_owned)
        .collect()
}

#[test]
fn the_help_of_each_command_has_its_options_and_no_others() {
    let window = [&WINDOW[..], &PICTURE[..], &TIME].concat();
    let render = [
        &["--output", "--frame", "--camera", "--hash"],
        &PICTURE[..],
        &TIME,
    ]
    .concat();
    let anim = [&["--output", "--frames", "--hash"], &PICTURE[..], &TIME].concat();
    let bench = [
        "--size",
        "--threads",
        "--kernel",
        "--engine",
        "--workload",
        "--coarse",
        "--stages",
        "--scaling",
        "--frames",
        "--json",
    ];
    for (command, expected) in [
        (&[][..], &[&["--version"], &window[..]].concat()[..]),
        (&["view"], &window[..]),
        (&["render"], &render[..]),
        (&["anim"], &anim[..]),
        (&["check"], &["--all-warnings"]),
        (&["info"], &["--json"]),
        (&["bench"], &bench[..]),
    ] {
        let text = help(command);
        // Options are named at the start of a line or after the short form; texts may mention others.
        let defined: BTreeSet<String> = text
            .lines()
            .map(str::trim_start)
            .filter(|l| l.starts_with('-'))
            .flat_map(|l| options(l).into_iter().take(1))
            .collect();
        let expected: BTreeSet<String> = expected
            .iter()
            .chain(&["--help"])
            .map(|s| (*s).to_owned())
            .collect();
        assert_eq!(defined, expected, "{command:?}");
    }
}

#[test]
fn the_help_of_demo_has_its_option() {
    assert!(options(&help(&["demo"])).contains("--write"));
}

#[test]
fn every_help_shows_the_exit_codes() {
    for command in [&[][..]]
        .into_iter()
        .chain(COMMANDS.iter().map(std::slice::from_ref))
    {
        let text = help(command);
        for code in ["0", "1", "2", "3", "4", "5", "130"] {
            let line = format!("\n{:>5}  ", code);
            assert!(
                text.contains(&line),
                "{code} in the help of {command:?}: {text}"
            );
        }
    }
}

#[test]
fn the_main_help_lists_the_commands_and_version_tells_the_version() {
    let text = help(&[]);
    for command in COMMANDS {
        assert!(
            text.contains(&format!("\n  {command} ")),
            "{command}: {text}"
        );
    }
    let run = Folder::new().run(&["--version"]).ok();
    assert_eq!(
        run.stdout,
        format!("raybomb {}\n", env!("CARGO_PKG_VERSION"))
    );
}

#[test]
fn the_readme_names_every_command_and_option() {
    let readme = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/README.md"))
        .expect("there is a README.md");
    let named = options(&readme);
    for command in COMMANDS {
        assert!(readme.contains(&format!("raybomb {command}")), "{command}");
        for option in options(&help(&[command])) {
            assert!(named.contains(&option), "README.md does not name {option}");
        }
    }
}

/// The chords and the words of each line of the table of keys that the program prints.
fn bindings(listing: &str) -> Vec<(Vec<&str>, &str)> {
    let lines = listing.lines().skip_while(|line| *line != "[keys]");
    lines
        .skip(1)
        .map(|line| {
            let (entry, says) = line.split_once("  # ").expect("words");
            let (_, value) = entry.split_once(" = ").expect("a name and chords");
            let chords = value.trim().trim_matches(['[', ']']).split(", ");
            (chords.map(|c| &c[1..c.len() - 1]).collect(), says)
        })
        .collect()
}

#[test]
fn the_readme_has_the_table_of_keys_that_the_program_prints() {
    let run = Folder::new().run(&["--list-bindings"]).ok();
    let mut rows: Vec<(String, &str)> = Vec::new();
    for (chords, says) in bindings(&run.stdout) {
        let chords = format!("`{}`", chords.join("` `"));
        match rows.last_mut() {
            Some((row, same)) if *same == says => *row += &format!(" {chords}"),
            _ => rows.push((chords, says)),
        }
    }
    let rows: Vec<String> = rows
        .iter()
        .map(|(chords, says)| format!("| {chords} | {says} |"))
        .collect();
    assert!(rows.len() > 20, "{rows:?}");
    let readme = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/README.md"))
        .expect("there is a README.md");
    let keys = readme.split("\n## ").find(|part| part.starts_with("Keys"));
    let table: Vec<&str> = keys
        .expect("a section on keys")
        .lines()
        .filter(|line| line.starts_with("| `"))
        .collect();
    assert_eq!(table, rows);
}

#[test]
fn the_page_about_the_window_names_every_key() {
    let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/viewer.md"))
        .expect("there is a docs/viewer.md");
    let run = Folder::new().run(&["--list-bindings"]).ok();
    let bindings = bindings(&run.stdout);
    assert!(bindings.len() > 20, "{bindings:?}");
    for chord in bindings.into_iter().flat_map(|(chords, _)| chords) {
        assert!(page.contains(&format!("`{chord}`")), "no `{chord}`");
    }
}
