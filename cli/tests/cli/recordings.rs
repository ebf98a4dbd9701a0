//! Runs that are recorded, and done again.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::cli::processes::detach_brain;
use crate::cli::{Running, baudbot, command, good, place, said};

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// Every scenario of the project.
fn scenarios() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../catalogue/scenarios");
    let files = |folder: &Path| fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    let mut found: Vec<PathBuf> = files(&folder);
    found.extend(files(&folder.join("devices")));
    found.retain(|path| path.extension().is_some_and(|end| end == "toml"));
    assert!(found.len() > 25, "{}", found.len());
    found
}

/// Whether a microcontroller of the scenario's runs a program of the user's own.
fn runs_a_program(path: &Path) -> bool {
    fs::read_to_string(path).unwrap().contains("\nprogram = ")
}

/// Records a run and replays it; what the replay found.
fn record_and_replay(scenario: &str, args: &[&str], file: &Path) -> Value {
    let _ = fs::remove_file(file);
    let mut run = vec!["run", scenario, "--quiet", "--json", "--record", text(file)];
    run.extend(args);
    let (code, out, err) = baudbot(&run);
    assert_eq!(code, 0, "{scenario} {args:?}: {err}");
    let summary: Value = serde_json::from_str(&out).unwrap();
    let (code, out, err) = baudbot(&["replay", text(file), "--json"]);
    let found: Value = serde_json::from_str(&out).unwrap_or_else(|_| panic!("{scenario}: {err}"));
    assert_eq!((code, &found["identical"]), (0, &Value::Bool(true)), "{scenario} {args:?}: {found}");
    assert_eq!(found["state_hash"], summary["state_hash"], "{scenario} {args:?}");
    assert_eq!(found["last_tick"], summary["ticks"], "{scenario} {args:?}");
    assert_eq!(found.get("cut_off"), None, "{found}");
    found
}

/// Any robot can have this one; its commands are as noisy as its readings are late.
const BRAIN: &str = "wander:forward=0.3";

#[test]
fn every_scenario_is_replayed_to_the_same_bits() {
    for path in scenarios() {
        let name = path.file_stem().unwrap().to_str().unwrap();
        let file = place(&format!("replay-{name}.mcap"));
        // Brains understand nothing of a program of the user's own.
        for brain in [BRAIN, "none"].into_iter().filter(|brain| *brain == "none" || !runs_a_program(&path)) {
            record_and_replay(text(&path), &["--seconds", "3", "--brain", brain], &file);
        }
    }
}

#[test]
fn every_scenario_is_replayed_though_it_followed_the_clock() {
    for path in scenarios() {
        let name = path.file_stem().unwrap().to_str().unwrap();
        let file = place(&format!("replay-timed-{name}.mcap"));
        let brain = if runs_a_program(&path) { "none" } else { BRAIN };
        let args = ["--pace", "real-time", "--seconds", "0.3", "--brain", brain, "--viewer", "off"];
        record_and_replay(text(&path), &args, &file);
    }
}

/// Ten robots in one room.
fn ten(scenario: &str) -> PathBuf {
    let text = fs::read_to_string(
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../catalogue/scenarios").join(scenario),
    )
    .unwrap();
    let start = text.lines().find(|line| line.starts_with("start = ")).unwrap();
    let starts: Vec<_> = (0..10)
        .map(|i| {
            format!(
                "{{ x_m = {:.2}, y_m = {:.2}, heading_rad = {i}.5 }}",
                f64::from(i % 4) * 0.45 - 0.68,
                f64::from(i / 4) * 0.45 - 0.45
            )
        })
        .collect();
    let many = text.replacen(start, &format!("starts = [{}]", starts.join(", ")), 1);
    let path = place(&format!("ten-{scenario}"));
    fs::write(&path, many.replace("collision = \"stop-run\"", "collision = \"stop-robot\"")).unwrap();
    path
}

#[test]
fn ten_robots_are_replayed_in_lockstep_and_in_real_time() {
    for scenario in ["wander.toml", "khepera.toml"] {
        let (path, file) = (ten(scenario), place(&format!("ten-{scenario}.mcap")));
        record_and_replay(text(&path), &["--seconds", "10"], &file);
        let args = ["--pace", "scaled:4", "--seconds", "4", "--viewer", "off"];
        record_and_replay(text(&path), &args, &file);
    }
}

#[test]
fn a_run_in_lockstep_whose_brain_is_restarted_is_replayed() {
    let (socket, file) = (format!("unix:{}", place("restarted.sock").display()), place("restarted.mcap"));
    let mut run = Running::start(&[
        "run",
        "wander",
        "--seconds",
        "400",
        "--set",
        "collision=stop-robot",
        "--json",
        "--listen",
        &socket,
        "--record",
        text(&file),
    ]);
    assert_eq!(run.first_complaint(), format!("listening on {socket}\n"));
    let mut restarts = 0;
    while restarts < 3 {
        // Neither before it has come, nor before it has come again.
        restarts += u32::from(detach_brain(&socket, true).is_ok());
    }
    let (code, out, err) = run.end();
    assert_eq!(code, 0, "{err}");
    let summary: Value = serde_json::from_str(&out).unwrap();
    let (code, out, err) = baudbot(&["replay", text(&file), "--json"]);
    assert_eq!(code, 0, "{err}");
    let found: Value = serde_json::from_str(&out).unwrap();
    assert_eq!((&found["identical"], &found["state_hash"]), (&Value::Bool(true), &summary["state_hash"]));
    assert_eq!(found["last_tick"], 40_000, "{found}");
    let events = good(&["export", text(&file), "--events", "-", "--quiet"]);
    let restarted = events.matches("the operator restarts this brain").count();
    assert_eq!(restarted, 3, "{events}");
}

#[test]
fn a_recording_is_replayed_shown_in_words_or_refused() {
    let file = place("words.mcap");
    good(&["run", "wander", "--seconds", "2", "--quiet", "--record", text(&file)]);
    let out = good(&["replay", text(&file)]);
    assert!(out.starts_with("world wander, ticks 0 to 200 (2 s), "), "{out}");
    assert!(out.contains("\nidentical: state hash "), "{out}");
    let out = good(&["replay", text(&file), "--to", "1"]);
    assert!(out.starts_with("world wander, ticks 0 to 100 (1 s), "), "{out}");
    let refused = |args: &[&str], why: &str| {
        let (code, _, err) = baudbot(args);
        assert!(code == 2 && err.contains(why), "{code}: {err}");
    };
    refused(&["replay", text(&file), "--to", "3", "--fork"], "--to 3: the recording is from 0 s to 2 s");
    refused(&["replay", "/nowhere.mcap"], "/nowhere.mcap: cannot be read: No such file");
    let other = place("no-recording.mcap");
    fs::write(&other, "name = \"wander\"").unwrap();
    refused(&["replay", text(&other)], "is not an MCAP file");
    refused(&["serve", "--resume", text(&other)], "is not an MCAP file");
    refused(&["serve", "--resume", text(&file), "--record", text(&file)], "is the recording that is resumed");
    refused(&["run", "--csv", text(&file), "--record", text(&file)], "are the same file");
    refused(&["run", "--record", text(&file)], "already exists, and no file is overwritten");
    refused(&["run", "--record", "-"], "cannot be written to stdout");
    refused(&["replay", text(&file), "--record", "/tmp/x.mcap"], "use it with --fork");
    refused(&["replay", text(&file), "--listen", "127.0.0.1:0"], "need --view or --fork");
    refused(&["replay", text(&file), "--fork", "--record", text(&file)], "already exists");
    refused(&["serve", "wander", "khepera", "--record", text(&file)], "--record: takes a single world");
    refused(&["serve", "--recordings", "/nowhere/runs"], "its parent folder does not exist");
    refused(&["serve", "--recordings", "/dev/null"], "is a file, not a folder");
    let (code, _, err) = baudbot(&["run", "--record", "/nowhere/run.mcap"]);
    assert!(code == 1 && err.contains("cannot write /nowhere/run.mcap: No such file"), "{code}: {err}");
}

#[test]
fn a_full_disk_ends_the_recording_and_not_the_run() {
    let file = place("full.mcap");
    // Files may have 200 blocks of 512 bytes.
    let script = format!(
        "trap '' XFSZ; ulimit -f 200; exec \"$0\" run wander --seconds 60 --json --quiet --record {}",
        text(&file)
    );
    let mut shell = std::process::Command::new("sh");
    let program = command(&[]);
    let (code, out, err) = said(shell.args(["-c", &script]).arg(program.get_program()).output().unwrap());
    // The exit code is an error, as the requested recording is missing.
    assert!(code == 1 && err.contains("ended before the run: File too large"), "{code}: {err}");
    let summary: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(summary["ticks"], 6000);
    let problem = summary["recording"]["problem"].as_str().unwrap();
    assert!(problem.contains("File too large"), "{problem}");
    // The ticks that are there can be replayed, and are whole.
    let (code, out, err) = baudbot(&["replay", text(&file), "--json"]);
    assert!(code == 3 && err.contains("it is replayed as far as possible"), "{code}: {err}");
    let found: Value = serde_json::from_str(&out).unwrap();
    assert_eq!((&found["identical"], &found["complete"]), (&Value::Bool(true), &Value::Bool(false)));
    assert_eq!(summary["recording"]["bytes"], fs::metadata(&file).unwrap().len());
}

#[test]
fn a_file_that_is_cut_off_anywhere_is_read_as_far_as_it_goes_or_refused() {
    let file = place("parts.mcap");
    good(&[
        "run",
        "wander",
        "--pace",
        "scaled:2",
        "--seconds",
        "3",
        "--quiet",
        "--viewer",
        "off",
        "--record",
        text(&file),
    ]);
    let whole = fs::read(&file).unwrap();
    let cut = place("parts-cut.mcap");
    let mut ticks = Vec::new();
    for part in 1..20 {
        fs::write(&cut, &whole[..whole.len() * part / 20]).unwrap();
        let (code, out, err) = baudbot(&["replay", text(&cut), "--json"]);
        match code {
            3 => ticks.push(serde_json::from_str::<Value>(&out).unwrap()["last_tick"].as_u64().unwrap()),
            2 => assert!(err.contains("cut off before") || err.contains("cannot be replayed"), "{err}"),
            _ => panic!("{code}: {err}"),
        }
    }
    assert!(ticks.is_sorted() && ticks.len() > 10 && ticks[0] < ticks[ticks.len() - 1], "{ticks:?}");
}

#[test]
fn a_server_goes_on_where_a_recording_ends() {
    let file = place("resumed.mcap");
    good(&["run", "wander", "--seconds", "2", "--quiet", "--record", text(&file)]);
    let (socket, next) = (place("resume.sock"), place("resumed-2.mcap"));
    let address = format!("unix:{}", text(&socket));
    let args = ["serve", "--resume", text(&file), "--listen", &address, "--record", text(&next)];
    let mut server = Running::start(&args);
    server.lines_until("world wander");
    // The run was over after 2 s, so nothing goes on here; but there it is.
    let out = good(&["watch", "--connect", &address, "--once"]);
    assert!(out.starts_with("world wander  t = 2.000 s  tick 200"), "{out}");
    server.signal("-INT");
    assert_eq!(server.end().0, 0);
    assert!(good(&["replay", text(&next)]).contains("identical"));
}

#[test]
fn a_fork_goes_on_with_other_brains() {
    let file = place("forked.mcap");
    good(&["run", "wander", "--seconds", "2", "--quiet", "--record", text(&file)]);
    let (socket, next) = (place("fork.sock"), place("forked-2.mcap"));
    let address = format!("unix:{}", text(&socket));
    let args = ["replay", text(&file), "--to", "1", "--fork", "--listen", &address, "--record", text(&next)];
    let mut server = Running::start(&args);
    server.lines_until("world wander");
    let (code, _, err) = baudbot(&["brain", "constant:left=0.1,right=0.1", "--connect", &address]);
    assert_eq!(code, 0, "{err}");
    let out = good(&["watch", "--connect", &address, "--once"]);
    assert!(out.starts_with("world wander  t = 2.000 s  tick 200"), "{out}");
    server.signal("-INT");
    assert_eq!(server.end().0, 0);
    let out = good(&["replay", text(&next)]);
    assert!(out.starts_with("world wander, ticks 100 to 200 (1 s)") && out.contains("identical"), "{out}");
}

/// The recording of a server that is killed at no particular moment while a brain drives, and a tick that was observed
/// a second before.
fn killed(number: u64) -> (PathBuf, u64) {
    let (file, socket) = (place(&format!("killed-{number}.mcap")), place(&format!("killed-{number}.sock")));
    let address = format!("unix:{}", text(&socket));
    // The pace is by the clock in half of the runs, else as fast as the brain answers.
    let pace = if number.is_multiple_of(2) { "scaled:3" } else { "lockstep" };
    let args = [
        "serve",
        "wander",
        "--pace",
        pace,
        "--listen",
        &address,
        "--record",
        text(&file),
        "--record-hz",
        "5",
        "--set",
        "end.after_s=100000.0",
    ];
    let mut server = Running::start(&args);
    server.lines_until("world wander");
    let brain = Running::start(&["brain", "wander:forward=0.3", "--connect", &address]);
    // A number that is as good as chance, and the same each time: 0.3 to 1.3 s.
    let wait_ms = 300 + (number * 7919) % 1000;
    std::thread::sleep(std::time::Duration::from_millis(wait_ms));
    let mut seen_tick = 0;
    while seen_tick == 0 {
        let out = good(&["watch", "--connect", &address, "--once"]);
        seen_tick = out.split("tick ").nth(1).unwrap().lines().next().unwrap().parse().unwrap();
    }
    // Not rates: what a second is worth in ticks is another thing on a machine that has a lot to do.
    std::thread::sleep(std::time::Duration::from_secs(1));
    server.signal("-KILL");
    drop((server, brain));
    (file, seen_tick)
}

#[test]
fn a_server_that_is_killed_loses_a_second_at_most_and_goes_on_to_the_same_bits() {
    let all: Vec<Vec<u64>> = (0..5).map(|worker| (0..10).map(|i| worker * 10 + i).collect()).collect();
    std::thread::scope(|scope| {
        for numbers in all {
            scope.spawn(|| numbers.into_iter().for_each(kill_and_resume));
        }
    });
}

fn kill_and_resume(number: u64) {
    let (file, seen_tick) = killed(number);
    let (code, out, err) = baudbot(&["replay", text(&file), "--json"]);
    let found: Value = serde_json::from_str(&out).unwrap_or_else(|_| panic!("{number}: {err}"));
    // Nothing differs; the end is missing.
    assert_eq!((code, &found["identical"]), (3, &Value::Bool(true)), "{number}: {found}");
    let last_tick = found["last_tick"].as_u64().unwrap();
    assert!(
        last_tick >= seen_tick,
        "{number}: tick {seen_tick} was seen a second before, {last_tick} is there"
    );
    let (next, socket) = (place(&format!("after-{number}.mcap")), place(&format!("after-{number}.sock")));
    let address = format!("unix:{}", text(&socket));
    let args = ["serve", "--resume", text(&file), "--paused", "--listen", &address, "--record", text(&next)];
    let mut server = Running::start(&args);
    server.lines_until("world wander");
    server.signal("-INT");
    assert_eq!(server.end().0, 0);
    // The run that goes on is at the same tick, in the same state.
    let out = good(&["replay", text(&next), "--json"]);
    let again: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(
        (&again["first_tick"], &again["state_hash"]),
        (&found["last_tick"], &found["state_hash"]),
        "{number}"
    );
}

#[test]
fn a_replay_is_shown_in_a_browser_beside_any_server() {
    let file = place("shown.mcap");
    good(&["run", "wander", "--seconds", "1", "--quiet", "--record", text(&file)]);
    let mut server = Running::start(&["replay", text(&file), "--view", "--viewer", "127.0.0.1:0"]);
    let lines = server.lines_until("open in a browser: http://127.0.0.1:");
    // The usual port of servers may be taken by one.
    assert_eq!(lines[0], "world wander: replays a recording");
    server.signal("-INT");
    assert_eq!(server.end().0, 0);
}
