//! The greatest lateness of the microcontroller.

use alloc::vec::Vec;

use super::bounds::{Estimate, Fixed, MOST_ROUNDS, longest_task_ns};
use super::curve::{Curve, Source, backlog_after, queue};
use super::plan::Plan;
use super::wire;
use baudbot_sim::firmware::Mode;
use baudbot_sim::link::Link;
use baudbot_sim::model::Writes;

impl Fixed<'_> {
    /// Most work that there is at an instant, in nanoseconds.
    pub(super) fn backlog(&self, estimate: &Estimate) -> Option<u64> {
        let plan = self.plan;
        let reads = self.reads();
        let frame_ns = self.framing.most.checked_add(self.blocked_ns(estimate.wait_up?)?)?;
        if plan.spec.is_onboard() && plan.spec.thinking_ns > 0 {
            return self.backlog_on_board(&reads);
        }
        let late = estimate.backlog?;
        let backlogs = self.arrivals(estimate).into_iter().filter_map(|arrivals| {
            let in_order = queue(&self.in_order(&reads, Some((frame_ns, late)), &arrivals));
            let once = self.once_each(&reads, frame_ns, &arrivals);
            [in_order.map(|queue| queue.backlog_ns), once].into_iter().flatten().min()
        });
        backlogs.min()
    }

    fn reads(&self) -> Vec<u64> {
        self.plan.on_wire().iter().map(|sensor| self.plan.read_ns(sensor).most).collect()
    }

    /// The greatest lateness at which the last byte of a command is taken. Work that fell due before the message that
    /// it answers is done, unless the processor has not rested since.
    pub(super) fn obeyed_late(&self, estimate: &Estimate) -> Option<u64> {
        let own_ns = self.plan.receiving_ns() + self.plan.spec.processor.obeying_ns;
        let most = estimate.backlog?;
        let is_alone = self.takes_turns() || self.is_over_in_time(estimate);
        // On board thinking is work of the processor, too.
        if !is_alone || self.plan.spec.is_onboard() {
            return Some(most.saturating_sub(own_ns));
        }
        let reads = self.reads();
        let frame = (self.framing.most.saturating_add(self.blocked_ns(estimate.wait_up?)?), most);
        let backlogs = self.arrivals(estimate).into_iter().filter_map(|arrivals| {
            let since = backlog_after(&self.in_order(&reads, None, &arrivals), 0)?;
            let before =
                backlog_after(&self.in_order(&reads, Some(frame), &arrivals), self.least_exchange_ns())?;
            Some(since.max(before))
        });
        Some(backlogs.chain([most]).min()?.saturating_sub(own_ns))
    }

    /// The arrivals from the laptop, in all the ways in which they are known; each is true.
    fn arrivals(&self, estimate: &Estimate) -> Vec<Arrivals> {
        let plan = self.plan;
        let late = estimate.down.map(|down| down + plan.spec.link.burst_ns(plan.command_bytes().most));
        let known = self.commands(estimate).into_iter().filter_map(|way| Some((way, late?)));
        let ways = known.map(|(way, late)| Arrivals {
            pieces: Vec::new(),
            commands: way.into_iter().map(|curve| curve.late_by(late)).collect(),
            command_ns: plan.command_ns(),
        });
        ways.chain(self.off_the_wire()).collect()
    }

    /// Whatever is written: a serial line brings one character after the other.
    fn off_the_wire(&self) -> Option<Arrivals> {
        let Plan { spec, .. } = self.plan;
        let character_ns = wire::least_ns(&spec.link, 1);
        let command_ns = wire::least_ns(&spec.link, self.plan.command_bytes().least);
        let character = Source { curve: Curve::every(character_ns), work_ns: self.plan.receiving_ns() };
        (matches!(spec.link, Link::Uart(_)) && character_ns > 0).then(|| Arrivals {
            pieces: alloc::vec![character],
            commands: alloc::vec![Curve::every(command_ns)],
            command_ns: spec.processor.obeying_ns,
        })
    }

    /// The work that comes before a frame: earlier tasks come first. `frame` has the work of a frame and the lateness
    /// of its request.
    fn in_order(&self, reads: &[u64], frame: Option<(u64, u64)>, arrivals: &Arrivals) -> Vec<Source> {
        let source = |curve, work_ns| Source { curve, work_ns };
        let sensors = self.plan.on_wire().iter().zip(reads);
        let mut sources: Vec<_> =
            sensors.map(|(sensor, &ns)| source(Curve::every(sensor.schedule.period_ns()), ns)).collect();
        let Arrivals { pieces, commands, command_ns } = arrivals;
        sources.extend(pieces);
        sources.extend(commands.iter().map(|&curve| source(curve, *command_ns)));
        match (frame, self.plan.spec.firmware.mode) {
            (None, _) => {}
            (Some((frame_ns, _)), Mode::Stream(frame)) => {
                sources.push(source(Curve::every(frame.period_ns()), frame_ns));
            }
            (Some((frame_ns, late)), Mode::Poll) => {
                sources.extend(commands.iter().map(|&curve| source(curve.late_by(late), frame_ns)));
            }
        }
        sources
    }

    /// The work under way, and each other task once; commands as many as can have come meanwhile.
    fn once_each(&self, reads: &[u64], frame_ns: u64, arrivals: &Arrivals) -> Option<u64> {
        let tasks = reads.iter().sum::<u64>() + frame_ns;
        let command_ns = self.plan.command_ns();
        let longest = reads.iter().copied().chain([frame_ns, command_ns]).max()?;
        let base = tasks.checked_add(longest)?;
        if self.takes_turns() {
            return base.checked_add(command_ns);
        }
        let mut backlog = base;
        for _ in 0..MOST_ROUNDS {
            let commands =
                arrivals.commands.iter().map(|&curve| Source { curve, work_ns: arrivals.command_ns });
            let come = arrivals.pieces.iter().copied().chain(commands);
            let come = come.map(|source| source.curve.count(backlog).saturating_mul(source.work_ns));
            let next = come.fold(base, u64::saturating_add);
            if next == u64::MAX {
                return None;
            }
            if next == backlog {
                return Some(backlog);
            }
            backlog = next;
        }
        None
    }

    /// On board a step of the brain may come before each task, but no more than one a tick; and two commands can
    /// wait, as a third is written only when a frame has been served behind the first. A brain that writes unasked may write in
    /// each of its steps.
    fn backlog_on_board(&self, reads: &[u64]) -> Option<u64> {
        let Plan { spec, step_ns, .. } = *self.plan;
        if self.plan.has_ports() {
            return None;
        }
        let command_ns = self.plan.command_ns();
        let longest = longest_task_ns(self.plan, 0);
        let tasks: u64 = reads.iter().sum::<u64>() + longest;
        let asked = self.plan.writes() == Writes::OnMessage;
        let most = if asked { reads.len() as u64 + 5 } else { u64::MAX };
        let mut backlog = tasks;
        for _ in 0..MOST_ROUNDS {
            let thinks = most.min(backlog / step_ns + 2);
            let commands = if asked { 2 } else { thinks.saturating_mul(self.plan.commands_in_a_turn()) };
            let work =
                thinks.saturating_mul(spec.thinking_ns).saturating_add(commands.saturating_mul(command_ns));
            let next = tasks.saturating_add(work);
            if next == u64::MAX {
                return None;
            }
            if next == backlog {
                return Some(backlog);
            }
            backlog = next;
        }
        asked.then(|| tasks + most.saturating_mul(spec.thinking_ns) + 2 * command_ns)
    }
}

/// The bytes of the laptop as they arrive at the microcontroller.
struct Arrivals {
    /// Work besides that of a whole command.
    pieces: Vec<Source>,
    /// The curves by which commands are complete.
    commands: Vec<Curve>,
    /// The work that each of them makes, in nanoseconds.
    command_ns: u64,
}
