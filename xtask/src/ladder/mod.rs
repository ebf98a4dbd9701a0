//! Runs sections one after the other: what is missing is told first, how far it is at each section, and at the end what
//! passed, what did not, and how to go on.

mod preflight;
mod summary;

use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use crate::arguments::Plan;
use crate::place::Place;
use crate::records::{self, Duration, Green, Passed, Repeats, Table};
use crate::sections::{LONGEST_TURN_S, Rung, Section};
use crate::shell::{Failure, Shell};

pub(crate) use summary::in_words;

/// The result of a section.
enum End {
    /// It passed.
    Passed(Duration),
    /// It passed earlier, on this state of the tree.
    Resumed,
    /// It failed after so many seconds.
    Failed(u64, Failure),
    /// It is optional, and this is missing.
    LeftOut(String),
}

/// A run of sections.
struct Run<'a> {
    plan: &'a Plan,
    shell: Shell,
    /// The state of the tree, and its commit; nothing is noted where git does not tell.
    tree: Option<(String, String)>,
    passed: Passed,
    times: Table<Duration>,
    ends: Vec<(&'static Section, End)>,
    /// The checks that programs within sections could not do, in their words.
    not_checked: Vec<String>,
    begin: Instant,
}

/// A section runs so many times as long as it should before it is ended.
const PATIENCE: u64 = 5;
/// It may always run for so long, as a machine may be slow, and its crates are to be downloaded.
const LEAST_LIMIT_S: u64 = 1800;

/// Runs what is planned.
///
/// # Errors
///
/// Nothing could begin.
pub(crate) fn run(plan: &Plan) -> Result<ExitCode, Failure> {
    let interrupted = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM, signal_hook::consts::SIGHUP] {
        signal_hook::flag::register(signal, interrupted.clone())
            .map_err(|error| Failure::Start { program: "a handler of signals".to_owned(), error })?;
    }
    let shell = Shell::new(Place::new(), interrupted)?;
    let root = shell.place.root.clone();
    let tree = records::state_of_tree(&root).and_then(|state| Ok((state, records::commit(&root)?)));
    if let Err(error) = &tree {
        println!("nothing is noted of this run: {error}");
    }
    let mut run = Run {
        plan,
        tree: tree.ok(),
        passed: Passed::of(&shell.place),
        shell,
        times: records::times(&root)?,
        ends: Vec::new(),
        not_checked: Vec::new(),
        begin: Instant::now(),
    };
    let Some(mut sections) = run.preflight(&plan.sections)? else { return Ok(ExitCode::from(2)) };
    if plan.whole {
        run.judge_release_checks()?;
        let Some(turn) = run.release_check_of_this_run()? else { return Ok(ExitCode::from(2)) };
        sections.extend(turn);
    }
    let load = plan.load.then(Load::new);
    let code = run.all(&sections)?;
    drop(load);
    Ok(code)
}

impl Run<'_> {
    fn all(&mut self, sections: &[&'static Section]) -> Result<ExitCode, Failure> {
        let total = sections.len();
        println!("{total} sections, {}", self.expected(sections));
        for (i, &section) in sections.iter().enumerate() {
            if self.plan.resume && self.has_passed(section) {
                self.ends.push((section, End::Resumed));
                continue;
            }
            if let Some(words) = self.takes_too_long(section) {
                println!("\n{words}");
                continue;
            }
            println!(
                "\n[{}/{total}] {}: {}, {}",
                i + 1,
                section.name,
                section.protects,
                self.expected(&[section])
            );
            for round in 1..=self.plan.repeat {
                if self.plan.repeat > 1 {
                    println!("round {round} of {}", self.plan.repeat);
                }
                let end = self.one(section)?;
                let stops = matches!(end, End::Failed(_, _)) && !self.plan.keep_going;
                self.ends.push((section, end));
                if self.shell.is_interrupted() {
                    return Ok(self.interrupted());
                }
                if stops {
                    return self.finish(total - i - 1);
                }
            }
        }
        self.finish(0)
    }

    fn one(&mut self, section: &'static Section) -> Result<End, Failure> {
        let expected_s = self.times.get(section.name).map_or(0, |time| time.wall_s);
        let limit_s =
            if self.plan.arguments.is_empty() { LEAST_LIMIT_S.max(PATIENCE * expected_s) } else { u64::MAX };
        let log = self.shell.begin_section(section.name, limit_s)?;
        let (begin, processor_s) = (Instant::now(), records::processor_s());
        let result = (section.check)(&self.shell, &self.plan.arguments).and_then(|()| self.is_whole(section));
        let wall_s = begin.elapsed().as_secs_f64().round() as u64;
        self.note_round(section, &result, wall_s)?;
        Ok(match result {
            Ok(()) => {
                let processor_s = (records::processor_s() - processor_s).round() as u64;
                let commit = self.tree.as_ref().map_or_else(String::new, |(_, commit)| commit.clone());
                let time = Duration { wall_s, processor_s, commit, machine: records::machine() };
                self.note(section, &log, &time)?;
                End::Passed(time)
            }
            Err(Failure::Missing(what)) if self.passes_over(section) => End::LeftOut(what),
            Err(failure) => {
                if !matches!(failure, Failure::Interrupted) {
                    println!(
                        "{} FAILED after {wall_s} s: {failure}\nits output is in {}",
                        section.name,
                        log.display()
                    );
                    self.passed.remove(&self.key(section))?;
                }
                End::Failed(wall_s, failure)
            }
        })
    }

    /// Whether the release check of this run takes longer on this machine than a turn may; it comes again before a release, or
    /// on another machine.
    fn takes_too_long(&self, section: &Section) -> Option<String> {
        let expected_s = self.times.get(section.name).map_or(0, |time| time.wall_s) as f64 * self.pace();
        let is_in_turn = self.plan.whole && section.rung == Rung::Release;
        (is_in_turn && expected_s > LONGEST_TURN_S as f64).then(|| {
            format!(
                "the release check {} is not run: on this machine it would take {expected_s:.0} s, more than {LONGEST_TURN_S} s",
                section.name
            )
        })
    }

    /// Whether a section may be left out where its tools are missing.
    fn passes_over(&self, section: &Section) -> bool {
        section.is_optional && self.plan.asked.is_empty() && !self.shell.place.ci
    }

    /// Programs print the checks that they could not do. Under continuous integration that is a failure, elsewhere
    /// the last line tells.
    fn is_whole(&mut self, section: &Section) -> Result<(), Failure> {
        let log = self.shell.log_text()?;
        let not_checked = log.lines().filter(|line| line.contains("NOT CHECKED"));
        let not_checked: Vec<_> =
            not_checked.map(|line| format!("{}: {}", section.name, line.trim())).collect();
        if self.shell.place.ci && !not_checked.is_empty() {
            return Err(Failure::Wrong(not_checked.join("\n")));
        }
        self.not_checked.extend(not_checked);
        Ok(())
    }

    /// The state of the tree, the section, and its arguments.
    fn key(&self, section: &Section) -> String {
        let state = self.tree.as_ref().map_or("", |(state, _)| state);
        [&[state, section.name], &*self.plan.arguments.iter().map(String::as_str).collect::<Vec<_>>()]
            .concat()
            .join(" ")
    }

    fn has_passed(&self, section: &Section) -> bool {
        self.tree.is_some() && self.passed.has(&self.key(section))
    }

    /// Keeps the result of a round, and the log of one that failed.
    fn note_round(
        &self,
        section: &Section,
        result: &Result<(), Failure>,
        wall_s: u64,
    ) -> Result<(), Failure> {
        let Some((state, _)) = self.tree.as_ref().filter(|_| self.plan.repeat > 1) else { return Ok(()) };
        if matches!(result, Err(Failure::Interrupted | Failure::Missing(_))) {
            return Ok(());
        }
        let repeats = Repeats::of(&self.shell.place);
        repeats.add(state, section.name, result.is_ok(), wall_s)?;
        if result.is_err() {
            let (_, failed) = repeats.counts(state, section.name);
            let kept = self.shell.place.target.join(format!("test/{}.failed-{failed}.log", section.name));
            std::fs::write(&kept, self.shell.log_text()?).map_err(Failure::file(&kept))?;
        }
        Ok(())
    }

    /// Notes that a section has passed, on a tree that nobody has changed meanwhile. A release check is green if all of it ran on
    /// a commit as it is.
    fn note(&self, section: &Section, log: &Path, time: &Duration) -> Result<(), Failure> {
        let root = &self.shell.place.root;
        let Some((state, commit)) = &self.tree else { return Ok(()) };
        if records::state_of_tree(root)? != *state {
            println!("{} is not noted as passed: the tree has changed meanwhile", section.name);
            return Ok(());
        }
        self.passed.add(&self.key(section))?;
        if section.rung != Rung::Release || !self.plan.arguments.is_empty() || self.shell.place.ci {
            return Ok(());
        }
        if state != commit {
            println!("{} is not noted as green: the tree has changes that are not committed", section.name);
            return Ok(());
        }
        let green = Green {
            commit: commit.clone(),
            date: records::today(),
            log: records::content_hash(root, log)?,
            wall_s: time.wall_s,
        };
        Ok(records::write_green(root, section.name, green)?)
    }
}

/// Keeps all processors busy until it is dropped.
struct Load(Arc<AtomicBool>);

impl Load {
    fn new() -> Self {
        let end = Arc::new(AtomicBool::new(false));
        for _ in 0..std::thread::available_parallelism().map_or(2, std::num::NonZero::get) {
            let end = end.clone();
            std::thread::spawn(move || {
                while !end.load(Ordering::Relaxed) {
                    std::hint::black_box((0..10_000_u64).sum::<u64>());
                }
            });
        }
        Self(end)
    }
}

impl Drop for Load {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}
