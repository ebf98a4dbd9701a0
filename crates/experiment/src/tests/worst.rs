//! The search for the worst run, from the file to the case.

use std::fs;

use super::*;
use crate::figures::Figure;
use crate::statistics::clopper_pearson;
use crate::worst::Case;
use crate::{Limit, Shard, Task, Worst, local_runner, merge_worst, worst};

const HUNT: &str = r#"
brain = "constant:left=0.4"
seconds = 6.0
[require]
always = "clearance_m > 0.02"
[[fields]]
field = "robots.alice.start.heading_rad"
label = "heading_rad"
from = -3.0
to = 3.0
[[fields]]
field = "brain.right"
label = "right"
from = 0.3
to = 0.5
[[fields]]
field = "robots.alice.link.baud"
label = "baud"
values = [9600, 38400]
"#;

/// Faults that have nothing to do with a robot that drives on blindly.
const FAULTS: &str = r#"
[[robots.faults]]
kind = "sensor"
sensor = "ir_2"
from_s = 0.5
for_s = 0.5
[[robots.faults]]
kind = "brain"
every_s = 3.0
for_s = 0.2
"#;

fn limit(runs: u64) -> Limit {
    Limit { runs: Some(runs), within: None, first: false }
}

fn hunt(experiment: &Experiment, name: &str, runs: u64) -> Worst {
    let out = folder(name);
    let found = worst(experiment, &options(&out), limit(runs)).unwrap();
    let _ = fs::remove_dir_all(out);
    found
}

fn numbers(worst: &Worst) -> (u64, u64, Vec<(u64, u64, u64)>) {
    let runs = worst.worst.iter().map(|tried| (tried.task.run, tried.fall.robustness.to_bits(), tried.hash));
    (worst.runs, worst.fallen, runs.collect())
}

/// The case's scenario as an experiment of one run, by the way of sweeps.
fn again(experiment: &Experiment, case: &Case) -> Row {
    let mut alone = experiment.clone();
    (alone.text, alone.seconds, alone.fields) = (case.toml.clone(), None, Vec::new());
    case.brains.clone_into(&mut alone.brains);
    let task = Task { run: 0, cell: alone.cell(0), seed: baudbot_scenario::parse(&case.toml).unwrap().seed };
    local_runner::run(&alone, &task)
}

#[test]
fn the_worst_run_becomes_a_plain_scenario_that_fails_in_the_same_way() {
    let mut experiment = experiment(HUNT).unwrap();
    experiment.text += FAULTS;
    let found = hunt(&experiment, "plain", 60);
    assert!(found.fallen > 0 && found.worst.len() == 10 && found.failed == 0, "{found:?}");
    assert!(found.worst.is_sorted_by(|a, b| a.fall.order(&b.fall).is_le()));
    let case = found.case.as_ref().unwrap();
    let ran = again(&experiment, case).outcome.unwrap();
    let fall = ran.fall.unwrap();
    assert!(!fall.holds && fall.robustness < 0.0 && ran.hash == case.hash, "{fall:?}\n{}", case.toml);
    // Neither of the faults is needed, nor that the run goes on.
    assert!(!case.toml.contains("faults"), "{}", case.toml);
    let ends = case.toml.lines().find_map(|line| line.split_once("after_s = ")).unwrap().1;
    let ends_s: f64 = ends.trim_end_matches([' ', '}']).parse().unwrap();
    assert!(ends_s < fall.at_s() + 0.2 && ends_s < 6.0, "{ends_s} {fall:?}");
    let fields =
        case.changes.iter().filter(|change| !change.contains("without") && !change.starts_with("end."));
    assert!(fields.clone().count() <= 3, "{:?}", case.changes);
    // Nothing that is left can be left out.
    for change in fields.filter(|change| !change.starts_with("seed=")) {
        let path = change.split('=').next().unwrap();
        let key = path.rsplit('.').next().unwrap();
        let without: Vec<_> = case.toml.lines().map(|line| cut(line, key)).collect();
        let plainer = Case { toml: without.join("\n"), ..case.clone() };
        let fall = again(&experiment, &plainer).outcome.unwrap().fall.unwrap();
        assert!(fall.holds, "{change} is not needed:\n{}", plainer.toml);
    }
    assert!(case.account.starts_with("alice: always clearance_m > 0.02 fails by 0.0"), "{}", case.account);
}

/// The referee of the budget: what a search for the longest cycle finds lies between those of runs that nobody searched for, and the bound.
#[test]
fn the_longest_cycle_that_is_found_is_told_beside_the_bound_of_the_budget() {
    let toml = HUNT.replace("clearance_m > 0.02", "deadline_slack_ms > 1000");
    let experiment = experiment(&toml).unwrap();
    let found = hunt(&experiment, "cycles", 40);
    let case = found.case.as_ref().unwrap();
    let scenario = baudbot_scenario::parse(&case.toml).unwrap();
    let deadline_ns = scenario.robots[0].deadline.within_ns;
    let sampled = (1..=3).map(|seed| {
        let toml = case.toml.replace(&format!("seed = {}", scenario.seed), &format!("seed = {seed}"));
        let ran = again(&experiment, &Case { toml, ..case.clone() }).outcome.unwrap();
        deadline_ns as f64 - ran.figures.get(Figure::DeadlineSlackMinMs).unwrap() * 1e6
    });
    let sampled_ns = sampled.fold(0.0, f64::max);
    let tightness = case.tightness.unwrap();
    let (found_ns, bound_ns) = (tightness.found_ns as f64, tightness.bound_ns.unwrap() as f64);
    // Slack is in milliseconds, and so not to the last bit.
    assert!(sampled_ns <= found_ns + 1.0 && found_ns <= bound_ns, "{sampled_ns} {tightness:?}");
    assert!((0.5..=1.0).contains(&tightness.share().unwrap()), "{tightness}");
    let told = found.text(&experiment);
    assert!(told.contains(&format!("{:.2} of the {:.1} ms", found_ns / bound_ns, bound_ns / 1e6)), "{told}");
    // Any slack is less than that, so nothing of the scenario is needed but its end.
    assert!(case.is_plainest && told.contains("(made plain with "), "{told}");
}

/// The cable is out from 1 s to 1.3 s: what fails half a second later is explained by that, what fails much later is not.
#[test]
fn the_oldest_reading_is_that_of_the_second_before() {
    let age_ms = |fails_at_s: f64| {
        let toml = format!(
            "brain = \"constant:left=0\"\nseconds = 4.0\n[require]\nnever = \"time_s > {fails_at_s} and time_s < {}\"\n[worst]\nmethod = \"random\"\n",
            fails_at_s + 0.1
        );
        let mut experiment = experiment(&toml).unwrap();
        experiment.text = experiment
            .text
            .replace("baud = 38400", "baud = 38400, outages = [{ from_s = 1.0, for_s = 0.3 }]");
        let found = hunt(&experiment, &format!("gap-{fails_at_s}"), 1);
        found.worst[0].fall.stalest.unwrap().1
    };
    assert!((300.0..400.0).contains(&age_ms(1.8)), "{}", age_ms(1.8));
    assert!(age_ms(2.8) < 100.0, "{}", age_ms(2.8));
}

/// A line without a key of an inline table, or nothing if it is of that key alone.
fn cut(line: &str, key: &str) -> String {
    let is_alone =
        line.trim_start().starts_with(key) || line.contains(&format!("= {{ {key} = ")) && !line.contains(',');
    if is_alone { String::new() } else { line.to_owned() }
}

#[test]
fn a_search_is_the_same_however_it_is_done() {
    for method in ["random", "cma-es"] {
        // No run fails, so that no case is to be made plain.
        let toml = HUNT.replace("> 0.02", "> -1");
        let experiment = experiment(&format!("{toml}[worst]\nmethod = \"{method}\"\n")).unwrap();
        let whole = hunt(&experiment, &format!("whole-{method}"), 70);
        let out = folder(&format!("parts-{method}"));
        for (runs, jobs) in [(20, 1), (45, 3), (70, 2)] {
            let found = worst(&experiment, &Options { jobs, ..options(&out) }, limit(runs)).unwrap();
            assert_eq!(found.runs, runs);
        }
        // All runs are in the journal: none is done again.
        let lines = fs::read_to_string(out.join("rows.jsonl")).unwrap().lines().count();
        assert_eq!(lines, 71);
        let parts = worst(&experiment, &options(&out), limit(70)).unwrap();
        assert_eq!(numbers(&parts), numbers(&whole), "{method}");
        let _ = fs::remove_dir_all(out);
    }
}

#[test]
fn a_search_for_the_first_failure_ends_with_it() {
    let out = folder("first");
    let found =
        worst(&experiment_of("random"), &options(&out), Limit { first: true, ..limit(1000) }).unwrap();
    assert!(found.fallen == 1 && found.runs < 1000, "{} of {}", found.fallen, found.runs);
    // Nor does a run begin once the time is over: the first batch has 64.
    let mut experiment = experiment_of("random");
    experiment.seconds = Some(600.0);
    let soon = Limit { runs: None, within: Some(std::time::Duration::from_nanos(1)), first: false };
    let told = worst(&experiment, &options(&folder("soon")), soon).unwrap();
    assert_eq!(told.runs, 0);
    let _ = fs::remove_dir_all(out);
}

#[test]
fn shards_make_what_one_machine_makes() {
    let experiment = experiment(&format!("{HUNT}[worst]\nmethod = \"random\"\n")).unwrap();
    let whole = hunt(&experiment, "one", 60);
    let (out, shards) = (folder("merged"), folder("shards"));
    let all: Vec<_> = Shard::all(3).collect();
    let shard = |shard: Shard| {
        let out = shards.join(shard.folder());
        worst(&experiment, &Options { shard: Some(shard), ..options(&out) }, limit(60)).unwrap()
    };
    shard(all[0]);
    shard(all[2]);
    let sources = [shards.clone()];
    let error = merge_worst(&experiment, &sources, &options(&out), limit(60)).unwrap_err().to_string();
    assert!(error.contains("of the shards 1/3"), "{error}");
    shard(all[1]);
    let merged = merge_worst(&experiment, &sources, &options(&out), limit(60)).unwrap();
    assert_eq!(numbers(&merged), numbers(&whole));
    assert_eq!(merged.case, whole.case);
    let adapted = experiment_of("cma-es");
    let error = worst(&adapted, &Options { shard: Some(all[0]), ..options(&out) }, limit(9)).unwrap_err();
    assert!(error.to_string().starts_with("--shard: only the method `random` has shards"), "{error}");
    for folder in [out, shards] {
        let _ = fs::remove_dir_all(folder);
    }
}

fn experiment_of(method: &str) -> Experiment {
    experiment(&format!("{HUNT}[worst]\nmethod = \"{method}\"\n")).unwrap()
}

#[test]
fn what_is_required_of_nobody_is_told() {
    for (require, expected) in [
        ("always = \"age_ms(ir_9) < 3\"", "require: there is no sensor `ir_9`"),
        (
            "always = \"clearance_m > 0\"\nrobot = \"alcie\"",
            "require: there is no robot `alcie`; there is only `alice`",
        ),
    ] {
        let toml = HUNT.replace("always = \"clearance_m > 0.02\"", require);
        let error = worst(&experiment(&toml).unwrap(), &options(&folder("nobody")), limit(3))
            .unwrap_err()
            .to_string();
        assert!(error.contains(expected), "{error}");
    }
    let toml = HUNT.replace("always = \"clearance_m > 0.02\"", "eventually = \"distance_m > 1\"")
        + "[worst]\nmethod = \"splitting\"";
    let error =
        worst(&experiment(&toml).unwrap(), &options(&folder("later")), limit(3)).unwrap_err().to_string();
    assert!(error.starts_with("worst.method: `splitting` is for always and never"), "{error}");
}

/// A robot that stands, at a cable that damages bytes: readings grow old if several messages in a row are lost.
const LOSSES: &str = r#"
brains = ["alice=none"]
seconds = 1.0
seeds = [1]
[require]
always = "age_ms(ir_2) < 90 or time_s < 0.2"
[[fields]]
field = "robots.alice.link.byte_error_rate"
label = "rate"
values = [0.002]
"#;

/// The oracle is plain sampling.
#[test]
fn splitting_estimates_what_sampling_counts() {
    let sampled = LOSSES.replace("seeds = [1]", "seeds = 1") + "[worst]\nmethod = \"random\"\n";
    let sampled = hunt(&experiment(&sampled).unwrap(), "sampled", 1500);
    let (share, low, high) = clopper_pearson(sampled.fallen, sampled.runs).unwrap();
    assert!((0.005..0.1).contains(&share), "{share}");
    let split = LOSSES.to_owned() + "[worst]\nmethod = \"splitting\"\nparticles = 60\nrepeats = 5\n";
    let (split, out) = (experiment(&split).unwrap(), folder("split"));
    let error = worst(&split, &options(&out), limit(9)).unwrap_err().to_string();
    assert!(error.starts_with("--runs, --within and --first are for searches"), "{error}");
    let found = worst(&split, &options(&out), Limit { runs: None, within: None, first: false }).unwrap();
    let _ = fs::remove_dir_all(out);
    let split = found.likelihood.unwrap();
    let (from, to) = split.interval;
    assert!(from < high && low < to, "{split:?}, and {share} of {}: {low} to {high}", sampled.runs);
    assert!((split.probability / share - 1.0).abs() < 0.5, "{split:?} and {share}");
}
