//! The far end of a program's ports: the cables of its robot in the world.

use std::collections::VecDeque;

use baudbot_board::far_end::{self, Read, Settings};
use baudbot_port::UartCable;
use baudbot_program::{Cables, LineSettings, ModemInputs, ModemOutputs};
use baudbot_sim::cable::Cable;
use baudbot_sim::link::Link;
use baudbot_sim::{SimTime, World};

use crate::port_world::PortWorld;

/// A port of the program, with what its UART and that of the robot make of each other.
pub(super) struct PortLine {
    cable: Cable,
    uart: UartCable,
    /// The settings of the program's UART, from when it first opens the port until it ends.
    settings: Option<Settings>,
    /// Bytes for the program, with the instants at which it gets them.
    up: VecDeque<Read>,
    /// Bytes of the program, with the instants from which on the world's cable carries them.
    down: VecDeque<Read>,
    outputs: ModemOutputs,
    break_since_ns: Option<u64>,
}

impl PortLine {
    pub(super) fn new(world: &World, robot: usize, cable: Cable) -> Self {
        let spec = world.robot(robot).spec();
        let link = match cable {
            Cable::Robot => Some(&spec.link),
            Cable::Sensor(i) => spec.sensors[i].port.as_ref().map(|port| &port.link),
        };
        let bits = match link {
            Some(Link::Uart(uart)) => u32::from(uart.bits_per_character),
            Some(Link::Ideal | Link::Usb(_) | Link::Onboard) | None => 10,
        };
        let settings = baud(world, robot, cable).map(|baud| Settings::of_cable(baud, bits));
        let (up, down, outputs) = (VecDeque::new(), VecDeque::new(), ModemOutputs::default());
        let uart = UartCable::new(settings);
        Self { cable, uart, settings: None, up, down, outputs, break_since_ns: None }
    }

    /// The program has ended: nobody reads any more, and what it wrote still goes out.
    pub(super) fn abandon(&mut self) {
        self.settings = None;
        self.up.clear();
    }

    /// The instant at which something happens next of what is on its way already.
    pub(super) fn next_ns(&self, now_ns: u64) -> Option<u64> {
        // What has come by now and is not taken waits for nothing.
        let later =
            |reads: &VecDeque<Read>| reads.iter().map(|read| read.at_ns).find(|at_ns| *at_ns > now_ns);
        let own = self.settings.filter(|_| self.uart.is_listening());
        let idle = own.map(|own| now_ns + own.character_ns().max(1));
        later(&self.up).into_iter().chain(later(&self.down)).chain(idle).min()
    }

    /// Whether bytes have come for the program by now.
    pub(super) fn has_come(&self, now_ns: u64) -> bool {
        self.up.front().is_some_and(|read| read.at_ns <= now_ns)
    }
}

/// The rate of a cable as it is now, if it has one.
fn baud(world: &World, robot: usize, cable: Cable) -> Option<u32> {
    match cable {
        Cable::Robot => world.robot(robot).spec().link.baud(),
        Cable::Sensor(i) => world.port_baud(robot, i),
    }
}

/// The far end at an instant.
pub(super) struct FarEnd<'a, W> {
    pub(super) world: &'a mut W,
    pub(super) robot: usize,
    pub(super) now_ns: u64,
    pub(super) lines: &'a mut [PortLine],
    /// The program has raised DTR on the robot's cable.
    pub(super) has_raised: &'a mut bool,
}

impl<W: PortWorld> FarEnd<'_, W> {
    /// What has reached the laptop by now, and what its own UART has sent by now, goes on.
    pub(super) fn pass(&mut self) {
        for port in 0..self.lines.len() {
            self.hear(port);
            let line = &mut self.lines[port];
            line.uart.idle(self.now_ns, &mut line.up, &mut line.down);
            self.hand_down(port);
        }
    }

    fn hear(&mut self, port: usize) {
        let line = &mut self.lines[port];
        line.uart.set_baud(baud(self.world.world(), self.robot, line.cable));
        let mut bytes = Vec::new();
        self.world.take_arrived(self.robot, line.cable, &mut bytes);
        if line.settings.is_none() {
            // Nobody has this port; while the program has closed it, its terminal loses what comes.
            return;
        }
        let bytes: Vec<_> = bytes.into_iter().map(|byte| (self.now_ns, byte)).collect();
        line.uart.up(line.settings, &bytes, &mut line.up);
    }

    /// Bytes that the program's UART has sent by now are on the world's cable.
    fn hand_down(&mut self, port: usize) {
        let line = &mut self.lines[port];
        let due = line.down.partition_point(|read| read.at_ns <= self.now_ns);
        if due > 0 {
            let bytes: Vec<u8> = line.down.drain(..due).map(|read| read.byte).collect();
            self.world.write_within(self.robot, line.cable, SimTime::from_ns(self.now_ns), &bytes);
        }
    }
}

impl<W: PortWorld> Cables for FarEnd<'_, W> {
    fn write(&mut self, port: usize, bytes: &[u8]) {
        let line = &mut self.lines[port];
        line.uart.down(line.settings, self.now_ns, bytes, &mut line.down);
        self.hand_down(port);
    }

    fn take(&mut self, port: usize, into: &mut Vec<u8>) {
        let line = &mut self.lines[port];
        let come = line.up.partition_point(|read| read.at_ns <= self.now_ns);
        into.extend(line.up.drain(..come).map(|read| read.byte));
    }

    fn sent_at_ns(&self, port: usize) -> u64 {
        let line = &self.lines[port];
        let on_cable = self.world.world().sent_at(self.robot, line.cable).map_or(0, SimTime::as_ns);
        let own = line
            .down
            .back()
            .map_or(0, |read| read.at_ns + line.settings.map_or(0, |settings| settings.character_ns()));
        on_cable.max(own)
    }

    fn unsent(&self, port: usize) -> usize {
        let line = &self.lines[port];
        let now = SimTime::from_ns(self.now_ns);
        let (waiting, room) =
            self.world.world().unsent(self.robot, line.cable, now).unwrap_or((0, TTY_BYTES));
        // The system's buffer is full when that of the laptop's driver is.
        waiting.max(TTY_BYTES.saturating_sub(room)) + line.down.len()
    }

    fn configure(&mut self, port: usize, settings: LineSettings) {
        let LineSettings { baud, data_bits, parity, stop_bits } = settings;
        let parity = match parity {
            baudbot_program::Parity::None => far_end::Parity::None,
            baudbot_program::Parity::Even => far_end::Parity::Even,
            baudbot_program::Parity::Odd => far_end::Parity::Odd,
            baudbot_program::Parity::Mark => far_end::Parity::Mark,
            baudbot_program::Parity::Space => far_end::Parity::Space,
        };
        self.lines[port].settings = Some(Settings { baud, data_bits, parity, stop_bits });
    }

    fn set_outputs(&mut self, port: usize, outputs: ModemOutputs) {
        let line = &mut self.lines[port];
        *self.has_raised |= line.cable == Cable::Robot && outputs.dtr && !line.outputs.dtr;
        line.outputs = outputs;
    }

    /// The cables have three wires. Adapters for them hold these lines so that programs go on.
    fn inputs(&self, _port: usize) -> ModemInputs {
        ModemInputs { cts: true, dsr: true, dcd: true, ri: false }
    }

    fn send_break(&mut self, port: usize, is_on: bool) {
        let line = &mut self.lines[port];
        match (line.break_since_ns, is_on) {
            (None, true) => line.break_since_ns = Some(self.now_ns),
            (Some(since_ns), false) => {
                line.break_since_ns = None;
                line.uart.send_break(since_ns, self.now_ns - since_ns, &mut line.down);
                self.hand_down(port);
            }
            (None, false) | (Some(_), true) => {}
        }
    }

    /// What is on the world's cable stays there: it is in the adapter by then.
    fn discard_unsent(&mut self, port: usize) {
        let line = &mut self.lines[port];
        line.down.clear();
        line.uart.forget_sent();
    }
}

/// The bytes that the system holds for a port, each way.
const TTY_BYTES: usize = 4096;
