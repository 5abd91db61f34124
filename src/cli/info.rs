//! `raybomb info`: what is in a scene.

use std::fmt::{self, Display};

use serde::Serialize;

use super::args::InfoArgs;
use super::console::print;
use super::exit::{Failure, Outcome};
use super::load::{Source, compile, parse, renderer};
use crate::bvh::BvhStats;
use crate::camera::{Camera, Pivot};
use crate::geometry::Aabb;
use crate::scene::{Axis, CameraSetting, Scene};
use crate::timeline::{Timing, camera_at};
use crate::world::World;

/// Prints the facts.
///
/// # Errors
/// Those of the file and of its text.
pub fn run(args: &InfoArgs) -> Outcome {
    let renderer = renderer(0)?;
    let source = Source::read(&args.scene)?;
    let scene = parse(&renderer, &source)?;
    let world = compile(&renderer, &scene);
    let info = Info::new(source.name, &scene, &world);
    if args.json {
        let json = serde_json::to_string(&info)
            .map_err(|e| Failure::Failed(format!("cannot write JSON: {e}")))?;
        print(json)
    } else {
        print(info)
    }
}

/// Everything that `info` tells; the fields' names are those of the JSON object.
#[derive(Debug, Serialize)]
struct Info {
    scene: String,
    triangles: usize,
    degenerate: usize,
    /// `null` without triangles.
    bounds: Option<Bounds>,
    light: [f32; 3],
    camera: CameraInfo,
    operations: Vec<OperationInfo>,
    /// Frames of the animation at the default speed.
    frames: u64,
    bvh: BvhInfo,
    /// Of everything that the tracer keeps in memory.
    bytes: usize,
}

#[derive(Debug, Serialize)]
struct Bounds {
    min: [f32; 3],
    max: [f32; 3],
}

#[derive(Debug, Serialize)]
struct CameraInfo {
    /// `default` or `set`.
    setting: &'static str,
    /// Size of a picture when none is asked for.
    size: [usize; 2],
    base: CameraPoints,
    after_operations: CameraPoints,
}

#[derive(Debug, Serialize)]
struct CameraPoints {
    eye: [f64; 3],
    top_left: [f64; 3],
    top_right: [f64; 3],
    bottom_left: [f64; 3],
}

#[derive(Debug, Serialize)]
struct OperationInfo {
    axis: &'static str,
    angle_rad: f64,
}

#[derive(Debug, Serialize)]
struct BvhInfo {
    sah_cost: f64,
    nodes: usize,
    leaves: usize,
    depth: usize,
    bytes: usize,
}

impl Info {
    fn new(name: String, scene: &Scene, world: &World) -> Info {
        let operations = scene.operations.iter().map(|op| OperationInfo {
            axis: match op.axis {
                Axis::X => "x",
                Axis::Y => "y",
                Axis::Z => "z",
            },
            angle_rad: op.angle_rad,
        });
        Info {
            scene: name,
            triangles: world.triangle_count(),
            degenerate: world.degenerate_count(),
            bounds: Bounds::of(world.bounds()),
            light: scene.light.to_array(),
            camera: CameraInfo::new(scene, world.bounds()),
            operations: operations.collect(),
            frames: Timing::default().last_frame(&scene.operations) + 1,
            bvh: BvhInfo::from(world.bvh_stats()),
            bytes: world.bytes(),
        }
    }
}

impl Bounds {
    fn of(bounds: Aabb) -> Option<Bounds> {
        (!bounds.is_empty()).then(|| Bounds {
            min: bounds.min.to_array(),
            max: bounds.max.to_array(),
        })
    }
}

impl CameraInfo {
    fn new(scene: &Scene, bounds: Aabb) -> CameraInfo {
        let base = Camera::of_scene(scene, bounds);
        let timing = Timing::default();
        let last = timing.last_frame(&scene.operations);
        let pivot = Pivot::Origin.point(bounds);
        let (width, height) = base.default_size();
        CameraInfo {
            setting: match scene.camera {
                CameraSetting::Default => "default",
                CameraSetting::Set(_) => "set",
            },
            size: [width, height],
            base: base.into(),
            after_operations: camera_at(base, &scene.operations, timing, last, pivot).into(),
        }
    }
}

impl From<Camera> for CameraPoints {
    fn from(c: Camera) -> CameraPoints {
        CameraPoints {
            eye: c.eye.to_array(),
            top_left: c.top_left.to_array(),
            top_right: c.top_right.to_array(),
            bottom_left: c.bottom_left.to_array(),
        }
    }
}

impl From<BvhStats> for BvhInfo {
    fn from(s: BvhStats) -> BvhInfo {
        BvhInfo {
            sah_cost: s.sah_cost,
            nodes: s.nodes,
            leaves: s.leaves,
            depth: s.depth,
            bytes: s.bytes,
        }
    }
}

impl Display for Info {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "scene        {}", self.scene)?;
        write!(f, "triangles    {}", self.triangles)?;
        match self.degenerate {
            0 => writeln!(f)?,
            n => writeln!(f, ", {n} of them without area")?,
        }
        match &self.bounds {
            Some(b) => writeln!(f, "bounds       {} to {}", Point(b.min), Point(b.max))?,
            None => writeln!(f, "bounds       none")?,
        }
        writeln!(f, "light        {}", Point(self.light))?;
        let [width, height] = self.camera.size;
        writeln!(f, "camera       {}, {width}x{height}", self.camera.setting)?;
        write!(f, "{}", self.camera.base)?;
        writeln!(f, "operations   {}", self.operations.len())?;
        for op in &self.operations {
            writeln!(f, "  {} {} rad", op.axis, op.angle_rad)?;
        }
        if !self.operations.is_empty() {
            writeln!(f, "camera after the operations")?;
            write!(f, "{}", self.camera.after_operations)?;
        }
        writeln!(f, "frames       {} (0 to {})", self.frames, self.frames - 1)?;
        let bvh = &self.bvh;
        writeln!(
            f,
            "BVH          {} nodes, {} leaves, depth {}, SAH cost {:.2}, {} bytes",
            bvh.nodes, bvh.leaves, bvh.depth, bvh.sah_cost, bvh.bytes
        )?;
        write!(f, "memory       {} bytes", self.bytes)
    }
}

impl Display for CameraPoints {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "  eye          {}", Point(self.eye))?;
        writeln!(f, "  top left     {}", Point(self.top_left))?;
        writeln!(f, "  top right    {}", Point(self.top_right))?;
        writeln!(f, "  bottom left  {}", Point(self.bottom_left))
    }
}

/// Three coordinates with blanks between them.
struct Point<T>([T; 3]);

impl<T: Display> Display for Point<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = &self.0;
        write!(f, "{x} {y} {z}")
    }
}
