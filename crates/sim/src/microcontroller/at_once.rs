//! Messages on a line that takes no time, between ends that take none either: what is in them arrives as it is sent, to
//! the resolution that it has on the wire, and their bytes are only counted.

use baudbot_wire::frame;

use super::request::Request;
use super::{Microcontroller, Taken};
use crate::firmware::{Protocol, Refusal};
use crate::laptop::Laptop;
use crate::link::{Command, Line, LineCounters, Link};
use crate::model::{PortUse, RobotSpec};
use crate::time::SimTime;

impl Microcontroller {
    /// The number of bytes of a command that may go as it is on this line; `None` if something depends on its bytes.
    pub(crate) fn len_at_once(&self, spec: &RobotSpec, downlink: &Line, command: &Command) -> Option<usize> {
        let layout = spec.firmware.layout();
        let payload = layout.command_len();
        let is_whole = matches!(spec.firmware.protocol, Protocol::Framed { .. })
            && 2 + command.others.len() == layout.motors.len()
            && payload <= frame::SHORT_PAYLOAD
            && [command.wheels.left, command.wheels.right]
                .iter()
                .chain(&command.others)
                .all(|s| s.is_finite());
        // An observer of the cable sees bytes.
        let is_instant = !downlink.is_taped()
            && downlink.is_idle_and_instant(&spec.link)
            && self.decoder.is_between_frames()
            && (spec.is_onboard() || spec.processor.receiving_ns_per_byte == 0);
        (is_whole && is_instant).then(|| frame::encoded_len_max(payload))
    }

    /// Takes a command as [`receive`](Self::receive) would take its bytes.
    pub(super) fn receive_command(
        &mut self,
        spec: &RobotSpec,
        now: SimTime,
        command: &Command,
        counters: &mut LineCounters,
    ) -> Taken {
        self.free_at = now;
        let signals =
            [command.wheels.left, command.wheels.right].into_iter().chain(command.others.iter().copied());
        let mut signals = spec
            .firmware
            .layout()
            .motors
            .iter()
            .zip(signals)
            .map(|(encoding, signal)| encoding.quantise(signal));
        let request = Request::drive(spec, &mut signals).ok_or(Refusal::Protocol);
        counters.bad_messages += u64::from(request.is_err());
        self.take_request(spec, request, counters)
    }

    /// Frames what is readable and gives it to the laptop, if all of that takes no time; returns how many bytes it has
    /// and when the control cycle began that it belongs to. `None`, and nothing is done, if something depends on the
    /// bytes.
    pub(crate) fn send_at_once(
        &mut self,
        spec: &RobotSpec,
        now: SimTime,
        uplink: &mut Line,
        laptop: &mut Laptop,
    ) -> Option<(usize, SimTime)> {
        let is_instant =
            matches!((&spec.link, spec.firmware.protocol), (Link::Ideal, Protocol::Framed { .. }))
                && uplink.is_idle_and_instant(&spec.link)
                && spec.processor.framing_ns_per_byte == 0
                && spec.port_use == PortUse::Closed;
        if !is_instant {
            return None;
        }
        let mut bytes = [0; frame::MAX_FRAME];
        let (len, _) = self.write_frame(&spec.firmware, now, 0, &mut bytes);
        if !laptop.take_at_once(spec, &bytes[..len]) {
            return None;
        }
        uplink.pass_message(now, &bytes[..len]);
        let begun = self.tell(spec, now, laptop);
        self.free_at = now;
        Some((len, begun))
    }
}
