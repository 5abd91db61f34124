use glam::{DVec3, Vec3};

use super::*;
use crate::app::moves::Moves;
use crate::scene::Axis;

fn ground() -> Ground {
    Ground {
        path: "scene.txt".into(),
        camera: CameraSetting::Default,
        operations: Vec::new(),
        bounds: Aabb::EMPTY,
        triangles: 5,
    }
}

/// The state of a hand that made so many turns.
fn kept(turns: u32) -> Kept {
    let mut moves = Moves::default();
    for i in 0..turns {
        let axis = [Axis::X, Axis::Z][(i % 2) as usize];
        moves.turn(axis, f64::from(i + 1));
        moves.end();
    }
    Kept {
        own_operations: 0,
        camera: CameraSetting::Default,
        base: Camera::default_for(Aabb::EMPTY),
        list: moves.list().clone(),
        frame: u64::from(turns) * 10,
    }
}

fn journal(folder: &Path) -> Journal {
    let mut journal = Journal::new(Some(folder.to_owned()));
    journal.open(Some(ground()));
    journal
}

fn note(journal: &mut Journal, turns: u32) {
    let noted = journal.note(u64::from(turns), || (turns > 0).then(|| kept(turns)));
    noted.expect("written");
}

fn find(journal: &mut Journal) -> Option<Kept> {
    journal.find(|words| panic!("{words}"))
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder").flatten();
    entries
        .map(|e| e.file_name().to_string_lossy().into_owned())
        .collect()
}

#[test]
fn what_a_window_leaves_is_found_by_the_next_one_and_goes_on() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut first = journal(folder.path());
    assert_eq!(find(&mut first), None);
    for turns in 1..=4 {
        note(&mut first, turns);
    }
    assert_eq!(find(&mut journal(folder.path())), None, "it is in use");
    // A program that ends leaves its locks.
    drop(first);
    let mut second = journal(folder.path());
    assert_eq!(find(&mut second), Some(kept(4)));
    assert_eq!(
        find(&mut journal(folder.path())),
        None,
        "it is being offered"
    );
    second.adopt();
    note(&mut second, 2);
    drop(second);
    let mut third = journal(folder.path());
    assert_eq!(find(&mut third), Some(kept(2)));
    third.adopt();
    third.forget();
    assert_eq!(names(folder.path()), [""; 0]);
}

#[test]
fn nothing_is_written_where_there_is_nothing_to_lose() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut journal = journal(folder.path());
    note(&mut journal, 0);
    assert_eq!(names(folder.path()), [""; 0]);
    note(&mut journal, 1);
    assert_eq!(names(folder.path()).len(), 1);
    note(&mut journal, 0);
    assert_eq!(names(folder.path()), [""; 0]);
    note(&mut journal, 3);
    journal.open(None);
    assert_eq!(names(folder.path()), [""; 0], "another scene");
    let mut off = Journal::new(None);
    off.open(Some(ground()));
    note(&mut off, 1);
    assert_eq!(find(&mut off), None);
}

#[test]
fn several_windows_keep_their_own_and_what_is_dropped_makes_room_for_the_next() {
    let folder = tempfile::tempdir().expect("a folder");
    let [mut a, mut b] = [journal(folder.path()), journal(folder.path())];
    note(&mut a, 1);
    note(&mut b, 2);
    assert_eq!(names(folder.path()).len(), 2);
    drop((a, b));
    let mut c = journal(folder.path());
    let first = find(&mut c).expect("one");
    c.drop_offered();
    let second = find(&mut c).expect("the other");
    assert_ne!(first, second);
    c.put_off();
    assert_eq!(find(&mut c), Some(second));
    c.drop_offered();
    assert_eq!(find(&mut c), None);
}

#[test]
fn another_scene_has_other_moves_and_a_saved_one_takes_them_along() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut first = journal(folder.path());
    note(&mut first, 1);
    let operations = vec![Operation {
        axis: Axis::Y,
        angle_rad: 0.5,
    }];
    let saved = ground().saved(Path::new("scene.txt"), CameraSetting::Default, operations);
    first.set_ground(Some(saved.clone()));
    note(&mut first, 3);
    assert_eq!(names(folder.path()).len(), 1);
    drop(first);
    let mut second = journal(folder.path());
    assert_eq!(find(&mut second), None);
    second.open(Some(saved));
    assert_eq!(find(&mut second), Some(kept(3)));
    second.drop_offered();
    let others = [
        Ground {
            path: "b.txt".into(),
            ..ground()
        },
        Ground {
            triangles: 6,
            ..ground()
        },
        Ground {
            bounds: Aabb {
                min: Vec3::ZERO,
                max: Vec3::ONE,
            },
            ..ground()
        },
    ];
    for other in others {
        assert_ne!(other.key(), ground().key(), "{other:?}");
    }
}

#[test]
fn a_line_that_was_cut_off_does_not_count_and_a_damaged_journal_is_put_aside() {
    let folder = tempfile::tempdir().expect("a folder");
    let whole = {
        let mut first = journal(folder.path());
        note(&mut first, 1);
        note(&mut first, 2);
        let name = &names(folder.path())[0];
        fs::read(folder.path().join(name)).expect("a journal")
    };
    let name = names(folder.path()).remove(0);
    let path = folder.path().join(name);
    let lines = whole.iter().filter(|b| **b == b'\n').count();
    assert_eq!(lines, 3);
    fs::write(&path, &whole[..whole.len() - 1]).expect("written");
    let mut second = journal(folder.path());
    assert_eq!(find(&mut second), Some(kept(1)));
    second.adopt();
    note(&mut second, 5);
    drop(second);
    let mut third = journal(folder.path());
    assert_eq!(
        find(&mut third),
        Some(kept(5)),
        "after the line that was cut off"
    );
    drop(third);
    for at in [0, 20, whole.len() - 3] {
        let mut damaged = whole.clone();
        damaged[at] ^= 4;
        fs::write(&path, &damaged).expect("written");
        let mut words = Vec::new();
        let found = journal(folder.path()).find(|line| words.push(line.to_owned()));
        assert_eq!(found, None, "byte {at}");
        assert!(words[0].contains(".damaged"), "{words:?}");
        assert!(!path.exists());
    }
    for text in [&b""[..], b"\n", b"\xff\n", b"raybomb moves 1 0 d\n"] {
        fs::write(&path, text).expect("written");
        let mut words = 0;
        assert_eq!(journal(folder.path()).find(|_| words += 1), None);
        assert_eq!(words, 1);
    }
}

#[test]
fn a_folder_that_takes_nothing_is_told_once() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("file");
    fs::write(&file, "").expect("written");
    let mut journal = journal(&file.join("moves"));
    assert!(journal.note(1, || Some(kept(1))).is_err());
    assert!(journal.note(2, || Some(kept(2))).is_ok());
}

#[test]
fn cameras_of_files_and_of_hands_come_back_to_the_bit() {
    let corners = CameraCorners {
        eye: Vec3::new(0.1, -6.0, 1e-7),
        top_left: Vec3::new(-4.0, -2.0, 3.3),
        top_right: Vec3::new(4.0, -2.0, 3.3),
        bottom_left: Vec3::new(-4.0, -2.0, -3.1),
    };
    let mut moves = Moves::default();
    let base = Camera::from(corners);
    let motion = |p: DVec3| p + DVec3::new(1.0 / 3.0, 0.1, 0.0);
    assert!(moves.bake(base, glam::DMat3::IDENTITY, DVec3::ZERO, motion));
    moves.end();
    let kept = Kept {
        own_operations: 2,
        camera: CameraSetting::Set(corners),
        base,
        list: moves.list().clone(),
        frame: u64::MAX,
    };
    let text = kept.head() + &kept.line(&List::default());
    assert_eq!(Kept::of_text(&text), Some((kept, text.len())));
}
