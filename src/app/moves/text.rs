//! Moves as lines of text, each telling how a list differs from the one before. Every number reads back to its bits.

use glam::DVec3;

use super::{List, Turn, can_be_saved, rounded};
use crate::camera::Camera;
use crate::scene::Axis;

const AXES: [(char, Axis); 3] = [('x', Axis::X), ('y', Axis::Y), ('z', Axis::Z)];
/// Angles below are exact as `f64`.
const MAX_MICRO_RAD: i64 = 1 << 53;

impl List {
    /// True when some of it is recorded.
    #[must_use]
    pub fn has_recorded(&self) -> bool {
        self.recorded != (0, None)
    }

    /// What leads from `before` to this list: turns kept, turns recorded, two cameras, more turns.
    #[must_use]
    pub fn line_after(&self, before: &List) -> String {
        let both = before.turns.iter().zip(&self.turns);
        let kept = both.take_while(|(a, b)| a == b).count();
        let (recorded, recorded_base) = self.recorded;
        let [base, recorded_base] = [self.base, recorded_base].map(|camera| match camera {
            Some(camera) => camera_word(&camera),
            None => "-".to_owned(),
        });
        let turns = self.turns[kept..].iter().map(|turn| {
            let (letter, _) = AXES[turn.axis as usize];
            format!(" {letter}{}", turn.micro_rad)
        });
        let turns: String = turns.collect();
        format!("{kept} {recorded} {base} {recorded_base}{turns}")
    }

    /// The list that such a line leads to from this one; `None` when it is not such a line.
    #[must_use]
    pub fn after_line(&self, line: &str) -> Option<List> {
        let mut words = line.split(' ');
        let kept: usize = words.next()?.parse().ok()?;
        let recorded = words.next()?.parse().ok()?;
        let mut camera = || match words.next()? {
            "-" => Some(None),
            word => Some(Some(camera_of(word)?)),
        };
        let (base, recorded_base) = (camera()?, camera()?);
        let mut turns = self.turns.get(..kept)?.to_vec();
        for word in words {
            let mut letters = word.chars();
            let letter = letters.next()?;
            let (_, axis) = *AXES.iter().find(|(l, _)| *l == letter)?;
            let micro_rad: i64 = letters.as_str().parse().ok()?;
            if micro_rad.unsigned_abs() >= MAX_MICRO_RAD.unsigned_abs() {
                return None;
            }
            turns.push(Turn { axis, micro_rad });
        }
        (recorded <= turns.len()).then_some(List {
            turns,
            base,
            recorded: (recorded, recorded_base),
        })
    }
}

/// A camera as one word.
#[must_use]
pub fn camera_word(camera: &Camera) -> String {
    let points = [
        camera.eye,
        camera.top_left,
        camera.top_right,
        camera.bottom_left,
    ];
    let numbers = points.iter().flat_map(|p| p.to_array());
    let words: Vec<String> = numbers.map(|n| n.to_string()).collect();
    words.join(",")
}

/// The camera of such a word; `None` when it is none that a scene could have.
#[must_use]
pub fn camera_of(word: &str) -> Option<Camera> {
    let numbers: Option<Vec<f64>> = word.split(',').map(|n| n.parse().ok()).collect();
    let numbers: [f64; 12] = numbers?.try_into().ok()?;
    let point = |i: usize| DVec3::from_slice(&numbers[3 * i..]);
    let camera = Camera {
        eye: point(0),
        top_left: point(1),
        top_right: point(2),
        bottom_left: point(3),
    };
    can_be_saved(&rounded(camera)).then_some(camera)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Random;

    fn random_list(random: &mut Random, before: &List) -> List {
        let mut number = |most: u32| random.below(most);
        let mut turns = before.turns.clone();
        turns.truncate(number(5) as usize + turns.len() / 2);
        for _ in 0..number(4) {
            turns.push(Turn {
                axis: AXES[number(3) as usize].1,
                micro_rad: i64::from(number(2_000_000)) - 1_000_000,
            });
        }
        let mut camera = || {
            let z = f64::from(number(1000)) / 7.0 + 1.0;
            (number(3) > 0).then_some(Camera {
                eye: DVec3::new(1.0 / 3.0, -0.0, z),
                top_left: DVec3::new(-1.0, 1.0, 0.1),
                top_right: DVec3::new(1.0, 1.0, 0.1),
                bottom_left: DVec3::new(-1.0, -1.0, 0.1),
            })
        };
        let (base, recorded_base) = (camera(), camera());
        let recorded = (number(u32::MAX) as usize % (turns.len() + 1), recorded_base);
        List {
            turns,
            base,
            recorded,
        }
    }

    #[test]
    fn lines_lead_from_list_to_list_to_the_bit() {
        let mut random = Random::new(5);
        let mut list = List::default();
        for _ in 0..200 {
            let next = random_list(&mut random, &list);
            let line = next.line_after(&list);
            assert_eq!(list.after_line(&line), Some(next.clone()), "{line}");
            list = next;
        }
    }

    #[test]
    fn other_lines_are_told_apart() {
        let camera = "0,0,5,-1,1,0,1,1,0,-1,-1,0";
        let list = List::default();
        assert!(list.after_line(&format!("0 1 {camera} - x5")).is_some());
        for bad in [
            "",
            "0",
            "0 0",
            "0 0 -",
            "1 0 - -",
            "0 1 - -",
            "0 0 - - w5",
            "0 0 - - x",
            "0 0 - - x9007199254740992",
            "0 0 - - x-9223372036854775808",
            "0 0 - -  x1",
            "0 0 1,2,3 -",
            "0 0 0,0,5,-1,1,0,1,1,0,nan,-1,0 -",
            "0 0 0,0,0,-1,1,0,1,1,0,-1,-1,0 -",
        ] {
            assert_eq!(list.after_line(bad), None, "{bad}");
        }
    }
}
