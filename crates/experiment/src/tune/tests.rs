//! Tunings from their file to their outputs.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use super::{Tuned, tune};
use crate::{BRAIN_TIMEOUT, Error, Experiment, Options, Place, Told};

const ROOM: &str = r#"
name = "room"
step_ms = 10.0
[[arena.polygons]]
name = "wall"
solid = false
points_m = [[-1, -1], [1, -1], [1, 1], [-1, 1]]
[[robots]]
name = "alice"
preset = "khepera-1"
link = { kind = "uart", baud = 38400 }
"#;

/// An experiment whose goal is the distance that a robot drives in a second without a collision.
const STRAIGHT: &str = r#"
scenario = "room.toml"
brain = "constant:left=0.1"
seconds = 1.0
seeds = 2
[success]
collisions_at_most = 0
[[fields]]
field = "brain.left"
from = -0.2
to = 0.4
[[fields]]
field = "brain.right"
from = -0.2
to = 0.4
[tune]
maximize = { distance_m = 1.0 }
population = 6
generations = 5
check_seeds = 3
"#;

fn experiment(toml: &str) -> Result<Experiment, Error> {
    Experiment::parse(toml, "test", |_| Ok(ROOM.to_owned()))
}

/// A folder that is not there yet.
fn folder(name: &str) -> PathBuf {
    let path = std::env::temp_dir().join(format!("baudbot-experiment-{}-tune-{name}", std::process::id()));
    let _ = std::fs::remove_dir_all(&path);
    path
}

/// Stops after so many runs.
fn run_until(toml: &str, out: &Path, jobs: usize, runs: u64) -> Result<Tuned, Error> {
    run_and_tell(toml, out, jobs, runs, &|_| {})
}

fn run_and_tell(
    toml: &str,
    out: &Path,
    jobs: usize,
    runs: u64,
    tell: &(dyn Fn(&Told) + Sync),
) -> Result<Tuned, Error> {
    let (stop, seen) = (AtomicBool::new(false), AtomicU64::new(0));
    let progress = |done: u64, _| {
        if seen.fetch_max(done, Ordering::Relaxed).max(done) >= runs {
            stop.store(true, Ordering::Relaxed);
        }
    };
    let (place, fresh, confirmed) = (Place::Here, false, true);
    let experiment = experiment(toml)?;
    let (stop, progress, brain_timeout) = (&stop, &progress, BRAIN_TIMEOUT);
    let options =
        Options { out, fresh, shard: None, place, jobs, brain_timeout, confirmed, stop, progress, tell };
    tune(&experiment, &options)
}

fn run(toml: &str, name: &str) -> Tuned {
    let out = folder(name);
    let tuned = run_until(toml, &out, 2, u64::MAX).unwrap();
    std::fs::remove_dir_all(out).unwrap();
    tuned
}

fn refused(toml: &str) -> String {
    let out = folder("refused");
    let error = run_until(toml, &out, 2, u64::MAX).expect_err(toml).to_string();
    let _ = std::fs::remove_dir_all(out);
    error
}

fn read(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let names = super::outcome::FILES.iter();
    names.filter_map(|name| Some(((*name).to_owned(), std::fs::read(folder.join(name)).ok()?))).collect()
}

#[test]
fn each_method_makes_the_goal_larger_than_it_was() {
    for method in ["cma-es", "pso", "ga"] {
        let toml = format!("{STRAIGHT}method = \"{method}\"\n");
        let tuned = run(&toml, method);
        let score = |outcome: &super::Outcome| outcome.score().unwrap();
        let (best, untuned) = (tuned.best().unwrap(), tuned.untuned.as_ref().unwrap());
        assert!(score(&best.outcome) > 2.0 * score(&untuned.outcome), "{method}: {tuned:?}");
        assert!(best.values.iter().all(|value| (-0.2..=0.4).contains(value)), "{method}: {best:?}");
        let (checked, untuned) = tuned.checked.as_ref().unwrap();
        assert_eq!((checked.runs, untuned.runs), (3, 3));
        let text = tuned.text(&experiment(&toml).unwrap());
        assert!(text.contains("with 3 seeds that were not used in the search"), "{text}");
        assert!(text.contains("as options of `baudbot run`: --brain 'constant:left=0.1,left=0."), "{text}");
    }
}

#[test]
fn what_was_stopped_goes_on_and_any_number_of_threads_finds_the_same() {
    let (whole, parts) = (folder("whole"), folder("parts"));
    run_until(STRAIGHT, &whole, 4, u64::MAX).unwrap();
    for runs in [1, 7, 30] {
        let tuned = run_until(STRAIGHT, &parts, 1, runs).unwrap();
        assert!(tuned.interrupted && tuned.files.is_empty());
    }
    assert!(!run_until(STRAIGHT, &parts, 1, u64::MAX).unwrap().interrupted);
    let files = read(&whole);
    assert_eq!(files.len(), 3, "constant has no description");
    assert!(files == read(&parts));
    // All is there: nothing is run again.
    let journal = std::fs::read(parts.join("rows.jsonl")).unwrap();
    run_until(STRAIGHT, &parts, 1, u64::MAX).unwrap();
    assert_eq!(journal, std::fs::read(parts.join("rows.jsonl")).unwrap());
    [whole, parts].iter().for_each(|folder| std::fs::remove_dir_all(folder).unwrap());
}

#[test]
fn damaged_lines_are_told_of_and_their_runs_done_again_to_the_same_result() {
    let out = folder("damaged");
    run_until(STRAIGHT, &out, 2, u64::MAX).unwrap();
    let (files, path) = (read(&out), out.join("rows.jsonl"));
    let sound = std::fs::read(&path).unwrap();
    let mut bytes = sound.clone();
    let lines = bytes.split_inclusive_mut(|byte| *byte == b'\n').skip(3).step_by(7);
    let hit = lines.map(|line| line[line.len() / 2] ^= 1).count();
    std::fs::write(&path, &bytes).unwrap();
    let told = std::sync::Mutex::new(Vec::new());
    run_and_tell(STRAIGHT, &out, 2, u64::MAX, &|text| told.lock().unwrap().push(text.to_string())).unwrap();
    let mut told = told.into_inner().unwrap();
    assert!(told.pop().unwrap().ends_with(" runs; --fresh does them again"));
    assert_eq!(told.len(), hit);
    for (i, told) in told.iter().enumerate() {
        assert!(told.contains(&format!("rows.jsonl: line {} is damaged", 4 + 7 * i)), "{told}");
    }
    assert!(files == read(&out));
    let sorted = |bytes: &[u8]| {
        let mut lines: Vec<_> = bytes.split(|byte| *byte == b'\n').map(<[u8]>::to_vec).collect();
        lines.sort();
        lines
    };
    assert!(sorted(&sound) == sorted(&std::fs::read(&path).unwrap()), "other runs were done");
    std::fs::remove_dir_all(out).unwrap();
}

#[test]
fn more_generations_go_on_with_what_there_is_and_anything_else_does_not() {
    let out = folder("more");
    let first = run_until(STRAIGHT, &out, 2, u64::MAX).unwrap();
    let longer = STRAIGHT.replace("generations = 5", "generations = 7");
    let more = run_until(&longer, &out, 2, u64::MAX).unwrap();
    assert_eq!(first.candidates, more.candidates[..first.candidates.len()]);
    assert!(more.candidates.len() > first.candidates.len());
    let other = STRAIGHT.replace("distance_m = 1.0", "distance_m = 2.0");
    let error = run_until(&other, &out, 2, u64::MAX).unwrap_err().to_string();
    assert!(error.contains("belongs to another experiment"), "{error}");
    std::fs::remove_dir_all(out).unwrap();
}

#[test]
fn a_described_brain_is_written_down_with_its_numbers() {
    let timid = folder("timid.toml");
    let description = "[motor.stroll]\nkind = \"wander\"\nparameters = { forward = 0.1 } # slowly\nutility = { bias = 0.3 }\n";
    std::fs::write(&timid, description).unwrap();
    let toml = STRAIGHT.replace("constant:left=0.1", timid.to_str().unwrap());
    let toml = toml.replace("brain.left", "brain.motor.stroll.parameters.forward");
    let toml = toml.replace("brain.right", "brain.motor.stroll.parameters.turn");
    let out = folder("described");
    let tuned = run_until(&toml, &out, 2, u64::MAX).unwrap();
    let best = std::fs::read_to_string(out.join("best.toml")).unwrap();
    let forward = tuned.best().unwrap().values[0];
    assert!(
        best.contains(&format!("forward = {forward}"))
            && best.ends_with("# slowly\nutility = { bias = 0.3 }\n"),
        "{best}"
    );
    // A brain that is described in another way is another experiment.
    std::fs::write(&timid, description.replace("0.3", "0.2")).unwrap();
    let error = run_until(&toml, &out, 2, u64::MAX).unwrap_err().to_string();
    assert!(error.contains("belongs to another experiment"), "{error}");
    let wrong = toml.replace("stroll.parameters.turn", "strol.parameters.turn");
    assert!(refused(&wrong).starts_with("fields[1]: "), "{}", refused(&wrong));
    let wrong = toml.replace("stroll.parameters.turn", "stroll.parameters.trun");
    assert!(refused(&wrong).contains("has no parameter `trun`"), "{}", refused(&wrong));
    assert!(refused(&wrong).starts_with("fields[1]: "), "{}", refused(&wrong));
    std::fs::remove_dir_all(out).unwrap();
    std::fs::remove_file(timid).unwrap();
}

#[test]
fn what_cannot_be_tuned_is_refused_with_the_field_and_the_mend() {
    let (head, _) = STRAIGHT.split_once("[tune]").unwrap();
    assert!(refused(head).starts_with("tune: is missing: what to maximize, such as maximize = {"));
    let levels = STRAIGHT.replacen("from = -0.2\nto = 0.4", "values = [1, 2]", 1);
    assert!(refused(&levels).starts_with("fields[0]: has values instead of a range"));
    let few = STRAIGHT.replace("population = 6", "population = 2");
    assert_eq!(refused(&few), "tune.population: must be from 4 to 10000, is 2");
    let unknown = STRAIGHT.replace("population", "popluation");
    assert!(refused(&unknown).starts_with("tune.popluation: ") || refused(&unknown).contains("popluation"));
    let uncounted = STRAIGHT.replace("{ distance_m = 1.0 }", "{ covered = 1.0 }");
    assert!(refused(&uncounted).ends_with("`covered` was not counted, so there is no score"));
    let endless = STRAIGHT.replace("seeds = 2\n", "seeds = 1000000000000000000\n");
    let said = refused(&endless);
    assert!(said.starts_with("seeds: make ") && said.ends_with(" at most 10000000"), "{said}");
    let method = format!("{STRAIGHT}method = \"sgd\"\n");
    assert!(refused(&method).contains("cma-es"), "{}", refused(&method));
}

/// A run that does not reach its goal has no time to it; it is worse than one that does, and no reason to stop.
#[test]
fn the_way_to_a_goal_can_be_made_short() {
    let toml = STRAIGHT.replace("{ distance_m = 1.0 }", "{ goal_time_s = -1.0 }");
    let toml = toml.replace("constant:left=0.1", "constant").replace("seconds = 1.0", "seconds = 3.0");
    let toml = toml.replace("collisions_at_most = 0", "goal_reached = true");
    let room =
        ROOM.replacen("[[arena", "[end]\ngoal = { x_m = 0.25, y_m = 0.0, radius_m = 0.15 }\n[[arena", 1);
    let experiment = Experiment::parse(&toml, "test", |_| Ok(room)).unwrap();
    let (out, stop) = (folder("goal"), AtomicBool::new(false));
    let (place, fresh, confirmed) = (Place::Here, false, true);
    let (progress, tell) = (&|_, _| {}, &|_: &Told| {});
    let (stop, jobs, brain_timeout) = (&stop, 2, BRAIN_TIMEOUT);
    let options = Options {
        out: &out,
        fresh,
        shard: None,
        place,
        jobs,
        brain_timeout,
        confirmed,
        stop,
        progress,
        tell,
    };
    let tuned = tune(&experiment, &options).unwrap();
    assert_eq!(tuned.untuned.as_ref().unwrap().outcome.score(), None, "it stands");
    assert!(
        tuned.candidates.iter().any(|candidate| candidate.outcome.score().is_none()),
        "some drive elsewhere"
    );
    let best = tuned.best().unwrap();
    assert!(best.outcome.succeeded == 2 && best.outcome.score().unwrap() > -3.0, "{best:?}");
    std::fs::remove_dir_all(out).unwrap();
}
