//! A single run, for optimizers outside.

use std::collections::BTreeMap;

use baudbot_run::UnknownName;
use serde_json::{Value, json};

use super::plan::Plan;
use crate::check::check;
use crate::design::Cell;
use crate::error::Error;
use crate::experiment::Experiment;
use crate::factor::{Choice, Field, Level};
use crate::local_runner;
use crate::run_record::Task;

/// Does a run with these values of an experiment's fields, by their labels, and tells how it keeps to what is required: an object with
/// `robustness`, `holds`, `at_s`, `requirement` and `state_hash`.
///
/// # Errors
/// If a field has no value, or one that it cannot have; if the run cannot be done in this process.
pub fn trial(experiment: &Experiment, values: &BTreeMap<String, f64>, seed: u64) -> Result<Value, Error> {
    let plan = Plan::new(experiment)?;
    check(&plan.experiment)?;
    let labels: Vec<_> = experiment.fields.iter().map(|field| field.label.as_str()).collect();
    if let Some(other) = values.keys().find(|label| !labels.contains(&label.as_str())) {
        return Err(Error::field("values", UnknownName::new("field", other, &labels)));
    }
    let levels = experiment.fields.iter().map(|field| level(field, values.get(&field.label).copied()));
    let cell = Cell { number: 0, levels: levels.collect::<Result<_, _>>()? };
    let ran = local_runner::run(&plan.experiment, &Task { run: 0, cell, seed }).outcome;
    let ran = ran.map_err(|error| Error::Refused(error.to_string()))?;
    let fall = ran.fall.ok_or_else(|| Error::Refused("nothing is required of the run".to_owned()))?;
    Ok(json!({
        "robustness": fall.robustness, "holds": fall.holds, "at_s": fall.at_s(),
        "requirement": plan.experiment.requirements[fall.requirement as usize].to_string(),
        "state_hash": format!("{:016x}", ran.hash),
    }))
}

fn level(field: &Field, value: Option<f64>) -> Result<Level, Error> {
    let at = || format!("values.{}", field.label);
    match (&field.choice, value) {
        (Choice::Range(range), Some(value)) if (range.from..=range.to).contains(&value) => {
            Ok(range.level(value))
        }
        (Choice::Range(range), Some(value)) => {
            Err(Error::field(at(), format!("must be from {} to {}, is {value}", range.from, range.to)))
        }
        (Choice::Range(_), None) => Err(Error::field(at(), "is missing")),
        (Choice::Levels(levels), None) if levels.len() == 1 => Ok(levels[0].clone()),
        (Choice::Levels(levels), value) => {
            let found = value.and_then(|value| levels.iter().find(|level| level.number == Some(value)));
            found.cloned().ok_or_else(|| {
                let names: Vec<_> = levels.iter().map(|level| level.name.as_str()).collect();
                Error::field(at(), format!("must be one of {}", names.join(", ")))
            })
        }
    }
}
