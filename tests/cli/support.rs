//! Runs the real program in a folder of its own, and reads what it writes.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use raybomb::export::Hasher;
use tempfile::TempDir;

/// A pyramid and a floor behind a set camera, with three operations.
pub const SCENE: &str = "\
<s
0 -6 4
-4 -2 3
4 -2 3
-4 -2 -3
0.3 1 -1
6
-2 -1 -1  2 -1 -1  0 0 2  255 80 0
2 -1 -1  0 2 -1  0 0 2  0 200 90
0 2 -1  -2 -1 -1  0 0 2  60 90 255
-9 -9 -1.5  9 -9 -1.5  9 9 -1.5  200 200 200
-9 -9 -1.5  9 9 -1.5  -9 9 -1.5  180 180 190
1 1 1  1 1 1  2 2 2  1 2 3
<o
3
<z 0.7
<x -0.25
<y 0.125
";

/// A folder with `scene.txt` in it, removed at the end.
pub struct Folder(TempDir);

/// How a run of the program ended.
#[derive(Debug)]
pub struct Run {
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl Folder {
    pub fn new() -> Folder {
        let folder = Folder(tempfile::tempdir().expect("a folder for the test"));
        folder.write("scene.txt", SCENE);
        folder
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), bytes).expect("the test's folder takes files");
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// The names of all files, sorted.
    pub fn names(&self) -> Vec<String> {
        names_in(self.0.path())
    }

    /// The program in this folder, without a display.
    pub fn command(&self, args: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_raybomb"));
        command
            .args(args)
            .current_dir(self.0.path())
            .env_remove("DISPLAY")
            .env_remove("WAYLAND_DISPLAY")
            .env_remove("WAYLAND_SOCKET")
            .env("XDG_CONFIG_HOME", self.path("config"))
            .env("XDG_STATE_HOME", self.path("state"))
            .stdin(Stdio::null());
        command
    }

    /// Runs the program to its end.
    pub fn run(&self, args: &[&str]) -> Run {
        Run::from(self.command(args).output().expect("the program runs"))
    }

    /// Runs the program with `input` as its standard input.
    pub fn run_with_input(&self, args: &[&str], input: &[u8]) -> Run {
        let mut child = self.start(args);
        let mut stdin = child.stdin.take().expect("a pipe");
        stdin.write_all(input).expect("the program reads all");
        drop(stdin);
        Run::from(child.wait_with_output().expect("the program ends"))
    }

    /// Starts the program with pipes to it and from it.
    pub fn start(&self, args: &[&str]) -> Child {
        self.command(args)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts")
    }

    /// The hash that `--hash` prints for `args`.
    pub fn hash(&self, args: &[&str]) -> String {
        self.run(args).ok().stdout.trim_end().to_owned()
    }
}

impl From<Output> for Run {
    fn from(output: Output) -> Run {
        Run {
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).expect("stdout is text"),
            stderr: String::from_utf8(output.stderr).expect("stderr is text"),
        }
    }
}

impl Run {
    /// This run, which must have ended well; it may have said something.
    #[track_caller]
    pub fn ok(self) -> Run {
        self.code_is(0)
    }

    /// This run, which must have ended with `code`.
    #[track_caller]
    pub fn code_is(self, code: i32) -> Run {
        assert_eq!(self.code, Some(code), "{self:#?}");
        self
    }

    /// This run, whose error stream must contain `text`.
    #[track_caller]
    pub fn says(self, text: &str) -> Run {
        assert!(self.stderr.contains(text), "no {text:?} in {self:#?}");
        self
    }
}

pub fn names_in(folder: &Path) -> Vec<String> {
    let entries = folder.read_dir().expect("the folder is there");
    let name = |e: std::io::Result<std::fs::DirEntry>| e.expect("an entry").file_name();
    let mut names: Vec<String> = entries
        .map(|e| name(e).into_string().expect("a name in UTF-8"))
        .collect();
    names.sort();
    names
}

/// A picture's rows from top to bottom, R, G, B.
#[derive(Debug, PartialEq)]
pub struct Picture {
    pub width: usize,
    pub height: usize,
    pub rgb: Vec<u8>,
}

impl Picture {
    /// The SHA-256 of the picture as a PPM file.
    pub fn hash(&self) -> String {
        let mut hasher = Hasher::default();
        hasher.update(format!("P6\n{} {}\n255\n", self.width, self.height).as_bytes());
        hasher.update(&self.rgb);
        hasher.finish()
    }

    /// Reads a BMP file and insists on every byte that is not a pixel.
    pub fn from_bmp(file: &[u8]) -> Picture {
        let u32_at = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().expect("4 bytes"));
        let (width, height) = (u32_at(18) as usize, u32_at(22) as usize);
        let row_bytes = (width * 3).next_multiple_of(4);
        let mut header = [0u8; 54];
        header[..2].copy_from_slice(b"BM");
        header[2..6].copy_from_slice(&(file.len() as u32).to_le_bytes());
        header[10] = 54;
        header[14] = 40;
        header[18..26].copy_from_slice(&file[18..26]);
        header[26] = 1;
        header[28] = 24;
        assert_eq!(file[..54], header);
        assert_eq!(file.len(), 54 + row_bytes * height);
        let mut rgb = Vec::new();
        for row in file[54..].chunks_exact(row_bytes).rev() {
            let (pixels, padding) = row.split_at(width * 3);
            rgb.extend(pixels.chunks_exact(3).flat_map(|c| [c[2], c[1], c[0]]));
            assert!(padding.iter().all(|b| *b == 0), "the padding is not zero");
        }
        Picture { width, height, rgb }
    }

    /// Reads all of a PNG file.
    pub fn from_png(file: &[u8]) -> Picture {
        let decoder = png::Decoder::new(std::io::Cursor::new(file));
        let mut reader = decoder.read_info().expect("a PNG file");
        let mut rgb = vec![0; reader.output_buffer_size().expect("a size")];
        let info = reader.next_frame(&mut rgb).expect("a whole picture");
        reader.finish().expect("a whole file");
        assert_eq!(info.color_type, png::ColorType::Rgb);
        Picture {
            width: info.width as usize,
            height: info.height as usize,
            rgb,
        }
    }
}

/// An NPY file's type, shape and data.
#[derive(Debug)]
pub struct Array {
    pub descr: String,
    pub shape: Vec<usize>,
    pub data: Vec<u8>,
}

impl Array {
    pub fn from_npy(file: &[u8]) -> Array {
        assert_eq!(file[..8], *b"\x93NUMPY\x01\x00");
        let end = 10 + usize::from(u16::from_le_bytes([file[8], file[9]]));
        assert_eq!(end % 64, 0, "the data is not aligned");
        let header = std::str::from_utf8(&file[10..end]).expect("ASCII");
        assert!(header.ends_with('\n') && header.contains("'fortran_order': False"));
        let after = |key: &str| header.split_once(key).expect("a header with all keys").1;
        let descr = after("'descr': '").split('\'').next().expect("a type");
        let shape = after("'shape': (").split(')').next().expect("a shape");
        let array = Array {
            descr: descr.to_owned(),
            shape: shape
                .split(", ")
                .map(|n| n.parse().expect("a number"))
                .collect(),
            data: file[end..].to_vec(),
        };
        let item: usize = descr[2..].parse().expect("a size");
        let items: usize = array.shape.iter().product();
        assert_eq!(array.data.len(), items * item);
        array
    }

    pub fn u32s(&self) -> Vec<u32> {
        assert_eq!(self.descr, "<u4");
        let value = |b: &[u8]| u32::from_le_bytes(b.try_into().expect("4 bytes"));
        self.data.chunks_exact(4).map(value).collect()
    }

    pub fn f32s(&self) -> Vec<f32> {
        assert_eq!(self.descr, "<f4");
        let value = |b: &[u8]| f32::from_le_bytes(b.try_into().expect("4 bytes"));
        self.data.chunks_exact(4).map(value).collect()
    }
}

/// Waits until `done`, for a minute at most.
pub fn wait_until(what: &str, mut done: impl FnMut() -> bool) {
    let start = Instant::now();
    while !done() {
        assert!(start.elapsed() < Duration::from_secs(60), "never: {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Sends a signal (`INT`, `KILL`) to the program.
#[cfg(unix)]
pub fn signal(child: &Child, name: &str) {
    let line = format!("kill -{name} {}", child.id());
    let status = Command::new("sh").args(["-c", &line]).status();
    assert!(status.expect("a shell").success(), "{line}");
}
