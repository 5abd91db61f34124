//! Raw input to [`Action`]s. Plain data: no window, no clock; the time of an event enters as a value.

use std::sync::Arc;
use std::time::Duration;

use super::action::Action;
use super::bindings::{Button, Chord, Effect, Grip, Key, Modifiers, Spot, Trigger};
use super::keymap::Keymap;
use crate::scene::Axis;

/// Tells one physical key from another, whatever it types.
pub type KeyId = u32;

/// A press shorter than this that stays within [`CLICK_PX`] is a click.
const CLICK: Duration = Duration::from_millis(300);
/// How far a click may wander.
const CLICK_PX: f64 = 4.0;
/// A second click that soon after the first makes it a double one.
const DOUBLE_CLICK: Duration = Duration::from_millis(400);

/// A button that is down.
#[derive(Clone, Copy, Debug)]
struct Press {
    button: Button,
    /// What its drag does, if anything.
    grip: Option<Grip>,
    /// The modifiers as it went down.
    modifiers: Modifiers,
    since: Duration,
    at: (f64, f64),
    /// It is a drag, no click any more.
    dragging: bool,
}

/// What hands are doing: modifiers and keys that are down, and a press under way.
#[derive(Debug, Default)]
pub struct Input {
    keymap: Arc<Keymap>,
    modifiers: Modifiers,
    held: Vec<(KeyId, Axis)>,
    cursor_px: Option<(f64, f64)>,
    press: Option<Press>,
    last_click: Option<(Duration, (f64, f64))>,
    /// A button of X11 that stands for a notch of the wheel went up just now.
    wheel_let_go: bool,
}

impl Input {
    /// Hands at rest, on these chords.
    #[must_use]
    pub fn new(keymap: Arc<Keymap>) -> Input {
        Input {
            keymap,
            ..Input::default()
        }
    }

    /// The modifiers changed.
    pub fn set_modifiers(&mut self, modifiers: Modifiers) {
        self.modifiers = modifiers;
    }

    /// A key goes down, or is held and `repeat`s itself: then it only does what goes on by steps.
    pub fn key_down(&mut self, id: KeyId, key: Key, repeat: bool) -> Option<Action> {
        if self.modifiers.foreign {
            return None;
        }
        match self.keymap.bound_to(Chord::of_key(key, self.modifiers))? {
            Effect::Press(action) => (!repeat || action.repeats()).then_some(action),
            Effect::Hold { .. } if repeat => None,
            Effect::Hold { axis, reverse } => {
                // The same axis from a second key: the newer one counts.
                self.held.retain(|&(_, held)| held != axis);
                self.held.push((id, axis));
                // In the middle of a drag the key only says which axis.
                let orbits = |p: &Press| p.dragging && p.grip == Some(Grip::Orbit);
                let dragging = self.press.as_ref().is_some_and(orbits);
                (!dragging).then_some(Action::StartTurn { axis, reverse })
            }
            Effect::Grip(_) | Effect::At(_) => None,
        }
    }

    /// The chord of a press of `key`, if nothing is bound to it.
    #[must_use]
    pub fn unbound(&self, key: Key) -> Option<Chord> {
        let chord = Chord::of_key(key, self.modifiers);
        let is_bound = self.modifiers.foreign || self.keymap.bound_to(chord).is_some();
        (!is_bound).then_some(chord)
    }

    /// A chord that does `action`.
    #[must_use]
    pub fn chord_of(&self, action: Action) -> Option<Chord> {
        self.keymap.chord_of(action)
    }

    /// A key goes up. It is known by its place: with Shift let go first it no longer types what it did.
    pub fn key_up(&mut self, id: KeyId) -> Option<Action> {
        let at = self.held.iter().position(|&(held, _)| held == id)?;
        let (_, axis) = self.held.remove(at);
        Some(Action::StopTurn(axis))
    }

    /// A mouse button goes down: a click or a drag may begin. A second button during a drag changes nothing.
    pub fn button_down(&mut self, button: Button, now: Duration) {
        let (None, Some(at)) = (self.press, self.cursor_px) else {
            return;
        };
        let chord = Chord {
            trigger: Trigger::Drag(button),
            modifiers: self.modifiers,
        };
        let grip = match self.keymap.bound_to(chord) {
            Some(Effect::Grip(grip)) => Some(grip),
            _ => None,
        };
        self.press = Some(Press {
            button,
            grip,
            modifiers: self.modifiers,
            since: now,
            at,
            dragging: false,
        });
    }

    /// A mouse button goes up.
    pub fn button_up(&mut self, button: Button, now: Duration) -> Option<Action> {
        let press = self.press.filter(|p| p.button == button)?;
        self.press = None;
        if press.dragging {
            return Some(Action::LetGo);
        }
        if button != Button::Left || now.saturating_sub(press.since) >= CLICK {
            return None;
        }
        let second = self.last_click.is_some_and(|(then, place)| {
            now.saturating_sub(then) < DOUBLE_CLICK && is_near(place, press.at)
        });
        let on = |trigger| {
            let modifiers = press.modifiers;
            match self.keymap.bound_to(Chord { trigger, modifiers }) {
                Some(Effect::At(Spot::Pick)) => Some(Action::Pick(press.at)),
                Some(Effect::At(Spot::Measure)) => Some(Action::Measure(press.at)),
                Some(Effect::At(Spot::Pivot)) => Some(Action::SetPivot(press.at)),
                _ => None,
            }
        };
        if second && let Some(action) = on(Trigger::DoubleClick) {
            self.last_click = None;
            return Some(action);
        }
        self.last_click = Some((now, press.at));
        on(Trigger::Click)
    }

    /// The cursor is at a place in the window, or, while it drags, outside of it.
    pub fn cursor_moved(&mut self, x_px: f64, y_px: f64, now: Duration) -> Option<Action> {
        let to = (x_px, y_px);
        let mut from = self.cursor_px.replace(to)?;
        let press = self.press.as_mut()?;
        let grip = press.grip?;
        if !press.dragging {
            // Up to here it could have been a click: the way so far counts from now on.
            let long = now.saturating_sub(press.since) >= CLICK;
            if !long && is_near(press.at, to) {
                return None;
            }
            press.dragging = true;
            from = press.at;
        }
        let (dx_px, dy_px) = (to.0 - from.0, to.1 - from.1);
        Some(match grip {
            Grip::Orbit => Action::Orbit {
                dx_px,
                dy_px,
                only: self.held.last().map(|&(_, axis)| axis),
            },
            Grip::Roll => Action::Roll { dx_px },
            Grip::Pan => Action::Pan { dx_px, dy_px },
            Grip::Dolly => Action::DollyDrag { dy_px, at: None },
            Grip::DollyAt => Action::DollyDrag {
                dy_px,
                at: Some(press.at),
            },
        })
    }

    /// The mouse did something on X11 that the window is told of next: a button of this number went down or up, or
    /// anything else. Where a pointer has no wheel of its own (xdotool, VNC), the buttons 4 to 7 stand for one, and
    /// winit 0.30 tells a notch as such a button goes down, and another one as it goes up.
    pub fn raw_button(&mut self, button: Option<u32>, is_down: bool) {
        self.wheel_let_go = matches!(button, Some(4..=7)) && !is_down;
    }

    /// The wheel turned by so many notches, away from the user counting up.
    pub fn wheel(&mut self, notches: f64) -> Option<Action> {
        if std::mem::take(&mut self.wheel_let_go) {
            return None;
        }
        let chord = Chord {
            trigger: Trigger::Wheel,
            modifiers: self.modifiers,
        };
        let at = match self.keymap.bound_to(chord)? {
            Effect::Grip(Grip::Dolly) => None,
            Effect::Grip(Grip::DollyAt) => self.cursor_px,
            _ => return None,
        };
        Some(Action::Dolly { notches, at })
    }

    /// Where the cursor was last.
    #[must_use]
    pub fn cursor_px(&self) -> Option<(f64, f64)> {
        self.cursor_px
    }

    /// The window lost the keyboard: releases go elsewhere from now on, so everything is let go.
    pub fn focus_lost(&mut self) -> Action {
        *self = Input {
            keymap: Arc::clone(&self.keymap),
            cursor_px: self.cursor_px,
            ..Input::default()
        };
        Action::StopTurns
    }
}

fn is_near(a: (f64, f64), b: (f64, f64)) -> bool {
    libm::hypot(a.0 - b.0, a.1 - b.1) < CLICK_PX
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHIFT: Modifiers = Modifiers {
        shift: true,
        ctrl: false,
        foreign: false,
    };
    const CTRL: Modifiers = Modifiers {
        shift: false,
        ctrl: true,
        foreign: false,
    };

    fn ms(ms: u64) -> Duration {
        Duration::from_millis(ms)
    }

    #[test]
    fn a_key_that_does_nothing_is_known() {
        let mut input = Input::default();
        let chord = |input: &Input, c| input.unbound(Key::Char(c)).map(|chord| chord.to_string());
        assert_eq!(chord(&input, 'u').as_deref(), Some("u"));
        assert_eq!(chord(&input, 'q'), None);
        input.set_modifiers(CTRL);
        assert_eq!(chord(&input, 'u').as_deref(), Some("Ctrl+u"));
        // The desktop's own.
        let foreign = true;
        input.set_modifiers(Modifiers { foreign, ..CTRL });
        assert_eq!(chord(&input, 'u'), None);
    }

    fn orbit(dx_px: f64, dy_px: f64) -> Option<Action> {
        let only = None;
        Some(Action::Orbit { dx_px, dy_px, only })
    }

    /// The cursor at (10, 10).
    fn input() -> Input {
        let mut input = Input::default();
        input.cursor_moved(10.0, 10.0, ms(0));
        input
    }

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
    fn a_held_key_repeats_steps_and_nothing_else() {
        let mut input = Input::default();
        let mut repeated = |key| input.key_down(1, key, true);
        let step = Some(Action::StepFrames(1));
        assert_eq!(repeated(Key::Char('.')), step);
        let back = true;
        assert_eq!(repeated(Key::Left), Some(Action::StepOperation { back }));
        for key in [Key::Space, Key::Tab, Key::Char('r'), Key::Char('q')] {
            assert_eq!(repeated(key), None, "{key:?}");
        }
        input.set_modifiers(CTRL);
        let mut repeated = |c| input.key_down(1, Key::Char(c), true);
        assert_eq!(repeated('z'), Some(Action::Undo));
        assert_eq!(repeated('='), Some(Action::Zoom(1)));
        assert_eq!(repeated('s'), None);
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
        let mut input = input();
        input.key_down(1, Key::Char('y'), false);
        input.button_down(Button::Left, ms(0));
        assert_eq!(input.focus_lost(), Action::StopTurns);
        assert_eq!(input.key_up(1), None);
        assert_eq!(input.cursor_moved(99.0, 9.0, ms(900)), None);
    }

    #[test]
    fn a_drag_keeps_its_meaning_until_its_button_goes_up() {
        let mut input = input();
        input.button_down(Button::Left, ms(0));
        input.set_modifiers(SHIFT);
        input.button_down(Button::Right, ms(1));
        assert_eq!(input.button_up(Button::Right, ms(2)), None);
        assert_eq!(input.cursor_moved(15.0, 9.0, ms(3)), orbit(5.0, -1.0));
        assert_eq!(input.cursor_moved(16.0, 9.0, ms(4)), orbit(1.0, 0.0));
        assert_eq!(input.button_up(Button::Left, ms(5)), Some(Action::LetGo));
        input.button_down(Button::Left, ms(6));
        let pan = Action::Pan {
            dx_px: 7.0,
            dy_px: 0.0,
        };
        assert_eq!(input.cursor_moved(23.0, 9.0, ms(7)), Some(pan));
    }

    #[test]
    fn a_short_press_that_stays_is_a_click_and_moves_nothing() {
        let mut input = input();
        input.button_down(Button::Left, ms(100));
        assert_eq!(input.cursor_moved(12.0, 12.0, ms(200)), None);
        let click = Some(Action::Pick((10.0, 10.0)));
        assert_eq!(input.button_up(Button::Left, ms(399)), click);
        input.button_down(Button::Left, ms(1000));
        assert_eq!(input.button_up(Button::Left, ms(1300)), None);
    }

    #[test]
    fn a_slow_press_is_a_drag_that_loses_no_pixel() {
        let mut input = input();
        input.button_down(Button::Left, ms(0));
        assert_eq!(input.cursor_moved(11.0, 10.0, ms(100)), None);
        assert_eq!(input.cursor_moved(12.0, 10.0, ms(301)), orbit(2.0, 0.0));
        assert_eq!(input.button_up(Button::Left, ms(310)), Some(Action::LetGo));
    }

    #[test]
    fn two_clicks_at_one_place_set_the_pivot_and_with_ctrl_they_measure() {
        let mut input = input();
        let mut click = |at: u64, modifiers| {
            input.set_modifiers(modifiers);
            input.button_down(Button::Left, ms(at));
            input.button_up(Button::Left, ms(at + 50))
        };
        let at = (10.0, 10.0);
        let none = Modifiers::default();
        assert_eq!(click(0, none), Some(Action::Pick(at)));
        assert_eq!(click(200, none), Some(Action::SetPivot(at)));
        assert_eq!(click(400, none), Some(Action::Pick(at)));
        assert_eq!(click(2000, none), Some(Action::Pick(at)));
        assert_eq!(click(2200, CTRL), Some(Action::Measure(at)));
        assert_eq!(click(3000, SHIFT), None);
    }

    #[test]
    fn an_axis_key_held_while_dragging_names_the_axis_and_starts_no_turn() {
        let mut input = input();
        input.key_down(1, Key::Char('x'), false);
        input.button_down(Button::Left, ms(0));
        let about = |only| {
            let (dx_px, dy_px) = (10.0, 0.0);
            Some(Action::Orbit { dx_px, dy_px, only })
        };
        assert_eq!(input.cursor_moved(20.0, 10.0, ms(1)), about(Some(Axis::X)));
        assert_eq!(input.key_down(2, Key::Char('z'), false), None);
        assert_eq!(input.cursor_moved(30.0, 10.0, ms(2)), about(Some(Axis::Z)));
        input.key_up(2);
        input.key_up(1);
        assert_eq!(input.cursor_moved(40.0, 10.0, ms(3)), about(None));
    }

    #[test]
    fn with_ctrl_the_wheel_and_the_right_button_dolly_towards_a_place() {
        let mut input = input();
        input.set_modifiers(CTRL);
        let at = Some((10.0, 10.0));
        let notches = -2.0;
        assert_eq!(input.wheel(notches), Some(Action::Dolly { notches, at }));
        input.button_down(Button::Right, ms(0));
        let dy_px = 20.0;
        let drag = Some(Action::DollyDrag { dy_px, at });
        assert_eq!(input.cursor_moved(10.0, 30.0, ms(1)), drag);
    }

    #[test]
    fn a_button_that_stands_for_a_notch_counts_once_and_a_wheel_of_its_own_every_time() {
        let mut input = input();
        let (notches, at) = (1.0, None);
        let dolly = Some(Action::Dolly { notches, at });
        for _ in 0..2 {
            input.raw_button(Some(4), true);
            assert_eq!(input.wheel(notches), dolly);
            input.raw_button(Some(4), false);
            assert_eq!(input.wheel(notches), None);
        }
        // The notch of this one was another window's.
        input.raw_button(Some(4), false);
        for _ in 0..2 {
            input.raw_button(None, false);
            assert_eq!(input.wheel(notches), dolly);
            assert_eq!(input.wheel(notches), dolly);
        }
        input.raw_button(Some(3), false);
        assert_eq!(input.wheel(notches), dolly);
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
