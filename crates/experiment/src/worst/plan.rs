//! The plan of a search for the worst run, which is known before the first run.

use baudbot_require::Rule;
use baudbot_run::assignment;
use baudbot_run::programs::{EXEC, PROGRAM};

use crate::design::Cell;
use crate::error::Error;
use crate::experiment::Experiment;
use crate::factor::{Choice, Level};
use crate::fingerprint::{build, fingerprint_with};
use crate::journal::Header;
use crate::raw::Strategy;
use crate::requirement::Demand;
use crate::run_record::Task;
use crate::seeds::Seeds;
use crate::tune::{check_optimizers, number_at};

/// An experiment whose worst run is wanted.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    /// The experiment, with what is usually required if it requires nothing.
    pub(super) experiment: Experiment,
    pub(super) strategy: Strategy,
}

impl Plan {
    pub(super) fn new(experiment: &Experiment) -> Result<Self, Error> {
        let mut experiment = experiment.clone();
        experiment.requirements = Demand::or_usual(&experiment.requirements);
        let usual = if experiment.fields.is_empty() { Strategy::Random } else { Strategy::CmaEs };
        let strategy = experiment.hunt.strategy.unwrap_or(usual);
        match strategy {
            Strategy::CmaEs if experiment.fields.is_empty() => {
                let problem = "`cma-es` needs [[fields]], of which it looks for the values; without any, `random` tries seeds";
                return Err(Error::field("worst.method", problem));
            }
            Strategy::CmaEs => check_optimizers()?,
            Strategy::Splitting => refuse_splitting(&experiment)?,
            Strategy::Random => {}
        }
        Ok(Self { experiment, strategy })
    }

    /// The journal's. More runs go on with what there is.
    pub(super) fn header(&self) -> Header {
        let Experiment { name, hunt, requirements, .. } = &self.experiment;
        let own = format!("worst {:?}", (self.strategy, hunt.seed, requirements));
        Header::new(name, fingerprint_with(&self.experiment, &own), build(), i64::MAX as u64)
    }

    /// A run at a point of the unit cube.
    pub(super) fn task(&self, run: u64, point: &[f64]) -> Task {
        let levels =
            self.experiment.fields.iter().zip(point).map(|(field, share)| level(&field.choice, *share));
        Task { run, cell: Cell { number: run, levels: levels.collect() }, seed: self.seed(run) }
    }

    /// The seed of a run: each has another, unless they are listed.
    pub(super) fn seed(&self, run: u64) -> u64 {
        match &self.experiment.seeds {
            Seeds::From(first, _) => first.saturating_add(run).min(i64::MAX as u64),
            Seeds::List(seeds) => seeds[(run % seeds.len() as u64) as usize],
        }
    }
}

/// Splitting takes a nearness that never goes back, and brains whose past can be done again in this process.
fn refuse_splitting(experiment: &Experiment) -> Result<(), Error> {
    let is_monotone = |demand: &Demand| matches!(demand.requirement.rule, Rule::Always(_) | Rule::Never(_));
    if let Some(demand) = experiment.requirements.iter().find(|demand| !is_monotone(demand)) {
        let problem = format!(
            "`splitting` is for always and never; `{demand}` may still be met after it has nearly failed: use `random`"
        );
        return Err(Error::field("worst.method", problem));
    }
    let is_program = |brain: &&str| {
        let brain = assignment::split(brain).1;
        [EXEC, PROGRAM].iter().any(|prefix| brain.starts_with(prefix))
    };
    if let Some(brain) = experiment.all_brains().find(is_program) {
        let problem = format!(
            "`splitting` does each run's past again in this process, where `{brain}` is not: use `random` or `cma-es`"
        );
        return Err(Error::field("worst.method", problem));
    }
    Ok(())
}

/// The value of a field at a share of its range, or of its list.
fn level(choice: &Choice, share: f64) -> Level {
    match choice {
        Choice::Range(range) => range.level(number_at(range, share)),
        Choice::Levels(levels) => {
            levels[((share * levels.len() as f64) as usize).min(levels.len() - 1)].clone()
        }
    }
}
