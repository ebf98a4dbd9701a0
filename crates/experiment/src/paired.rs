//! Combinations beside the first one, seed by seed: what their runs have in common by their seeds is no part of the difference.

use serde_json::{Map, Value, json};

use crate::experiment::Experiment;
use crate::figures::{Figure, Figures, INFOS};
use crate::run_record::Row;
use crate::statistics::{Sample, mcnemar, pairs_for_difference, pairs_for_shares};

/// The runs of the first combination, by the places of their seeds.
#[derive(Clone, Debug, Default)]
pub(crate) struct Baseline {
    runs: Vec<Option<Half>>,
}

/// A run of a pair.
#[derive(Clone, Debug)]
struct Half {
    success: Option<bool>,
    figures: Figures,
}

/// A combination beside the first one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Comparison {
    /// Pairs of runs with the same seed, both of which could be done.
    pub pairs: u64,
    /// Pairs in which only the run of this combination succeeded.
    pub gained: u64,
    /// Pairs in which only the run of the first one did.
    pub lost: u64,
    /// The differences of each figure, this combination less the first one.
    pub figures: [Sample; Figures::COUNT],
}

impl Baseline {
    /// Takes in a row of the first combination.
    pub(crate) fn add(&mut self, experiment: &Experiment, row: &Row) {
        if self.runs.len() < MOST_PAIRS {
            self.runs.push(Half::of(experiment, row));
        }
    }

    /// The comparison with a row of another combination, if its seed had a run in the first.
    pub(crate) fn compare(&self, experiment: &Experiment, place: usize, row: &Row, with: &mut Comparison) {
        let (Some(Some(first)), Some(this)) = (self.runs.get(place), Half::of(experiment, row)) else {
            return;
        };
        with.pairs += 1;
        with.gained += u64::from((first.success, this.success) == (Some(false), Some(true)));
        with.lost += u64::from((first.success, this.success) == (Some(true), Some(false)));
        for (sample, (before, after)) in
            with.figures.iter_mut().zip(first.figures.0.iter().zip(this.figures.0))
        {
            if let (Some(before), Some(after)) = (before, after) {
                sample.add(after - before);
            }
        }
    }
}

impl Baseline {
    /// The value of a figure, or of success, in the run with the seed of this place.
    pub(crate) fn value(&self, place: usize, figure: Option<Figure>) -> Option<f64> {
        let first = self.runs.get(place)?.as_ref()?;
        match figure {
            Some(figure) => first.figures.get(figure),
            None => first.success.map(|success| f64::from(u8::from(success))),
        }
    }
}

impl Half {
    fn of(experiment: &Experiment, row: &Row) -> Option<Self> {
        let ran = row.outcome.as_ref().ok()?;
        Some(Self { success: experiment.succeeded(row), figures: ran.figures.clone() })
    }
}

impl Comparison {
    /// The difference of the shares of runs that succeeded, and how likely one at least as large is by chance (McNemar's exact test).
    pub fn success(&self) -> Option<(f64, f64)> {
        let difference = (self.gained as f64 - self.lost as f64) / self.pairs as f64;
        (self.pairs > 0).then(|| (difference, mcnemar(self.lost, self.gained)))
    }

    /// The number of seeds with which such a difference is told from none with a power of 80 %.
    pub fn seeds_needed(&self) -> Option<u64> {
        let share = |count: u64| count as f64 / self.pairs as f64;
        (self.pairs > 0).then(|| pairs_for_shares(share(self.lost), share(self.gained), POWER)).flatten()
    }

    pub(crate) fn json(&self) -> Value {
        let figure = |sample: &Sample| {
            let needed = sample.mean().zip(sample.deviation());
            let needed = needed.and_then(|(mean, deviation)| pairs_for_difference(mean, deviation, POWER));
            json!({ "difference": sample.mean(), "plus_minus": sample.half_width(), "seeds_needed": needed })
        };
        let figures =
            INFOS.iter().zip(&self.figures).map(|(info, sample)| (info.name.to_owned(), figure(sample)));
        let success = self.success().map(|(difference, p)| {
            json!({
                "difference": difference, "gained": self.gained, "lost": self.lost, "p": p, "seeds_needed": self.seeds_needed(),
            })
        });
        json!({ "pairs": self.pairs, "success": success, "figures": figures.collect::<Map<_, _>>() })
    }
}

/// The wanted power of the numbers of seeds that are needed.
const POWER: f64 = 0.8;

/// Seeds beyond these are not compared, so that the memory that pairs take is limited.
const MOST_PAIRS: usize = 100_000;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_tell_what_chance_would_hide() {
        // Of 40 seeds nine are lost and one is gained: scipy.stats.binomtest(1, 10).pvalue is 0.021484375.
        let comparison = Comparison { pairs: 40, gained: 1, lost: 9, ..Comparison::default() };
        let (difference, p) = comparison.success().unwrap();
        assert!((difference + 0.2).abs() < 1e-12 && (p - 0.021_484_375).abs() < 1e-9, "{difference} {p}");
        assert!((40..60).contains(&comparison.seeds_needed().unwrap()), "{:?}", comparison.seeds_needed());
        assert_eq!(Comparison::default().success(), None);
    }

    #[test]
    fn the_interval_of_paired_differences_is_students() {
        let pairs = [(5.1, 4.9), (4.8, 4.9), (6.0, 5.2), (5.5, 5.0), (4.9, 4.4), (5.7, 5.6)];
        let mut comparison = Comparison { pairs: 6, ..Comparison::default() };
        comparison.figures[0] = Sample::of(pairs.map(|(this, first)| this - first));
        let told = &comparison.json()["figures"][INFOS[0].name];
        // scipy's ttest_rel, whose interval is from -0.00941 to 0.67608; (1.96 + 0.8416)² (0.32660 / 0.33333)² is 7.53.
        let number = |name: &str| told[name].as_f64().unwrap();
        assert!((number("difference") - 1.0 / 3.0).abs() < 1e-12, "{told}");
        assert!((number("plus_minus") - 0.342_744).abs() < 1e-5, "{told}");
        assert_eq!(told["seeds_needed"], 8);
    }
}
