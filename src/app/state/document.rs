//! The picture shown as the text of a scene: printed, and saved.

use glam::DVec3;

use super::{Command, State};
use crate::app::moves::Written;
use crate::scene::{CameraCorners, CameraSetting, Operation, camera_text, operations_text};

/// A scene to be saved: its text with these.
#[derive(Clone, Debug, PartialEq)]
pub struct Document {
    /// The camera before any operation.
    pub camera: CameraSetting,
    /// All operations.
    pub operations: Vec<Operation>,
    /// Take a name that is free.
    pub new_name: bool,
    /// Of camera and operations, what the hand did.
    pub moves: Written,
}

impl State {
    /// The picture shown, as the head and the tail of a scene file whose still picture it is.
    #[must_use]
    pub fn scene_text(&self) -> (String, String) {
        let operations: Vec<Operation> = self.operations().collect();
        let camera = match self.camera_of(self.moves.base_corners()) {
            CameraSetting::Default => Ok("<d\n".to_owned()),
            CameraSetting::Set(corners) => camera_text(&corners),
        };
        (
            camera.expect("a camera that could not be saved is not taken"),
            operations_text(&operations).expect("angles are finite"),
        )
    }

    /// The scene was saved under that name, or not; `moves` is what the hand had done then, `None` when another scene is
    /// open since.
    pub fn saved(&mut self, moves: Option<Written>, result: Result<String, String>) {
        let line = match result {
            Ok(name) => {
                let is_part = moves.as_ref().is_some_and(Written::is_part);
                if let Some(moves) = moves {
                    self.moves.mark_saved(moves);
                }
                let without = if is_part {
                    " without the moves that lie on top of the frame"
                } else {
                    ""
                };
                format!("saved {name}{without}{}", self.needed_pivot())
            }
            Err(why) => format!("cannot save the scene: {why}"),
        };
        self.report(line.clone());
        self.say(line);
    }

    /// What the operations need to show the same again, in words.
    fn needed_pivot(&self) -> &'static str {
        let is_origin = self.setting.pivot == DVec3::ZERO;
        if is_origin || self.operations().next().is_none() {
            ""
        } else {
            "; its operations need --pivot centre"
        }
    }

    /// The base camera as a file says it; `None`: the scene's.
    fn camera_of(&self, base: Option<CameraCorners>) -> CameraSetting {
        base.map_or(self.setting.camera, CameraSetting::Set)
    }

    pub(super) fn save(&mut self, new_name: bool) {
        self.let_go_of_all();
        // What is on top of another frame is no part of the scene; what is on top of the last one becomes the end of the film,
        // as it is in the file.
        let is_at_end = self.playback.is_at_end();
        if is_at_end {
            self.moves.record();
            self.after_move();
        }
        let moves = self.moves.to_write(is_at_end);
        let own = self.setting.operations.iter().copied();
        self.commands.push(Command::Save(Document {
            camera: self.camera_of(moves.base_corners()),
            operations: own.chain(moves.operations()).collect(),
            new_name,
            moves,
        }));
    }

    pub(super) fn print_camera(&mut self) {
        let (camera, operations) = self.scene_text();
        self.commands.push(Command::Print(camera + &operations));
        let needed = self.needed_pivot();
        self.say(format!("the camera is on the standard output{needed}"));
    }
}
