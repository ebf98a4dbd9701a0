//! Experiments from their file to their outputs.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use crate::find::find;
use crate::{Error, Experiment, Options, Place, Swept, Workers, check, sweep};

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
firmware = { mode = "stream", period_ms = 20.0, phase_ms = 17.6 }
link = { kind = "uart", baud = 38400 }
"#;

/// An experiment in a room with a robot that drives on blindly.
fn experiment(toml: &str) -> Result<Experiment, Error> {
    let head = if toml.contains("scenario =") { "" } else { "scenario = \"room.toml\"\n" };
    Experiment::parse(&(head.to_owned() + toml), "test", |_| Ok(ROOM.to_owned()))
}

/// What is wrong with it.
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
    let options = Options {
        out,
        fresh: false,
        place: Place::Here,
        jobs: 2,
        confirmed: true,
        stop: &stop,
        progress: &progress,
    };
    sweep(experiment, &options)
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
    assert!(text.contains("12 of 36 runs could not be:\n  run 24: robots[0].link.baud: "), "{text}");
    for name in ["collisions.svg", "success-heat.svg"] {
        let svg = String::from_utf8(read(&out, name)).unwrap();
        assert!(roxmltree::Document::parse(&svg).is_ok(), "{svg}");
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
    // As if it had been killed within a write.
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
    assert_eq!(run(&experiment, &torn).unwrap().resumed, 36);
    let other = super::tests::experiment(&SMALL.replace("seeds = 3", "seeds = 4")).unwrap();
    let error = run(&other, &torn).unwrap_err().to_string();
    assert!(error.contains("is of another experiment") && error.contains("--fresh"), "{error}");
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
        (with("[[fields]]\nfield = \"step_ms\"\nvalues = [1, 1]"), "fields[0].values: `1` is there twice"),
        (
            with("[[fields]]\nfield = \"step_ms\"\nlabel = \"run\"\nvalues = [1]"),
            "`run` is a column of the table already",
        ),
        (with("[[fields]]\nfield = \"step_ms\"\nfrom = 1.0\nto = 2.0"), "fields[0]: `from` and `to` are for"),
        (with("[[fields]]\nfield = \"step_ms\"\nfrom = 2.0\nto = 2.0"), "fields[0].to: must be more than"),
        (with("seeds = []") + fields, "seeds: is empty"),
        (with("seeds = 0") + fields, "seeds: must be at least 1"),
        (with("seeds = [1, 2, 1]") + fields, "seeds: 1 is there twice"),
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
            "there are more than 2^63 runs",
        ),
    ] {
        let error = refused(&toml);
        assert!(error.contains(expected), "{toml}\n{error}");
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
    let workers = Workers { place: Place::Here, jobs: 2, name: "find".into() };
    let limits = find(&experiment, "x", &workers, &AtomicBool::new(false), &|_| {}).unwrap().unwrap();
    let [limit] = &limits[..] else { panic!("{limits:?}") };
    let text = limit.text(&experiment, "x");
    assert!(limit.is_monotone(), "{limits:?}");
    assert!(
        text.starts_with("speed slow: highest x at which constant has no collision in 3 s: 0.5 (2 of 2 seeds, 95 % interval 34–100 %); at 0.7: 0 of 2"),
        "{text}"
    );
}
