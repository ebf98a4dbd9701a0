//! `baudbot tune`: its output and its files.

use std::path::{Path, PathBuf};

use crate::cli::{baudbot, good};

/// The tuning of the book in short: half a minute, two generations of four.
fn short(name: &str) -> (String, String) {
    let book = Path::new(env!("CARGO_MANIFEST_DIR")).join("../catalogue/experiments/tune-sweeper.toml");
    let toml = std::fs::read_to_string(&book).unwrap();
    let toml = toml.replace("1800.0", "30.0").replace("seeds = 3", "seeds = 1");
    let toml = toml.replace("generations = 20", "generations = 2\npopulation = 4");
    let toml = toml.replace("check_seeds = 10", "check_seeds = 2");
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("tune-{name}"));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("experiment.toml");
    std::fs::write(&path, toml).unwrap();
    (path.to_str().unwrap().to_owned(), folder.join("out").to_str().unwrap().to_owned())
}

#[test]
fn the_tuning_of_the_book_can_be_run_and_what_it_found_drives() {
    let (experiment, out) = short("book");
    let (code, told, err) = baudbot(&["tune", &experiment, "--out", &out]);
    assert_eq!((code, err.lines().count()), (0, 4), "{err}");
    assert!(told.contains("by 8 candidates in 2 generations, each with 1 seed"), "{told}");
    assert!(told.contains("with 2 seeds that were not used in the search"), "{told}");
    let read = |name: &str| std::fs::read_to_string(Path::new(&out).join(name)).unwrap();
    assert_eq!(read("summary.txt"), told);
    assert_eq!(read("candidates.csv").lines().count(), 1 + 1 + 8);
    assert!(read("trace.svg").starts_with("<svg "));
    assert!(read("best.toml").contains("# How full the battery is, from 0 to 1."), "comments stay");
    let best = Path::new(&out).join("best.toml");
    let scenario = Path::new(env!("CARGO_MANIFEST_DIR")).join("../catalogue/scenarios/sweeper.toml");
    let (scenario, best) = (scenario.to_str().unwrap(), best.to_str().unwrap());
    // The described brain with the seed of the search does what the candidate did.
    let described = ["run", scenario, "--brain", best, "--seconds", "30", "--json"];
    let options = told.lines().last().unwrap().split_once("--brain '").unwrap().1.trim_end_matches('\'');
    let set = ["run", scenario, "--brain", options, "--seconds", "30", "--json"];
    let hash = |args: &[&str]| {
        let summary: serde_json::Value = serde_json::from_str(&good(args)).unwrap();
        summary["state_hash"].clone()
    };
    assert!(hash(&described).is_string() && hash(&described) == hash(&set), "{}", hash(&set));
    let json: serde_json::Value =
        serde_json::from_str(&good(&["tune", &experiment, "--out", &out, "--json", "--quiet"])).unwrap();
    assert_eq!(json["candidates"], 8);
}

#[test]
fn a_tuning_that_is_to_be_swept_is_told_with_its_command() {
    let (code, _, error) = baudbot(&["sweep", "tune-sweeper"]);
    assert_eq!(code, 2, "{error}");
    assert!(error.starts_with("error: tune-sweeper: fields[0]: "), "{error}");
    assert!(error.contains("this is an experiment for `baudbot tune`"), "{error}");
}

#[test]
fn an_experiment_that_says_nothing_of_tuning_is_refused() {
    let book = Path::new(env!("CARGO_MANIFEST_DIR")).join("../catalogue/experiments/ftdi.toml");
    let (code, _, error) = baudbot(&["tune", book.to_str().unwrap()]);
    assert_eq!(code, 2, "{error}");
    assert!(error.contains("ftdi.toml: tune: is missing: what to maximize"), "{error}");
}
