//! `baudbot grade --class`: the brains of a class on one exercise, as a table.

use std::fmt::Display;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;

use anyhow::Context;
use baudbot_experiment::grade::junit::{self, Pupil};
use baudbot_experiment::grade::{Exercise, Grading, Options, Verdict, grade};
use serde_json::{Value, json};

use crate::args::GradeArgs;
use crate::assignment::Assigned;
use crate::error::Refused;
use crate::signals::INTERRUPTED;
use crate::text::{self, print, print_json, table, tell};
use crate::work;

/// A brain of the class, by the name of its file or folder.
struct Entry {
    name: String,
    brain: String,
}

/// The brains that the arguments name, in the order of their names.
pub(crate) struct Class(Vec<Entry>);

impl Class {
    /// # Errors
    /// If there is none, or something that is no brain was named.
    pub(crate) fn find(args: &GradeArgs) -> anyhow::Result<Self> {
        let with = args.with.as_deref();
        let mut entries: Vec<(PathBuf, String)> = Vec::new();
        for path in &args.class {
            if brain_in(path, with).is_none() && path.is_dir() {
                for file in sorted(path)? {
                    match brain_in(&file, with) {
                        Some(brain) => entries.push((file, brain)),
                        // It may be notes, or the brain of a person who would miss the grading.
                        None if is_hidden(&file) => {}
                        None => tell!("note: {} is not a brain, and is skipped", file.display()),
                    }
                }
                continue;
            }
            let brain = brain_in(path, with).ok_or_else(|| {
                Refused::error(format!(
                    "--class {}: is not a brain: neither a description in TOML, nor a Python program, nor executable; give the command that \
                     runs it by --with 'exec:COMMAND {{}}'",
                    path.display()
                ))
            })?;
            entries.push((path.clone(), brain));
        }
        if entries.is_empty() {
            return Err(Refused::error(
                "--class: there is no brain in it; brains are files NAME.toml or NAME.py, programs, or folders with \
                                       brain.toml or brain.py",
            ));
        }
        // Files that are all called the same are each in a folder of its author's.
        let names: Vec<_> = entries.iter().map(|(path, _)| name(path)).collect();
        let is_shared = |own: &String| names.iter().filter(|name| *name == own).count() > 1;
        let named = entries.iter().zip(&names).map(|((path, brain), own)| {
            let folder = path.parent().filter(|_| is_shared(own)).map(name);
            Entry { name: folder.unwrap_or_else(|| own.clone()), brain: brain.clone() }
        });
        Ok(Self(named.collect()))
    }
}

/// The words on a command line for the brain in this file, or in this folder of the user's.
fn brain_in(path: &Path, with: Option<&str>) -> Option<String> {
    if path.is_dir() {
        let inside = ["brain.toml", "brain.py"].map(|name| path.join(name));
        return inside.iter().filter(|file| file.is_file()).find_map(|file| brain_in(file, with));
    }
    let shown = path.to_str().filter(|_| path.is_file() && !is_hidden(path))?;
    let quoted = shlex::try_quote(shown).ok()?;
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
    match (ending, with) {
        ("toml", _) => Some(shown.to_owned()),
        (_, Some(with)) => Some(with.replace("{}", &quoted)),
        ("py", None) => Some(format!("exec:python3 {quoted}")),
        _ => {
            let mode = path.metadata().ok()?.permissions().mode();
            let absolute = std::path::absolute(path).ok()?;
            let quoted = shlex::try_quote(absolute.to_str()?).ok()?.into_owned();
            (mode & 0o111 != 0).then(|| format!("exec:{quoted}"))
        }
    }
}

fn is_hidden(path: &Path) -> bool {
    name(path).starts_with('.')
}

fn name(path: &Path) -> String {
    let name = if path.is_dir() { path.file_name() } else { path.file_stem() };
    name.unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

fn sorted(folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let cannot = || format!("--class {}: cannot be read", folder.display());
    let entries = fs::read_dir(folder).with_context(cannot)?;
    let mut files: Vec<_> = entries
        .map(|entry| entry.map(|entry| entry.path()))
        .collect::<Result<_, _>>()
        .with_context(cannot)?;
    alphanumeric_sort::sort_path_slice(&mut files);
    Ok(files)
}

/// The result of one: a grading, or the reason why there is none.
type Outcome = anyhow::Result<Grading>;

/// Gives brains to robots, by arguments of `--brain`.
type Assign<'a> = &'a dyn Fn(&[String]) -> anyhow::Result<Assigned>;

/// The exit code of a brain that is not good enough.
pub(crate) const NOT_PASSED: u8 = 3;

/// Grades all of them, one after the other; `assign` gives the brains that are named to robots.
pub(crate) fn run(
    exercise: &Exercise,
    args: &GradeArgs,
    (Class(entries), assign): (Class, Assign<'_>),
    stop: &AtomicBool,
) -> anyhow::Result<ExitCode> {
    let bar = work::progress(args.quiet);
    let runs = exercise.seeds.count();
    let mut class: Vec<(Entry, Outcome)> = Vec::new();
    let count = entries.len();
    for (i, entry) in entries.into_iter().enumerate() {
        let progress = |done| work::advance(&bar, i as u64 * runs + done, count as u64 * runs);
        progress(0);
        let brains: Vec<_> = [entry.brain.clone()].into_iter().chain(args.brains.iter().cloned()).collect();
        // A brain that cannot be read is its author's fault, and not the class's.
        let outcome = match assign(&brains) {
            Err(error) => Err(error),
            Ok(assigned) => {
                let options = Options { jobs: work::jobs_of(args.jobs), stop, progress: &progress };
                let Some(grading) = grade(exercise, &assigned, &options).context("could not be graded")?
                else {
                    bar.finish_and_clear();
                    tell!("stopped; {i} of {count} brains had been graded");
                    return Ok(ExitCode::from(INTERRUPTED));
                };
                Ok(grading)
            }
        };
        class.push((entry, outcome));
    }
    bar.finish_and_clear();
    report(exercise, args, &class)?;
    let is_passed =
        |outcome: &Outcome| outcome.as_ref().is_ok_and(|grading| grading.verdict == Verdict::Passed);
    let all_passed = class.iter().all(|(_, outcome)| is_passed(outcome));
    Ok(if all_passed { ExitCode::SUCCESS } else { ExitCode::from(NOT_PASSED) })
}

fn report(exercise: &Exercise, args: &GradeArgs, class: &[(Entry, Outcome)]) -> anyhow::Result<()> {
    if let Some(file) = &args.junit {
        let pupils: Vec<_> = class
            .iter()
            .map(|(entry, outcome)| Pupil {
                name: &entry.name,
                outcome: outcome.as_ref().map_err(|error| error as &dyn Display),
            })
            .collect();
        text::write(file, &junit::class(exercise, &pupils))?;
    }
    if let Some(file) = &args.csv {
        text::write(file, &csv(exercise, class)?)?;
    }
    if args.json {
        let of_one = |(entry, outcome): &(Entry, Outcome)| {
            let mut json = match outcome {
                Ok(grading) => grading.json(exercise),
                Err(problem) => {
                    let findings = [problem.to_string()];
                    json!({ "verdict": Verdict::NotGraded.name(), "points": 0.0, "findings": findings })
                }
            };
            json["name"] = json!(entry.name);
            json["brains"] = json!([entry.brain]);
            json
        };
        return print_json(&class.iter().map(of_one).collect::<Value>());
    }
    if args.quiet { Ok(()) } else { print(&told(exercise, class)) }
}

/// The verdict, the points, and what went wrong first.
fn cells(outcome: &Outcome) -> (&'static str, f64, String) {
    match outcome {
        Ok(grading) => {
            let finding =
                grading.findings.first().map_or_else(String::new, |finding| text::one_line(finding));
            (grading.verdict.name(), grading.points, finding)
        }
        Err(problem) => (Verdict::NotGraded.name(), 0.0, text::one_line(&problem.to_string())),
    }
}

fn told(exercise: &Exercise, class: &[(Entry, Outcome)]) -> String {
    let row = |(entry, outcome): &(Entry, Outcome)| {
        let (verdict, points, finding) = cells(outcome);
        ([entry.name.clone(), format!("{points:.2}"), verdict.to_owned()], finding)
    };
    let rows: Vec<_> = class.iter().map(row).collect();
    let lines = table("  ", &rows.iter().map(|(cells, _)| cells.clone()).collect::<Vec<_>>());
    let passed = class.iter().filter(|(_, outcome)| cells(outcome).0 == Verdict::Passed.name()).count();
    let lines = lines
        .lines()
        .zip(&rows)
        .map(|(line, (_, finding))| format!("{line}  {finding}").trim_end().to_owned() + "\n");
    format!(
        "{}\n\n{}\n{passed} of {} brains passed, with {:.2} of {:.2} points or more\n",
        exercise.headline(),
        lines.collect::<String>(),
        class.len(),
        exercise.pass * exercise.points(),
        exercise.points()
    )
}

fn csv(exercise: &Exercise, class: &[(Entry, Outcome)]) -> anyhow::Result<String> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(["name", "brain", "verdict", "points", "points_of", "finding"])?;
    for (entry, outcome) in class {
        let (verdict, points, finding) = cells(outcome);
        let (points, of) = (points.to_string(), exercise.points().to_string());
        writer.write_record([&entry.name, &entry.brain, verdict, &points, &of, &finding])?;
    }
    Ok(String::from_utf8(writer.into_inner().context("cannot write the table")?)?)
}
