//! A world whose ports programs have in simulated time.

use baudbot_sim::cable::Cable;
use baudbot_sim::{Intervention, InterventionError, SimTime, World};

use crate::driven_world::{BareWorld, LockstepWorld};

/// A [`LockstepWorld`] in which programs act within ticks.
pub trait PortWorld: LockstepWorld {
    /// See [`World::hear`].
    fn hear(&mut self, robot: usize, until: SimTime) -> Option<SimTime>;

    /// See [`World::take_arrived`].
    fn take_arrived(&mut self, robot: usize, cable: Cable, into: &mut Vec<u8>);

    /// See [`World::write_within`].
    fn write_within(&mut self, robot: usize, cable: Cable, at: SimTime, bytes: &[u8]) -> bool;

    /// See [`World::intervene`]; between two ticks.
    ///
    /// # Errors
    /// If it is not possible.
    fn change(&mut self, change: &Intervention) -> Result<(), InterventionError>;
}

impl PortWorld for BareWorld {
    fn hear(&mut self, robot: usize, until: SimTime) -> Option<SimTime> {
        World::hear(self, robot, until)
    }

    fn take_arrived(&mut self, robot: usize, cable: Cable, into: &mut Vec<u8>) {
        World::take_arrived(self, robot, cable, into);
    }

    fn write_within(&mut self, robot: usize, cable: Cable, at: SimTime, bytes: &[u8]) -> bool {
        World::write_within(self, robot, cable, at, bytes)
    }

    fn change(&mut self, change: &Intervention) -> Result<(), InterventionError> {
        self.intervene(change)
    }
}
