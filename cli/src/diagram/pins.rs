//! What is on the pins of a robot's chip: which of it is wanted, and what has been seen.

use baudbot_plot::quantity::handy;
use baudbot_plot::timing::{Shot, ms};
use baudbot_sim::chip::{ChipSpec, Line, Net, Shown, Stretch};
use baudbot_sim::chip::{Level, Scope};
use baudbot_sim::model::RobotSpec;

use crate::chips;
use crate::error::Refused;

/// What has been seen of each signal since an instant, and of the time before it what holds there.
#[derive(Debug, Default)]
pub(super) struct Pins {
    pub(super) shots: Vec<Shot>,
    /// The first thing that the program did, once it is known.
    pub(super) begins: Option<Begins>,
}

/// The program's first deed.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Begins {
    pub(super) at_ns: u64,
    /// What it does then, as the end of a sentence.
    pub(super) what: String,
}

impl Pins {
    pub(super) fn new(robot: &RobotSpec) -> Self {
        let signals = robot.chip.iter().flat_map(|chip| chip.signals());
        let shots = signals.map(|signal| Shot { signal, shown: Vec::new() }).collect();
        Self { shots, begins: None }
    }

    /// Takes what is new on the pins of a chip, and forgets what is not seen from an instant on.
    pub(super) fn take(&mut self, chip: &ChipSpec, fresh: Vec<(usize, Shown)>, from_ns: u64) {
        for (place, shown) in fresh {
            let Some(shot) = self.shots.get_mut(place) else { continue };
            if let (Some(Shown::Stretch(Stretch::Pulses(last))), Shown::Stretch(Stretch::Pulses(next))) =
                (shot.shown.last_mut(), &shown)
                && last.join(next)
            {
                continue;
            }
            shot.shown.push(shown);
            if let Some(what) = deed(chip, shot, &shown)
                && self.begins.as_ref().is_none_or(|begins| shown.at_ns() < begins.at_ns)
            {
                self.begins = Some(Begins { at_ns: shown.at_ns(), what });
            }
        }
        for shot in &mut self.shots {
            let over = shot.shown.partition_point(|shown| shown.at_ns() <= from_ns);
            shot.shown.drain(..over.saturating_sub(KEPT));
        }
    }

    /// How much is kept.
    pub(super) fn count(&self) -> usize {
        self.shots.iter().map(|shot| shot.shown.len()).sum()
    }
}

/// What the program does there, if it sends something or turns a wheel.
fn deed(chip: &ChipSpec, shot: &Shot, shown: &Shown) -> Option<String> {
    match (shot.signal.line, shown) {
        (Line::Sent, Shown::Number { .. }) => Some("sends its first character".to_owned()),
        (Line::Wire(net), Shown::Stretch(Stretch::Pulses(_) | Stretch::Level { level: Level::High, .. })) => {
            chip.turns_a_wheel(net).then(|| format!("first drives {}", shot.signal.label()))
        }
        (Line::Wire(_) | Line::Adc(_) | Line::Sent | Line::Received, _) => None,
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
            Line::Sent | Line::Received => false,
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

/// What a diagram without `--at` shows of such a robot.
pub(super) fn place_in_words(begins: Option<&Begins>) -> String {
    match begins {
        Some(Begins { at_ns, what }) => format!("At {} ms the program {what}.", ms(*at_ns, 3)),
        None => format!(
            "Within {} s the program sends no character and drives no wheel: this is the start.",
            handy(PATIENCE_NS as f64 * 1e-9)
        ),
    }
}

/// So long it is waited for something that the program does, in nanoseconds.
pub(super) const PATIENCE_NS: u64 = 10_000_000_000;

/// Of the time before a window so much is kept: pulses may be told later than a level that follows.
const KEPT: usize = 2;
