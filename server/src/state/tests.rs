use std::fs;
use std::ops::Deref;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use baudbot_recording::journal::{Entries, Ports, Settings};
use baudbot_sim::{Scenario, World};
use tokio::sync::Semaphore;

use super::files::WorldFiles;
use super::shared::Shared;
use super::storage::System;
use super::threads::Threads;
use super::work::Work;
use super::{Found, StateFolder};

/// A file of a world, and what is in it.
type Entry<'a> = (&'a str, &'a [u8]);

const WANDER: &str = include_str!("../../../catalogue/scenarios/wander.toml");

/// The folder `lab` in one of a test's own, which goes with it.
struct Lab(PathBuf);

impl Deref for Lab {
    type Target = Path;

    fn deref(&self) -> &Path {
        &self.0
    }
}

impl Drop for Lab {
    fn drop(&mut self) {
        let _ = self.0.parent().map(fs::remove_dir_all);
    }
}

fn place(test: &str) -> Lab {
    let path = std::env::temp_dir().join(format!("baudbot-state-{}-{test}", std::process::id()));
    let _ = fs::remove_dir_all(&path);
    Lab(path.join("lab"))
}

/// A journal, or a snapshot, of a world that has not begun.
fn journal() -> Vec<u8> {
    let world = World::new(Arc::<Scenario>::new(baudbot_scenario::parse(WANDER).unwrap()));
    let made = Arc::clone(world.origin());
    Entries::beginning("alice", &world, &made, &Settings::default(), &Ports::default()).take()
}

fn make(folder: &Path, files: &[Entry<'_>]) {
    fs::create_dir_all(folder).unwrap();
    for (name, bytes) in files {
        fs::write(folder.join(name), bytes).unwrap();
    }
}

fn names(folder: &Path) -> Vec<String> {
    let names = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<_> = names.collect();
    names.sort();
    names
}

/// The content, as text, with paths below the folder of worlds.
fn found(lab: &Path) -> Vec<String> {
    let worlds = lab.join("worlds");
    let short = |path: &Path| path.strip_prefix(&worlds).unwrap().display().to_string();
    let told = |found: Found| match found {
        Found::World(world) => format!("{} continues", world.name),
        Found::SetAside { name, file, problem, to } => {
            format!("{name}: {} {problem} -> {}", short(&file), short(&to))
        }
        Found::Unreadable { name, file, problem } => format!("{name}: {} {problem}", short(&file)),
        Found::Ignored { path, problem } => format!("{} {problem}", short(&path)),
    };
    StateFolder::open(lab).unwrap().worlds().unwrap().into_iter().map(told).collect()
}

#[test]
fn what_was_cut_or_is_missing_is_set_aside_with_all_that_is_beside_it() {
    let whole = journal();
    let (cut, whole) = (&whole[..1000], whole.as_slice());
    let short = "alice: alice/journal-1 ends before the first state -> alice.damaged";
    let none = "alice: alice has no journal -> alice.damaged";
    let cases: [(&[Entry<'_>], &str); 9] = [
        (&[("journal-1", cut)], short),
        (&[("journal-1", &[])], short),
        (
            &[("journal-1", &[0; 5000])],
            "alice: alice/journal-1 is no journal of baudbot: its first line is missing -> alice.damaged",
        ),
        (&[("journal-1", cut), ("snapshot-1", whole)], short),
        (&[("journal-1", cut), ("notes.txt", b"keep")], short),
        (&[("snapshot-1", whole)], none),
        (&[("notes.txt", b"keep")], none),
        (&[("notes.new", b"keep")], none),
        (&[("journal-01", whole), ("journal-99999999999", whole)], none),
    ];
    for (number, (files, expected)) in cases.into_iter().enumerate() {
        let lab = place(&format!("cut-{number}"));
        make(&lab, &[("baudbot-state", b"baudbot-state 1\n")]);
        make(&lab.join("worlds/alice"), files);
        make(&lab.join("worlds/bob"), &[("journal-3", whole)]);
        assert_eq!(found(&lab), [expected, "bob continues"]);
        for (name, bytes) in files {
            assert!(fs::read(lab.join("worlds/alice.damaged").join(name)).unwrap() == *bytes, "{name}");
        }
        assert_eq!(found(&lab), ["bob continues"]);
    }
}

#[test]
fn a_world_whose_creation_was_interrupted_leaves_nothing() {
    let lab = place("interrupted");
    StateFolder::open(&lab).unwrap();
    let whole = journal();
    let worlds = lab.join("worlds");
    make(&worlds.join("empty"), &[]);
    make(&worlds.join("half"), &[("journal-1.new", &whole[..1000]), ("snapshot-2.new", &whole)]);
    make(
        &worlds.join("next"),
        &[("journal-1", &whole), ("journal-2", &whole[..1000]), ("journal-3.new", &[])],
    );
    assert_eq!(found(&lab), ["next continues"]);
    assert_eq!(names(&worlds), ["next"]);
    assert_eq!(names(&worlds.join("next")), ["journal-1", "journal-2"]);
}

#[test]
fn a_journal_whose_beginning_did_not_reach_the_disk_gives_way_to_the_one_before() {
    let whole = journal();
    let mut garbled = whole.clone();
    garbled[600] ^= 1;
    for (number, newer) in [&whole[..1000], &[], &[0; 5000][..], &garbled[..]].into_iter().enumerate() {
        let lab = place(&format!("gives-way-{number}"));
        StateFolder::open(&lab).unwrap();
        make(&lab.join("worlds/alice"), &[("journal-1", &whole), ("journal-2", newer)]);
        let found = StateFolder::open(&lab).unwrap().worlds().unwrap();
        let [Found::World(world)] = &found[..] else { panic!("{number}") };
        let note = world.note.as_deref().unwrap();
        assert!(
            note.starts_with("journal-2 ") && note.ends_with("journal-1 before it is continued"),
            "{note}"
        );
    }
}

#[test]
fn only_folders_of_deleted_worlds_are_removed() {
    let lab = place("deleted");
    StateFolder::open(&lab).unwrap();
    let worlds = lab.join("worlds");
    for name in ["alice.deleted", "alice.deleted-2", "a_B-c.deleted-17"] {
        make(&worlds.join(name), &[("journal-1", b"any")]);
    }
    let kept = [
        ".deleted",
        "alice.deleted-",
        "alice.deleted-02",
        "alice.deleted-1",
        "alice.deleted-by-mistake-keep",
        "alice.deleted.old",
        "my alice.deleted",
        "my.alice.deleted",
    ];
    for name in kept {
        make(&worlds.join(name), &[("journal-1", b"any")]);
    }
    make(&worlds, &[("bob.deleted", b"a file")]);
    assert_eq!(found(&lab), Vec::<String>::new());
    let mut left = names(&worlds);
    left.retain(|name| name != "bob.deleted");
    assert_eq!(left, kept);
    assert!(worlds.join("bob.deleted").is_file());
}

#[cfg(unix)]
#[test]
fn what_is_no_world_or_cannot_be_read_is_left_as_it_is_and_the_others_go_on() {
    use std::os::unix::fs::{PermissionsExt, symlink};

    let lab = place("stray");
    StateFolder::open(&lab).unwrap();
    let (worlds, whole) = (lab.join("worlds"), journal());
    make(&worlds.join("alice"), &[("journal-1", &whole)]);
    make(&worlds.join("my copy"), &[("journal-1", &whole)]);
    make(&worlds, &[("stray", b"keep")]);
    symlink("/nowhere/gone", worlds.join("gone")).unwrap();
    let mut expected = vec![
        "alice continues",
        "gone: gone cannot be read: No such file or directory (os error 2)",
        "my copy has a name that no world can have",
        "stray is not a folder",
    ];
    make(&worlds.join("locked"), &[("journal-1", &whole), ("journal-2.new", &whole)]);
    let journal = worlds.join("locked/journal-1");
    fs::set_permissions(&journal, fs::Permissions::from_mode(0o000)).unwrap();
    // Root can read it nonetheless.
    match fs::read(&journal) {
        Ok(_) => fs::remove_dir_all(worlds.join("locked")).unwrap(),
        Err(_) => {
            expected.insert(2, "locked: locked/journal-1 cannot be read: Permission denied (os error 13)");
        }
    }
    let before = names(&worlds);
    assert_eq!(found(&lab), expected);
    assert_eq!(names(&worlds), before);
    if worlds.join("locked").exists() {
        assert_eq!(names(&worlds.join("locked")), ["journal-1", "journal-2.new"]);
    }
}

/// The journal has no place to stay open: each write opens it.
fn shared() -> Shared {
    let (threads, places) = (Threads::start().unwrap(), Arc::new(Semaphore::new(0)));
    Shared { storage: Arc::new(System), threads, places }
}

fn begin() -> Work {
    Work::Begin { journal: journal(), tick: 0, snapshots: Vec::new(), on_disk: Arc::default() }
}

#[test]
fn under_a_name_that_is_taken_nothing_is_written_and_nothing_removed() {
    let lab = place("taken");
    let folder = lab.join("worlds/alice");
    make(&folder, &[("snapshot-1", b"one")]);
    let files = Arc::new(WorldFiles::none(folder.clone(), shared()));
    for work in [begin(), Work::Snapshot(2, journal()), Work::Forget(1), begin()] {
        files.add(work, true);
        assert!(files.is_lost());
    }
    files.append(b"more", 7);
    files.remove().unwrap();
    assert_eq!(names(&folder), ["snapshot-1"]);
    assert_eq!(fs::read(folder.join("snapshot-1")).unwrap(), b"one");
    assert_eq!((files.is_lost(), files.keeping().tick), (true, 0));
}

#[test]
fn until_its_first_journal_is_written_a_world_is_kept_as_its_server_left_it() {
    let lab = place("continued");
    let folder = lab.join("worlds/alice");
    make(&folder, &[("journal-4", &journal())]);
    let files = Arc::new(WorldFiles::new(folder.clone(), shared(), 2_030_614));
    assert_eq!(files.keeping().tick, 2_030_614);
    files.add(begin(), true);
    assert_eq!(files.keeping().tick, 0, "another run");
    let new = WorldFiles::new(folder.with_file_name("bob"), shared(), 500);
    assert_eq!(new.keeping().tick, 0, "nothing of it is on the disk");
}

#[test]
fn a_journal_replaces_nothing_and_gets_its_name_when_it_is_whole() {
    let lab = place("whole");
    let folder = lab.join("worlds/alice");
    make(&folder.join("journal-2"), &[("keep", b"any")]);
    make(&folder, &[("journal-1", &journal()), ("journal-3.new", &[7; 100_000])]);
    let files = Arc::new(WorldFiles::new(folder.clone(), shared(), 0));
    files.add(begin(), true);
    assert_eq!(names(&folder), ["journal-1", "journal-2", "journal-3"]);
    assert!(fs::read(folder.join("journal-3")).unwrap() == journal());
    files.append(b"more", 1);
    assert!(fs::read(folder.join("journal-3")).unwrap() == [journal(), b"more".to_vec()].concat());
    files.sync();
    assert_eq!(names(&folder), ["journal-2", "journal-3"]);
    assert_eq!(names(&folder.join("journal-2")), ["keep"]);
}

#[cfg(unix)]
#[test]
fn folders_and_files_are_for_this_user_only() {
    use std::os::unix::fs::PermissionsExt;

    let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
    let lab = place("modes");
    let folder = StateFolder::open(&lab).unwrap();
    let alice = lab.join("worlds/alice");
    let files = Arc::new(WorldFiles::new(alice.clone(), shared(), 0));
    files.add(begin(), true);
    files.add(Work::Snapshot(1, journal()), true);
    for path in [lab.parent().unwrap(), &lab, &folder.recordings(), alice.parent().unwrap(), &alice] {
        assert_eq!(mode(path), 0o700, "{}", path.display());
    }
    for path in [lab.join("baudbot-state"), alice.join("journal-1"), alice.join("snapshot-1")] {
        assert_eq!(mode(&path), 0o600, "{}", path.display());
    }
    let own = place("own-mode");
    fs::create_dir_all(&*own).unwrap();
    fs::set_permissions(&*own, fs::Permissions::from_mode(0o750)).unwrap();
    StateFolder::open(&own).unwrap();
    assert_eq!(mode(&own), 0o750, "a folder that was there");
}
