//! The command line as scripts rely on it: commands, options and their defaults.

use std::env;
use std::error::Error as _;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Args, CommandFactory, FromArgMatches, Parser, Subcommand, ValueEnum};

use super::exit::help_table;
use super::pattern::Pattern;
use super::values::{self, Size};
use crate::camera::Pivot;
use crate::demo;
use crate::render::{COST_SCALE, Engine, Reflection, Samples, Settings, ViewMode};
use crate::scene::CameraCorners;
use crate::simd::Kernel;
use crate::timeline::{Ease, Timing};

/// Ray Bomb 3D: ray-traces coloured triangles on the CPU, in a window and to files.
///
/// Without a command, SCENE is opened in a window; without SCENE, a built-in demo.
#[derive(Debug, Parser)]
#[command(name = "raybomb", version)]
#[command(args_conflicts_with_subcommands = true, disable_help_subcommand = true)]
pub struct Cli {
    /// What to do; `None` opens the window.
    #[command(subcommand)]
    pub command: Option<Command>,
    /// Scene file to open in the window, or - for the standard input; without it a built-in demo is shown
    ///
    /// A file that is named like a command is opened as ./NAME.
    pub scene: Option<PathBuf>,
    #[command(flatten)]
    pub window: WindowOptions,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Opens a scene in a window
    View(ViewArgs),
    /// Renders one picture to a file
    Render(RenderArgs),
    /// Renders the scene's operations as an animation, one file a frame
    Anim(AnimArgs),
    /// Tells every problem of a scene file with its place
    Check(CheckArgs),
    /// Tells what is in a scene: counts, bounds, camera, operations, BVH
    Info(InfoArgs),
    /// Measures speed
    Bench(BenchArgs),
    /// Lists the built-in demos, opens one or saves it as a scene file
    Demo(DemoArgs),
}

/// `raybomb view`
#[derive(Args, Debug)]
pub struct ViewArgs {
    /// Scene file, or - for the standard input
    #[arg(required_unless_present_any = ["list_bindings", "kiosk"])]
    pub scene: Option<PathBuf>,
    #[command(flatten)]
    pub window: WindowOptions,
}

/// What a window can be told.
#[derive(Args, Debug)]
pub struct WindowOptions {
    /// Play the operations at once
    #[arg(long)]
    pub play: bool,
    /// Show scenes, folders of scenes and demos (by name) in turn, all over the screen, and let no key but q do anything
    ///
    /// Each plays its operations once. Without names: SCENE alone, or all demos.
    #[arg(long, value_name = "SCENE", num_args = 0.., conflicts_with_all = ["play_actions", "record_actions"])]
    pub kiosk: Option<Vec<PathBuf>>,
    /// Draw nothing over the picture, not even messages
    #[arg(long)]
    pub no_overlay: bool,
    /// Print what a click hits: one JSON object a line
    #[arg(long)]
    pub print_picks: bool,
    /// Print every key and gesture of the window, as the [keys] of a settings file, and end
    #[arg(long)]
    pub list_bindings: bool,
    /// Play a session: a line for each action, - for the standard input
    #[arg(long, value_name = "FILE")]
    pub play_actions: Option<PathBuf>,
    /// Write the session to a file that can be played again
    #[arg(long, value_name = "FILE")]
    pub record_actions: Option<PathBuf>,
    /// Settings instead of $XDG_CONFIG_HOME/raybomb/config.toml: [keys] as --list-bindings prints them, and [options]
    ///
    /// [options] holds values for options like aa = 16; the command line wins. A mistake in the file is an error with its place. $XDG_CONFIG_HOME is ~/.config, or %APPDATA% on Windows, unless it is set.
    #[arg(long, value_name = "FILE", conflicts_with = "no_config")]
    pub config: Option<PathBuf>,
    /// Read no settings; leave no trace: neither the window's size and place nor a journal of unsaved moves
    #[arg(long)]
    pub no_config: bool,
    /// Pictures a second that the window keeps while something moves, with larger pixels where it must
    #[arg(long, value_name = "N", value_parser = values::timing, default_value = "60", allow_hyphen_values = true)]
    pub target_fps: f64,
    #[command(flatten)]
    pub picture: PictureOptions,
    #[command(flatten)]
    pub time: TimeOptions,
}

/// `raybomb render`
#[derive(Args, Debug)]
pub struct RenderArgs {
    /// Scene file, or - for the standard input
    pub scene: PathBuf,
    /// File to write: .bmp, .png, or .npy (the numbers of --view id, depth, normal or shaded)
    ///
    /// Default: data.bmp, or none with --hash. The standard output (-) and other pipes and devices without an extension get a BMP.
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Frame of the animation [default: the last]
    #[arg(long, value_name = "K", value_parser = values::frame, conflicts_with = "camera", allow_hyphen_values = true)]
    pub frame: Option<u64>,
    /// Eye, then top-left, top-right and bottom-left corner of the projection plane: the picture's camera, whatever the scene and its operations say
    #[arg(long, value_name = "12 NUMBERS", value_parser = values::camera, allow_hyphen_values = true)]
    pub camera: Option<CameraCorners>,
    /// Print the SHA-256 of the picture as a binary PPM file
    #[arg(long)]
    pub hash: bool,
    #[command(flatten)]
    pub picture: PictureOptions,
    #[command(flatten)]
    pub time: TimeOptions,
}

/// `raybomb anim`
#[derive(Args, Debug)]
pub struct AnimArgs {
    /// Scene file, or - for the standard input
    pub scene: PathBuf,
    /// Files to write, named by frame: frames/{frame}.bmp, frames/{frame:04}.png; missing folders are made
    #[arg(short, long, value_name = "PATTERN", required_unless_present = "hash")]
    pub output: Option<Pattern>,
    /// First and last frame, both included [default: all]
    #[arg(long, value_name = "A..B", value_parser = values::frames, allow_hyphen_values = true)]
    pub frames: Option<RangeInclusive<u64>>,
    /// Print a line for each frame: its number and the SHA-256 of the picture as a binary PPM file
    #[arg(long)]
    pub hash: bool,
    #[command(flatten)]
    pub picture: PictureOptions,
    #[command(flatten)]
    pub time: TimeOptions,
}

/// `raybomb check`
#[derive(Args, Debug)]
pub struct CheckArgs {
    /// Scene file, or - for the standard input
    pub scene: PathBuf,
    /// Point at every triangle without area, not only at the first 20
    #[arg(long)]
    pub all_warnings: bool,
}

/// `raybomb info`
#[derive(Args, Debug)]
pub struct InfoArgs {
    /// Scene file, or - for the standard input
    pub scene: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

/// `raybomb bench`
#[derive(Args, Debug)]
pub struct BenchArgs {
    /// Scene file, or - for the standard input
    pub scene: PathBuf,
    /// Size of the picture, each side 1 to 16384
    #[arg(
        long,
        value_name = "WxH",
        default_value = "1920x1080",
        allow_hyphen_values = true
    )]
    pub size: Size,
    #[command(flatten)]
    pub machine: MachineOptions,
    /// What to measure
    #[arg(long, value_name = "WORKLOAD", value_enum, default_value = "primary")]
    pub workload: Workload,
    /// Build the coarse tree: sooner there, slower frames, the same pictures
    #[arg(long)]
    pub coarse: bool,
    /// How often, after one run that does not count
    #[arg(long, value_name = "N", default_value = "30", value_parser = values::count, allow_hyphen_values = true)]
    pub frames: u32,
    /// Also tell where the time of a picture goes (workloads primary and shaded, engine fast)
    #[arg(long)]
    pub stages: bool,
    /// Also tell what more threads would bring, from the time of each tile (workload primary, engine fast)
    #[arg(long)]
    pub scaling: bool,
    /// Print one JSON object on one line
    #[arg(long)]
    pub json: bool,
}

/// What `bench` measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Workload {
    /// One ray a pixel, to numbers and distances
    Primary,
    /// The whole picture
    Shaded,
    /// One ray to the light from every point of the picture that is turned to it: does anything hide it?
    Shadow,
    /// One mirror ray from every point of the picture
    Bounce,
    /// As many rays as the picture has pixels, from random points in random directions
    Random,
    /// From the scene to its BVH
    Build,
    /// From the file to the scene
    Load,
}

/// `raybomb demo`
#[derive(Args, Debug)]
pub struct DemoArgs {
    /// Name of the demo; without it, all are listed
    pub name: Option<String>,
    /// Save the demo as a scene file (- for the standard output) instead of opening it
    #[arg(long, value_name = "FILE", requires = "name")]
    pub write: Option<PathBuf>,
    #[command(flatten)]
    pub window: WindowOptions,
}

/// What a picture shows, of what size, and what makes it.
#[derive(Args, Debug)]
#[command(next_help_heading = "Picture options")]
pub struct PictureOptions {
    /// Size of the picture, each side 1 to 16384 [default: height 480, in the shape of the projection plane]
    #[arg(long, value_name = "WxH", allow_hyphen_values = true)]
    pub size: Option<Size>,
    /// What the picture shows
    #[arg(long, value_name = "VIEW", value_parser = values::one_of(values::VIEWS), default_value = "shaded")]
    pub view: ViewMode,
    /// Samples a pixel: 1, 2, 4, .. 64; a window gets there step by step when nothing moves
    #[arg(long, value_name = "N", value_parser = values::samples, default_value = "1", allow_hyphen_values = true)]
    pub aa: Samples,
    #[command(flatten)]
    pub machine: MachineOptions,
    /// The formula of the shading: the mirror image, or what the original report prints
    #[arg(long, value_name = "FORMULA", value_parser = values::one_of(values::REFLECTIONS), default_value = "mirror")]
    pub reflection: Reflection,
    /// Tests per 4x4 pixels that the view cost shows white
    #[arg(long, value_name = "N", value_parser = values::cost_scale, default_value_t = COST_SCALE, allow_hyphen_values = true)]
    pub cost_scale: u32,
    /// Map the projection plane onto the picture as it is, instead of widening it to the picture's shape
    #[arg(long)]
    pub stretch: bool,
    /// What the operations turn the camera about: the world's origin or the centre of the scene's box
    #[arg(long, value_name = "POINT", value_parser = values::one_of(values::PIVOTS), default_value = "origin")]
    pub pivot: Pivot,
}

impl PictureOptions {
    /// What the renderer needs to know.
    #[must_use]
    pub fn settings(&self) -> Settings {
        Settings {
            engine: self.machine.engine,
            kernel: self.machine.kernel,
            mode: self.view,
            reflection: self.reflection,
            cost_scale: self.cost_scale,
        }
    }
}

/// What computes.
#[derive(Args, Debug)]
pub struct MachineOptions {
    /// What finds the hits: the tracer, every triangle for every pixel (the same bits), or the original report's method
    #[arg(long, value_name = "ENGINE", value_parser = values::one_of(values::ENGINES), default_value = "fast")]
    pub engine: Engine,
    /// Instructions to use (the same bits): auto is the widest that this CPU has
    #[arg(long, value_name = "KERNEL", value_parser = values::kernel(), default_value = "auto")]
    pub kernel: Kernel,
    /// Threads, at most 1024; 0: all cores
    #[arg(long, value_name = "N", value_parser = values::threads, default_value = "0", allow_hyphen_values = true)]
    pub threads: usize,
}

/// How operations become frames.
#[derive(Args, Debug)]
#[command(next_help_heading = "Time options")]
pub struct TimeOptions {
    /// Frames a second
    #[arg(long, value_name = "N", value_parser = values::timing, default_value = "16", allow_hyphen_values = true)]
    pub fps: f64,
    /// Seconds that each operation takes
    #[arg(long, value_name = "N", value_parser = values::timing, default_value = "1", allow_hyphen_values = true)]
    pub seconds_per_op: f64,
    /// How an operation moves: in equal steps, or with a gentle start and end
    #[arg(long, value_name = "HOW", value_parser = values::one_of(values::EASES), default_value = "linear")]
    pub ease: Ease,
    /// Each frame is a whole operation, 1/16 s long
    #[arg(long, conflicts_with_all = ["fps", "seconds_per_op", "ease"])]
    pub steps: bool,
}

impl TimeOptions {
    /// The same as the timeline knows it.
    #[must_use]
    pub fn timing(&self) -> Timing {
        if self.steps {
            return Timing::STEPS;
        }
        Timing {
            fps: self.fps,
            seconds_per_op: self.seconds_per_op,
            ease: self.ease,
        }
    }
}

impl Cli {
    /// The options of the window, when it is a window that is asked for.
    #[must_use]
    pub fn window(&self) -> Option<&WindowOptions> {
        match &self.command {
            None => Some(&self.window),
            Some(Command::View(args)) => Some(&args.window),
            Some(Command::Demo(args)) if args.name.is_some() && args.write.is_none() => {
                Some(&args.window)
            }
            _ => None,
        }
    }
}

/// An option's long name, and the value that it has unless the command line says otherwise.
pub type Default = (&'static str, String);

/// Parses the program's arguments; options of windows have these `defaults`.
///
/// # Errors
/// What clap has to say: a mistake, or the text of `--help` and `--version`.
pub fn parse(defaults: &[Default]) -> Result<Cli, clap::Error> {
    let table = help_table();
    let mut command = Cli::command()
        .after_help(table.clone())
        .mut_subcommands(|c| c.after_help(table.clone()));
    for default in defaults {
        let set = |c: clap::Command| with_default(c, default);
        command = set(command)
            .mut_subcommand("view", set)
            .mut_subcommand("demo", set);
    }
    let matches = command.try_get_matches_from_mut(env::args_os());
    Cli::from_arg_matches(&matches.map_err(|e| in_our_words(e, &mut command))?)
}

/// Clap takes a second word without a command for a command, and calls it one.
fn in_our_words(error: clap::Error, command: &mut clap::Command) -> clap::Error {
    let second = match error.get(ContextKind::InvalidSubcommand) {
        Some(ContextValue::String(word)) if error.kind() == ErrorKind::ArgumentConflict => word,
        _ => return error,
    };
    let mut before = env::args_os()
        .skip(1)
        .take_while(|word| word != second.as_str());
    let told = if let Some(command) = command.find_subcommand(second) {
        format!(
            "the command comes first: raybomb {} SCENE",
            command.get_name()
        )
    } else if let Some(told) = before.find_map(|word| misspelt(Path::new(&word))) {
        told
    } else {
        format!(
            "a window shows one scene, and {second} is one too many: --kiosk shows several in turn"
        )
    };
    command.error(ErrorKind::ArgumentConflict, told)
}

/// That there is no such scene, when it is more likely a command with a slip in it, or a demo's name.
#[must_use]
pub fn misspelt(scene: &Path) -> Option<String> {
    let word = scene.to_str().filter(|_| !scene.exists())?;
    let commands = Cli::command();
    let names = commands.get_subcommands().map(clap::Command::get_name);
    let meant = match word {
        "help" => "--help".to_owned(),
        _ if demo::all().iter().any(|d| d.name == word) => format!("demo {word}"),
        _ if word.contains(['.', '/']) => return None,
        _ => values::nearest(word, names)?.to_owned(),
    };
    Some(format!(
        "there is no file and no command {word}: is `raybomb {meant}` meant?"
    ))
}

fn with_default(command: clap::Command, (name, value): &Default) -> clap::Command {
    command.mut_arg(name.replace('-', "_"), |arg| arg.default_value(value))
}

/// Why `value` is none for the option with that long name, in words; `None` when it is one.
#[must_use]
pub fn wrong_value(name: &str, value: &str) -> Option<String> {
    let option = format!("--{name}={value}");
    let error = Cli::try_parse_from(["raybomb", &option]).err()?;
    let listed = error.get(ContextKind::ValidValue).map(ToString::to_string);
    let told = error.source().map(ToString::to_string);
    Some(match (told, listed) {
        (Some(why), _) => why,
        (None, Some(values)) => format!("must be one of {values}"),
        (None, None) => "is no value of that option".to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_definition_is_sound() {
        Cli::command().debug_assert();
    }

    #[test]
    fn a_scene_alone_opens_a_window_and_commands_win_over_files() {
        let cli = Cli::try_parse_from(["raybomb", "a.txt", "--play"]).unwrap();
        assert!(cli.command.is_none() && cli.window.play);
        assert_eq!(cli.scene, Some(PathBuf::from("a.txt")));
        let cli = Cli::try_parse_from(["raybomb", "./render"]).unwrap();
        assert!(cli.command.is_none() && cli.scene.is_some());
        let cli = Cli::try_parse_from(["raybomb"]).unwrap();
        assert!(cli.command.is_none() && cli.scene.is_none());
        let cli = Cli::try_parse_from(["raybomb", "-"]).unwrap();
        assert_eq!(cli.scene, Some(PathBuf::from("-")));
        assert!(Cli::try_parse_from(["raybomb", "render"]).is_err());
    }
}
