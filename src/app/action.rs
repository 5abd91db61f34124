//! What a user can do, and how it is written down in a file of actions.

use std::fmt;
use std::str::FromStr;

use crate::render::ViewMode;
use crate::scene::Axis;

/// Something that changes the viewer's state. Distances and places are in physical pixels, right and down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action {
    /// Begin turning about a world axis, and go on until told to stop.
    StartTurn {
        /// Through the format's pivot.
        axis: Axis,
        /// The other way than the right-handed one.
        reverse: bool,
    },
    /// Stop turning about that axis.
    StopTurn(Axis),
    /// Stop turning at all: the window lost the keyboard.
    StopTurns,
    /// The hand went that far while it holds the picture like a globe.
    Orbit {
        /// To the right.
        dx_px: f64,
        /// Down.
        dy_px: f64,
        /// About this world axis alone.
        only: Option<Axis>,
    },
    /// The hand went that far to the right while it rolls the picture.
    Roll {
        /// To the right.
        dx_px: f64,
    },
    /// The hand went that far while it holds the point under the cursor.
    Pan {
        /// To the right.
        dx_px: f64,
        /// Down.
        dy_px: f64,
    },
    /// The hand went down that far while it pulls the picture nearer.
    DollyDrag {
        /// Down.
        dy_px: f64,
        /// Towards this place; `None`: the middle.
        at: Option<(f64, f64)>,
    },
    /// Nearer by so many notches of the wheel.
    Dolly {
        /// Negative: away.
        notches: f64,
        /// Towards this place; `None`: the middle.
        at: Option<(f64, f64)>,
    },
    /// The hand lets go of the picture: what it did is one step of undo.
    LetGo,
    /// Move so far away that the whole scene is seen.
    Fit,
    /// Look from a side.
    Look {
        /// Which.
        from: Side,
        /// From the other one.
        opposite: bool,
    },
    /// Orbit like a ball, or like a plate on a spindle.
    ToggleTurntable,
    /// Tell what is seen there.
    Pick((f64, f64)),
    /// Tell how far what is seen there is from what was picked.
    Measure((f64, f64)),
    /// Orbit about what is seen there.
    SetPivot((f64, f64)),
    /// Play the film, or pause.
    TogglePlayback,
    /// Play it backwards, or pause.
    TogglePlaybackBackwards,
    /// So many frames on, and stand there.
    StepFrames(i64),
    /// To the next beginning of an operation, or the one before.
    StepOperation {
        /// Towards the first frame.
        back: bool,
    },
    /// To the first frame.
    GoToStart,
    /// To the last frame.
    GoToEnd,
    /// To that frame.
    Seek(u64),
    /// Play so many times as fast.
    ScaleSpeed(f64),
    /// Play as fast as told.
    NormalSpeed,
    /// Set the first end of a loop, then the second, then drop both.
    MarkSection,
    /// Once, loop, ping-pong, cyclic.
    NextOrder,
    /// Keep the moves to come as operations of the film, or no longer.
    ToggleRecording,
    /// Take back the last move.
    Undo,
    /// Do it again.
    Redo,
    /// Write the scene's file.
    Save,
    /// Write the scene under a new name.
    SaveAs,
    /// Print the camera as the text of a scene.
    PrintCamera,
    /// Yes, to a question.
    Accept,
    /// No, to a question.
    Decline,
    /// Drop what the hand did; in the middle of the film, only what lies on top of it.
    ReturnToScene,
    /// The next kind of picture.
    NextView,
    /// That kind of picture.
    ShowView(ViewMode),
    /// The next engine: fast, brute, report.
    NextEngine,
    /// Two engines or views side by side, or one.
    ToggleSplit,
    /// The left side has so large a part of the picture's width, from 0 to 1.
    SetDivider(f64),
    /// The next engine of the right side.
    NextRightEngine,
    /// The next kind of picture of the right side.
    NextRightView,
    /// That kind of picture on the right side.
    ShowRightView(ViewMode),
    /// So many times as many tests are white in the view of the work done.
    ScaleCost(f64),
    /// The next kernel that this CPU has.
    NextKernel,
    /// Show or hide the figures.
    ToggleStatistics,
    /// Show or hide the cross of the axes.
    ToggleAxes,
    /// Draw what lies over the picture so many steps larger.
    Zoom(i32),
    /// Show or hide the key sheet.
    ToggleSheet,
    /// Save the picture as it is rendered.
    Screenshot,
    /// Enter or leave fullscreen.
    ToggleFullscreen,
    /// Another scene of the file's folder.
    Browse {
        /// The next one by name; otherwise the one before.
        forward: bool,
    },
    /// Close what is open, else leave fullscreen, else quit.
    Back,
    /// End the program.
    Quit,
}

impl Action {
    /// A key held down does it again and again.
    #[must_use]
    pub fn repeats(self) -> bool {
        matches!(
            self,
            Action::StepFrames(_)
                | Action::StepOperation { .. }
                | Action::ScaleSpeed(_)
                | Action::ScaleCost(_)
                | Action::Zoom(_)
                | Action::Undo
                | Action::Redo
        )
    }
}

/// Where to look from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// Where up is z: along +y; where it is y: along -z.
    Front,
    /// Along -x.
    Right,
    /// From where up is.
    Top,
    /// From the front, the right and above at once.
    Corner,
}

/// The actions that one word says.
const WORDS: &[(&str, Action)] = &[
    ("stop-turns", Action::StopTurns),
    ("let-go", Action::LetGo),
    ("fit", Action::Fit),
    ("turntable", Action::ToggleTurntable),
    ("play", Action::TogglePlayback),
    ("play-backwards", Action::TogglePlaybackBackwards),
    ("next-operation", Action::StepOperation { back: false }),
    ("previous-operation", Action::StepOperation { back: true }),
    ("start", Action::GoToStart),
    ("end", Action::GoToEnd),
    ("normal-speed", Action::NormalSpeed),
    ("mark-section", Action::MarkSection),
    ("next-order", Action::NextOrder),
    ("record", Action::ToggleRecording),
    ("undo", Action::Undo),
    ("redo", Action::Redo),
    ("save", Action::Save),
    ("save-as", Action::SaveAs),
    ("print-camera", Action::PrintCamera),
    ("accept", Action::Accept),
    ("decline", Action::Decline),
    ("return", Action::ReturnToScene),
    ("next-view", Action::NextView),
    ("next-engine", Action::NextEngine),
    ("split", Action::ToggleSplit),
    ("next-right-engine", Action::NextRightEngine),
    ("next-right-view", Action::NextRightView),
    ("next-kernel", Action::NextKernel),
    ("statistics", Action::ToggleStatistics),
    ("axes", Action::ToggleAxes),
    ("sheet", Action::ToggleSheet),
    ("screenshot", Action::Screenshot),
    ("fullscreen", Action::ToggleFullscreen),
    ("next-scene", Action::Browse { forward: true }),
    ("previous-scene", Action::Browse { forward: false }),
    ("back", Action::Back),
    ("quit", Action::Quit),
];

const AXES: [(&str, Axis); 3] = [("x", Axis::X), ("y", Axis::Y), ("z", Axis::Z)];

const SIDES: [(&str, Side); 4] = [
    ("front", Side::Front),
    ("right", Side::Right),
    ("top", Side::Top),
    ("corner", Side::Corner),
];

const VIEWS: [(&str, ViewMode); 5] = [
    ("shaded", ViewMode::Shaded),
    ("id", ViewMode::Id),
    ("normal", ViewMode::Normal),
    ("depth", ViewMode::Depth),
    ("cost", ViewMode::Cost),
];

fn name_of<T: PartialEq>(names: &[(&'static str, T)], value: T) -> &'static str {
    let found = names.iter().find(|(_, v)| *v == value);
    found.map_or("", |(name, _)| *name)
}

/// The line that [`Action::from_str`] reads.
impl fmt::Display for Action {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let place = |at: Option<(f64, f64)>| match at {
            Some((x, y)) => format!(" {x} {y}"),
            None => String::new(),
        };
        let word = |on: bool, word: &'static str| if on { word } else { "" };
        match *self {
            Action::StartTurn { axis, reverse } => {
                let axis = name_of(&AXES, axis);
                write!(f, "start-turn {axis}{}", word(reverse, " reverse"))
            }
            Action::StopTurn(axis) => write!(f, "stop-turn {}", name_of(&AXES, axis)),
            Action::Orbit { dx_px, dy_px, only } => {
                write!(f, "orbit {dx_px} {dy_px}")?;
                only.map_or(Ok(()), |axis| write!(f, " {}", name_of(&AXES, axis)))
            }
            Action::Roll { dx_px } => write!(f, "roll {dx_px}"),
            Action::Pan { dx_px, dy_px } => write!(f, "pan {dx_px} {dy_px}"),
            Action::DollyDrag { dy_px, at } => write!(f, "dolly-drag {dy_px}{}", place(at)),
            Action::Dolly { notches, at } => write!(f, "dolly {notches}{}", place(at)),
            Action::Look { from, opposite } => {
                let side = name_of(&SIDES, from);
                write!(f, "look {side}{}", word(opposite, " opposite"))
            }
            Action::Pick((x, y)) => write!(f, "pick {x} {y}"),
            Action::Measure((x, y)) => write!(f, "measure {x} {y}"),
            Action::SetPivot((x, y)) => write!(f, "pivot {x} {y}"),
            Action::StepFrames(frames) => write!(f, "step {frames}"),
            Action::Seek(frame) => write!(f, "seek {frame}"),
            Action::ScaleSpeed(factor) => write!(f, "speed {factor}"),
            Action::ShowView(mode) => write!(f, "view {}", name_of(&VIEWS, mode)),
            Action::ShowRightView(mode) => write!(f, "right-view {}", name_of(&VIEWS, mode)),
            Action::Zoom(steps) => write!(f, "zoom {steps}"),
            Action::SetDivider(part) => write!(f, "divider {part}"),
            Action::ScaleCost(factor) => write!(f, "scale-cost {factor}"),
            plain => f.write_str(name_of(WORDS, plain)),
        }
    }
}

/// What is left of a line.
struct Words<'t>(std::str::SplitAsciiWhitespace<'t>);

impl<'t> Words<'t> {
    fn word(&mut self, what: &str) -> Result<&'t str, String> {
        self.0.next().ok_or_else(|| format!("needs {what}"))
    }

    fn value<T: FromStr>(&mut self, what: &str) -> Result<T, String> {
        let word = self.word(what)?;
        word.parse()
            .map_err(|_| format!("needs {what}, has {word:?}"))
    }

    fn number(&mut self, what: &str) -> Result<f64, String> {
        let number: f64 = self.value(what)?;
        // Moves of any hand fit; sums of them stay finite.
        if number.abs() <= 1e6 {
            Ok(number)
        } else {
            Err(format!("{what} must lie between -1e6 and 1e6"))
        }
    }

    fn factor(&mut self) -> Result<f64, String> {
        match self.number("a factor")? {
            factor if factor > 0.0 => Ok(factor),
            _ => Err("the factor must be above 0".to_owned()),
        }
    }

    fn one_of<T: Copy>(&mut self, names: &[(&str, T)]) -> Result<T, String> {
        let list: Vec<&str> = names.iter().map(|(name, _)| *name).collect();
        let what = format!("one of {}", list.join(", "));
        let word = self.word(&what)?;
        let found = names.iter().find(|(name, _)| *name == word);
        found
            .map(|(_, value)| *value)
            .ok_or_else(|| format!("needs {what}, has {word:?}"))
    }

    fn place(&mut self) -> Result<(f64, f64), String> {
        Ok((self.number("a place")?, self.number("a place")?))
    }

    fn is_empty(&self) -> bool {
        self.0.clone().next().is_none()
    }

    fn place_if_any(&mut self) -> Result<Option<(f64, f64)>, String> {
        (!self.is_empty()).then(|| self.place()).transpose()
    }

    fn flag(&mut self, flag: &str) -> Result<bool, String> {
        if self.is_empty() {
            return Ok(false);
        }
        self.one_of(&[(flag, true)])
    }
}

impl FromStr for Action {
    type Err = String;

    fn from_str(line: &str) -> Result<Action, String> {
        let mut words = Words(line.split_ascii_whitespace());
        let name = words.word("an action")?;
        let action = action(name, &mut words).map_err(|e| format!("{name}: {e}"))?;
        match words.0.next() {
            None => Ok(action),
            Some(more) => Err(format!("{name}: ends before {more:?}")),
        }
    }
}

fn action(name: &str, words: &mut Words<'_>) -> Result<Action, String> {
    if let Some((_, action)) = WORDS.iter().find(|(word, _)| *word == name) {
        return Ok(*action);
    }
    let w = words;
    Ok(match name {
        "start-turn" => Action::StartTurn {
            axis: w.one_of(&AXES)?,
            reverse: w.flag("reverse")?,
        },
        "stop-turn" => Action::StopTurn(w.one_of(&AXES)?),
        "orbit" => Action::Orbit {
            dx_px: w.number("pixels")?,
            dy_px: w.number("pixels")?,
            only: (!w.is_empty()).then(|| w.one_of(&AXES)).transpose()?,
        },
        "roll" => Action::Roll {
            dx_px: w.number("pixels")?,
        },
        "pan" => Action::Pan {
            dx_px: w.number("pixels")?,
            dy_px: w.number("pixels")?,
        },
        "dolly-drag" => Action::DollyDrag {
            dy_px: w.number("pixels")?,
            at: w.place_if_any()?,
        },
        "dolly" => Action::Dolly {
            notches: w.number("notches")?,
            at: w.place_if_any()?,
        },
        "look" => Action::Look {
            from: w.one_of(&SIDES)?,
            opposite: w.flag("opposite")?,
        },
        "pick" => Action::Pick(w.place()?),
        "measure" => Action::Measure(w.place()?),
        "pivot" => Action::SetPivot(w.place()?),
        "step" => Action::StepFrames(w.value("a number of frames")?),
        "seek" => Action::Seek(w.value("the number of a frame")?),
        "speed" => Action::ScaleSpeed(w.factor()?),
        "view" => Action::ShowView(w.one_of(&VIEWS)?),
        "right-view" => Action::ShowRightView(w.one_of(&VIEWS)?),
        "zoom" => match w.value("a number of steps")? {
            steps @ -100..=100 => Action::Zoom(steps),
            _ => return Err("at most 100 steps".to_owned()),
        },
        "divider" => Action::SetDivider(w.number("a part of 1")?),
        "scale-cost" => Action::ScaleCost(w.factor()?),
        _ => return Err("is no action".to_owned()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_action_reads_back_as_it_was_written() {
        let (axis, at) = (Axis::Y, Some((0.1, -1e-9)));
        let (dx_px, dy_px) = (1.0 / 3.0, -2.5);
        let mut actions: Vec<Action> = WORDS.iter().map(|(_, action)| *action).collect();
        for reverse in [false, true] {
            actions.push(Action::StartTurn { axis, reverse });
            for (_, from) in SIDES {
                let opposite = reverse;
                actions.push(Action::Look { from, opposite });
            }
        }
        for only in [None, Some(Axis::Z)] {
            actions.push(Action::Orbit { dx_px, dy_px, only });
        }
        for at in [None, at] {
            actions.push(Action::DollyDrag { dy_px, at });
            actions.push(Action::Dolly { notches: 2.0, at });
        }
        actions.extend([
            Action::StopTurn(axis),
            Action::Roll { dx_px },
            Action::Pan { dx_px, dy_px },
            Action::Pick((3.5, 4.0)),
            Action::Measure((3.5, 4.0)),
            Action::SetPivot((3.5, 4.0)),
            Action::StepFrames(-1),
            Action::Seek(u64::MAX),
            Action::ScaleSpeed(1.1),
            Action::Zoom(-2),
            Action::SetDivider(0.25),
            Action::ScaleCost(0.5),
        ]);
        for (_, mode) in VIEWS {
            actions.extend([Action::ShowView(mode), Action::ShowRightView(mode)]);
        }
        for action in actions {
            let line = action.to_string();
            assert_eq!(line.parse(), Ok(action), "{line}");
        }
    }

    #[test]
    fn mistakes_are_told_and_never_panic() {
        for (line, why) in [
            ("", "needs an action"),
            ("dance", "dance: is no action"),
            ("orbit 1", "orbit: needs pixels"),
            ("orbit 1 two", "orbit: needs pixels, has \"two\""),
            ("orbit 1 2 w", "orbit: needs one of x, y, z, has \"w\""),
            ("orbit nan 2", "orbit: pixels must lie between -1e6 and 1e6"),
            ("undo twice", "undo: ends before \"twice\""),
            ("speed 0", "speed: the factor must be above 0"),
            ("step 1.5", "step: needs a number of frames, has \"1.5\""),
        ] {
            assert_eq!(line.parse::<Action>(), Err(why.to_owned()));
        }
    }
}
