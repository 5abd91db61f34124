//! The hand on the camera: turns, drags, wheel, views, and what becomes of them in the list of moves.
//!
//! A turn about the format's pivot is a turn of the list; anything else moves the base camera.

use std::time::Duration;

use glam::{DQuat, DVec3};

use super::{State, Turning};
use crate::app::action::{Action, Side};
use crate::app::orbit::{self, OrbitStyle};
use crate::app::overlay::RECORDING;
use crate::camera::Pivot;
use crate::scene::Axis;

/// The turn of a tapped axis key, at once: 5 degrees.
pub(super) const TAP_MICRO_RAD: f64 = 87_266.0;
/// A key held longer than this turns on; a tap is shorter.
const TAP: Duration = Duration::from_millis(250);
/// A held key turns in steps of this length, counted from time 0: how often time is looked at does not matter.
const TICK: Duration = Duration::from_millis(4);
/// By so much each: a quarter turn in a second and a half.
pub(super) const TICK_MICRO_RAD: f64 = 4_189.0;
/// Notches of the wheel that a drag over the whole window is worth.
const DOLLY_NOTCHES_PER_HEIGHT: f64 = 40.0;

impl State {
    pub(super) fn start_turn(&mut self, axis: Axis, reverse: bool) {
        self.turning.retain(|t| t.axis != axis);
        self.turning.push(Turning {
            axis,
            reverse,
            on_from: self.now + TAP,
        });
        self.before_move();
        self.turn_about(axis, signed(TAP_MICRO_RAD, reverse), true);
        self.after_move();
    }

    pub(super) fn stop_turn(&mut self, axis: Axis) {
        self.turning.retain(|t| t.axis != axis);
        self.end_if_idle();
    }

    /// Turns by what the held keys are worth between `before` and now.
    pub(super) fn turn_on(&mut self, before: Duration) {
        let ticks = |t: Duration| t.as_nanos() / TICK.as_nanos();
        let first = self
            .turning
            .iter()
            .map(|t| ticks(before.max(t.on_from)))
            .min();
        let Some(first) = first.filter(|first| *first < ticks(self.now)) else {
            return;
        };
        self.before_move();
        let turning = self.turning.clone();
        for tick in first..ticks(self.now) {
            let due = |t: &&Turning| ticks(t.on_from) <= tick;
            let alone = turning.iter().filter(due).count() == 1;
            for t in turning.iter().filter(due) {
                self.turn_about(t.axis, signed(TICK_MICRO_RAD, t.reverse), alone);
            }
        }
        self.after_move();
    }

    pub(super) fn orbit(&mut self, dx_px: f64, dy_px: f64, only: Option<Axis>) {
        self.take_back_key(only);
        let (camera, height) = (self.camera(), self.height_px());
        match only {
            None => {
                let turn = orbit::orbit(&camera, self.style(), dx_px, dy_px, height);
                self.turn_about_pivot(orbit::rotation_of(turn));
            }
            Some(axis) => {
                let angle_rad = orbit::orbit_about(&camera, axis, dx_px, dy_px, height);
                self.before_move();
                self.turn_about(axis, angle_rad * 1e6, true);
                self.after_move();
            }
        }
        self.dragging = true;
    }

    pub(super) fn roll(&mut self, dx_px: f64) {
        let turn = orbit::roll(&self.camera(), dx_px, self.height_px());
        self.turn_about_pivot(orbit::rotation_of(turn));
        self.dragging = true;
    }

    pub(super) fn pan(&mut self, dx_px: f64, dy_px: f64) {
        let view = self.view();
        let step = view.dx * dx_px + view.dy * dy_px;
        self.shift(orbit::pan(&self.camera(), self.pivot_point(), step));
        self.dragging = true;
    }

    pub(super) fn dolly_drag(&mut self, dy_px: f64, at: Option<(f64, f64)>) {
        let notches = -dy_px / self.height_px() * DOLLY_NOTCHES_PER_HEIGHT;
        self.dolly(notches, at);
        self.dragging = true;
    }

    pub(super) fn dolly(&mut self, notches: f64, at: Option<(f64, f64)>) {
        let (camera, pivot) = (self.camera(), self.pivot_point());
        let shift = match at {
            None => orbit::dolly(&camera, pivot, notches),
            Some(at) => orbit::dolly_towards(&camera, &self.view(), at, pivot, notches),
        };
        self.shift(shift);
        self.end_if_idle();
    }

    pub(super) fn look(&mut self, from: Side, opposite: bool) {
        let [right, up, front] = orbit::sides(&self.setting.base);
        let (direction, up) = match from {
            Side::Front => (front, up),
            Side::Right => (right, up),
            Side::Top => (up, -front),
            Side::Corner => (right + up + front, up),
        };
        let direction = if opposite { -direction } else { direction };
        self.let_go_of_all();
        self.take_pivot_in_scene();
        self.turn_about_pivot(orbit::facing(&self.camera(), direction, up));
        self.end_if_idle();
    }

    pub(super) fn fit(&mut self) {
        self.let_go_of_all();
        self.take_pivot_in_scene();
        match orbit::fit(&self.camera(), &self.view(), self.setting.bounds) {
            Some(shift) => self.shift(shift),
            None => self.say("there is nothing to fit into the window".to_owned()),
        }
        self.end_if_idle();
    }

    /// A turn about a point outside of the scene would turn the scene out of the picture.
    fn take_pivot_in_scene(&mut self) {
        let bounds = self.setting.bounds;
        let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
        let pivot = self.setting.pivot;
        let is_inside = pivot.cmpge(min).all() && pivot.cmple(max).all();
        if self.pivot.is_none() && !is_inside && !bounds.is_empty() {
            self.pivot = Some(Pivot::Centre.point(bounds));
            self.say("the scene lies beside the pivot: orbit about its centre".to_owned());
        }
    }

    pub(super) fn let_go(&mut self) {
        self.dragging = false;
        self.end_if_idle();
    }

    pub(super) fn let_go_of_all(&mut self) {
        self.turning.clear();
        self.let_go();
    }

    pub(super) fn toggle_turntable(&mut self) {
        self.turntable = !self.turntable;
        let style = match self.style() {
            OrbitStyle::Trackball => "trackball".to_owned(),
            OrbitStyle::Turntable(axis) => format!("turntable about {axis:?}").to_lowercase(),
        };
        self.say(style);
    }

    /// Without what the hand did. In the middle of the film, only without what lies on top: it goes on from its frame.
    pub(super) fn return_to_scene(&mut self) {
        self.let_go_of_all();
        if !self.playback.is_at_end() {
            if !self.moves.drop_on_top() {
                self.say("nothing lies on top of the film".to_owned());
            }
            return;
        }
        if self.moves.recorded().len() > 0 {
            let undo = self.keymap.chord_of(Action::Undo);
            let undo = undo.map_or("undo".to_owned(), |chord| chord.to_string());
            self.say(format!(
                "back to the scene: {undo} brings the recorded moves back"
            ));
        }
        self.moves.drop_all();
        self.after_move();
    }

    pub(super) fn toggle_recording(&mut self) {
        self.let_go_of_all();
        self.recording = !self.recording;
        if self.recording {
            // New operations follow the last one: that is where they are seen.
            self.playback.stop();
            self.moves.record();
            self.after_move();
        }
        let on = if self.recording { "on" } else { "off" };
        self.say(format!("recording {on}"));
    }

    pub(super) fn undo(&mut self) {
        self.let_go_of_all();
        if !self.moves.undo_move() {
            self.say("nothing to undo".to_owned());
        }
        self.after_move();
    }

    pub(super) fn redo(&mut self) {
        self.let_go_of_all();
        if !self.moves.redo_move() {
            self.say("nothing to redo".to_owned());
        }
        self.after_move();
    }

    fn style(&self) -> OrbitStyle {
        if self.turntable {
            OrbitStyle::Turntable(orbit::spindle(&self.setting.base))
        } else {
            OrbitStyle::Trackball
        }
    }

    fn height_px(&self) -> f64 {
        // At most 16384 or so.
        self.size_px.1 as f64
    }

    pub(super) fn pivot_point(&self) -> DVec3 {
        self.pivot.unwrap_or(self.setting.pivot)
    }

    /// A key that names the axis of a drag was no turn: what it turned is taken back.
    fn take_back_key(&mut self, only: Option<Axis>) {
        if !self.dragging && self.turning.iter().any(|t| Some(t.axis) == only) {
            self.turning.clear();
            self.moves.take_back();
        }
    }

    /// Turns along a world axis through the pivot; not `alone`: about others at the same time.
    fn turn_about(&mut self, axis: Axis, micro_rad: f64, alone: bool) {
        match self.pivot {
            Some(pivot) => {
                let turn = orbit::rotation_of(orbit::direction(axis) * (micro_rad / 1e6));
                self.bake(|p| turn * (p - pivot) + pivot);
            }
            None if alone => self.moves.turn(axis, micro_rad),
            None => self.moves.turn_among_others(axis, micro_rad),
        }
    }

    fn turn_about_pivot(&mut self, rotation: DQuat) {
        self.before_move();
        match self.pivot {
            None => self.moves.turn_freely(rotation),
            Some(pivot) => self.bake(|p| rotation * (p - pivot) + pivot),
        }
        self.after_move();
    }

    fn shift(&mut self, by: DVec3) {
        self.before_move();
        self.bake(|p| p + by);
        self.after_move();
    }

    fn bake(&mut self, motion: impl Fn(DVec3) -> DVec3) {
        let (turn, setting) = (self.turn(), &self.setting);
        if !self.moves.bake(setting.base, turn, setting.pivot, motion) {
            self.say("no scene file could hold that camera".to_owned());
        }
    }

    fn before_move(&mut self) {
        self.moves.set_recording(self.moves_are_recorded());
    }

    /// New operations follow the last frame: on others moves lie on top.
    fn moves_are_recorded(&self) -> bool {
        self.recording && self.playback.is_at_end()
    }

    pub(super) fn recording_in_words(&self) -> Option<String> {
        if self.moves_are_recorded() {
            return Some(RECORDING.to_owned());
        }
        let end = self.keymap.chord_of(Action::GoToEnd);
        let end = end.map_or("the last frame".to_owned(), |chord| chord.to_string());
        self.recording.then(|| format!("recording waits: {end}"))
    }

    /// Brings the film in line with what is recorded.
    pub(super) fn after_move(&mut self) {
        self.film.truncate(self.setting.operations.len());
        self.film.extend(self.moves.recorded());
        self.playback
            .set_last(self.setting.timing.last_frame(&self.film));
    }

    fn end_if_idle(&mut self) {
        if !self.dragging && self.turning.is_empty() {
            self.moves.end();
        }
    }
}

fn signed(size: f64, reverse: bool) -> f64 {
    if reverse { -size } else { size }
}
