//! How late the microcontroller is at most.

use alloc::vec::Vec;

use super::bounds::{Estimate, Fixed, MOST_ROUNDS, longest_task_ns};
use super::curve::{Curve, Source, queue};
use super::plan::Plan;
use baudbot_sim::firmware::Mode;

impl Fixed<'_> {
    /// Most work that there is at an instant, in nanoseconds.
    pub(super) fn backlog(&self, estimate: &Estimate) -> Option<u64> {
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
}
