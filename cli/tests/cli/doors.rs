//! The doors of the program: every socket that it opens is one of the table in `docs/reference/trust.md`.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use crate::cli::{Running, command, place};

const TRUST: &str = include_str!("../../../docs/reference/trust.md");

/// The doors, each with the command that opens it here.
const DOORS: [(&str, &str); 10] = [
    ("gRPC over TCP", "serve"),
    ("gRPC over a Unix socket", "serve"),
    ("trainers", "serve"),
    ("the page and its metrics", "serve"),
    ("brains that are programs", "run"),
    ("a brain that `conform` examines", "conform"),
    ("a serial port: socket, RFC 2217", "serve"),
    ("a serial port: pseudo-terminal, Unix socket", "serve"),
    ("a debugger", "gdb"),
    ("Foxglove", "foxglove"),
];

/// The sockets at which a process listens: addresses and paths.
fn listening(process: u32) -> Vec<String> {
    let links = fs::read_dir(format!("/proc/{process}/fd")).unwrap();
    let links = links.filter_map(|entry| fs::read_link(entry.ok()?.path()).ok());
    let number = |link: &Path| Some(link.to_str()?.strip_prefix("socket:[")?.strip_suffix(']')?.to_owned());
    let own: Vec<_> = links.filter_map(|link| number(&link)).collect();
    let list = |file: &str| fs::read_to_string(format!("/proc/{process}/net/{file}")).unwrap_or_default();
    let mut found = Vec::new();
    for line in list("tcp").lines().chain(list("tcp6").lines()) {
        let fields: Vec<_> = line.split_whitespace().collect();
        if fields.get(3) == Some(&"0A") && own.iter().any(|own| own == fields[9]) {
            let (host, port) = fields[1].split_once(':').unwrap();
            assert_eq!(host, "0100007F", "this test opens doors of this machine only");
            found.push(format!("127.0.0.1:{}", u16::from_str_radix(port, 16).unwrap()));
        }
    }
    for line in list("unix").lines() {
        let fields: Vec<_> = line.split_whitespace().collect();
        if fields.get(3) == Some(&"00010000") && own.iter().any(|own| own == fields[6]) {
            found.push(fields.get(7).copied().unwrap_or("without a name").to_owned());
        }
    }
    found.sort();
    found
}

/// Waits until so many sockets are there, and a moment longer, in case that there are more.
fn settled(process: u32, count: usize) -> Vec<String> {
    let begun = Instant::now();
    while listening(process).len() < count {
        assert!(begun.elapsed() < Duration::from_secs(60), "{:?}", listening(process));
        std::thread::sleep(Duration::from_millis(20));
    }
    std::thread::sleep(Duration::from_millis(200));
    listening(process)
}

#[test]
fn every_socket_that_the_program_opens_is_a_door_of_the_table() {
    let table = TRUST.split("\n## Doors\n").nth(1).unwrap().split("\n## ").next().unwrap();
    let rows = table.lines().filter(|line| line.starts_with("| ")).skip(1);
    let named: Vec<_> = rows.map(|row| row.split('|').nth(1).unwrap().trim()).collect();
    assert_eq!(named, DOORS.map(|(door, _)| door), "the table and this test have the same doors");

    let file = |name: &str| place(&format!("doors-{name}")).display().to_string();
    let (socket, serial, pty) = (file("grpc"), file("serial"), file("pty"));
    let [unix, tcp, rfc, by_pty] = [
        format!("robot=unix:{serial}"),
        "robot=tcp:0".to_owned(),
        "robot=rfc2217:0".to_owned(),
        format!("robot=pty:{pty}"),
    ];
    let listen = format!("unix:{socket}");
    let mut server = Running::start(&[
        "serve",
        "wander",
        "--listen",
        "127.0.0.1:0",
        "--listen",
        &listen,
        "--viewer",
        "127.0.0.1:0",
        "--trainer",
        "127.0.0.1:0",
        "--port",
        &unix,
        "--port",
        &tcp,
        "--port",
        &rfc,
        "--port",
        &by_pty,
    ]);
    let told = server.lines_until("Ctrl-C stops");
    // gRPC by TCP and by a Unix socket, trainers, the page, and three serial ports; a pseudo-terminal is no socket.
    let doors = settled(server.0.id(), 7);
    assert_eq!(doors.len(), 7, "{doors:?}, {told:?}");
    assert_eq!(doors.iter().filter(|door| door.starts_with("127.0.0.1:")).count(), 5, "{doors:?}");
    assert!(doors.contains(&socket) && doors.contains(&serial), "{doors:?}");
    let address = told[0].strip_prefix("listening on ").unwrap().to_owned();

    let debugged = Running(
        command(&["run", "firmware", "--gdb", "robot=0", "--listen", "127.0.0.1:0", "--viewer", "off"])
            .spawn()
            .unwrap(),
    );
    let doors = settled(debugged.0.id(), 1);
    assert!(doors.len() <= 2 && doors.iter().all(|door| door.starts_with("127.0.0.1:")), "{doors:?}");

    let brain = "exec:sleep 60";
    let run = Running(command(&["run", "wander", "--brain", brain, "--seconds", "60"]).spawn().unwrap());
    are_private(&settled(run.0.id(), 1), 1);
    let grading = ["grade", "wander", "--brain", brain, "--jobs", "1", "--quiet"];
    let grading = Running(command(&grading).spawn().unwrap());
    are_private(&settled(grading.0.id(), 1), 1);
    // Its first run is alone; others go on side by side, each with a socket of its own.
    let kit = Running(command(&["conform", brain, "--patience", "60", "--quiet"]).spawn().unwrap());
    are_private(&settled(kit.0.id(), 1), 1);
    let outside = Running(
        command(&["conform", "--external", "127.0.0.1:0", "--patience", "60", "--quiet"]).spawn().unwrap(),
    );
    let doors = settled(outside.0.id(), 1);
    assert!(doors.len() == 1 && doors[0].starts_with("127.0.0.1:"), "{doors:?}");
    let refused = command(&["conform", "--external", "0.0.0.0:0"]).output().unwrap();
    let words = String::from_utf8(refused.stderr).unwrap();
    assert!(
        refused.status.code() == Some(2) && words.contains("must be an address of this machine"),
        "{words}"
    );

    let foxglove =
        Running(command(&["watch", "--foxglove=127.0.0.1:0", "--connect", &address]).spawn().unwrap());
    let doors = settled(foxglove.0.id(), 1);
    assert!(doors.len() == 1 && doors[0].starts_with("127.0.0.1:"), "{doors:?}");
}

/// So many sockets, each in a folder of its own that only this user may enter.
fn are_private(doors: &[String], count: usize) {
    assert_eq!(doors.len(), count, "{doors:?}");
    for door in doors {
        assert!(door.starts_with('/'), "{doors:?}");
        let folder = Path::new(door).parent().unwrap();
        let mode = Command::new("stat").args(["-c", "%a"]).arg(folder).output().unwrap();
        assert_eq!(String::from_utf8(mode.stdout).unwrap().trim(), "700", "{doors:?}");
    }
}

/// The files of the program in which something listens: a new one is a new door, which belongs into the table.
const LISTENERS: [&str; 6] = [
    "cli/src/foxglove/bridge.rs",
    "crates/conform/src/kit.rs",
    "crates/port/src/debug/server.rs",
    "crates/port/src/socket.rs",
    "server/src/server/listeners.rs",
    "crates/bench/src/network/ping.rs",
];

#[test]
fn nothing_listens_in_the_sources_but_the_doors_of_the_table() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut found = Vec::new();
    for around in ["", "crates", "viewer"] {
        for name in fs::read_dir(root.join(around)).unwrap().map(|entry| entry.unwrap().file_name()) {
            look(&root, &Path::new(around).join(&name).join("src"), &mut found);
        }
    }
    found.sort();
    let mut expected = LISTENERS;
    expected.sort_unstable();
    assert_eq!(found, expected);
}

/// The calls that make a program listen.
const LISTEN: [&str; 3] = ["TcpListener::bind(", "UnixListener::bind(", "server.bind("];

fn look(root: &Path, folder: &Path, found: &mut Vec<String>) {
    let Ok(entries) = fs::read_dir(root.join(folder)) else { return };
    for entry in entries.map(Result::unwrap) {
        let path = folder.join(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            look(root, &path, found);
        } else if path.extension().is_some_and(|end| end == "rs") {
            let text = fs::read_to_string(root.join(&path)).unwrap();
            // Tests are at the end of files.
            let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
            if code.lines().any(|line| LISTEN.iter().any(|word| line.contains(word))) {
                found.push(path.display().to_string());
            }
        }
    }
}
