//! The attacks of others on the program: connections without end, and files at which it could wait for ever.

use std::net::TcpStream;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use super::{Running, baudbot, command, place, said};

/// A server that may have so many files open, and more only if it asks for it; and where it listens.
fn serve(soft: u32, hard: u32) -> (Running, String) {
    let limited = format!("ulimit -Sn {soft} && ulimit -Hn {hard} && exec \"$0\" \"$@\"");
    let mut server = Command::new("sh");
    server.args([
        "-c",
        &limited,
        env!("CARGO_BIN_EXE_baudbot"),
        "serve",
        "--listen",
        "127.0.0.1:0",
        "--viewer",
        "off",
    ]);
    let server = server.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut server = Running(server);
    let line = server.lines_until("listening on ").pop().unwrap();
    let address = line.strip_prefix("listening on ").unwrap().to_owned();
    (server, address)
}

#[test]
fn connections_that_say_nothing_lock_nobody_out_of_a_server_with_few_descriptors() {
    let (server, address) = serve(64, 64);
    let silent: Vec<_> = (0..200).map(|_| TcpStream::connect(&address).unwrap()).collect();
    let (code, out, err) = baudbot(&["watch", "--connect", &address, "--once"]);
    assert_eq!((code, err.as_str()), (0, ""), "{out}");
    drop(silent);
    server.signal("-TERM");
    assert_eq!(server.end().0, 0);
}

#[cfg(target_os = "linux")]
#[test]
fn a_server_takes_all_descriptors_that_it_may_have() {
    let (server, _) = serve(64, 128);
    let limits = std::fs::read_to_string(format!("/proc/{}/limits", server.0.id())).unwrap();
    let files = limits.lines().find(|line| line.starts_with("Max open files")).unwrap();
    let numbers: Vec<_> = files.split_whitespace().filter_map(|word| word.parse::<u32>().ok()).collect();
    assert_eq!(numbers, [128, 128], "{files}");
}

/// A FIFO of this name without a writer.
fn fifo(name: &str) -> String {
    let path = place(name).to_str().unwrap().to_owned();
    assert!(Command::new("mkfifo").arg(&path).status().unwrap().success());
    path
}

#[test]
fn no_command_waits_for_ever_at_a_pipe_into_which_nobody_writes() {
    let path = fifo("silent.toml");
    let nobody = "is a pipe that no program writes to";
    let commands: [(&[&str], &str); 9] = [
        (&["check", &path], nobody),
        (&["run", &path], nobody),
        (&["budget", &path], nobody),
        (&["diagram", &path], nobody),
        (&["sweep", &path], nobody),
        (&["replay", &path], "is not a file"),
        (&["export", &path], "is not a file"),
        (&["serve", "--listen", "127.0.0.1:0", "--resume", &path], "is not a file"),
        (&["run", "--brain", &path], "is not a file"),
    ];
    let running = commands.map(|(args, words)| (args, words, Running::start(args)));
    for (args, words, running) in running {
        let (code, _, err) = running.end();
        assert_eq!(code, 2, "{args:?}: {err}");
        assert!(err.contains(&path) && err.contains(words), "{args:?}: {err}");
    }
}

#[test]
fn a_scenario_may_come_through_a_pipe() {
    let path = fifo("told.toml");
    let scenario = concat!(env!("CARGO_MANIFEST_DIR"), "/../catalogue/scenarios/wander.toml");
    // The command waits for a reader, for as long as that takes.
    let mut told = Command::new("sh").args(["-c", "cat \"$0\" > \"$1\"", scenario, &path]).spawn().unwrap();
    let (code, out, err) = Running::start(&["check", &path]).end();
    assert!(told.wait().unwrap().success());
    assert_eq!((code, err.as_str()), (0, ""));
    let by_name = said(command(&["check", scenario]).output().unwrap()).1;
    assert_eq!(out, by_name.replacen(scenario, &path, 1));
}

#[test]
fn a_program_that_takes_connections_and_says_nothing_is_not_waited_for() {
    let silent = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = silent.local_addr().unwrap().to_string();
    let started = Instant::now();
    let (code, _, err) = baudbot(&["watch", "--connect", &address, "--once"]);
    assert!(started.elapsed() < Duration::from_secs(60));
    assert_eq!(code, 1, "{err}");
    assert!(err.contains("a program accepts connections there, but has not answered for 5s"), "{err}");
}
