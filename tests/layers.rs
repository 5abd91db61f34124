//! The order of the modules that `src/lib.rs` tells is the one that they keep.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

/// The number in the list of each module that it names.
fn layers(lib: &str) -> HashMap<&str, usize> {
    let mut layers = HashMap::new();
    let mut layer = 0;
    for line in lib.lines().filter_map(|line| line.strip_prefix("//! ")) {
        if line.starts_with(|c: char| c.is_ascii_digit()) {
            layer += 1;
        }
        for name in line.split("[`").skip(1) {
            let name = name.split('`').next().expect("a name");
            assert_eq!(layers.insert(name, layer), None, "{name} is named twice");
        }
    }
    layers
}

fn rust_files(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            rust_files(&path, files);
        } else if path.extension().is_some_and(|e| e == "rs") {
            files.push(path);
        }
    }
}

#[test]
fn no_module_uses_one_of_a_later_layer() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let lib = fs::read_to_string(src.join("lib.rs")).expect("src/lib.rs");
    let layers = layers(&lib);
    for module in lib.lines().filter_map(|line| line.strip_prefix("pub mod ")) {
        let name = module.trim_end_matches(';');
        assert!(layers.contains_key(name), "the list has no {name}");
    }
    let mut files = Vec::new();
    rust_files(&src, &mut files);
    let mut uses = 0;
    for path in &files {
        let file = path
            .strip_prefix(&src)
            .expect("a file of src")
            .with_extension("");
        let name = file.iter().next().expect("a name").to_str().expect("UTF-8");
        let Some(own) = layers.get(name) else {
            continue;
        };
        if file.iter().any(|part| part == "tests") {
            continue;
        }
        let text = fs::read_to_string(path).expect("a file");
        // What tests use is another matter.
        let code = text
            .split("\n#[cfg(test)]\nmod tests")
            .next()
            .expect("a first part");
        for line in code
            .lines()
            .filter(|line| !line.trim_start().starts_with("//"))
        {
            for used in line.split("crate::").skip(1) {
                let end = used.find(|c: char| !c.is_ascii_lowercase() && c != '_');
                let used = &used[..end.unwrap_or(used.len())];
                if let Some(layer) = layers.get(used) {
                    uses += 1;
                    assert!(
                        layer <= own,
                        "{}: uses {used} of a later layer",
                        path.display()
                    );
                }
            }
        }
    }
    assert!(uses > 200, "{uses} uses in {} files", files.len());
}

/// A clock that someone sets must not hold up, hurry or end anything: time is [`std::time::Instant`]. Only a file's own stamp
/// is of the wall clock, and is compared for being the same.
#[test]
fn nothing_but_a_files_stamp_looks_at_the_wall_clock() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    rust_files(&src, &mut files);
    let looks = |path: &&PathBuf| {
        let text = fs::read_to_string(path).expect("a file");
        text.contains("SystemTime") || text.contains("UNIX_EPOCH")
    };
    let found: Vec<&PathBuf> = files.iter().filter(looks).collect();
    assert_eq!(found, [&src.join("app/save.rs")]);
    let save = fs::read_to_string(found[0]).expect("a file");
    assert!(!save.contains("SystemTime::now"));
}
