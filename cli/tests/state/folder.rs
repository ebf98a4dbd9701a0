//! The folder: what is kept in it, who may use it, and what is done about damage.

use std::fs;
use std::process::Command;
use std::time::{Duration, Instant};

use baudbot_proto::v1::{WorldState, WorldStatus};

use crate::state::brains::drive;
use crate::state::operator::{lockstep, real_time, stepped};
use crate::state::server::Server;
use crate::state::{WANDER, crowd, place, text};

#[test]
fn a_world_is_there_again_with_all_that_an_operator_has_done() {
    let folder = place("operator");
    let server = Server::start(&folder, "operator", &["wander", "--pace", "lockstep", "--paused"]);
    let mut operator = server.operator();
    operator.create("made", WANDER, (stepped(), false), &["seed=7"]).unwrap();
    operator.start("made").unwrap();
    operator.step("made", 50).unwrap();
    let snapshot = operator.snapshot("made").unwrap();
    let kept = operator.status("made").unwrap();
    operator.step("made", 10).unwrap();
    operator.clone_world("made", "clone").unwrap();
    operator.clone_world("made", "gone").unwrap();
    operator.delete("gone").unwrap();
    let reset = operator.reset("made", 9).unwrap();
    operator.put("made", (0.3, 0.2, 1.0)).unwrap();
    operator.put("made", (0.3, 0.1, 1.0)).unwrap();
    operator.set_pace("clone", real_time()).unwrap();
    operator.start("clone").unwrap();
    operator.pause("clone").unwrap();
    // A change in a world that follows the clock is on its way to the disk.
    std::thread::sleep(Duration::from_secs(1));
    let before = ["clone", "made", "wander"].map(|name| operator.status(name).unwrap());
    server.kill();

    let server = Server::start(&folder, "operator", &["wander", "--pace", "lockstep"]);
    let log = server.log();
    assert!(
        log.contains(
            "note: world wander continues from its stored state; scenario wander is not started again\n"
        ),
        "{log}"
    );
    let mut operator = server.operator();
    assert_eq!(operator.worlds(), ["clone", "made", "wander"]);
    for before in before {
        let after = operator.status(&before.world).unwrap();
        let told = |status: &WorldStatus| (status.tick, status.state_hash, status.state, status.pace);
        assert_eq!(told(&after), told(&before), "{}", before.world);
    }
    // The world can be changed by hand again, goes back to its snapshot, and a reset is one of the world as it was
    // made.
    operator.put("made", (0.2, 0.1, 1.0)).unwrap();
    let restored = operator.restore("made", snapshot).unwrap();
    assert_eq!((restored.tick, restored.state_hash), (kept.tick, kept.state_hash));
    assert_eq!(operator.reset("made", 9).unwrap().state_hash, reset.state_hash);
    assert_eq!(operator.snapshot("made").unwrap(), snapshot + 1);
}

#[test]
fn a_recording_goes_on_in_another_file() {
    let folder = place("recorded");
    let server = Server::start(&folder, "recorded", &["wander"]);
    let mut operator = server.operator();
    operator.record("wander", "run").unwrap();
    operator.wait_until("wander", |status| status.tick > 120);
    server.kill();
    let server = Server::start(&folder, "recorded", &[]);
    let mut operator = server.operator();
    let status = operator.wait_until("wander", |status| status.tick > 300);
    assert_eq!(status.recording.unwrap().recording, "run-2");
    server.signal("-TERM");
    assert_eq!(server.end().0, Some(0));
    for (file, code) in [("run", 3), ("run-2", 0)] {
        let file = folder.join(format!("recordings/{file}.mcap"));
        let replayed =
            Command::new(env!("CARGO_BIN_EXE_baudbot")).args(["replay", text(&file)]).output().unwrap();
        let out = String::from_utf8(replayed.stdout).unwrap();
        assert_eq!(replayed.status.code(), Some(code), "{out}");
        assert!(out.contains("identical"), "{out}");
    }
}

#[test]
fn a_second_server_is_refused_and_a_folder_of_something_else() {
    let folder = place("locked");
    let server = Server::start(&folder, "locked", &["wander"]);
    let refused = |folder: &std::path::Path| {
        let args = ["serve", "--listen", "127.0.0.1:0", "--viewer", "off", "--state", text(folder)];
        let output = Command::new(env!("CARGO_BIN_EXE_baudbot")).args(args).output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    let path = folder.display();
    let words = "another server keeps its state there; stop that one, or choose another folder";
    assert_eq!(refused(&folder), (Some(2), format!("error: --state {path}: {words}\n")));
    server.kill();
    let other = place("other");
    fs::create_dir_all(&other).unwrap();
    fs::write(other.join("thesis.txt"), "chapter one").unwrap();
    let (code, err) = refused(&other);
    assert_eq!(code, Some(2), "{err}");
    assert!(err.contains("is not empty, and not the folder of a server's state"), "{err}");
    fs::remove_file(other.join("thesis.txt")).unwrap();
    fs::write(other.join("baudbot-state"), "baudbot-state 99\n").unwrap();
    let (code, err) = refused(&other);
    assert!(code == Some(2) && err.contains("its layout is `baudbot-state 99`"), "{err}");
}

#[test]
fn a_damaged_world_is_set_aside_and_the_others_go_on() {
    let folder = place("damaged");
    let server = Server::start(&folder, "damaged", &["wander", "khepera", "--paused"]);
    server.signal("-TERM");
    assert_eq!(server.end().0, Some(0));
    let journal = folder.join("worlds/wander/journal-1");
    let mut bytes = fs::read(&journal).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&journal, bytes).unwrap();
    let server = Server::start(&folder, "damaged", &["wander", "--paused"]);
    let (log, aside) = (server.log(), folder.join("worlds/wander.damaged"));
    let (journal, shown) = (journal.display(), aside.display());
    assert!(
        log.contains(&format!("warning: world wander does not continue: {journal} is damaged at byte ")),
        "{log}"
    );
    assert!(log.contains(&format!("; its folder is set aside as {shown}\n")), "{log}");
    assert!(aside.join("journal-1").is_file());
    // The scenario of the command line begins anew.
    assert_eq!(server.operator().worlds(), ["khepera", "wander"]);
    server.kill();
    let server = Server::start(&folder, "damaged", &[]);
    assert!(!server.log().contains("warning"), "{}", server.log());
    assert_eq!(server.operator().worlds(), ["khepera", "wander"]);
}

#[test]
fn a_torn_tail_is_cut_and_the_world_goes_on() {
    let folder = place("torn");
    let server = Server::start(&folder, "torn", &[]);
    let mut operator = server.operator();
    operator.create("w", WANDER, (stepped(), false), &[]).unwrap();
    operator.start("w").unwrap();
    let mut seen = vec![operator.status("w").unwrap()];
    for _ in 0..20 {
        seen.push(operator.step("w", 10).unwrap());
    }
    server.kill();
    let journal = folder.join("worlds/w/journal-1");
    let whole = fs::read(&journal).unwrap();
    let garbage = |length: usize| (0..length).map(|i| (i * 7919 % 251) as u8 + 1);
    let tails: [(&str, Vec<u8>, bool); 4] = [
        ("zeros behind it", [whole.clone(), vec![0; 4096]].concat(), true),
        ("garbage behind it", whole.iter().copied().chain(garbage(64)).collect(), true),
        ("zeros at its end", [&whole[..whole.len() - 300], &[0; 300]].concat(), false),
        ("a block that stands twice", [&whole[..], &whole[whole.len() - 512..]].concat(), true),
    ];
    for (what, torn, has_all) in tails {
        fs::remove_dir_all(folder.join("worlds/w")).unwrap();
        fs::create_dir(folder.join("worlds/w")).unwrap();
        fs::write(&journal, torn).unwrap();
        let server = Server::start(&folder, "torn", &[]);
        let log = server.log();
        assert!(log.contains("are an unfinished write and are left out"), "{what}: {log}");
        let mut operator = server.operator();
        let status = operator.status("w").unwrap();
        let last = seen.last().unwrap();
        assert!(!has_all || status.tick == last.tick, "{what}: {}", status.tick);
        let same = |seen: &&WorldStatus| seen.tick == status.tick;
        if let Some(seen) = seen.iter().find(same) {
            assert_eq!(seen.state_hash, status.state_hash, "{what}");
        }
        assert_eq!(operator.step("w", 10).unwrap().tick, status.tick + 10, "{what}");
        server.kill();
    }
}

#[test]
fn what_is_sound_of_a_damaged_world_is_recovered() {
    let folder = place("recovered");
    let server = Server::start(&folder, "recovered", &[]);
    let mut operator = server.operator();
    for world in ["w", "sound"] {
        operator.create(world, WANDER, (stepped(), false), &[]).unwrap();
        operator.start(world).unwrap();
        operator.step(world, 30).unwrap();
    }
    let snapshot = operator.snapshot("w").unwrap();
    let seen = operator.step("w", 1).unwrap();
    let early = fs::metadata(folder.join("worlds/w/journal-1")).unwrap().len() as usize;
    operator.step("w", 10).unwrap();
    // The changes before are known to be on the disk.
    std::thread::sleep(Duration::from_millis(2500));
    operator.step("w", 10).unwrap();
    server.kill();
    let journal = folder.join("worlds/w/journal-1");
    let mut bytes = fs::read(&journal).unwrap();
    bytes[early + 2] ^= 1;
    fs::write(&journal, bytes).unwrap();
    let baudbot = |args: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_baudbot")).args(args).output().unwrap();
        let said = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap()).concat();
        (output.status.code(), said)
    };
    let (code, said) = baudbot(&["state", "check", text(&folder)]);
    let expected = format!("w: damaged: {} is damaged at byte {early}\n", journal.display());
    assert!(code == Some(1) && said.contains(&expected), "{said}");
    assert!(said.contains("sound: sound, at tick 30, "), "{said}");
    let server = Server::start(&folder, "recovered", &[]);
    assert!(server.log().contains("its folder is set aside as"), "{}", server.log());
    server.kill();
    let (code, said) = baudbot(&["state", "recover", text(&folder), "w"]);
    assert!(code == Some(0) && said.starts_with("world w can be continued at tick 31, "), "{said}");
    assert!(said.contains("are left out"), "{said}");
    let (code, said) = baudbot(&["state", "recover", text(&folder), "w"]);
    assert!(code == Some(2) && said.contains("--as NAME"), "{said}");
    let (code, said) = baudbot(&["state", "recover", text(&folder), "sound"]);
    assert!(code == Some(2) && said.contains("there is nothing to recover"), "{said}");
    let server = Server::start(&folder, "recovered", &[]);
    let mut operator = server.operator();
    let after = operator.status("w").unwrap();
    assert_eq!((after.tick, after.state_hash), (seen.tick, seen.state_hash));
    assert_eq!(operator.restore("w", snapshot).unwrap().tick, 30);
    assert!(folder.join("worlds/w.damaged/journal-1").is_file());
}

#[test]
fn a_world_whose_journal_was_cut_is_set_aside_with_its_snapshots() {
    let folder = place("cut");
    let server = Server::start(&folder, "cut", &["wander", "khepera", "--paused"]);
    let mut operator = server.operator();
    operator.snapshot("wander").unwrap();
    operator.snapshot("khepera").unwrap();
    server.signal("-TERM");
    assert_eq!(server.end().0, Some(0));
    let journal = folder.join("worlds/wander/journal-1");
    fs::File::options().write(true).open(&journal).unwrap().set_len(1000).unwrap();
    let khepera = folder.join("worlds/khepera");
    fs::remove_file(khepera.join("journal-1")).unwrap();
    fs::write(khepera.join("notes.txt"), "keep").unwrap();
    let server = Server::start(&folder, "cut", &["wander", "--paused"]);
    let log = server.log();
    for (world, what) in [
        ("wander", format!("{} ends before the first state", journal.display())),
        ("khepera", format!("{} has no journal", khepera.display())),
    ] {
        let aside = folder.join(format!("worlds/{world}.damaged"));
        let words = format!(
            "warning: world {world} does not continue: {what}; its folder is set aside as {}\n",
            aside.display()
        );
        assert!(log.contains(&words), "{words}{log}");
        assert!(aside.join("snapshot-1").is_file());
    }
    assert!(folder.join("worlds/wander.damaged/journal-1").is_file());
    assert!(folder.join("worlds/khepera.damaged/notes.txt").is_file());
    assert_eq!(server.operator().worlds(), ["wander"]);
}

#[test]
fn what_is_no_world_or_cannot_be_read_stops_no_server_and_stays_as_it_is() {
    let folder = place("stray");
    let server = Server::start(&folder, "stray", &["wander", "--paused"]);
    server.signal("-TERM");
    assert_eq!(server.end().0, Some(0));
    let worlds = folder.join("worlds");
    let (stray, gone) = (worlds.join("stray"), worlds.join("gone"));
    fs::write(&stray, "keep").unwrap();
    std::os::unix::fs::symlink("/nowhere/gone", &gone).unwrap();
    let server = Server::start(&folder, "stray", &[]);
    let log = server.log();
    let ignored = format!(
        "warning: {} is not a folder and is ignored; move it to a place outside the folder of --state\n",
        stray.display()
    );
    assert!(log.contains(&ignored), "{log}");
    let unreadable = format!(
        "warning: world gone does not continue: {} cannot be read: No such file or directory (os error 2); it is left unchanged, and a \
         new world gone is not stored: give this user read and write access to its folder, and start the server again\n",
        gone.display()
    );
    assert!(log.contains(&unreadable), "{log}");
    let mut operator = server.operator();
    assert_eq!(operator.worlds(), ["wander"]);
    // Worlds of these names are not kept, and what is there is not theirs.
    for name in ["gone", "stray"] {
        operator.create(name, WANDER, (stepped(), false), &[]).unwrap();
        operator.start(name).unwrap();
        assert_eq!(operator.step(name, 5).unwrap().tick, 5);
        operator.delete(name).unwrap();
    }
    assert!(server.log().contains("state not stored; the world continues"), "{}", server.log());
    assert_eq!(fs::read_to_string(&stray).unwrap(), "keep");
    assert!(gone.is_symlink());
    assert_eq!(fs::read_dir(&worlds).unwrap().count(), 3);
}

#[test]
fn a_world_that_continues_stays_paused_if_that_is_wanted() {
    let folder = place("paused");
    let server = Server::start(&folder, "paused", &["wander", "--set", "collision=stop-robot"]);
    server.operator().wait_until("wander", |status| status.tick > 20);
    server.signal("-TERM");
    assert_eq!(server.end().0, Some(0));
    // The world stays as it was without the option.
    for args in [&["wander", "--paused"][..], &[]] {
        let server = Server::start(&folder, "paused", args);
        let mut operator = server.operator();
        let before = operator.status("wander").unwrap();
        assert_eq!(before.state(), WorldState::Paused, "{args:?}");
        std::thread::sleep(Duration::from_millis(300));
        let after = operator.status("wander").unwrap();
        assert_eq!((after.tick, after.state_hash), (before.tick, before.state_hash));
        server.signal("-TERM");
        assert_eq!(server.end().0, Some(0));
    }
    let server = Server::start(&folder, "paused", &["wander"]);
    let mut operator = server.operator();
    let tick = operator.start("wander").unwrap().tick;
    operator.wait_until("wander", |status| status.tick > tick + 20);
}

#[test]
fn a_long_journal_is_replaced_by_a_new_one() {
    let folder = place("long");
    let server = Server::start(&folder, "long", &[]);
    let mut operator = server.operator();
    operator.create("crowd", &crowd(8), (lockstep(), false), &[]).unwrap();
    let names: Vec<_> = (0..8).map(|i| format!("r{i:02}")).collect();
    let _lines = drive(&server.address, "crowd", &names.iter().map(String::as_str).collect::<Vec<_>>());
    let first = folder.join("worlds/crowd/journal-1");
    assert!(first.exists());
    let start = Instant::now();
    while first.exists() {
        assert!(start.elapsed() < Duration::from_secs(50), "tick {}", operator.status("crowd").unwrap().tick);
        std::thread::sleep(Duration::from_millis(100));
    }
    let files = fs::read_dir(folder.join("worlds/crowd")).unwrap();
    let bytes: u64 = files.map(|file| file.unwrap().metadata().unwrap().len()).sum();
    assert!(bytes < 12 << 20, "{bytes} bytes");
    let seen = operator.status("crowd").unwrap().tick;
    server.kill();
    let server = Server::start(&folder, "long", &[]);
    assert!(!server.log().contains("warning"), "{}", server.log());
    assert!(server.operator().status("crowd").unwrap().tick >= seen);
}

#[test]
fn robots_that_were_excused_are_not_waited_for() {
    let folder = place("excused");
    let server = Server::start(&folder, "excused", &["wander"]);
    let mut operator = server.operator();
    operator.create("free", WANDER, (lockstep(), false), &["collision=stop-robot"]).unwrap();
    operator.start("free").unwrap();
    let seen = operator.wait_until("free", |status| status.tick > 100).tick;
    server.kill();
    let server = Server::start(&folder, "excused", &[]);
    server.operator().wait_until("free", |status| status.tick > seen + 100);
}
