//! The room in the window: what stands where, and where else there is place.

use super::canvas::Rect;

/// A window, and the rectangles in it that are taken.
#[derive(Debug)]
pub struct Room {
    width: i32,
    height: i32,
    taken: Vec<Rect>,
}

impl Room {
    /// An empty window of that size.
    #[must_use]
    pub fn new((width, height): (i32, i32)) -> Room {
        Room {
            width,
            height,
            taken: Vec::new(),
        }
    }

    /// Of the window, in pixels.
    #[must_use]
    pub fn width(&self) -> i32 {
        self.width
    }

    /// Of the window, in pixels.
    #[must_use]
    pub fn height(&self) -> i32 {
        self.height
    }

    /// Something stands there.
    pub fn take(&mut self, rect: Rect) {
        self.taken.push(rect);
    }

    /// `wish`, or where it covers something the free place next to it; `None` when there is none in the window.
    #[must_use]
    pub fn find(&self, wish: Rect) -> Option<Rect> {
        if self.is_free(&wish) {
            return Some(wish);
        }
        // Moved as far to any side as it can be, a rectangle touches borders: no other places need be tried.
        let others = |of: fn(&Rect) -> (i32, i32), here: i32, size: i32, window: i32| {
            let beside = self.taken.iter().map(of);
            let beside = beside.flat_map(|(first, end)| [first.saturating_sub(size), end]);
            let all = beside.chain([here, 0, window - size]);
            all.filter(|&at| (0..=window - size).contains(&at))
                .collect::<Vec<i32>>()
        };
        let columns = |r: &Rect| (r.x, r.x.saturating_add(r.width));
        let rows = |r: &Rect| (r.y, r.y.saturating_add(r.height));
        let (xs, ys) = (
            others(columns, wish.x, wish.width, self.width),
            others(rows, wish.y, wish.height, self.height),
        );
        let places = ys
            .iter()
            .flat_map(|&y| xs.iter().map(move |&x| Rect { x, y, ..wish }));
        places
            .filter(|place| self.is_free(place))
            .min_by_key(|place| place.x.abs_diff(wish.x) + place.y.abs_diff(wish.y))
    }

    fn is_free(&self, rect: &Rect) -> bool {
        self.taken.iter().all(|taken| rect.is_apart(taken))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Random;

    fn rect(x: i32, y: i32, width: i32, height: i32) -> Rect {
        Rect {
            x,
            y,
            width,
            height,
        }
    }

    #[test]
    fn what_is_in_the_way_is_gone_round_by_the_shortest_way() {
        let mut room = Room::new((100, 60));
        assert_eq!(room.find(rect(0, 0, 40, 20)), Some(rect(0, 0, 40, 20)));
        room.take(rect(0, 0, 40, 20));
        assert_eq!(room.find(rect(0, 0, 50, 10)), Some(rect(0, 20, 50, 10)));
        assert_eq!(room.find(rect(30, 5, 50, 10)), Some(rect(40, 5, 50, 10)));
        assert_eq!(room.find(rect(0, 0, 70, 41)), None);
    }

    #[test]
    fn a_place_is_found_wherever_there_is_one() {
        for seed in 0..2000 {
            let mut random = Random::new(seed);
            let mut draw = |limit: u32| random.below(limit) as i32;
            let mut room = Room::new((12, 9));
            for _ in 0..draw(5) {
                room.take(rect(draw(13) - 2, draw(10) - 2, draw(8), draw(8)));
            }
            let wish = rect(draw(12), draw(9), 1 + draw(6), 1 + draw(6));
            let is_there = (0..=9 - wish.height)
                .any(|y| (0..=12 - wish.width).any(|x| room.is_free(&Rect { x, y, ..wish })));
            let found = room.find(wish);
            assert!(found.is_none_or(|place| room.is_free(&place)), "{seed}");
            assert!(found.is_some() || !is_there, "{seed}");
        }
    }
}
