//! What a user can do, and the one table that says by which key or gesture.
//!
//! Input looks chords up in [`BINDINGS`], and the key sheet prints the same table: they cannot disagree.

use std::fmt;

use crate::scene::Axis;

/// Something that changes the viewer's state. Distances are in physical pixels, right and down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action {
    /// Begin turning about a world axis, and go on until told to stop.
    StartTurn {
        /// Through the pivot.
        axis: Axis,
        /// The other way than the right-handed one.
        reverse: bool,
    },
    /// Stop turning about that axis.
    StopTurn(Axis),
    /// Stop turning at all: the window lost the keyboard.
    StopTurns,
    /// The hand went that far while it holds the picture like a globe.
    Orbit {
        /// To the right.
        dx_px: f64,
        /// Down.
        dy_px: f64,
    },
    /// The hand went that far while it holds the point under the cursor.
    Pan {
        /// To the right.
        dx_px: f64,
        /// Down.
        dy_px: f64,
    },
    /// The hand went down that far while it pulls the picture nearer.
    DollyDrag {
        /// Down.
        dy_px: f64,
    },
    /// Nearer by so many notches of the wheel.
    Dolly {
        /// Negative: away.
        notches: f64,
    },
    /// Play the operations, or pause.
    TogglePlayback,
    /// Back to the still picture, without what the hand did.
    ReturnToScene,
    /// The next kind of picture.
    NextView,
    /// The next kernel that this CPU has.
    NextKernel,
    /// Show or hide the figures.
    ToggleStatistics,
    /// Show or hide the key sheet.
    ToggleSheet,
    /// Save the picture as it is rendered.
    Screenshot,
    /// Enter or leave fullscreen.
    ToggleFullscreen,
    /// Another scene of the file's folder.
    Browse {
        /// The next one by name; otherwise the one before.
        forward: bool,
    },
    /// Close the sheet, else leave fullscreen, else quit.
    Back,
    /// End the program.
    Quit,
}

/// A key by what it types, not by where it sits. Letters are lower case; Shift is told apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Key {
    /// A letter, digit or sign.
    Char(char),
    /// The space bar.
    Space,
    /// Enter, of the keypad too.
    Enter,
    /// Esc.
    Escape,
    /// Page up.
    PageUp,
    /// Page down.
    PageDown,
}

/// A button of the mouse.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Button {
    /// The first.
    Left,
    /// The wheel pressed.
    Middle,
    /// The second.
    Right,
}

/// Which modifiers are down. Chords with others (Alt, Super) belong to the desktop.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Modifiers {
    /// Shift.
    pub shift: bool,
    /// Ctrl.
    pub ctrl: bool,
    /// Any that no binding uses.
    pub foreign: bool,
}

impl Modifiers {
    const NONE: Modifiers = Modifiers {
        shift: false,
        ctrl: false,
        foreign: false,
    };
    const SHIFT: Modifiers = Modifiers {
        shift: true,
        ..Modifiers::NONE
    };
}

/// What a binding waits for, apart from the modifiers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Trigger {
    /// A key goes down.
    Key(Key),
    /// The mouse moves while this button is down.
    Drag(Button),
    /// The wheel turns.
    Wheel,
}

/// A trigger with its modifiers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Chord {
    /// The key or gesture.
    pub trigger: Trigger,
    /// Exactly these are down.
    pub modifiers: Modifiers,
}

impl Chord {
    /// The chord of a key press. Shift counts with letters and named keys; a sign such as `?` has used it up.
    #[must_use]
    pub fn of_key(key: Key, modifiers: Modifiers) -> Chord {
        let sign = matches!(key, Key::Char(c) if !c.is_alphabetic());
        Chord {
            trigger: Trigger::Key(key),
            modifiers: Modifiers {
                shift: modifiers.shift && !sign,
                ..modifiers
            },
        }
    }
}

impl fmt::Display for Chord {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.modifiers.ctrl {
            f.write_str("Ctrl+")?;
        }
        if self.modifiers.shift {
            f.write_str("Shift+")?;
        }
        match self.trigger {
            Trigger::Key(Key::Char(c)) => write!(f, "{c}"),
            Trigger::Key(Key::Space) => f.write_str("Space"),
            Trigger::Key(Key::Enter) => f.write_str("Enter"),
            Trigger::Key(Key::Escape) => f.write_str("Esc"),
            Trigger::Key(Key::PageUp) => f.write_str("PageUp"),
            Trigger::Key(Key::PageDown) => f.write_str("PageDown"),
            Trigger::Drag(Button::Left) => f.write_str("left-drag"),
            Trigger::Drag(Button::Middle) => f.write_str("middle-drag"),
            Trigger::Drag(Button::Right) => f.write_str("right-drag"),
            Trigger::Wheel => f.write_str("wheel"),
        }
    }
}

/// What a drag of the mouse does to the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grip {
    /// Turn about the pivot.
    Orbit,
    /// Shift in the picture plane.
    Pan,
    /// Nearer and away.
    Dolly,
}

/// What a chord does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Effect {
    /// One action as the key goes down.
    Press(Action),
    /// Turning while the key is down.
    Hold {
        /// About this axis.
        axis: Axis,
        /// The other way.
        reverse: bool,
    },
    /// Moves of the mouse, or turns of the wheel, become this.
    Grip(Grip),
}

/// A line of the table.
#[derive(Clone, Copy, Debug)]
pub struct Binding {
    /// By what.
    pub chord: Chord,
    /// Does what.
    pub effect: Effect,
    /// In words, for the key sheet. Neighbours with the same words share a line there.
    pub says: &'static str,
}

const fn key(key: Key, action: Action, says: &'static str) -> Binding {
    Binding {
        chord: Chord {
            trigger: Trigger::Key(key),
            modifiers: Modifiers::NONE,
        },
        effect: Effect::Press(action),
        says,
    }
}

const fn turn(c: char, axis: Axis, reverse: bool) -> Binding {
    Binding {
        chord: Chord {
            trigger: Trigger::Key(Key::Char(c)),
            modifiers: if reverse {
                Modifiers::SHIFT
            } else {
                Modifiers::NONE
            },
        },
        effect: Effect::Hold { axis, reverse },
        says: if reverse {
            "the same, the other way"
        } else {
            "turn the camera about that world axis (tap or hold)"
        },
    }
}

const fn grip(trigger: Trigger, modifiers: Modifiers, grip: Grip) -> Binding {
    Binding {
        chord: Chord { trigger, modifiers },
        effect: Effect::Grip(grip),
        says: match grip {
            Grip::Orbit => "orbit about the pivot",
            Grip::Pan => "pan: shift the picture",
            Grip::Dolly => "dolly: nearer or away",
        },
    }
}

/// Every key and gesture of the viewer.
pub const BINDINGS: &[Binding] = &[
    turn('x', Axis::X, false),
    turn('y', Axis::Y, false),
    turn('z', Axis::Z, false),
    turn('x', Axis::X, true),
    turn('y', Axis::Y, true),
    turn('z', Axis::Z, true),
    grip(Trigger::Drag(Button::Left), Modifiers::NONE, Grip::Orbit),
    grip(Trigger::Wheel, Modifiers::NONE, Grip::Dolly),
    grip(Trigger::Drag(Button::Right), Modifiers::NONE, Grip::Dolly),
    grip(Trigger::Drag(Button::Middle), Modifiers::NONE, Grip::Pan),
    grip(Trigger::Drag(Button::Left), Modifiers::SHIFT, Grip::Pan),
    key(
        Key::Space,
        Action::TogglePlayback,
        "play or pause the scene's operations",
    ),
    key(
        Key::Enter,
        Action::ReturnToScene,
        "return to the scene's camera",
    ),
    key(
        Key::Char('v'),
        Action::NextView,
        "next view: shaded, id, normal, depth, cost",
    ),
    key(
        Key::Char('k'),
        Action::NextKernel,
        "next kernel that this CPU has",
    ),
    key(
        Key::Char('i'),
        Action::ToggleStatistics,
        "statistics on or off",
    ),
    key(
        Key::Char('s'),
        Action::Screenshot,
        "save the picture as a PNG file",
    ),
    key(
        Key::Char('f'),
        Action::ToggleFullscreen,
        "fullscreen on or off",
    ),
    key(
        Key::PageDown,
        Action::Browse { forward: true },
        "next or previous scene of the folder",
    ),
    key(
        Key::PageUp,
        Action::Browse { forward: false },
        "next or previous scene of the folder",
    ),
    key(Key::Char('h'), Action::ToggleSheet, "this sheet on or off"),
    key(Key::Char('?'), Action::ToggleSheet, "this sheet on or off"),
    key(
        Key::Escape,
        Action::Back,
        "cancel loading, close the sheet, leave fullscreen, quit",
    ),
    key(Key::Char('q'), Action::Quit, "quit"),
];

/// What a chord is bound to.
#[must_use]
pub fn bound_to(chord: Chord) -> Option<Effect> {
    BINDINGS.iter().find(|b| b.chord == chord).map(|b| b.effect)
}

/// The table as lines of (chords, words).
#[must_use]
pub fn sheet() -> Vec<(String, &'static str)> {
    let mut lines: Vec<(String, &'static str)> = Vec::new();
    for binding in BINDINGS {
        match lines.last_mut() {
            Some((chords, says)) if *says == binding.says => {
                *chords += &format!("  {}", binding.chord);
            }
            _ => lines.push((binding.chord.to_string(), binding.says)),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn no_two_actions_share_a_chord() {
        let mut seen = HashSet::new();
        for b in BINDINGS {
            assert!(seen.insert(b.chord), "{} is bound twice", b.chord);
        }
    }

    #[test]
    fn every_bound_key_can_be_typed() {
        for b in BINDINGS {
            if let Trigger::Key(key) = b.chord.trigger {
                assert_eq!(Chord::of_key(key, b.chord.modifiers), b.chord);
                if let Key::Char(c) = key {
                    assert_eq!(c.to_lowercase().to_string(), c.to_string());
                }
            }
        }
    }

    #[test]
    fn a_sign_has_used_up_shift_and_a_letter_has_not() {
        let of = |c| Chord::of_key(Key::Char(c), Modifiers::SHIFT);
        assert_eq!(bound_to(of('?')), Some(Effect::Press(Action::ToggleSheet)));
        let reverse = Effect::Hold {
            axis: Axis::Y,
            reverse: true,
        };
        assert_eq!(bound_to(of('y')), Some(reverse));
        assert_eq!(bound_to(of('q')), None);
    }

    #[test]
    fn the_sheet_tells_every_chord_once() {
        let text: String = sheet().iter().map(|(c, _)| format!(" {c} ")).collect();
        for b in BINDINGS {
            let chord = format!(" {} ", b.chord);
            assert_eq!(text.matches(&chord).count(), 1, "{chord} in {text}");
        }
    }
}
