//! What is seen at a place: asked for here, found out by whoever has the world, told in the window and as JSON.

use glam::DVec3;
use serde_json::{Value, json};

use super::{Command, Probe, State};
use crate::app::bindings::Spot;
use crate::app::orbit;
use crate::render::Picked;

impl State {
    pub(super) fn probe(&mut self, (x, y): (f64, f64), spot: Spot) {
        let (width, height) = self.size_px;
        let inside = |v: f64, limit: usize| v >= 0.0 && v < limit as f64;
        if inside(x, width) && inside(y, height) {
            self.commands.push(Command::Probe(Probe {
                scene: self.scene,
                wish: self.wish(),
                // Not negative, and below a window's size.
                pixel: (x as usize, y as usize),
                spot,
            }));
        }
    }

    /// The answer to a probe. That of another scene tells nothing of this one.
    pub fn probed(&mut self, probe: &Probe, found: Option<Picked>) {
        if probe.scene != self.scene {
            return;
        }
        match probe.spot {
            Spot::Pivot => {
                self.pivot = found.map(|p| p.point);
                // Its first click was a pick, which nobody wanted.
                self.drop_pick();
                self.say(match found {
                    Some(p) => format!("orbit about {}", words(p.point)),
                    None => "orbit about the format's pivot".to_owned(),
                });
            }
            Spot::Pick => {
                self.print_pick(probe, found, None);
                self.picked = found;
                self.measured = None;
                self.picked_lines = found.map(|p| lines(&p)).unwrap_or_default();
            }
            Spot::Measure => {
                let Some(first) = self.picked else {
                    let spot = Spot::Pick;
                    return self.probed(&Probe { spot, ..*probe }, found);
                };
                let measured = found.map(|p| (p.point - first.point).length());
                self.print_pick(probe, found, measured);
                self.measured = found.map(|p| p.point);
                match (found, measured) {
                    (Some(p), Some(measured)) => {
                        self.picked_lines = lines(&first);
                        self.picked_lines.extend([
                            ("to".to_owned(), format!("triangle {}", p.id)),
                            ("at".to_owned(), words(p.point)),
                            ("measured".to_owned(), format!("{measured:.6}")),
                        ]);
                    }
                    _ => {
                        self.picked_lines = lines(&first);
                        self.say("nothing to measure to".to_owned());
                    }
                }
            }
        }
    }

    pub(super) fn drop_pick(&mut self) {
        self.picked = None;
        self.measured = None;
        self.picked_lines.clear();
    }

    /// Where the picked points are seen now.
    pub(super) fn marks(&self) -> Vec<(i32, i32)> {
        let points = self
            .picked
            .map(|p| p.point)
            .into_iter()
            .chain(self.measured);
        let view = self.view();
        points
            .filter_map(|p| orbit::place_of(&view, p))
            // Far outside stays far outside.
            .map(|(x, y)| (x.floor() as i32, y.floor() as i32))
            .collect()
    }

    fn print_pick(&mut self, probe: &Probe, found: Option<Picked>, measured: Option<f64>) {
        if self.setting.print_picks {
            let line = format!("{}\n", record(probe, found, measured));
            self.commands.push(Command::Print(line));
        }
    }
}

/// A pick as JSON.
fn record(probe: &Probe, found: Option<Picked>, measured: Option<f64>) -> Value {
    let (x, y) = probe.pixel;
    let mut record = json!({ "pixel": [x, y], "id": null });
    if let Some(p) = found {
        let corners = p.corners.map(|c| c.to_array());
        record["id"] = json!(p.id);
        record["corners"] = json!(corners);
        record["color"] = json!([p.color.r, p.color.g, p.color.b]);
        record["point"] = json!(p.point.to_array());
        record["distance"] = json!(p.distance);
        record["angle_deg"] = json!(p.angle_rad.to_degrees());
    }
    if let Some(measured) = measured {
        record["measured"] = json!(measured);
    }
    record
}

/// A pick for the window.
fn lines(p: &Picked) -> Vec<(String, String)> {
    let line = |name: &str, text: String| (name.to_owned(), text);
    let corner = |name, i: usize| line(name, words(p.corners[i].as_dvec3()));
    let c = p.color;
    vec![
        line("triangle", p.id.to_string()),
        corner("A", 0),
        corner("B", 1),
        corner("C", 2),
        line("colour", format!("{} {} {}", c.r, c.g, c.b)),
        line("point", words(p.point)),
        line("distance", format!("{:.6}", p.distance)),
        line("angle", format!("{:.2} degrees", p.angle_rad.to_degrees())),
    ]
}

fn words(p: DVec3) -> String {
    format!("{:.5} {:.5} {:.5}", p.x, p.y, p.z)
}
