//! The context in which robots are checked: the length of a tick, and the world that they are put into.

use alloc::string::String;
use alloc::vec::Vec;

use baudbot_sim::arena::Arena;
use baudbot_sim::movable::Body;
use baudbot_sim::scenario::SerialPort;
use baudbot_sim::surroundings::Surroundings;

baudbot_fields::rules! {
    /// The period of anything that repeats, in milliseconds: below the least a run would do nothing else.
    Period: Any, MIN_PERIOD_MS, 1e7;
    /// A time that something lasts, in seconds.
    Lasting: Any, 1e-9, 1e8;
}

/// Shortest period of anything that repeats: below it a run would do nothing else.
pub(super) const MIN_PERIOD_MS: f64 = 0.01;
/// Most Euler steps in a tick.
pub(super) const MAX_SUBSTEPS: u64 = 10_000;

/// The length of a tick, which several checks need.
#[derive(Clone, Copy)]
pub(super) struct Step {
    pub(super) step_ns: u64,
    pub(super) substeps: u64,
}

/// The world that the robots are put into.
pub(super) struct World<'a> {
    pub(super) step: Step,
    pub(super) seed: u64,
    pub(super) surroundings: &'a Surroundings,
    pub(super) arena: &'a mut Arena,
    /// The movers and the pushed things at their starts.
    pub(super) bodies: &'a [(String, Body)],
    /// Gets the serial ports of each robot.
    pub(super) serial_ports: Vec<SerialPort>,
}
