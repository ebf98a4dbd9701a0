//! Whether an experiment's paths lead anywhere, before the first run.
//!
//! Whether a field exists may depend on the values of others: a sensor of one kind has a range, one of another has none.
//! So each value is tried together with the first values of all other fields, and a path is refused only if no
//! combination that was tried has a place for it. What is wrong with a value is no matter here: it makes rows with an
//! error, and the other runs go on.

use std::collections::{BTreeMap, BTreeSet};

use baudbot_brain::Body;
use baudbot_brains::catalogue::{self, CatalogueError};
use baudbot_fields::Cause;
use baudbot_run::UnknownName;
use baudbot_run::assignment::{self, Assigned, AssignmentError};
use baudbot_scenario::ScenarioError;
use baudbot_sim::Scenario;

use crate::design::Cell;
use crate::error::Error;
use crate::experiment::Experiment;
use crate::factor::{Choice, Level, Setting};
use crate::run_record::Task;
use crate::setup::{self, Setup, SetupError};

/// Refuses an experiment whose scenario, brain or paths are not there, or whose runs would never end.
///
/// # Errors
/// An error with the field, and with the names that are near.
pub fn check(experiment: &Experiment) -> Result<(), Error> {
    let base = setup::overrides(experiment, [].iter());
    let scenario = setup::parse(experiment, &base)
        .map_err(|error| Error::field("scenario", format!("{}: {error}", experiment.scenario)))?;
    check_brains(experiment, &scenario)?;
    check_paths(experiment, &scenario)?;
    let is_end =
        |setting: &Setting| matches!(setting, Setting::Scenario { path, .. } if path.starts_with("end"));
    let ends = || levels(experiment).any(|(_, level)| level.settings.iter().any(is_end));
    if scenario.end.after.is_none() && !ends() {
        let problem = format!("is missing, and {} sets no end.after_s; a run must end", experiment.scenario);
        return Err(Error::field("seconds", problem));
    }
    Ok(())
}

/// Every level with the place of its field.
fn levels(experiment: &Experiment) -> impl Iterator<Item = (usize, Level)> {
    experiment.fields.iter().enumerate().flat_map(|(i, field)| {
        let levels = match &field.choice {
            Choice::Levels(levels) => levels.iter().take(MOST_LEVELS).cloned().collect(),
            Choice::Range(range) => vec![range.level(range.from), range.level(range.to)],
        };
        levels.into_iter().map(move |level| (i, level))
    })
}

fn check_brains(experiment: &Experiment, scenario: &Scenario) -> Result<(), Error> {
    let field = if experiment.brains.len() == 1 { "brain" } else { "brains" };
    let assigned = match assignment::assign(&experiment.brains, &scenario.robots) {
        Ok(assigned) => assigned,
        Err(
            error @ (AssignmentError::Robot { .. }
            | AssignmentError::Twice { .. }
            | AssignmentError::Mixed { .. }
            | AssignmentError::Program(_)),
        ) => {
            return Err(Error::field(field, error.to_string()));
        }
        // A run may have another robot.
        Err(
            AssignmentError::Blind { .. }
            | AssignmentError::OwnProgram { .. }
            | AssignmentError::Brain(_)
            | AssignmentError::Client(_),
        ) => Assigned::default(),
    };
    for assignment in &assigned.brains {
        let robots = scenario.robots.iter().filter(|spec| assignment.robots.contains(&spec.name));
        for spec in robots {
            match catalogue::brain(&assignment.brain, 1, &Body::from(spec)) {
                // A run may have other sensors.
                Ok(_) | Err(CatalogueError::Sensor { .. }) => {}
                Err(error) => return Err(Error::field(field, error.to_string())),
            }
        }
    }
    Ok(())
}

/// Settings of levels that no combination has a place for.
fn check_paths(experiment: &Experiment, base: &Scenario) -> Result<(), Error> {
    let first: Vec<_> = experiment.fields.iter().map(|field| first(&field.choice)).collect();
    let (mut good, mut bad) = (BTreeSet::new(), BTreeMap::new());
    for (place, level) in levels(experiment) {
        let mut all = first.clone();
        all[place] = level;
        let task = Task { run: 0, cell: Cell { number: 0, levels: all }, seed: 1 };
        let settings =
            || (0..).zip(&task.cell.levels).flat_map(|(i, level)| level.settings.iter().map(move |s| (i, s)));
        match Setup::new(experiment, &task) {
            Ok(setup) if wrong_path(&setup).is_none() => {
                good.extend(settings().map(|(_, setting)| name(setting).to_owned()));
            }
            Ok(_) => {
                let own = task.cell.levels[place].settings.first().map(name).unwrap_or_default();
                if let Some(error) = wrong_alone(experiment, &task, place) {
                    bad.entry((place, own.to_owned())).or_insert(error);
                }
            }
            Err(error) => {
                if let Some((i, setting, words)) = missing(&error, settings(), base) {
                    bad.entry((i, name(setting).to_owned())).or_insert(words);
                }
            }
        }
    }
    match bad.into_iter().find(|((_, path), _)| !good.contains(path)) {
        None => Ok(()),
        Some(((i, path), words)) => Err(Error::field(format!("fields[{i}]"), format!("{path}: {words}"))),
    }
}

/// The field that a described brain has no place for, if nothing but one field's level is set: then that one is wrong.
fn wrong_alone(experiment: &Experiment, task: &Task, place: usize) -> Option<String> {
    let levels = vec![task.cell.levels[place].clone()];
    let alone = Task { cell: Cell { number: 0, levels }, ..*task };
    wrong_path(&Setup::new(experiment, &alone).ok()?)
}

/// The field that a described brain has no place for.
fn wrong_path(setup: &Setup) -> Option<String> {
    let body = |robot: &String| setup.scenario.robots.iter().find(|spec| spec.name == *robot).map(Body::from);
    let mut all = setup
        .assigned
        .brains
        .iter()
        .flat_map(|assignment| assignment.robots.iter().map(move |robot| (assignment, robot)));
    all.find_map(|(assignment, robot)| match catalogue::brain(&assignment.brain, 1, &body(robot)?) {
        Err(CatalogueError::Description { brain, error }) if error.cause.is_absence() => {
            Some(CatalogueError::Description { brain, error }.to_string())
        }
        Ok(_) | Err(_) => None,
    })
}

fn first(choice: &Choice) -> Level {
    match choice {
        Choice::Levels(levels) => levels[0].clone(),
        Choice::Range(range) => range.level(range.from),
    }
}

fn name(setting: &Setting) -> &str {
    match setting {
        Setting::Scenario { path, .. } => path,
        Setting::Parameter { name, .. } => name,
        Setting::Brain(brain) => brain,
    }
}

/// The missing setting that the error is about, with those that there are.
fn missing<'a>(
    error: &SetupError,
    mut settings: impl Iterator<Item = (usize, &'a Setting)>,
    base: &Scenario,
) -> Option<(usize, &'a Setting, String)> {
    let mut by = |is: &dyn Fn(&Setting) -> bool, words: String| {
        settings.find(|(_, setting)| is(setting)).map(|(i, setting)| (i, setting, words))
    };
    let (path, problem, cause) = match error {
        SetupError::Scenario(ScenarioError::Field { path, problem, cause }) => (path, problem, cause),
        SetupError::Parameter(unknown) => {
            return by(&|setting| name(setting) == unknown.name(), unknown.to_string());
        }
        SetupError::Brain(AssignmentError::Brain(error)) => {
            let CatalogueError::Brain { name: unknown, .. } = error else { return None };
            return by(&|setting| name(setting) == unknown, error.to_string());
        }
        SetupError::Scenario(_) | SetupError::Endless | SetupError::Brain(_) => return None,
    };
    let words = || UnknownName::of(cause).map(|unknown| unknown.to_string()).unwrap_or_default();
    match cause {
        Cause::UnknownField { name, .. } => by(&|setting| mentions(setting, name), words()),
        Cause::UnknownElement { name, .. } => {
            by(&|setting| parts(setting).any(|part| part == &**name), words())
        }
        Cause::NoTable => by(&|setting| name(setting).starts_with(path.as_str()), problem.clone()),
        Cause::MissingField => {
            // A path made a part that was not there, which lacks what such parts must have.
            let made = path.rsplit('.').next()?;
            let known = devices(base);
            let is_new = !known.contains(&made);
            let makes = |setting: &Setting| {
                parts(setting).skip_while(|part| !MAPS.contains(part)).nth(1) == Some(made)
            };
            let unknown = UnknownName::new("sensor or actuator", made, &known);
            by(&|setting| is_new && makes(setting), unknown.to_string())
        }
        Cause::Value => None,
    }
}

fn parts(setting: &Setting) -> impl Iterator<Item = &str> {
    name(setting).split(['.', '[', ']']).filter(|part| !part.is_empty())
}

fn mentions(setting: &Setting, field: &str) -> bool {
    let in_value = |value: &str| value.starts_with('{') && value.contains(field);
    parts(setting).any(|part| part == field)
        || matches!(setting, Setting::Scenario { value, .. } if in_value(value))
}

/// Names of all sensors and actuators.
fn devices(scenario: &Scenario) -> Vec<&str> {
    let robots = scenario.robots.iter();
    let names = robots.flat_map(|robot| {
        let sensors = robot.sensors.iter().map(|sensor| sensor.name.as_str());
        sensors.chain(robot.actuators.iter().map(|actuator| actuator.name.as_str()))
    });
    names.collect::<BTreeSet<_>>().into_iter().collect()
}

/// Tables of a robot to which a path can add a part.
const MAPS: [&str; 2] = ["sensors", "actuators"];

/// More levels of a field than these have no other paths, as `values` all have the same.
const MOST_LEVELS: usize = 1000;
