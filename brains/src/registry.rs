//! Kinds of processes by name: what a [description](crate::description) may name.
//!
//! [`Registry::standard`] has all of this crate's; a program adds its own to its [`motors`](Registry::motors) and
//! [`cognitives`](Registry::cognitives), and then reads descriptions that name them.

use std::collections::BTreeMap;

use baudbot_brain::Body;
use serde::de::DeserializeOwned;
use toml::Table;

use crate::chance::Chance;
use crate::parameter::ParameterError;
use crate::process::{CognitiveProcess, MotorBehavior};

/// The context in which a process is built.
pub struct BuildContext<'a> {
    /// The name of the process in the repertoire.
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
    /// Kinds of motor behaviours.
    pub motors: Kinds<dyn MotorBehavior>,
    /// Kinds of cognitive processes.
    pub cognitives: Kinds<dyn CognitiveProcess>,
}

/// Kinds of processes that are each a `P`.
pub struct Kinds<P: ?Sized>(BTreeMap<&'static str, Make<P>>);

impl<P: ?Sized> Default for Kinds<P> {
    fn default() -> Self {
        Self(BTreeMap::new())
    }
}

impl<P: ?Sized> Kinds<P> {
    /// Adds a kind. `make` gets its parameters as they are in the description, with defaults where those have any, and
    /// returns why it cannot be made: `range_m: must be positive, is -1`.
    pub fn add<T, B>(
        &mut self,
        kind: &'static str,
        make: impl Fn(T, BuildContext<'_>) -> Result<B, ParameterError> + Send + Sync + 'static,
    ) -> &mut Self
    where
        T: DeserializeOwned + 'static,
        B: Process<P>,
    {
        let make = move |table: Table, context: BuildContext<'_>| {
            Ok(make(baudbot_fields::read(table)?, context)?.boxed())
        };
        self.0.insert(kind, Box::new(make));
        self
    }

    /// The names of the kinds, in order.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        self.0.keys().copied()
    }

    pub(crate) fn make(&self, kind: &str, table: Table, context: BuildContext<'_>) -> Result<Box<P>, Unmade> {
        let make = self.0.get(kind).ok_or_else(|| Unmade::Kind(self.names().collect()))?;
        make(table, context).map_err(Unmade::Parameters)
    }
}

/// A process that is a `P`: each [`MotorBehavior`], and each [`CognitiveProcess`].
pub trait Process<P: ?Sized> {
    /// The process on the heap.
    fn boxed(self) -> Box<P>;
}

impl<B: MotorBehavior + 'static> Process<dyn MotorBehavior> for B {
    fn boxed(self) -> Box<dyn MotorBehavior> {
        Box::new(self)
    }
}

impl<C: CognitiveProcess + 'static> Process<dyn CognitiveProcess> for C {
    fn boxed(self) -> Box<dyn CognitiveProcess> {
        Box::new(self)
    }
}

/// A reason why there is no such process.
pub(crate) enum Unmade {
    /// There is no such kind, but these.
    Kind(Vec<&'static str>),
    /// The problem with its parameters.
    Parameters(ParameterError),
}
