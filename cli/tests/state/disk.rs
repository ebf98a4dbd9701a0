//! A disk that is full, by a limit of the system's on the length of files.

use std::process::Command;
use std::time::{Duration, Instant};

use baudbot_proto::v1::WorldStatus;

use crate::state::operator::stepped;
use crate::state::server::Server;
use crate::state::{WANDER, place};

/// The program, in which a file that is too long is an error as on a full disk. Its log goes through a program that has no limit.
fn program() -> Command {
    let mut command = Command::new("bash");
    let program = env!("CARGO_BIN_EXE_baudbot");
    command.args(["-c", &format!("trap '' XFSZ; exec {program} \"$@\" 2> >(exec cat >&2)"), "baudbot"]);
    command
}

/// Limits the files of this process to so many bytes from now on.
fn limit(server: &Server, bytes: &str) {
    let limit = format!("--fsize={bytes}:unlimited");
    let done = Command::new("prlimit").args(["--pid", &server.id().to_string(), &limit]).status().unwrap();
    assert!(done.success());
}

fn wait_for(server: &Server, words: &str) {
    let start = Instant::now();
    while !server.log().contains(words) {
        assert!(start.elapsed() < Duration::from_secs(30), "no `{words}` in {}", server.log());
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn a_full_disk_stops_no_world_and_when_there_is_room_again_the_state_is_kept_again() {
    let folder = place("full");
    let server = Server::start_by(program(), &folder, "full", &["wander"]);
    let mut operator = server.operator();
    operator.create("made", WANDER, (stepped(), false), &[]).unwrap();
    operator.start("made").unwrap();
    let kept = operator.step("made", 20).unwrap();
    operator.record("wander", "run").unwrap();
    let told = |status: &WorldStatus| (status.tick, status.state_hash);

    limit(&server, "0");
    let lost = operator.step("made", 20).unwrap();
    assert_eq!(lost.tick, 40, "the world goes on");
    let tick = operator.status("wander").unwrap().tick;
    let status = operator.wait_until("wander", |status| status.tick > tick + 100);
    assert!(status.recording.unwrap().problem.contains("too large"), "the recording says so");
    // Nothing can be made of what is not there, but a world.
    operator.create("born", WANDER, (stepped(), true), &[]).unwrap();

    limit(&server, "unlimited");
    wait_for(&server, "state stored again");
    let born = operator.wait_until("born", |_| true);
    // Worlds attempt that by themselves.
    std::thread::sleep(Duration::from_secs(3));
    let after = operator.step("made", 5).unwrap();
    server.kill();
    let server = Server::start(&folder, "full", &[]);
    let mut operator = server.operator();
    assert_eq!(told(&operator.status("made").unwrap()), told(&after));
    assert_eq!(told(&operator.status("born").unwrap()), told(&born));
    assert!(operator.status("wander").unwrap().tick >= tick);
    drop(kept);
}

#[test]
fn what_was_kept_before_a_disk_was_full_is_there_again() {
    let folder = place("full-then-killed");
    let server = Server::start_by(program(), &folder, "full-then-killed", &["wander", "--paused"]);
    let mut operator = server.operator();
    operator.create("made", WANDER, (stepped(), false), &[]).unwrap();
    operator.start("made").unwrap();
    let kept = operator.step("made", 20).unwrap();
    limit(&server, "0");
    operator.step("made", 20).unwrap();
    server.kill();
    let server = Server::start(&folder, "full-then-killed", &[]);
    assert!(!server.log().contains("warning"), "{}", server.log());
    let after = server.operator().status("made").unwrap();
    assert_eq!((after.tick, after.state_hash), (kept.tick, kept.state_hash));
}

#[test]
fn a_restart_on_a_full_disk_says_up_to_where_the_state_is_kept() {
    let folder = place("full-at-start");
    let server = Server::start(&folder, "full-at-start", &["wander", "--paused"]);
    let mut operator = server.operator();
    operator.create("made", WANDER, (stepped(), false), &[]).unwrap();
    operator.start("made").unwrap();
    let kept = operator.step("made", 20).unwrap();
    server.kill();
    let mut full = Command::new("bash");
    let program = env!("CARGO_BIN_EXE_baudbot");
    let script = format!("trap '' XFSZ; exec 2> >(exec cat >&2); ulimit -f 0; exec {program} \"$@\"");
    full.args(["-c", &script, "baudbot"]);
    // The server has no token, which would have to be written, too.
    let server = Server::start_by(full, &folder, "full-at-start", &["--open"]);
    assert_eq!(server.operator().status("made").unwrap().tick, 20);
    wait_for(&server, "kept_tick=20");
    server.kill();
    let server = Server::start(&folder, "full-at-start", &[]);
    let after = server.operator().status("made").unwrap();
    assert_eq!((after.tick, after.state_hash), (kept.tick, kept.state_hash));
}
