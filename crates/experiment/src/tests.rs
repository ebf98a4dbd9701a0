//! Experiments from their file to their outputs.

mod rare;
mod shards;
mod worst;
mod writes;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use crate::find::find;
use crate::fingerprint::{build, fingerprint};
use crate::journal::{Header, Journal};
use crate::{
    BRAIN_TIMEOUT, Error, Experiment, Options, Place, Row, RunError, Swept, Told, Workers, check, sweep,
};

const ROOM: &str = r#"
name = "room"
step_ms = 10.0
substeps = 10
[[arena.polygons]]
name = "wall"
solid = false
points_m = [[-1, -1], [1, -1], [1, 1], [-1, 1]]
[[robots]]
name = "alice"
preset = "khepera-1"
firmware = { protocol = "framed", mode = "stream", period_ms = 20.0, phase_ms = 17.6 }
link = { kind = "uart", baud = 38400 }
"#;

/// An experiment in a room with a robot that drives on blindly.
fn experiment(toml: &str) -> Result<Experiment, Error> {
    let head = if toml.contains("scenario =") { "" } else { "scenario = \"room.toml\"\n" };
    Experiment::parse(&(head.to_owned() + toml), "test", |_| Ok(ROOM.to_owned()))
}

/// The message with which an experiment is refused.
fn refused(toml: &str) -> String {
    let checked = experiment(toml).and_then(|experiment| experiment.runs().and_then(|_| check(&experiment)));
    checked.expect_err(toml).to_string()
}

/// A folder that is not there yet.
fn folder(name: &str) -> PathBuf {
    let path = std::env::temp_dir().join(format!("baudbot-experiment-{}-{name}", std::process::id()));
    let _ = std::fs::remove_dir_all(&path);
    path
}

fn run(experiment: &Experiment, out: &Path) -> Result<Swept, Error> {
    run_until(experiment, out, u64::MAX)
}

/// Stops after so many runs.
fn run_until(experiment: &Experiment, out: &Path, runs: u64) -> Result<Swept, Error> {
    let (stop, seen) = (AtomicBool::new(false), AtomicU64::new(0));
    let progress = |_, _| {
        if seen.fetch_add(1, Ordering::Relaxed) >= runs {
            stop.store(true, Ordering::Relaxed);
        }
    };
    sweep(experiment, &Options { stop: &stop, progress: &progress, ..options(out) })
}

fn options(out: &Path) -> Options<'_> {
    static GO_ON: AtomicBool = AtomicBool::new(false);
    Options {
        out,
        fresh: false,
        shard: None,
        place: Place::Here,
        jobs: 2,
        brain_timeout: BRAIN_TIMEOUT,
        confirmed: true,
        stop: &GO_ON,
        progress: &|_, _| {},
        tell: &|_| {},
    }
}

fn read(folder: &Path, name: &str) -> Vec<u8> {
    std::fs::read(folder.join(name)).unwrap()
}

const SMALL: &str = r#"
brain = "constant:left=0.4"
seconds = 3.0
seeds = 3
[[fields]]
field = "robots.alice.link.baud"
label = "baud"
values = [9600, 19200, 49]
[[fields]]
field = "brain.right"
values = [0.3, 0.4]
[[fields]]
label = "sensors"
levels = [
  { name = "all" },
  { name = "front", set = ["robots.alice.without=['ir_0', 'ir_5', 'ir_6', 'ir_7']"] },
]
[success]
collisions_at_most = 0
[[charts]]
figure = "collisions"
by = "sensors"
[[charts]]
figure = "success"
kind = "heat"
"#;

#[test]
fn an_experiment_of_one_or_two_fields_has_charts_without_asking() {
    let field = |name: &str| format!("[[fields]]\nfield = \"brain.{name}\"\nvalues = [0.1, 0.2]\n");
    let charts = |rest: &str| {
        let head = "scenario = \"room\"\nbrain = \"constant:left=0.4\"\nseconds = 1.0\nseeds = 2\n";
        let experiment = experiment(&format!("{head}{rest}")).unwrap();
        let drawn = crate::chart::Graphs::new(&experiment).draw(&experiment);
        drawn.into_iter().map(|(name, _)| name).collect::<Vec<_>>()
    };
    let (left, right) = (field("left"), field("right"));
    let success = "[success]\ncollisions_at_most = 0\n";
    assert_eq!(charts(&left), ["collisions.svg", "distance_m.svg"]);
    assert_eq!(charts(&format!("{left}{success}")), ["success.svg", "distance_m.svg"]);
    assert_eq!(
        charts(&format!("{left}{right}{success}")),
        ["success.svg", "success-heat.svg", "distance_m.svg", "distance_m-heat.svg"]
    );
    assert_eq!(charts(""), [""; 0]);
    assert_eq!(charts(&format!("{left}[[charts]]\nfigure = \"time_s\"\n")), ["time_s.svg"]);
}

/// A cable that damages bytes beside one that does not: how many exchanges that costs depends on the seed.
const CABLES: &str = r#"
brain = "constant:left=0.4"
seconds = 1.0
seeds = 4
[[fields]]
field = "brain.right"
label = "right"
values = [0.4, 0.5]
[[fields]]
label = "cable"
levels = [{ name = "good" }, { name = "bad", set = ["robots.alice.link.byte_error_rate=0.02"] }]
[[charts]]
figure = "exchanges_per_s"
difference = true
"#;

#[test]
fn a_chart_of_differences_is_of_pairs_and_draws_their_intervals() {
    let (experiment, out) = (experiment(CABLES).unwrap(), folder("difference"));
    run(&experiment, &out).unwrap();
    let rows = String::from_utf8(read(&out, "rows.csv")).unwrap();
    let column = rows.lines().next().unwrap().split(',').position(|name| name == "exchanges_per_s").unwrap();
    let rates: Vec<f64> =
        rows.lines().skip(1).map(|row| row.split(',').nth(column).unwrap().parse().unwrap()).collect();
    // The second combination is the first one's with the bad cable.
    let differences = crate::statistics::Sample::of((0..4).map(|i| rates[4 + i] - rates[i]));
    let svg = String::from_utf8(read(&out, "exchanges_per_s-difference.svg")).unwrap();
    let (mean, half) = (differences.mean().unwrap(), differences.half_width().unwrap());
    let number = baudbot_plot::scale::number;
    let words = format!(": {} ({} to {})", number(mean), number(mean - half), number(mean + half));
    assert!(mean < -0.5 && half > 0.1 && svg.contains(&words), "{words} {rates:?}");
    assert!(svg.contains("from right 0.4, cable good with the same seeds"));
    let _ = std::fs::remove_dir_all(out);
    for toml in
        [CABLES.replace("seeds = 4", "seeds = [4]"), format!("design = \"random\"\nsamples = 3\n{CABLES}")]
    {
        let told = refused(&toml);
        assert!(told.starts_with("charts[0].difference: needs several `seeds`"), "{told}");
    }
}

#[test]
fn a_sweep_makes_a_row_a_run_and_what_cannot_be_run_stops_no_other() {
    let (out, experiment) = (folder("rows"), experiment(SMALL).unwrap());
    let swept = run(&experiment, &out).unwrap();
    assert_eq!((swept.total, swept.done, swept.interrupted), (36, 36, false));
    assert_eq!(swept.summary.failed, 12, "{:?}", swept.summary.failures);
    let csv = String::from_utf8(read(&out, "rows.csv")).unwrap();
    let lines: Vec<_> = csv.lines().collect();
    assert!(
        lines[0].starts_with("run,cell,seed,baud,brain.right,sensors,error,ending,success,time_s,"),
        "{csv}"
    );
    assert!(lines[1].starts_with("0,0,1,9600,0.3,all,,the scenario's time is over,"), "{csv}");
    assert!(lines[36].starts_with("35,11,3,49,0.4,front,\"robots[0].link.baud: "), "{csv}");
    assert_eq!(lines.len(), 37);
    let text = String::from_utf8(read(&out, "summary.txt")).unwrap();
    assert!(text.contains("12 of 36 runs failed:\n  run 24: robots[0].link.baud: "), "{text}");
    for name in ["collisions.svg", "success-heat.svg"] {
        let svg = String::from_utf8(read(&out, name)).unwrap();
        assert!(roxmltree::Document::parse(&svg).is_ok(), "{svg}");
        assert!(svg.contains("test: constant:left=0.4 in room, 3 s, seeds 1 to 3"), "{svg}");
    }
}

#[test]
fn a_sweep_that_was_stopped_and_torn_goes_on_to_the_same_bytes() {
    let experiment = experiment(SMALL).unwrap();
    let (whole, torn) = (folder("whole"), folder("torn"));
    run(&experiment, &whole).unwrap();
    let stopped = run_until(&experiment, &torn, 9).unwrap();
    assert!(stopped.interrupted && stopped.done < 36, "{stopped:?}");
    assert!(!torn.join("rows.csv").exists());
    // The journal is torn as by a kill within a write.
    let journal = torn.join("rows.jsonl");
    let mut bytes = std::fs::read(&journal).unwrap();
    bytes.truncate(bytes.len() - 7);
    std::fs::write(&journal, bytes).unwrap();
    let resumed = run(&experiment, &torn).unwrap();
    assert_eq!(resumed.resumed, stopped.done - 1);
    for name in ["rows.csv", "rows.parquet", "summary.txt", "collisions.svg"] {
        assert!(read(&whole, name) == read(&torn, name), "{name} differs");
    }
    // Nothing is missing, so nothing is run; and another experiment does not get in.
    // A third of the runs fails, and is tried again in vain.
    assert_eq!(run(&experiment, &torn).unwrap().resumed, 24);
    let other = super::tests::experiment(&SMALL.replace("seeds = 3", "seeds = 4")).unwrap();
    let error = run(&other, &torn).unwrap_err().to_string();
    assert!(error.contains("belongs to another experiment") && error.contains("--fresh"), "{error}");
}

#[test]
fn the_parquet_table_has_what_the_csv_has() {
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::RowAccessor;
    let (out, experiment) = (folder("parquet"), experiment(SMALL).unwrap());
    run(&experiment, &out).unwrap();
    let csv = String::from_utf8(read(&out, "rows.csv")).unwrap();
    let file = SerializedFileReader::new(std::fs::File::open(out.join("rows.parquet")).unwrap()).unwrap();
    assert_eq!(file.metadata().file_metadata().num_rows(), 36);
    for (row, line) in file.get_row_iter(None).unwrap().zip(csv.lines().skip(1)) {
        let row = row.unwrap();
        let cells: Vec<_> = line.split(',').collect();
        assert_eq!(row.get_long(0).unwrap().to_string(), cells[0]);
        assert_eq!(row.get_double(3).unwrap().to_string(), cells[3]);
        assert_eq!(row.get_string(5).unwrap(), cells[5]);
        if cells[6].is_empty() {
            assert_eq!(row.get_bool(8).unwrap(), cells[8] == "1");
            assert_eq!(row.get_double(11).unwrap().to_string(), cells[11], "distance of {line}");
        }
    }
}

#[test]
fn paths_that_lead_nowhere_are_found_before_the_first_run_with_the_nearest_name_first() {
    let field = |path: &str| {
        format!("seconds = 1.0\nbrain = \"constant\"\n[[fields]]\nfield = \"{path}\"\nvalues = [1]\n")
    };
    for (path, expected) in [
        (
            "robots.alice.link.buad",
            "fields[0]: robots.alice.link.buad: there is no field `buad`; did you mean `baud`?",
        ),
        ("robots.alise.link.baud", "there is no element `alise`; there is only `alice`"),
        ("robots.alice.sensors.ir_O.range_m", "there is no sensor or actuator `ir_O`; did you mean `ir_0`?"),
        ("robots.alice.micro.ram_bytes", "there is no field `micro`; did you mean `"),
        ("step_ms.x", "it has no field `x`"),
        ("robots.link.baud", "there is no element `link`"),
        ("brain.letf", "there is no parameter of a brain `letf`; did you mean `left`?"),
        ("seed", "the seed is varied by `seeds`"),
    ] {
        let error = refused(&field(path));
        assert!(error.contains(expected), "{path}: {error}");
    }
}

#[test]
fn a_field_that_is_there_only_beside_another_value_is_no_mistake() {
    let toml = "seconds = 1.0\nbrain = \"constant\"\n\
        [[fields]]\nlabel = \"link\"\nlevels = [{ name = \"ideal\", set = [\"robots.alice.link={ kind = 'ideal' }\"] }, { name = \"uart\" }]\n\
        [[fields]]\nfield = \"robots.alice.link.baud\"\nvalues = [9600]\n";
    check(&experiment(toml).unwrap()).unwrap();
}

#[test]
fn what_makes_no_sense_is_refused_with_how_to_mend_it() {
    let fields = "[[fields]]\nfield = \"step_ms\"\nvalues = [10.0]\n";
    let with = |text: &str| format!("seconds = 1.0\nbrain = \"constant\"\n{text}\n");
    for (toml, expected) in [
        (with(""), "fields: is missing: give at least one [[fields]]"),
        (with("[[fields]]\nfield = \"step_ms\"\nvalues = []"), "fields[0].values: is empty"),
        (with("[[fields]]\nfield = \"step_ms\""), "fields[0]: has no values"),
        (with("[[fields]]\nfield = \"step_ms\"\nvalues = [1, 1]"), "fields[0].values: `1` appears twice"),
        (
            with("[[fields]]\nfield = \"step_ms\"\nlabel = \"run\"\nvalues = [1]"),
            "`run` is a column of the table already",
        ),
        (with("[[fields]]\nfield = \"step_ms\"\nfrom = 1.0\nto = 2.0"), "fields[0]: `from` and `to` are for"),
        (with("[[fields]]\nfield = \"step_ms\"\nfrom = 2.0\nto = 2.0"), "fields[0].to: must be more than"),
        (with("seeds = []") + fields, "seeds: is empty"),
        (with("seeds = 0") + fields, "seeds: must be at least 1"),
        (with("seeds = [1, 2, 1]") + fields, "seeds: 1 appears twice"),
        (with("seed = 2") + fields, "seed: goes with design = \"random\"; `seeds` sets"),
        (
            format!("seconds = 1.0\n{fields}[brain]\nname = \"avoid\""),
            "brain: is a table, which is for a program; write brain = \"avoid\"",
        ),
        (
            with(
                "[[fields]]\nfield = \"step_ms\"\nfrom = 1.0\nto = 2.0\n[tune]\nmaximize = { covered = 1.0 }",
            ),
            "fields[0]: is a range that is tuned: with its table [tune] this is an experiment for `baudbot tune`",
        ),
        (with("samples = 3") + fields, "samples: goes with design = \"random\""),
        (with("sedes = 3") + fields, "sedes: there is no field `sedes`; did you mean `seeds`?"),
        (
            with("[[charts]]\nfigure = \"colisions\"") + fields,
            "charts[0].figure: there is no figure `colisions`; did you mean `collisions`?",
        ),
        (with("[[charts]]\nfigure = \"success\"") + fields, "charts[0].figure: there is no [success]"),
        (
            "brain = \"constant\"\n".to_owned() + fields,
            "seconds: is missing, and room.toml sets no end.after_s",
        ),
        (
            "seconds = 1.0\nbrain = \"constnt\"\n".to_owned() + fields,
            "brain: no brain `constnt`; there are: constant",
        ),
        ("seconds = 1.0\nbrain = \"bob=constant\"\n".to_owned() + fields, "brain: there is no robot `bob`"),
        (
            with("seeds = 9000000000000000000\n[[fields]]\nfield = \"step_ms\"\nvalues = [1, 2, 3]"),
            "seeds: make 27000000000000000000 runs, and an experiment has at most 10000000",
        ),
        (
            with("seeds = 5000001\n[[fields]]\nfield = \"step_ms\"\nvalues = [1, 2]"),
            "seeds: make 10000002 runs",
        ),
        (
            with(
                "design = \"random\"\nsamples = 10000000\nseeds = 2\n[[fields]]\nfield = \"step_ms\"\nvalues = [1, 2]",
            ),
            "samples: make 20000000 runs",
        ),
    ] {
        let error = refused(&toml);
        assert!(error.contains(expected), "{toml}\n{error}");
    }
}

#[test]
fn a_place_that_two_fields_vary_is_refused_however_it_is_written() {
    let two = |first: &str, second: &str| {
        let fields = [first, second].map(|field| format!("[[fields]]\n{field}\n")).concat();
        format!("seconds = 1.0\nbrain = \"constant\"\n{fields}")
    };
    let baud = "field = \"robots.alice.link.baud\"\nvalues = [4800, 9600]";
    for (first, second) in [
        (baud, "field = \"robots.alice.link.baud\"\nlabel = \"b2\"\nvalues = [1200]"),
        (baud, "field = \"robots[0].link.baud\"\nlabel = \"b2\"\nvalues = [1200]"),
        (baud, "field = \"robots.0.link.baud\"\nlabel = \"b2\"\nvalues = [1200]"),
        (
            baud,
            "label = \"b2\"\nlevels = [{ name = \"a\" }, { name = \"b\", set = [\"robots[0].link.baud=1200\"] }]",
        ),
        ("field = \"brain.left\"\nvalues = [0.1]", "field = \"brain.left\"\nlabel = \"l\"\nvalues = [0.2]"),
        (
            "field = \"brain\"\nvalues = [\"avoid\"]",
            "field = \"brain\"\nlabel = \"b\"\nvalues = [\"wander\"]",
        ),
    ] {
        let error = refused(&two(first, second));
        assert!(error.starts_with("fields[1]: varies `"), "{error}");
        assert!(error.contains("which fields[0] varies already"), "{error}");
    }
    for (first, second) in [
        (baud, "field = \"robots.alice.start.x_m\"\nvalues = [0.1]"),
        (
            "field = \"brain\"\nvalues = [\"alice=avoid\"]",
            "field = \"brain\"\nlabel = \"b\"\nvalues = [\"wander\"]",
        ),
    ] {
        experiment(&two(first, second)).unwrap();
    }
}

#[test]
fn a_limit_is_found_by_bisection_and_its_neighbours_are_looked_at() {
    // At a fifth of 0.5 m/s a Khepera goes 0.3 m in 3 s, and the wall is at 1 m.
    let values = "seconds = 3.0\nseeds = 2\nbrain = \"constant\"\n\
        [[fields]]\nfield = \"robots.alice.start.x_m\"\nlabel = \"x\"\nvalues = [0.0, 0.9, 0.2, 0.1, 0.5, 0.7]\n\
        [[fields]]\nlabel = \"speed\"\nlevels = [{ name = \"slow\", set = [\"brain.left=0.2\", \"brain.right=0.2\"] }]\n\
        [success]\ncollisions_at_most = 0\n[find]\nwants = \"highest\"\n";
    let experiment = experiment(values).unwrap();
    let workers = Workers::new(Place::Here, 2, "find".into(), BRAIN_TIMEOUT);
    let limits = find(&experiment, "x", &workers, false, &AtomicBool::new(false), &|_| {}).unwrap().unwrap();
    let [limit] = &limits[..] else { panic!("{limits:?}") };
    let text = limit.text(&experiment, "x");
    assert!(limit.is_monotone(), "{limits:?}");
    assert!(
        text.starts_with("speed slow: highest x at which constant has no collision in 3 s: 0.5 (2 of 2 seeds, 95 % interval 34–100 %); at 0.7: 0 of 2"),
        "{text}"
    );
}

/// An experiment of two runs, its folder once they are done, and the lines of the journal there.
fn two_runs(name: &str) -> (Experiment, PathBuf, Vec<String>) {
    let toml = "brain = \"constant\"\nseconds = 0.1\nseeds = 2\n\
        [[fields]]\nfield = \"step_ms\"\nvalues = [10.0]\n[[charts]]\nfigure = \"collisions\"\n";
    let (experiment, out) = (experiment(toml).unwrap(), folder(name));
    run(&experiment, &out).unwrap();
    let lines = String::from_utf8(read(&out, "rows.jsonl")).unwrap().lines().map(str::to_owned).collect();
    (experiment, out, lines)
}

#[test]
fn a_file_that_is_no_journal_is_not_cut_but_a_torn_header_of_our_own_is() {
    let (experiment, out, lines) = two_runs("torn-header");
    let journal = out.join("rows.jsonl");
    for text in ["my only copy", "{\"sweep\":\"test\",\"fingerprint\":\"0\"}", "no\nnewline"] {
        std::fs::write(&journal, text).unwrap();
        let error = run(&experiment, &out).unwrap_err().to_string();
        assert!(error.contains("rows.jsonl is not the journal of an experiment"), "{error}");
        assert_eq!(std::fs::read_to_string(&journal).unwrap(), text);
    }
    for len in [1, 40, lines[0].len()] {
        std::fs::write(&journal, &lines[0][..len]).unwrap();
        let swept = run(&experiment, &out).unwrap();
        assert_eq!((swept.resumed, swept.done), (0, 2), "{len} bytes");
    }
}

/// The journal of an experiment of two runs.
fn journal(experiment: &Experiment, out: &Path, build: String) -> Journal {
    let header = Header::new("test", fingerprint(experiment), build, 2);
    let path = out.join("rows.jsonl");
    std::fs::write(&path, "").unwrap();
    Journal::open(&path, &header, &|_| {}).unwrap()
}

#[test]
fn a_damaged_line_is_told_of_and_its_run_done_again_to_the_same_table() {
    let (experiment, out, _) = two_runs("damaged");
    let (table, sound) = (read(&out, "rows.csv"), read(&out, "rows.jsonl"));
    // Bits of the header, of both rows, and the last one.
    for at in [9, 400, sound.len() / 2, sound.len() - 300, sound.len() - 1] {
        let mut bytes = sound.clone();
        bytes[at] ^= 0x10;
        std::fs::write(out.join("rows.jsonl"), &bytes).unwrap();
        let line = 1 + sound[..at].iter().filter(|byte| **byte == b'\n').count();
        let told = std::sync::Mutex::new(Vec::new());
        let tell = |text: &Told| told.lock().unwrap().push(text.to_string());
        let swept = sweep(&experiment, &Options { tell: &tell, ..options(&out) }).unwrap();
        let told = told.into_inner().unwrap();
        assert!(told[0].starts_with("warning: "), "{told:?}");
        assert!(told[0].contains(&format!("rows.jsonl: line {line} is ")), "byte {at}: {told:?}");
        assert_eq!(swept.resumed, if line == 1 { 2 } else { 1 }, "byte {at}");
        assert!(read(&out, "rows.csv") == table, "byte {at}");
        assert_eq!(run(&experiment, &out).unwrap().resumed, 2, "byte {at}: it is not mended");
    }
}

#[test]
fn a_run_that_failed_is_done_again_however_it_failed() {
    let (experiment, out, _) = two_runs("failed");
    let expected = read(&out, "rows.csv");
    let with = |error: &str| {
        let mut journal = journal(&experiment, &out, build());
        journal.append(&Row { run: 0, outcome: Err(RunError::new(error)) }).unwrap();
        journal.append(&crate::run(&experiment, &experiment.task(1))).unwrap();
        run(&experiment, &out).unwrap()
    };
    for error in ["the run panicked, which is a bug in baudbot: at 7", "there is no program `follow`"] {
        let again = with(error);
        assert_eq!((again.resumed, again.done, again.summary.failed), (1, 2, 0), "{error}");
        assert!(read(&out, "rows.csv") == expected, "{error}");
        assert_eq!(run(&experiment, &out).unwrap().resumed, 2, "{error}: the better row is not found");
    }
}

#[test]
fn what_is_taken_from_a_journal_is_told_and_a_program_that_is_newer_is_named() {
    let (mut experiment, out, _) = two_runs("told");
    let told = |experiment: &Experiment| {
        let told = std::sync::Mutex::new(Vec::new());
        let tell = |text: &Told| told.lock().unwrap().push(text.to_string());
        sweep(experiment, &Options { tell: &tell, ..options(&out) }).unwrap();
        told.into_inner().unwrap()
    };
    let journal = out.join("rows.jsonl").display().to_string();
    assert_eq!(
        told(&experiment),
        [format!("note: {journal} (the journal) has 2 of 2 runs; --fresh does them again")]
    );
    let mut half = self::journal(&experiment, &out, build());
    half.append(&crate::run(&experiment, &experiment.task(1))).unwrap();
    drop(half);
    let note = format!("note: {journal} (the journal) has 1 of 2 runs; --fresh does them again");
    assert_eq!(told(&experiment), [note]);
    let mut failed = self::journal(&experiment, &out, build());
    failed.append(&crate::run(&experiment, &experiment.task(0))).unwrap();
    failed.append(&Row { run: 1, outcome: Err(RunError::new("no")) }).unwrap();
    drop(failed);
    let note = format!(
        "note: {journal} (the journal) has 1 of 2 runs; 1 that failed are done again; --fresh does all again"
    );
    assert_eq!(told(&experiment), [note]);
    // A program, which is not started: all runs are there.
    experiment.folder.clone_from(&out);
    experiment.brains = vec!["exec:python3 follow.py".to_owned()];
    let header = Header::new("test", fingerprint(&experiment), build(), 2);
    std::fs::remove_file(out.join("rows.jsonl")).unwrap();
    let mut all = Journal::open(&out.join("rows.jsonl"), &header, &|_| {}).unwrap();
    let row = crate::run(&two_runs("told-rows").0, &experiment.task(0));
    (0..2).for_each(|run| all.append(&Row { run, ..row.clone() }).unwrap());
    let program = std::fs::File::create(out.join("follow.py")).unwrap();
    let hour = std::time::Duration::from_secs(3600);
    let now = std::time::SystemTime::now();
    program.set_modified(now - hour).unwrap();
    assert_eq!(told(&experiment).len(), 1);
    program.set_modified(now + hour).unwrap();
    let file = out.join("follow.py").display().to_string();
    let warning = format!("warning: {file} was changed after runs in the journal; --fresh does them again");
    assert_eq!(told(&experiment)[1..], [warning]);
}

#[test]
fn another_build_of_the_model_does_not_go_on_with_a_journal() {
    let (experiment, out, _) = two_runs("build");
    let own = build();
    let version = own.split(' ').next().unwrap();
    let other = format!("{version} 0123456789abcdef");
    drop(journal(&experiment, &out, other.clone()));
    let error = run(&experiment, &out).unwrap_err().to_string();
    assert!(
        error.contains("was begun by another build of baudbot, whose runs differ from this one's")
            && error.contains(&format!("(`{other}` instead of `{own}`)"))
            && error.contains("--fresh"),
        "{error}"
    );
}

#[test]
fn a_fresh_sweep_that_is_refused_deletes_nothing_and_one_that_is_done_deletes_all() {
    let (small, out, _) = two_runs("fresh");
    let all = || ["rows.jsonl", "rows.csv", "rows.parquet", "summary.txt", "collisions.svg"];
    let before = all().map(|name| read(&out, name));
    let mut long = small;
    long.seeds = crate::Seeds::From(1, 1_000_000);
    let fresh = || Options { fresh: true, ..options(&out) };
    let error = sweep(&long, &Options { confirmed: false, ..fresh() }).unwrap_err().to_string();
    assert!(error.contains("confirm with --yes"), "{error}");
    assert!(all().map(|name| read(&out, name)) == before, "it is gone");
    assert!(!out.join(".rows.jsonl.tmp").exists());
    let stop = AtomicBool::new(false);
    let progress = |done, _| stop.store(done > 20, Ordering::Relaxed);
    let swept = sweep(&long, &Options { stop: &stop, progress: &progress, ..fresh() }).unwrap();
    assert!(swept.interrupted && swept.resumed == 0, "{swept:?}");
    let left = all().map(|name| out.join(name).exists());
    assert_eq!(left, [true, false, false, false, false]);
    assert_eq!(run_until(&long, &out, 0).unwrap().resumed, swept.done);
}

#[test]
fn a_search_that_takes_long_must_be_meant() {
    let toml = "brain = \"constant\"\nseconds = 0.1\nseeds = 3000\n[success]\ncollisions_at_most = 0\n\
        [[fields]]\nfield = \"brain.left\"\nlabel = \"left\"\nvalues = [0.1, 0.2, 0.3, 0.4]\n";
    let mut experiment = experiment(toml).unwrap();
    let workers = Workers::new(Place::Here, 2, "find".into(), BRAIN_TIMEOUT);
    let look = |experiment: &Experiment, confirmed| {
        find(experiment, "left", &workers, confirmed, &AtomicBool::new(false), &|_| {})
    };
    let error = look(&experiment, false).unwrap_err();
    assert!(error.is_refusal());
    let error = error.to_string();
    assert!(error.starts_with("up to 12000 runs would take about "), "{error}");
    assert!(error.contains("confirm with --yes"), "{error}");
    experiment.seeds = crate::Seeds::From(1, 3);
    assert_eq!(look(&experiment, false).unwrap(), look(&experiment, true).unwrap());
}

/// A server that is full of worlds, which are called `w0`, `w1` and so on.
fn full_server(runtime: &tokio::runtime::Runtime) -> baudbot_server::Server {
    use baudbot_server::{MAX_WORLDS, Server, WorldConfig};
    let scenario = std::sync::Arc::new(baudbot_scenario::parse("step_ms = 10.0").unwrap());
    let worlds = (0..MAX_WORLDS).map(|i| WorldConfig::new(format!("w{i}"), scenario.clone()).paused(true));
    let builder = worlds.fold(Server::builder(), |builder, world| builder.world(world));
    let address = "127.0.0.1:0".parse().unwrap();
    runtime.block_on(builder.listen(address).serve()).unwrap()
}

#[test]
fn a_full_server_stops_a_sweep_which_goes_on_when_there_is_room_and_leaves_foreign_worlds_alone() {
    use baudbot_proto::v1::control_service_client::ControlServiceClient;
    use baudbot_proto::v1::{CreateWorldRequest, DeleteWorldRequest};
    let (experiment, here, _) = two_runs("not-full");
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    let server = full_server(&runtime);
    let address = server.addresses()[0].to_string();
    let out = folder("full");
    let there = || {
        let options = Options { place: Place::Server(address.clone()), jobs: 1, ..options(&out) };
        std::thread::scope(|scope| {
            let sweep = scope.spawn(|| sweep(&experiment, &options));
            // The server works only while this thread waits.
            runtime.block_on(async {
                while !sweep.is_finished() {
                    tokio::time::sleep(std::time::Duration::from_millis(1)).await;
                }
            });
            sweep.join().unwrap()
        })
    };
    let error = there().unwrap_err();
    assert!(matches!(&error, Error::Server(text) if text.contains("the server is full: ")), "{error}");
    assert_eq!(read(&out, "rows.jsonl").iter().filter(|&&byte| byte == b'\n').count(), 1, "an error is kept");
    let mut control = ControlServiceClient::new(runtime.block_on(server.channel()).unwrap());
    let delete = |world: &str| DeleteWorldRequest { world: world.to_owned() };
    let id = |out: &Path| String::from_utf8(read(out, ".lock")).unwrap();
    // A world that a sweep left here when it was killed, and one of a sweep in another folder.
    let world = |out: &Path| format!("{}-0", sweep::world_name(&id(out), out));
    let (own, foreign) = (world(&out), world(&here));
    assert_ne!(id(&out), id(&here));
    for (i, world) in [&own, &foreign].into_iter().enumerate() {
        runtime.block_on(control.delete_world(delete(&format!("w{i}")))).unwrap();
        let (world, scenario_toml) = (world.clone(), "step_ms = 10.0".to_owned());
        let request = CreateWorldRequest { world, scenario_toml, paused: true, ..Default::default() };
        runtime.block_on(control.create_world(request)).unwrap();
    }
    runtime.block_on(control.delete_world(delete("w7"))).unwrap();
    assert_eq!(there().unwrap().done, 2);
    assert!(read(&out, "rows.csv") == read(&here, "rows.csv"));
    assert!(runtime.block_on(control.delete_world(delete(&own))).is_err(), "it is left over");
    runtime.block_on(control.delete_world(delete(&foreign))).expect("it is not ours to delete");
    runtime.block_on(server.shutdown());
}

#[test]
fn a_folder_keeps_its_id_and_a_lock_of_something_else_is_left_alone() {
    let (experiment, out, _) = two_runs("id");
    let lock = out.join(".lock");
    let id = read(&out, ".lock");
    run(&experiment, &out).unwrap();
    assert!(read(&out, ".lock") == id && id.len() == 16, "{id:?}");
    std::fs::write(&lock, &id[..7]).unwrap();
    run(&experiment, &out).unwrap();
    assert!(read(&out, ".lock").len() == 16 && read(&out, ".lock") != id);
    std::fs::write(&lock, "pid 7").unwrap();
    let error = run(&experiment, &out).unwrap_err().to_string();
    assert!(error.contains(".lock does not belong to an experiment; choose another place"), "{error}");
    assert_eq!(read(&out, ".lock"), b"pid 7");
}
