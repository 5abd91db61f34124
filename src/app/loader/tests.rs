use super::*;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

const CAMERA: &str = "<s 0 0 5 -1.6 0.9 3 1.6 0.9 3 -1.6 -0.9 3";

fn text(text: &str) -> Source {
    Source::Text {
        name: "it".into(),
        text: Arc::new(text.into()),
    }
}

fn start(loader: &mut Loader, source: Source) -> Receiver<(u64, Told)> {
    let (send, receive) = channel();
    let tell = move |number, told| {
        let _ = send.send((number, told));
    };
    loader.start(source, None, tell).expect("a thread");
    receive
}

fn done(told: &Receiver<(u64, Told)>) -> (u64, Result<Box<Loaded>, LoadError>) {
    loop {
        match told.recv_timeout(Duration::from_secs(20)).expect("an end") {
            (number, Told::Done(done)) => return (number, done),
            (_, Told::At(_) | Told::Known | Told::Improving(_) | Told::Better(_)) => {}
        }
    }
}

#[test]
fn a_scene_comes_with_its_stages_and_its_world() {
    let mut loader = Loader::new(1);
    let scene = format!("{CAMERA} 0 0 -1 1 0 0 0 1 0 0 0 1 0 9 9 9 <o 1 <x 0.5");
    let told = start(&mut loader, text(&scene));
    let stages: Vec<String> = std::iter::from_fn(|| match told.recv() {
        Ok((_, Told::At(stage))) => Some(stage.to_string()),
        Ok((number, Told::Done(Ok(loaded)))) => {
            assert!(loader.is_wanted(number));
            assert_eq!(loaded.operations.len(), 1);
            assert_eq!(loaded.world.triangle_count(), 1);
            None
        }
        other => panic!("{other:?}"),
    })
    .collect();
    assert_eq!(
        stages,
        [
            "parsing 0.0 MB, 0 %",
            "building a tree of 1 triangles, 0 %",
            "building a tree of 1 triangles, 100 %"
        ]
    );
}

/// The picture of a world, by the fast engine.
fn picture(world: &World, base: Camera) -> crate::frame::Frame {
    let mut frame = crate::frame::Frame::default();
    crate::render::Renderer::new(1)
        .expect("a thread")
        .picture(
            world,
            &base.view(160, 90, false),
            &crate::render::Settings::default(),
            &mut frame,
            &crate::render::Progress::new(),
        )
        .expect("nobody cancels");
    frame
}

#[test]
fn a_large_scene_comes_with_a_coarse_tree_and_then_with_a_better_one_of_the_same_picture() {
    let mut random = crate::math::Random::new(3);
    let mut scene = format!("{CAMERA} 0.3 -1 -1 {LARGE}");
    for _ in 0..LARGE {
        let p = random.point();
        for corner in [p, p + random.point() * 0.1, p + random.point() * 0.1] {
            scene += &format!(" {} {} {}", corner.x, corner.y, corner.z);
        }
        scene += " 250 200 90";
    }
    let mut loader = Loader::new(2);
    let told = start(&mut loader, text(&scene));
    let (_, loaded) = done(&told);
    let loaded = loaded.expect("a scene");
    assert!(loaded.is_coarse);
    let mut percents = Vec::new();
    let (number, better) = loop {
        match told.recv() {
            Ok((_, Told::Improving(percent))) => percents.push(percent),
            Ok((number, Told::Better(better))) => break (number, better),
            other => panic!("no better tree: {other:?}"),
        }
    };
    assert!(!percents.is_empty() && percents.is_sorted(), "{percents:?}");
    assert!(loader.is_wanted(number) && told.recv().is_err());
    let cost = |world: &World| world.bvh_stats().sah_cost;
    assert!(cost(&better) < cost(&loaded.world));
    let shown = picture(&loaded.world, loaded.base);
    assert!(shown.pixels.iter().any(|&p| p != 0));
    assert!(shown == picture(&better, loaded.base));
}

#[test]
fn a_large_file_is_read_whole_and_tells_how_far_it_is() {
    let file = tempfile::NamedTempFile::new().expect("a file");
    let bytes: Vec<u8> = (0..40 << 20).map(|i: u32| i as u8).collect();
    fs::write(file.path(), &bytes).expect("written");
    let told = std::sync::Mutex::new(Vec::new());
    let tell = |done: usize, of: usize| told.lock().expect("no panic").push((done >> 20, of >> 20));
    let text = read(file.path(), Watch::of(&tell)).expect("nobody cancels");
    assert!(text.expect("read") == bytes);
    let told = told.into_inner().expect("no panic");
    assert_eq!(told, [(16, 40), (32, 40), (40, 40)]);
}

#[test]
fn parsing_tells_how_far_it_is() {
    let triangle = "0 0 0 1 0 0 0 1 0 1 2 3\n";
    let scene = format!("<d 0 0 -1 20000\n{}", triangle.repeat(20_000));
    let stages = std::sync::Mutex::new(Vec::new());
    let at = |stage: Stage| stages.lock().expect("no panic").push(stage.to_string());
    let parsed = text(&scene).parse(None, &at, &AtomicBool::new(false));
    assert_eq!(parsed.expect("a scene").triangles.len(), 20_000);
    let stages = stages.into_inner().expect("no panic");
    assert!(stages.len() > 1 && stages.len() <= 101, "{stages:?}");
    assert_eq!(stages[0], "parsing 0.5 MB, 0 %");
    let first = stages[1].strip_prefix("parsing 0.5 MB, ");
    assert!(first.is_some() && stages[1] != stages[0], "{stages:?}");
}

#[test]
fn percentages_grow_and_come_now_and_then() {
    let percent = Percent::default();
    let start = Instant::now();
    let at = |done: usize, ms: u64| percent.news_at(done, 200, start + Duration::from_millis(ms));
    assert_eq!([at(0, 0), at(1, 0), at(2, 0)], [None, None, Some(1)]);
    assert_eq!([at(2, 500), at(1, 500), at(5, 99)], [None; 3]);
    assert_eq!(
        [at(4, 100), at(180, 199), at(200, 200)],
        [Some(2), None, Some(100)]
    );
    assert_eq!(at(300, 900), None);
    assert_eq!(Percent::default().news(7, 0), Some(100));
}

#[test]
fn a_bad_text_is_told_with_its_place_and_a_missing_file_with_its_name() {
    let mut loader = Loader::new(1);
    let (_, bad) = done(&start(&mut loader, text("<d\n0 0 -1\n1\nx")));
    let words = bad.expect_err("not a scene").to_string();
    assert!(words.starts_with("it:4:1: expected"), "{words}");
    assert!(words.contains('^'), "{words}");
    let missing = Source::File("there/is/none.txt".into());
    let (_, missing) = done(&start(&mut loader, missing));
    let words = missing.expect_err("no file").to_string();
    assert_eq!(words, "cannot read there/is/none.txt: no such file");
}

#[test]
fn a_text_that_is_known_is_not_loaded() {
    let mut loader = Loader::new(1);
    let scene = format!("{CAMERA} 0 0 -1 0");
    for (known, is_loaded) in [(scene.clone(), false), (scene.clone() + " ", true)] {
        let (send, receive) = channel();
        let tell = move |_, told| {
            let _ = send.send(told);
        };
        let known = Some(Arc::new(known.into_bytes()));
        loader.start(text(&scene), known, tell).expect("a thread");
        let last = receive.iter().last();
        assert_eq!(matches!(last, Some(Told::Known)), !is_loaded, "{last:?}");
        assert_eq!(matches!(last, Some(Told::Done(Ok(_)))), is_loaded);
    }
}

#[test]
fn only_the_newest_load_counts_and_none_after_a_cancel() {
    let mut loader = Loader::new(1);
    let first = start(&mut loader, text(CAMERA));
    let second = start(&mut loader, text(CAMERA));
    let (number, _) = done(&second);
    assert!(loader.is_wanted(number));
    loader.cancel();
    assert!(!loader.is_wanted(number));
    for (number, _) in first.iter().chain(second.try_iter()) {
        assert!(!loader.is_wanted(number));
    }
}

#[test]
fn a_load_that_is_cancelled_at_any_stage_ends_there() {
    let is_at: [fn(&Told) -> bool; 5] = [
        |told| matches!(told, Told::At(Stage::Reading(_))),
        |told| matches!(told, Told::At(Stage::Parsing(..))),
        |told| matches!(told, Told::At(Stage::Parsing(_, 1..))),
        |told| matches!(told, Told::At(Stage::Building(_, 0))),
        |told| matches!(told, Told::At(Stage::Building(_, 1..))),
    ];
    let file = tempfile::NamedTempFile::new().expect("a file");
    let mut scene = String::from("<d 0 0 -1 90000\n");
    for i in 0..90_000 {
        let (x, y) = (i % 300, i / 300);
        scene += &format!("{x} {y} 0 {x}.5 {y} 0 {x} {y}.5 0 1 2 3\n");
    }
    fs::write(file.path(), scene).expect("written");
    for (stage, is_at) in is_at.into_iter().enumerate() {
        for threads in [1, 2] {
            let cancelled = AtomicBool::new(false);
            let told = std::sync::Mutex::new(Vec::new());
            let tell = |news: Told| {
                if is_at(&news) {
                    cancelled.store(true, Ordering::Relaxed);
                }
                told.lock().expect("no panic").push(news);
            };
            let source = Source::File(file.path().into());
            let end = load(&source, None, threads, &cancelled, &tell);
            assert!(matches!(end, Err(End::Cancelled)), "{stage}: {end:?}");
            let told = told.into_inner().expect("no panic");
            // What the other thread has begun it may tell.
            let later = told.iter().skip_while(|news| !is_at(news)).count();
            assert!((1..=2).contains(&later), "{stage}: {told:?}");
        }
    }
}

#[test]
fn the_better_tree_of_the_scene_on_screen_is_built_until_another_one_is_shown() {
    let mut loader = Loader::new(1);
    let first = start(&mut loader, text(CAMERA));
    let (first, _) = done(&first);
    loader.show();
    let second = start(&mut loader, text(CAMERA));
    assert!(loader.is_wanted(first));
    let (second, _) = done(&second);
    assert!(loader.is_wanted(first) && loader.is_wanted(second));
    loader.cancel();
    assert!(loader.is_wanted(first) && !loader.is_wanted(second));
    let third = start(&mut loader, text(CAMERA));
    let (third, _) = done(&third);
    loader.show();
    assert!(!loader.is_wanted(first) && loader.is_wanted(third));
}

#[test]
fn the_head_of_a_text_tells_the_size_of_its_picture() {
    let size = |s: &str| text(s).default_size();
    assert_eq!(
        size(&format!("# a\n{CAMERA} 0 0 -1 7 .. ")),
        Some((853, 480))
    );
    let apart = CAMERA.replace("<s", "< S").replace("0 5", "0 5 # eye\n");
    assert_eq!(size(&apart), Some((853, 480)));
    assert_eq!(size("<d 0 0 -1 0"), None);
    assert_eq!(size("<s 1 2"), None);
    assert_eq!(size(""), None);
}
