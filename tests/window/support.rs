//! An X server of its own for each test, the program on it, and the window's pixels.

use std::io::{BufRead, BufReader, Read, Write};
use std::path::PathBuf;
use std::process::{Child, ChildStdin, Command, ExitStatus, Output, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use tempfile::TempDir;

pub use crate::picture::Picture;
use crate::proxy::Proxy;
use crate::x11::Client;

/// A pyramid and a floor behind a set camera, with three operations.
pub const SCENE: &str = "\
<s
0 -6 4
-4 -2 3
4 -2 3
-4 -2 -3
0.3 1 -1
5
-2 -1 -1  2 -1 -1  0 0 2  255 80 0
2 -1 -1  0 2 -1  0 0 2  0 200 90
0 2 -1  -2 -1 -1  0 0 2  60 90 255
-9 -9 -1.5  9 -9 -1.5  9 9 -1.5  200 200 200
-9 -9 -1.5  9 9 -1.5  -9 9 -1.5  180 180 190
<o
3
<z 0.7
<x -0.25
<y 0.125
";

/// The usual screen.
const SCREEN: &[&str] = &["-screen", "0", "1600x1200x24"];

/// Longer than anything takes on a busy machine.
const PATIENCE: Duration = Duration::from_secs(30);
/// Between two looks.
const LOOK: Duration = Duration::from_millis(20);

/// An X server with the programs' folder.
pub struct Desk {
    server: Mutex<Child>,
    display: String,
    folder: TempDir,
    manager: Mutex<Option<Child>>,
}

impl Desk {
    /// Starts a usual server; see [`Desk::with`].
    pub fn new() -> Option<Desk> {
        Desk::with(&[])
    }

    /// Starts the server with further arguments; `None`, said aloud, where the tools are missing and nobody insists on them.
    pub fn with(arguments: &[&str]) -> Option<Desk> {
        Desk::on("Xvfb", &[SCREEN, arguments].concat())
    }

    /// Starts a server whose pixels have 32 bits, which Xvfb has not.
    pub fn with_opacity() -> Option<Desk> {
        let deep = ["-depth", "32", "-geometry", "1600x1200"];
        let reached_by_nobody = ["-rfbport", "-1", "-SecurityTypes", "None"];
        Desk::on("Xtigervnc", &[deep, reached_by_nobody].concat())
    }

    fn on(server: &str, arguments: &[&str]) -> Option<Desk> {
        if !is_there(&[server, "xdotool", "xwd"]) {
            return None;
        }
        let (server, display) = start_server(server, arguments);
        let folder = tempfile::tempdir().expect("a folder for the test");
        std::fs::write(folder.path().join("scene.txt"), SCENE).expect("a scene");
        Some(Desk {
            server: Mutex::new(server),
            display,
            folder,
            manager: Mutex::new(None),
        })
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Takes the server away from the programs on it.
    pub fn kill_server(&self) {
        let mut server = self.server.lock().expect("no panic");
        let _ = server.kill();
        let _ = server.wait();
        // It ends with the server.
        if let Some(mut manager) = self.manager.lock().expect("no panic").take() {
            let _ = manager.wait();
        }
    }

    /// Another server in its place.
    pub fn restart_server(&mut self) {
        let (server, display) = start_server("Xvfb", SCREEN);
        (self.server, self.display) = (Mutex::new(server), display);
    }

    /// The program, to be run on this display and no other.
    pub fn program(&self) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_raybomb"));
        command
            .current_dir(self.folder.path())
            .env("DISPLAY", &self.display)
            .env_remove("WAYLAND_DISPLAY")
            .env_remove("WAYLAND_SOCKET")
            .env_remove("RUST_BACKTRACE")
            .env("XDG_CONFIG_HOME", self.path("config"))
            .env("XDG_STATE_HOME", self.path("state"));
        command
    }

    /// Opens the scene at 320x240 and waits until the window is there and has the keyboard.
    pub fn view(&self, options: &[&str]) -> Viewer<'_> {
        let mut command = self.program();
        command.args(["view", "scene.txt", "--size", "320x240"]);
        Viewer::start(self, command.args(options))
    }

    /// What `raybomb render` writes with these options.
    pub fn render(&self, options: &[&str]) -> Picture {
        self.render_file("scene.txt", options)
    }

    /// What `raybomb render` writes of the scene in a file of the folder.
    pub fn render_file(&self, file: &str, options: &[&str]) -> Picture {
        let output = self
            .program()
            .args(["render", file, "-o", "expected.bmp"])
            .args(options)
            .output()
            .expect("the program runs");
        assert!(output.status.success(), "render {options:?}: {output:?}");
        Picture::from_bmp(&std::fs::read(self.path("expected.bmp")).expect("a BMP file"))
    }

    /// The still picture at the size that [`Desk::view`] opens.
    pub fn still(&self) -> Picture {
        self.render(&["--size", "320x240"])
    }

    /// The command, on this display.
    pub fn on_display<'c>(&self, command: &'c mut Command) -> &'c mut Command {
        command.env("DISPLAY", &self.display)
    }

    /// Puts a scene in the folder that keeps the slow engines busy.
    pub fn bring_bomb(&self) {
        let bomb = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/bomb.txt");
        std::fs::copy(bomb, self.path("bomb.txt")).expect("copied");
    }

    /// The whole screen.
    pub fn screen(&self) -> Picture {
        let output = self.tool("xwd", &["-silent", "-root"]);
        assert!(output.status.success(), "{output:?}");
        Picture::from_xwd(&output.stdout)
    }

    /// A display before the server's own.
    pub fn proxy(&self) -> Proxy {
        Proxy::to(&self.display)
    }

    /// A client of the server.
    pub fn client(&self) -> Client {
        Client::of(&self.display)
    }

    /// Runs openbox until the server goes.
    pub fn manage(&self) {
        let openbox = Command::new("openbox")
            .args(["--sm-disable", "--config-file", "/dev/null"])
            .env("DISPLAY", &self.display)
            .env("XDG_CACHE_HOME", self.path("cache"))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("openbox starts");
        *self.manager.lock().expect("no panic") = Some(openbox);
        until("a window manager", || {
            self.client().is_managed().then_some(())
        });
    }

    /// Runs xdotool.
    pub fn xdotool(&self, arguments: &[&str]) -> Output {
        self.tool("xdotool", arguments)
    }

    fn tool(&self, tool: &str, arguments: &[&str]) -> Output {
        Command::new(tool)
            .args(arguments)
            .env("DISPLAY", &self.display)
            .output()
            .expect("the tool runs")
    }

    /// The visible window of a process. (Numbers of windows are used again: they tell nothing.)
    fn window_of(&self, process: u32) -> Option<String> {
        let process = process.to_string();
        let search = ["search", "--onlyvisible", "--all", "--pid", &process];
        let found = self.xdotool(&[&search[..], &["--class", "raybomb"]].concat());
        let text = String::from_utf8_lossy(&found.stdout).into_owned();
        text.lines().next().map(str::to_owned)
    }
}

/// A server that is ready, and the name of its display.
fn start_server(server: &str, arguments: &[&str]) -> (Child, String) {
    let mut server = Command::new(server)
        // Without the last it starts anew, and turns callers away, whenever a tool was its only client.
        .args(["-displayfd", "1", "-nolisten", "tcp", "-noreset"])
        .args(arguments)
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("the server starts");
    let mut number = String::new();
    BufReader::new(server.stdout.as_mut().expect("piped"))
        .read_line(&mut number)
        .expect("the server tells its number");
    assert!(!number.trim().is_empty(), "no display number is free");
    (server, format!(":{}", number.trim()))
}

impl Drop for Desk {
    fn drop(&mut self) {
        self.kill_server();
    }
}

/// Whether all the tools are installed; said aloud where they are not, and an error where somebody insists on them.
pub fn is_there(tools: &[&str]) -> bool {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let is_installed = |tool: &str| std::env::split_paths(&path).any(|f| f.join(tool).is_file());
    let missing: Vec<&str> = tools
        .iter()
        .copied()
        .filter(|tool| !is_installed(tool))
        .collect();
    if missing.is_empty() {
        return true;
    }
    let words = format!("not installed: {}", missing.join(", "));
    let ci = std::env::var("CI").is_ok_and(|ci| ci == "true");
    assert!(!ci, "{words}");
    println!("SKIPPED, {words}");
    false
}

/// The program with its window.
pub struct Viewer<'a> {
    desk: &'a Desk,
    child: Child,
    window: String,
    words: Arc<Mutex<Vec<String>>>,
    prints: Arc<Mutex<Vec<String>>>,
    input: Option<ChildStdin>,
    /// From the start of the process to a window.
    pub opened_in: Duration,
}

impl<'a> Viewer<'a> {
    /// Runs the program, waits for its window and gives that the keyboard.
    pub fn start(desk: &'a Desk, command: &mut Command) -> Viewer<'a> {
        let viewer = Viewer::open(desk, command);
        viewer.focus();
        viewer
    }

    /// Runs the program and waits for its window.
    pub fn open(desk: &'a Desk, command: &mut Command) -> Viewer<'a> {
        let start = Instant::now();
        let mut viewer = Viewer::run(desk, command);
        viewer.window = until("a window", || {
            let ended = viewer.child.try_wait().expect("it is ours");
            assert!(ended.is_none(), "{ended:?}: {:?}", viewer.words());
            desk.window_of(viewer.id())
        });
        viewer.opened_in = start.elapsed();
        viewer
    }

    /// Runs the program.
    pub fn run(desk: &'a Desk, command: &mut Command) -> Viewer<'a> {
        let mut child = command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program runs");
        let prints = collect_lines(child.stdout.take().expect("piped"));
        let input = child.stdin.take();
        let words = collect_lines(child.stderr.take().expect("piped"));
        Viewer {
            desk,
            child,
            window: String::new(),
            words,
            prints,
            input,
            opened_in: Duration::ZERO,
        }
    }

    /// The window's number.
    pub fn window(&self) -> u32 {
        self.window.parse().expect("a number")
    }

    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Gives the window the keyboard.
    pub fn focus(&self) {
        until("the keyboard", || {
            let done = self.desk.xdotool(&["windowfocus", "--sync", &self.window]);
            done.status.success().then_some(())
        });
    }

    /// Types keys into the window that has the keyboard.
    pub fn keys(&self, keys: &[&str]) {
        let arguments: Vec<&str> = ["key"].iter().chain(keys).copied().collect();
        assert!(self.desk.xdotool(&arguments).status.success());
    }

    /// Runs xdotool with `WINDOW` replaced by the window's number.
    pub fn hand(&self, arguments: &[&str]) {
        let arguments: Vec<&str> = arguments
            .iter()
            .map(|a| if *a == "WINDOW" { &self.window } else { *a })
            .collect();
        let done = self.desk.xdotool(&arguments);
        assert!(done.status.success(), "{arguments:?}: {done:?}");
    }

    pub fn resize(&self, width: usize, height: usize) {
        let (width, height) = (width.to_string(), height.to_string());
        self.hand(&["windowsize", "WINDOW", &width, &height]);
    }

    /// Where the window's upper left corner is.
    pub fn place(&self) -> (i32, i32) {
        let told = self
            .desk
            .xdotool(&["getwindowgeometry", "--shell", &self.window]);
        let text = String::from_utf8_lossy(&told.stdout).into_owned();
        let number = |name: &str| {
            let value = text.lines().find_map(|line| line.strip_prefix(name));
            value.and_then(|v| v.parse().ok()).expect("a number")
        };
        (number("X="), number("Y="))
    }

    /// The window's pixels.
    pub fn grab(&self) -> Picture {
        // In vain where the window takes another size between xwd's two questions.
        until("the window's pixels", || {
            let output = self.desk.tool("xwd", &["-silent", "-id", &self.window]);
            let is_whole = output.status.success();
            is_whole.then(|| Picture::from_xwd(&output.stdout))
        })
    }

    /// Waits until the window shows `expected`, to the bit.
    pub fn shows(&self, expected: &Picture, what: &str) {
        let start = Instant::now();
        loop {
            let shown = self.grab();
            if shown == *expected {
                return;
            }
            assert!(
                start.elapsed() < PATIENCE,
                "{what}: {}",
                shown.difference(expected)
            );
            std::thread::sleep(LOOK);
        }
    }

    /// Waits until the upper left corner of the window shows `expected`, to the bit.
    pub fn shows_in_corner(&self, expected: &Picture, what: &str) {
        until(what, || {
            let corner = self.grab().corner(expected.width, expected.height);
            (corner == *expected).then_some(())
        });
    }

    /// Sends the program a signal.
    pub fn signal(&self, name: &str) {
        let kill = format!("kill -{name} {}", self.id());
        let done = Command::new("sh").args(["-c", &kill]).status();
        assert!(done.expect("a shell").success(), "{kill}");
    }

    /// Waits until the window shows anything else, and returns that.
    pub fn changes_from(&self, old: &Picture, what: &str) -> Picture {
        until(what, || Some(self.grab()).filter(|new| new != old))
    }

    /// Waits until the picture has stood still for a while, and returns it.
    pub fn rests(&self, what: &str) -> Picture {
        until(what, || {
            let old = self.grab();
            std::thread::sleep(Duration::from_millis(400));
            Some(old).filter(|old| *old == self.grab())
        })
    }

    /// Waits for the line number `index` that the program says, counted from 0.
    pub fn says(&self, index: usize) -> String {
        until("words", || {
            self.words.lock().expect("no panic").get(index).cloned()
        })
    }

    /// Waits for the line number `index` on the standard output, counted from 0.
    pub fn prints(&self, index: usize) -> String {
        until("a printed line", || {
            self.prints.lock().expect("no panic").get(index).cloned()
        })
    }

    /// Writes lines to the standard input.
    pub fn tell(&mut self, lines: &str) {
        let input = self.input.as_mut().expect("it is open");
        input
            .write_all(format!("{lines}\n").as_bytes())
            .and_then(|()| input.flush())
            .expect("it reads");
    }

    /// Closes the standard input.
    pub fn end_input(&mut self) {
        self.input = None;
    }

    /// Everything said up to now.
    pub fn words(&self) -> Vec<String> {
        self.words.lock().expect("no panic").clone()
    }

    /// Clock ticks (of a hundredth of a second) of CPU time up to now.
    pub fn cpu_ticks(&self) -> u64 {
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", self.id())).expect("it runs");
        let after_name = stat.rsplit_once(')').expect("a name in brackets").1;
        let fields: Vec<&str> = after_name.split_whitespace().collect();
        let ticks = |i: usize| fields[i].parse::<u64>().expect("a number");
        ticks(11) + ticks(12)
    }

    /// Waits until the program has done nothing for a while.
    pub fn sleeps(&self, what: &str) {
        until(what, || {
            let before = self.cpu_ticks();
            std::thread::sleep(Duration::from_millis(400));
            (self.cpu_ticks() <= before + 1).then_some(())
        });
    }

    /// Waits for the end of the program.
    pub fn ends(&mut self) -> ExitStatus {
        until("the end", || self.child.try_wait().expect("it is ours"))
    }
}

impl Drop for Viewer<'_> {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Asks again and again until there is an answer.
pub fn until<T>(what: &str, mut ask: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(answer) = ask() {
            return answer;
        }
        assert!(start.elapsed() < PATIENCE, "waited in vain for {what}");
        std::thread::sleep(LOOK);
    }
}

fn collect_lines(stream: impl Read + Send + 'static) -> Arc<Mutex<Vec<String>>> {
    let lines = Arc::new(Mutex::new(Vec::new()));
    let to = Arc::clone(&lines);
    std::thread::spawn(move || {
        for line in BufReader::new(stream).lines().map_while(Result::ok) {
            to.lock().expect("no panic").push(line);
        }
    });
    lines
}
