//! The faults, in words: the exercise's advice for typical mistakes, and observations of any brain.

use std::collections::BTreeMap;

use crate::figures::Figure;

use crate::grade::advice::shown;
use crate::grade::exercise::Exercise;
use crate::grade::measure::{Measure, Own};
use crate::grade::points::Awarded;
use crate::grade::run::Run;

/// The findings of a grading that is not passed, the most telling first: brains that failed, collisions, the exercise's own
/// advice, and what is suspicious of any brain.
pub(crate) fn of(exercise: &Exercise, runs: &[Run], awarded: &[Awarded]) -> Vec<String> {
    let mut findings = problems(runs);
    if is_about_collisions(exercise, awarded) {
        findings.extend(collisions(runs));
    }
    let advice = exercise.advice.iter().filter_map(|advice| {
        let words = |run: &Run| advice.words(run.measures()?);
        told(runs, &words)
    });
    findings.extend(advice);
    findings.extend(SUSPICIONS.iter().filter_map(|suspicion| told(runs, suspicion)));
    findings
}

/// Words for the runs that they are about, in the numbers of the first of these.
fn told(runs: &[Run], words: &dyn Fn(&Run) -> Option<String>) -> Option<String> {
    let all: Vec<_> = runs.iter().filter_map(|run| Some((run.seed, words(run)?))).collect();
    let seeds: Vec<_> = all.iter().map(|(seed, _)| *seed).collect();
    let (_, first) = all.into_iter().next()?;
    Some(format!("{first} ({})", in_seeds(&seeds, runs.len())))
}

/// The faults of brains, the same words once.
fn problems(runs: &[Run]) -> Vec<String> {
    let mut by_words: BTreeMap<String, Vec<&Run>> = BTreeMap::new();
    for run in runs {
        if let Err(problem) = &run.outcome {
            by_words.entry(problem.to_string()).or_default().push(run);
        }
    }
    let mut all: Vec<_> = by_words.into_iter().collect();
    // Order by the first seed and not by the words.
    all.sort_by_key(|(_, of)| runs.iter().position(|run| Some(&run) == of.first()));
    let told = |(words, of): (String, Vec<&Run>)| {
        let seeds: Vec<_> = of.iter().map(|run| run.seed).collect();
        let at_s = of.first().map_or(0.0, |run| run.time_s);
        let at = if at_s > 0.0 { format!("at {} s ", shown(at_s)) } else { String::new() };
        format!("{at}{}: {words}", in_seeds(&seeds, runs.len()))
    };
    all.into_iter().map(told).collect()
}

/// Whether points are missing for which nothing may be hit. A run that a collision has ended lacks other points, too.
fn is_about_collisions(exercise: &Exercise, awarded: &[Awarded]) -> bool {
    let collisions = [Measure::Figure(Figure::Collisions), Measure::Own(Own::FirstCollisionS)];
    let all = exercise.criteria.iter().zip(awarded);
    all.filter(|(_, awarded)| !awarded.fulfilled.iter().all(|&fulfilled| fulfilled)).any(|(criterion, _)| {
        criterion.needs.iter().any(|condition| collisions.contains(&condition.quantity))
    })
}

fn collisions(runs: &[Run]) -> Option<String> {
    let first: Vec<_> = runs.iter().filter_map(|run| Some((run.seed, run.hits.first()?))).collect();
    let (seed, hit) = first.first()?;
    let seeds: Vec<_> = first.iter().map(|(seed, _)| *seed).collect();
    Some(format!(
        "`{}` collided at {} s with `{}` (seed {seed}); there were collisions {}",
        hit.robot,
        shown(hit.at_s),
        hit.with,
        in_seeds(&seeds, runs.len())
    ))
}

/// The suspicious signs of any brain.
const SUSPICIONS: [fn(&Run) -> Option<String>; 3] = [no_commands, queue, old_readings];

fn no_commands(run: &Run) -> Option<String> {
    let commands = run.measures()?.get(Measure::Own(Own::Commands))?;
    (commands == 0.0).then(|| {
        "no command has reached the robot: the brain must answer with drive(left, right), and not with nothing".to_owned()
    })
}

fn queue(run: &Run) -> Option<String> {
    let bytes = run.measures()?.get(Measure::Own(Own::QueueMaxBytes))?;
    (bytes > LONG_QUEUE_BYTES).then(|| {
        format!(
            "up to {} bytes waited for the cable to the robot, so that commands were obeyed late: the brain sends more than the \
             cable carries",
            shown(bytes)
        )
    })
}

fn old_readings(run: &Run) -> Option<String> {
    let measures = run.measures()?;
    let collisions = measures.get(Measure::Figure(Figure::Collisions))?;
    let age_ms = measures.get(Measure::Figure(Figure::StalenessP95Ms))?;
    (collisions > 0.0 && age_ms > OLD_MS).then(|| {
        format!(
            "the brain steered by readings up to {} ms old: `baudbot diagram` draws when each is read, sent and used; drive more \
             slowly, or have less on the cable",
            shown(age_ms)
        )
    })
}

/// `in seeds 1 and 3`, `in all 5 seeds`.
pub(crate) fn in_seeds(seeds: &[u64], of: usize) -> String {
    match seeds {
        _ if seeds.len() == of && of > 1 => format!("in all {of} seeds"),
        [seed] => format!("in seed {seed}"),
        _ if seeds.len() <= MOST_NAMED => {
            let names: Vec<_> = seeds.iter().map(ToString::to_string).collect();
            format!("in {} of {of} seeds: {}", seeds.len(), names.join(", "))
        }
        _ => format!("in {} of {of} seeds", seeds.len()),
    }
}

/// More seeds than these are counted only.
const MOST_NAMED: usize = 8;

/// Commands are some ten bytes each: from so many on, more than a few wait.
const LONG_QUEUE_BYTES: f64 = 100.0;

/// Readings of such an age are old for a robot that drives a tenth of a metre meanwhile.
const OLD_MS: f64 = 100.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_are_named_if_they_are_few() {
        assert_eq!(in_seeds(&[3], 5), "in seed 3");
        assert_eq!(in_seeds(&[1], 1), "in seed 1");
        assert_eq!(in_seeds(&[1, 3], 5), "in 2 of 5 seeds: 1, 3");
        assert_eq!(in_seeds(&[1, 2], 2), "in all 2 seeds");
        assert_eq!(in_seeds(&(1..=9).collect::<Vec<_>>(), 20), "in 9 of 20 seeds");
    }
}
