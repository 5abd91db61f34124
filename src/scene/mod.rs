//! The text format: bytes to plain data and back. Never opens files.

mod model;

pub use model::{Axis, CameraCorners, CameraSetting, Operation, Scene, Triangle};
