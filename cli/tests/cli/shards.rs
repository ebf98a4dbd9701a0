//! `baudbot sweep --shard` and `--merge`: many machines make what one makes, whatever becomes of them.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use crate::cli::sweep::{GRID, experiment, out, table, wait_for_rows};
use crate::cli::{Running, baudbot, command, said};

/// All that a sweep leaves for people.
fn outputs(folder: &str) -> BTreeMap<PathBuf, Vec<u8>> {
    let names = fs::read_dir(folder).unwrap().map(|entry| PathBuf::from(entry.unwrap().file_name()));
    let names = names.filter(|name| name != Path::new(".lock") && name != Path::new("rows.jsonl"));
    names.map(|name| (name.clone(), fs::read(Path::new(folder).join(name)).unwrap())).collect()
}

/// Does a shard to its end, in the folder of an experiment; returns its output.
fn shard(experiment: &str, shard: &str, more: &[&str]) -> String {
    let (code, stdout, stderr) =
        in_folder(experiment, &[&["sweep", experiment, "--shard", shard], more].concat());
    assert_eq!((code, stdout.as_str()), (0, ""), "{stderr}");
    stderr
}

/// The program in the folder of an experiment: its code, stdout and stderr.
fn in_folder(experiment: &str, args: &[&str]) -> (i32, String, String) {
    said(command(args).current_dir(Path::new(experiment).parent().unwrap()).output().unwrap())
}

#[test]
fn eight_shards_one_of_which_is_killed_make_the_files_of_one_process() {
    let grid = experiment("shards", &GRID.replace("seconds = 5.0", "seconds = 20.0"));
    let (whole, merged, shards) = (out(&grid, "whole"), out(&grid, "merged"), out(&grid, "grid.shards"));
    let expected = table(&[&grid], &whole);
    for index in [7, 2, 0, 1, 6, 4, 3] {
        let told = shard(&grid, &format!("{index}/8"), &[]);
        let place = format!("grid.shards/{index}-of-8/rows.jsonl");
        assert_eq!(told, format!("shard {index}/8: all of its 9 runs are recorded in {place}\n"));
    }
    let killed = out(&grid, "grid.shards/5-of-8");
    let running = Running::start(&["sweep", &grid, "--shard", "5/8", "--out", &killed, "--jobs", "1"]);
    wait_for_rows(&killed, 2);
    // SIGKILL.
    drop(running);
    let merge = ["sweep", &grid, "--merge", &shards, "--out", &merged];
    let (code, stdout, err) = baudbot(&merge);
    assert_eq!((code, stdout.as_str()), (1, ""), "{err}");
    assert!(!Path::new(&merged).exists());
    // The commands that it lists are all that has to be done.
    let lines: Vec<_> = err.lines().filter(|line| !line.starts_with("warning: ")).collect();
    assert!(
        lines[0].ends_with(" of 72 runs are missing, so nothing was written; these commands do them:"),
        "{err}"
    );
    let command = format!("baudbot sweep {grid} --shard 5/8 --out {killed}  # ");
    assert!(lines.len() == 2 && lines[1].starts_with(&command) && lines[1].contains(" missing: "), "{err}");
    let words: Vec<_> = lines[1].split("  #").next().unwrap().split(' ').skip(1).collect();
    assert_eq!(baudbot(&words).0, 0);
    let (code, printed, _) = baudbot(&merge);
    assert_eq!((code, printed), (0, baudbot(&["sweep", &grid, "--out", &whole]).1));
    let (a, b) = (outputs(&whole), outputs(&merged));
    assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>());
    assert!(a.contains_key(Path::new("rows.parquet")) && a.contains_key(Path::new("collisions.svg")));
    assert!(a == b, "a file differs");
    assert_eq!(table(&[&grid], &merged), expected);
}

#[test]
fn shards_that_were_never_begun_are_named_with_their_commands() {
    let grid = experiment("unbegun", &GRID.replace("seconds = 5.0", "seconds = 0.1"));
    shard(&grid, "0/3", &["--seeds", "4..6", "--quiet"]);
    let merge = ["sweep", "experiment.toml", "--merge", "grid.shards", "--seeds", "4..6"];
    let (code, _, err) = in_folder(&grid, &merge);
    assert_eq!(code, 1);
    let lines: Vec<_> = err.lines().collect();
    assert_eq!(lines[0], "error: 48 of 72 runs are missing, so nothing was written; these commands do them:");
    for (line, index) in lines[1..].iter().zip(1..3) {
        let command = format!("baudbot sweep experiment.toml --seeds 4..6 --shard {index}/3  # 24 missing: ");
        assert!(line.starts_with(&command) && line.ends_with(", …"), "{err}");
        let words: Vec<_> = line.split("  #").next().unwrap().split(' ').skip(1).collect();
        assert_eq!(in_folder(&grid, &words).0, 0);
    }
    assert_eq!(lines.len(), 3, "{err}");
    assert_eq!(in_folder(&grid, &merge).0, 0);
    // The same experiment with other seeds is another one.
    let (code, _, err) = in_folder(&grid, &merge[..4]);
    assert_eq!(code, 2);
    assert!(
        err.contains("0-of-3/rows.jsonl belongs to another experiment") && err.contains("--seeds"),
        "{err}"
    );
}

#[test]
fn failed_runs_fail_the_merge_and_no_shard() {
    let grid = GRID.replace("seconds = 5.0", "seconds = 0.1").replace("values = [2400", "values = [49");
    let grid = experiment("failing", &grid);
    let told = shard(&grid, "0/2", &[]);
    assert!(told.starts_with("shard 0/2: all of its 36 runs are recorded in "), "{told}");
    assert!(told.ends_with(" of them failed\n"), "{told}");
    let (code, json, _) = in_folder(&grid, &["sweep", &grid, "--shard", "1/2", "--json"]);
    assert_eq!(code, 0);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!((&json["shard"], &json["runs"]), (&"1/2".into(), &36.into()));
    assert_eq!(json["failed"].as_u64().unwrap() as usize, json["failures"].as_array().unwrap().len());
    let (code, text, _) =
        in_folder(&grid, &["sweep", &grid, "--merge", "grid.shards/0-of-2", "grid.shards/1-of-2"]);
    assert_eq!(code, 1);
    assert!(text.contains("12 of 72 runs failed"), "{text}");
}

#[test]
fn what_has_no_shards_is_refused_with_the_reason() {
    let grid = experiment("refused-shards", GRID);
    let refused = |args: &[&str]| {
        let (code, stdout, err) = in_folder(&grid, args);
        assert_eq!((code, stdout.as_str()), (2, ""), "{args:?}: {err}");
        err
    };
    let err = refused(&["sweep", &grid, "--shard", "8/8"]);
    assert!(err.contains("shards are numbered from 0, as Kubernetes' JOB_COMPLETION_INDEX is"), "{err}");
    assert!(err.contains("so the last of 8 is 7/8"), "{err}");
    let err = refused(&["sweep", &grid, "--shard", "/8"]);
    assert!(err.contains("a shard is I/N"), "{err}");
    for option in [["--shard", "0/8"], ["--merge", "x"]] {
        let err = refused(&["sweep", &grid, "--find", "baud", option[0], option[1]]);
        assert!(
            err.starts_with(&format!("error: {}: --find has no shards, as each value", option[0])),
            "{err}"
        );
    }
    let err = refused(&["tune", &grid, "--shard", "0/8"]);
    assert!(err.starts_with("error: --shard: tuning has no shards, as each generation depends"), "{err}");
    let err = refused(&["sweep", &grid, "--shard", "0/8", "--merge", "x"]);
    assert!(err.contains("cannot be used with"), "{err}");
}
