//! What the hand did to the camera, as it would be saved: turns about the format's pivot, and a base camera.
//!
//! A turn is an axis and a whole number of millionths of a radian; turns about one axis in a row are one. What
//! no turn can say (pans, dollies, turns about another point) moves the base camera, which is rounded to the
//! `f32` of an `<s` camera before anything is composed from it. So the camera shown is the saved file's, to the
//! bit. Unrounded numbers are kept for the moves to come: nothing drifts.
//!
//! The first turns may be *recorded*: they belong to the film, after the scene's own operations. The rest lies
//! on top of whatever frame is shown.

mod text;

use glam::{DMat3, DQuat, DVec3};

use crate::camera::Camera;
use crate::math::rotation;
use crate::scene::{self, Axis, CameraCorners, Operation};

pub use text::{camera_of, camera_word};

/// A turn about a world axis through the format's pivot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Turn {
    /// Which.
    pub axis: Axis,
    /// Right-handed, in millionths of a radian.
    pub micro_rad: i64,
}

impl Turn {
    /// The same as a scene file says it: the nearest `f64` to the decimal.
    #[must_use]
    pub fn operation(self) -> Operation {
        Operation {
            axis: self.axis,
            // Angles stay far below 2^53 millionths.
            angle_rad: self.micro_rad as f64 / 1e6,
        }
    }
}

/// Everything that undo brings back.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct List {
    turns: Vec<Turn>,
    /// Before rounding; `None`: the scene's.
    base: Option<Camera>,
    /// So many of the turns, and that base, are recorded.
    recorded: (usize, Option<Camera>),
}

impl List {
    /// The recorded part, as a file says it.
    fn recorded_part(&self) -> (&[Turn], Option<CameraCorners>) {
        let (turns, base) = self.recorded;
        (&self.turns[..turns], base.map(rounded))
    }

    /// True when both are the same moves, whatever of them is recorded.
    fn has_moves_of(&self, other: &List) -> bool {
        (&self.turns, self.base) == (&other.turns, other.base)
    }

    /// Leaves the recorded part. False when there is nothing else.
    fn drop_on_top(&mut self) -> bool {
        let (turns, base) = self.recorded;
        let any = self.turns.len() > turns || self.base != base;
        self.turns.truncate(turns);
        self.base = base;
        any
    }

    /// Adds a turn, merged with the one before when that is about the same axis and not below `floor`.
    fn push(&mut self, floor: usize, turn: Turn) {
        if turn.micro_rad == 0 {
            return;
        }
        if self.turns.len() > floor
            && let Some(top) = self.turns.last_mut()
            && top.axis == turn.axis
        {
            top.micro_rad = top.micro_rad.saturating_add(turn.micro_rad);
            if top.micro_rad == 0 {
                self.turns.pop();
            }
            return;
        }
        self.turns.push(turn);
    }
}

/// A list without the turns at its beginning that it shares with another.
#[derive(Clone, Debug)]
struct Ending {
    tail: Vec<Turn>,
    base: Option<Camera>,
    recorded: (usize, Option<Camera>),
}

impl Ending {
    fn of(list: &List, shared: usize) -> Ending {
        Ending {
            tail: list.turns[shared..].to_vec(),
            base: list.base,
            recorded: list.recorded,
        }
    }
}

/// One press, drag or notch: undone at once.
#[derive(Clone, Debug)]
struct Step {
    shared: usize,
    before: Ending,
    after: Ending,
}

impl Step {
    /// False when it only makes recorded moves of those that were there.
    fn moves(&self) -> bool {
        (&self.before.tail, self.before.base) != (&self.after.tail, self.after.base)
    }

    /// What leads from one list to the other; `None` when they are the same.
    fn between(before: &List, after: &List) -> Option<Step> {
        if before == after {
            return None;
        }
        let both = before.turns.iter().zip(&after.turns);
        let shared = both.take_while(|(a, b)| a == b).count();
        Some(Step {
            shared,
            before: Ending::of(before, shared),
            after: Ending::of(after, shared),
        })
    }
}

/// A part of a gesture that becomes turns as a whole.
#[derive(Clone, Copy, Debug)]
enum Part {
    /// About one world axis, by so many millionths of a radian, whole or not.
    Axis(Axis, f64),
    /// Any way round.
    Free(DQuat),
}

impl Part {
    fn turns(self) -> Vec<Turn> {
        match self {
            // A hand does not turn that often.
            Part::Axis(axis, micro) => vec![Turn {
                axis,
                micro_rad: micro.round() as i64,
            }],
            Part::Free(rotation) => turns_of(DMat3::from_quat(rotation)).to_vec(),
        }
    }
}

/// The turns about x, then y, then z that a rotation is made of, each to the nearest millionth.
fn turns_of(m: DMat3) -> [Turn; 3] {
    let sin_y = -m.x_axis.z;
    let cos_y = libm::hypot(m.x_axis.x, m.x_axis.y);
    let y = libm::atan2(sin_y, cos_y);
    let (x, z) = if cos_y > 1e-9 {
        (
            libm::atan2(m.y_axis.z, m.z_axis.z),
            libm::atan2(m.x_axis.y, m.x_axis.x),
        )
    } else {
        // x and z turn about the same line: x takes it all.
        (libm::atan2(-m.z_axis.y, m.y_axis.y), 0.0)
    };
    let turn = |axis, angle_rad: f64| Turn {
        axis,
        micro_rad: (angle_rad * 1e6).round() as i64,
    };
    [turn(Axis::X, x), turn(Axis::Y, y), turn(Axis::Z, z)]
}

/// What the hand is doing right now: one step of undo.
#[derive(Clone, Debug)]
struct Gesture {
    before: List,
    parts: Vec<Part>,
    /// It goes to the film.
    recorded: bool,
}

/// The list, what it was, and what it may be again.
#[derive(Clone, Debug, Default)]
pub struct Moves {
    list: List,
    gesture: Option<Gesture>,
    past: Vec<Step>,
    future: Vec<Step>,
    /// Gestures that begin now are recorded.
    recording: bool,
    saved: Written,
    /// Counts the changes that are done.
    revision: u64,
}

/// A list as it went to a file: the file's last operations are its turns, and its base is the file's camera.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Written {
    list: List,
    /// Without what lay on top of the film.
    is_part: bool,
    /// When it went there.
    revision: u64,
}

impl Written {
    /// What a file has, read again: the list that it was made of had no other turns.
    #[must_use]
    pub fn of_file(operations: &[Operation], base: Option<Camera>) -> Written {
        let turn = |op: &Operation| Turn {
            axis: op.axis,
            // Angles stay far below 2^53 millionths.
            micro_rad: (op.angle_rad * 1e6).round() as i64,
        };
        let list = List {
            turns: operations.iter().map(turn).collect(),
            base,
            recorded: (operations.len(), base),
        };
        // None that a list reaches.
        let revision = u64::MAX;
        Written {
            list,
            is_part: false,
            revision,
        }
    }

    /// True when something lay on top of the film, and was left out.
    #[must_use]
    pub fn is_part(&self) -> bool {
        self.is_part
    }

    /// The file's last operations.
    pub fn operations(&self) -> impl ExactSizeIterator<Item = Operation> {
        self.list.turns.iter().map(|t| t.operation())
    }

    /// The file's camera; `None`: the one that it had before.
    #[must_use]
    pub fn base_corners(&self) -> Option<CameraCorners> {
        self.list.base.map(rounded)
    }
}

impl Moves {
    /// The camera before any operation: `scene`'s, or what pans made of it, as a file would say it.
    #[must_use]
    pub fn base(&self, scene: Camera) -> Camera {
        self.list
            .base
            .map_or(scene, |exact| Camera::from(rounded(exact)))
    }

    /// The base camera to be saved; `None`: the scene's own.
    #[must_use]
    pub fn base_corners(&self) -> Option<CameraCorners> {
        self.list.base.map(rounded)
    }

    /// The turns that belong to the film.
    pub fn recorded(&self) -> impl ExactSizeIterator<Item = Operation> {
        let (turns, _) = self.list.recorded;
        self.list.turns[..turns].iter().map(|t| t.operation())
    }

    /// The turns on top of the frame.
    pub fn on_top(&self) -> impl ExactSizeIterator<Item = Operation> {
        let (turns, _) = self.list.recorded;
        self.list.turns[turns..].iter().map(|t| t.operation())
    }

    /// True when something is recorded that no file has.
    #[must_use]
    pub fn is_unsaved(&self) -> bool {
        self.list.recorded_part() != self.saved.list.recorded_part()
    }

    /// Another number after each step, one that is undone or done again too.
    #[must_use]
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// True when nothing was done since the last save, or ever.
    #[must_use]
    pub fn is_as_saved(&self) -> bool {
        let is_same = self.list.has_moves_of(&self.saved.list);
        (is_same || self.revision == self.saved.revision) && !self.saved.is_part
    }

    /// True when nothing is left of what the hand did.
    #[must_use]
    pub fn is_untouched(&self) -> bool {
        self.list == List::default()
    }

    /// Everything that the hand did, as it stands.
    #[must_use]
    pub fn list(&self) -> &List {
        &self.list
    }

    /// The hand did this, in one step.
    pub fn take_over(&mut self, list: List) {
        self.end();
        self.gesture();
        self.list = list;
        self.end();
    }

    /// What goes to a file: all, or without what lies on top.
    #[must_use]
    pub fn to_write(&self, with_top: bool) -> Written {
        let mut list = self.list.clone();
        if !with_top {
            list.drop_on_top();
        }
        Written {
            is_part: list != self.list,
            list,
            revision: self.revision,
        }
    }

    /// That is in a file now.
    pub fn mark_saved(&mut self, saved: Written) {
        self.saved = saved;
    }

    /// What the file has of the hand's moves.
    #[must_use]
    pub fn saved(&self) -> &Written {
        &self.saved
    }

    /// True when the file has any.
    #[must_use]
    pub fn is_any_saved(&self) -> bool {
        self.saved.list != List::default()
    }

    /// The file keeps what was saved, whatever became of that: what the hand did since is one step on top of it.
    pub fn leave_saved(&mut self) {
        self.end();
        let (saved, now) = (&self.saved.list, &self.list);
        let both = saved.turns.iter().zip(&now.turns);
        let shared = both.take_while(|(a, b)| a == b).count();
        let mut turns = now.turns[shared..].to_vec();
        // A turn about the axis of the last one that was saved was merged into it.
        if let ([last], Some(first)) = (&saved.turns[shared..], turns.first_mut())
            && last.axis == first.axis
        {
            first.micro_rad -= last.micro_rad;
        }
        let since = |base| if base == saved.base { None } else { base };
        let (recorded, base) = now.recorded;
        let rest = List {
            turns,
            base: since(now.base),
            recorded: (recorded.saturating_sub(shared), since(base)),
        };
        *self = Moves {
            revision: self.revision + 1,
            ..Moves::default()
        };
        self.take_over(rest);
    }

    /// Whether gestures that begin from now on go to the film, with all that lies on top.
    pub fn set_recording(&mut self, recording: bool) {
        self.recording = recording;
    }

    /// Turns about a world axis by so many millionths of a radian.
    pub fn turn(&mut self, axis: Axis, micro_rad: f64) {
        let gesture = self.gesture();
        match gesture.parts.last_mut() {
            Some(Part::Axis(last, micro)) if *last == axis => *micro += micro_rad,
            _ => gesture.parts.push(Part::Axis(axis, micro_rad)),
        }
        self.compose();
    }

    /// Turns any way round.
    pub fn turn_freely(&mut self, turn: DQuat) {
        let gesture = self.gesture();
        match gesture.parts.last_mut() {
            Some(Part::Free(so_far)) => *so_far = (turn * *so_far).normalize(),
            _ => gesture.parts.push(Part::Free(turn)),
        }
        self.compose();
    }

    /// Turns about the axis as [`Moves::turn_freely`]: several axes turn at once.
    pub fn turn_among_others(&mut self, axis: Axis, micro_rad: f64) {
        let turn = DQuat::from_mat3(&rotation(axis, micro_rad / 1e6));
        self.turn_freely(turn.normalize());
    }

    /// Takes back the gesture so far.
    pub fn take_back(&mut self) {
        if let Some(gesture) = &mut self.gesture {
            gesture.parts.clear();
            self.list.base = gesture.before.base;
            self.compose();
        }
    }

    /// Moves the camera shown by `motion`, where `turn` about `pivot` is all that follows the base camera. False,
    /// and nothing done, when the moved camera could not be saved.
    pub fn bake(
        &mut self,
        scene: Camera,
        turn: DMat3,
        pivot: DVec3,
        motion: impl Fn(DVec3) -> DVec3,
    ) -> bool {
        let exact = self.list.base.unwrap_or(scene);
        // A rotation's inverse is its transpose.
        let base = exact
            .turned(turn, pivot)
            .map(motion)
            .turned(turn.transpose(), pivot);
        let good = can_be_saved(&rounded(base));
        if good {
            let recorded = self.gesture().recorded;
            self.list.base = Some(base);
            if recorded {
                self.list.recorded = (self.list.turns.len(), self.list.base);
            }
        }
        good
    }

    /// Drops every move, the recorded ones too: one step.
    pub fn drop_all(&mut self) {
        self.end();
        self.gesture();
        self.list = List::default();
        self.end();
    }

    /// Drops what lies on top of the film: one step. False when there is nothing.
    pub fn drop_on_top(&mut self) -> bool {
        self.end();
        self.gesture();
        let any = self.list.drop_on_top();
        self.end();
        any
    }

    /// What lies on top becomes the end of the film.
    pub fn record(&mut self) {
        let all = (self.list.turns.len(), self.list.base);
        if self.list.recorded != all {
            let alone = self.gesture.is_none();
            self.gesture();
            self.list.recorded = all;
            if alone {
                self.end();
            }
        }
    }

    /// The hand lets go: what it did is one step from now on.
    pub fn end(&mut self) {
        if let Some(gesture) = self.gesture.take()
            && let Some(step) = Step::between(&gesture.before, &self.list)
        {
            self.past.push(step);
            self.future.clear();
            self.revision += 1;
        }
    }

    /// Takes back the last step that moved something, and those after it, which only recorded that. False when there is no
    /// step.
    pub fn undo_move(&mut self) -> bool {
        let any = self.undo();
        while self.future.last().is_some_and(|step| !step.moves()) && self.undo() {}
        any
    }

    /// Does that again. False when there is nothing.
    pub fn redo_move(&mut self) -> bool {
        let any = self.redo();
        while self.future.last().is_some_and(|step| !step.moves()) && self.redo() {}
        any
    }

    /// Takes back the last step. False when there is none.
    fn undo(&mut self) -> bool {
        self.end();
        let Some(step) = self.past.pop() else {
            return false;
        };
        self.restore(step.shared, &step.before);
        self.future.push(step);
        true
    }

    /// Does again what was undone last. False when there is nothing.
    fn redo(&mut self) -> bool {
        self.end();
        let Some(step) = self.future.pop() else {
            return false;
        };
        self.restore(step.shared, &step.after);
        self.past.push(step);
        true
    }

    fn restore(&mut self, shared: usize, ending: &Ending) {
        self.list.turns.truncate(shared);
        self.list.turns.extend(&ending.tail);
        self.list.base = ending.base;
        self.list.recorded = ending.recorded;
        self.revision += 1;
    }

    /// The gesture under way; a new one when there is none.
    fn gesture(&mut self) -> &mut Gesture {
        self.gesture.get_or_insert_with(|| Gesture {
            before: self.list.clone(),
            parts: Vec::new(),
            recorded: self.recording,
        })
    }

    /// Makes the turns of the list anew: those before the gesture, and what its parts are worth.
    fn compose(&mut self) {
        let Some(gesture) = &self.gesture else {
            return;
        };
        let before = &gesture.before;
        self.list.turns.clone_from(&before.turns);
        // What is only on top is not merged into the film: the film would change.
        let (recorded, _) = before.recorded;
        let floor = if gesture.recorded { 0 } else { recorded };
        for turn in gesture.parts.iter().flat_map(|part| part.turns()) {
            self.list.push(floor, turn);
        }
        self.list.recorded = if gesture.recorded {
            (self.list.turns.len(), self.list.base)
        } else {
            before.recorded
        };
    }
}

/// As an `<s` camera says it.
fn rounded(camera: Camera) -> CameraCorners {
    CameraCorners {
        eye: camera.eye.as_vec3(),
        top_left: camera.top_left.as_vec3(),
        top_right: camera.top_right.as_vec3(),
        bottom_left: camera.bottom_left.as_vec3(),
    }
}

/// True when the format accepts the camera: it is its own parser that says so.
fn can_be_saved(corners: &CameraCorners) -> bool {
    scene::camera_text(corners)
        .is_ok_and(|text| scene::parse(format!("{text}0 0 -1\n0\n").as_bytes()).is_ok())
}

#[cfg(test)]
mod tests;
