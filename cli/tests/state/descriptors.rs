//! A server that may have few files open.

use std::process::Command;

use crate::state::operator::stepped;
use crate::state::server::Server;
use crate::state::{WANDER, place};

#[test]
fn a_server_with_few_files_lets_everybody_in_and_keeps_all_worlds() {
    let folder = place("few-files");
    let mut few = Command::new("bash");
    let program = env!("CARGO_BIN_EXE_baudbot");
    few.args(["-c", &format!("ulimit -n 96; exec {program} \"$@\""), "baudbot"]);
    let server = Server::start_by(few, &folder, "few-files", &["wander", "--paused"]);
    let mut operator = server.operator();
    let mut seen = Vec::new();
    for number in 0..120 {
        let name = format!("w{number}");
        operator.create(&name, WANDER, (stepped(), false), &[]).unwrap();
        operator.start(&name).unwrap();
        seen.push(operator.step(&name, 3).unwrap());
    }
    // A new client finds a place, and the journals of all worlds can be written.
    for (before, number) in seen.iter_mut().zip(0..120) {
        let mut late = server.operator();
        *before = late.step(&format!("w{number}"), 2).unwrap();
        assert_eq!(before.tick, 5);
    }
    assert!(!server.log().contains("state not stored"), "{}", server.log());
    server.kill();
    let server = Server::start(&folder, "few-files", &[]);
    let mut operator = server.operator();
    for before in seen {
        let after = operator.status(&before.world).unwrap();
        assert_eq!((after.tick, after.state_hash), (before.tick, before.state_hash), "{}", before.world);
    }
}
