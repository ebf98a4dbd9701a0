//! The result of a brain's step.

use alloc::vec::Vec;
use core::time::Duration;

/// The action of a brain in a step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Action {
    /// Signals for the motors; `None` leaves those in force.
    pub signals: Option<Signals>,
    /// Signals for the other actuators, all of them, in the order of [`Body::actuators`](crate::Body::actuators);
    /// empty sends again what was sent last. A command has the signals of all motors and actuators, so these
    /// count only beside [`signals`](Self::signals).
    pub others: Vec<f64>,
    /// The brain's own figure for its thinking time, in simulated time; `None`: the scenario's.
    pub thinking: Option<Duration>,
    /// Instead of `thinking`, on a robot that is onboard: how many operations its program did.
    pub operations: Option<u64>,
    /// Asks a firmware that answers only when asked. Signals ask too (where they do not on the wire, a poll is sent
    /// behind them), so this counts only without them.
    pub poll: bool,
    /// The brain now waits for news; `None`: it wants each of its turns.
    pub until: Option<Until>,
}

impl Action {
    /// Sends signals.
    pub const fn drive(left: f64, right: f64) -> Self {
        let mut action = Self::wait();
        action.signals = Some(Signals { left, right });
        action
    }

    /// Sends nothing.
    pub const fn wait() -> Self {
        Self { signals: None, others: Vec::new(), thinking: None, operations: None, poll: false, until: None }
    }

    /// Asks for readings.
    pub const fn poll() -> Self {
        let mut action = Self::wait();
        action.poll = true;
        action
    }

    /// The same after so much simulated time of thought.
    #[must_use]
    pub const fn after(mut self, thinking: Duration) -> Self {
        self.thinking = Some(thinking);
        self
    }

    /// The same, and then waits until something new has come: turns without news are not given to the brain. Each
    /// counts as [`wait`](Self::wait). In lockstep they do not even cross the network, so that a brain which acts on
    /// news alone loses no time with the others.
    #[must_use]
    pub const fn until_message(mut self) -> Self {
        self.until = Some(Until { at_latest_ns: None });
        self
    }

    /// The same as [`until_message`](Self::until_message), but the first turn at this instant of simulated time, or
    /// after it, is given to the brain in any case.
    #[must_use]
    pub const fn until_message_or(mut self, at_latest_ns: u64) -> Self {
        self.until = Some(Until { at_latest_ns: Some(at_latest_ns) });
        self
    }

    /// The same after so many operations of the microcontroller that the brain runs on.
    #[must_use]
    pub const fn operations(mut self, operations: u64) -> Self {
        self.operations = Some(operations);
        self
    }

    /// The same with signals for the actuators besides the wheels, all of them, in the order of
    /// [`Body::actuators`](crate::Body::actuators).
    #[must_use]
    pub fn with_others(mut self, others: Vec<f64>) -> Self {
        self.others = others;
        self
    }
}

/// Signals for the motors; 1 is full voltage forwards.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Signals {
    /// The signal of the left motor.
    pub left: f64,
    /// The signal of the right motor.
    pub right: f64,
}

/// The instant until which a brain wants no turn without news, as a program that reads from its serial port with a
/// timeout.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Until {
    /// The instant at which it wants a turn in any case, in nanoseconds of simulated time; `None`: never.
    pub at_latest_ns: Option<u64>,
}

impl Until {
    /// Whether the time to wait is over at this instant, in nanoseconds of simulated time.
    pub fn is_over(&self, at_ns: u64) -> bool {
        self.at_latest_ns.is_some_and(|at_latest_ns| at_ns >= at_latest_ns)
    }
}
