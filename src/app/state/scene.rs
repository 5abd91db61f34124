//! What another scene, or the same one saved again, does to the state.

use std::time::Duration;

use glam::DVec3;

use super::State;
use crate::camera::Camera;
use crate::scene::Operation;

impl State {
    /// Another scene: it stands on its still picture, and no hand has touched it.
    pub fn open(&mut self, base: Camera, operations: Vec<Operation>, pivot: DVec3) {
        self.reload(base, operations, pivot);
        self.return_to_scene();
    }

    /// The scene changed under the hand: its moves, the frame and the playing stay.
    pub fn reload(&mut self, base: Camera, operations: Vec<Operation>, pivot: DVec3) {
        self.playback
            .set_operations(self.setting.timing, &operations);
        self.setting.base = base;
        self.setting.operations = operations;
        self.setting.pivot = pivot;
    }

    /// True where something may be drawn over the picture.
    #[must_use]
    pub fn may_overlay(&self) -> bool {
        self.setting.overlay
    }

    /// How long each frame is shown while the animation plays; `None` when it does not.
    #[must_use]
    pub fn frame_time(&self) -> Option<Duration> {
        let seconds = 1.0 / self.setting.timing.fps;
        let playing = self.playback.is_playing();
        playing.then(|| Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX))
    }
}
