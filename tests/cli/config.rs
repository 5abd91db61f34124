//! The settings file: found, followed, and mistakes in it.

use crate::support::Folder;

/// A folder with the user's own settings.
fn with_settings(text: &str) -> Folder {
    let folder = Folder::new();
    std::fs::create_dir_all(folder.path("config/raybomb")).expect("a folder");
    folder.write("config/raybomb/config.toml", text);
    folder
}

#[test]
fn the_users_keys_are_listed_and_other_settings_win_or_none() {
    let folder = with_settings("[keys]\nquit = \"Ctrl+w\"\n");
    folder.write("other.toml", "[keys]\nquit = \"x\"\n");
    let listed = |args: &[&str]| {
        let all = [&["view", "--list-bindings"], args].concat();
        let text = folder.run(&all).ok().stdout;
        let line = text.lines().find(|line| line.starts_with("quit = "));
        let (entry, _) = line
            .expect("quit is listed")
            .split_once("  # ")
            .expect("words");
        entry.trim_end().to_owned()
    };
    assert_eq!(listed(&[]), "quit = \"Ctrl+w\"");
    assert_eq!(listed(&["--config", "other.toml"]), "quit = \"x\"");
    assert_eq!(listed(&["--no-config"]), "quit = [\"q\", \"Ctrl+q\"]");
}

#[test]
fn mistakes_end_windows_with_1_and_their_places_and_nothing_else() {
    let folder = with_settings("[keys]\nqiut = \"x\"\n[options]\naa = 3\n");
    for args in [
        &["scene.txt"][..],
        &["view", "scene.txt"],
        &["demo", "cube"],
        &[],
    ] {
        let run = folder.run(args).code_is(1);
        let run = run.says("config.toml:2:1: there is no action or gesture called \"qiut\"");
        let run = run
            .says("help: is \"quit\" meant?")
            .says("\n4 | aa = 3\n  |      ^\n");
        run.says("hint: `--no-config`");
    }
    folder.run(&["view", "scene.txt", "--no-config"]).code_is(4);
    folder.run(&["render", "scene.txt", "--size", "9x9"]).ok();
    folder.run(&["demo"]).ok();
    folder.run(&["demo", "cube", "--write", "cube.txt"]).ok();
}

#[test]
fn a_file_that_is_asked_for_must_be_there() {
    let folder = Folder::new();
    folder
        .run(&["view", "scene.txt", "--config", "none.toml"])
        .code_is(1)
        .says("cannot read none.toml: no such file");
    folder
        .run(&["view", "scene.txt", "--config", "a", "--no-config"])
        .code_is(2);
}
