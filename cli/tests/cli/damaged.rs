//! Recordings that were ended by a signal, cut off or damaged: the output of `run` and `replay`, and their exit codes.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::cli::{Running, baudbot, good, place};

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// The report of `replay` on a file, and its exit code.
fn replay(file: &Path) -> (i32, Value) {
    let (code, out, err) = baudbot(&["replay", text(file), "--json"]);
    let found = serde_json::from_str(&out).unwrap_or_else(|_| panic!("{code}: {err}"));
    (code, found)
}

/// Ends a run by this signal once some of it is in the file.
fn ended_by(signal: &str, number: usize) {
    let file = place(&format!("ended-by{signal}-{number}.mcap"));
    let run = Running::start(&[
        "run",
        "wander",
        "--seconds",
        "100000",
        "--json",
        "--quiet",
        "--record",
        text(&file),
    ]);
    // However busy the machine is: there is more than the beginning.
    let least = 30_000 + 1_000 * number as u64;
    let started = std::time::Instant::now();
    while fs::metadata(&file).map_or(0, |data| data.len()) < least {
        assert!(started.elapsed().as_secs() < 120, "nothing is recorded");
        std::thread::sleep(std::time::Duration::from_millis(3));
    }
    run.signal(signal);
    if signal == "-HUP" {
        // The signal comes from a terminal's shell, and then from the system.
        run.signal(signal);
    }
    let (code, out, err) = run.end();
    assert_eq!(code, 130, "{signal}: {err}");
    let summary: Value = serde_json::from_str(&out).unwrap();
    let (code, found) = replay(&file);
    assert_eq!((code, &found["complete"]), (0, &Value::Bool(true)), "{signal}: {found}");
    assert_eq!(summary["ticks"], found["last_tick"], "{signal}: {found}");
    assert_eq!(summary["state_hash"], found["state_hash"], "{signal}: {found}");
    assert_eq!(summary["recording"]["ticks"], found["last_tick"], "{signal}");
}

#[test]
fn a_run_that_a_signal_ends_is_summed_up_as_it_is_recorded() {
    for number in 0..4 {
        ended_by("-INT", number);
        ended_by("-TERM", number);
    }
    ended_by("-HUP", 0);
}

#[test]
fn a_closed_terminal_does_not_end_what_was_started_with_nohup() {
    let socket = place("nohup.sock");
    let address = format!("unix:{}", text(&socket));
    let program = crate::cli::command(&[]).get_program().to_owned();
    let script = "trap '' HUP; exec \"$0\" \"$@\"";
    let mut shell = std::process::Command::new("sh");
    shell.args(["-c", script]).arg(program).args(["serve", "wander", "--listen", &address]);
    let mut server = Running(shell.stdout(std::process::Stdio::piped()).spawn().unwrap());
    server.lines_until("world wander");
    server.signal("-HUP");
    assert!(good(&["watch", "--connect", &address, "--once"]).starts_with("world wander"));
    let frame: Value =
        serde_json::from_str(&good(&["watch", "--connect", &address, "--once", "--json"])).unwrap();
    assert!(frame["world"] == "wander" && frame["robots"][0]["x_m"].is_number(), "{frame}");
    server.signal("-TERM");
    drop(server);
}

/// A recording of 130 s with marks and three states in it.
fn recorded(name: &str) -> Vec<u8> {
    let file = place(name);
    good(&["run", "wander", "--seconds", "130", "--quiet", "--record", text(&file), "--record-hz", "1"]);
    fs::read(&file).unwrap()
}

#[test]
fn of_a_damaged_recording_all_is_compared_that_is_left_and_what_is_missing_is_told() {
    let whole = recorded("damaged-whole.mcap");
    let file = place("damaged.mcap");
    for percent in [20, 50, 90] {
        fs::write(&file, &whole[..whole.len() * percent / 100]).unwrap();
        let (code, found) = replay(&file);
        assert_eq!((code, &found["identical"]), (3, &Value::Bool(true)), "cut at {percent} %: {found}");
    }
    let (_, out, err) = baudbot(&["replay", text(&file)]);
    assert!(out.contains("incomplete: identical in") && out.contains("ticks that are left"), "{out}");
    assert!(err.contains("cut off"), "{err}");
    let (mut incomplete, mut most, mut to_the_end, mut gaps) = (0, 0, 0, 0);
    for place in (1..14).map(|part| whole.len() * part / 14) {
        let mut damaged = whole.clone();
        damaged[place] ^= 0x10;
        fs::write(&file, &damaged).unwrap();
        let (code, out, err) = baudbot(&["replay", text(&file), "--json"]);
        match code {
            // The index, which is not needed for this.
            0 => {
                let found: Value = serde_json::from_str(&out).unwrap();
                assert_eq!(
                    [&found["identical"], &found["complete"]],
                    [&Value::Bool(true); 2],
                    "byte {place}"
                );
                assert_eq!(found["compared_ticks"], 13_000, "byte {place}: {found}");
            }
            2 => assert!(err.contains("cannot be replayed"), "byte {place}: {err}"),
            3 => {
                let found: Value = serde_json::from_str(&out).unwrap();
                let [compared, all] = ["compared_ticks", "recorded_ticks"].map(|name| found[name].as_u64());
                assert!(all == Some(13_000) && compared < all, "byte {place}: {found}");
                assert_eq!(found["identical"], true, "byte {place}: {found}");
                // The bytes behind the next state are compared, too.
                if found["last_tick"] == 13_000 {
                    to_the_end += 1;
                    // From the first state on there is a gap within, and a picture does not draw across it.
                    let picture = good(&["export", text(&file), "--svg", "-", "--quiet"]);
                    gaps += usize::from(picture.contains(" missing in the recording"));
                }
                most = most.max(compared.unwrap());
                incomplete += 1;
            }
            _ => panic!("byte {place}: {code}: {out} {err}"),
        }
    }
    assert!(incomplete > 4 && most > 6_000 && to_the_end > 2, "{incomplete}, {most}, {to_the_end}");
    assert!(gaps > 1, "{gaps} pictures of {to_the_end}");
}

#[test]
fn a_folder_for_recordings_is_made_where_it_is_not_there() {
    let folder = place("made-for-recordings");
    let _ = fs::remove_dir_all(&folder);
    let socket = place("made-for-recordings.sock");
    let address = format!("unix:{}", text(&socket));
    let mut server =
        Running::start(&["serve", "wander", "--listen", &address, "--recordings", text(&folder)]);
    server.lines_until("world wander");
    assert!(folder.is_dir());
    server.signal("-INT");
    assert_eq!(server.end().0, 0);
}

#[test]
fn a_recording_that_cannot_be_written_is_no_success() {
    let (code, _, err) = baudbot(&["run", "wander", "--seconds", "1", "--quiet", "--record", "/dev/full"]);
    assert!(code != 0 && err.contains("/dev/full"), "{code}: {err}");
}
