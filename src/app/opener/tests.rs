use super::*;
use std::sync::mpsc::{Receiver, channel};

const GOOD: &str = "<d 0 0 -1 0";

fn opener(path: &Path) -> (Opener, Receiver<Heard>) {
    let (send, receive) = channel();
    let tell = move |heard| {
        let _ = send.send(heard);
    };
    let mut opener = Opener::new(Source::File(path.into()), 1, tell);
    opener.begin().expect("a thread");
    (opener, receive)
}

#[test]
fn the_better_tree_follows_the_coarse_one_and_is_void_when_another_load_begins() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("a.txt");
    let triangle = "0 0 0 1 0 0 0 1 0 9 9 9 ";
    let text = "<d 0 0 -1 50000 ".to_owned() + &triangle.repeat(50_000);
    std::fs::write(&file, text).expect("written");
    let (mut opener, heard) = opener(&file);
    let first = outcome(&mut opener, &heard);
    assert!(matches!(first, Outcome::Show { .. }), "{first:?}");
    assert!(opener.is_improving() && !opener.is_loading());
    let tree = opener.improvement().expect("a coarse one");
    assert_eq!(
        (&*tree.name, &*tree.text),
        ("tree", "coarse; better one 0 %")
    );
    let second = outcome(&mut opener, &heard);
    assert!(matches!(second, Outcome::Better(_)), "{second:?}");
    assert!(!opener.is_improving() && opener.improvement().is_none());
    opener.begin().expect("a thread");
    outcome(&mut opener, &heard);
    std::fs::write(&file, GOOD).expect("written");
    opener.begin().expect("a thread");
    let mut small = outcome(&mut opener, &heard);
    if matches!(small, Outcome::Better(_)) {
        // That of the scene on screen was quicker.
        small = outcome(&mut opener, &heard);
    }
    assert!(matches!(small, Outcome::Show { .. }), "{small:?}");
    assert!(!opener.is_improving());
}

#[test]
fn after_a_cancelled_load_and_a_bad_file_the_scene_on_screen_is_watched_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let [file, other, bad] = ["a.txt", "b.txt", "c.txt"].map(|name| folder.path().join(name));
    for (path, text) in [(&file, GOOD), (&other, GOOD), (&bad, "<d 0")] {
        std::fs::write(path, text).expect("written");
    }
    let (mut opener, heard) = opener(&file);
    outcome(&mut opener, &heard);
    let is_shown_again = |opener: &mut Opener| {
        assert_eq!(opener.name(), file.display().to_string());
        let again = outcome(opener, &heard);
        assert!(
            matches!(again, Outcome::Show { again: true, .. }),
            "{again:?}"
        );
    };
    opener.open(Source::File(other.clone())).expect("a thread");
    assert!(opener.cancel() && !opener.is_loading());
    std::fs::write(&file, "<d 0 0 -1 0 # after").expect("written");
    is_shown_again(&mut opener);
    opener.open(Source::File(other)).expect("a thread");
    std::fs::write(&file, "<d 0 0 -1 0 # meanwhile").expect("written");
    assert!(opener.cancel());
    is_shown_again(&mut opener);
    opener.open(Source::File(bad)).expect("a thread");
    let kept = outcome(&mut opener, &heard);
    assert!(matches!(kept, Outcome::Kept(_)), "{kept:?}");
    assert!(opener.dismiss());
    std::fs::write(&file, GOOD).expect("written");
    is_shown_again(&mut opener);
}

/// Goes on until something follows for the window.
fn outcome(opener: &mut Opener, heard: &Receiver<Heard>) -> Outcome {
    let start = Instant::now();
    loop {
        assert!(start.elapsed() < Duration::from_secs(20), "no outcome");
        opener.tick(Instant::now()).expect("a thread");
        if let Ok(heard) = heard.recv_timeout(Duration::from_millis(20))
            && let Some(outcome) = opener.hear(heard, Instant::now())
        {
            return outcome;
        }
    }
}

#[test]
fn a_bad_save_keeps_the_scene_and_shows_the_error_until_the_file_is_good_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("a.txt");
    std::fs::write(&file, GOOD).expect("written");
    let (mut opener, heard) = opener(&file);
    let first = outcome(&mut opener, &heard);
    assert!(
        matches!(first, Outcome::Show { again: false, .. }),
        "{first:?}"
    );
    std::fs::write(&file, "<d 0 0 x 0").expect("written");
    let kept = outcome(&mut opener, &heard);
    assert!(matches!(kept, Outcome::Kept(_)), "{kept:?}");
    let board = opener.board(Instant::now()).expect("an error");
    assert!(board[0].text.contains("a.txt:1:8: expected"), "{board:?}");
    assert!(
        board.iter().any(|line| line.text.contains('^')),
        "{board:?}"
    );
    std::fs::write(&file, GOOD).expect("written");
    let again = outcome(&mut opener, &heard);
    assert!(
        matches!(again, Outcome::Show { again: true, .. }),
        "{again:?}"
    );
    assert_eq!(opener.board(Instant::now()), None);
    std::fs::write(&file, "<d 0").expect("written");
    outcome(&mut opener, &heard);
    assert!(opener.board(Instant::now()).is_some());
    assert!(opener.dismiss() && !opener.dismiss());
    assert_eq!(opener.board(Instant::now()), None);
}

#[test]
fn what_we_save_ourselves_is_not_loaded_and_what_others_save_is() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("a.txt");
    std::fs::write(&file, GOOD).expect("written");
    let (mut opener, heard) = opener(&file);
    outcome(&mut opener, &heard);
    let path = folder.path().join("b.txt");
    let text = b"<d 0 0 -1 0 # ours".to_vec();
    std::fs::write(&path, &text).expect("written");
    opener.begin_saving();
    opener.end_saving(Some(Saved {
        path: path.clone(),
        text: text.clone(),
        from: Stamp::of(&Source::File(file)),
    }));
    assert_eq!(opener.name(), path.display().to_string());
    // Known again after a text that is no scene.
    for text in [&b"<d 0 0"[..], &text] {
        std::fs::write(&path, text).expect("written");
        let start = Instant::now();
        while opener.error.is_some() == (text.len() > 10) {
            assert!(start.elapsed() < Duration::from_secs(20), "no change");
            opener.tick(Instant::now()).expect("a thread");
            if let Ok(heard) = heard.recv_timeout(Duration::from_millis(20)) {
                let outcome = opener.hear(heard, Instant::now());
                assert!(!matches!(outcome, Some(Outcome::Show { .. })));
            }
        }
    }
    std::fs::write(&path, GOOD).expect("written");
    let again = outcome(&mut opener, &heard);
    assert!(
        matches!(again, Outcome::Show { again: true, .. }),
        "{again:?}"
    );
}

#[test]
fn a_save_while_another_file_is_loaded_is_known_when_that_is_cancelled() {
    let folder = tempfile::tempdir().expect("a folder");
    let [file, other, new] = ["a.txt", "b.txt", "c.txt"].map(|name| folder.path().join(name));
    for path in [&file, &other] {
        std::fs::write(path, GOOD).expect("written");
    }
    let (mut opener, heard) = opener(&file);
    outcome(&mut opener, &heard);
    let save = |opener: &mut Opener, path: &PathBuf| {
        opener.open(Source::File(other.clone())).expect("a thread");
        opener.begin_saving();
        let from = Stamp::of(&Source::File(file.clone()));
        let text = format!("{GOOD} # {}", path.display()).into_bytes();
        std::fs::write(path, &text).expect("written");
        let path = path.clone();
        opener.end_saving(Some(Saved { path, text, from }));
        assert_eq!(opener.name(), other.display().to_string());
    };
    save(&mut opener, &file);
    assert_eq!(opener.shown_name(), file.display().to_string());
    assert!(opener.cancel());
    assert_eq!(opener.reload_at, None);
    // Under a new name that is the scene's own from then on.
    save(&mut opener, &new);
    assert!(opener.cancel());
    assert_eq!(opener.name(), new.display().to_string());
    assert_eq!(opener.reload_at, None);
    // Changed by another program in between.
    opener.open(Source::File(other.clone())).expect("a thread");
    opener.begin_saving();
    let (path, text) = (new.clone(), GOOD.into());
    std::fs::write(&path, GOOD).expect("written");
    let from = None;
    opener.end_saving(Some(Saved { path, text, from }));
    assert!(opener.cancel());
    let again = outcome(&mut opener, &heard);
    assert!(
        matches!(again, Outcome::Show { again: true, .. }),
        "{again:?}"
    );
}

#[test]
fn who_cancels_a_load_a_moment_too_late_is_known() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("a.txt");
    std::fs::write(&file, GOOD).expect("written");
    let (mut opener, heard) = opener(&file);
    let load = |opener: &mut Opener, ms| {
        let end = opener.loading.expect("a load").since + Duration::from_millis(ms);
        loop {
            let told = heard.recv_timeout(Duration::from_secs(20)).expect("a load");
            if opener.hear(told, end).is_some() {
                return end;
            }
        }
    };
    let end = load(&mut opener, 900);
    assert!(!opener.was_just_loading(end), "it would have quit");
    opener.begin().expect("a thread");
    let end = load(&mut opener, 100);
    assert!(!opener.was_just_loading(end), "nobody was told");
    opener.begin().expect("a thread");
    let end = load(&mut opener, 200);
    assert!(opener.was_just_loading(end + Duration::from_millis(499)));
    assert!(!opener.was_just_loading(end + Duration::from_millis(500)));
}

#[test]
fn what_another_program_changed_just_before_a_save_is_loaded() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("a.txt");
    std::fs::write(&file, GOOD).expect("written");
    let (mut opener, heard) = opener(&file);
    outcome(&mut opener, &heard);
    opener.begin_saving();
    let theirs = format!("{GOOD} # theirs");
    std::fs::write(&file, &theirs).expect("written");
    let from = Stamp::of(opener.source());
    let text = (theirs + " with moves").into_bytes();
    std::fs::write(&file, &text).expect("written");
    let path = file.clone();
    opener.end_saving(Some(Saved { path, text, from }));
    let again = outcome(&mut opener, &heard);
    assert!(
        matches!(again, Outcome::Show { again: true, .. }),
        "{again:?}"
    );
}

#[test]
fn without_any_scene_an_error_is_the_end() {
    let (mut opener, heard) = opener(Path::new("there/is/none.txt"));
    assert!(!opener.cancel(), "nothing else to show");
    let end = outcome(&mut opener, &heard);
    assert!(
        matches!(end, Outcome::Fatal(LoadError::Unreadable(_))),
        "{end:?}"
    );
}

#[test]
fn a_load_that_takes_long_is_told_and_can_be_cancelled() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("a.txt");
    std::fs::write(&file, GOOD).expect("written");
    let (mut opener, heard) = opener(&file);
    let start = Instant::now();
    let later = start + Duration::from_millis(1950);
    assert!(
        opener.board(later).expect("progress")[1]
            .text
            .ends_with("1.9 s")
    );
    assert!(opener.wake(later).is_some_and(|at| at <= later + TICK));
    outcome(&mut opener, &heard);
    assert_eq!(opener.wake(Instant::now()), None);
    opener.begin().expect("a thread");
    assert!(opener.cancel());
    // All that the load still says; whether it comes to its end is a race.
    while let Ok(heard) = heard.recv_timeout(Duration::from_millis(200)) {
        assert!(opener.hear(heard, Instant::now()).is_none());
    }
    assert_eq!(opener.board(later), None);
}

#[test]
fn neighbours_go_round_by_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    assert_eq!(neighbour(&path("b.txt"), true), None);
    for name in ["a.txt", "b.txt", "c.TXT", "d.png"] {
        std::fs::write(path(name), "").expect("written");
    }
    std::fs::create_dir(path("e.txt")).expect("made");
    assert_eq!(neighbour(&path("b.txt"), true), Some(path("c.TXT")));
    assert_eq!(neighbour(&path("c.TXT"), true), Some(path("a.txt")));
    assert_eq!(neighbour(&path("a.txt"), false), Some(path("c.TXT")));
    // The file itself may be gone.
    assert_eq!(neighbour(&path("bb.txt"), false), Some(path("b.txt")));
    assert_eq!(neighbour(Path::new("none/a.txt"), true), None);
}

#[test]
fn the_neighbours_of_a_demo_are_the_other_demos() {
    let all = demo::all();
    let neighbour = |at: usize, forward| {
        let opener = Opener::new(Source::Demo(&all[at]), 1, |_| {});
        match opener.neighbour(forward) {
            Some(Source::Demo(demo)) => demo.name,
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(neighbour(0, true), all[1].name);
    assert_eq!(neighbour(0, false), all[all.len() - 1].name);
    assert_eq!(neighbour(all.len() - 1, true), all[0].name);
}
