//! Scenes in turn, without a hand: each plays its operations once or stands for a while, fades to black, and the next
//! one comes out of it. The next one is loaded meanwhile; while it takes longer, the one before stays.
//!
//! Plain data; time enters as a value.

use std::time::{Duration, Instant};

use super::loader::{Loaded, Source};
use crate::world::World;
use std::sync::Arc;

/// From light to black, and back.
const FADE: Duration = Duration::from_millis(600);
/// How long a scene stands after its last operation, and one that has none in all.
const REST: Duration = Duration::from_millis(1000);
const STAND: Duration = Duration::from_secs(8);

/// Something that the window has to do.
#[derive(Debug)]
pub enum Turn {
    /// Load this one, while another is shown.
    Load(Source),
    /// Show this one from its first frame.
    Show(Box<Loaded>),
}

/// What is on screen.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    /// Nothing, or nothing that can be seen.
    Black,
    /// A scene that comes, or has come.
    Lit { since: Instant },
    /// A scene that goes.
    Fading { since: Instant },
}

/// The round of scenes.
#[derive(Debug)]
pub struct Kiosk {
    sources: Vec<Source>,
    /// The number of the source that was loaded last.
    at: usize,
    /// It is there, and not yet shown.
    next: Option<Box<Loaded>>,
    /// It is on its way.
    is_loading: bool,
    /// Sources in a row that were no scenes.
    bad: usize,
    /// What was said of each source that was no scene when it was loaded last.
    told: Vec<Option<String>>,
    phase: Phase,
    /// The scene on screen has operations.
    has_operations: bool,
    /// It was last seen playing then.
    played: Option<Instant>,
}

impl Kiosk {
    /// Goes round `sources`, of which there is at least one and the first is being loaded.
    #[must_use]
    pub fn new(sources: Vec<Source>) -> Kiosk {
        Kiosk {
            told: vec![None; sources.len()],
            sources,
            at: 0,
            next: None,
            is_loading: true,
            bad: 0,
            phase: Phase::Black,
            has_operations: false,
            played: None,
        }
    }

    /// A scene is there.
    pub fn loaded(&mut self, loaded: Box<Loaded>) {
        self.next = Some(loaded);
        self.is_loading = false;
        self.bad = 0;
        self.told[self.at] = None;
    }

    /// True when the terminal has to hear why a source is no scene: not again and again in each round.
    pub fn is_news(&mut self, why: &str) -> bool {
        let before = self.told[self.at].replace(why.to_owned());
        before.as_deref() != Some(why)
    }

    /// The scene that was loaded last has a better tree. Given back when it is the one on screen.
    pub fn improved(&mut self, world: Arc<World>) -> Option<Arc<World>> {
        match &mut self.next {
            Some(next) => {
                next.world = world;
                None
            }
            None => Some(world),
        }
    }

    /// A source is no scene. False when none of them is.
    pub fn failed(&mut self) -> bool {
        self.is_loading = false;
        self.bad += 1;
        self.bad < self.sources.len()
    }

    /// What is to be done now; ask again until it is nothing.
    pub fn turn(&mut self, now: Instant, is_playing: bool) -> Option<Turn> {
        if is_playing {
            self.played = Some(now);
        }
        match self.phase {
            Phase::Black => {
                if let Some(loaded) = self.next.take() {
                    self.phase = Phase::Lit { since: now };
                    self.has_operations = !loaded.operations.is_empty();
                    self.played = None;
                    return Some(Turn::Show(loaded));
                }
            }
            Phase::Lit { .. } if self.next.is_some() && self.goes_at(now) <= now => {
                self.phase = Phase::Fading { since: now };
            }
            Phase::Fading { since } if now >= since + FADE => {
                self.phase = Phase::Black;
                return self.turn(now, is_playing);
            }
            Phase::Lit { .. } | Phase::Fading { .. } => {}
        }
        if self.next.is_none() && !self.is_loading {
            self.is_loading = true;
            self.at = (self.at + 1) % self.sources.len();
            return Some(Turn::Load(self.sources[self.at].clone()));
        }
        None
    }

    /// When the scene on screen begins to go, if it stops playing now.
    fn goes_at(&self, now: Instant) -> Instant {
        let Phase::Lit { since } = self.phase else {
            return now;
        };
        match self.played {
            Some(played) if self.has_operations => played + REST,
            _ => since + STAND,
        }
    }

    /// How much of the light is to be seen, of 256.
    #[must_use]
    pub fn light(&self, now: Instant) -> u32 {
        let part = |since: Instant| {
            let passed = now.saturating_duration_since(since).as_secs_f64();
            (passed / FADE.as_secs_f64()).min(1.0)
        };
        let light = match self.phase {
            Phase::Black => 0.0,
            Phase::Lit { since } => part(since),
            Phase::Fading { since } => 1.0 - part(since),
        };
        // 0 to 256.
        (light * 256.0).round() as u32
    }

    /// True while the light changes.
    #[must_use]
    pub fn is_fading(&self, now: Instant) -> bool {
        match self.phase {
            Phase::Black => false,
            Phase::Lit { since } => now < since + FADE,
            Phase::Fading { .. } => true,
        }
    }

    /// When to ask again, if nothing happens before.
    #[must_use]
    pub fn wake(&self, now: Instant) -> Option<Instant> {
        match self.phase {
            Phase::Lit { .. } if self.next.is_some() => Some(self.goes_at(now)),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::loader::Loader;
    use crate::app::loader::Told;
    use std::sync::mpsc::channel;

    fn source(name: &str) -> Source {
        Source::Text {
            name: name.to_owned(),
            text: Arc::new(b"<d 0 0 -1 0 <o 1 <z 1".to_vec()),
        }
    }

    fn scene(name: &str) -> Box<Loaded> {
        let (send, receive) = channel();
        let tell = move |_, told| {
            let _ = send.send(told);
        };
        let mut loader = Loader::new(1);
        loader.start(source(name), None, tell).expect("a thread");
        let done = receive.iter().find_map(|told| match told {
            Told::Done(done) => Some(done),
            _ => None,
        });
        done.expect("an end").expect("a scene")
    }

    fn name(turn: Option<Turn>) -> String {
        match turn {
            Some(Turn::Load(source)) => source.name(),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn scenes_come_out_of_black_play_and_go_into_it_round_and_round() {
        let start = Instant::now();
        let at = |ms: u64| start + Duration::from_millis(ms);
        let mut k = Kiosk::new(vec![source("a"), source("b")]);
        assert!(k.turn(at(0), false).is_none() && k.light(at(0)) == 0);
        k.loaded(scene("a"));
        assert!(matches!(k.turn(at(10), false), Some(Turn::Show(_))));
        assert_eq!(name(k.turn(at(10), true)), "b");
        assert!(k.is_fading(at(20)) && k.light(at(310)) == 128 && k.light(at(710)) == 256);
        // It plays for 20 seconds, and the next one is there long before.
        k.loaded(scene("b"));
        for ms in (1000..20_000).step_by(50) {
            assert!(k.turn(at(ms), true).is_none());
            assert!(!k.is_fading(at(ms)));
        }
        assert!(k.turn(at(20_000), false).is_none());
        let goes = k.wake(at(20_000)).expect("a time");
        assert!(k.turn(goes, false).is_none() && k.is_fading(goes));
        assert_eq!(k.light(goes), 256);
        assert!(matches!(k.turn(goes + FADE, false), Some(Turn::Show(_))));
        assert_eq!(k.light(goes + FADE), 0);
        assert_eq!(name(k.turn(goes + FADE, true)), "a");
    }

    #[test]
    fn a_scene_stays_until_the_next_one_is_there() {
        let start = Instant::now();
        let mut k = Kiosk::new(vec![source("a"), source("b")]);
        k.loaded(scene("a"));
        k.turn(start, false);
        k.turn(start, false);
        let late = start + Duration::from_secs(100);
        assert!(k.turn(late, false).is_none() && k.light(late) == 256);
        assert_eq!(k.wake(late), None);
        k.loaded(scene("b"));
        k.turn(late, false);
        assert!(k.is_fading(late));
    }

    #[test]
    fn bad_sources_are_passed_over_until_all_are_bad() {
        let now = Instant::now();
        let mut k = Kiosk::new(vec![source("a"), source("b"), source("c")]);
        assert!(k.failed());
        assert_eq!(name(k.turn(now, false)), "b");
        assert!(k.failed());
        assert_eq!(name(k.turn(now, false)), "c");
        k.loaded(scene("c"));
        assert!(matches!(k.turn(now, false), Some(Turn::Show(_))));
        for expected in ["a", "b"] {
            assert_eq!(name(k.turn(now, false)), expected);
            assert!(k.failed());
        }
        assert_eq!(name(k.turn(now, false)), "c");
        assert!(!k.failed());
    }

    #[test]
    fn why_a_source_is_bad_is_told_once_until_that_changes() {
        let mut k = Kiosk::new(vec![source("a"), source("b")]);
        assert!(k.is_news("no file") && !k.is_news("no file"));
        assert!(k.is_news("no scene"));
        assert!(k.failed());
        assert_eq!(name(k.turn(Instant::now(), false)), "b");
        assert!(k.is_news("no scene") && !k.is_news("no scene"));
        k.loaded(scene("b"));
        assert!(k.is_news("no scene"));
    }

    #[test]
    fn a_better_tree_goes_to_the_scene_that_it_is_of() {
        let mut k = Kiosk::new(vec![source("a")]);
        k.loaded(scene("a"));
        let world = Arc::clone(&scene("a").world);
        assert!(k.improved(Arc::clone(&world)).is_none());
        let Some(Turn::Show(shown)) = k.turn(Instant::now(), false) else {
            panic!("it is there");
        };
        assert!(Arc::ptr_eq(&shown.world, &world));
        assert!(k.improved(world).is_some());
    }
}
