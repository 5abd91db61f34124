//! Raw input to [`Action`]s. Plain data: no window, no clock.

use super::action::{Action, Button, Chord, Effect, Grip, Key, Modifiers, Trigger, bound_to};
use crate::scene::Axis;

/// Tells one physical key from another, whatever it types.
pub type KeyId = u32;

/// What hands are doing: modifiers and keys that are down, and a drag under way.
#[derive(Debug, Default)]
pub struct Input {
    modifiers: Modifiers,
    held: Vec<(KeyId, Axis)>,
    cursor_px: Option<(f64, f64)>,
    drag: Option<(Button, Grip)>,
}

impl Input {
    /// The modifiers changed.
    pub fn set_modifiers(&mut self, modifiers: Modifiers) {
        self.modifiers = modifiers;
    }

    /// A key goes down. Repeats of a held key do nothing.
    pub fn key_down(&mut self, id: KeyId, key: Key, repeat: bool) -> Option<Action> {
        if repeat || self.modifiers.foreign {
            return None;
        }
        match bound_to(Chord::of_key(key, self.modifiers))? {
            Effect::Press(action) => Some(action),
            Effect::Hold { axis, reverse } => {
                // The same axis from a second key: the newer one counts.
                self.held.retain(|&(_, held)| held != axis);
                self.held.push((id, axis));
                Some(Action::StartTurn { axis, reverse })
            }
            Effect::Grip(_) => None,
        }
    }

    /// A key goes up. It is known by its place: with Shift let go first it no longer types what it did.
    pub fn key_up(&mut self, id: KeyId) -> Option<Action> {
        let at = self.held.iter().position(|&(held, _)| held == id)?;
        let (_, axis) = self.held.remove(at);
        Some(Action::StopTurn(axis))
    }

    /// A mouse button goes down: a drag may begin. A second button during a drag changes nothing.
    pub fn button_down(&mut self, button: Button) {
        let chord = Chord {
            trigger: Trigger::Drag(button),
            modifiers: self.modifiers,
        };
        if let (None, Some(Effect::Grip(grip))) = (self.drag, bound_to(chord)) {
            self.drag = Some((button, grip));
        }
    }

    /// A mouse button goes up.
    pub fn button_up(&mut self, button: Button) {
        if self.drag.is_some_and(|(held, _)| held == button) {
            self.drag = None;
        }
    }

    /// The cursor is at a place in the window, or, while it drags, outside of it.
    pub fn cursor_moved(&mut self, x_px: f64, y_px: f64) -> Option<Action> {
        let (old_x, old_y) = self.cursor_px.replace((x_px, y_px))?;
        let (dx_px, dy_px) = (x_px - old_x, y_px - old_y);
        let (_, grip) = self.drag?;
        Some(match grip {
            Grip::Orbit => Action::Orbit { dx_px, dy_px },
            Grip::Pan => Action::Pan { dx_px, dy_px },
            Grip::Dolly => Action::DollyDrag { dy_px },
        })
    }

    /// The wheel turned by so many notches, away from the user counting up.
    pub fn wheel(&mut self, notches: f64) -> Option<Action> {
        let chord = Chord {
            trigger: Trigger::Wheel,
            modifiers: self.modifiers,
        };
        match bound_to(chord)? {
            Effect::Grip(Grip::Dolly) => Some(Action::Dolly { notches }),
            _ => None,
        }
    }

    /// The window lost the keyboard: releases go elsewhere from now on, so everything is let go.
    pub fn focus_lost(&mut self) -> Action {
        *self = Input {
            cursor_px: self.cursor_px,
            ..Input::default()
        };
        Action::StopTurns
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHIFT: Modifiers = Modifiers {
        shift: true,
        ctrl: false,
        foreign: false,
    };

    #[test]
    fn a_held_axis_key_starts_once_and_stops_when_let_go() {
        let mut input = Input::default();
        let start = Action::StartTurn {
            axis: Axis::X,
            reverse: false,
        };
        assert_eq!(input.key_down(1, Key::Char('x'), false), Some(start));
        assert_eq!(input.key_down(1, Key::Char('x'), true), None);
        assert_eq!(input.key_up(1), Some(Action::StopTurn(Axis::X)));
        assert_eq!(input.key_up(1), None);
    }

    #[test]
    fn shift_let_go_before_the_key_still_stops_it() {
        let mut input = Input::default();
        input.set_modifiers(SHIFT);
        let start = Action::StartTurn {
            axis: Axis::Z,
            reverse: true,
        };
        assert_eq!(input.key_down(7, Key::Char('z'), false), Some(start));
        input.set_modifiers(Modifiers::default());
        assert_eq!(input.key_up(7), Some(Action::StopTurn(Axis::Z)));
    }

    #[test]
    fn lost_focus_lets_go_of_everything() {
        let mut input = Input::default();
        input.key_down(1, Key::Char('y'), false);
        input.button_down(Button::Left);
        assert_eq!(input.focus_lost(), Action::StopTurns);
        assert_eq!(input.key_up(1), None);
        input.cursor_moved(0.0, 0.0);
        assert_eq!(input.cursor_moved(9.0, 9.0), None);
    }

    #[test]
    fn a_drag_keeps_its_meaning_until_its_button_goes_up() {
        let mut input = Input::default();
        input.cursor_moved(10.0, 10.0);
        input.button_down(Button::Left);
        input.set_modifiers(SHIFT);
        input.button_down(Button::Right);
        input.button_up(Button::Right);
        let orbit = Action::Orbit {
            dx_px: 2.0,
            dy_px: -1.0,
        };
        assert_eq!(input.cursor_moved(12.0, 9.0), Some(orbit));
        input.button_up(Button::Left);
        input.button_down(Button::Left);
        let pan = Action::Pan {
            dx_px: 1.0,
            dy_px: 0.0,
        };
        assert_eq!(input.cursor_moved(13.0, 9.0), Some(pan));
    }

    #[test]
    fn chords_of_the_desktop_are_left_alone() {
        let mut input = Input::default();
        input.set_modifiers(Modifiers {
            foreign: true,
            ..Modifiers::default()
        });
        assert_eq!(input.key_down(1, Key::Char('q'), false), None);
    }
}
