//! Which chord does what: the table of [`BINDINGS`], or what the user made of it.
//!
//! Every effect has a name, and every chord is a text that reads back as the same chord: so the table can be printed
//! as the `[keys]` of a settings file, changed there, and read again.

use std::collections::HashSet;
use std::fmt::Write as _;
use std::str::FromStr;

use super::action::Action;
use super::bindings::{
    BINDINGS, Binding, Button, Chord, Effect, Grip, Key, Modifiers, Spot, Trigger,
};
use crate::scene::Axis;

/// The triggers that have a name, beside the function keys; others are the letter or sign that they type.
const NAMED: [Trigger; 17] = [
    Trigger::Key(Key::Space),
    Trigger::Key(Key::Enter),
    Trigger::Key(Key::Escape),
    Trigger::Key(Key::Left),
    Trigger::Key(Key::Right),
    Trigger::Key(Key::Home),
    Trigger::Key(Key::End),
    Trigger::Key(Key::Backspace),
    Trigger::Key(Key::PageUp),
    Trigger::Key(Key::PageDown),
    Trigger::Key(Key::Tab),
    Trigger::Drag(Button::Left),
    Trigger::Drag(Button::Middle),
    Trigger::Drag(Button::Right),
    Trigger::Wheel,
    Trigger::Click,
    Trigger::DoubleClick,
];

/// What the chords of a window do.
#[derive(Clone, Debug)]
pub struct Keymap {
    bindings: Vec<Binding>,
}

impl Default for Keymap {
    fn default() -> Keymap {
        Keymap {
            bindings: BINDINGS.to_vec(),
        }
    }
}

/// An action or gesture, and the chords that are to do it instead of those it had.
#[derive(Clone, Debug)]
pub struct Rebinding {
    effect: Effect,
    chords: Vec<Chord>,
}

impl Rebinding {
    /// No chord yet does what is called `name`; `None` when nothing is.
    #[must_use]
    pub fn of(name: &str) -> Option<Rebinding> {
        let found = BINDINGS.iter().find(|b| name_of(b.effect) == name)?;
        Some(Rebinding {
            effect: found.effect,
            chords: Vec::new(),
        })
    }

    /// A chord more, as the key sheet writes it.
    ///
    /// # Errors
    /// Why not, in words.
    pub fn add(&mut self, chord: &str) -> Result<Chord, String> {
        let chord: Chord = chord.parse()?;
        if !fits(chord.trigger, self.effect) {
            return Err(format!(
                "{} cannot be done by {chord}: {}",
                name_of(self.effect),
                needs(self.effect)
            ));
        }
        self.chords.push(chord);
        Ok(chord)
    }
}

impl Keymap {
    /// The usual table with changes. A chord that is given away is taken from whatever had it.
    #[must_use]
    pub fn with(changes: &[Rebinding]) -> Keymap {
        let given: HashSet<Chord> = changes.iter().flat_map(|c| &c.chords).copied().collect();
        let mut bindings: Vec<Binding> = Vec::new();
        let mut done: Vec<Effect> = Vec::new();
        for binding in BINDINGS {
            let change = changes.iter().find(|c| c.effect == binding.effect);
            let Some(change) = change else {
                if !given.contains(&binding.chord) {
                    bindings.push(*binding);
                }
                continue;
            };
            if !done.contains(&change.effect) {
                done.push(change.effect);
                let chords = change.chords.iter();
                bindings.extend(chords.map(|&chord| Binding { chord, ..*binding }));
            }
        }
        Keymap { bindings }
    }

    /// What a chord is bound to.
    #[must_use]
    pub fn bound_to(&self, chord: Chord) -> Option<Effect> {
        let found = self.bindings.iter().find(|b| b.chord == chord);
        found.map(|b| b.effect)
    }

    /// The chord that does an action, for messages; `None` when nothing does.
    #[must_use]
    pub fn chord_of(&self, action: Action) -> Option<Chord> {
        let effect = Effect::Press(action);
        let found = self.bindings.iter().find(|b| b.effect == effect);
        found.map(|b| b.chord)
    }

    /// The table as lines of (chords, words). Neighbours with the same words share a line.
    #[must_use]
    pub fn sheet(&self) -> Vec<(String, &'static str)> {
        let mut lines: Vec<(String, &'static str)> = Vec::new();
        for binding in &self.bindings {
            match lines.last_mut() {
                Some((chords, says)) if *says == binding.says => {
                    *chords += &format!(" {}", binding.chord);
                }
                _ => lines.push((binding.chord.to_string(), binding.says)),
            }
        }
        lines
    }

    /// The table as the `[keys]` of a settings file: `name = ["chord", ..]  # words`.
    #[must_use]
    pub fn listing(&self) -> String {
        let entries = effects().map(|(effect, says)| {
            let chords = self.bindings.iter().filter(|b| b.effect == effect);
            let chords: Vec<String> = chords.map(|b| quoted(&b.chord.to_string())).collect();
            let value = match &chords[..] {
                [one] => one.clone(),
                several => format!("[{}]", several.join(", ")),
            };
            (format!("{} = {value}", name_of(effect)), says)
        });
        let entries: Vec<(String, &str)> = entries.collect();
        let width = entries.iter().map(|(entry, _)| entry.len()).max();
        let width = width.unwrap_or(0);
        let mut text = String::from("[keys]\n");
        for (entry, says) in entries {
            writeln!(text, "{entry:width$}  # {says}").expect("a String takes any text");
        }
        text
    }
}

/// What a key means while a question waits, whatever it is bound to.
#[must_use]
pub fn answer(key: Key) -> Option<Action> {
    match key {
        Key::Char('y') => Some(Action::Accept),
        Key::Char('n') => Some(Action::Decline),
        _ => None,
    }
}

/// The names of everything that chords can do.
pub fn names() -> impl Iterator<Item = String> {
    effects().map(|(effect, _)| name_of(effect))
}

/// Everything that chords can do, once, with its words.
fn effects() -> impl Iterator<Item = (Effect, &'static str)> {
    let is_first = |i: &usize| {
        let earlier = &BINDINGS[..*i];
        earlier.iter().all(|b| b.effect != BINDINGS[*i].effect)
    };
    let firsts = (0..BINDINGS.len()).filter(is_first);
    firsts.map(|i| (BINDINGS[i].effect, BINDINGS[i].says))
}

/// What an effect is called in a settings file: the words of a session's script, where there are any.
fn name_of(effect: Effect) -> String {
    match effect {
        Effect::Press(Action::StepFrames(frames)) if frames < 0 => "previous-frame".into(),
        Effect::Press(Action::StepFrames(_)) => "next-frame".into(),
        Effect::Press(Action::ScaleSpeed(factor)) => match factor {
            _ if factor <= 0.5 => "half-speed".into(),
            _ if factor < 1.0 => "slower".into(),
            _ if factor < 2.0 => "faster".into(),
            _ => "double-speed".into(),
        },
        Effect::Press(Action::ScaleCost(factor)) if factor < 1.0 => "brighter-cost".into(),
        Effect::Press(Action::ScaleCost(_)) => "darker-cost".into(),
        Effect::Press(Action::Zoom(steps)) if steps > 0 => "larger-letters".into(),
        Effect::Press(Action::Zoom(_)) => "smaller-letters".into(),
        Effect::Press(action) => action.to_string().replace(' ', "-"),
        Effect::Hold { axis, reverse } => {
            let axis = match axis {
                Axis::X => "x",
                Axis::Y => "y",
                Axis::Z => "z",
            };
            format!("turn-{axis}{}", if reverse { "-reverse" } else { "" })
        }
        Effect::Grip(Grip::Orbit) => "orbit".into(),
        Effect::Grip(Grip::Roll) => "roll".into(),
        Effect::Grip(Grip::Pan) => "pan".into(),
        Effect::Grip(Grip::Dolly) => "dolly".into(),
        Effect::Grip(Grip::DollyAt) => "dolly-to-cursor".into(),
        Effect::At(Spot::Pick) => "pick".into(),
        Effect::At(Spot::Measure) => "measure".into(),
        Effect::At(Spot::Pivot) => "pivot".into(),
    }
}

fn fits(trigger: Trigger, effect: Effect) -> bool {
    match trigger {
        Trigger::Key(_) => matches!(effect, Effect::Press(_) | Effect::Hold { .. }),
        Trigger::Drag(_) => matches!(effect, Effect::Grip(_)),
        Trigger::Wheel => matches!(effect, Effect::Grip(Grip::Dolly | Grip::DollyAt)),
        Trigger::Click | Trigger::DoubleClick => matches!(effect, Effect::At(_)),
    }
}

/// By what an effect can be done.
fn needs(effect: Effect) -> &'static str {
    match effect {
        Effect::Press(_) | Effect::Hold { .. } => "it needs a key",
        Effect::Grip(Grip::Dolly | Grip::DollyAt) => {
            "it needs the wheel or a drag, like right-drag"
        }
        Effect::Grip(_) => "it needs a drag, like left-drag",
        Effect::At(_) => "it needs click or double-click",
    }
}

/// As a TOML string.
fn quoted(chord: &str) -> String {
    format!("\"{}\"", chord.replace('\\', "\\\\").replace('"', "\\\""))
}

/// The text after `prefix`, in whatever case that is written.
fn without<'t>(text: &'t str, prefix: &str) -> Option<&'t str> {
    let head = text.get(..prefix.len())?;
    let rest = &text[prefix.len()..];
    (head.eq_ignore_ascii_case(prefix) && !rest.is_empty()).then_some(rest)
}

/// Reads what [`Chord`]'s `Display` writes: `Ctrl+Shift+s`, `left-drag`, `?`.
impl FromStr for Chord {
    type Err = String;

    fn from_str(text: &str) -> Result<Chord, String> {
        let mut modifiers = Modifiers::default();
        let mut rest = text;
        loop {
            if let Some(after) = without(rest, "ctrl+") {
                (modifiers.ctrl, rest) = (true, after);
            } else if let Some(after) = without(rest, "shift+") {
                (modifiers.shift, rest) = (true, after);
            } else {
                break;
            }
        }
        let trigger = trigger_of(rest)?;
        let chord = Chord { trigger, modifiers };
        match trigger {
            Trigger::Key(key) if Chord::of_key(key, modifiers) != chord => Err(format!(
                "Shift is part of what types {rest:?}: write what the key types, without Shift"
            )),
            _ => Ok(chord),
        }
    }
}

fn trigger_of(text: &str) -> Result<Trigger, String> {
    let function_keys = (1..=12).map(|number| Trigger::Key(Key::F(number)));
    for trigger in NAMED.into_iter().chain(function_keys) {
        let modifiers = Modifiers::default();
        let name = Chord { trigger, modifiers }.to_string();
        if name.eq_ignore_ascii_case(text) {
            return Ok(trigger);
        }
    }
    for foreign in ["alt+", "super+", "meta+", "win+", "cmd+"] {
        if without(text, foreign).is_some() {
            return Err("only Ctrl and Shift can be used: others belong to the desktop".into());
        }
    }
    let mut letters = text.chars();
    match (letters.next(), letters.next()) {
        (Some(c), None) if c.is_uppercase() => Err(format!(
            "keys are lower-case letters: write \"{}\" or \"Shift+{0}\"",
            c.to_lowercase()
        )),
        (Some(c), None) if !c.is_whitespace() && !c.is_control() => Ok(Trigger::Key(Key::Char(c))),
        _ => Err(format!("there is no key or gesture called {text:?}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn change(name: &str, chords: &[&str]) -> Rebinding {
        let mut change = Rebinding::of(name).expect("a name");
        for chord in chords {
            change.add(chord).expect("a chord");
        }
        change
    }

    fn keymaps() -> [Keymap; 3] {
        let changes = [
            change("quit", &["x", "Ctrl+q"]),
            change("turn-y", &[]),
            change("sheet", &["/"]),
            change("orbit", &["Shift+right-drag"]),
        ];
        let swap = [
            change("undo", &["Ctrl+Shift+z"]),
            change("redo", &["Ctrl+z"]),
        ];
        [
            Keymap::default(),
            Keymap::with(&changes),
            Keymap::with(&swap),
        ]
    }

    #[test]
    fn no_two_actions_share_a_chord() {
        for keymap in keymaps() {
            let mut seen = HashSet::new();
            for b in &keymap.bindings {
                assert!(seen.insert(b.chord), "{} is bound twice", b.chord);
            }
        }
    }

    #[test]
    fn the_sheet_tells_every_chord_once() {
        for keymap in keymaps() {
            let sheet = keymap.sheet();
            let text: String = sheet.iter().map(|(c, _)| format!(" {c} ")).collect();
            for b in &keymap.bindings {
                let chord = format!(" {} ", b.chord);
                assert_eq!(text.matches(&chord).count(), 1, "{chord} in {text}");
            }
        }
    }

    #[test]
    fn every_effect_has_a_name_of_its_own_and_every_chord_reads_back() {
        let mut names = HashSet::new();
        for (effect, _) in effects() {
            let name = name_of(effect);
            let plain = |c: char| c.is_ascii_lowercase() || c == '-';
            assert!(name.chars().all(plain), "{name}");
            assert_eq!(Rebinding::of(&name).expect("found").effect, effect);
            assert!(names.insert(name.clone()), "{name} is used twice");
        }
        for b in BINDINGS {
            let chord = b.chord.to_string();
            assert_eq!(chord.parse(), Ok(b.chord), "{chord}");
            assert!(fits(b.chord.trigger, b.effect), "{chord}");
        }
    }

    #[test]
    fn a_chord_that_is_given_away_is_taken_from_what_had_it() {
        let [_, changed, swapped] = keymaps();
        let on = |keymap: &Keymap, chord: &str| keymap.bound_to(chord.parse().expect("a chord"));
        let press = |action| Some(Effect::Press(action));
        assert_eq!(on(&changed, "x"), press(Action::Quit));
        assert_eq!(on(&changed, "Ctrl+q"), press(Action::Quit));
        assert_eq!(on(&changed, "q"), None);
        assert_eq!(on(&changed, "y"), None);
        assert_eq!(on(&changed, "left-drag"), None);
        assert_eq!(changed.chord_of(Action::ToggleSheet), "/".parse().ok());
        assert_eq!(on(&swapped, "ctrl+SHIFT+z"), press(Action::Undo));
        assert_eq!(on(&swapped, "Ctrl+z"), press(Action::Redo));
        assert!(changed.listing().contains("\nturn-y = []"));
        assert!(changed.listing().contains("\nquit = [\"x\", \"Ctrl+q\"]"));
    }

    #[test]
    fn chords_that_no_hand_can_do_are_told_apart() {
        for (chord, why) in [
            ("Shift+?", "without Shift"),
            ("Q", "\"q\" or \"Shift+q\""),
            ("Alt+x", "only Ctrl and Shift"),
            ("F13", "no key or gesture called \"F13\""),
            ("Ctrl+", "no key or gesture"),
            ("", "no key or gesture"),
            (" ", "no key or gesture"),
        ] {
            let error = chord.parse::<Chord>().expect_err(chord);
            assert!(error.contains(why), "{chord}: {error}");
        }
        assert_eq!(
            "Ctrl++".parse::<Chord>().map(|c| c.to_string()),
            Ok("Ctrl++".into())
        );
        for (name, chord, why) in [
            ("quit", "left-drag", "needs a key"),
            ("roll", "wheel", "needs a drag"),
            ("dolly", "d", "needs the wheel"),
            ("pick", "p", "needs click"),
        ] {
            let error = Rebinding::of(name).expect("a name").add(chord);
            let error = error.expect_err(chord);
            assert!(error.contains(why), "{error}");
        }
    }

    #[test]
    fn questions_are_answered_by_y_and_n() {
        assert_eq!(answer(Key::Char('y')), Some(Action::Accept));
        assert_eq!(answer(Key::Char('n')), Some(Action::Decline));
        assert_eq!(answer(Key::Escape), None);
    }
}
