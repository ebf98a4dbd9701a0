//! How long each part of a cycle takes at least and at most, whatever happens.
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

use super::curve::{Curve, Source, queue};
use super::pattern::Pattern;
use super::plan::{Plan, Range, turnaround_ns};
use super::wire;
use crate::firmware::Mode;
use crate::link::Link;

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
    /// Besides the wire.
    pub(super) wait_up: Option<u64>,
    pub(super) step: Option<u64>,
    pub(super) thinking: Option<u64>,
    pub(super) down: Option<u64>,
    /// Why something has no end.
    pub(super) reason: Option<&'static str>,
}

/// What is known so far of what depends on itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Estimate {
    backlog: Option<u64>,
    wait_up: Option<u64>,
    down: Option<u64>,
}

/// What stays the same meanwhile.
struct Fixed<'a> {
    plan: &'a Plan<'a>,
    bytes: Range,
    framing: Range,
}

/// Rounds until things are taken to have no end.
const MOST_ROUNDS: usize = 100;

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
            wait_up,
            step: Some(fixed.step_ns(&estimate)),
            thinking: Some(
                plan.spec.thinking_ns
                    + if plan.spec.is_onboard() { longest_task_ns(plan, framing.most) } else { 0 },
            ),
            down,
            reason: fixed.reason(&estimate),
        }
    }

    /// How late something is served at most that takes so long itself.
    pub(super) fn late_ns(&self, own_ns: u64) -> Option<u64> {
        self.backlog.map(|backlog| backlog.saturating_sub(own_ns))
    }

    /// From the beginning of a read to the beginning of the framing of the message that it is in.
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
            Mode::Stream(frame) if !plan.is_bare() => {
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

fn frame_period_ns(plan: &Plan<'_>) -> Option<u64> {
    match plan.spec.firmware.mode {
        Mode::Stream(frame) => Some(frame.period_ns()),
        Mode::Poll => None,
    }
}

fn longest_task_ns(plan: &Plan<'_>, framing_ns: u64) -> u64 {
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
        match estimate {
            Estimate { down: None, .. } if wire::radio(&self.plan.spec.link).is_none() => {
                Some("commands come faster than the way down can carry them")
            }
            Estimate { wait_up: None, .. } | Estimate { down: None, .. } => {
                Some("the cable or the radio cannot promise to keep up")
            }
            Estimate { backlog: None, .. } => Some("the microcontroller has more to do than time"),
            _ => None,
        }
    }

    /// How often commands are written, in all the ways in which it is known; each is true.
    fn commands(&self, estimate: &Estimate) -> Vec<Vec<Curve>> {
        let Plan { spec, step_ns, noise, .. } = *self.plan;
        // No more than one step a tick: the last instant of one and the first of the next are near.
        let mut ways = vec![vec![Curve::every(step_ns).late_by(step_ns)]];
        if spec.thinking_ns >= step_ns {
            ways.push(vec![Curve::every(spec.thinking_ns)]);
        }
        let (Mode::Stream(frame), Some(late), Some(wait)) =
            (spec.firmware.mode, estimate.backlog, estimate.wait_up)
        else {
            return ways;
        };
        let wire = spec.link.burst_ns(self.bytes.most) - wire::least_ns(&spec.link, self.bytes.least);
        let late = late + self.framing.width() + wire + wait + self.step_ns(estimate);
        let mut curves = vec![Curve::every(frame.period_ns()).late_by(late)];
        for (_, sensor, clock, link) in self.plan.ports() {
            let (spread, jitter) = if noise { (clock.spread_ns, clock.jitter_ns) } else { (0, 0) };
            let bytes = wire::port_bytes(sensor);
            let wire = link.burst_ns(bytes.most) - wire::least_ns(link, bytes.least) + wire::frame_ns(link);
            let late = jitter + wire + wire::hold_up_ns(link).most + self.step_ns(estimate);
            curves.push(Curve::every(clock.period_ns.saturating_sub(spread).max(1)).late_by(late));
        }
        ways.push(curves);
        ways
    }

    /// How long a message waits at most for the brain's step: until the next tick begins, or the brain is done. If no
    /// two messages can come in one tick, only a brain that thinks keeps them waiting.
    fn step_ns(&self, estimate: &Estimate) -> u64 {
        let Plan { spec, step_ns, .. } = *self.plan;
        let task_ns = if spec.is_onboard() { longest_task_ns(self.plan, 0) } else { 0 };
        let busy = spec.thinking_ns + task_ns;
        let link = &spec.link;
        let wire_least = wire::least_ns(link, self.bytes.least);
        let least = self.framing.least + wire_least + wire::hold_up_ns(link).least;
        match spec.firmware.mode {
            _ if self.plan.has_ports() => step_ns.max(busy),
            Mode::Poll => {
                let command = wire::least_ns(link, self.plan.command_bytes().least);
                let robot = super::cycle::least_obeying_ns(self.plan);
                let down = spec.thinking_ns + wire::hold_down_ns(link).least + command + robot;
                step_ns.saturating_sub(least + down).max(busy)
            }
            Mode::Stream(frame) => {
                let Some((late, wait)) = estimate.backlog.zip(estimate.wait_up) else {
                    return step_ns.max(busy);
                };
                let most = late + link.burst_ns(self.bytes.most) + wait + busy;
                let tick = |ns: u64| (frame.phase_ns() + ns) / step_ns;
                let in_place = frame.period_ns() % step_ns == 0 && tick(least) == tick(most);
                let apart = frame.period_ns() >= step_ns + most.saturating_sub(least);
                if in_place || apart { busy } else { step_ns.max(busy) }
            }
        }
    }

    /// The brain answers, and only then is there something to answer again.
    fn takes_turns(&self) -> bool {
        self.plan.polls() && !self.plan.has_ports()
    }

    fn backlog(&self, estimate: &Estimate) -> Option<u64> {
        let plan = self.plan;
        let reads: Vec<u64> = plan.on_wire().iter().map(|sensor| plan.read_ns(sensor).most).collect();
        let frame_ns = self.framing.most.checked_add(self.blocked_ns(estimate.wait_up?)?)?;
        if plan.spec.is_onboard() && plan.spec.thinking_ns > 0 {
            return self.backlog_on_board(&reads);
        }
        let byte_ns = plan.spec.link.burst_ns(plan.command_bytes().most);
        let late = estimate.down?.checked_add(byte_ns)?;
        let ways = self.commands(estimate).into_iter().map(|way| {
            let curves = way.into_iter().map(|curve| curve.late_by(late));
            curves.collect::<Vec<_>>()
        });
        ways.filter_map(|way| {
            let in_order = self.in_order(&reads, frame_ns, &way, estimate.backlog?);
            let once = self.once_each(&reads, frame_ns, &way);
            [in_order, once].into_iter().flatten().min()
        })
        .min()
    }

    /// What fell due earlier comes first.
    fn in_order(&self, reads: &[u64], frame_ns: u64, commands: &[Curve], late: u64) -> Option<u64> {
        let source = |curve, work_ns| Source { curve, work_ns };
        let sensors = self.plan.on_wire().iter().zip(reads);
        let mut sources: Vec<_> =
            sensors.map(|(sensor, &ns)| source(Curve::every(sensor.schedule.period_ns()), ns)).collect();
        let command_ns = self.plan.command_ns();
        sources.extend(commands.iter().map(|&curve| source(curve, command_ns)));
        match self.plan.spec.firmware.mode {
            Mode::Stream(frame) => sources.push(source(Curve::every(frame.period_ns()), frame_ns)),
            Mode::Poll => sources.extend(commands.iter().map(|&curve| source(curve.late_by(late), frame_ns))),
        }
        queue(&sources).map(|queue| queue.backlog_ns)
    }

    /// What is under way, and each other task once; commands as many as can have come meanwhile.
    fn once_each(&self, reads: &[u64], frame_ns: u64, commands: &[Curve]) -> Option<u64> {
        let tasks = reads.iter().sum::<u64>() + frame_ns;
        let command_ns = self.plan.command_ns();
        let longest = reads.iter().copied().chain([frame_ns, command_ns]).max()?;
        let base = tasks.checked_add(longest)?;
        if self.takes_turns() {
            return base.checked_add(command_ns);
        }
        let mut backlog = base;
        for _ in 0..MOST_ROUNDS {
            let come = commands.iter().fold(0_u64, |sum, curve| sum.saturating_add(curve.count(backlog)));
            let next = base.checked_add(come.checked_mul(command_ns)?)?;
            if next == backlog {
                return Some(backlog);
            }
            backlog = next;
        }
        None
    }

    /// On board a step of the brain may come before each task, but no more than one a tick; and two commands can
    /// wait, as a third is written only when a frame has been served behind the first.
    fn backlog_on_board(&self, reads: &[u64]) -> Option<u64> {
        let Plan { spec, step_ns, .. } = *self.plan;
        if self.plan.has_ports() {
            return None;
        }
        let command_ns = self.plan.command_ns();
        let longest = longest_task_ns(self.plan, 0);
        let tasks: u64 = reads.iter().sum::<u64>() + 2 * command_ns + longest;
        let most = reads.len() as u64 + 5;
        let mut backlog = tasks;
        for _ in 0..MOST_ROUNDS {
            let thinks = most.min(backlog / step_ns + 2);
            let next = tasks + thinks * spec.thinking_ns;
            if next == backlog {
                break;
            }
            backlog = next;
        }
        Some(tasks + most.min(backlog / step_ns + 2) * spec.thinking_ns)
    }

    /// How long the microcontroller waits for its transmitter at most, if messages wait so long for the wire.
    fn blocked_ns(&self, wait_up: u64) -> Option<u64> {
        let link = &self.plan.spec.link;
        let (bytes, burst) = (self.bytes.most, link.burst_ns(self.bytes.most));
        let depth = link.transmit_depth() as u64;
        match link {
            Link::Ideal | Link::Onboard => Some(0),
            Link::Usb(usb) if bytes <= depth && wait_up <= usb.frame_ns => Some(0),
            Link::Usb(usb) => Some(2 * usb.frame_ns + burst),
            Link::Uart(_) => {
                let hold = wire::hold_up_ns(link).most;
                let queued = wait_up.saturating_sub(hold);
                let before = queued.div_ceil(link.burst_ns(1).max(1));
                if before + bytes <= depth {
                    return Some(0);
                }
                let shared = if turnaround_ns(link).is_some() { queued } else { 0 };
                let over =
                    if queued <= 1 { link.burst_ns(bytes.saturating_sub(depth)) + 2 } else { burst + 2 };
                Some(over + shared)
            }
        }
    }

    /// How long a message waits besides being on the wire.
    fn wait_up(&self, estimate: &Estimate) -> Option<u64> {
        let link = &self.plan.spec.link;
        let jitter = estimate.backlog?.saturating_sub(self.framing.most) + self.framing.width();
        let closings = frame_period_ns(self.plan).map(|period| Curve::every(period).late_by(jitter));
        let queued = match link {
            Link::Ideal | Link::Onboard => 0,
            Link::Usb(usb) => self.frames_ns(usb.frame_ns, usb.bytes_per_frame, closings),
            Link::Uart(_) => self.queued_up_ns(closings),
        };
        let shared = match turnaround_ns(link) {
            None => 0,
            Some(turn) => self.shared_ns(turn, estimate)?,
        };
        let hold = wire::hold_up_ns(link).most;
        if let Some(radio) = wire::radio(link) {
            let packet = wire::packet_ns(&radio).most;
            let by_wire = packet / link.burst_ns(1).max(1) + 1;
            let by_messages = match closings {
                _ if self.takes_turns() => self.bytes.most,
                Some(closings) => {
                    closings.late_by(queued + link.burst_ns(self.bytes.most)).count(packet) * self.bytes.most
                }
                None => u64::MAX,
            };
            let at_once = by_wire.min(by_messages);
            if at_once > u64::from(radio.packet_bytes) || 3 * at_once > link.laptop_buffer() as u64 {
                return None;
            }
        }
        queued.checked_add(hold)?.checked_add(shared)
    }

    /// USB: what comes within a frame goes with the next, unless it is too much.
    fn frames_ns(&self, frame_ns: u64, bytes_per_frame: u32, closings: Option<Curve>) -> u64 {
        let at_once = match closings {
            _ if self.takes_turns() => 1,
            Some(closings) => closings.count(frame_ns),
            None => u64::MAX,
        };
        let fits = at_once.saturating_mul(self.bytes.most) <= u64::from(bytes_per_frame);
        // What fits into no frame alone begins with one, and nothing comes before it is over.
        let alone = self.takes_turns()
            || closings.is_some_and(|curve| curve.count(self.plan.spec.link.burst_ns(self.bytes.most)) == 1);
        if fits || alone { frame_ns } else { 2 * frame_ns }
    }

    /// UART: what is on the wire already, which is no more than the transmitter holds.
    fn queued_up_ns(&self, closings: Option<Curve>) -> u64 {
        let link = &self.plan.spec.link;
        if self.takes_turns() {
            return 1;
        }
        let burst = link.burst_ns(self.bytes.most);
        let held = link.burst_ns(link.transmit_depth() as u64);
        let queue = closings.and_then(|curve| queue(&[Source { curve, work_ns: burst }]));
        queue.map_or(held, |queue| held.min(queue.backlog_ns - burst)) + 1
    }

    /// Where both share the wire: the longest time that it is not idle.
    fn shared_ns(&self, turn: u64, estimate: &Estimate) -> Option<u64> {
        let link = &self.plan.spec.link;
        if self.takes_turns() {
            return Some(turn);
        }
        let period = frame_period_ns(self.plan)?;
        let message = self.framing.most + link.burst_ns(self.bytes.most) + turn;
        let command = link.burst_ns(self.plan.command_bytes().most) + turn;
        let hold = wire::hold_down_ns(link).width();
        let late = estimate.backlog?;
        let busy = self.commands(estimate).into_iter().filter_map(|way| {
            let commands =
                way.into_iter().map(|curve| Source { curve: curve.late_by(hold), work_ns: command });
            let mut sources = vec![Source { curve: Curve::every(period).late_by(late), work_ns: message }];
            sources.extend(commands);
            queue(&sources).map(|queue| queue.busy_ns)
        });
        // A robot that speaks again before its last message is over keeps the wire.
        busy.min().filter(|busy| period.saturating_sub(late) > busy + turn)
    }

    /// From the write to the arrival of the command's last byte.
    fn down(&self, estimate: &Estimate) -> Option<u64> {
        let link = &self.plan.spec.link;
        let bytes = self.plan.command_bytes().most;
        let burst = link.burst_ns(bytes);
        let hold = wire::hold_down_ns(link);
        let shared = match turnaround_ns(link) {
            None => 0,
            Some(turn) => self.shared_ns(turn, estimate)?,
        };
        if self.takes_turns() {
            let fits = wire::radio(link).is_none_or(|radio| bytes <= u64::from(radio.packet_bytes));
            return fits.then_some(hold.most + wire::frame_ns(link) + burst + shared + 1);
        }
        let least = self.commands(estimate).into_iter().filter_map(|way| self.down_by(&way, bytes)).min()?;
        least.checked_add(shared)
    }

    fn down_by(&self, commands: &[Curve], bytes: u64) -> Option<u64> {
        let link = &self.plan.spec.link;
        let hold = wire::hold_down_ns(link);
        let come = |within_ns: u64| commands.iter().map(|curve| curve.count(within_ns)).sum::<u64>();
        if let Some(radio) = wire::radio(link) {
            let at_once = come(wire::packet_ns(&radio).most).saturating_mul(bytes);
            if at_once > u64::from(radio.packet_bytes) {
                return None;
            }
        }
        if let Link::Usb(usb) = link
            && come(usb.frame_ns).saturating_mul(bytes) <= u64::from(usb.bytes_per_frame)
        {
            return Some(2 * usb.frame_ns);
        }
        let work_ns = link.burst_ns(bytes);
        let source = |curve: &Curve| Source { curve: curve.late_by(hold.width()), work_ns };
        let queue = queue(&commands.iter().map(source).collect::<Vec<_>>())?;
        hold.most.checked_add(wire::frame_ns(link))?.checked_add(queue.backlog_ns)?.checked_add(1)
    }
}
