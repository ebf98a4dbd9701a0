//! The pins of a robot's chip: the signals that are wanted, and those that have been seen.

use baudbot_plot::timing::Shot;
use baudbot_sim::chip::{ChipSpec, Line, Net, Scope, Shown};
use baudbot_sim::model::RobotSpec;

use crate::chips;
use crate::error::Refused;

/// The record of each signal since an instant, and of the time before it the part that holds there.
#[derive(Debug, Default)]
pub(super) struct Pins {
    pub(super) shots: Vec<Shot>,
}

impl Pins {
    pub(super) fn new(robot: &RobotSpec) -> Self {
        let signals = robot.chip.iter().flat_map(|chip| chip.signals());
        let shots = signals.map(|signal| Shot { signal, shown: Vec::new() }).collect();
        Self { shots }
    }

    /// Takes what is new on the pins, and forgets what is not seen from an instant on.
    pub(super) fn take(&mut self, fresh: impl Iterator<Item = (usize, Shown)>, from_ns: u64) {
        for (place, shown) in fresh {
            let Some(shot) = self.shots.get_mut(place) else { continue };
            if !shot.shown.last_mut().is_some_and(|last| last.join(&shown)) {
                shot.shown.push(shown);
            }
        }
        for shot in &mut self.shots {
            let over = shot.shown.partition_point(|shown| shown.at_ns() <= from_ns);
            shot.shown.drain(..over.saturating_sub(KEPT));
        }
    }

    /// The number of entries.
    pub(super) fn count(&self) -> usize {
        self.shots.iter().map(|shot| shot.shown.len()).sum()
    }
}

/// The chip of a robot, and which of its wires `--pins` names.
pub(super) fn chosen(robot: &RobotSpec, pins: &[String]) -> anyhow::Result<Option<Vec<Net>>> {
    if pins.is_empty() {
        return Ok(None);
    }
    let Some(chip) = &robot.chip else {
        return Err(chips::PINS.without_program(&robot.name));
    };
    let nets = pins.iter().map(|name| net(robot, chip, name)).collect::<anyhow::Result<_>>()?;
    Ok(Some(nets))
}

fn net(robot: &RobotSpec, chip: &ChipSpec, name: &str) -> anyhow::Result<Net> {
    let signals = chip.signals();
    let is_there = |net: &Net| {
        signals.iter().any(|signal| match signal.line {
            Line::Wire(wire) => wire == *net,
            Line::Adc(channel) => net.pin().is_none() && net.adc_channel() == Some(channel),
            Line::MainLoop | Line::Sent | Line::Received => false,
        })
    };
    let unknown = || {
        let wires = signals.iter().filter(|signal| matches!(signal.line, Line::Wire(_)));
        let names: Vec<_> = wires.map(baudbot_sim::chip::Signal::name).collect();
        Refused::error(format!(
            "--pins: the chip of `{}` has no pin `{name}`; there are: {}",
            robot.name,
            names.join(", ")
        ))
    };
    Net::by_name(name.trim()).filter(is_there).ok_or_else(unknown)
}

/// A scope on a robot's chip, if it has one.
pub(super) fn scope(robot: &RobotSpec, finest_ns: u64) -> Option<Scope> {
    robot.chip.as_ref().map(|chip| Scope::new(chip, finest_ns))
}

/// The number of entries before a window that are kept: a pulse may be reported later than a level that follows it.
const KEPT: usize = 2;
