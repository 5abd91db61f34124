//! Ctrl+C and worse: no half file, ever.

use std::os::unix::process::ExitStatusExt;
use std::process::Stdio;

use crate::support::{Folder, Picture, Run, SCENE, names_in, signal, wait_until};

/// An animation that takes hours.
#[rustfmt::skip]
const ENDLESS: [&str; 8] = [
    "anim", "scene.txt", "--size", "400x300", "--fps", "1e6", "-o", "out/{frame}.png",
];

/// Starts [`ENDLESS`], waits for its frame 3, and sends it a signal.
fn stopped(folder: &Folder, name: &str) -> Run {
    let mut child = folder
        .command(&ENDLESS)
        .stderr(Stdio::null())
        .spawn()
        .expect("the program starts");
    wait_until("frame 3", || folder.path("out/3.png").exists());
    signal(&child, name);
    let status = child.wait().expect("the program ends");
    Run {
        code: status.code().or(status.signal().map(|s| -s)),
        stdout: String::new(),
        stderr: String::new(),
    }
}

/// Every picture in `out` is whole; gives the names of everything else.
fn other_files(folder: &Folder) -> Vec<String> {
    let (pictures, others): (Vec<String>, Vec<String>) = names_in(&folder.path("out"))
        .into_iter()
        .partition(|n| n.ends_with(".png"));
    for name in pictures {
        Picture::from_png(&folder.read(&format!("out/{name}")));
    }
    others
}

#[test]
fn ctrl_c_leaves_whole_pictures_only() {
    for signal in ["INT", "TERM"] {
        let folder = Folder::new();
        stopped(&folder, signal).code_is(130);
        assert_eq!(other_files(&folder), [""; 0]);
    }
}

#[test]
fn a_killed_program_leaves_no_half_picture() {
    let folder = Folder::new();
    stopped(&folder, "KILL").code_is(-9);
    assert!(other_files(&folder).len() <= 1);
}

#[test]
fn ctrl_c_while_a_scene_is_read_keeps_the_old_picture() {
    let folder = Folder::new();
    folder.write("x.bmp", "old");
    let mut child = folder.start(&["render", "-", "-o", "x.bmp"]);
    let mut stdin = child.stdin.take().unwrap();
    std::io::Write::write_all(&mut stdin, &SCENE.as_bytes()[..100]).unwrap();
    // The handler must be there before the signal: it is, once the program waits for more.
    std::thread::sleep(std::time::Duration::from_millis(500));
    signal(&child, "INT");
    Run::from(child.wait_with_output().unwrap()).code_is(130);
    assert_eq!(folder.read("x.bmp"), b"old");
    assert_eq!(folder.names(), ["scene.txt", "x.bmp"]);
}

#[test]
fn a_failed_render_keeps_the_old_picture() {
    let folder = Folder::new();
    folder.write("x.bmp", "old");
    folder.write("bad.txt", "<d 0 0 -1 7");
    folder.run(&["render", "bad.txt", "-o", "x.bmp"]).code_is(3);
    assert_eq!(folder.read("x.bmp"), b"old");
    folder.run(&["render", "scene.txt", "-o", "x.bmp"]).ok();
    Picture::from_bmp(&folder.read("x.bmp"));
    assert_eq!(folder.names(), ["bad.txt", "scene.txt", "x.bmp"]);
}
