//! The picture shown as the text of a scene: printed, and saved.

use super::{Command, State};
use crate::app::moves::Recorded;
use crate::scene::{CameraSetting, Operation, camera_text, operations_text};

/// A scene to be saved: its text with these.
#[derive(Clone, Debug, PartialEq)]
pub struct Document {
    /// The camera before any operation.
    pub camera: CameraSetting,
    /// All operations.
    pub operations: Vec<Operation>,
    /// Take a name that is free.
    pub new_name: bool,
    /// Of the operations, what the hand recorded.
    pub recorded: Recorded,
}

impl State {
    /// The picture shown, as the head and the tail of a scene file whose still picture it is.
    #[must_use]
    pub fn scene_text(&self) -> (String, String) {
        let operations: Vec<Operation> = self.operations().collect();
        let camera = match self.camera_setting() {
            CameraSetting::Default => Ok("<d\n".to_owned()),
            CameraSetting::Set(corners) => camera_text(&corners),
        };
        (
            camera.expect("a camera that could not be saved is not taken"),
            operations_text(&operations).expect("angles are finite"),
        )
    }

    /// The scene was saved under that name, or not; `recorded` is what was recorded then, `None` when another scene is
    /// open since.
    pub fn saved(&mut self, recorded: Option<Recorded>, result: Result<String, String>) {
        let line = match result {
            Ok(name) => {
                if let Some(recorded) = recorded {
                    self.moves.mark_saved(recorded);
                    self.is_in_file = true;
                }
                format!("saved {name}")
            }
            Err(why) => format!("cannot save the scene: {why}"),
        };
        self.report(line.clone());
        self.say(line);
    }

    /// The base camera as a file says it.
    pub(super) fn camera_setting(&self) -> CameraSetting {
        self.moves
            .base_corners()
            .map_or(self.setting.camera, CameraSetting::Set)
    }

    pub(super) fn save(&mut self, new_name: bool) {
        self.let_go_of_all();
        let mut operations = self.film.clone();
        // What is on top of another frame is no part of the scene.
        if self.playback.is_at_end() {
            operations.extend(self.moves.on_top());
        }
        self.commands.push(Command::Save(Document {
            camera: self.camera_setting(),
            operations,
            new_name,
            recorded: self.moves.recorded_part(),
        }));
    }

    pub(super) fn print_camera(&mut self) {
        let (camera, operations) = self.scene_text();
        self.commands.push(Command::Print(camera + &operations));
        self.say("the camera is on the standard output".to_owned());
    }
}
