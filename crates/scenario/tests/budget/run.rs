//! Runs with brains that write when they may.

use baudbot_sim::firmware::Mode;
use baudbot_sim::link::Link;
use baudbot_sim::model::{Frequency, Writes};
use baudbot_sim::{Input, Scenario, SimTime, World};

use crate::common::{command, opening};

/// The measurements of a run.
pub(crate) struct Measured {
    pub(crate) seconds: f64,
    /// Messages that arrived, and commands that were understood.
    pub(crate) messages: u64,
    pub(crate) commands: u64,
    /// The instants at which messages of the microcontroller arrived, in seconds.
    pub(crate) arrivals: Vec<f64>,
    /// The instants at which each sensor was readable, in seconds.
    pub(crate) readable: Vec<Vec<f64>>,
    /// The true ages of its readings then, in nanoseconds.
    pub(crate) ages: Vec<Vec<u64>>,
    pub(crate) world: World,
}

/// The times at which a brain of a run writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Writer {
    /// The brain writes when a message has come, from a port too.
    OnMessage,
    /// In each turn.
    EveryTick,
    /// Twice in each turn.
    Twice,
    /// Every 0.1 s, whatever has come.
    Blind,
    /// In answer to a message, but not before its last command is off the cable.
    WhenFree,
    /// The brain never writes.
    Never,
}

impl Writer {
    pub(crate) const ALL: [Self; 6] =
        [Self::OnMessage, Self::EveryTick, Self::Twice, Self::Blind, Self::WhenFree, Self::Never];

    /// The writes that are stated to a budget.
    pub(crate) fn writes(self, step_ns: u64) -> Writes {
        let at_most = |per_s: f64| Writes::AtMost(Frequency::new(per_s).unwrap());
        match self {
            Self::OnMessage | Self::Never => Writes::OnMessage,
            Self::EveryTick => Writes::EveryTick,
            Self::Twice => at_most(2e9 / step_ns as f64),
            Self::Blind => at_most(10.0),
            Self::WhenFree => Writes::WhenFree,
        }
    }
}

/// A brain at work.
struct Hand {
    writer: Writer,
    /// The time of a command on the cable.
    command_ns: u64,
    wrote: Option<SimTime>,
    owes: bool,
}

impl Hand {
    /// The number of commands that it writes in its step.
    fn commands(&mut self, at: SimTime, speaks: bool) -> usize {
        let since = self.wrote.map(|wrote| at.since(wrote));
        let has_paused = |ns: u64| since.is_none_or(|since| since >= ns);
        let commands = match self.writer {
            Writer::OnMessage => usize::from(speaks),
            Writer::EveryTick => 1,
            Writer::Twice => 2,
            Writer::Blind => usize::from(has_paused(100_000_000)),
            Writer::WhenFree => {
                self.owes |= speaks;
                usize::from(has_paused(self.command_ns) && core::mem::take(&mut self.owes))
            }
            Writer::Never => 0,
        };
        if commands > 0 {
            self.wrote = Some(at);
        }
        commands
    }
}

/// Runs the only robot for a while; its brain answers each message, from a port too, and thinks as long as the scenario
/// states, in each step.
pub(crate) fn run(scenario: Scenario, seconds: f64) -> Measured {
    let thinking_ns = scenario.robots[0].thinking_ns;
    run_thinking(scenario, seconds, |_| thinking_ns)
}

/// The same with a brain that writes when it may.
pub(crate) fn run_writing(scenario: Scenario, seconds: f64, writer: Writer) -> Measured {
    let thinking_ns = scenario.robots[0].thinking_ns;
    run_as(scenario, seconds, writer, |_| thinking_ns)
}

/// The same, but its brain thinks so many nanoseconds in each tick.
pub(crate) fn run_thinking(
    scenario: Scenario,
    seconds: f64,
    thinking_ns: impl FnMut(u64) -> u64,
) -> Measured {
    run_as(scenario, seconds, Writer::OnMessage, thinking_ns)
}

fn run_as(
    scenario: Scenario,
    seconds: f64,
    writer: Writer,
    mut thinking_ns: impl FnMut(u64) -> u64,
) -> Measured {
    let step_ns = scenario.step_ns;
    let ticks = (seconds * 1e9 / step_ns as f64).ceil() as u64;
    let mut world = World::new(scenario.into());
    let bytes = command(world.robot(0).spec(), 0.0, 0.0);
    let link = &world.robot(0).spec().link;
    let command_ns = if matches!(link, Link::Uart(_)) { link.burst_ns(bytes.len() as u64) } else { 0 };
    let mut hand = Hand { writer, command_ns, wrote: None, owes: false };
    let opening = opening(world.robot(0).spec());
    let sensors = world.robot(0).spec().sensors.len();
    let mut arrivals = Vec::new();
    let mut readable = vec![Vec::new(); sensors];
    let mut ages = vec![Vec::new(); sensors];
    let mut last: Option<u64> = None;
    let bootloader_ns = world.robot(0).spec().processor.bootloader_ns;
    let mut has_started = false;
    for tick in 0..ticks {
        let turns = world.begin().to_vec();
        let Some(turn) = turns.first() else {
            world.finish(&[]);
            continue;
        };
        let robot = world.robot(0);
        let at = turn.at.as_seconds();
        let ports: u64 = (0..sensors).filter_map(|i| robot.port(i)).map(|port| port.messages).sum();
        let heard = robot.uplink().messages;
        if heard > arrivals.len() as u64 {
            arrivals.resize(heard as usize, at);
        }
        for (reading, times) in robot.readings().iter().zip(&mut readable) {
            times.extend(reading.readable.then_some(at));
        }
        let news = last.replace(heard + ports).is_some_and(|last| heard + ports > last);
        let first = heard + ports > 0 && tick == 0;
        // A polled robot sends when asked; a streaming one needs no first command, which would delay the answer to it.
        // Commands before the start of the firmware are lost.
        let is_first = !has_started && turn.at.as_ns() >= bootloader_ns;
        has_started |= is_first;
        let asks = is_first && world.robot(0).spec().firmware.mode == Mode::Poll;
        let speaks = asks || news || first;
        let said = if is_first { &opening[..] } else { &[] };
        let at = turn.at + thinking_ns(tick);
        let commands = hand.commands(turn.at, speaks);
        // An answer to a port that comes behind the start is received, and no first command is needed.
        has_started |= commands > 0 && at.as_ns() >= bootloader_ns;
        let first = if commands > 0 { &bytes[..] } else { said };
        let inputs = [first].into_iter().chain((1..commands).map(|_| &bytes[..]));
        let inputs: Vec<_> = inputs.map(|bytes| Input { robot: 0, at, bytes }).collect();
        let before: Vec<_> = world.robot(0).sensors().map(|sensor| sensor.freshness.clone()).collect();
        world.finish(&inputs);
        for (i, sensor) in world.robot(0).sensors().enumerate() {
            let is_aged = sensor.freshness.ages.count() > before[i].ages.count();
            ages[i].extend(is_aged.then(|| sensor.freshness.ages.sum_ns() - before[i].ages.sum_ns()));
        }
    }
    let (messages, commands) = (world.robot(0).uplink().messages, world.robot(0).downlink().messages);
    Measured {
        seconds: SimTime::as_seconds(world.time()),
        messages,
        commands,
        arrivals,
        readable,
        ages,
        world,
    }
}

impl Measured {
    /// Messages a second, from the first that arrived to the last.
    pub(crate) fn messages_per_s(&self) -> f64 {
        per_s(&self.arrivals)
    }
}

/// The rate a second, from the first of these instants to the last.
pub(crate) fn per_s(at: &[f64]) -> f64 {
    match at {
        [first, .., last] => (at.len() - 1) as f64 / (last - first),
        _ => 0.0,
    }
}
