//! `baudbot run`.

use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::cli::{Running, baudbot, good, place};

fn json(args: &[&str]) -> Value {
    let out = good(&[&["run", "--json", "--quiet"], args].concat());
    serde_json::from_str(&out).unwrap_or_else(|error| panic!("{error}: {out}"))
}

#[test]
fn a_run_is_summed_up() {
    let out = good(&["run", "--seconds", "2"]);
    for part in [
        "scenario    wander, seed 1\n",
        "pace        lockstep\n",
        "ticks       200 of 10 ms\n",
        "ended       because the scenario's time is over\n",
        "robot robot\n  brain   avoid, 200 turns,",
        "9600 baud, 10 bits a character\n",
        "ir_front_right",
    ] {
        assert!(out.contains(part), "`{part}` is not in:\n{out}");
    }
}

#[test]
fn the_summary_as_json() {
    let summary = json(&["--seconds", "2", "--set", "robots.robot.link.baud=19200"]);
    assert_eq!(summary["ticks"], 200);
    assert_eq!(summary["simulated_s"], 2.0);
    assert_eq!(summary["pace"], "lockstep");
    assert!(summary["clock"].is_null() && summary["lockstep"]["waiting_s"].as_f64().unwrap() > 0.0);
    let robot = &summary["robots"][0];
    assert_eq!(robot["brain"], "avoid");
    assert_eq!(robot["baud"], 19200);
    // 19 bytes every 20 ms on a line of 1920 bytes/s.
    let used = robot["uplink"]["used_percent"].as_f64().unwrap();
    assert!((used - 100.0 * 950.0 / 1920.0).abs() < 1.0, "{used}");
    assert_eq!(robot["sensors"].as_array().unwrap().len(), 5);
    assert!(robot["sensors"][0]["age"]["mean_ms"].as_f64().unwrap() > 9.9, "the frame's time on the line");
}

/// The robot drives into the wall before it and is held there; in its own arena it meets nothing in that time.
#[test]
fn a_summary_says_how_long_a_robot_stood_in_contact() {
    let run = ["wander", "--brain", "constant:left=0.5,right=0.5", "--set", "collision=slide", "--seconds"];
    let stood_s =
        |seconds| json(&[&run[..], &[seconds]].concat())["robots"][0]["stood_in_contact_s"].as_f64();
    let (ten_s, twenty_s) = (stood_s("10").unwrap(), stood_s("20").unwrap());
    assert!(ten_s > 0.0 && (twenty_s - ten_s - 10.0).abs() < 0.011, "{ten_s} s, {twenty_s} s");
    let out = good(&[&["run"], &run[..], &["20"]].concat());
    assert!(out.contains(&format!(", 1 collision, stood in contact for {twenty_s} s\n")), "{out}");
    assert_eq!(stood_s("1"), Some(0.0));
    let free = good(&[&["run"], &run[..], &["1"]].concat());
    assert!(!free.contains("in contact"), "{free}");
}

/// Such as what it waits for.
#[test]
fn a_summary_has_what_a_brain_last_said_of_itself() {
    let room = concat!(env!("CARGO_MANIFEST_DIR"), "/../catalogue/scenarios/explore-room.toml");
    let run = [room, "--brain", "explore", "--ticks", "6"];
    let said = "waits for `laser` since 0.00 s";
    assert_eq!(json(&run)["robots"][0]["said"], said);
    let out = good(&[&["run"], &run[..]].concat());
    assert!(out.contains(&format!("\n  said    {said}\n")), "{out}");
    let silent = good(&["run", "--ticks", "6"]);
    assert!(!silent.contains("said"), "{silent}");
}

#[test]
fn the_same_seed_gives_the_same_run_and_another_another() {
    let hash = |seed| json(&["--seconds", "1", "--seed", seed])["state_hash"].as_str().unwrap().to_owned();
    assert_eq!(hash("7"), hash("7"));
    assert_ne!(hash("7"), hash("8"));
}

#[test]
fn ticks_are_exact() {
    assert_eq!(json(&["--ticks", "7"])["ticks"], 7);
    assert_eq!(json(&["arsim", "--ticks", "1"])["ticks"], 1);
}

#[test]
fn real_time_is_kept_and_told() {
    let is_kept = || {
        let started = Instant::now();
        let summary = json(&["--pace", "scaled:2", "--seconds", "1"]);
        assert!(started.elapsed() >= Duration::from_millis(495));
        assert!(summary["lockstep"].is_null());
        let clock = &summary["clock"];
        let bars = clock["lateness"].as_array().unwrap().iter();
        let bars = bars.map(|bar| (bar["below_us"].as_u64().unwrap(), bar["ticks"].as_u64().unwrap()));
        assert_eq!(bars.clone().map(|(_, ticks)| ticks).sum::<u64>(), 100);
        let on_time: u64 = bars.filter(|(below_us, _)| *below_us < 10_000).map(|(_, ticks)| ticks).sum();
        on_time > 90 && clock["drift_percent"].as_f64().unwrap().abs() < 20.0
    };
    // A busy machine is late now and then, a clock that is wrong each time.
    assert!((0..3).any(|_| is_kept()));
}

#[test]
fn the_table_has_a_row_a_tick_and_numbers_that_read_back() {
    let table = good(&["run", "khepera", "--ticks", "20", "--csv", "-", "--quiet"]);
    let rows: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 1 + 21);
    assert_eq!(rows[0][..7].join(","), "t_s,robot,x_m,y_m,heading_rad,speed_m_s,turn_rate_rad_s");
    assert_eq!(rows[0][7], "ir_0");
    assert_eq!(rows[0][15..].join(","), "encoders.left,encoders.right,left_signal,right_signal,collided");
    for (tick, row) in rows[1..].iter().enumerate() {
        assert_eq!(row.len(), rows[0].len());
        assert_eq!(row[0].parse::<f64>().unwrap(), (tick as u64 * 10_000_000) as f64 / 1e9);
        assert_eq!((row[1], row[19]), ("khepera", "0"));
        // The fifth sensor is first read in the second tick.
        assert_eq!(row[11].is_empty(), tick == 0, "{row:?}");
        for number in row[..19].iter().enumerate().filter(|(i, cell)| *i != 1 && !cell.is_empty()) {
            let digits = number.1.split('e').next().unwrap().chars().filter(char::is_ascii_digit).count();
            assert_eq!(digits, 17, "{number:?}");
        }
    }
}

#[test]
fn the_table_is_the_same_in_a_file() {
    let path = place("same.csv");
    std::fs::write(&path, "old\n".repeat(100_000)).unwrap();
    good(&["run", "--ticks", "30", "--quiet", "--csv", path.to_str().unwrap()]);
    let to_stdout = good(&["run", "--ticks", "30", "--quiet", "--csv", "-"]);
    assert_eq!(std::fs::read_to_string(path).unwrap(), to_stdout);
}

#[test]
fn a_collision_ends_the_run_and_is_no_error() {
    let path = place("collision.csv");
    let into_the_wall = "constant:left=0.5,right=0.5";
    let path = path.to_str().unwrap();
    let summary = json(&["--brain", into_the_wall, "--seconds", "60", "--csv", path]);
    assert_eq!(summary["ending"], "`robot` ran into `wall_right`");
    assert_eq!(summary["robots"][0]["collisions"], 1);
    let table = std::fs::read_to_string(path).unwrap();
    let collided: Vec<_> = table.lines().skip(1).map(|line| &line[line.len() - 2..]).collect();
    assert_eq!(collided.len() as u64, summary["ticks"].as_u64().unwrap() + 1);
    assert_eq!(
        collided.iter().position(|flag| *flag == ",1"),
        Some(collided.len() - 1),
        "only the last state"
    );
}

#[test]
fn a_robot_without_a_brain_stands_still() {
    let summary = json(&["--brain", "none", "--seconds", "1"]);
    assert_eq!(summary["ticks"], 100);
    assert_eq!(summary["robots"][0]["brain"], "");
    assert_eq!(summary["robots"][0]["distance_m"], 0.0);
}

#[test]
fn without_an_end_a_run_has_60_seconds_and_says_so() {
    let (code, out, err) = baudbot(&["run", "wander", "--brain", "none", "--pace", "free", "--json"]);
    assert_eq!(code, 0);
    assert_eq!(err, "note: wander sets no end; this run ends after 60 s\n");
    assert_eq!(serde_json::from_str::<Value>(&out).unwrap()["simulated_s"], 60.0);
}

#[test]
fn ctrl_c_ends_the_run_and_keeps_what_was_done() {
    let path = place("interrupted.csv");
    let csv = path.to_str().unwrap();
    let socket = format!("unix:{}", place("interrupted.sock").display());
    let args = ["--pace", "real-time", "--seconds", "1000", "--json", "--listen", &socket, "--csv", csv];
    let mut run = Running::start(&[&["run"], &args[..]].concat());
    // Signals are awaited before it listens.
    assert_eq!(run.first_complaint(), format!("listening on {socket}\n"));
    let begun = Instant::now();
    while good(&["watch", "--once", "--connect", &socket]).starts_with("world wander  t = 0.000 s") {
        assert!(begun.elapsed() < Duration::from_secs(20), "the world does not start");
    }
    run.signal("-INT");
    let (code, out, _) = run.end();
    assert_eq!(code, 130);
    let summary: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(summary["interrupted"], true);
    let table = std::fs::read_to_string(&path).unwrap();
    assert!(table.ends_with('\n'));
    let columns = |line: &str| line.split(',').count();
    assert!(table.lines().all(|line| columns(line) == columns(table.lines().next().unwrap())));
    let ticks = summary["ticks"].as_u64().unwrap();
    let rows = table.lines().count() as u64 - 1;
    assert!(ticks > 0 && (rows == ticks || rows == ticks + 1), "{rows} rows for {ticks} ticks");
}

#[test]
fn a_second_signal_ends_at_once_what_waits_for_a_reader() {
    // The reader stops after the first row, and a pipe does not hold all of them.
    let mut run = Running::start(&["run", "--seconds", "1000", "--csv", "-"]);
    run.lines_until("t_s,robot,");
    std::thread::sleep(Duration::from_millis(1000));
    run.signal("-INT");
    std::thread::sleep(Duration::from_millis(300));
    run.signal("-TERM");
    assert_eq!(run.end().0, 130);
}

/// A FIFO of this name.
fn fifo(name: &str) -> String {
    let path = place(name).to_str().unwrap().to_owned();
    assert!(Command::new("mkfifo").arg(&path).status().unwrap().success());
    path
}

#[test]
fn one_signal_ends_what_waits_for_a_fifo() {
    let path = fifo("waits.fifo");
    for args in [&["run", &path][..], &["serve", "--listen", "127.0.0.1:0", &path], &["run", "--csv", &path]]
    {
        let mut run = Running::start(args);
        std::thread::sleep(Duration::from_millis(500));
        assert!(run.0.try_wait().unwrap().is_none(), "{args:?} waits");
        run.signal("-INT");
        let deadline = Instant::now() + Duration::from_secs(5);
        while run.0.try_wait().unwrap().is_none() {
            assert!(Instant::now() < deadline, "{args:?} does not end");
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}

#[test]
fn a_table_goes_through_a_fifo() {
    let path = fifo("table.fifo");
    let reader = Command::new("cat").arg(&path).stdout(Stdio::piped()).spawn().unwrap();
    good(&["run", "--ticks", "30", "--quiet", "--csv", &path]);
    let read = String::from_utf8(reader.wait_with_output().unwrap().stdout).unwrap();
    assert_eq!(read, good(&["run", "--ticks", "30", "--quiet", "--csv", "-"]));
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_told_once_and_is_an_error() {
    let (code, out, err) = baudbot(&["run", "--seconds", "10", "--csv", "/dev/full"]);
    assert_eq!((code, out.as_str()), (1, ""));
    assert_eq!(err, "error: cannot write /dev/full: No space left on device (os error 28)\n");
}

#[test]
fn people_read_robots_in_the_natural_order_of_their_names_and_programs_in_that_of_the_world() {
    let robot =
        |n: u32| format!("[[robots]]\nname = \"cell-{n}\"\npreset = \"khepera-1\"\nstart.y_m = {n}.0\n");
    let path = place("cells.toml");
    std::fs::write(&path, [10, 2, 1].map(robot).concat()).unwrap();
    let arguments = ["run", path.to_str().unwrap(), "--brain", "none", "--seconds", "0.1"];
    let order = |text: &str| {
        let mut names = ["cell-1", "cell-2", "cell-10"];
        let quoted = |name: &str| text.find(&format!("\"{name}\""));
        names.sort_by_key(|name| text.find(&format!("{name}\n")).or_else(|| quoted(name)));
        names
    };
    assert_eq!(order(&good(&arguments)), ["cell-1", "cell-2", "cell-10"]);
    assert_eq!(order(&good(&[&arguments[..], &["--json"]].concat())), ["cell-1", "cell-10", "cell-2"]);
}
