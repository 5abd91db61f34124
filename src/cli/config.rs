//! The settings file of windows: which keys do what, and what options are worth unless the command line says otherwise.
//!
//! ```toml
//! [options]
//! aa = 16                      # as --aa 16
//! [keys]                       # names and chords as --list-bindings prints them
//! quit = ["q", "Ctrl+w"]
//! ```
//!
//! Commands without a window do not read it: their pictures depend on the command line alone. A mistake ends the
//! program before there is a window: settings that half hold are worse than none, and `--no-config` is always there.

use std::collections::HashMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::args::{self, WindowOptions};
use super::console::color;
use super::exit::Failure;
use super::values::nearest;
use crate::app::{self, Keymap, Rebinding, folders};
use crate::scene::{Location, Severity, annotate};

/// The options that the file may give a value.
const OPTIONS: [&str; 13] = [
    "size",
    "view",
    "aa",
    "engine",
    "kernel",
    "threads",
    "reflection",
    "cost-scale",
    "pivot",
    "target-fps",
    "fps",
    "seconds-per-op",
    "ease",
];

const TABLES: [&str; 2] = ["keys", "options"];

/// What the file says.
#[derive(Debug, Default)]
pub struct Config {
    /// Which chord does what.
    pub keymap: Keymap,
    /// What options are worth.
    pub defaults: Vec<args::Default>,
}

/// Something wrong in the file.
#[derive(Debug)]
struct Mistake {
    span: Range<usize>,
    message: String,
    help: Option<String>,
}

impl Config {
    /// Reads the file that `window` names, or else the user's, if there is one.
    ///
    /// # Errors
    /// When it cannot be read, or says something that makes no sense.
    pub fn load(window: &WindowOptions) -> Result<Config, Failure> {
        let path = match &window.config {
            _ if window.no_config => return Ok(Config::default()),
            Some(path) => path.clone(),
            None => match users_file() {
                Some(path) => path,
                None => return Ok(Config::default()),
            },
        };
        let text = app::read_file(&path).map_err(|e| Failure::file("read", &path, &e))?;
        Config::of(&text).map_err(|mistakes| told(&path, &text, &mistakes))
    }

    fn of(bytes: &[u8]) -> Result<Config, Vec<Mistake>> {
        let text = std::str::from_utf8(bytes).map_err(|e| {
            let at = e.valid_up_to();
            vec![Mistake::new(at..at + 1, "this is not UTF-8 text".into())]
        })?;
        let (file, errors) = DeTable::parse_recoverable(text);
        let mut reader = Reader::default();
        for e in errors {
            let span = e.span().unwrap_or(0..0);
            reader.mistake(span, e.message().to_owned());
        }
        // What could not be read leads to mistakes that are none.
        if reader.mistakes.is_empty() {
            reader.file(file.get_ref());
        }
        if !reader.mistakes.is_empty() {
            reader.mistakes.sort_by_key(|m| m.span.start);
            return Err(reader.mistakes);
        }
        Ok(Config {
            keymap: Keymap::with(&reader.changes),
            defaults: reader.defaults,
        })
    }
}

/// The user's own file, if it is there.
fn users_file() -> Option<PathBuf> {
    let path = folders::config_file(|name| std::env::var_os(name))?;
    path.exists().then_some(path)
}

fn told(path: &Path, text: &[u8], mistakes: &[Mistake]) -> Failure {
    let name = path.display().to_string();
    let told: Vec<String> = mistakes
        .iter()
        .map(
            |Mistake {
                 span,
                 message,
                 help,
             }| {
                let at = Location::of(text, span.clone());
                annotate(
                    Severity::Error,
                    &name,
                    text,
                    &at,
                    message,
                    help.as_deref(),
                    color(),
                )
            },
        )
        .collect();
    let hint = "hint: `--no-config` opens the window without settings";
    Failure::Failed(format!("bad settings\n{}\n{hint}", told.join("\n")))
}

impl Mistake {
    fn new(span: Range<usize>, message: String) -> Mistake {
        Mistake {
            span,
            message,
            help: None,
        }
    }
}

/// Goes through the file.
#[derive(Debug, Default)]
struct Reader {
    changes: Vec<Rebinding>,
    /// What each chord was given to.
    given: HashMap<String, String>,
    defaults: Vec<args::Default>,
    mistakes: Vec<Mistake>,
}

impl Reader {
    fn mistake(&mut self, span: Range<usize>, message: String) {
        self.mistakes.push(Mistake::new(span, message));
    }

    /// There is no `name` among the `known` things of that `kind`.
    fn unknown(&mut self, span: Range<usize>, kind: &str, name: &str, known: &[String]) {
        let help = match nearest(name, known.iter().map(String::as_str)) {
            Some(nearest) => format!("is {nearest:?} meant?"),
            _ if known.len() <= OPTIONS.len() => format!("there are {}", known.join(", ")),
            _ => "`raybomb view --list-bindings` prints all names".to_owned(),
        };
        self.mistakes.push(Mistake {
            span,
            message: format!("there is no {kind} called {name:?}"),
            help: Some(help),
        });
    }

    /// `name` is known, but not outside of `table`.
    fn misplaced(&mut self, span: Range<usize>, name: &str, table: &str) {
        self.mistakes.push(Mistake {
            span,
            message: format!("{name} is in no table"),
            help: Some(format!("it belongs under a line [{table}]")),
        });
    }

    fn file(&mut self, file: &DeTable<'_>) {
        for (name, value) in in_order(file) {
            let table = value.get_ref().as_table();
            match (name.get_ref().as_ref(), table) {
                ("keys", Some(keys)) => self.keys(keys),
                ("options", Some(options)) => self.options(options),
                (known, None) if TABLES.contains(&known) => {
                    self.mistake(value.span(), format!("{known} must be a table: [{known}]"));
                }
                (option, None) if OPTIONS.contains(&option) => {
                    self.misplaced(name.span(), option, "options");
                }
                (key, None) if app::names_of_keys().any(|known| known == key) => {
                    self.misplaced(name.span(), key, "keys");
                }
                (unknown, _) => {
                    let known = TABLES.map(str::to_owned);
                    self.unknown(name.span(), "table", unknown, &known);
                }
            }
        }
    }

    fn keys(&mut self, keys: &DeTable<'_>) {
        for (name, value) in in_order(keys) {
            let Some(mut change) = Rebinding::of(name.get_ref()) else {
                let known: Vec<String> = app::names_of_keys().collect();
                self.unknown(name.span(), "action or gesture", name.get_ref(), &known);
                continue;
            };
            let chords = match value.get_ref().as_array() {
                Some(chords) => chords.iter().collect(),
                None => vec![value],
            };
            for chord in chords {
                self.chord(name.get_ref(), &mut change, chord);
            }
            self.changes.push(change);
        }
    }

    fn chord(&mut self, name: &str, change: &mut Rebinding, value: &Spanned<DeValue<'_>>) {
        let Some(text) = value.get_ref().as_str() else {
            let message = "keys are strings, like \"Ctrl+s\", or lists of them: [\"h\", \"?\"]";
            return self.mistake(value.span(), message.to_owned());
        };
        match change.add(text) {
            Ok(chord) => {
                if let Some(other) = self.given.insert(chord.to_string(), name.to_owned()) {
                    let message = format!("{chord} is already given to {other}");
                    self.mistake(value.span(), message);
                }
            }
            Err(why) => self.mistake(value.span(), why),
        }
    }

    fn options(&mut self, options: &DeTable<'_>) {
        for (name, value) in in_order(options) {
            let known = OPTIONS.iter().find(|known| *known == name.get_ref());
            let Some(option) = known else {
                let known = OPTIONS.map(str::to_owned);
                self.unknown(name.span(), "option with a value", name.get_ref(), &known);
                continue;
            };
            let text = match value.get_ref() {
                DeValue::String(text) => text.to_string(),
                DeValue::Integer(number) if number.radix() == 10 => number.as_str().to_owned(),
                DeValue::Float(number) => number.as_str().to_owned(),
                _ => {
                    self.mistake(value.span(), format!("{option} needs a number or a string"));
                    continue;
                }
            };
            match args::wrong_value(option, &text) {
                Some(why) => self.mistake(value.span(), format!("{option}: {why}")),
                None => self.defaults.push((option, text)),
            }
        }
    }
}

/// The entries as they stand in the file.
fn in_order<'t, 'i>(
    table: &'t DeTable<'i>,
) -> Vec<(
    &'t Spanned<toml::de::DeString<'i>>,
    &'t Spanned<DeValue<'i>>,
)> {
    let mut entries: Vec<_> = table.iter().collect();
    entries.sort_by_key(|(name, _)| name.span().start);
    entries
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory as _;

    use super::*;
    use crate::math::Random;

    fn mistakes(text: &str) -> Vec<(String, String)> {
        let mistakes = Config::of(text.as_bytes()).expect_err("mistakes");
        let told = |m: Mistake| {
            let help = m.help.map_or(String::new(), |help| format!(" / {help}"));
            (text[m.span].to_owned(), m.message + &help)
        };
        mistakes.into_iter().map(told).collect()
    }

    #[test]
    fn an_empty_file_and_the_listing_itself_change_nothing() {
        let usual = Keymap::default().listing();
        for text in ["", "# nothing\n[keys]\n[options]\n", &usual] {
            let config = Config::of(text.as_bytes()).expect("settings");
            assert_eq!(config.keymap.listing(), usual);
            assert_eq!(config.defaults, []);
        }
    }

    #[test]
    fn a_listing_with_changes_reads_back_as_the_same() {
        let text = "[keys]\nquit = 'x'\nsheet = ['/', '\"', '\\']\nroll = []\n";
        let listing = Config::of(text.as_bytes())
            .expect("settings")
            .keymap
            .listing();
        assert_ne!(listing, Keymap::default().listing());
        let again = Config::of(listing.as_bytes()).expect("settings");
        assert_eq!(again.keymap.listing(), listing);
    }

    #[test]
    fn options_are_values_of_the_command_line() {
        let text = "[options]\naa = 16\nfps = 2_4.5\nview = \"id\"\nsize = \"64x48\"\n";
        let config = Config::of(text.as_bytes()).expect("settings");
        let expected = [
            ("aa", "16"),
            ("fps", "24.5"),
            ("view", "id"),
            ("size", "64x48"),
        ];
        assert_eq!(config.defaults, expected.map(|(n, v)| (n, v.to_owned())));
        for (option, why) in [
            ("aa = 3", "aa: must be a power of two from 1 to 64"),
            (
                "view = \"idd\"",
                "view: must be one of shaded, id, normal, depth, cost",
            ),
            (
                "threads = -1",
                "threads: must be a number from 0 (all cores) to 1024",
            ),
            ("ease = true", "ease needs a number or a string"),
        ] {
            let (_, message) = mistakes(&format!("[options]\n{option}")).remove(0);
            assert_eq!(message, why);
        }
    }

    #[test]
    fn every_value_of_pictures_and_time_can_be_set() {
        let command = args::Cli::command();
        let in_file = |arg: &&clap::Arg| {
            let heading = arg.get_help_heading();
            let shown = heading.is_some_and(|h| h == "Picture options" || h == "Time options");
            shown && arg.get_action().takes_values()
        };
        let names: Vec<&str> = command
            .get_arguments()
            .filter(in_file)
            .filter_map(clap::Arg::get_long)
            .collect();
        assert!(names.len() >= 12, "{names:?}");
        for name in names {
            assert!(OPTIONS.contains(&name), "{name}");
        }
    }

    #[test]
    fn random_text_is_told_and_never_panics() {
        let usual = Keymap::default().listing() + "[options]\naa = 16\nfps = 1.5\n";
        let mut random = Random::new(3);
        let mut wrong = 0;
        for _ in 0..60 {
            let mut text = usual.clone().into_bytes();
            let mut below = |most: usize| random.below(most as u32) as usize;
            for _ in 0..=below(4) {
                let at = below(text.len());
                text[at] = below(256) as u8;
            }
            text.truncate(text.len() - below(20));
            if let Err(mistakes) = Config::of(&text) {
                let words = told(Path::new("a.toml"), &text, &mistakes).to_string();
                assert!(words.contains("\na.toml:"), "{words}");
                wrong += 1;
            }
        }
        assert!(wrong > 20, "{wrong}");
    }

    #[test]
    fn mistakes_are_told_with_their_places_and_cures() {
        for (text, at, message) in [
            (
                "[keys]\nqiut = \"q\"",
                "qiut",
                "there is no action or gesture called \"qiut\" / is \"quit\" meant?",
            ),
            (
                "[keys]\nquit = [\"a\", \"zz\"]",
                "\"zz\"",
                "there is no key or gesture called \"zz\"",
            ),
            (
                "[keys]\nquit = \"a\"\nrecord = \"a\"",
                "\"a\"",
                "a is already given to quit",
            ),
            (
                "[keys]\nquit = [\"a\", \"a\"]",
                "\"a\"",
                "a is already given to quit",
            ),
            (
                "[keys]\nroll = \"a\"",
                "\"a\"",
                "roll cannot be done by a: it needs a drag, like left-drag",
            ),
            (
                "[keys]\nquit = 1",
                "1",
                "keys are strings, like \"Ctrl+s\", or lists of them: [\"h\", \"?\"]",
            ),
            (
                "[option]\naa = 1",
                "option",
                "there is no table called \"option\" / is \"options\" meant?",
            ),
            ("keys = 1", "1", "keys must be a table: [keys]"),
            (
                "aa = 1",
                "aa",
                "aa is in no table / it belongs under a line [options]",
            ),
            (
                "quit = 'x'",
                "quit",
                "quit is in no table / it belongs under a line [keys]",
            ),
            (
                "[options]\nplay = true",
                "play",
                "there is no option with a value called \"play\"",
            ),
        ] {
            let (place, told) = mistakes(text).remove(0);
            assert_eq!(place, at, "{text}");
            assert!(told.starts_with(message), "{text}: {told}");
        }
        let two = mistakes("[keys]\nquit = \"zz\"\n[options]\naa = 0");
        assert_eq!(two.len(), 2);
        assert!(!mistakes("[keys\n").is_empty());
        assert!(!mistakes("[keys]\nquit = \"a\"\nquit = \"b\"").is_empty());
        assert!(Config::of(b"[keys]\n\xff = 1").is_err());
    }
}
