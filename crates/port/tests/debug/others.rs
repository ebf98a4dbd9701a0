//! Programs of other users, which are no debuggers.

use std::os::unix::fs::MetadataExt;
use std::os::unix::process::CommandExt;
use std::process::Command;

use super::client::Client;
use super::running::Running;

/// Another user, `nobody` on all systems, whose programs are refused.
const NOBODY: u32 = 65534;

#[test]
fn a_program_of_another_user_is_sent_away_and_the_users_own_is_let_in() {
    // Only root can take the identity of another user. `./test strangers` does it as root, too.
    if std::fs::metadata("/proc/self").map_or(1, |own| own.uid()) != 0 {
        return;
    }
    let running = Running::start(&[0xcfff]);
    // The attacker asks why the chip stands, and writes to the static memory.
    let attack = format!(
        "exec 3<>/dev/tcp/127.0.0.1/{} && printf '$?#3f$M800100,2:beef#a5' >&3; timeout 5 cat <&3 | wc -c",
        running.address.port()
    );
    for _ in 0..3 {
        let mut other = Command::new("bash");
        let output = other.args(["-c", &attack]).uid(NOBODY).gid(NOBODY).output().unwrap();
        let answer = String::from_utf8(output.stdout).unwrap();
        assert_eq!(answer.trim(), "0", "{}", String::from_utf8_lossy(&output.stderr));
    }
    let mut own = Client::connect(running.address);
    assert_eq!(own.ask("m800100,2"), "0000", "nobody else has written");
}
