//! The one table that says by which key or gesture an action is done.
//!
//! Input looks chords up in a [`Keymap`] made of [`BINDINGS`]; the key sheet, `--list-bindings` and a test of the README
//! print the same table: they cannot disagree.
//!
//! [`Keymap`]: super::keymap::Keymap

use std::fmt;

use super::action::{Action, Side};
use crate::render::ViewMode;
use crate::scene::Axis;

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
    /// The arrow.
    Left,
    /// The arrow.
    Right,
    /// Home.
    Home,
    /// End.
    End,
    /// Backspace.
    Backspace,
    /// Page up.
    PageUp,
    /// Page down.
    PageDown,
    /// Tab.
    Tab,
    /// A function key.
    F(u8),
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
    const CTRL: Modifiers = Modifiers {
        ctrl: true,
        ..Modifiers::NONE
    };
    const CTRL_SHIFT: Modifiers = Modifiers {
        shift: true,
        ..Modifiers::CTRL
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
    /// The left button goes down and soon up again, at one place.
    Click,
    /// The same twice.
    DoubleClick,
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
            Trigger::Key(Key::Left) => f.write_str("Left"),
            Trigger::Key(Key::Right) => f.write_str("Right"),
            Trigger::Key(Key::Home) => f.write_str("Home"),
            Trigger::Key(Key::End) => f.write_str("End"),
            Trigger::Key(Key::Backspace) => f.write_str("Backspace"),
            Trigger::Key(Key::PageUp) => f.write_str("PageUp"),
            Trigger::Key(Key::PageDown) => f.write_str("PageDown"),
            Trigger::Key(Key::Tab) => f.write_str("Tab"),
            Trigger::Key(Key::F(number)) => write!(f, "F{number}"),
            Trigger::Drag(Button::Left) => f.write_str("left-drag"),
            Trigger::Drag(Button::Middle) => f.write_str("middle-drag"),
            Trigger::Drag(Button::Right) => f.write_str("right-drag"),
            Trigger::Wheel => f.write_str("wheel"),
            Trigger::Click => f.write_str("click"),
            Trigger::DoubleClick => f.write_str("double-click"),
        }
    }
}

/// What a drag of the mouse does to the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grip {
    /// Turn about the pivot.
    Orbit,
    /// Turn about the view.
    Roll,
    /// Shift in the picture plane.
    Pan,
    /// Nearer and away.
    Dolly,
    /// Nearer to the place under the cursor, and away from it.
    DollyAt,
}

/// What the place of a click is taken for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spot {
    /// To tell what is there.
    Pick,
    /// To tell how far it is.
    Measure,
    /// To orbit about it.
    Pivot,
}

/// What a chord does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Effect {
    /// One action as the key goes down.
    Press(Action),
    /// Turning while the key is down; a drag meanwhile is held to the axis.
    Hold {
        /// About this axis.
        axis: Axis,
        /// The other way.
        reverse: bool,
    },
    /// Moves of the mouse, or turns of the wheel, become this.
    Grip(Grip),
    /// A place in the picture is taken for this.
    At(Spot),
}

/// A line of the table.
#[derive(Clone, Copy, Debug)]
pub struct Binding {
    /// By what.
    pub chord: Chord,
    /// Does what.
    pub effect: Effect,
    /// In words. Neighbours with the same words share a line of the sheet.
    pub says: &'static str,
}

const fn bind(
    trigger: Trigger,
    modifiers: Modifiers,
    effect: Effect,
    says: &'static str,
) -> Binding {
    Binding {
        chord: Chord { trigger, modifiers },
        effect,
        says,
    }
}

const fn key(key: Key, action: Action, says: &'static str) -> Binding {
    with(Modifiers::NONE, key, action, says)
}

const fn with(modifiers: Modifiers, key: Key, action: Action, says: &'static str) -> Binding {
    bind(Trigger::Key(key), modifiers, Effect::Press(action), says)
}

const fn letter(c: char, action: Action, says: &'static str) -> Binding {
    key(Key::Char(c), action, says)
}

const fn turn(c: char, axis: Axis, modifiers: Modifiers) -> Binding {
    let effect = Effect::Hold {
        axis,
        reverse: modifiers.shift,
    };
    let says = if modifiers.shift {
        "the same, the other way"
    } else {
        "turn about that world axis; held in a drag: only about it"
    };
    bind(Trigger::Key(Key::Char(c)), modifiers, effect, says)
}

const fn grip(trigger: Trigger, modifiers: Modifiers, grip: Grip) -> Binding {
    let says = match grip {
        Grip::Orbit => "orbit about the pivot",
        Grip::Roll => "roll",
        Grip::Pan => "pan: shift the picture",
        Grip::Dolly => "dolly: nearer or away",
        Grip::DollyAt => "dolly towards the cursor",
    };
    bind(trigger, modifiers, Effect::Grip(grip), says)
}

const fn look(c: char, from: Side, modifiers: Modifiers) -> Binding {
    let action = Action::Look {
        from,
        opposite: modifiers.ctrl,
    };
    let says = if modifiers.ctrl {
        "the same from the other side"
    } else {
        "look from the front, the right, the top, a corner"
    };
    with(modifiers, Key::Char(c), action, says)
}

const fn view(number: u8, mode: ViewMode) -> Binding {
    key(Key::F(number), Action::ShowView(mode), VIEWS)
}

const fn right_view(number: u8, mode: ViewMode) -> Binding {
    let action = Action::ShowRightView(mode);
    with(Modifiers::SHIFT, Key::F(number), action, RIGHT_VIEWS)
}

const VIEWS: &str = "view: shaded, id, normal, depth, cost";
const COST: &str = "the view cost: brighter, darker";
const RIGHT_VIEWS: &str = "the same on the right side of a split";
const RIGHT: &str = "right side of a split: next engine, next view";
const FRAME: &str = "one frame back, one on";
const OPERATION: &str = "one operation back, one on";
const ENDS: &str = "to the first frame, to the last";
const SPEED: &str = "play at half the speed, slower, faster, at twice the speed";
const BROWSE: &str = "next or previous scene of the folder";
const ZOOM: &str = "larger, smaller letters over the picture";
const SHEET: &str = "this sheet on or off";
const UNDO: &str = "undo a move, redo it";
const FULLSCREEN: &str = "fullscreen on or off";
const QUIT: &str = "quit";
const FIT: &str = "fit the whole scene into the window";
const SAVE: &str = "save the scene with the moves; under a new name";

/// Every key and gesture of the viewer.
pub const BINDINGS: &[Binding] = &[
    turn('x', Axis::X, Modifiers::NONE),
    turn('y', Axis::Y, Modifiers::NONE),
    turn('z', Axis::Z, Modifiers::NONE),
    turn('x', Axis::X, Modifiers::SHIFT),
    turn('y', Axis::Y, Modifiers::SHIFT),
    turn('z', Axis::Z, Modifiers::SHIFT),
    grip(Trigger::Drag(Button::Left), Modifiers::NONE, Grip::Orbit),
    grip(Trigger::Drag(Button::Left), Modifiers::CTRL, Grip::Roll),
    grip(Trigger::Drag(Button::Middle), Modifiers::NONE, Grip::Pan),
    grip(Trigger::Drag(Button::Left), Modifiers::SHIFT, Grip::Pan),
    grip(Trigger::Wheel, Modifiers::NONE, Grip::Dolly),
    grip(Trigger::Drag(Button::Right), Modifiers::NONE, Grip::Dolly),
    grip(Trigger::Wheel, Modifiers::CTRL, Grip::DollyAt),
    grip(Trigger::Drag(Button::Right), Modifiers::CTRL, Grip::DollyAt),
    bind(
        Trigger::Click,
        Modifiers::NONE,
        Effect::At(Spot::Pick),
        "pick: what is seen there",
    ),
    bind(
        Trigger::Click,
        Modifiers::CTRL,
        Effect::At(Spot::Measure),
        "how far that is from what was picked",
    ),
    bind(
        Trigger::DoubleClick,
        Modifiers::NONE,
        Effect::At(Spot::Pivot),
        "orbit about what is seen there (else: the format's pivot)",
    ),
    letter('t', Action::ToggleTurntable, "turntable or trackball"),
    look('1', Side::Front, Modifiers::NONE),
    look('3', Side::Right, Modifiers::NONE),
    look('7', Side::Top, Modifiers::NONE),
    look('9', Side::Corner, Modifiers::NONE),
    look('1', Side::Front, Modifiers::CTRL),
    look('3', Side::Right, Modifiers::CTRL),
    look('7', Side::Top, Modifiers::CTRL),
    look('9', Side::Corner, Modifiers::CTRL),
    letter('0', Action::Fit, FIT),
    with(Modifiers::SHIFT, Key::Char('c'), Action::Fit, FIT),
    key(
        Key::Enter,
        Action::ReturnToScene,
        "return to the scene's camera",
    ),
    key(
        Key::Space,
        Action::TogglePlayback,
        "play the scene's operations, pause",
    ),
    with(
        Modifiers::CTRL_SHIFT,
        Key::Space,
        Action::TogglePlaybackBackwards,
        "play them backwards",
    ),
    letter(',', Action::StepFrames(-1), FRAME),
    letter('.', Action::StepFrames(1), FRAME),
    key(Key::Left, Action::StepOperation { back: true }, OPERATION),
    key(Key::Right, Action::StepOperation { back: false }, OPERATION),
    key(Key::Home, Action::GoToStart, ENDS),
    key(Key::End, Action::GoToEnd, ENDS),
    letter('{', Action::ScaleSpeed(0.5), SPEED),
    letter('[', Action::ScaleSpeed(1.0 / 1.1), SPEED),
    letter(']', Action::ScaleSpeed(1.1), SPEED),
    letter('}', Action::ScaleSpeed(2.0), SPEED),
    key(
        Key::Backspace,
        Action::NormalSpeed,
        "play at the normal speed",
    ),
    letter(
        'l',
        Action::MarkSection,
        "set the ends of a loop, then drop them",
    ),
    with(
        Modifiers::SHIFT,
        Key::Char('l'),
        Action::NextOrder,
        "play once, loop, ping-pong, cyclic",
    ),
    letter(
        'r',
        Action::ToggleRecording,
        "record moves as operations, stop recording",
    ),
    with(Modifiers::CTRL, Key::Char('z'), Action::Undo, UNDO),
    with(Modifiers::CTRL_SHIFT, Key::Char('z'), Action::Redo, UNDO),
    with(Modifiers::CTRL, Key::Char('y'), Action::Redo, UNDO),
    with(Modifiers::CTRL, Key::Char('s'), Action::Save, SAVE),
    with(Modifiers::CTRL_SHIFT, Key::Char('s'), Action::SaveAs, SAVE),
    letter(
        'c',
        Action::PrintCamera,
        "print the camera as the text of a scene",
    ),
    letter(
        'v',
        Action::NextView,
        "next view: shaded, id, normal, depth, cost",
    ),
    view(1, ViewMode::Shaded),
    view(2, ViewMode::Id),
    view(3, ViewMode::Normal),
    view(4, ViewMode::Depth),
    view(5, ViewMode::Cost),
    right_view(1, ViewMode::Shaded),
    right_view(2, ViewMode::Id),
    right_view(3, ViewMode::Normal),
    right_view(4, ViewMode::Depth),
    right_view(5, ViewMode::Cost),
    key(Key::F(9), Action::ScaleCost(0.5), COST),
    key(Key::F(10), Action::ScaleCost(2.0), COST),
    letter(
        'b',
        Action::NextEngine,
        "next engine: fast, brute force, the report's method",
    ),
    key(
        Key::Tab,
        Action::ToggleSplit,
        "split: two engines or views side by side; drag the divider",
    ),
    with(
        Modifiers::SHIFT,
        Key::Char('b'),
        Action::NextRightEngine,
        RIGHT,
    ),
    with(
        Modifiers::SHIFT,
        Key::Char('v'),
        Action::NextRightView,
        RIGHT,
    ),
    letter(
        'k',
        Action::NextKernel,
        "next kernel: scalar, SSE, AVX2, AVX-512",
    ),
    letter('i', Action::ToggleStatistics, "statistics on or off"),
    letter('a', Action::ToggleAxes, "the cross of the axes on or off"),
    with(Modifiers::CTRL, Key::Char('='), Action::Zoom(1), ZOOM),
    with(Modifiers::CTRL, Key::Char('+'), Action::Zoom(1), ZOOM),
    with(Modifiers::CTRL, Key::Char('-'), Action::Zoom(-1), ZOOM),
    letter('s', Action::Screenshot, "save the picture as a PNG file"),
    letter('f', Action::ToggleFullscreen, FULLSCREEN),
    key(Key::F(11), Action::ToggleFullscreen, FULLSCREEN),
    key(Key::PageDown, Action::Browse { forward: true }, BROWSE),
    key(Key::PageUp, Action::Browse { forward: false }, BROWSE),
    letter('h', Action::ToggleSheet, SHEET),
    letter('?', Action::ToggleSheet, SHEET),
    key(
        Key::Escape,
        Action::Back,
        "cancel loading, close what is open, leave fullscreen, quit",
    ),
    letter('q', Action::Quit, QUIT),
    with(Modifiers::CTRL, Key::Char('q'), Action::Quit, QUIT),
    letter('n', Action::Decline, "answer no (y: yes)"),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::keymap::Keymap;

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
        let keymap = Keymap::default();
        let bound_to = |chord| keymap.bound_to(chord);
        let of = |c| Chord::of_key(Key::Char(c), Modifiers::SHIFT);
        assert_eq!(bound_to(of('?')), Some(Effect::Press(Action::ToggleSheet)));
        let reverse = Effect::Hold {
            axis: Axis::Y,
            reverse: true,
        };
        assert_eq!(bound_to(of('y')), Some(reverse));
        assert_eq!(bound_to(of('q')), None);
    }
}
