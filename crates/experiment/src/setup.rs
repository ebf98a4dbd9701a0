//! The setup of a run: its scenario, and the brain of each robot.

use baudbot_run::UnknownName;
use baudbot_run::assignment::{self, Assigned, AssignmentError};
use baudbot_scenario::{Override, ScenarioError};
use baudbot_sim::Scenario;

use crate::experiment::Experiment;
use crate::factor::Setting;
use crate::run_record::Task;

/// A run that can be done.
pub(crate) struct Setup {
    pub(crate) scenario: Scenario,
    pub(crate) assigned: Assigned,
}

/// A reason why a run cannot be done, in a line.
#[derive(Debug, thiserror::Error)]
pub(crate) enum SetupError {
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    #[error("the run has no time limit; set `seconds`, or end.after_s")]
    Endless,
    #[error(transparent)]
    Brain(#[from] AssignmentError),
    #[error(transparent)]
    Parameter(#[from] UnknownName),
}

impl Setup {
    pub(crate) fn new(experiment: &Experiment, task: &Task) -> Result<Self, SetupError> {
        let mut overrides = overrides(experiment, settings(task));
        overrides.push(format!("seed={}", task.seed));
        let scenario = parse(experiment, &overrides)?;
        if scenario.end.after.is_none() {
            return Err(SetupError::Endless);
        }
        let assigned = assigned(experiment, task, &scenario)?;
        Ok(Self { scenario, assigned })
    }
}

/// All fields that a task sets.
pub(crate) fn settings(task: &Task) -> impl Iterator<Item = &Setting> {
    task.cell.levels.iter().flat_map(|level| &level.settings)
}

/// The changes of the scenario in the form of `--set`; later ones win.
pub(crate) fn overrides<'a>(
    experiment: &Experiment,
    settings: impl Iterator<Item = &'a Setting>,
) -> Vec<String> {
    let seconds = experiment.seconds.map(|seconds| format!("end.after_s={seconds:?}"));
    seconds.into_iter().chain(settings.filter_map(Setting::as_override)).collect()
}

pub(crate) fn parse(experiment: &Experiment, overrides: &[String]) -> Result<Scenario, ScenarioError> {
    let overrides = overrides.iter().map(|text| Override::parse(text)).collect::<Result<Vec<_>, _>>()?;
    baudbot_scenario::parse_with(&experiment.text, &overrides)
}

/// The experiment's brains with what the task changes of them.
fn assigned(experiment: &Experiment, task: &Task, scenario: &Scenario) -> Result<Assigned, SetupError> {
    let mut brains = experiment.brains.clone();
    for setting in settings(task) {
        if let Setting::Brain(brain) = setting {
            brains.retain(|text| assignment::split(text).0.is_some());
            brains.push(brain.clone());
        }
    }
    let mut assigned = assignment::assign(&brains, &scenario.robots)?;
    for task in &mut assigned.programs {
        task.program = task.program.clone().in_folder(experiment.folder.clone());
        task.lifetime = experiment.lifetime;
    }
    for task in &mut assigned.at_ports {
        task.program = task.program.clone().in_folder(experiment.folder.clone());
    }
    for setting in settings(task) {
        if let Setting::Parameter { name, value } = setting {
            assigned.set_parameter(name, value)?;
        }
    }
    Ok(assigned)
}
