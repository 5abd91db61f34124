//! What `bench` prints: words, or one line of JSON.

use serde::Serialize;

use super::scaling::ScalingReport;
use crate::cli::console::counted;

/// One line of `bench --json`: scripts rely on names and order.
#[derive(Debug, Serialize)]
pub struct Report {
    pub scene: String,
    pub workload: &'static str,
    pub engine: &'static str,
    pub kernel: &'static str,
    pub threads: usize,
    pub width: usize,
    pub height: usize,
    pub triangles: usize,
    pub frames: u32,
    pub median_ms: f64,
    pub min_ms: f64,
    /// From the median; `null` where no rays are measured.
    pub mrays_s: Option<f64>,
    pub build_ms: f64,
    pub bytes_per_triangle: f64,
    /// The tree was built by the coarse builder.
    pub coarse: bool,
    /// Million triangles a second, from the median; `null` where no building is measured.
    pub mtris_s: Option<f64>,
    /// `null` where none are measured.
    pub rays: Option<usize>,
    /// How many of them hit something; `null` where it is not counted.
    pub hits: Option<usize>,
    /// SHA-256 of the results.
    pub hash: Option<String>,
    /// While the world was built, that included: with workload build, where the system tells.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peak_bytes_per_triangle: Option<f64>,
    /// What `slice::fill` of the same framebuffer takes on as many threads: with workload shaded.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fill_ms: Option<f64>,
    /// With `--stages`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stages: Option<StagesReport>,
    /// With `--scaling`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scaling: Option<ScalingReport>,
}

/// Ticks of the time stamp counter a pixel, all threads together.
#[derive(Debug, Serialize)]
pub struct StagesReport {
    /// From box to box.
    pub traversal: f64,
    /// Leaves: vertices, boxes on screen, edge functions.
    pub setup: f64,
    /// From edge functions to pixels.
    pub coverage: f64,
    /// Shading and storing, or storing numbers and distances.
    pub output: f64,
}

impl StagesReport {
    /// For people.
    pub fn words(&self) -> String {
        format!(
            "\nticks a pixel: traversal {:.2}, setup {:.2}, coverage {:.2}, output {:.2}",
            self.traversal, self.setup, self.coverage, self.output
        )
    }
}

impl Report {
    /// For people.
    pub fn words(&self) -> String {
        let rays = self
            .mrays_s
            .map_or_else(String::new, |m| format!(", {m:.1} Mray/s"));
        let built = self
            .mtris_s
            .map_or_else(String::new, |m| format!(", {m:.2} Mtri/s"));
        let quality = if self.coarse { "coarse " } else { "" };
        let peak = self
            .peak_bytes_per_triangle
            .map_or_else(String::new, |b| format!(" (peak {b:.1})"));
        let fill = self.fill_ms.map_or_else(String::new, |fill| {
            format!("\na fill of the framebuffer alone {fill:.3} ms")
        });
        let counts = match (self.rays, self.hits) {
            (Some(rays), Some(hits)) => format!("\n{rays} rays, {hits} hits"),
            _ => String::new(),
        };
        format!(
            "{}: {}, {}x{}\n\
             {}, engine {}, kernel {}, threads {}: median {:.3} ms, best {:.3} ms of {}{rays}{built}\n\
             {quality}build {:.1} ms, {:.1} bytes a triangle{peak}{counts}{fill}{}{}",
            self.scene,
            counted(self.triangles, "triangle"),
            self.width,
            self.height,
            self.workload,
            self.engine,
            self.kernel,
            self.threads,
            self.median_ms,
            self.min_ms,
            self.frames,
            self.build_ms,
            self.bytes_per_triangle,
            self.stages
                .as_ref()
                .map_or_else(String::new, StagesReport::words),
            self.scaling
                .as_ref()
                .map_or_else(String::new, ScalingReport::words)
        )
    }
}
