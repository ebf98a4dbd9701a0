//! Systems and processors on which no program runs in simulated time.

use std::convert::Infallible;

use crate::{Cables, End, Error, Program, Report, Wait};

/// A program that runs in simulated time: there is none here.
#[derive(Debug)]
pub struct Session(Infallible);

/// The state of a program at an instant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// All its tasks wait.
    Waiting {
        /// For this instant at the latest, in nanoseconds.
        until_ns: Option<u64>,
    },
    /// It is over.
    Ended(End),
}

impl Session {
    /// Starts no program.
    ///
    /// # Errors
    ///
    /// Always: [`Error::Platform`].
    pub fn start(_: &Program) -> Result<Self, Error> {
        Err(Error::Platform)
    }

    /// There is no session to run.
    ///
    /// # Errors
    ///
    /// None.
    pub fn run(&mut self, _: u64, _: &mut dyn Cables) -> Result<State, Error> {
        match self.0 {}
    }

    /// There is no session to report of.
    pub fn report(&self) -> Report {
        match self.0 {}
    }

    /// There is no session that waits.
    pub fn waits(&self) -> Vec<Wait> {
        match self.0 {}
    }

    /// There is no session to interrupt.
    pub fn interrupt(&mut self, _: i32) {
        match self.0 {}
    }

    /// There is no session to end.
    pub fn kill(&mut self) {
        match self.0 {}
    }
}
