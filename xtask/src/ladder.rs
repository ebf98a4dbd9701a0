//! Runs sections one after the other: what is missing is told first, how far it is at each section, and at the end what
//! passed, what did not, and how to go on.

use std::io::IsTerminal as _;
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use crate::arguments::Plan;
use crate::needs::Missing;
use crate::place::Place;
use crate::records::{self, Duration, Green, Passed, Repeats, Table};
use crate::sections::{self, Rung, Section};
use crate::shell::{Failure, Shell};

/// What became of a section.
enum End {
    /// It passed, after so many seconds.
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
    state: String,
    commit: String,
    passed: Passed,
    times: Table<Duration>,
    ends: Vec<(&'static Section, End)>,
    begin: Instant,
}

/// Runs what is planned.
///
/// # Errors
///
/// Nothing could begin.
pub(crate) fn run(plan: &Plan) -> Result<ExitCode, Failure> {
    let interrupted = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        signal_hook::flag::register(signal, interrupted.clone())
            .map_err(|error| Failure::Start { program: "a handler of signals".to_owned(), error })?;
    }
    let shell = Shell::new(Place::new(), interrupted)?;
    let root = shell.place.root.clone();
    let passed = Passed::of(&shell.place);
    let begin = Instant::now();
    let (state, commit) = (records::state_of_tree(&root)?, records::commit(&root)?);
    let mut run =
        Run { plan, shell, state, commit, passed, times: records::times(&root)?, ends: Vec::new(), begin };
    let Some(mut sections) = run.preflight(&plan.sections)? else { return Ok(ExitCode::from(2)) };
    if plan.whole {
        run.judge_release_checks()?;
        sections.extend(run.release_check_of_this_run()?);
    }
    let load = plan.load.then(Load::new);
    let code = run.all(&sections)?;
    drop(load);
    Ok(code)
}

impl Run<'_> {
    /// The sections that can run here; `None` if something is missing that they must have.
    fn preflight(&mut self, sections: &[&'static Section]) -> Result<Option<Vec<&'static Section>>, Failure> {
        let root = self.shell.place.root.clone();
        let needs = || sections.iter().flat_map(|section| section.needs);
        let mut missing = Missing::of(needs(), &root);
        if !missing.is_empty() && self.plan.install {
            println!("installing {}", missing.words());
            missing.install(&self.shell)?;
            missing = Missing::of(needs(), &root);
        }
        if missing.is_empty() {
            return Ok(Some(sections.to_vec()));
        }
        let mut kept = Vec::new();
        let mut refused = Vec::new();
        for &section in sections {
            let lacks = Missing::of(section.needs, &root);
            if lacks.is_empty() {
                kept.push(section);
            } else if self.passes_over(section) {
                self.ends.push((section, End::LeftOut(format!("{} is missing", lacks.words()))));
            } else {
                refused.push((section.name, lacks.words()));
            }
        }
        if refused.is_empty() {
            return Ok(Some(kept));
        }
        eprintln!("nothing has been run: some tools are missing");
        for (name, words) in refused {
            eprintln!("  {name}: {words}");
        }
        eprintln!(
            "this installs them, as does ./test … --install:\n\n{}\n",
            Missing::of(needs(), &root).remedy()
        );
        Ok(None)
    }

    /// Says which release checks have not been green for long; too long is a failure.
    fn judge_release_checks(&self) -> Result<(), Failure> {
        let root = &self.shell.place.root;
        let due = sections::overdue(&records::greens(root)?, |commit| records::commits_since(root, commit));
        if due.is_empty() {
            return Ok(());
        }
        let names: Vec<_> = due.iter().map(|(name, age)| format!("{name} ({age})")).collect();
        Err(Failure::Wrong(format!(
            "these release checks were last green more than {} commits ago: {}; run ./test {} and commit xtask/release-checks.toml",
            sections::OLDEST,
            names.join(", "),
            due.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(" ")
        )))
    }

    /// Under continuous integration the release check whose turn it is, if there is one that is short enough.
    fn release_check_of_this_run(&mut self) -> Result<Option<&'static Section>, Failure> {
        if !self.shell.place.ci {
            return Ok(None);
        }
        let root = &self.shell.place.root;
        let next = sections::next_release_check(&records::greens(root)?, &self.times, |commit| {
            records::commits_since(root, commit)
        });
        let Some(section) = next else { return Ok(None) };
        println!("the release check whose turn it is: {}", section.name);
        Ok(self.preflight(&[section])?.map(|_| section))
    }

    fn all(&mut self, sections: &[&'static Section]) -> Result<ExitCode, Failure> {
        let total = sections.len();
        println!("{total} sections, {}", self.expected(sections));
        for (i, &section) in sections.iter().enumerate() {
            if self.plan.resume && self.passed.has(&self.state, section.name) {
                self.ends.push((section, End::Resumed));
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
        let log = self.shell.begin_log(section.name)?;
        let (begin, processor_s) = (Instant::now(), records::processor_s());
        let result = (section.check)(&self.shell, &self.plan.arguments);
        let wall_s = begin.elapsed().as_secs_f64().round() as u64;
        if self.plan.repeat > 1 {
            Repeats::of(&self.shell.place).add(&self.state, section.name, result.is_ok(), wall_s)?;
        }
        Ok(match result {
            Ok(()) => {
                let processor_s = (records::processor_s() - processor_s).round() as u64;
                let time = Duration {
                    wall_s,
                    processor_s,
                    commit: self.commit.clone(),
                    machine: records::machine(),
                };
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
                }
                End::Failed(wall_s, failure)
            }
        })
    }

    /// Whether a section may be left out where its tools are missing.
    fn passes_over(&self, section: &Section) -> bool {
        section.is_optional && self.plan.asked.is_empty() && !self.shell.place.ci
    }

    /// Notes that a section has passed. A release check is green if all of it ran on a commit as it is.
    fn note(&self, section: &Section, log: &Path, time: &Duration) -> Result<(), Failure> {
        self.passed.add(&self.state, section.name)?;
        let is_whole = self.plan.arguments.is_empty() && self.state == self.commit;
        if section.rung == Rung::Release && is_whole && !self.shell.place.ci {
            let root = &self.shell.place.root;
            let (commit, log) = (self.commit.clone(), records::content_hash(root, log)?);
            records::write_green(
                root,
                section.name,
                Green { commit, date: records::today(), log, wall_s: time.wall_s },
            )?;
        }
        Ok(())
    }

    fn expected(&self, sections: &[&'static Section]) -> String {
        let times: Vec<_> = sections
            .iter()
            .filter_map(|section| self.times.get(section.name))
            .map(|time| time.wall_s)
            .collect();
        if times.is_empty() {
            "no time is known".to_owned()
        } else {
            format!("about {}", in_words(times.iter().sum()))
        }
    }

    fn interrupted(&self) -> ExitCode {
        let passed = self.ends.iter().filter(|(_, end)| matches!(end, End::Passed(_) | End::Resumed)).count();
        let name = self.ends.last().map_or("", |(section, _)| section.name);
        let mut words = self.plan.asked.clone();
        words.extend(self.plan.arguments.iter().cloned());
        println!(
            "\ninterrupted in {name} after {} s; {passed} passed; go on with ./test {}--resume",
            self.begin.elapsed().as_secs(),
            words.iter().map(|word| format!("{word} ")).collect::<String>()
        );
        ExitCode::from(130)
    }

    /// Sums up, with so many sections not begun.
    fn finish(&self, not_begun: usize) -> Result<ExitCode, Failure> {
        println!();
        let (mut failed, mut left_out, mut passed) = (Vec::new(), Vec::new(), 0);
        for (section, end) in &self.ends {
            match end {
                End::Passed(time) => {
                    passed += 1;
                    println!("{:6} s  {:6} processor s  {}", time.wall_s, time.processor_s, section.name);
                }
                End::Resumed => {
                    passed += 1;
                    println!("   passed before            {}", section.name);
                }
                End::Failed(wall_s, failure) => {
                    println!("{wall_s:6} s  FAILED              {}: {failure}", section.name);
                    failed.push(section.name);
                }
                End::LeftOut(why) => left_out.push(format!("{} ({why})", section.name)),
            }
        }
        self.write_times()?;
        self.tell_repeats();
        let seconds = self.begin.elapsed().as_secs();
        if !failed.is_empty() {
            let rest = if not_begun > 0 { format!("; {not_begun} not begun") } else { String::new() };
            println!(
                "FAILED after {seconds} s: {}; {passed} passed{rest}; when it is mended, go on with --resume",
                failed.join(", ")
            );
        } else if left_out.is_empty() {
            println!("all {passed} sections passed in {seconds} s");
        } else {
            println!("{passed} sections passed in {seconds} s; not run: {}", left_out.join(", "));
        }
        // The line that continuous integration reads.
        if !std::io::stdout().is_terminal() {
            println!("{passed} passed, {} failed", failed.len());
        }
        Ok(if failed.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
    }

    /// Keeps how long sections took, if that is asked for.
    fn write_times(&self) -> Result<(), Failure> {
        let passed = self.ends.iter().filter_map(|(section, end)| match end {
            End::Passed(time) => Some((section.name.to_owned(), time.clone())),
            End::Resumed | End::Failed(_, _) | End::LeftOut(_) => None,
        });
        if self.plan.write_times {
            records::write_times(&self.shell.place.root, passed.collect())?;
        }
        Ok(())
    }

    fn tell_repeats(&self) {
        if self.plan.repeat == 1 {
            return;
        }
        let repeats = Repeats::of(&self.shell.place);
        for section in &self.plan.sections {
            let (passed, failed) = repeats.counts(&self.state, section.name);
            println!(
                "{}: on this state of the tree {passed} rounds passed and {failed} failed so far",
                section.name
            );
        }
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

/// A duration as people say it.
pub(crate) fn in_words(seconds: u64) -> String {
    match seconds {
        0..90 => format!("{seconds} s"),
        90..5400 => format!("{} min", (seconds + 30) / 60),
        _ => format!("{:.1} h", seconds as f64 / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::in_words;

    #[test]
    fn durations_are_said_as_people_say_them() {
        assert_eq!([40, 89, 90, 1800, 7200].map(in_words), ["40 s", "89 s", "2 min", "30 min", "2.0 h"]);
    }
}
