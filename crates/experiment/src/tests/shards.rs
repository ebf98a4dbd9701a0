//! Shards of an experiment, and their merge.

use std::collections::BTreeMap;
use std::fs;

use super::*;
use crate::{Merged, Missing, Shard, merge};

/// The files of a sweep in its folder, but for the differences from sweep to sweep: the order of the journal's lines,
/// and the lock.
fn outputs(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(folder).unwrap().map(Result::unwrap);
    let mut all: BTreeMap<_, _> = entries
        .filter(|entry| entry.file_name() != ".lock")
        .map(|entry| (entry.file_name().into_string().unwrap(), fs::read(entry.path()).unwrap()))
        .collect();
    let journal = String::from_utf8(all["rows.jsonl"].clone()).unwrap();
    let mut lines: Vec<_> = journal.lines().collect();
    lines[1..].sort_unstable();
    all.insert("rows.jsonl".to_owned(), lines.join("\n").into_bytes());
    all
}

fn assert_same(a: &Path, b: &Path) {
    let (a, b) = (outputs(a), outputs(b));
    assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>());
    assert!(a.len() >= 6, "with tables, a summary and charts: {:?}", a.keys());
    for (name, content) in a {
        assert!(content == b[&name], "{name} differs");
    }
}

fn shard(text: &str) -> Option<Shard> {
    Some(text.parse().unwrap())
}

fn run_shard(experiment: &Experiment, text: &str, out: &Path) -> Swept {
    sweep(experiment, &Options { shard: shard(text), ..options(out) }).unwrap()
}

/// All shards, in folders of a folder.
fn run_shards(experiment: &Experiment, count: u32, out: &Path) {
    for shard in Shard::all(count) {
        run_shard(experiment, &shard.to_string(), &out.join(shard.folder()));
    }
}

fn whole(experiment: &Experiment, sources: &[PathBuf], out: &Path) -> Swept {
    match merge(experiment, sources, &options(out)).unwrap() {
        Merged::Whole(swept) => swept,
        Merged::Missing(missing) => panic!("{missing:?}"),
    }
}

fn missing(experiment: &Experiment, sources: &[PathBuf], out: &Path) -> Missing {
    match merge(experiment, sources, &options(out)).unwrap() {
        Merged::Whole(swept) => panic!("{swept:?}"),
        Merged::Missing(missing) => missing,
    }
}

fn refused_merge(experiment: &Experiment, sources: &[PathBuf], out: &Path) -> String {
    merge(experiment, sources, &options(out)).expect_err("it is merged").to_string()
}

#[test]
fn shards_make_what_one_machine_makes_byte_for_byte_also_if_some_have_nothing_to_do() {
    let experiment = experiment(SMALL).unwrap();
    let alone = folder("alone");
    let expected = run(&experiment, &alone).unwrap();
    for count in [1, 8, 60] {
        let (shards, out) = (folder(&format!("shards-{count}")), folder(&format!("merged-{count}")));
        run_shards(&experiment, count, &shards);
        assert_eq!(outputs(&shards.join(format!("0-of-{count}"))).keys().collect::<Vec<_>>(), ["rows.jsonl"]);
        let merged = whole(&experiment, &[shards], &out);
        assert_eq!(merged.summary.json(&experiment), expected.summary.json(&experiment));
        assert_eq!((merged.total, merged.done, merged.interrupted), (36, 36, false));
        assert_same(&alone, &out);
        // The folder is that of a sweep that is over.
        assert_eq!(run(&experiment, &out).unwrap().resumed, 24);
        assert_same(&alone, &out);
    }
}

#[test]
fn a_shard_that_was_stopped_and_torn_goes_on_and_its_folder_takes_no_other() {
    let experiment = experiment(SMALL).unwrap();
    let (alone, shards, out) = (folder("alone-2"), folder("shards-stopped"), folder("merged-stopped"));
    run(&experiment, &alone).unwrap();
    for index in [0, 2] {
        run_shard(&experiment, &format!("{index}/3"), &shards.join(index.to_string()));
    }
    let torn = shards.join("1");
    let (stop, seen) = (AtomicBool::new(false), AtomicU64::new(0));
    let progress = |_, _| stop.store(seen.fetch_add(1, Ordering::Relaxed) >= 4, Ordering::Relaxed);
    // One worker is at most three runs ahead of the journal, which is before the shard's last four runs, that fail.
    let stopping =
        Options { stop: &stop, progress: &progress, shard: shard("1/3"), jobs: 1, ..options(&torn) };
    let stopped = sweep(&experiment, &stopping).unwrap();
    assert!(stopped.interrupted && (4..8).contains(&stopped.done) && stopped.total == 12, "{stopped:?}");
    let journal = torn.join("rows.jsonl");
    let mut bytes = fs::read(&journal).unwrap();
    bytes.truncate(bytes.len() - 7);
    fs::write(&journal, &bytes).unwrap();
    // The merge reads it as it is, and names the shard that has to go on.
    let lacks = missing(&experiment, std::slice::from_ref(&shards), &out);
    assert_eq!((lacks.runs, lacks.total, lacks.shards.len()), (13 - stopped.done, 36, 1));
    assert_eq!((lacks.shards[0].shard, lacks.shards[0].runs), (shard("1/3"), lacks.runs));
    assert_eq!(lacks.shards[0].folder.as_ref(), Some(&torn));
    assert!(fs::read(&journal).unwrap() == bytes && !out.exists(), "it only reads");
    for other in [shard("2/3"), shard("1/4"), None] {
        let error = sweep(&experiment, &Options { shard: other, ..options(&torn) }).unwrap_err().to_string();
        assert!(error.contains("rows.jsonl is for shard 1/3, not for "), "{error}");
    }
    let resumed = run_shard(&experiment, "1/3", &torn);
    assert_eq!((resumed.resumed, resumed.done), (stopped.done - 1, 12));
    whole(&experiment, &[shards], &out);
    assert_same(&alone, &out);
    let error =
        sweep(&experiment, &Options { shard: shard("0/3"), ..options(&out) }).unwrap_err().to_string();
    assert!(error.contains("is for all runs, not for shard 0/3"), "{error}");
}

#[test]
fn what_is_missing_is_named_by_shard_and_run() {
    let experiment = experiment(SMALL).unwrap();
    let (shards, out) = (folder("shards-missing"), folder("merged-missing"));
    for index in [0, 1, 3] {
        run_shard(&experiment, &format!("{index}/4"), &shards.join(format!("{index}-of-4")));
    }
    let lacks = missing(&experiment, std::slice::from_ref(&shards), &out);
    assert_eq!((lacks.runs, lacks.total, lacks.shards.len()), (9, 36, 1));
    let lack = &lacks.shards[0];
    let runs: Vec<_> = shard("2/4").unwrap().runs(36).collect();
    assert_eq!((lack.shard, lack.runs, &*lack.first), (shard("2/4"), 9, &runs[..3]));
    assert_eq!(lack.folder, Some(shards.join("2-of-4")));
    // A sweep without shards has to go on itself; all that counts for parts is that none of them is missing.
    let begun = folder("begun");
    run_until(&experiment, &begun, 5).unwrap();
    let lacks = missing(&experiment, std::slice::from_ref(&begun), &out);
    assert_eq!((lacks.shards[0].shard, lacks.shards[0].folder.as_ref()), (None, Some(&begun)));
    let half = folder("half");
    run_shard(&experiment, "0/2", &half);
    run_shard(&experiment, "1/2", &folder("other-half"));
    let parts = [half.join("rows.jsonl"), folder_of("other-half"), shards, begun];
    assert_eq!(whole(&experiment, &parts, &out).done, 36);
    let nothing = folder("nothing");
    fs::create_dir_all(nothing.join("a")).unwrap();
    let error = refused_merge(&experiment, std::slice::from_ref(&nothing), &out);
    assert!(
        error.contains("has no rows.jsonl, nor has a folder in it; give the folders of the shards"),
        "{error}"
    );
    let error = refused_merge(&experiment, &[nothing.join("b")], &out);
    assert!(error.starts_with("cannot read "), "{error}");
}

/// The path of a folder that is there.
fn folder_of(name: &str) -> PathBuf {
    std::env::temp_dir().join(format!("baudbot-experiment-{}-{name}", std::process::id()))
}

#[test]
fn journals_that_do_not_belong_together_are_refused_with_the_reason() {
    let experiment = experiment(SMALL).unwrap();
    let (shards, out) = (folder("shards-foreign"), folder("merged-foreign"));
    run_shards(&experiment, 2, &shards);
    let foreign = shards.join("foreign");
    let other = super::experiment(&SMALL.replace("seeds = 3", "seeds = 4")).unwrap();
    run_shard(&other, "0/9", &foreign);
    let refused = || refused_merge(&experiment, std::slice::from_ref(&shards), &out);
    assert!(refused().contains("foreign/rows.jsonl belongs to another experiment"), "{}", refused());
    // The journal is of another build.
    fs::remove_dir_all(&foreign).unwrap();
    fs::create_dir(&foreign).unwrap();
    let of_build = |build: String| Header::new("test", fingerprint(&experiment), build, 36);
    let begin = |header| Journal::open(&foreign.join("rows.jsonl"), &header, &|_| {}).unwrap();
    drop(begin(of_build("0.0.0 other".to_owned())));
    assert!(refused().contains("by another build of baudbot") && refused().contains("0.0.0 other"));
    fs::remove_file(foreign.join("rows.jsonl")).unwrap();
    // Twice the same is fine.
    let mut own = begin(of_build(build()));
    let first =
        Journal::open(&shards.join("0-of-2/rows.jsonl"), &of_build(build()).of_shard(shard("0/2")), &|_| {});
    let row = first.unwrap().rows().unwrap().next().unwrap().unwrap();
    own.append(&row).unwrap();
    assert_eq!(whole(&experiment, std::slice::from_ref(&shards), &out).done, 36);
    // And again, into the same folder.
    assert_eq!(whole(&experiment, std::slice::from_ref(&shards), &out).resumed, 24);
    // Not so another result of it, nor beside what was merged before.
    fs::remove_file(foreign.join("rows.jsonl")).unwrap();
    let ran = row.outcome.clone().map(|ran| crate::Ran { hash: !ran.hash, ..ran });
    let wrong = Row { outcome: ran, ..row };
    begin(of_build(build())).append(&wrong).unwrap();
    let error = refused();
    assert!(error.starts_with(&format!("run {} has different results in line ", wrong.run)), "{error}");
    assert!(
        error.contains("0-of-2/rows.jsonl and line 2 of ") && error.contains("foreign/rows.jsonl; "),
        "{error}"
    );
    fs::remove_dir_all(&foreign).unwrap();
    let mut lines: Vec<_> =
        String::from_utf8(read(&out, "rows.jsonl")).unwrap().lines().map(str::to_owned).collect();
    lines.truncate(1);
    fs::write(out.join("rows.jsonl"), lines[0].clone() + "\n").unwrap();
    Journal::open(&out.join("rows.jsonl"), &of_build(build()), &|_| {}).unwrap().append(&wrong).unwrap();
    assert!(refused().contains("has different results in line "), "{}", refused());
    let fresh = Options { fresh: true, ..options(&out) };
    assert!(
        matches!(merge(&experiment, &[shards], &fresh).unwrap(), Merged::Whole(swept) if swept.done == 36)
    );
}

#[test]
fn a_run_that_failed_is_a_row_unless_another_shard_did_it() {
    let experiment = experiment(SMALL).unwrap();
    let (shards, out, again) =
        (folder("shards-failed"), folder("merged-failed"), folder("merged-failed-again"));
    run_shard(&experiment, "1/2", &shards.join("1"));
    let path = shards.join("0");
    run_shard(&experiment, "0/2", &path);
    let header = || Header::new("test", fingerprint(&experiment), build(), 36).of_shard(shard("0/2"));
    let mut journal = Journal::open(&path.join("rows.jsonl"), &header(), &|_| {}).unwrap();
    let done = journal.done();
    journal.keep_failed();
    let rows: Vec<_> = journal.rows().unwrap().map(Result::unwrap).collect();
    drop(journal);
    fs::remove_file(path.join("rows.jsonl")).unwrap();
    let mut journal = Journal::open(&path.join("rows.jsonl"), &header(), &|_| {}).unwrap();
    let failed = Row { outcome: Err(RunError::new("no program")), ..rows[0].clone() };
    journal.append(&failed).unwrap();
    rows[1..].iter().for_each(|row| journal.append(row).unwrap());
    let merged = whole(&experiment, std::slice::from_ref(&shards), &out);
    assert!(merged.summary.failures.contains(&(failed.run, "no program".to_owned())));
    // The shard does it again.
    assert_eq!(run_shard(&experiment, "0/2", &path).resumed, done - 1);
    assert_eq!(
        whole(&experiment, std::slice::from_ref(&shards), &again).summary.failed,
        merged.summary.failed - 1
    );
    // So does the folder of a merge, whatever it had before.
    whole(&experiment, &[shards], &out);
    assert!(read(&again, "rows.csv") == read(&out, "rows.csv"));
    assert!(read(&again, "rows.parquet") == read(&out, "rows.parquet"));
}

#[test]
fn damage_is_told_and_counts_as_missing() {
    let experiment = experiment(SMALL).unwrap();
    let (shards, out) = (folder("shards-damaged"), folder("merged-damaged"));
    run_shards(&experiment, 2, &shards);
    let journal = shards.join("0-of-2/rows.jsonl");
    let mut bytes = fs::read(&journal).unwrap();
    bytes[3] ^= 1;
    let last = bytes.len() - 40;
    bytes[last] ^= 1;
    fs::write(&journal, bytes).unwrap();
    let told = std::sync::Mutex::new(Vec::new());
    let tell = |text: &Told| told.lock().unwrap().push(text.to_string());
    let sources = [shards];
    let merged = merge(&experiment, &sources, &Options { tell: &tell, ..options(&out) }).unwrap();
    let Merged::Missing(lacks) = merged else { panic!("{merged:?}") };
    // The journal's shard is unknown; the run's is not.
    assert_eq!((lacks.runs, lacks.shards[0].shard), (1, shard("0/2")));
    let told = told.into_inner().unwrap();
    assert!(
        told[0].ends_with("0-of-2/rows.jsonl: line 1 is damaged; which shard's it is, is unknown"),
        "{told:?}"
    );
    assert!(told[1].ends_with("line 19 is damaged; its run does not count"), "{told:?}");
    let error = sweep(&experiment, &Options { shard: shard("1/2"), ..options(&sources[0].join("0-of-2")) });
    assert!(error.unwrap_err().to_string().contains("is for shard 0/2, not for shard 1/2"));
    run_shard(&experiment, "0/2", &sources[0].join("0-of-2"));
    whole(&experiment, &sources, &out);
}
