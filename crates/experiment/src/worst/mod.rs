//! The worst run: the values, the seed and the instant at which a brain comes nearest to a failure, or fails.
//!
//! `plan` is what the file says of it, thought through; `search` says which runs come next, batch by batch. Runs are numbered, so the
//! journal of a sweep is that of a search, too. `shrink` makes of the worst run the plainest scenario that still fails, and `report` tells
//! what was found. `splitting` estimates how likely a failure is that no run of a search would show.

mod case;
mod document;
mod plan;
mod report;
mod search;
mod shrink;
mod splitting;
mod trial;

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use baudbot_run::in_process::InProcess;
use baudbot_sim::random::Stream;

pub use case::Case;
use case::Trials;
pub use report::Tightness;
pub use splitting::Likelihood;
pub use trial::trial;

use crate::batches::Batches;
use crate::check::check;
use crate::error::Error;
use crate::experiment::Experiment;
use crate::hunt::Hunt;
use crate::merge::{Gathered, gather};
use crate::outputs::Folder;
use crate::raw::Strategy;
use crate::requirement::{Demands, Fall, Judge};
use crate::resumed;
use crate::run_options::RunOptions;
use crate::run_record::{Row, Task};
use crate::setup::Setup;
use crate::shard::Shard;
use crate::sweep::{self, Options};
use plan::Plan;
use search::Search;
use splitting::{Approach, Extent, Lineage};

/// The extent of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// The number of runs; the same number gives the same runs on any machine. `None` is 1,000, or as many as the time allows.
    pub runs: Option<u64>,
    /// The time by the wall clock after which no run begins any more. Once a run has failed, half of it is for the search and half
    /// to make the case plain.
    pub within: Option<Duration>,
    /// No run begins any more once one has failed.
    pub first: bool,
}

/// The result of a search.
#[derive(Debug)]
pub struct Worst {
    /// The search was stopped before its end: there is a journal, and nothing else.
    pub interrupted: bool,
    /// What was required.
    pub requirements: Demands,
    /// The way in which it was searched.
    pub strategy: Strategy,
    /// The number of runs.
    pub runs: u64,
    /// Runs that did not keep to what is required.
    pub fallen: u64,
    /// Runs that could not be done.
    pub failed: u64,
    /// The first of their errors.
    pub error: Option<String>,
    /// The command that does that run again, but for what is required.
    pub command: Option<String>,
    /// The worst runs, the worst first.
    pub worst: Vec<Trial>,
    /// The plainest scenario that was found in which the robot fails.
    pub case: Option<Case>,
    /// How likely a failure is, by [`Strategy::Splitting`].
    pub likelihood: Option<Likelihood>,
    /// The files that were written.
    pub files: Vec<PathBuf>,
}

/// A run that was tried.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// The run with its values and its seed.
    pub task: Task,
    /// How it kept to what is required.
    pub fall: Fall,
    /// The fingerprint of its final state.
    pub hash: u64,
}

/// Looks for the runs that come nearest to a failure, and writes the results.
///
/// # Errors
/// If the experiment is invalid, the folder is another's, no run can be done, a file cannot be written or the server fails. What was run
/// is in the journal.
pub fn worst(experiment: &Experiment, options: &Options<'_>, limit: Limit) -> Result<Worst, Error> {
    let plan = Plan::new(experiment)?;
    check(&plan.experiment)?;
    if options.shard.is_some() {
        refuse_shards(plan.strategy)?;
    }
    let folder = Folder::take(options.out)?;
    let header = plan.header().of_shard(options.shard);
    let mut journal = sweep::begin_journal(&folder, &header, options)?;
    resumed::tell(&plan.experiment, &journal, None, options.tell);
    if options.fresh {
        report::remove(&folder)?;
        sweep::keep_journal(&folder, &mut journal)?;
    }
    if plan.strategy == Strategy::Splitting {
        return estimated(&plan, options, limit, &folder);
    }
    let begun = Instant::now();
    let batches = Batches::new(&plan.experiment, options, &folder, &mut journal)?;
    let mut hunter = Hunter { plan: &plan, options, limit, begun, batches };
    let mut worst = hunter.search()?;
    hunter.batches.finish()?;
    if worst.interrupted || options.shard.is_some() {
        return Ok(worst);
    }
    if worst.worst.is_empty()
        && let Some(error) = &worst.error
    {
        return Err(Error::Refused(format!("none of {} runs could be done: {error}", worst.runs)));
    }
    let extent =
        Trials { workers: &hunter.batches.workers, until: limit.within.map(|within| begun + within) };
    worst.case = case::worst_case(&plan.experiment, &worst, options, extent)?;
    worst.interrupted = options.stop.load(Ordering::Relaxed);
    if !worst.interrupted {
        report::write(&mut worst, &plan.experiment, &folder)?;
    }
    Ok(worst)
}

/// The likelihood of a failure, in place of a search. It has no journal.
fn estimated(plan: &Plan, options: &Options<'_>, limit: Limit, folder: &Folder) -> Result<Worst, Error> {
    if limit.runs.is_some() || limit.within.is_some() || limit.first {
        return Err(Error::Refused(
            "--runs, --within and --first are for searches; the extent of `splitting` is that of particles and repeats in [worst]"
                .to_owned(),
        ));
    }
    let Hunt { particles, repeats, seed, .. } = plan.experiment.hunt;
    let extent = Extent { particles, repeats, seed, jobs: options.jobs };
    let each = |runs| (options.progress)(runs, 0);
    let mut worst = Worst::new(plan);
    worst.likelihood = splitting::estimate(extent, options.stop, &each, &|lineage| approach(plan, lineage))?;
    worst.interrupted = worst.likelihood.is_none();
    if let Some(likelihood) = &worst.likelihood {
        worst.runs = likelihood.runs;
        worst.fallen = u64::from(likelihood.probability > 0.0);
        report::write(&mut worst, &plan.experiment, folder)?;
    }
    Ok(worst)
}

/// The way of a run with these seeds towards a failure.
fn approach(plan: &Plan, lineage: &Lineage) -> Result<Approach, Error> {
    let refused = |error: &dyn std::fmt::Display| Error::Refused(format!("seed {}: {error}", lineage.seed));
    let mut stream = Stream::new(lineage.seed, "worst/point");
    let point: Vec<_> = plan.experiment.fields.iter().map(|_| stream.uniform()).collect();
    let task = Task { seed: lineage.seed, ..plan.task(0, &point) };
    let Setup { scenario, assigned } =
        Setup::new(&plan.experiment, &task).map_err(|error| refused(&error))?;
    let mut local =
        InProcess::with_assignments(scenario, &assigned.brains).map_err(|error| refused(&error))?;
    local.world.keep_timeline(0);
    let mut judge = Judge::new(plan.experiment.requirements.clone());
    let (mut approach, mut turns) = (Approach::new(), lineage.turns.iter().peekable());
    while local.world.ending().is_none() && approach.last().is_none_or(|(_, near)| near.is_finite()) {
        if let Some((_, seed)) = turns.next_if(|(tick, _)| *tick == local.world.tick()) {
            local.world.reseed(*seed);
        }
        local.tick(|world| judge.see(world));
        let tick = local.world.tick() - 1;
        let near =
            judge.fall().map_err(|error| refused(&error))?.map_or(f64::NEG_INFINITY, |fall| {
                match fall.holds {
                    true => -fall.robustness,
                    false => f64::INFINITY,
                }
            });
        if approach.last().is_none_or(|(_, nearest)| near > *nearest) {
            approach.push((tick, near));
        }
    }
    Ok(approach)
}

/// The same of the journals of shards, of which together there must be as many runs as are wanted.
///
/// # Errors
/// As [`worst`]; also if a source has no journal of this search, runs are missing, or two journals differ about one.
pub fn merge_worst(
    experiment: &Experiment,
    sources: &[PathBuf],
    options: &Options<'_>,
    limit: Limit,
) -> Result<Worst, Error> {
    let plan = Plan::new(experiment)?;
    let Some(runs) = limit.runs else {
        return Err(Error::Refused(
            "--merge: give the number of runs that the shards did together, with --runs".to_owned(),
        ));
    };
    match gather(&plan.header(), runs, sources, options)? {
        Gathered::Missing(missing) => {
            let shards: Vec<_> =
                missing.shards.iter().filter_map(|shard| Some(shard.shard?.to_string())).collect();
            let which = if shards.is_empty() {
                String::new()
            } else {
                format!(", of the shards {}", shards.join(", "))
            };
            Err(Error::Refused(format!(
                "{} of {runs} runs are missing{which}, so nothing was written; do them with --shard and the same --runs",
                missing.runs
            )))
        }
        Gathered::Whole { folder, mut journal, .. } => {
            if options.fresh {
                report::remove(&folder)?;
                sweep::keep_journal(&folder, &mut journal)?;
            }
            drop((folder, journal));
            worst(experiment, &Options { fresh: false, place: options.place.clone(), ..*options }, limit)
        }
    }
}

/// Refuses a search that cannot be done in shards, or at all.
///
/// # Errors
/// If the experiment is invalid, or its method has no shards.
pub fn check_shards(experiment: &Experiment) -> Result<(), Error> {
    let plan = Plan::new(experiment)?;
    check(&plan.experiment)?;
    refuse_shards(plan.strategy)
}

fn refuse_shards(strategy: Strategy) -> Result<(), Error> {
    match strategy {
        Strategy::Random => Ok(()),
        Strategy::CmaEs | Strategy::Splitting => Err(Error::Refused(
            "--shard: only the method `random` has shards, as others depend on the results of the runs before; write \
             [worst] method = \"random\""
                .to_owned(),
        )),
    }
}

struct Hunter<'a> {
    plan: &'a Plan,
    options: &'a Options<'a>,
    limit: Limit,
    begun: Instant,
    batches: Batches<'a>,
}

impl Hunter<'_> {
    fn search(&mut self) -> Result<Worst, Error> {
        let plan = self.plan;
        let mut search = Search::new(plan.strategy, plan.experiment.hunt.seed, plan.experiment.fields.len());
        let mut worst = Worst::new(plan);
        let (most, mut next) = (self.limit.most().unwrap_or(u64::MAX), 0);
        while next < most && !self.limit.is_over(self.begun, worst.fallen > 0) {
            let mut points = search.next()?;
            points.truncate(usize::try_from(most - next).unwrap_or(usize::MAX));
            let tasks: Vec<_> = (next..).zip(&points).map(|(run, point)| plan.task(run, point)).collect();
            let own = self.options.shard.unwrap_or(Shard::WHOLE);
            let tasks: Vec<_> =
                tasks.into_iter().filter(|task| Shard::of(task.run, own.count()) == own).collect();
            self.run(tasks.clone(), worst.fallen > 0)?;
            next += points.len() as u64;
            let mut costs = Vec::new();
            for task in tasks {
                let Some(row) = self.batches.rows.get(&task.run) else {
                    worst.interrupted = self.options.stop.load(Ordering::Relaxed);
                    return Ok(worst);
                };
                costs.push(worst.note(&plan.experiment, task, row));
                let has_crashed = plan.experiment.has_programs() && worst.failed > 0;
                if self.limit.first && (worst.fallen > 0 || has_crashed) {
                    return Ok(worst);
                }
            }
            search.tell(&points, costs);
            // A brain that never starts does not in later runs either.
            if worst.failed == worst.runs && own == Shard::WHOLE {
                break;
            }
        }
        Ok(worst)
    }

    /// Does a batch, as far as the limit lets it.
    fn run(&mut self, tasks: Vec<Task>, has_fallen: bool) -> Result<(), Error> {
        let (limit, begun, has_fallen) = (self.limit, self.begun, AtomicBool::new(has_fallen));
        let has_programs = self.plan.experiment.has_programs();
        let look = |row: &Row| {
            let falls = match &row.outcome {
                Ok(ran) => ran.fall.is_some_and(|fall| !fall.holds),
                Err(_) => has_programs,
            };
            has_fallen.fetch_or(falls, Ordering::Relaxed);
        };
        let goes_on = || {
            let has_fallen = has_fallen.load(Ordering::Relaxed);
            !(limit.is_over(begun, has_fallen) || limit.first && has_fallen)
        };
        self.batches.run_while(tasks, limit.most().unwrap_or(0), look, goes_on).map(|_| ())
    }
}

impl Limit {
    /// The most runs; `None` if the time alone limits them.
    fn most(&self) -> Option<u64> {
        self.runs.or_else(|| self.within.is_none().then_some(RUNS))
    }

    /// Whether no run begins any more. Once one has failed, half of the time is left to make its case plain.
    fn is_over(&self, begun: Instant, has_fallen: bool) -> bool {
        self.within.is_some_and(|within| begun.elapsed() >= if has_fallen { within / 2 } else { within })
    }
}

impl Worst {
    fn new(plan: &Plan) -> Self {
        Self {
            interrupted: false,
            requirements: plan.experiment.requirements.clone(),
            strategy: plan.strategy,
            runs: 0,
            fallen: 0,
            failed: 0,
            error: None,
            command: None,
            worst: Vec::new(),
            case: None,
            likelihood: None,
            files: Vec::new(),
        }
    }

    /// Counts a run. Its cost is its robustness. A run that could not be done is worse than any other if a program may have crashed, and else
    /// better, as then its values are not possible.
    fn note(&mut self, experiment: &Experiment, task: Task, row: &Row) -> f64 {
        self.runs += 1;
        let ran = match &row.outcome {
            Ok(ran) => ran,
            Err(error) => {
                self.failed += 1;
                if self.error.is_none() {
                    self.error = Some(format!("run {}: {error}", row.run));
                    self.command = Some(RunOptions::command(experiment, &task));
                }
                return if experiment.has_programs() { -NO_COST } else { NO_COST };
            }
        };
        let Some(fall) = ran.fall else { return NO_COST };
        self.fallen += u64::from(!fall.holds);
        let place = self.worst.partition_point(|other| other.fall.order(&fall).is_le());
        if place < MOST_SHOWN {
            self.worst.insert(place, Trial { task, fall, hash: ran.hash });
            self.worst.truncate(MOST_SHOWN);
        }
        fall.robustness
    }
}

/// Worse than nothing: more robust than any run is.
const NO_COST: f64 = 2e300;

/// Runs without any limit given.
const RUNS: u64 = 1000;

/// The number of runs that are shown.
const MOST_SHOWN: usize = 10;
