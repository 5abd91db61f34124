//! The text format: bytes to plain data ([`Scene`]) and back. Never opens files.
//!
//! [`parse`] reads in layers: `lexer` cuts the bytes into words, `number` turns words into numbers, `parser`
//! knows which word may come next (`corners`: in the camera's section). Two helpers stand beside the parser:
//! `parallel` reads the triangles of large files on all threads and knows only right and wrong; `recover` finds
//! the words for what is wrong and the place to go on, with a guess from `advice` at what led to it. [`write()`]
//! is the way back, to the bit, and `splice` puts what a hand has changed into the text as it stands.
//!
//! Errors ([`ParseErrors`]) carry their places; `snippet` shows a place with its line and a caret. What is odd
//! but allowed, such as a triangle without area, is for geometry to decide: [`locate_triangles`] gives the
//! places and [`annotate`] shows them.

mod advice;
mod corners;
mod error;
mod lexer;
mod locate;
mod model;
mod number;
mod parallel;
mod parser;
mod recover;
mod snippet;
mod splice;
mod writer;

pub use crate::math::Axis;
pub use error::{Channel, Expected, Found, ParseError, ParseErrorKind, ParseErrors, Point};
pub use locate::{Location, locate_triangles};
pub use model::{CameraCorners, CameraSetting, Operation, Scene, Triangle};
pub use parser::{parse, parse_watched};
pub use snippet::{Severity, annotate};
pub use splice::with_moves;
pub use writer::{camera_text, operations_text, write};
