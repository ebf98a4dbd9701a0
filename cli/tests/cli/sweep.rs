//! `baudbot sweep`: what it writes, and that nothing is lost or doubled whatever ends it.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::cli::processes::serve;
use crate::cli::{Running, baudbot, good};

const ROOM: &str = r#"
name = "room"
step_ms = 10.0
substeps = 10
[[arena.polygons]]
name = "wall"
solid = false
points_m = [[-0.4, -0.4], [0.4, -0.4], [0.4, 0.4], [-0.4, 0.4]]
[[robots]]
name = "alice"
preset = "khepera-1"
firmware = { protocol = "framed", mode = "stream", period_ms = 20.0, phase_ms = 17.6 }
link = { kind = "uart", baud = 38400 }
"#;

/// Six baud rates and four sets of sensors.
pub(crate) const GRID: &str = r#"
name = "grid"
scenario = "room.toml"
brain = "avoid:forward=0.3"
seconds = 5.0
seeds = 3
[[fields]]
field = "robots.alice.link.baud"
label = "baud"
values = [2400, 4800, 9600, 19200, 38400, 115200]
[[fields]]
label = "sensors"
levels = [
  { name = "all eight" },
  { name = "front six", set = ["robots.alice.without=['ir_6', 'ir_7']"] },
  { name = "front four", set = ["robots.alice.without=['ir_0', 'ir_5', 'ir_6', 'ir_7']"] },
  { name = "front two", set = ["robots.alice.without=['ir_0', 'ir_1', 'ir_4', 'ir_5', 'ir_6', 'ir_7']"] },
]
[success]
collisions_at_most = 0
[[charts]]
figure = "collisions"
"#;

/// A folder with the scenario and this experiment; the experiment's path.
pub(crate) fn experiment(name: &str, toml: &str) -> String {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("sweep-{name}"));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("room.toml"), ROOM).unwrap();
    let path = folder.join("experiment.toml");
    std::fs::write(&path, toml).unwrap();
    path.to_str().unwrap().to_owned()
}

/// A folder for outputs, beside an experiment.
pub(crate) fn out(experiment: &str, name: &str) -> String {
    Path::new(experiment).with_file_name(name).to_str().unwrap().to_owned()
}

/// Sweeps quietly to a good end; the table.
pub(crate) fn table(args: &[&str], out: &str) -> String {
    assert_eq!(good(&[&["sweep", "--quiet", "--out", out], args].concat()), "");
    std::fs::read_to_string(Path::new(out).join("rows.csv")).unwrap()
}

/// Waits until a journal has so many rows.
pub(crate) fn wait_for_rows(out: &str, rows: usize) {
    let deadline = Instant::now() + Duration::from_secs(20);
    let lines =
        || std::fs::read_to_string(Path::new(out).join("rows.jsonl")).unwrap_or_default().lines().count();
    while lines() <= rows {
        assert!(Instant::now() < deadline, "there are no rows");
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn rows(out: &str) -> usize {
    std::fs::read_to_string(Path::new(out).join("rows.jsonl")).unwrap().lines().count() - 1
}

#[test]
fn a_sweep_that_is_killed_goes_on_to_the_same_table() {
    let grid = experiment("killed", GRID);
    let (whole, killed) = (out(&grid, "whole"), out(&grid, "killed"));
    let expected = table(&[&grid], &whole);
    assert_eq!(expected.lines().count(), 1 + 6 * 4 * 3);
    let long = ["sweep", &grid, "--out", &killed, "--jobs", "1"];
    for rows in [5, 20] {
        let running = Running::start(&long);
        wait_for_rows(&killed, rows);
        // SIGKILL.
        drop(running);
    }
    assert!(rows(&killed) < 72 && !Path::new(&killed).join("rows.csv").exists());
    assert_eq!(table(&[&grid], &killed), expected);
    assert_eq!(rows(&killed), 72, "no row is there twice");
    let parquet = |out: &str| std::fs::read(Path::new(out).join("rows.parquet")).unwrap();
    assert!(parquet(&whole) == parquet(&killed));
}

#[test]
fn ctrl_c_keeps_what_is_done_and_says_how_to_go_on() {
    let grid = experiment("interrupted", GRID);
    let to = out(&grid, "out");
    let running = Running::start(&["sweep", &grid, "--out", &to, "--jobs", "1"]);
    wait_for_rows(&to, 3);
    running.signal("-INT");
    let (code, stdout, err) = running.end();
    assert_eq!((code, stdout.as_str()), (130, ""));
    assert!(
        err.starts_with("stopped after ") && err.contains("the same command continues from there"),
        "{err}"
    );
    assert_eq!(table(&[&grid], &to).lines().count(), 73);
}

#[test]
fn two_sweeps_do_not_write_into_one_folder() {
    let grid = experiment("two", &GRID.replace("seconds = 5.0", "seconds = 60.0"));
    let to = out(&grid, "out");
    let _first = Running::start(&["sweep", &grid, "--out", &to, "--jobs", "1"]);
    wait_for_rows(&to, 1);
    let (code, _, err) = baudbot(&["sweep", &grid, "--out", &to]);
    assert_eq!(code, 2);
    assert!(err.starts_with("error: another experiment is writing into ") && err.contains("--out"), "{err}");
}

#[test]
fn a_folder_of_another_experiment_is_left_alone_until_it_is_to_be_fresh() {
    let short = experiment("fresh", &GRID.replace("seconds = 5.0", "seconds = 0.1"));
    let to = out(&short, "out");
    let first = table(&[&short], &to);
    let (code, _, err) = baudbot(&["sweep", &short, "--out", &to, "--seeds", "4..6"]);
    assert_eq!(code, 2);
    assert!(err.contains("belongs to another experiment") && err.contains("or to other seeds"), "{err}");
    assert!(err.contains("--out DIR") && err.contains("--fresh"), "{err}");
    let other = table(&[&short, "--seeds", "4..6", "--fresh"], &to);
    assert_eq!(other.lines().count(), first.lines().count());
    assert_ne!(other, first);
}

#[test]
fn mistakes_are_found_before_the_first_run() {
    let refused = |name: &str, toml: &str| {
        let path = experiment(name, toml);
        let to = out(&path, "out");
        let (code, stdout, err) = baudbot(&["sweep", &path, "--out", &to]);
        assert_eq!((code, stdout.as_str()), (2, ""), "{err}");
        assert!(!Path::new(&to).exists(), "{err}");
        err.strip_prefix(&format!("error: {path}: ")).unwrap_or_else(|| panic!("{err}")).to_owned()
    };
    let misspelt = refused("misspelt", &GRID.replace("link.baud", "link.buad"));
    assert!(
        misspelt
            .starts_with("fields[0]: robots.alice.link.buad: there is no field `buad`; did you mean `baud`?"),
        "{misspelt}"
    );
    let empty = refused("empty", "scenario = \"room.toml\"\nseconds = 1.0\n");
    assert_eq!(empty, "fields: is missing: give at least one [[fields]] that is varied\n");
    let nothing = refused(
        "nothing",
        "scenario = \"room.toml\"\nseconds = 1.0\nfields = [{ field = \"step_ms\", values = [] }]",
    );
    assert!(nothing.starts_with("fields[0].values: is empty"), "{nothing}");
    let twice = GRID.replace(
        "[success]",
        "[[fields]]\nfield = \"robots[0].link.baud\"\nlabel = \"b2\"\nvalues = [1200]\n[success]",
    );
    let twice = refused("twice", &twice);
    assert!(
        twice.starts_with("fields[2]: varies `robots[0].link.baud`, which fields[0] varies already, as `robots.alice.link.baud`"),
        "{twice}"
    );
    let nowhere = refused("nowhere", "scenario = \"rom.toml\"\n");
    assert!(nowhere.contains("rom.toml: there is no such file"), "{nowhere}");
}

#[test]
fn a_name_of_another_kind_is_told_with_its_command() {
    for (args, expected) in [
        (
            &["sweep", "wander"][..],
            "no experiment of this name is built in; `wander` is a scenario: `baudbot run wander`",
        ),
        (
            &["tune", "wander"],
            "no experiment of this name is built in; `wander` is a scenario: `baudbot run wander`",
        ),
        (&["sweep", "square"], "`square` is an exercise: `baudbot grade square --brain BRAIN`"),
        (&["run", "baud-vs-speed"], "`baud-vs-speed` is an experiment: `baudbot sweep baud-vs-speed`"),
        (&["run", "tune-sweeper"], "`tune-sweeper` is an experiment: `baudbot tune tune-sweeper`"),
        (
            &["grade", "baud-vs-speed"],
            "no exercise of this name is built in; `baud-vs-speed` is an experiment",
        ),
        (&["replay", "wander"], "there is no such file; `wander` is a scenario: `baudbot run wander`"),
        (
            &["sweep", "nofile.toml"],
            "nofile.toml: there is no such file, and no experiment of this name is built in\n",
        ),
        (&["sweep", "baud-vs-sped"], "did you mean `baud-vs-speed`?"),
        // The brain of these experiments is a program of the repository.
        (&["sweep", "follow"], "follow: there is no such file, and no experiment of this name is built in"),
        (
            &["tune", "tune-follow"],
            "tune-follow: there is no such file, and no experiment of this name is built in",
        ),
    ] {
        let (code, _, err) = baudbot(args);
        assert_eq!(code, 2, "{args:?}: {err}");
        assert!(err.contains(expected), "{args:?}: {err}");
    }
}

#[test]
fn a_file_of_another_kind_is_told_with_its_command() {
    let grid = experiment("kinds", GRID);
    let beside = |name: &str| out(&grid, name);
    let (room, task, run) = (beside("room.toml"), beside("task.toml"), beside("run.mcap"));
    std::fs::write(&task, "title = \"Stop\"\ntask = \"Stop.\"\nscenario = \"wander\"\n").unwrap();
    good(&["run", "wander", "--seconds", "0.1", "--quiet", "--record", &run]);
    let told = |command: &str, file: &str, is: &str, not: &str, with: &str| {
        let (code, _, err) = baudbot(&[command, file]);
        let expected = format!("error: {file}: is {is}, not {not}; run it with `baudbot {with}`\n");
        assert_eq!((code, err), (2, expected), "{command}");
    };
    for (command, not) in [
        ("sweep", "an experiment"),
        ("tune", "an experiment"),
        ("grade", "an exercise"),
        ("replay", "a recording"),
        ("export", "a recording"),
    ] {
        told(command, &room, "a scenario", not, &format!("run {room}"));
    }
    for (command, not) in
        [("run", "a scenario"), ("check", "a scenario"), ("grade", "an exercise"), ("replay", "a recording")]
    {
        told(command, &grid, "an experiment", not, &format!("sweep {grid}"));
    }
    for (command, not) in [("run", "a scenario"), ("sweep", "an experiment")] {
        told(command, &task, "an exercise", not, &format!("grade {task} --brain BRAIN"));
    }
    for (command, not) in [("sweep", "an experiment"), ("grade", "an exercise"), ("run", "a scenario")] {
        let (code, _, err) = baudbot(&[command, &run]);
        assert_eq!(code, 2, "{err}");
        assert!(err.contains(&format!("is a recording, not {not}; `baudbot replay {run}`")), "{err}");
    }
}

#[test]
fn what_cannot_be_run_is_told_and_the_others_are_run() {
    let path = experiment(
        "failing",
        &GRID.replace("2400, 4800", "2400, 20").replace("seconds = 5.0", "seconds = 0.1"),
    );
    let to = out(&path, "out");
    let (code, stdout, _) = baudbot(&["sweep", &path, "--out", &to]);
    assert_eq!(code, 1);
    assert!(stdout.contains("12 of 72 runs failed:\n  run 12: robots[0].link.baud: "), "{stdout}");
    assert_eq!(rows(&to), 72);
    let (code, stdout, err) = baudbot(&["sweep", &path, "--out", &to, "--quiet"]);
    assert_eq!((code, stdout.as_str()), (1, ""));
    assert!(
        err.starts_with("error: 12 of 72 runs failed; the first, run 12: robots[0].link.baud: "),
        "{err}"
    );
    let json: serde_json::Value =
        serde_json::from_str(&baudbot(&["sweep", &path, "--out", &to, "--json", "--quiet"]).1).unwrap();
    assert_eq!((&json["runs"], &json["failed"]), (&72.into(), &12.into()));
    assert_eq!(json["cells"][0]["values"]["sensors"], "all eight");
    assert_eq!(json["cells"][0]["figures"]["time_s"]["mean"], 0.1);
    assert!(json["cells"][4]["figures"]["time_s"]["mean"].is_null(), "it could not be run");
}

#[test]
fn runs_that_failed_are_done_again_and_others_are_told_of_until_a_sweep_is_fresh() {
    let path = experiment("again", "");
    let (to, program) = (out(&path, "out"), out(&path, "late.sh"));
    let toml = "scenario = \"room.toml\"\nbrain = { exec = \"sh late.sh\" }\nseconds = 0.2\nseeds = 2\n\
        fields = [{ field = \"robots.alice.link.baud\", values = [19200] }]\n";
    std::fs::write(&path, toml).unwrap();
    let sweep = |more: &[&str]| {
        let (code, _, err) = baudbot(&[&["sweep", &path, "--out", &to], more].concat());
        (code, err.lines().filter(|line| !line.starts_with("wrote ")).collect::<Vec<_>>().join("\n"))
    };
    assert_eq!(sweep(&[]), (1, String::new()), "there is no program");
    let brain = "brain avoid --connect $BAUDBOT_CONNECT --world $BAUDBOT_WORLD --robot $BAUDBOT_ROBOT";
    std::fs::write(&program, format!("exec {} {brain}\n", env!("CARGO_BIN_EXE_baudbot"))).unwrap();
    let journal = format!("{to}/rows.jsonl (the journal)");
    let (code, told) = sweep(&[]);
    assert_eq!(
        (code, told),
        (0, format!("note: {journal} has 0 of 2 runs; 2 that failed are done again; --fresh does all again"))
    );
    let note = format!("note: {journal} has 2 of 2 runs; --fresh does them again");
    assert_eq!(sweep(&[]), (0, note.clone()), "the program is older than the runs that count");
    assert_eq!(sweep(&["--quiet"]), (0, String::new()));
    let later = std::time::SystemTime::now() + Duration::from_secs(60);
    std::fs::File::options().append(true).open(&program).unwrap().set_modified(later).unwrap();
    let warning =
        format!("warning: {program} was changed after runs in the journal; --fresh does them again");
    assert_eq!(sweep(&[]), (0, format!("{note}\n{warning}")));
    assert_eq!(sweep(&["--fresh"]), (0, String::new()));
}

#[test]
fn what_takes_long_must_be_meant() {
    let path = experiment("long", &GRID.replace("seeds = 3", "seeds = 400000"));
    let to = out(&path, "out");
    let (code, _, err) = baudbot(&["sweep", &path, "--out", &to]);
    assert_eq!(code, 2);
    assert!(err.contains(" runs would take about ") && err.contains("--yes"), "{err}");
    assert!(rows(&to) < 100, "they were run all the same");
    let (code, stdout, err) = baudbot(&["sweep", &path, "--find", "baud"]);
    assert_eq!((code, stdout.as_str()), (2, ""));
    // Four limits of at most six values each.
    assert!(err.starts_with("error: up to 9600000 runs would take about "), "{err}");
    assert!(err.contains("--yes"), "{err}");
}

#[test]
fn a_fresh_sweep_that_is_not_meant_deletes_nothing() {
    let path = experiment("fresh-long", &GRID.replace("seconds = 5.0", "seconds = 0.1"));
    let to = out(&path, "out");
    let before = table(&[&path], &to);
    let fresh = ["sweep", &path, "--out", &to, "--fresh", "--seeds", "400000"];
    let (code, _, err) = baudbot(&fresh);
    assert_eq!(code, 2);
    assert!(err.contains("--yes"), "{err}");
    assert_eq!(table(&[&path], &to), before);
    assert_eq!(rows(&to), 72);
}

#[test]
fn a_table_and_a_trace_do_not_go_into_one_file() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let file = folder.join("both.out").to_str().unwrap().to_owned();
    let _ = std::fs::remove_file(&file);
    let (code, stdout, err) =
        baudbot(&["run", "wander", "--ticks", "1", "--csv", &file, "--timeline", &file]);
    assert_eq!((code, stdout.as_str()), (2, ""));
    assert!(
        err.starts_with(&format!("error: --csv {file} and --timeline {file} are the same file")),
        "{err}"
    );
    assert!(!Path::new(&file).exists());
}

#[test]
fn a_full_disk_is_told_with_the_files_name() {
    let path = experiment("full", &GRID.replace("seconds = 5.0", "seconds = 0.1"));
    let to = out(&path, "out");
    std::fs::create_dir_all(&to).unwrap();
    std::os::unix::fs::symlink("/dev/full", Path::new(&to).join("rows.jsonl")).unwrap();
    let (code, _, err) = baudbot(&["sweep", &path, "--out", &to]);
    assert_eq!(code, 1);
    assert!(
        err.starts_with(&format!("error: cannot write {to}/rows.jsonl: No space left on device")),
        "{err}"
    );
    // The rows fit, the table does not: they are kept for when there is room again.
    std::fs::remove_file(Path::new(&to).join("rows.jsonl")).unwrap();
    std::os::unix::fs::symlink("/dev/full", Path::new(&to).join(".rows.csv.tmp")).unwrap();
    let (code, _, err) = baudbot(&["sweep", &path, "--out", &to]);
    assert_eq!(code, 1);
    assert!(err.starts_with(&format!("error: cannot write {to}/rows.csv: No space left on device")), "{err}");
    assert_eq!(rows(&to), 72);
    assert_eq!(table(&[&path], &to).lines().count(), 73);
}

#[test]
fn runs_on_a_server_are_the_same_to_the_last_bit() {
    let path = experiment(
        "server",
        &GRID
            .replace("seeds = 3", "seeds = 1")
            .replace("seconds = 5.0", "seconds = 2.0")
            .replace("115200]", "20]"),
    );
    let (here, there) = (out(&path, "here"), out(&path, "there"));
    let (server, tcp, _) = serve("sweep.sock", &["wander", "--paused"]);
    // Some of it could not be run, with the same words in both.
    let sweep =
        |args: &[&str]| assert_eq!(baudbot(&[&["sweep", &path, "--quiet", "--out"], args].concat()).0, 1);
    sweep(&[&here]);
    sweep(&[&there, "--connect", &tcp]);
    let read = |out: &str| std::fs::read_to_string(Path::new(out).join("rows.csv")).unwrap();
    assert_eq!(read(&there), read(&here));
    drop(server);
    let lost = out(&path, "lost");
    let (code, _, err) = baudbot(&["sweep", &path, "--out", &lost, "--connect", &tcp]);
    assert_eq!(code, 1);
    assert!(err.contains("no server answers at"), "{err}");
    assert_eq!(rows(&lost), 0);
}

#[test]
fn the_limit_of_a_field_is_found() {
    let path =
        experiment("find", &GRID.replace("collisions_at_most = 0", "staleness_mean_ms_at_most = 50.0"));
    let found = good(&["sweep", &path, "--find", "baud", "--seeds", "7..8"]);
    let lines: Vec<_> = found.lines().collect();
    assert_eq!(lines.len(), 4, "{found}");
    assert!(
        lines[0].starts_with("sensors all eight: lowest baud at which avoid:forward=0.3 has staleness_mean_ms at most 50 in 5 s: ")
            && lines[0].contains("(2 of 2 seeds, 95 % interval 34–100 %); at "),
        "{found}"
    );
    let (code, _, err) = baudbot(&["sweep", &path, "--find", "bau"]);
    assert_eq!(code, 2);
    assert!(err.starts_with("error: --find: there is no field `bau`; did you mean `baud`?"), "{err}");
}

#[test]
fn the_experiments_of_the_book_can_be_run() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../catalogue/experiments");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let text = std::fs::read_to_string(&path).unwrap();
        // The experiments whose brain is a program in Python are run by the tests of its package
        // (`client/python/tests`).
        let is_search = text.contains("[tune]") || text.contains("[require]");
        if !text.contains("[[fields]]") || is_search || text.contains("python3 ") {
            continue;
        }
        count += 1;
        // A moment of each instead of minutes.
        let name = path.file_stem().unwrap().to_str().unwrap();
        let rest = text.lines().filter(|line| !line.starts_with("seconds = "));
        let toml = ["seconds = 0.2"].into_iter().chain(rest).collect::<Vec<_>>().join("\n");
        let own = experiment(name, &toml);
        assert!(table(&[&own, "--seeds", "1"], &out(&own, "out")).lines().count() > 2, "{name}");
    }
    assert_eq!(count, 9);
}
