//! A server that ends in good order.

use std::process::Command;
use std::time::Duration;

use crate::state::brains::drive;
use crate::state::operator::{lockstep, real_time};
use crate::state::server::Server;
use crate::state::{WANDER, place};

#[test]
fn a_server_that_is_told_to_stop_marks_all_and_tells_its_brains() {
    let folder = place("stopped");
    let server = Server::start(&folder, "stopped", &["wander", "--set", "collision=stop-robot"]);
    let mut operator = server.operator();
    operator.create("locked", WANDER, (lockstep(), false), &["collision=stop-robot"]).unwrap();
    operator.record("wander", "run").unwrap();
    let lines = drive(&server.address, "locked", &["robot"]);
    operator.wait_until("locked", |status| status.tick > 200);
    let seen = operator.wait_until("wander", |status| status.tick > 100).tick;
    server.signal("-TERM");
    let (code, log, took) = server.end();
    assert_eq!(code, Some(0), "{log}");
    assert!(took < Duration::from_secs(8), "{took:?}");
    assert_eq!(lines.recv().unwrap(), "driving robot of world locked");
    let lost = lines.recv_timeout(Duration::from_secs(10)).unwrap();
    assert!(lost.contains("world `locked` is over, as its server stops"), "{lost}");

    let server = Server::start(&folder, "stopped", &[]);
    let mut operator = server.operator();
    // Nothing of a world that follows the clock is lost either.
    let after = operator.status("wander").unwrap();
    assert!(after.tick >= seen, "{} < {seen}", after.tick);
    let tick = operator.status("locked").unwrap().tick;
    operator.wait_until("locked", |status| status.tick > tick + 100);
    let back = lines.recv_timeout(Duration::from_secs(10)).unwrap();
    assert_eq!(back, "reconnected with a restarted brain: driving robot of world locked");
}

#[test]
fn a_server_whose_disk_hangs_ends_nonetheless_with_words_and_another_code() {
    let folder = place("hanging");
    let server = Server::start(&folder, "hanging", &["wander", "--stop-within", "1"]);
    let mut operator = server.operator();
    operator.create("other", WANDER, (real_time(), false), &["collision=stop-robot"]).unwrap();
    // A pipe without a reader stands for a disk that does not answer.
    let pipe = folder.join("worlds/other/snapshot-1.new");
    while !pipe.parent().unwrap().exists() {
        std::thread::sleep(Duration::from_millis(10));
    }
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    operator.snapshot("other").unwrap();
    operator.wait_until("other", |status| status.tick > 20);
    server.signal("-TERM");
    let (code, log, took) = server.end();
    assert_eq!(code, Some(1), "{log}");
    assert!(
        log.contains("error: not everything has ended within 1 s (--stop-within)")
            && log.contains("changes of other since"),
        "{log}"
    );
    assert!(took < Duration::from_secs(6), "{took:?}: {log}");
    let server = Server::start(&folder, "hanging", &[]);
    assert_eq!(server.operator().worlds(), ["other", "wander"]);
}
