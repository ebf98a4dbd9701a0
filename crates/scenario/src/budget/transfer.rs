//! The longest time that bytes are on their way, besides being on the wire.

use alloc::vec;
use alloc::vec::Vec;

use super::bounds::{Estimate, Fixed, frame_period_ns};
use super::curve::{Curve, Source, queue};
use super::plan::turnaround_ns;
use super::wire;
use baudbot_sim::link::Link;

impl Fixed<'_> {
    /// The longest time for which the microcontroller waits for its transmitter, if messages wait so long for the wire.
    pub(super) fn blocked_ns(&self, wait_up: u64) -> Option<u64> {
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

    /// The time for which a message waits besides being on the wire.
    pub(super) fn wait_up(&self, estimate: &Estimate) -> Option<u64> {
        let link = &self.plan.spec.link;
        if self.plan.acknowledgement_bytes() > 0 {
            return None;
        }
        let jitter = estimate.backlog?.saturating_sub(self.framing.most) + self.framing.width();
        let closings = frame_period_ns(self.plan).map(|period| Curve::every(period).late_by(jitter));
        let queued = match link {
            Link::Ideal | Link::Onboard => 0,
            Link::Usb(usb) => self.frames_ns(usb.frame_ns, usb.bytes_per_frame, closings),
            Link::Uart(_) => self.queued_up_ns(closings),
        };
        let shared = match turnaround_ns(link) {
            None => 0,
            Some(_) if self.is_over_in_time(estimate) => 0,
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
        // A message that fits into no frame alone begins with one, and nothing comes before it is over.
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

    /// The longest time for which a wire that both share is not idle.
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
        // The case in which the robot speaks again before its last message is over has not been worked out.
        busy.min().filter(|busy| period.saturating_sub(late) > busy + turn)
    }

    /// The time from the write to the arrival of the command's last byte.
    pub(super) fn down(&self, estimate: &Estimate) -> Option<u64> {
        let link = &self.plan.spec.link;
        let bytes = self.plan.command_bytes().most;
        let burst = link.burst_ns(bytes);
        let hold = wire::hold_down_ns(link);
        let shared = match turnaround_ns(link) {
            None => 0,
            Some(turn) if self.is_over_in_time(estimate) => turn,
            Some(turn) => self.shared_ns(turn, estimate)?,
        };
        if self.takes_turns() || self.is_over_in_time(estimate) {
            let fits = wire::radio(link).is_none_or(|radio| bytes <= u64::from(radio.packet_bytes));
            return fits.then_some(hold.most + wire::frame_ns(link) + burst + shared + u64::from(burst > 0));
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
        // The answer is the first that is written in its turn.
        let behind = if wire::radio(link).is_some() { 0 } else { self.plan.commands_in_a_turn() - 1 };
        let behind_ns = behind.saturating_mul(work_ns);
        hold.most
            .checked_add(wire::frame_ns(link))?
            .checked_add(queue.backlog_ns.saturating_sub(behind_ns))?
            .checked_add(u64::from(work_ns > 0))
    }
}
