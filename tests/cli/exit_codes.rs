//! Every way to fail: its exit code, and a message that names what is wrong.

use std::process::Stdio;

use crate::support::{Folder, Run};

#[test]
fn missing_files_and_folders_are_failures_that_name_the_path() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("dir")).unwrap();
    for command in ["view", "render", "check", "info", "bench"] {
        folder
            .run(&[command, "nowhere.txt"])
            .code_is(1)
            .says("error: cannot read nowhere.txt: no such file");
        folder
            .run(&[command, "dir"])
            .code_is(1)
            .says("error: cannot read dir: it is a folder");
    }
    folder.run(&["anim", "nowhere.txt", "--hash"]).code_is(1);
    folder.run(&["nowhere.txt"]).code_is(1).says("nowhere.txt");
}

#[test]
fn output_that_cannot_be_written_is_a_failure_that_names_the_path() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("dir.bmp")).unwrap();
    let render = |out: &str| folder.run(&["render", "scene.txt", "--size", "9x9", "-o", out]);
    render("dir.bmp")
        .code_is(1)
        .says("cannot write dir.bmp: it is a folder");
    let missing = "cannot write no/x.bmp: the folder no does not exist";
    render("no/x.bmp").code_is(1).says(missing);
    let not_a_folder = "cannot write scene.txt/x.bmp: ";
    render("scene.txt/x.bmp").code_is(1).says(not_a_folder);
    folder.write("file", "");
    folder
        .run(&[
            "anim",
            "scene.txt",
            "--size",
            "9x9",
            "-o",
            "file/{frame}.bmp",
        ])
        .code_is(1)
        .says("cannot make the folder file");
    folder
        .run(&["demo", first_demo(&folder).as_str(), "--write", "no/x.txt"])
        .code_is(1)
        .says("no/x.txt");
    assert_eq!(folder.names(), ["dir.bmp", "file", "scene.txt"]);
}

fn first_demo(folder: &Folder) -> String {
    let list = folder.run(&["demo"]).ok().stdout;
    list.split_whitespace().next().expect("a demo").to_owned()
}

#[cfg(target_os = "linux")]
#[test]
fn devices_are_written_directly_and_a_full_one_is_a_failure() {
    let folder = Folder::new();
    let render = ["render", "scene.txt", "--size", "99x99", "-o"];
    folder
        .run(&[&render[..], &["/dev/full"]].concat())
        .code_is(1)
        .says("cannot write /dev/full: No space left on device");
    let to_stdout = folder
        .command(&[&render[..], &["/dev/stdout"]].concat())
        .output()
        .unwrap();
    assert!(to_stdout.status.success());
    folder.run(&[&render[..], &["x.bmp"]].concat()).ok();
    assert_eq!(to_stdout.stdout, folder.read("x.bmp"));
    let dash = folder
        .command(&[&render[..], &["-"]].concat())
        .output()
        .unwrap();
    assert_eq!(dash.stdout, to_stdout.stdout);
    let full = std::fs::File::create("/dev/full").unwrap();
    let printing = folder
        .command(&["info", "scene.txt"])
        .stdout(full)
        .output()
        .unwrap();
    let run = Run::from(printing).code_is(1);
    run.says("cannot write to the standard output: No space left on device");
}

#[test]
fn nobody_reading_is_no_reason_for_words() {
    let folder = Folder::new();
    let mut child = folder
        .command(&["info", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    std::io::Write::write_all(&mut child.stdin.take().unwrap(), b"<d 0 0 -1 0").unwrap();
    let run = Run::from(child.wait_with_output().unwrap());
    assert_eq!(run.code_is(1).stderr, "");
}

#[cfg(target_os = "linux")]
#[test]
fn a_named_pipe_that_nobody_reads_to_its_end_is_a_failure() {
    let folder = Folder::new();
    let made = std::process::Command::new("mkfifo")
        .arg(folder.path("pipe"))
        .status();
    assert!(made.expect("mkfifo").success());
    let child = folder.start(&["render", "scene.txt", "--size", "999x999", "-o", "pipe"]);
    drop(std::fs::File::open(folder.path("pipe")).expect("the other end"));
    let run = Run::from(child.wait_with_output().expect("the program ends"));
    run.code_is(1).says("cannot write pipe: Broken pipe");
}

#[test]
fn arguments_that_make_no_sense_are_usage_errors_that_name_the_option() {
    let folder = Folder::new();
    for (option, values) in [
        (
            "--size",
            &["0x5", "5x0", "16385x5", "5", "5x", "-5x5", "5X5", "x"][..],
        ),
        ("--view", &["sharp", ""]),
        ("--engine", &["quick"]),
        ("--kernel", &["mmx"]),
        ("--threads", &["-1", "1025", "two", "1.5"]),
        ("--reflection", &["printed"]),
        ("--pivot", &["center", "0"]),
        ("--fps", &["0", "-1", "nan", "inf", "1e9", "x"]),
        ("--seconds-per-op", &["0", "-0.5", "NaN", "1e400"]),
        ("--frame", &["49", "-1", "x", "99999999999999999999"]),
        (
            "--camera",
            &[
                "1 2 3",
                "0 0 0 0 0 0 0 0 0 0 0 0",
                "0 0 0 -1 1 0 1 1 0 -1 -1 0",
            ],
        ),
        ("--output", &["x.jpg", "x", "png", "x.bmp.gz"]),
    ] {
        for value in values {
            let run = folder
                .run(&["render", "scene.txt", option, value])
                .code_is(2);
            let named = run.stderr.contains(option)
                || option == "--output" && run.stderr.contains(".bmp, .png, .npy");
            assert!(
                run.stderr.contains("error: ") && named,
                "{option} {value}: {run:#?}"
            );
            assert_eq!(run.stdout, "");
        }
    }
    assert_eq!(folder.names(), ["scene.txt"]);
}

#[test]
fn other_usage_errors() {
    let folder = Folder::new();
    let usage = |args: &[&str]| folder.run(args).code_is(2);
    usage(&["render"]);
    usage(&["view"]);
    usage(&["render", "scene.txt", "--nonsense"]);
    usage(&["scene.txt", "other.txt"]).says("one scene, and other.txt is one too many");
    usage(&["scene.txt", "render"]).says("the command comes first: raybomb render SCENE");
    for slip in [
        &["rendr"][..],
        &["--play", "rendr"],
        &["rendr", "scene.txt", "-o", "x.bmp"],
    ] {
        usage(slip).says("there is no file and no command rendr: is `raybomb render` meant?");
    }
    usage(&["help"]).says("is `raybomb --help` meant?");
    usage(&["cube"]).says("is `raybomb demo cube` meant?");
    usage(&["render", "scene.txt", "--frame", "49"]).says("beyond the last frame, 48");
    let camera = "0 -6 4 -4 -2 3 4 -2 3 -4 -2 -3";
    usage(&["render", "scene.txt", "--frame", "1", "--camera", camera]);
    usage(&["render", "scene.txt", "--view", "cost", "-o", "x.npy"]).says("not cost");
    for stdout in ["-", "/dev/stdout"] {
        let both = usage(&["render", "scene.txt", "--hash", "-o", stdout]);
        assert_eq!(both.says("name a file for the picture").stdout, "");
    }
    usage(&["anim", "scene.txt"]).says("--output");
    for pattern in [
        "x.png",
        "{frame}",
        "{frame:4}.png",
        "{frame}.jpg",
        "{frame}{frame}.png",
    ] {
        let run = usage(&["anim", "scene.txt", "-o", pattern]);
        let named = run.stderr.contains("--output") || run.stderr.contains(".bmp, .png, .npy");
        assert!(named, "{pattern}: {run:#?}");
    }
    for range in ["0..49", "5..4", "3", "-1..4", "a..b"] {
        usage(&["anim", "scene.txt", "--hash", "--frames", range]).says("--frames");
    }
    usage(&["bench", "scene.txt", "--frames", "0"]).says("--frames");
    usage(&["bench", "scene.txt", "--workload", "idle"]).says("--workload");
    usage(&["bench", "-", "--workload", "load"]).says("--workload");
    assert_eq!(folder.names(), ["scene.txt"]);
}

#[test]
fn a_kernel_that_this_cpu_lacks_is_a_usage_error_that_lists_what_it_has() {
    use raybomb::simd::Kernel;
    let folder = Folder::new();
    for kernel in Kernel::ALL {
        let run = folder.run(&["render", "scene.txt", "--hash", "--kernel", kernel.name()]);
        if Kernel::available().contains(&kernel) {
            run.ok();
        } else {
            run.code_is(2).says("this CPU has only scalar");
        }
    }
}

#[test]
fn without_a_display_there_is_no_window_and_the_message_tells_what_works() {
    let folder = Folder::new();
    let demo = first_demo(&folder);
    for args in [
        &["view", "scene.txt"][..],
        &["scene.txt"],
        &[],
        &["demo", &demo],
    ] {
        folder.run(args).code_is(4).says("render");
    }
}

#[test]
fn a_scene_that_is_named_like_a_command_can_be_opened() {
    let folder = Folder::new();
    std::fs::rename(folder.path("scene.txt"), folder.path("render")).unwrap();
    folder.run(&["./render"]).code_is(4);
    folder.run(&["render"]).code_is(2);
    folder.run(&["render", "render", "--hash"]).ok();
}
