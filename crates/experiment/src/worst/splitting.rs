//! Adaptive multilevel splitting: how likely a failure is that hardly any run shows.
//!
//! Of some runs those that came least near to a failure are given up, and each is replaced by one that shares the past of a better one
//! up to the instant at which that passed the level of those given up, and has other random numbers from there on. Level by level the
//! runs come nearer; the product of the shares that were kept estimates the probability without bias, whatever the number of runs
//! (Bréhier, Gazeau, Goudenège, Lelièvre and Rousset, *Unbiasedness of some generalized adaptive multilevel splitting algorithms*,
//! 2016). Runs with equal levels are given up together, which that takes.
//!
//! *Choice.* A past is not cloned but done again, from the seeds that it had: so brains need no copying, and a failure is told by a list
//! of seeds. It costs the time of the shared part.

use std::sync::Mutex;
use std::sync::PoisonError;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread;

use baudbot_sim::random::Stream;

use crate::error::Error;
use crate::statistics::{Sample, student};

/// The random numbers of a run: the scenario's seed, and others from some ticks on.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Lineage {
    pub(super) seed: u64,
    /// Ticks, in their order, with the seeds of what comes from them on.
    pub(super) turns: Vec<(u64, u64)>,
}

/// The course of a run towards failure: each tick in which it came nearer than ever, with how near. A failure is at infinity.
pub(super) type Approach = Vec<(u64, f64)>;

/// An estimate of the probability of a failure.
#[derive(Clone, Debug, PartialEq)]
pub struct Likelihood {
    /// The mean of independent estimates.
    pub probability: f64,
    /// The interval that it is in with a confidence of 95 %.
    pub interval: (f64, f64),
    /// The independent estimates.
    pub estimates: Vec<f64>,
    /// The number of runs.
    pub runs: u64,
}

/// The parameters of an estimate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    pub(super) particles: usize,
    pub(super) repeats: usize,
    pub(super) seed: u64,
    pub(super) jobs: usize,
}

/// A run of an estimate.
#[derive(Clone, Debug)]
struct Particle {
    lineage: Lineage,
    approach: Approach,
}

impl Particle {
    fn nearest(&self) -> f64 {
        self.approach.last().map_or(f64::NEG_INFINITY, |(_, near)| *near)
    }
}

/// Estimates the probability that a run reaches infinity. `run` does the run of a lineage; `each` is told the number of runs so far.
/// `None` if it was stopped.
///
/// # Errors
/// That of a run.
pub(super) fn estimate(
    extent: Extent,
    stop: &AtomicBool,
    each: &(dyn Fn(u64) + Sync),
    run: &(dyn Fn(&Lineage) -> Result<Approach, Error> + Sync),
) -> Result<Option<Likelihood>, Error> {
    let (mut estimates, mut runs) = (Vec::new(), 0);
    for repeat in 0..extent.repeats {
        let stream = Stream::new(extent.seed, &format!("worst/splitting/{repeat}"));
        let mut family = Family { extent, stream, stop, each, run, runs };
        let Some(estimate) = family.estimate()? else { return Ok(None) };
        estimates.push(estimate);
        runs = family.runs;
    }
    let probability = Sample::of(estimates.iter().copied()).mean().unwrap_or(0.0);
    Ok(Some(Likelihood { probability, interval: interval(&estimates), estimates, runs }))
}

/// The interval of the mean of estimates that are products, and so about log-normal: Cox's, with Student's quantile. If one is 0,
/// which has no logarithm, it is Student's of the mean, as a ratio; that is too narrow, which the report says.
fn interval(estimates: &[f64]) -> (f64, f64) {
    let sample = Sample::of(estimates.iter().copied());
    let logs = Sample::of(estimates.iter().map(|estimate| estimate.ln()));
    let (middle, half) = match (sample.mean(), sample.half_width(), logs.deviation()) {
        (Some(mean), Some(_), _) if mean <= 0.0 => return (0.0, 1.0),
        (Some(_), Some(_), Some(deviation)) if deviation.is_finite() => {
            let (count, variance) = (estimates.len() as f64, deviation * deviation);
            let of_the_variance = variance * variance / (2.0 * (count - 1.0));
            let half = student(estimates.len() as u64 - 1) * (variance / count + of_the_variance).sqrt();
            (logs.mean().unwrap_or_default() + variance / 2.0, half)
        }
        (Some(mean), Some(half), _) => (mean.ln(), half / mean),
        (None, _, _) | (_, None, _) => return (0.0, 1.0),
    };
    ((middle - half).exp(), (middle + half).exp().min(1.0))
}

/// One estimate that is under way.
struct Family<'a> {
    extent: Extent,
    stream: Stream,
    stop: &'a AtomicBool,
    each: &'a (dyn Fn(u64) + Sync),
    run: &'a (dyn Fn(&Lineage) -> Result<Approach, Error> + Sync),
    runs: u64,
}

impl Family<'_> {
    fn estimate(&mut self) -> Result<Option<f64>, Error> {
        let count = self.extent.particles;
        let first = (0..count).map(|_| Lineage { seed: self.draw_seed(), turns: Vec::new() }).collect();
        let Some(mut particles) = self.do_runs(first)? else { return Ok(None) };
        let mut kept = 1.0;
        loop {
            let mut levels: Vec<_> = particles.iter().map(Particle::nearest).collect();
            levels.sort_by(f64::total_cmp);
            let level = levels[(count / GIVEN_UP).max(1) - 1];
            let (survivors, lost): (Vec<_>, Vec<_>) =
                particles.into_iter().partition(|particle| particle.nearest() > level);
            if level == f64::INFINITY || survivors.is_empty() {
                let failed = lost.iter().filter(|particle| particle.nearest() == f64::INFINITY).count();
                return Ok(Some(kept * failed as f64 / count as f64));
            }
            kept *= survivors.len() as f64 / count as f64;
            let mut next = Vec::new();
            for _ in &lost {
                let parent = &survivors[self.stream.below(survivors.len() as u32) as usize];
                next.push(self.child(parent, level));
            }
            let Some(children) = self.do_runs(next)? else { return Ok(None) };
            particles = survivors;
            particles.extend(children);
        }
    }

    /// The lineage of a run that is the parent's until it has passed this level.
    fn child(&mut self, parent: &Particle, level: f64) -> Lineage {
        let passed = parent.approach.iter().find(|(_, near)| *near > level);
        let tick = passed.map_or(0, |(tick, _)| tick + 1);
        let turns = parent.lineage.turns.iter().copied().filter(|(at, _)| *at < tick);
        let turns = turns.chain([(tick, self.draw_seed())]).collect();
        Lineage { seed: parent.lineage.seed, turns }
    }

    fn draw_seed(&mut self) -> u64 {
        let halves = [self.stream.below(1 << 31), self.stream.below(u32::MAX)];
        u64::from(halves[0]) << 32 | u64::from(halves[1])
    }

    /// Does runs on some threads. Their order makes no difference.
    fn do_runs(&mut self, lineages: Vec<Lineage>) -> Result<Option<Vec<Particle>>, Error> {
        let (next, done) = (AtomicUsize::new(0), Mutex::new(vec![None; lineages.len()]));
        let work = || -> Result<(), Error> {
            while let Some((place, lineage)) = take(&next, &lineages) {
                if self.stop.load(Ordering::Relaxed) {
                    return Ok(());
                }
                let approach = (self.run)(lineage)?;
                let particle = Particle { lineage: lineage.clone(), approach };
                done.lock().unwrap_or_else(PoisonError::into_inner)[place] = Some(particle);
            }
            Ok(())
        };
        thread::scope(|scope| {
            let workers: Vec<_> = (0..self.extent.jobs.max(1)).map(|_| scope.spawn(work)).collect();
            let panicked = || Err(Error::Refused("a run panicked, which is a bug in baudbot".to_owned()));
            workers.into_iter().try_for_each(|worker| worker.join().unwrap_or_else(|_| panicked()))
        })?;
        self.runs += lineages.len() as u64;
        (self.each)(self.runs);
        Ok(done.into_inner().unwrap_or_else(PoisonError::into_inner).into_iter().collect())
    }
}

/// The next of a list, with its place, for one of several threads.
pub(super) fn take<'a, T>(next: &AtomicUsize, list: &'a [T]) -> Option<(usize, &'a T)> {
    let place = next.fetch_add(1, Ordering::Relaxed);
    Some((place, list.get(place)?))
}

/// One in so many runs is given up at each level, those with the same level, too.
const GIVEN_UP: usize = 10;

#[cfg(test)]
mod tests {
    use super::*;

    /// Messages, each of which is lost with this probability; the run fails if so many in a row are.
    #[derive(Clone, Copy)]
    struct Losses {
        probability: f64,
        in_a_row: u32,
        messages: u64,
    }

    impl Losses {
        /// Feller's recurrence: the state is how many have just been lost.
        fn likelihood(&self) -> f64 {
            let mut states = vec![0.0; self.in_a_row as usize];
            (states[0], _) = (1.0, ());
            let mut failed = 0.0;
            for _ in 0..self.messages {
                let all: f64 = states.iter().sum();
                failed += states.last().unwrap_or(&0.0) * self.probability;
                for state in (1..states.len()).rev() {
                    states[state] = states[state - 1] * self.probability;
                }
                states[0] = all * (1.0 - self.probability);
            }
            failed
        }

        fn run(&self, lineage: &Lineage) -> Approach {
            let mut stream = Stream::new(lineage.seed, "losses");
            let (mut approach, mut lost) = (Approach::new(), 0);
            for message in 0..self.messages {
                if let Some((_, seed)) = lineage.turns.iter().find(|(tick, _)| *tick == message) {
                    stream = Stream::new(*seed, "losses");
                }
                lost = if stream.uniform() < self.probability { lost + 1 } else { 0 };
                let near = if lost >= self.in_a_row { f64::INFINITY } else { f64::from(lost) };
                if approach.last().is_none_or(|(_, nearest)| near > *nearest) {
                    approach.push((message, near));
                }
            }
            approach
        }

        fn estimate(&self, seed: u64, particles: usize) -> Likelihood {
            let extent = Extent { particles, repeats: 10, seed, jobs: 2 };
            let estimate =
                estimate(extent, &AtomicBool::new(false), &|_| {}, &|lineage| Ok(self.run(lineage)));
            estimate.unwrap().unwrap()
        }
    }

    /// 1e-2, 1e-4 and 1e-6: the interval holds the truth in 19 of 20 trials. Plain sampling would take p (1 − p) / σ² runs for means that
    /// scatter as little as those of the trials.
    #[test]
    fn rare_failures_are_as_likely_as_they_are_told_to_be_and_cost_few_runs() {
        for (losses, cheaper) in [
            (Losses { probability: 0.2, in_a_row: 5, messages: 40 }, 1.0),
            (Losses { probability: 0.1, in_a_row: 5, messages: 12 }, 50.0),
            (Losses { probability: 0.1, in_a_row: 7, messages: 18 }, 1000.0),
        ] {
            let truth = losses.likelihood();
            let trials: Vec<_> = (1..=20).map(|seed| losses.estimate(seed, 200)).collect();
            let held = trials.iter().filter(|t| t.interval.0 <= truth && truth <= t.interval.1).count();
            let sample = Sample::of(trials.iter().map(|trial| trial.probability));
            let (mean, deviation) = (sample.mean().unwrap(), sample.deviation().unwrap());
            assert!(held >= 18 && (mean / truth - 1.0).abs() < 0.15, "{truth}: {held} of 20, {mean}");
            // As many drawn runs give as small a deviation.
            let plain = truth * (1.0 - truth) / (deviation * deviation);
            let runs = trials[0].runs;
            assert!(plain > cheaper * runs as f64, "{truth}: {runs} runs and not {plain}");
        }
    }

    #[test]
    fn an_estimate_is_the_same_in_any_number_of_threads() {
        let losses = Losses { probability: 0.2, in_a_row: 4, messages: 30 };
        let run = |jobs| {
            let extent = Extent { particles: 50, repeats: 3, seed: 7, jobs };
            estimate(extent, &AtomicBool::new(false), &|_| {}, &|lineage| Ok(losses.run(lineage))).unwrap()
        };
        assert_eq!(run(1), run(3));
    }

    #[test]
    fn what_cannot_fail_has_no_probability_and_what_always_fails_has_one() {
        let never = Losses { probability: 0.0, in_a_row: 2, messages: 5 }.estimate(1, 20);
        assert_eq!((never.probability, never.interval), (0.0, (0.0, 1.0)));
        let always = Losses { probability: 1.0, in_a_row: 2, messages: 5 }.estimate(1, 20);
        assert_eq!((always.probability, always.interval), (1.0, (1.0, 1.0)));
    }
}
