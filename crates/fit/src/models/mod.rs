//! The models: each computes how likely a log is for some numbers.

mod bus;
mod commands;
pub(crate) mod compass;
pub(crate) mod curve;
pub(crate) mod echo;
mod jitter;
mod judged;
pub(crate) mod motion;
pub(crate) mod radio;
pub(crate) mod response;
pub(crate) mod specimens;
pub(crate) mod travel;
mod uneven;
mod whole;

use baudbot_sim::model::RobotModel;

use crate::estimate::{Finding, Outcome, Reason};
use crate::fields::{Field, SensorField};
use crate::log::{Column, Log, Quantity};

/// The robot whose numbers are looked for, and how its world is computed.
#[derive(Clone, Copy, Debug)]
pub struct Robot<'a> {
    /// The robot.
    pub model: &'a RobotModel,
    /// Δt, in seconds.
    pub tick_s: f64,
    /// The Euler step of its motion, in seconds.
    pub substep_s: f64,
}

/// The task of a model.
#[derive(Clone, Copy)]
pub(crate) struct Case<'a> {
    pub(crate) robot: Robot<'a>,
    pub(crate) log: &'a Log,
    /// The fields of this model that are wanted.
    pub(crate) wanted: &'a [Field],
}

impl Case<'_> {
    pub(crate) fn wants(&self, field: Field) -> bool {
        self.wanted.contains(&field)
    }

    pub(crate) fn finding(&self, field: Field, outcome: Outcome) -> Finding {
        Finding { path: field.path(self.robot.model), is_field: true, outcome }
    }

    /// No wanted field has a result, for one reason.
    pub(crate) fn none(&self, reason: &Reason) -> Vec<Finding> {
        let outcome = || Outcome::CannotTell(reason.clone());
        self.wanted.iter().map(|field| self.finding(*field, outcome())).collect()
    }

    /// A column, or the reason that it is missing.
    pub(crate) fn column(&self, quantity: Quantity) -> Result<&Column, Reason> {
        let example = quantity.dimension().units()[0].suffix;
        let needs = if example.is_empty() {
            format!("column `{quantity}`")
        } else {
            format!("column `{quantity}_{example}`{}", what_for(quantity))
        };
        self.log.column(quantity).ok_or(Reason::Columns { needs })
    }

    /// Whether the field is wanted of any sensor.
    fn wanted_of(&self, field: SensorField) -> bool {
        self.wanted.iter().any(|wanted| matches!(wanted, Field::Sensor(_, of) if *of == field))
    }

    /// The findings of all sensors, which are specimens of one kind, from the outcome of each of the model's fields that is
    /// wanted.
    fn findings(&self, fields: &[SensorField], mut outcome: impl FnMut(usize) -> Outcome) -> Vec<Finding> {
        let mut outcomes = Vec::new();
        for (i, field) in fields.iter().enumerate().filter(|(_, field)| self.wanted_of(**field)) {
            outcomes.push((*field, outcome(i)));
        }
        let outcome = |field: &Field| match field {
            Field::Sensor(_, of) => outcomes.iter().find(|(field, _)| field == of).map(|(_, of)| of.clone()),
            Field::Adapter(_) | Field::Motors(_) | Field::Body(_) => None,
        };
        self.wanted.iter().filter_map(|field| Some(self.finding(*field, outcome(field)?))).collect()
    }
}

/// The numbers of the scenario, with those that are searched in place of some.
fn merged<const N: usize>(mut fixed: [f64; N], free: &[usize], values: &[f64]) -> [f64; N] {
    for (i, value) in free.iter().zip(values) {
        fixed[*i] = *value;
    }
    fixed
}

/// The numbers that are searched, of those to begin with.
fn chosen<const N: usize>(free: &[usize], starts: &[[f64; N]]) -> Vec<Vec<f64>> {
    starts.iter().map(|start| free.iter().map(|i| start[*i]).collect()).collect()
}

/// The origin of a column that people do not have by themselves.
fn what_for(quantity: Quantity) -> &'static str {
    if matches!(quantity, Quantity::X | Quantity::Y | Quantity::Heading) {
        ": the true pose, as from a camera above the robot or a laser's map; the odometer's own pose has no information about its errors"
    } else {
        ""
    }
}
