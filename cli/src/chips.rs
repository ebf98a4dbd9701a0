//! Robots whose microcontrollers run a program of the user's own, as options name them.

use baudbot_sim::model::RobotSpec;

use crate::args::ChipOutput;
use crate::error::Refused;

/// An option that is about the chips of robots.
pub(crate) struct ChipOption {
    name: &'static str,
    /// The thing that a robot without a program lacks.
    nothing: &'static str,
}

/// The record of a logic analyser on the pins.
pub(crate) const VCD: ChipOption = ChipOption { name: "--vcd", nothing: "it has no pins to record" };

/// The same in a diagram.
pub(crate) const PINS: ChipOption = ChipOption { name: "--pins", ..VCD };

/// The bytes that the program sends.
pub(crate) const SERIAL: ChipOption =
    ChipOption { name: "--serial", nothing: "its cable carries only messages to and from a brain" };

/// The places of the robots with a program.
pub(crate) fn all(specs: &[RobotSpec]) -> impl Iterator<Item = usize> {
    specs.iter().enumerate().filter(|(_, spec)| spec.chip.is_some()).map(|(robot, _)| robot)
}

impl ChipOption {
    /// The robots that are named, in the order of the arguments: each must have a chip with a program.
    pub(crate) fn robots(&self, outputs: &[ChipOutput], specs: &[RobotSpec]) -> anyhow::Result<Vec<usize>> {
        outputs.iter().map(|output| self.robot(&output.robot, specs)).collect()
    }

    fn robot(&self, robot: &str, specs: &[RobotSpec]) -> anyhow::Result<usize> {
        let name = self.name;
        let Some(place) = specs.iter().position(|spec| spec.name == *robot) else {
            let names = specs.iter().map(|spec| format!("`{}`", spec.name)).collect::<Vec<_>>().join(", ");
            return Err(Refused::error(format!("{name}: there is no robot `{robot}`; there are: {names}")));
        };
        if specs[place].chip.is_none() {
            return Err(self.without_program(robot));
        }
        Ok(place)
    }

    /// The error for a robot without a program.
    pub(crate) fn without_program(&self, robot: &str) -> anyhow::Error {
        let Self { name, nothing } = self;
        Refused::error(format!(
            "{name}: `{robot}` has no program on its microcontroller, so {nothing}; give it one \
             (`microcontroller.program`, docs/reference/firmware.md)"
        ))
    }
}
