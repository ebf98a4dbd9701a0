//! The robots' ports: what the server writes to them for brains.

use baudbot_sim::model::PortUse;
use baudbot_sim::{Intervention, RobotView, SimTime, World};

use super::WorldActor;
use super::final_command::FinalCommand;
use crate::endpoint::{Sender, Sent};
use crate::log::event;
use crate::recording::Input;

/// The ports of all robots, by robot.
pub(super) struct Ports {
    /// The senders of messages for brains. Their messages are on the wire, so they go back in time with the world.
    pub(super) senders: Vec<Sender>,
    /// The senders as they were when the tick began, to which a snapshot goes back.
    pub(super) senders_at_begin: Vec<Sender>,
    /// The messages that were written in this tick.
    pub(super) inputs: Vec<Pending>,
    /// The same for sensors on their own cables.
    pub(super) to_devices: Vec<ToDevice>,
    /// What programs in simulated time have written in this tick, which is on its way already.
    pub(super) within: Vec<Input>,
    /// Robots whose microcontroller is to be reset when the tick is over, as a program has opened their port.
    pub(super) to_reset: Vec<usize>,
    /// The messages that are written when a brain is gone, if the brain wants that.
    pub(super) final_commands: Vec<Option<FinalCommand>>,
    /// Robots whose brain a server has lost by ending. It comes back, and goes on where it was.
    pub(super) resumed: Vec<bool>,
}

/// The output of a brain in this tick.
pub(super) struct Pending {
    pub(super) robot: usize,
    pub(super) at: SimTime,
    pub(super) sent: Sent,
    /// The tick whose Turn it answers, if that is known.
    pub(super) tick: Option<u64>,
}

/// The output of a brain in this tick to a sensor on its own cable.
pub(super) struct ToDevice {
    pub(super) robot: usize,
    pub(super) sensor: usize,
    pub(super) at: SimTime,
    pub(super) bytes: Vec<u8>,
}

impl Ports {
    /// The ports of a world whose robots have no brains.
    pub(super) fn new(world: &World) -> Self {
        let senders = senders(world);
        Self {
            senders_at_begin: senders.clone(),
            inputs: Vec::new(),
            within: Vec::new(),
            to_devices: Vec::new(),
            to_reset: Vec::new(),
            final_commands: vec![None; senders.len()],
            resumed: vec![false; senders.len()],
            senders,
        }
    }

    /// A brain has got a robot, whose port it writes to by this sender; unless it comes back after its server was gone.
    pub(super) fn attach(&mut self, robot: usize, new: Sender) {
        let comes_back = std::mem::take(&mut self.resumed[robot]);
        if !comes_back || self.senders[robot].is_raw() != new.is_raw() {
            self.senders[robot] = new;
        }
        // The brain has written nothing yet.
        self.senders_at_begin[robot].clone_from(&self.senders[robot]);
    }

    /// A tick has begun.
    pub(super) fn note_begin(&mut self) {
        self.senders_at_begin.clone_from(&self.senders);
    }
}

/// The senders of all robots of a world that has just been made.
pub(super) fn senders(world: &World) -> Vec<Sender> {
    world.robots().map(|robot| sender(&robot, false)).collect()
}

/// A robot's sender as a new brain finds it, of bytes or of messages: the actuators go on with the signals that they have.
pub(super) fn sender(robot: &RobotView<'_>, raw: bool) -> Sender {
    Sender::new(robot.actuators().iter().map(|actuator| actuator.signal), raw)
}

impl Ports {
    /// The world has gone back to its beginning, with the same brains.
    pub(super) fn reset(&mut self, world: &World) {
        let robots = world.robots().zip(&self.senders);
        self.senders = robots.map(|(robot, old)| sender(&robot, old.is_raw())).collect();
    }
}

impl WorldActor {
    /// Prepares the ports for a tick: the world gets the serial ports in use, and the boards that their programs have
    /// reset.
    pub(super) fn set_ports(&mut self) {
        if self.world.is_begun() {
            return;
        }
        let mut changes = Vec::new();
        let robots = || self.world.scenario().robots.iter();
        for (spec, open) in robots().zip(self.sessions.serial_ports().unwrap_or_default()) {
            let port_use = if open { PortUse::Open } else { PortUse::Closed };
            if spec.port_use != port_use {
                changes.push(Intervention::OpenPort { robot: spec.name.clone(), port_use });
            }
        }
        for robot in std::mem::take(&mut self.ports.to_reset) {
            changes
                .push(Intervention::ResetBoard { robot: self.world.scenario().robots[robot].name.clone() });
        }
        for change in changes {
            match self.world.intervene(&change) {
                Ok(()) => self.record_change(&change),
                Err(error) => event!(self, warn, ?change, %error, "a serial port cannot do this"),
            }
        }
    }
}
