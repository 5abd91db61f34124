//! Ray Bomb 3D: coloured triangles, one camera, one light, ray-traced in real time on the CPU.
//!
//! The folders are the pipeline. A module uses the ones above it in this list and those beside it, never the ones below:
//!
//! 1. [`math`], [`color`], [`simd`]: helpers that know nothing of scenes. [`frame`]: the pixels and hits of a picture
//!    in memory. [`raw`]: all that is `unsafe`. [`watch`]: how far long work is, and the wish to stop it.
//! 2. [`scene`]: the text format, to plain data and back.
//! 3. [`geometry`], [`bvh`], [`camera`], [`timeline`], [`world`]: the scene as arrays for the kernels; where
//!    the camera stands at which frame.
//! 4. [`trace`], [`report`]: which triangle each pixel's ray hits, and how far away; by the fast tile
//!    kernels, by brute force, or by the method of the original report.
//! 5. [`shade`]: from hits to colours.
//! 6. [`render`], [`export`]: whole pictures, and files of them.
//! 7. [`demo`]: built-in scenes. [`app`]: the window. [`cli`]: the command line.

pub mod app;
pub mod bvh;
pub mod camera;
pub mod cli;
pub mod color;
pub mod demo;
pub mod export;
pub mod frame;
pub mod geometry;
pub mod math;
pub mod raw;
pub mod render;
pub mod report;
pub mod scene;
pub mod shade;
pub mod simd;
pub mod timeline;
pub mod trace;
pub mod watch;
pub mod world;
