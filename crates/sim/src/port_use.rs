//! Who reads a robot's serial ports.

use serde::{Deserialize, Serialize};

/// Who reads the laptop's serial ports at a robot's cables.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum PortUse {
    /// A brain, which steps once a tick.
    #[default]
    Closed,
    /// A program that follows the clock, and reads each byte at its own instant. What comes during a tick can be known when it
    /// begins, so the brain's step is at the end of each tick.
    Open,
    /// A program in simulated time: it acts whenever a byte has come and writes at that instant, within the tick
    /// ([`World::hear`](crate::World::hear), [`World::write_within`](crate::World::write_within)). There are no steps.
    Simulated,
}
