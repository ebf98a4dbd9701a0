//! One run of an exercise.

use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use baudbot_run::assignment::{Assigned, START_PATIENCE};
use baudbot_sim::{Ending, World};

use crate::error::Error;
use crate::grade::exercise::{Exercise, Limits};
use crate::grade::watch::{Hit, Measures, Watch};
use crate::served::{Next, Served};

/// A run, and its result.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// The scenario's seed, and its brains'.
    pub seed: u64,
    /// Simulated time at its end, in seconds.
    pub time_s: f64,
    /// The course of the run, or the fault of its brain.
    pub outcome: Result<Ended, Problem>,
    /// The first of its collisions.
    pub hits: Vec<Hit>,
}

/// A run that was done to its end.
#[derive(Clone, Debug, PartialEq)]
pub struct Ended {
    /// The reason for its end.
    pub ending: String,
    /// The measured values.
    pub measures: Measures,
    /// Fingerprint of the world's state at its end.
    pub hash: u64,
}

/// A fault of a brain.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Problem {
    /// The brain never drove the robot.
    #[error("{0}")]
    NotStarted(String),
    /// The brain ended, or did what it may not.
    #[error("{0}")]
    Failed(String),
    /// The brain did not answer in time.
    #[error(
        "the brain did not answer for {} s by the wall clock; look for an endless loop, or for a wait that never ends",
        .0.as_secs_f64()
    )]
    Silent(Duration),
    /// The whole run took too long.
    #[error(
        "the run took longer than {} s by the wall clock; let the brain compute less in a step",
        .0.as_secs_f64()
    )]
    TooLong(Duration),
}

/// The observations of a tick.
struct Sight {
    time_s: f64,
    /// New collisions.
    hits: Vec<Hit>,
    /// The state at the end of the run.
    ended: Option<Box<Ended>>,
}

impl Run {
    /// The measures, if it was done to its end.
    pub fn measures(&self) -> Option<&Measures> {
        self.outcome.as_ref().ok().map(|ended| &ended.measures)
    }

    /// Does it. `None` if it was stopped.
    pub(crate) fn new(
        exercise: &Exercise,
        assigned: &Assigned,
        seed: u64,
        stop: &AtomicBool,
    ) -> Result<Option<Self>, Error> {
        let world = World::new(exercise.scenario_with(seed)?.into());
        let mut watch = Watch::new(&world, exercise.robot, exercise.target, &exercise.deficits);
        let look = move |world: &World, believed: &[_]| {
            let hits = watch.see(world, believed);
            let ended = |ending: &Ending| {
                let (ending, measures) = (ending.to_string(), watch.measures(world));
                Box::new(Ended { ending, measures, hash: world.hash() })
            };
            let time_s = world.time().as_ns() as f64 / 1e9;
            Sight { time_s, hits, ended: world.ending().map(ended) }
        };
        let served = Served::start(world, assigned.clone(), look)?;
        follow(served, seed, exercise.limits, stop)
    }
}

/// Follows a run to its end, or to that of its brain or of the time that it has.
fn follow(
    mut served: Served<Sight>,
    seed: u64,
    limits: Limits,
    stop: &AtomicBool,
) -> Result<Option<Run>, Error> {
    let mut run =
        Run { seed, time_s: 0.0, outcome: Err(Problem::NotStarted(String::new())), hits: Vec::new() };
    // A program may load for long before it drives.
    let (mut patience, mut begun) = (START_PATIENCE + limits.answer, None);
    loop {
        let elapsed = begun.map_or(Duration::ZERO, |begun: Instant| begun.elapsed());
        let left = limits.run.saturating_sub(elapsed);
        let next = served.next_within(patience.min(left), stop);
        let problem = match next {
            // Even if ticks come all the time.
            Ok(Next::Seen(Sight { ended: None, .. })) if left.is_zero() => Problem::TooLong(limits.run),
            Ok(Next::Seen(sight)) => {
                (run.time_s, patience) = (sight.time_s, limits.answer);
                begun.get_or_insert_with(Instant::now);
                run.hits.extend(sight.hits.into_iter().take(MOST_HITS.saturating_sub(run.hits.len())));
                if let Some(ended) = sight.ended {
                    run.outcome = Ok(*ended);
                }
                continue;
            }
            Ok(Next::Over) => return Ok(run.is_over().then_some(run)),
            Ok(Next::Late) if left < patience => Problem::TooLong(limits.run),
            Ok(Next::Late) => Problem::Silent(limits.answer),
            Err(error) if !error.is_refusal() => return Err(error),
            // A program's failure at its end, after its run, is no fault.
            Err(_) if run.is_over() => return Ok(Some(run)),
            Err(error) if begun.is_none() => Problem::NotStarted(error.to_string()),
            Err(error) => Problem::Failed(error.to_string()),
        };
        run.outcome = Err(problem);
        return Ok(Some(run));
    }
}

impl Run {
    fn is_over(&self) -> bool {
        self.outcome.is_ok()
    }
}

/// Collisions that are kept of a run.
const MOST_HITS: usize = 100;
