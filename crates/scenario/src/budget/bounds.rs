//! The least and the greatest duration of each part of a cycle, whatever happens.
//!
//! Queues feed each other: a late frame makes a late command, which makes the microcontroller late. So the bounds are
//! computed again and again from one another, from the bottom up, until they stay as they are; then they hold by
//! induction over time.
//!
//! **The microcontroller** does what fell due first. Before a task that waits it does what fell due earlier, which is
//! the backlog of a queue ([`curve`](super::curve)); and, however loaded it is, no more than what is under way and each
//! other task once, because what has been served falls due later than what waits. A brain on board may think before
//! each of them.

use alloc::vec;
use alloc::vec::Vec;

use super::curve::Curve;
use super::pattern::Pattern;
use super::plan::{Plan, Range, turnaround_ns};
use super::wire;
use baudbot_sim::firmware::Mode;
use baudbot_sim::model::Writes;

/// The bounds of a robot's cycle, in nanoseconds; `None` where there is no end.
#[derive(Clone, Debug)]
pub(super) struct Bounds {
    pub(super) pattern: Pattern,
    /// Whether the pattern holds: nothing is late by a period.
    pub(super) in_step: bool,
    /// Whether all reads are done: none is late by its period.
    pub(super) reads_all: bool,
    pub(super) framing: Range,
    pub(super) wire_up: Range,
    /// Most work of the microcontroller that is there at an instant, what is looked at included.
    pub(super) backlog: Option<u64>,
    /// The greatest lateness at which the last byte of a command is taken.
    pub(super) obeyed_late: Option<u64>,
    /// Besides the wire.
    pub(super) wait_up: Option<u64>,
    pub(super) step: Option<u64>,
    pub(super) thinking: Option<u64>,
    pub(super) down: Option<u64>,
    /// Whether a message comes only when the brain has answered the one before.
    pub(super) takes_turns: bool,
    /// The reason why something has no end.
    pub(super) reason: Option<&'static str>,
}

/// The present estimate of quantities that depend on each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Estimate {
    pub(super) backlog: Option<u64>,
    pub(super) wait_up: Option<u64>,
    pub(super) down: Option<u64>,
}

/// The quantities that stay the same meanwhile.
pub(super) struct Fixed<'a> {
    pub(super) plan: &'a Plan<'a>,
    pub(super) bytes: Range,
    pub(super) framing: Range,
}

/// Rounds until things are taken to have no end.
pub(super) const MOST_ROUNDS: usize = 100;

impl Bounds {
    pub(super) fn of(plan: &Plan<'_>) -> Self {
        let nominal = Pattern::of(plan);
        let unknown = Pattern::unknown(plan);
        let bytes = nominal.as_ref().map_or(unknown.bytes, |nominal| nominal.bytes);
        let bounds = Self::with(plan, nominal.clone().unwrap_or_else(|| unknown.clone()), bytes);
        let shortest = plan.on_wire().iter().map(|sensor| sensor.schedule.period_ns());
        let shortest = shortest.chain(frame_period_ns(plan)).min().unwrap_or(u64::MAX);
        if nominal.is_some() && bounds.backlog.is_some_and(|ns| ns < shortest) {
            return Self { in_step: true, ..bounds };
        }
        Self::with(plan, unknown.clone(), unknown.bytes)
    }

    fn with(plan: &Plan<'_>, pattern: Pattern, bytes: Range) -> Self {
        let link = &plan.spec.link;
        let exact = |bytes: u64| plan.framing_ns(Range { least: bytes, most: bytes });
        // Framing is counted for the longest that a frame can be.
        let framing = Range { least: exact(bytes.least), most: exact(bytes.most) };
        let fixed = Fixed { plan, bytes, framing };
        let estimate = fixed.settle();
        let Estimate { backlog, wait_up, down } = estimate;
        Self {
            pattern,
            in_step: false,
            reads_all: estimate
                .backlog
                .is_some_and(|ns| plan.on_wire().iter().all(|sensor| ns < sensor.schedule.period_ns())),
            framing,
            wire_up: Range { least: wire::least_ns(link, bytes.least), most: link.burst_ns(bytes.most) },
            backlog,
            obeyed_late: fixed.obeyed_late(&estimate),
            wait_up,
            step: Some(fixed.step_ns(&estimate)),
            thinking: Some(
                plan.thinking().most_ns
                    + if plan.spec.is_onboard() { longest_task_ns(plan, framing.most) } else { 0 },
            ),
            down,
            takes_turns: fixed.takes_turns(),
            reason: fixed.reason(&estimate),
        }
    }

    /// The greatest lateness at which a task is served that takes so long itself.
    pub(super) fn late_ns(&self, own_ns: u64) -> Option<u64> {
        self.backlog.map(|backlog| backlog.saturating_sub(own_ns))
    }

    /// The time from the beginning of a read to the beginning of the framing of the message that it is in.
    pub(super) fn wait_for_frame(&self, plan: &Plan<'_>, i: usize) -> (u64, Option<u64>) {
        let sensor = &plan.on_wire()[i];
        let read = plan.read_ns(sensor);
        let late = self.late_ns(read.most);
        let frame_late = self.late_ns(self.framing.most);
        let slot = self.pattern.slots[i];
        if self.in_step {
            let least = slot.wait_ns.least.saturating_sub(late.unwrap_or(u64::MAX));
            return (read.least.max(least), frame_late.map(|late| slot.wait_ns.most + late));
        }
        let between_reads = late.map(|late| sensor.schedule.period_ns() + late);
        let most = match plan.spec.firmware.mode {
            // A bare message repeats what is not new.
            Mode::Stream(frame) if !plan.repeats() => {
                // Before the first message there is none that a sample could have gone with.
                let before = frame.phase_ns().saturating_sub(sensor.schedule.phase_ns());
                let between_frames = frame_late.map(|late| frame.period_ns().max(before) + late);
                between_reads.zip(between_frames).map(|(reads, frames)| reads.min(frames))
            }
            Mode::Stream(_) | Mode::Poll => between_reads,
        };
        (read.least, most)
    }
}

pub(super) fn frame_period_ns(plan: &Plan<'_>) -> Option<u64> {
    match plan.spec.firmware.mode {
        Mode::Stream(frame) => Some(frame.period_ns()),
        Mode::Poll => None,
    }
}

pub(super) fn longest_task_ns(plan: &Plan<'_>, framing_ns: u64) -> u64 {
    let reads = plan.on_wire().iter().map(|sensor| plan.read_ns(sensor).most);
    reads.chain([framing_ns, plan.command_ns()]).max().unwrap_or(0)
}

impl Fixed<'_> {
    fn settle(&self) -> Estimate {
        let mut estimate = Estimate { backlog: Some(0), wait_up: Some(0), down: Some(0) };
        for _ in 0..MOST_ROUNDS {
            let next = Estimate {
                backlog: self.backlog(&estimate),
                wait_up: self.wait_up(&estimate),
                down: self.down(&estimate),
            };
            if next == estimate {
                return estimate;
            }
            estimate = next;
        }
        Estimate { backlog: None, wait_up: None, down: None }
    }

    fn reason(&self, estimate: &Estimate) -> Option<&'static str> {
        if self.plan.acknowledgement_bytes() > 0 {
            return Some("the acknowledgement of a command may delay readings");
        }
        match estimate {
            Estimate { down: None, .. } if wire::radio(&self.plan.spec.link).is_none() => {
                Some("commands come faster than the cable can carry them")
            }
            Estimate { wait_up: None, .. } | Estimate { down: None, .. } => {
                Some("the cable or the radio cannot guarantee the rate of messages")
            }
            Estimate { backlog: None, .. } => Some("the microcontroller is overloaded"),
            _ => None,
        }
    }

    /// The curves of commands, in all the ways in which they are known; each is true.
    pub(super) fn commands(&self, estimate: &Estimate) -> Vec<Vec<Curve>> {
        let Plan { spec, step_ns, .. } = *self.plan;
        let thinking = self.plan.thinking();
        let in_a_turn = self.plan.commands_in_a_turn() as usize;
        // On board a brain waits for the processor before it thinks.
        let waits = thinking.width_ns() + if spec.is_onboard() { longest_task_ns(self.plan, 0) } else { 0 };
        // No more than one step a tick: the last instant of one and the first of the next are near.
        let each_tick = Curve::every(step_ns).late_by(step_ns + waits);
        let mut ways = vec![vec![each_tick; in_a_turn]];
        if thinking.least_ns >= step_ns {
            ways.push(vec![Curve::every(thinking.least_ns); in_a_turn]);
        }
        match self.plan.writes() {
            Writes::OnMessage => ways.extend(self.answers(estimate)),
            Writes::WhenFree | Writes::AtMost(_) if self.plan.pause_ns() > 0 => {
                ways.push(vec![Curve::every(self.plan.pause_ns()).late_by(waits)]);
            }
            Writes::WhenFree | Writes::EveryTick | Writes::AtMost(_) => {}
        }
        ways
    }

    /// The curves of messages that a brain answers, if they are known.
    fn answers(&self, estimate: &Estimate) -> Option<Vec<Curve>> {
        let Plan { spec, noise, .. } = *self.plan;
        let Mode::Stream(frame) = spec.firmware.mode else { return None };
        let (late, wait) = estimate.backlog.zip(estimate.wait_up)?;
        let wire = spec.link.burst_ns(self.bytes.most) - wire::least_ns(&spec.link, self.bytes.least);
        let thinking = self.plan.thinking().width_ns();
        let parts = [self.framing.width(), wire, wait, self.step_ns(estimate), thinking];
        let late = parts.into_iter().fold(late, u64::saturating_add);
        let mut curves = vec![Curve::every(frame.period_ns()).late_by(late)];
        for (_, sensor, clock, link) in self.plan.ports() {
            let (spread, jitter) = if noise { (clock.spread_ns, clock.jitter_ns) } else { (0, 0) };
            let bytes = wire::port_bytes(sensor);
            let wire = link.burst_ns(bytes.most) - wire::least_ns(link, bytes.least) + wire::frame_ns(link);
            let late = jitter + wire + wire::hold_up_ns(link).most + self.step_ns(estimate) + thinking;
            curves.push(Curve::every(clock.period_ns.saturating_sub(spread).max(1)).late_by(late));
        }
        Some(curves)
    }

    /// The longest time for which a message waits for the brain's step: until the next tick begins, or the brain is
    /// done. If no two messages can come in one tick, only a brain that thinks keeps them waiting.
    fn step_ns(&self, estimate: &Estimate) -> u64 {
        let Plan { spec, step_ns, .. } = *self.plan;
        let task_ns = if spec.is_onboard() { longest_task_ns(self.plan, 0) } else { 0 };
        let thinking = self.plan.thinking();
        let busy = thinking.most_ns + task_ns;
        let link = &spec.link;
        let wire_least = wire::least_ns(link, self.bytes.least);
        let least = self.framing.least + wire_least + wire::hold_up_ns(link).least;
        match spec.firmware.mode {
            _ if self.plan.has_ports() => step_ns.max(busy),
            Mode::Poll if !self.takes_turns() => step_ns.max(busy),
            Mode::Poll => {
                let command = wire::least_ns(link, self.plan.command_bytes().least);
                let robot = self.plan.least_obeying_ns();
                let down = thinking.least_ns + wire::hold_down_ns(link).least + command + robot;
                step_ns.saturating_sub(least + down).max(busy)
            }
            Mode::Stream(frame) => {
                let Some((late, wait)) = estimate.backlog.zip(estimate.wait_up) else {
                    return step_ns.max(busy);
                };
                let most =
                    [link.burst_ns(self.bytes.most), wait, busy].into_iter().fold(late, u64::saturating_add);
                let tick = |ns: u64| frame.phase_ns().saturating_add(ns) / step_ns;
                let in_place = frame.period_ns() % step_ns == 0 && tick(least) == tick(most);
                let apart = frame.period_ns() >= step_ns.saturating_add(most.saturating_sub(least));
                if in_place || apart { busy } else { step_ns.max(busy) }
            }
        }
    }

    /// Whether a command that answers a message of a stream has always arrived before the next message is due, and the wire is
    /// free again. Then nothing of the one is in the way of the other.
    pub(super) fn is_over_in_time(&self, estimate: &Estimate) -> bool {
        let Plan { spec, .. } = self.plan;
        let Mode::Stream(frame) = spec.firmware.mode else { return false };
        let is_asked =
            self.plan.writes() == Writes::OnMessage && !self.plan.has_ports() && !spec.is_onboard();
        let Estimate { backlog: Some(framed), wait_up: Some(wait), down: Some(down) } = *estimate else {
            return false;
        };
        let turn = turnaround_ns(&spec.link).unwrap_or(0);
        let thinking = self.plan.thinking().most_ns;
        let parts = [spec.link.burst_ns(self.bytes.most), wait, self.step_ns(estimate), thinking, down, turn];
        is_asked && parts.into_iter().fold(framed, u64::saturating_add) < frame.period_ns()
    }

    /// The least time from the instant at which a message is due to the arrival of the command that answers it.
    pub(super) fn least_exchange_ns(&self) -> u64 {
        let link = &self.plan.spec.link;
        let up = wire::least_ns(link, self.bytes.least) + wire::hold_up_ns(link).least;
        let down = wire::least_ns(link, self.plan.command_bytes().least) + wire::hold_down_ns(link).least;
        self.framing.least + up + self.plan.thinking().least_ns + down
    }

    /// The brain answers, and only then is there something to answer again.
    pub(super) fn takes_turns(&self) -> bool {
        self.plan.polls() && !self.plan.has_ports() && self.plan.writes() == Writes::OnMessage
    }
}
