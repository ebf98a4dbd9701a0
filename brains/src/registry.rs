//! Kinds of processes by name: what a [description](crate::description) may name.
//!
//! [`Registry::standard`] has all of this crate's; a program adds its own with [`motor`](Registry::motor) and
//! [`cognitive`](Registry::cognitive), and then reads descriptions that name them.

use std::collections::BTreeMap;

use baudbot_brain::Body;
use serde::de::DeserializeOwned;
use toml::Table;

use crate::chance::Chance;
use crate::parameter::ParameterError;
use crate::process::{CognitiveProcess, MotorBehavior};

/// The context in which a process is built.
pub struct BuildContext<'a> {
    /// Its name in the repertoire.
    pub name: &'a str,
    /// The robot's body.
    pub body: &'a Body,
    /// Chooses the brain's random numbers.
    pub seed: u64,
    /// Names of the motor behaviours of the repertoire.
    pub motors: &'a [&'a str],
    /// Whether utilities decide, so that Γ counts.
    pub by_utility: bool,
}

impl BuildContext<'_> {
    /// Random numbers of the process's own.
    pub fn chance(&self) -> Chance {
        Chance::new(self.seed, &format!("{}/{}", self.body.name, self.name))
    }

    /// A process can raise the Γ of this motor behaviour, which its `parameter` names.
    pub(crate) fn check_raised(&self, parameter: &str, behavior: &str) -> Result<(), ParameterError> {
        if !self.motors.contains(&behavior) {
            let known = self.motors.join(", ");
            let problem = format_args!("there is no motor behaviour `{behavior}`; there are: {known}");
            return Err(ParameterError::value(parameter, problem));
        }
        if !self.by_utility {
            return Err(ParameterError::value(parameter, "needs a decision by utilities"));
        }
        Ok(())
    }
}

type Make<P> = Box<dyn Fn(Table, BuildContext<'_>) -> Result<Box<P>, ParameterError> + Send + Sync>;

/// Kinds of motor behaviours and of cognitive processes.
#[derive(Default)]
pub struct Registry {
    motors: BTreeMap<&'static str, Make<dyn MotorBehavior>>,
    cognitives: BTreeMap<&'static str, Make<dyn CognitiveProcess>>,
}

impl Registry {
    /// Without any.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a kind of motor behaviour. `make` gets its parameters as they are in the description, with defaults where those
    /// have any, and says why it cannot be made: `range_m: must be positive, is -1`.
    pub fn motor<P, B>(
        &mut self,
        kind: &'static str,
        make: impl Fn(P, BuildContext<'_>) -> Result<B, ParameterError> + Send + Sync + 'static,
    ) -> &mut Self
    where
        P: DeserializeOwned + 'static,
        B: MotorBehavior + 'static,
    {
        let make = move |table, context: BuildContext<'_>| {
            Ok(Box::new(make(read(table)?, context)?) as Box<dyn MotorBehavior>)
        };
        self.motors.insert(kind, Box::new(make));
        self
    }

    /// Adds a kind of cognitive process.
    pub fn cognitive<P, C>(
        &mut self,
        kind: &'static str,
        make: impl Fn(P, BuildContext<'_>) -> Result<C, ParameterError> + Send + Sync + 'static,
    ) -> &mut Self
    where
        P: DeserializeOwned + 'static,
        C: CognitiveProcess + 'static,
    {
        let make = move |table, context: BuildContext<'_>| {
            Ok(Box::new(make(read(table)?, context)?) as Box<dyn CognitiveProcess>)
        };
        self.cognitives.insert(kind, Box::new(make));
        self
    }

    /// Kinds of motor behaviours, in order.
    pub fn motors(&self) -> impl Iterator<Item = &'static str> {
        self.motors.keys().copied()
    }

    /// Kinds of cognitive processes, in order.
    pub fn cognitives(&self) -> impl Iterator<Item = &'static str> {
        self.cognitives.keys().copied()
    }

    pub(crate) fn make_motor(
        &self,
        kind: &str,
        table: Table,
        context: BuildContext<'_>,
    ) -> Result<Box<dyn MotorBehavior>, Unmade> {
        let make = self.motors.get(kind).ok_or_else(|| Unmade::Kind(self.motors().collect()))?;
        make(table, context).map_err(Unmade::Parameters)
    }

    pub(crate) fn make_cognitive(
        &self,
        kind: &str,
        table: Table,
        context: BuildContext<'_>,
    ) -> Result<Box<dyn CognitiveProcess>, Unmade> {
        let make = self.cognitives.get(kind).ok_or_else(|| Unmade::Kind(self.cognitives().collect()))?;
        make(table, context).map_err(Unmade::Parameters)
    }
}

/// A reason why there is no such process.
pub(crate) enum Unmade {
    /// There is no such kind, but these.
    Kind(Vec<&'static str>),
    /// The problem with its parameters.
    Parameters(ParameterError),
}

/// Parameters, by name.
fn read<P: DeserializeOwned>(table: Table) -> Result<P, ParameterError> {
    Ok(baudbot_fields::read(table)?)
}
