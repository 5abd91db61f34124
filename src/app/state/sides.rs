//! How the picture is made, and the split view: two engines or views side by side.

use super::{MODES, State, next};
use crate::app::action::Action;
use crate::app::side::Split;
use crate::render::{COST_SCALE, Engine, Settings, ViewMode};

const ENGINES: [Engine; 3] = [Engine::Fast, Engine::Brute, Engine::Report];
/// Logical pixels to each side of the divider in which a hand takes hold of it.
const HOLD_PX: f64 = 5.0;
/// The largest number of tests that the cost map shows white, and the smallest is 1.
const MAX_COST_SCALE: u32 = 1 << 20;

/// The split view, open or not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Halves {
    is_open: bool,
    /// Part of the picture's width that is left of the divider.
    divider: f64,
    /// By what the right side is made.
    engine: Engine,
    /// What it shows; `None`: the same as the left one.
    mode: Option<ViewMode>,
}

impl Default for Halves {
    /// Closed; the method of the original report is on the right.
    fn default() -> Halves {
        Halves {
            is_open: false,
            divider: 0.5,
            engine: Engine::Report,
            mode: None,
        }
    }
}

impl State {
    /// The right side of the picture, when it is split.
    pub(super) fn split(&self) -> Option<Split> {
        let halves = self.halves;
        halves.is_open.then(|| Split {
            settings: Settings {
                engine: halves.engine,
                mode: halves.mode.unwrap_or(self.settings.mode),
                ..self.settings
            },
            column: self.divider_px(),
        })
    }

    fn divider_px(&self) -> usize {
        // Between 0 and a window's width.
        (self.halves.divider * self.size_px.0 as f64).round() as usize
    }

    /// True where a hand takes hold of the divider.
    #[must_use]
    pub fn is_on_divider(&self, (x, _): (f64, f64)) -> bool {
        let distance = (x - self.divider_px() as f64).abs();
        self.halves.is_open && distance <= HOLD_PX * self.scale_factor.max(1.0)
    }

    /// The place of the divider for a hand in column `x`.
    #[must_use]
    pub fn divider_at(&self, x: f64) -> f64 {
        (x / self.size_px.0 as f64).clamp(0.0, 1.0)
    }

    pub(super) fn toggle_split(&mut self) {
        self.halves.is_open = !self.halves.is_open;
    }

    pub(super) fn set_divider(&mut self, part: f64) {
        self.halves.divider = part.clamp(0.0, 1.0);
    }

    pub(super) fn next_engine(&mut self) {
        self.settings.engine = next(&ENGINES, self.settings.engine);
        self.say(format!("engine: {}", word(self.settings.engine)));
    }

    /// The picture stays the same to the bit: only words tell that something happened.
    pub(super) fn next_kernel(&mut self) {
        self.settings.kernel = next(&self.setting.kernels, self.settings.kernel);
        self.say(format!("kernel: {}", self.settings.kernel.name()));
    }

    /// Choosing for the right side opens the split view.
    pub(super) fn next_right_engine(&mut self) {
        if std::mem::replace(&mut self.halves.is_open, true) {
            self.halves.engine = next(&ENGINES, self.halves.engine);
        }
    }

    pub(super) fn next_right_view(&mut self) {
        let shown = self.halves.mode.unwrap_or(self.settings.mode);
        self.show_right_view(next(&MODES, shown));
    }

    pub(super) fn show_right_view(&mut self, mode: ViewMode) {
        self.halves.is_open = true;
        self.halves.mode = Some(mode);
    }

    pub(super) fn scale_cost(&mut self, factor: f64) {
        let scaled = f64::from(self.settings.cost_scale) * factor;
        // Kept in the range of the type.
        self.settings.cost_scale = scaled.clamp(1.0, f64::from(MAX_COST_SCALE)) as u32;
        let usual = match self.settings.cost_scale {
            COST_SCALE => " (as usual)",
            _ => "",
        };
        let scale = self.settings.cost_scale;
        let view = Action::ShowView(ViewMode::Cost);
        let unseen = match self.keymap.chord_of(view) {
            Some(chord) if !self.wish().shows_cost() => format!("; {chord} shows the view"),
            _ => String::new(),
        };
        self.say(format!("cost: {scale} tests are white{usual}{unseen}"));
    }
}

/// What an engine or view is called.
pub fn word(value: impl std::fmt::Debug) -> String {
    format!("{value:?}").to_lowercase()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::action::Action;
    use crate::app::state::Setting;
    use crate::camera::{Camera, Pivot};
    use crate::geometry::Aabb;
    use crate::scene::CameraSetting;
    use crate::timeline::Timing;

    fn state() -> State {
        let base = Camera::default_for(Aabb::EMPTY);
        let setting = Setting {
            camera: CameraSetting::Default,
            base,
            operations: Vec::new(),
            timing: Timing::STEPS,
            pivot: Pivot::Origin.point(Aabb::EMPTY),
            bounds: Aabb::EMPTY,
            stretch: false,
            overlay: true,
            print_picks: false,
            kernels: Vec::new(),
        };
        State::new(setting, Settings::default(), (100, 50))
    }

    #[test]
    fn the_split_opens_with_the_report_on_the_right_half_and_closes_without_a_trace() {
        let mut s = state();
        let whole = s.wish();
        s.apply(Action::ToggleSplit);
        let split = s.wish().split.expect("it is open");
        assert_eq!((split.column, split.settings.engine), (50, Engine::Report));
        assert_eq!(split.settings.mode, ViewMode::Shaded);
        s.apply(Action::ShowView(ViewMode::Id));
        let split = s.wish().split.expect("it is open");
        assert_eq!(split.settings.mode, ViewMode::Id, "as on the left");
        s.apply(Action::ShowView(ViewMode::Shaded));
        s.apply(Action::ToggleSplit);
        assert_eq!(s.wish(), whole);
    }

    #[test]
    fn the_right_side_has_an_engine_and_a_view_of_its_own() {
        let mut s = state();
        let right = |s: &State| {
            let split = s.wish().split.expect("it is open");
            (split.settings.engine, split.settings.mode)
        };
        s.apply(Action::NextRightEngine);
        assert_eq!(right(&s), (Engine::Report, ViewMode::Shaded));
        s.apply(Action::NextRightEngine);
        s.apply(Action::NextRightView);
        s.apply(Action::NextEngine);
        assert_eq!(right(&s), (Engine::Fast, ViewMode::Id));
        assert_eq!(s.wish().settings.engine, Engine::Brute);
        assert_eq!(s.wish().settings.mode, ViewMode::Shaded);
        s.apply(Action::ShowRightView(ViewMode::Cost));
        assert!(s.wish().shows_cost());
    }

    #[test]
    fn the_divider_is_where_the_hand_puts_it_and_keeps_its_part_of_the_width() {
        let mut s = state();
        assert!(!s.is_on_divider((50.0, 1.0)), "it is closed");
        s.apply(Action::ToggleSplit);
        assert!(s.is_on_divider((45.0, 1.0)) && !s.is_on_divider((44.0, 1.0)));
        s.apply(Action::SetDivider(s.divider_at(20.0)));
        s.resize(200, 50);
        assert_eq!(s.wish().split.expect("it is open").column, 40);
        s.apply(Action::SetDivider(s.divider_at(-9.0)));
        assert_eq!(s.wish().split.expect("it is open").column, 0);
    }

    #[test]
    fn the_cost_map_is_scaled_within_limits_and_back() {
        let mut s = state();
        let before = s.wish();
        for factor in [2.0, 0.5] {
            s.apply(Action::ScaleCost(factor));
        }
        assert_eq!(s.wish(), before);
        for _ in 0..40 {
            s.apply(Action::ScaleCost(0.5));
        }
        assert_eq!(s.wish().settings.cost_scale, 1);
        for _ in 0..40 {
            s.apply(Action::ScaleCost(2.0));
        }
        assert_eq!(s.wish().settings.cost_scale, MAX_COST_SCALE);
    }

    #[test]
    fn scaling_the_cost_map_that_is_not_shown_tells_how_to_see_it() {
        let mut s = state();
        let scaled = |s: &mut State| {
            s.apply(Action::ScaleCost(0.5));
            s.overlay().message.expect("a message")
        };
        let said = "cost: 512 tests are white; F5 shows the view";
        assert_eq!(scaled(&mut s), said);
        s.apply(Action::ShowView(ViewMode::Cost));
        assert_eq!(scaled(&mut s), "cost: 256 tests are white");
    }
}
