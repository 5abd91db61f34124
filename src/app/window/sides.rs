//! The sides of the picture that slow engines paint: who paints them, what there is of them, what is said of them.

use std::io;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use crate::app::companion::{Companion, News, Snapshot, Task};
use crate::app::overlay::{Labels, Line};
use crate::app::side::{Side, compose};
use crate::app::state::{Wish, word};
use crate::frame::Frame;
use crate::render::{Settings, ViewMode};
use crate::world::World;

/// A companion for each side, at work or not.
pub(super) struct SlowSides {
    companions: [Companion; 2],
    /// Counts the scenes.
    scene: u64,
    ordered: [Option<Task>; 2],
    /// What failed last, and was ordered once more.
    failed: [Option<Task>; 2],
    shown: [Option<Box<Snapshot>>; 2],
    /// There is more than is on screen.
    pub(super) is_new: bool,
}

impl SlowSides {
    /// Starts their threads, see [`Companion::start`]; `notify` is told whose news it is.
    pub(super) fn start(
        threads: usize,
        right_of_way: &Arc<AtomicBool>,
        notify: impl Fn(usize, News) + Clone + Send + Sync + 'static,
    ) -> io::Result<SlowSides> {
        let companion = |side| {
            let notify = notify.clone();
            Companion::start(threads, Arc::clone(right_of_way), move |news| {
                notify(side, news);
            })
        };
        Ok(SlowSides {
            companions: [companion(0)?, companion(1)?],
            scene: 0,
            ordered: [None, None],
            failed: [None, None],
            shown: [None, None],
            is_new: false,
        })
    }

    /// Another scene: nothing of the one before is shown.
    pub(super) fn open(&mut self, world: &Arc<World>) {
        self.scene += 1;
        self.ordered = [None, None];
        self.shown = [None, None];
        self.improve(world);
    }

    /// A better tree of the same scene.
    pub(super) fn improve(&mut self, world: &Arc<World>) {
        for companion in &self.companions {
            companion.set_world(Arc::clone(world));
        }
    }

    /// Asks for what `wish` wants of slow engines.
    pub(super) fn order(&mut self, wish: &Wish) {
        for (index, task) in self.tasks(wish).into_iter().enumerate() {
            if self.ordered[index] != task {
                if task.is_none() {
                    self.shown[index] = None;
                }
                self.companions[index].order(task.clone());
                self.ordered[index] = task;
            }
        }
    }

    /// Asks for nothing, until the next order; what there is stays.
    pub(super) fn rest(&mut self) {
        for (companion, ordered) in self.companions.iter().zip(&mut self.ordered) {
            if ordered.take().is_some() {
                companion.order(None);
            }
        }
    }

    fn tasks(&self, wish: &Wish) -> [Option<Task>; 2] {
        let task = |side: Side| Task {
            scene: self.scene,
            view: wish.view,
            settings: decisive(side.settings),
            columns: side.columns,
        };
        wish.sides().map(|side| side.is_slow().then(|| task(side)))
    }

    /// Takes in news of a side. Those of another scene, or of a side that is not wanted any more, are none.
    pub(super) fn take(&mut self, side: usize, snapshot: Box<Snapshot>) {
        if self.ordered[side].is_none() || snapshot.task.scene != self.scene {
            return;
        }
        if let Some(old) = self.shown[side].replace(snapshot) {
            self.companions[side].give_back(old.frame);
        }
        self.is_new = true;
    }

    /// A picture of a side failed: it is ordered once more, see [`Pace::failed`](crate::app::pace::Pace::failed).
    pub(super) fn take_failure(&mut self, side: usize) {
        if self.ordered[side] != self.failed[side] {
            self.failed[side] = self.ordered[side].take();
        }
    }

    /// See [`Companion::inject_fault`].
    pub(super) fn inject_fault(&self) {
        self.companions.iter().for_each(Companion::inject_fault);
    }

    /// True when nothing is missing of what `wish` wants.
    pub(super) fn are_whole(&self, wish: &Wish) -> bool {
        let pairs = self.tasks(wish).into_iter().zip(&self.shown);
        let mut missing = pairs.filter_map(|(task, shown)| Some((task?, shown)));
        missing.all(|(task, shown)| {
            let shown = shown.as_ref();
            shown.is_some_and(|s| s.is_whole && s.task == task)
        })
    }

    /// Lays the slow sides of `wish` over the rest of the picture.
    pub(super) fn lay(&self, wish: &Wish, pixels: &mut [u32], width: usize) {
        for (side, shown) in wish.sides().iter().zip(&self.shown) {
            if side.is_slow() {
                let frame = shown.as_ref().map(|s| &s.frame);
                compose(pixels, width, frame, side.columns.clone());
            }
        }
    }

    /// The picture as it is shown, for a file.
    pub(super) fn whole(&self, wish: &Wish, frame: &Frame) -> Frame {
        let mut frame = frame.clone();
        let width = frame.width;
        self.lay(wish, &mut frame.pixels, width);
        frame
    }

    /// What to say of the sides; `fast` is what the painter took for each. Nothing of a single side that is whole.
    pub(super) fn labels(&self, wish: &Wish, fast: [Duration; 2]) -> Option<Labels> {
        let sides = wish.sides();
        if wish.split.is_none() && (!sides[0].is_slow() || self.are_whole(wish)) {
            return None;
        }
        let mut times = [None, None];
        let mut lines = [0, 1].map(|i| {
            let side = &sides[i];
            let done = match &self.shown[i] {
                _ if !side.is_slow() => {
                    times[i] = Some(fast[i]);
                    span(fast[i])
                }
                None => "..".to_owned(),
                Some(shown) if shown.is_whole => {
                    times[i] = Some(shown.time);
                    span(shown.time)
                }
                Some(shown) => {
                    let percent = shown.done * 100.0;
                    let digits = if percent < 1.0 { 3 } else { 1 };
                    format!("{percent:.digits$} %, {}", span(shown.time))
                }
            };
            let name = word(side.settings.engine);
            vec![
                Line::new(name, word(side.settings.mode)),
                Line::new("", done),
            ]
        });
        if let [Some(left), Some(right)] = times
            && let Some(ratio) = ratio(left, right, &sides)
        {
            lines[1].push(Line::new("", format!("{ratio:.0} times as long")));
        }
        Some(Labels {
            column: wish.split.map(|split| split.column),
            lines,
        })
    }
}

/// What the picture of a slow engine depends on; the rest as usual. Such engines are scalar, and a change of what does not
/// matter is no reason to begin anew.
fn decisive(settings: Settings) -> Settings {
    let usual = Settings::default();
    Settings {
        kernel: usual.kernel,
        cost_scale: match settings.mode {
            ViewMode::Cost => settings.cost_scale,
            _ => usual.cost_scale,
        },
        ..settings
    }
}

/// How many times as long the right side takes for a pixel as the left one, if that is worth telling. With one engine on
/// both sides it would only tell what lies left and right of the divider.
fn ratio(left: Duration, right: Duration, sides: &[Side; 2]) -> Option<f64> {
    if sides[0].settings.engine == sides[1].settings.engine {
        return None;
    }
    let each = |time: Duration, side: &Side| time.as_secs_f64() / side.columns.len() as f64;
    let ratio = each(right, &sides[1]) / each(left, &sides[0]);
    (ratio.is_finite() && ratio >= 1.5).then_some(ratio)
}

/// A time in words.
fn span(time: Duration) -> String {
    let seconds = time.as_secs_f64();
    if seconds < 1.0 {
        format!("{:.1} ms", seconds * 1e3)
    } else {
        format!("{seconds:.1} s")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Engine;
    use crate::simd::Kernel;
    use std::ops::Range;

    #[test]
    fn slow_pictures_begin_anew_only_for_what_they_show() {
        let report = Settings {
            engine: Engine::Report,
            ..Settings::default()
        };
        let other = Settings {
            kernel: Kernel::Scalar,
            cost_scale: 7,
            ..report
        };
        assert_eq!(decisive(report), decisive(other));
        let mode = ViewMode::Cost;
        let cost = |settings| decisive(Settings { mode, ..settings });
        assert_ne!(cost(report), cost(other));
        assert_ne!(decisive(report), decisive(Settings::default()));
    }

    #[test]
    fn engines_are_compared_by_the_pixel_and_one_with_itself_not_at_all() {
        let side = |engine, columns| Side {
            settings: Settings {
                engine,
                ..Settings::default()
            },
            columns,
        };
        let ratio = |right, columns: Range<usize>| {
            let border = columns.start;
            let sides = [side(Engine::Fast, 0..border), side(right, columns)];
            ratio(Duration::from_millis(1), Duration::from_millis(60), &sides).map(f64::round)
        };
        assert_eq!(ratio(Engine::Report, 50..100), Some(60.0));
        assert_eq!(ratio(Engine::Report, 25..100), Some(20.0));
        assert_eq!(ratio(Engine::Report, 100..100), None);
        assert_eq!(ratio(Engine::Fast, 50..100), None);
    }
}
