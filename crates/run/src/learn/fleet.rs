//! Many environments with one agent each, stepped on some threads.

use std::sync::Arc;

use crate::learn::env::{Env, Stepped};
use crate::learn::error::LearnError;
use crate::learn::layout::Layout;
use crate::learn::memory::Need;
use crate::learn::reward::{Reward, Tally};
use crate::learn::run::{Info, Run, seed_of};
use crate::learn::task::Task;
use crate::learn::threads::Threads;

/// The time at which an environment whose run is over begins another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Autoreset {
    /// In the step behind the one that ended it, which ignores the action and is worth nothing.
    NextStep,
    /// In the same step: the observation is the new run's first.
    SameStep,
    /// The environment begins another run only by a reset.
    Never,
}

/// Environments.
pub struct Fleet {
    envs: Vec<Env>,
    runs: Vec<Run>,
    threads: Threads,
    autoreset: Autoreset,
}

/// Arrays with a row for each environment.
#[derive(Debug)]
pub struct Arrays<'a> {
    /// Readings, shape (environments, values).
    pub values: &'a mut [f32],
    /// Ages of readings, in seconds, shape (environments, sensors).
    pub ages_s: &'a mut [f32],
    /// Whether readings are new, 0 or 1, shape (environments, sensors).
    pub readable: &'a mut [i8],
}

/// The result of a step, with a row for each environment.
#[derive(Debug)]
pub struct Rewards<'a> {
    /// Shape (environments).
    pub rewards: &'a mut [f64],
    /// Shape (environments).
    pub terminated: &'a mut [bool],
    /// Shape (environments).
    pub truncated: &'a mut [bool],
    /// The numbers of [`Tally`], shape (environments, 8).
    pub tallies: &'a mut [f64],
    /// The last observations of runs that ended, which are over in the same step; of others nothing is written.
    pub finals: Option<Arrays<'a>>,
}

/// A row of arrays.
struct Row<'a> {
    values: &'a mut [f32],
    ages_s: &'a mut [f32],
    readable: &'a mut [i8],
}

/// The seeds of new runs.
#[derive(Clone, Copy, Debug)]
pub enum Seeds<'a> {
    /// The seeds follow from the ones before.
    Next,
    /// This one for the first environment, the next for the second, and so on.
    From(u64),
    /// One for each environment, or what follows from the one before.
    Each(&'a [Option<u64>]),
}

/// The work of a step for one environment.
struct Work<'a> {
    env: &'a mut Env,
    run: &'a mut Run,
    action: &'a [f32],
    row: Row<'a>,
    last: Option<Row<'a>>,
    reward: &'a mut f64,
    terminated: &'a mut bool,
    truncated: &'a mut bool,
    tally: &'a mut [f64],
}

impl Fleet {
    /// A fleet of `count` environments of a task with one agent; the seeds are `seed`, `seed + 1` and so on. They are
    /// stepped on so many threads.
    ///
    /// # Errors
    /// If the task has not one agent, if there are no environments, or if a run's scenario is invalid.
    pub fn new(
        task: &Arc<Task>,
        count: usize,
        threads: usize,
        seed: u64,
        autoreset: Autoreset,
    ) -> Result<Self, LearnError> {
        let agents = task.agents.len();
        if agents != 1 {
            let problem = format!(
                "the scenario has {agents} robots without a brain, an environment of this kind drives one; name it"
            );
            return Err(LearnError::value("agents", problem));
        }
        if count == 0 {
            return Err(LearnError::value("num_envs", "must be 1 or more"));
        }
        let threads = Threads::start(threads.clamp(1, count))?;
        let mut envs: Vec<Env> = Vec::new();
        let mut need = None;
        while envs.len() < count {
            // The first one is made alone, then as many as there are: their memory shows whether there is room for all.
            let (begin, end) = (envs.len(), count.min((2 * envs.len()).max(1)));
            let mut more: Vec<Option<Env>> = (begin..end).map(|_| None).collect();
            threads.each(more.iter_mut().enumerate(), |(i, env)| {
                *env = Some(Env::new(Arc::clone(task), seed_of(seed, begin + i), &[])?);
                Ok(())
            })?;
            envs.extend(more.into_iter().flatten());
            let first = || Need::new(count, row_bytes(&task.layouts[0]), end);
            need.get_or_insert_with(first).check(end)?;
        }
        let runs = (0..count).map(|i| Run { seed: seed_of(seed, i), ..Run::default() }).collect();
        Ok(Self { envs, runs, threads, autoreset })
    }

    /// The environments.
    pub fn envs(&self) -> &[Env] {
        &self.envs
    }

    /// The description of an environment's run; of the one before it if `of_last`, which ended in the last step of
    /// [`Autoreset::SameStep`].
    ///
    /// # Panics
    /// If there is no such environment.
    pub fn info(&self, place: usize, of_last: bool) -> Info {
        let last = self.runs[place].last.as_ref().filter(|_| of_last);
        last.cloned().unwrap_or_else(|| Info::of(&self.envs[place]))
    }

    /// The fingerprints of all worlds in one.
    pub fn hash(&self) -> u64 {
        self.envs.iter().fold(0, |all, env| all.rotate_left(1) ^ env.world().hash())
    }

    /// Begins other runs: of environments that `which` is true of (of all without it), with these seeds.
    ///
    /// # Errors
    /// If a run's scenario is invalid.
    pub fn reset(
        &mut self,
        seeds: Seeds<'_>,
        which: Option<&[bool]>,
        arrays: Arrays<'_>,
    ) -> Result<(), LearnError> {
        let width = self.width();
        self.threads.are_there()?;
        let Self { envs, runs, threads, .. } = self;
        let work = envs.iter_mut().zip(runs).zip(arrays.rows(width)).enumerate();
        threads.each(work, |(i, ((env, run), mut row))| {
            if which.is_none_or(|which| which[i]) {
                let seed = match seeds {
                    Seeds::Next => None,
                    Seeds::From(seed) => Some(seed_of(seed, i)),
                    Seeds::Each(seeds) => seeds.get(i).copied().flatten(),
                };
                let next = match seed {
                    Some(seed) => Run { seed, ..Run::default() },
                    None => Run { seed: run.seed, number: run.number + 1, ..Run::default() },
                };
                env.reset(next.world_seed(), &[])?;
                *run = next;
            }
            row.observe(env);
            Ok(())
        })
    }

    /// A step of each environment. `actions` has shape (environments, actions). Returns whether a run ended in it.
    ///
    /// # Errors
    /// If an action is not finite, or a new run's scenario is invalid.
    ///
    /// # Panics
    /// If an array has another shape.
    pub fn step(
        &mut self,
        actions: &[f32],
        reward: &Reward,
        arrays: Arrays<'_>,
        out: Rewards<'_>,
    ) -> Result<bool, LearnError> {
        let signals = self.envs[0].agents()[0].layout().actions.len();
        if let Some(place) = actions.iter().position(|signal| !signal.is_finite()) {
            let path = format!("actions[{}, {}]", place / signals, place % signals);
            return Err(LearnError::value(path, format!("is {}", actions[place])));
        }
        self.threads.are_there()?;
        let (width, autoreset) = (self.width(), self.autoreset);
        let Rewards { rewards, terminated, truncated, tallies, finals } = out;
        let Self { envs, runs, threads, .. } = self;
        let mut finals = finals.map(|arrays| arrays.rows(width));
        let environments =
            envs.iter_mut().zip(runs).zip(actions.chunks_exact(signals)).zip(arrays.rows(width));
        let outcomes = rewards
            .iter_mut()
            .zip(&mut *terminated)
            .zip(&mut *truncated)
            .zip(tallies.chunks_exact_mut(Tally::NAMES.len()));
        let work = environments.zip(outcomes).map(
            |((((env, run), action), row), (((rewards, terminated), truncated), tally))| {
                let last = finals.as_mut().and_then(Iterator::next);
                Work { env, run, action, row, last, reward: rewards, terminated, truncated, tally }
            },
        );
        threads.each(work, |mut work| work.step(reward, autoreset))?;
        Ok(terminated.iter().chain(&*truncated).any(|has_ended| *has_ended))
    }

    /// Values and sensors of a row.
    fn width(&self) -> [usize; 2] {
        let layout = self.envs[0].agents()[0].layout();
        [layout.bounds.len(), layout.sensors.len()]
    }
}

impl Work<'_> {
    fn step(&mut self, reward: &Reward, autoreset: Autoreset) -> Result<(), LearnError> {
        let Self { env, run, .. } = self;
        let mut stepped = Stepped::default();
        if run.is_over && autoreset == Autoreset::NextStep {
            run.begin(env)?;
            self.tally.fill(0.0);
            *self.reward = 0.0;
        } else {
            env.act(0, self.action.iter().map(|&signal| f64::from(signal)))?;
            stepped = env.step();
            let tally = env.tally(0);
            self.tally.copy_from_slice(&tally.numbers());
            *self.reward = reward.of(tally);
        }
        (*self.terminated, *self.truncated) = (stepped.is_terminated, stepped.is_truncated);
        // A run that is over as soon as it begins has a step that reports it.
        run.is_over = stepped.is_terminated || stepped.is_truncated;
        if run.is_over && autoreset == Autoreset::SameStep {
            if let Some(last) = &mut self.last {
                last.observe(env);
            }
            run.last = Some(Info::of(env));
            run.begin(env)?;
        }
        self.row.observe(env);
        Ok(())
    }
}

impl<'a> Arrays<'a> {
    /// Row by row, with so many values and sensors each; as many as there are environments, also where a robot senses nothing.
    fn rows(self, [values, sensors]: [usize; 2]) -> impl Iterator<Item = Row<'a>> {
        let Self { values: mut all_values, ages_s: mut all_ages, readable: mut all_readable } = self;
        std::iter::from_fn(move || {
            Some(Row {
                values: all_values.split_off_mut(..values)?,
                ages_s: all_ages.split_off_mut(..sensors)?,
                readable: all_readable.split_off_mut(..sensors)?,
            })
        })
    }
}

impl Row<'_> {
    fn observe(&mut self, env: &Env) {
        let agent = &env.agents()[0];
        self.values.iter_mut().zip(agent.values()).for_each(|(to, value)| *to = *value as f32);
        self.ages_s.iter_mut().zip(agent.ages_s()).for_each(|(to, age_s)| *to = age_s as f32);
        self.readable.iter_mut().zip(agent.readable()).for_each(|(to, readable)| *to = i8::from(*readable));
    }
}

/// The size of an environment's arrays, in bytes: those of readings, ages and readability, of observations that are
/// kept and of their bounds.
fn row_bytes(layout: &Layout) -> u64 {
    (ROWS * (4 * layout.bounds.len() + 5 * layout.sensors.len())) as u64
}

/// The number of rows that a caller has of each environment.
const ROWS: usize = 6;
