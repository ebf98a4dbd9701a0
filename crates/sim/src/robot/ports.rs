//! The cables of sensors' own: what goes up on them, and dialogues.

use super::Robot;
use crate::link::{Link, Message};
use crate::model::RobotSpec;
use crate::sensor::dialogue::{DialogueState, Fate, OnWire, Said};
use crate::sensor::port::{Port, PortState};
use crate::time::SimTime;
use crate::timeline::What;

impl Robot {
    /// The new baud rate of the microcontroller, once all that it sent before has arrived.
    pub(crate) fn take_baud(&mut self) -> Option<u32> {
        if self.uplink.under_way() > 0 { None } else { self.microcontroller.take_baud() }
    }

    /// A program opens the ports of this robot at `now`, and reads nothing from before; or it closes them, and leaves nothing.
    pub(crate) fn open_ports(&mut self, spec: &RobotSpec, open: bool, now: SimTime) {
        self.laptop.unread.clear();
        self.laptop.instants.clear();
        self.ports.iter_mut().for_each(PortState::clear);
        self.forget_arrived();
        let Some(dialogues) = &mut self.parts.dialogues else { return };
        for (k, (dialogue, state)) in dialogues.iter_mut().zip(&mut self.ports).enumerate() {
            if let (Some(dialogue), Some(port)) = (dialogue, port(spec, k)) {
                dialogue.open(port, open, now, &mut state.line);
            }
        }
    }

    /// The instant at which the next byte arrives at the laptop, and on which sensor's cable, if it is not the
    /// microcontroller's.
    #[inline]
    pub(super) fn next_byte(&self, spec: &RobotSpec) -> (SimTime, Option<usize>) {
        let mut next = (self.uplink.arrival(&spec.link), None);
        for (k, port) in self.ports.iter().enumerate() {
            let arrival = port.arrival(self.cable(spec, k));
            if arrival < next.0 {
                next = (arrival, Some(k));
            }
        }
        next
    }

    /// Moves the measurement of sensor `i`'s device to its output at `now`, and onto its own cable, if it has one and
    /// sends it.
    pub(super) fn send_output(&mut self, spec: &RobotSpec, now: SimTime, i: usize) {
        let sensor = &spec.sensors[i];
        let place = spec.sensors.ports().iter().position(|&other| other == i);
        let is_dialogue = place.is_some_and(|k| self.dialogue(k).is_some());
        let output = self.microcontroller.output(i, sensor);
        let (Some(output), Some(port), Some(k)) = (output, &sensor.port, place) else { return };
        if is_dialogue {
            return self.offer_scan(spec, now, (k, i));
        }
        match self.ports[k].send(sensor, port, i, now, output) {
            Some((from, until)) => {
                let bytes = port.format.message_len(&sensor.device) as u32;
                self.recorder.note(from, until, What::Port { sensor: i as u16, bytes });
            }
            None => {
                self.microcontroller.leave_out(i);
                self.recorder.note(now, now, What::Missed { sensor: i as u16 });
            }
        }
    }

    /// Takes the bytes that arrive at `now` on the cable of a sensor's own.
    #[inline(never)]
    pub(super) fn hear_port(&mut self, spec: &RobotSpec, now: SimTime, k: usize) -> bool {
        let i = spec.sensors.ports()[k];
        let cable = self.cable(spec, k);
        let mut drives = false;
        while let Some(arrival) = self.ports[k].take(cable, now) {
            let answer = self.laptop.receive_from_port(spec, i, arrival, &mut self.ports[k]);
            if let Some(is_start) = answer {
                self.drive_dialogue(spec, now, k, is_start);
                drives = true;
            }
        }
        drives
    }

    /// The cable of port `k` as it is now.
    #[inline]
    fn cable<'a>(&self, spec: &'a RobotSpec, k: usize) -> &'a Link {
        let Some(port) = port(spec, k) else { return &Link::Ideal };
        if self.parts.dialogues.is_none() {
            return &port.link;
        }
        self.dialogue(k).map_or(&port.link, |dialogue| dialogue.cable(port))
    }

    /// The dialogue on port `k`, if it is one.
    pub(crate) fn dialogue(&self, k: usize) -> Option<&DialogueState> {
        self.parts.dialogues.as_ref()?.get(k)?.as_ref()
    }

    fn dialogue_mut(&mut self, k: usize) -> Option<&mut DialogueState> {
        self.parts.dialogues.as_mut()?.get_mut(k)?.as_mut()
    }

    /// The instant at which a device does something next on a port of its own, if there is a dialogue, and on which.
    #[inline(never)]
    pub(super) fn next_of_dialogues(&self, spec: &RobotSpec) -> Option<(SimTime, usize)> {
        let nexts = (0..self.ports.len()).filter_map(|k| Some((self.dialogue(k)?.next(port(spec, k)?), k)));
        nexts.min_by_key(|(at, _)| *at)
    }

    /// The device on port `k` does what is next.
    pub(super) fn run_dialogue(&mut self, spec: &RobotSpec, now: SimTime, k: usize) {
        let Some(port) = port(spec, k) else { return };
        let Self { parts, ports, microcontroller, .. } = self;
        let dialogue = parts.dialogues.as_mut().and_then(|all| all.get_mut(k)?.as_mut());
        let (Some(dialogue), Some(state)) = (dialogue, ports.get_mut(k)) else { return };
        let newest = microcontroller.newest(spec.sensors.ports()[k]);
        let said = dialogue.run(port, now, &mut state.line, newest.map(|(values, begun, _)| (values, begun)));
        match said {
            Said::Nothing => {}
            Said::Up(on_wire) => self.note_up(spec, k, on_wire),
            Said::Down(on_wire) => self.note_down(spec, k, on_wire),
        }
    }

    /// A device sends something that is no scan, on port `k`.
    fn note_up(&mut self, spec: &RobotSpec, k: usize, on_wire: OnWire) {
        let OnWire { from, until, bytes } = on_wire;
        let sensor = spec.sensors.ports()[k] as u16;
        self.recorder.note(from, until, What::Port { sensor, bytes });
    }

    /// A device is sent something, on port `k`.
    fn note_down(&mut self, spec: &RobotSpec, k: usize, on_wire: OnWire) {
        let OnWire { from, until, bytes } = on_wire;
        let sensor = spec.sensors.ports()[k] as u16;
        self.recorder.note(from, until, What::PortDown { sensor, bytes });
    }

    /// The laptop's drivers have begun to ask before the run began.
    pub(crate) fn note_first_questions(&mut self, spec: &RobotSpec) {
        for k in 0..self.ports.len() {
            let asked =
                port(spec, k).zip(self.dialogue(k)).and_then(|(port, state)| state.first_question(port));
            if let Some(on_wire) = asked {
                self.note_down(spec, k, on_wire);
            }
        }
    }

    /// A scan is there on port `k`, a dialogue, of sensor `i`.
    fn offer_scan(&mut self, spec: &RobotSpec, now: SimTime, (k, i): (usize, usize)) {
        let Some(port) = port(spec, k) else { return };
        let Self { parts, ports, microcontroller, recorder, .. } = self;
        let dialogue = parts.dialogues.as_mut().and_then(|all| all.get_mut(k)?.as_mut());
        let (Some(dialogue), Some(state)) = (dialogue, ports.get_mut(k)) else { return };
        let Some((values, begun, truly_at)) = microcontroller.newest(i) else { return };
        let message = Message { sampled: alloc::vec![(i, truly_at)], ..Message::default() };
        match dialogue.scan(port, now, &mut state.line, (values, begun), message) {
            Fate::Unwanted => {}
            Fate::Missed => {
                microcontroller.leave_out(i);
                recorder.note(now, now, What::Missed { sensor: i as u16 });
            }
            Fate::Sent(on_wire) => self.note_up(spec, k, on_wire),
        }
    }

    /// A message that is no reading has come to the laptop on port `k` at `now`.
    fn drive_dialogue(&mut self, spec: &RobotSpec, now: SimTime, k: usize, is_start: bool) {
        let (Some(port), Some(dialogue)) = (port(spec, k), self.dialogue_mut(k)) else { return };
        if let Some(on_wire) = dialogue.drive(port, now, is_start) {
            self.note_down(spec, k, on_wire);
        }
    }

    /// Bytes are written to the port of sensor `i`. Returns whether it has one: a device without a dialogue ignores
    /// them.
    pub(crate) fn write_port(&mut self, spec: &RobotSpec, i: usize, at: SimTime, bytes: &[u8]) -> bool {
        let Some(k) = spec.sensors.ports().iter().position(|&other| other == i) else { return false };
        if let (Some(port), Some(dialogue)) = (port(spec, k), self.dialogue_mut(k)) {
            dialogue.write(port, at, bytes);
        }
        true
    }

    /// The bytes that were written to ports in this tick are on their way, none of them before `from`.
    pub(crate) fn send_written(&mut self, spec: &RobotSpec, from: SimTime) {
        if self.parts.dialogues.is_none() {
            return;
        }
        for k in 0..self.ports.len() {
            let (Some(port), Some(dialogue)) = (port(spec, k), self.dialogue_mut(k)) else { continue };
            for on_wire in dialogue.send_written(port, from) {
                self.note_down(spec, k, on_wire);
            }
        }
    }

    /// Whether the cables of sensors' own can be so at `now`.
    pub(crate) fn ports_are_sound(&self, spec: &RobotSpec, now: SimTime) -> bool {
        let sensors = spec.sensors.len();
        let dialogues = self.parts.dialogues.as_ref();
        dialogues.is_none_or(|all| all.len() == self.ports.len())
            && self.ports.iter().enumerate().all(|(k, state)| {
                let expected = port(spec, k).is_some_and(|port| port.dialogue.is_some());
                let dialogue = match (self.dialogue(k), port(spec, k)) {
                    (Some(dialogue), Some(port)) => expected && dialogue.is_sound(port, now, sensors),
                    (None, _) => !expected,
                    (Some(_), None) => false,
                };
                dialogue && state.is_sound(self.cable(spec, k), now, sensors)
            })
    }
}

fn port(spec: &RobotSpec, k: usize) -> Option<&Port> {
    spec.sensors.get(*spec.sensors.ports().get(k)?)?.port.as_ref()
}
