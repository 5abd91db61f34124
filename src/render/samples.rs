//! Several samples a pixel: where in the pixel they lie, and how they become one colour.
//!
//! A picture of `N` samples is the mean of `N` whole pictures, each with all its rays moved by the same part of a
//! pixel. One sample goes through the pixel's centre, as ever. From two on they come in pairs that lie opposite each
//! other about the centre, so the picture does not shift as it refines; and the places of a count are the first ones
//! of the next, so the window refines by adding, and has at each count the very bits of a file.
//!
//! The mean is exact: the 8-bit channels are added as whole numbers, and `(sum + N/2) / N` rounds to the nearest,
//! halves up.

use rayon::prelude::*;

use super::{Cancelled, Progress, RenderStats, Renderer, Settings};
use crate::camera::View;
use crate::frame::Frame;
use crate::world::World;

/// The first sample of each pair, in 128ths of a pixel right of and below the centre; the second lies opposite.
///
/// The first 2, 4, 8, .. 64 samples each fill every row, every column and every box between (of the sizes 1 x 1/N,
/// 1/2 x 2/N, .. 1/N x 1) once: a (0, m, 2)-net in base 2, as H. Niederreiter defines it ("Point sets and sequences
/// with small discrepancy", 1987). Found by a search for the widest gaps among those.
const PAIRS: [(i8, i8); 32] = [
    (31, -31),
    (37, 35),
    (-13, -15),
    (-49, 63),
    (-3, 43),
    (-63, -19),
    (41, -1),
    (21, 55),
    (-11, 9),
    (-17, 51),
    (27, 25),
    (55, 57),
    (-7, -47),
    (-35, 39),
    (-57, 23),
    (-45, -7),
    (-59, -41),
    (43, 49),
    (19, 3),
    (1, 21),
    (9, 61),
    (-47, 53),
    (53, -13),
    (-29, -37),
    (-39, 27),
    (15, -59),
    (23, -5),
    (-61, 45),
    (-33, -29),
    (-5, 17),
    (51, 11),
    (-25, 33),
];

/// How many samples a pixel has: 1, 2, 4, .. 64.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Samples(u32);

impl Samples {
    /// One, through the pixel's centre.
    pub const ONE: Samples = Samples(1);
    /// The most that there are.
    pub const MAX: Samples = Samples(64);

    /// `count` samples; `None` when it is no power of two up to 64.
    #[must_use]
    pub fn new(count: u32) -> Option<Samples> {
        let known = count.is_power_of_two() && count <= Samples::MAX.0;
        known.then_some(Samples(count))
    }

    /// The number.
    #[must_use]
    pub fn count(self) -> u32 {
        self.0
    }

    /// Twice as many, up to `limit`; `None` when these are as many.
    #[must_use]
    pub fn refined(self, limit: Samples) -> Option<Samples> {
        (self < limit).then_some(Samples(self.0 * 2))
    }
}

impl Default for Samples {
    fn default() -> Samples {
        Samples::ONE
    }
}

/// The rays of `view` through place number `index` (0..64) of each pixel.
#[must_use]
fn view_of_sample(view: &View, index: u32) -> View {
    let (right, down) = PAIRS[index as usize / 2];
    let sign = if index.is_multiple_of(2) { 1.0 } else { -1.0 };
    // 128ths are exact in binary: only the products round.
    let (right, down) = (
        sign * f64::from(right) / 128.0,
        sign * f64::from(down) / 128.0,
    );
    View {
        base: view.base + view.dx * right + view.dy * down,
        ..*view
    }
}

/// A picture that gets better: the sums of its samples up to now.
#[derive(Debug, Default)]
pub struct Refinement {
    /// A pixel's red, green and blue sum in 16 bits each, blue lowest: 64 times 255 fits.
    sums: Vec<u64>,
    /// How many samples they hold.
    count: u32,
    /// One sample.
    scratch: Frame,
}

impl Refinement {
    /// Forgets all samples: another view comes.
    pub fn restart(&mut self) {
        self.count = 0;
    }

    /// Brings the picture to `samples` samples a pixel, and `frame` to show it. Samples of the same view since the
    /// last [`Refinement::restart`] are not rendered again. The times are those of all samples added.
    ///
    /// # Errors
    /// [`Cancelled`] when `progress` was told so; `frame` is then unfinished, the samples stay.
    #[expect(clippy::too_many_arguments, reason = "a picture's, and how fine")]
    pub fn picture(
        &mut self,
        renderer: &Renderer,
        world: &World,
        view: &View,
        settings: &Settings,
        samples: Samples,
        frame: &mut Frame,
        progress: &Progress,
    ) -> Result<RenderStats, Cancelled> {
        self.refine(renderer, view, samples, frame, |view, frame| {
            renderer.picture(world, view, settings, frame, progress)
        })
    }

    /// The same, where each sample is what `paint` makes of its rays.
    ///
    /// # Errors
    /// [`Cancelled`] when `paint` was; `frame` is then unfinished, the samples stay.
    pub fn refine(
        &mut self,
        renderer: &Renderer,
        view: &View,
        samples: Samples,
        frame: &mut Frame,
        mut paint: impl FnMut(&View, &mut Frame) -> Result<RenderStats, Cancelled>,
    ) -> Result<RenderStats, Cancelled> {
        if samples == Samples::ONE {
            return paint(view, frame);
        }
        let mut stats = RenderStats::default();
        while self.count < samples.count() {
            let view = view_of_sample(view, self.count);
            stats = stats + paint(&view, &mut self.scratch)?;
            renderer.install(|| self.add());
        }
        frame.resize(view.width, view.height);
        renderer.install(|| self.mean(frame));
        Ok(stats)
    }

    /// Adds the sample in `scratch`.
    fn add(&mut self) {
        let Refinement {
            sums,
            count,
            scratch,
        } = self;
        if *count == 0 {
            sums.clear();
            sums.resize(scratch.pixels.len(), 0);
        }
        let add = |(sum, &pixel): (&mut u64, &u32)| *sum += spread(pixel);
        sums.par_iter_mut()
            .zip(&scratch.pixels)
            .with_min_len(1 << 14)
            .for_each(add);
        *count += 1;
    }

    fn mean(&self, frame: &mut Frame) {
        let count = u64::from(self.count);
        frame
            .pixels
            .par_iter_mut()
            .zip(&self.sums)
            .with_min_len(1 << 14)
            .for_each(|(pixel, &sum)| *pixel = mean(sum, count));
    }
}

/// `0x00RRGGBB` with 16 bits a channel.
fn spread(pixel: u32) -> u64 {
    let p = u64::from(pixel);
    (p & 0xff_0000) << 16 | (p & 0xff00) << 8 | p & 0xff
}

/// The colour whose channels are those of `sum` over `count`, to the nearest, halves up.
fn mean(sum: u64, count: u64) -> u32 {
    let channel = |shift: u32| ((sum >> shift & 0xffff) + count / 2) / count;
    // A mean of bytes is a byte.
    (channel(32) << 16 | channel(16) << 8 | channel(0)) as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::color::Rgb;
    use crate::math::Random;
    use crate::scene::{CameraSetting, Scene, Triangle};
    use std::collections::HashSet;

    /// The first `count` samples in 128ths of a pixel from its upper left corner.
    fn places(count: usize) -> Vec<(i32, i32)> {
        let opposite = |&(x, y): &(i8, i8)| {
            let (x, y) = (i32::from(x), i32::from(y));
            [(64 + x, 64 + y), (64 - x, 64 - y)]
        };
        PAIRS.iter().flat_map(opposite).take(count).collect()
    }

    #[test]
    fn every_count_fills_every_box_once() {
        for m in 1..=6 {
            let n = 1 << m;
            for columns in (0..=m).map(|bits| 1 << bits) {
                let rows = n / columns;
                let boxes: HashSet<(i32, i32)> = places(n as usize)
                    .into_iter()
                    .map(|(x, y)| (x * columns / 128, y * rows / 128))
                    .collect();
                assert_eq!(boxes.len(), n as usize, "{columns} x {rows} boxes");
            }
        }
    }

    #[test]
    fn counts_are_the_powers_of_two_up_to_64() {
        let known: Vec<u32> = (0..=200).filter(|&n| Samples::new(n).is_some()).collect();
        assert_eq!(known, [1, 2, 4, 8, 16, 32, 64]);
        assert_eq!(Samples::MAX.refined(Samples::MAX), None);
        assert_eq!(Samples::ONE.refined(Samples::MAX), Samples::new(2));
    }

    #[test]
    fn means_are_rounded_to_the_nearest_and_halves_up() {
        let sum = |pixels: &[u32]| pixels.iter().map(|&p| spread(p)).sum();
        assert_eq!(mean(sum(&[0xff_0001, 0xfe_0100]), 2), 0xff_0101);
        assert_eq!(mean(sum(&[1, 0, 0, 0]), 4), 0);
        assert_eq!(mean(sum(&[0xff_ffff; 64]), 64), 0xff_ffff);
    }

    /// A few triangles seen from above, with many edges.
    fn soup() -> (World, View) {
        let mut r = Random::new(5);
        let triangles = (0..20).map(|_| {
            let p = r.point();
            Triangle {
                corners: [p, p + r.point() * 0.6, p + r.point() * 0.6],
                color: Rgb::new(255, 160, 40),
            }
        });
        let world = World::compile(&Scene {
            camera: CameraSetting::Default,
            light: glam::Vec3::new(0.3, 0.2, -1.0),
            triangles: triangles.collect(),
            operations: Vec::new(),
        });
        let view = Camera::default_for(world.bounds()).view(70, 40, false);
        (world, view)
    }

    #[test]
    fn refining_step_by_step_gives_the_bits_of_all_at_once() {
        let (world, view) = soup();
        let renderers = [1, 3].map(|n| Renderer::new(n).expect("threads"));
        let take = |refinement: &mut Refinement, renderer: &Renderer, samples| {
            let mut frame = Frame::default();
            refinement
                .picture(
                    renderer,
                    &world,
                    &view,
                    &Settings::default(),
                    samples,
                    &mut frame,
                    &Progress::new(),
                )
                .expect("nobody cancels");
            frame
        };
        let mut step_by_step = Refinement::default();
        let mut samples = Samples::ONE;
        let mut seen = vec![take(&mut step_by_step, &renderers[0], samples)];
        while let Some(finer) = samples.refined(Samples::MAX) {
            samples = finer;
            let refined = take(&mut step_by_step, &renderers[0], samples);
            let at_once = take(&mut Refinement::default(), &renderers[1], samples);
            assert!(refined == at_once, "{samples:?}");
            assert!(!seen.contains(&refined), "{samples:?} changes nothing");
            seen.push(refined);
        }
        step_by_step.restart();
        assert!(take(&mut step_by_step, &renderers[0], Samples(2)) == seen[1]);
    }

    #[test]
    fn every_sample_is_the_picture_of_a_camera_moved_by_a_part_of_a_pixel() {
        let (world, view) = soup();
        let renderer = Renderer::new(1).expect("a thread");
        let picture = |view: &View| {
            let mut frame = Frame::default();
            let settings = Settings::default();
            renderer
                .picture(&world, view, &settings, &mut frame, &Progress::new())
                .expect("nobody cancels");
            frame.pixels
        };
        let both = [0, 1].map(|i| picture(&view_of_sample(&view, i)));
        let mut frame = Frame::default();
        Refinement::default()
            .picture(
                &renderer,
                &world,
                &view,
                &Settings::default(),
                Samples(2),
                &mut frame,
                &Progress::new(),
            )
            .expect("nobody cancels");
        for (i, &pixel) in frame.pixels.iter().enumerate() {
            for shift in [0, 8, 16] {
                let channel = |p: u32| p >> shift & 0xff;
                let [a, b] = [channel(both[0][i]), channel(both[1][i])];
                assert_eq!(channel(pixel), (a + b).div_ceil(2), "pixel {i}");
            }
        }
    }
}
