//! winit's keys, buttons and wheels in the viewer's own words.

use std::ops::RangeInclusive;

use winit::event::{KeyEvent, MouseButton, MouseScrollDelta};
use winit::keyboard::{
    Key as WinitKey, KeyCode, ModifiersState, NamedKey, NativeKeyCode, PhysicalKey,
};

use super::bindings::{Button, Key, Modifiers};
use super::input::KeyId;

/// Pixels of a touchpad, at scale factor 1, that are worth a notch of a wheel.
const PX_PER_NOTCH: f64 = 40.0;

/// What the key types. On a layout whose letters are not ASCII: what it would type on a US one.
#[must_use]
pub fn key_of(event: &KeyEvent) -> Option<Key> {
    if let Some(digit) = keypad_digit(event.physical_key) {
        return Some(Key::Char(digit));
    }
    match event.logical_key.as_ref() {
        WinitKey::Named(NamedKey::Space) | WinitKey::Character(" ") => Some(Key::Space),
        WinitKey::Named(NamedKey::Enter) => Some(Key::Enter),
        WinitKey::Named(NamedKey::Escape) => Some(Key::Escape),
        WinitKey::Named(NamedKey::ArrowLeft) => Some(Key::Left),
        WinitKey::Named(NamedKey::ArrowRight) => Some(Key::Right),
        WinitKey::Named(NamedKey::Home) => Some(Key::Home),
        WinitKey::Named(NamedKey::End) => Some(Key::End),
        WinitKey::Named(NamedKey::Backspace) => Some(Key::Backspace),
        WinitKey::Named(NamedKey::PageUp) => Some(Key::PageUp),
        WinitKey::Named(NamedKey::PageDown) => Some(Key::PageDown),
        WinitKey::Named(NamedKey::Tab) => Some(Key::Tab),
        WinitKey::Named(NamedKey::F1) => Some(Key::F(1)),
        WinitKey::Named(NamedKey::F2) => Some(Key::F(2)),
        WinitKey::Named(NamedKey::F3) => Some(Key::F(3)),
        WinitKey::Named(NamedKey::F4) => Some(Key::F(4)),
        WinitKey::Named(NamedKey::F5) => Some(Key::F(5)),
        WinitKey::Named(NamedKey::F6) => Some(Key::F(6)),
        WinitKey::Named(NamedKey::F7) => Some(Key::F(7)),
        WinitKey::Named(NamedKey::F8) => Some(Key::F(8)),
        WinitKey::Named(NamedKey::F9) => Some(Key::F(9)),
        WinitKey::Named(NamedKey::F10) => Some(Key::F(10)),
        WinitKey::Named(NamedKey::F11) => Some(Key::F(11)),
        WinitKey::Named(NamedKey::F12) => Some(Key::F(12)),
        WinitKey::Character(text) => {
            let c = text.chars().next()?.to_lowercase().next()?;
            let c = if c.is_ascii() {
                c
            } else {
                latin(event.physical_key).unwrap_or(c)
            };
            Some(Key::Char(c))
        }
        _ => None,
    }
}

/// The letter that stands on the key on a US keyboard.
fn latin(key: PhysicalKey) -> Option<char> {
    nth(key, KeyCode::KeyA, b'a'..=b'z')
}

/// The digit on a key of the keypad, NumLock or not: views are chosen there, and without NumLock 9 is PageUp.
fn keypad_digit(key: PhysicalKey) -> Option<char> {
    nth(key, KeyCode::Numpad0, b'0'..=b'9')
}

/// The sign of a key of those that follow `first` in winit's list in the order of `signs`.
fn nth(key: PhysicalKey, first: KeyCode, mut signs: RangeInclusive<u8>) -> Option<char> {
    let PhysicalKey::Code(code) = key else {
        return None;
    };
    let at = (code as u32).checked_sub(first as u32)?;
    signs.nth(usize::try_from(at).ok()?).map(char::from)
}

/// Tells physical keys apart.
#[must_use]
pub fn key_id(event: &KeyEvent) -> KeyId {
    const UNNAMED: KeyId = 1 << 31;
    match event.physical_key {
        PhysicalKey::Code(code) => code as KeyId,
        PhysicalKey::Unidentified(NativeKeyCode::Xkb(code)) => UNNAMED | code,
        PhysicalKey::Unidentified(_) => UNNAMED,
    }
}

/// The modifiers that are down.
#[must_use]
pub fn modifiers_of(state: ModifiersState) -> Modifiers {
    Modifiers {
        shift: state.shift_key(),
        ctrl: state.control_key(),
        foreign: state.alt_key() || state.super_key(),
    }
}

/// The button, if the viewer knows it.
#[must_use]
pub fn button_of(button: MouseButton) -> Option<Button> {
    match button {
        MouseButton::Left => Some(Button::Left),
        MouseButton::Middle => Some(Button::Middle),
        MouseButton::Right => Some(Button::Right),
        _ => None,
    }
}

/// Notches of the wheel, away from the user counting up.
#[must_use]
pub fn notches_of(delta: MouseScrollDelta, scale_factor: f64) -> f64 {
    match delta {
        MouseScrollDelta::LineDelta(_, lines) => f64::from(lines),
        MouseScrollDelta::PixelDelta(px) => px.y / (PX_PER_NOTCH * scale_factor),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_follow_one_another_in_winits_list() {
        for (code, letter) in [
            (KeyCode::KeyA, 'a'),
            (KeyCode::KeyI, 'i'),
            (KeyCode::KeyX, 'x'),
            (KeyCode::KeyZ, 'z'),
        ] {
            assert_eq!(latin(PhysicalKey::Code(code)), Some(letter));
        }
        for code in [KeyCode::Digit9, KeyCode::Equal, KeyCode::Minus] {
            assert_eq!(latin(PhysicalKey::Code(code)), None);
        }
    }

    #[test]
    fn digits_of_the_keypad_follow_one_another_in_winits_list() {
        for (code, digit) in [
            (KeyCode::Numpad0, Some('0')),
            (KeyCode::Numpad1, Some('1')),
            (KeyCode::Numpad7, Some('7')),
            (KeyCode::Numpad9, Some('9')),
            (KeyCode::NumLock, None),
            (KeyCode::NumpadAdd, None),
            (KeyCode::Digit9, None),
            (KeyCode::PageUp, None),
        ] {
            assert_eq!(keypad_digit(PhysicalKey::Code(code)), digit, "{code:?}");
        }
    }
}
