//! A device that answers on a cable of its own: what comes down to it, what it owes, and the laptop's driver that starts
//! it, if there is one.
//!
//! The device takes the bytes of a command as they arrive, answers [`ANSWER_NS`] after the last, and reads on when its
//! transmitter has taken the answer: what arrives meanwhile waits in its receiver, as much as that holds. So a host that
//! asks faster than the cable carries answers loses commands, and nothing grows.

use alloc::boxed::Box;
use alloc::vec::Vec;

use baudbot_wire::scip;
use baudbot_wire::scip::device::{ANSWER_NS, Answer, Description, Device, Effect, Newest, RATES, Rate};
use serde::{Deserialize, Serialize};

use crate::link::{Direction, Line, Link, Message, Uart};
use crate::sensor::port::{Format, Port};
use crate::time::SimTime;

/// That a device answers, and what it says of itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Dialogue {
    /// The device's description of itself.
    pub description: Description,
    /// The end that speaks first.
    pub begin: Begin,
    /// The cable at each of [`RATES`]; none if it has no rate.
    cables: Vec<Link>,
}

/// The end that speaks first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Begin {
    /// Nobody: the device is silent until something is written to its port.
    Asked,
    /// A driver of the laptop's, which lights the laser and asks for scans without an end when the run begins, and lets go of
    /// it while a serial port of `serve` is there for programs.
    Driver,
}

impl Dialogue {
    /// A dialogue on this cable, whose rate is the device's at power-on.
    pub fn new(description: Description, begin: Begin, cable: &Link) -> Self {
        let cables = match cable {
            Link::Uart(uart) => RATES.iter().map(|&baud| Link::Uart(Uart { baud, ..uart.clone() })).collect(),
            Link::Ideal | Link::Usb(_) | Link::Onboard => Vec::new(),
        };
        Self { description, begin, cables }
    }
}

/// State of a dialogue.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct DialogueState {
    /// The line to the device.
    pub(crate) down: Line,
    device: Device,
    /// The cable's rate among [`RATES`]; `None`: the one of power-on.
    rate: Option<u8>,
    /// The rate that it had before, and until when what was sent at that is on the wire.
    before: Option<(SimTime, Option<u8>)>,
    /// When the answer is due; the end of time, if it is due with the next scan.
    answer_at: Option<SimTime>,
    /// From when on the device reads again.
    free_at: SimTime,
    /// When the last scan is on the wire.
    scan_until: SimTime,
    /// The bytes that were written in the tick that is begun, with their instants.
    written: Vec<(SimTime, Vec<u8>)>,
    /// When the laptop's driver asks again; the end of time, if there is none or it has what it wants.
    driver_at: SimTime,
}

impl DialogueState {
    /// Of a robot's sensor, if its port is a dialogue.
    pub(crate) fn new(port: &Port, seed: u64, name: &[&str]) -> Option<Self> {
        let dialogue = port.dialogue.as_ref()?;
        let mut down = Line::down(&port.link, seed, name);
        if dialogue.begin == Begin::Driver {
            down.send(&port.link, SimTime::ZERO, b"BM\n");
        }
        Some(Self {
            down,
            device: Device::new(),
            rate: None,
            before: None,
            answer_at: None,
            free_at: SimTime::ZERO,
            scan_until: SimTime::ZERO,
            written: Vec::new(),
            driver_at: match dialogue.begin {
                Begin::Asked => SimTime::NEVER,
                Begin::Driver => SimTime::from_ns(DRIVER_NS),
            },
        })
    }

    /// A program opens the laptop's end of the cable at `now`, or closes it. If there is a driver, it lets go of the device, which
    /// is as after power-on then, or starts it again.
    pub(crate) fn open(&mut self, port: &Port, open: bool, now: SimTime, up: &mut Line) {
        if port.dialogue.as_ref().is_none_or(|dialogue| dialogue.begin != Begin::Driver) {
            return;
        }
        (self.device, self.answer_at, self.driver_at) = (Device::new(), None, SimTime::NEVER);
        self.change_rate(port, up, None);
        if !open {
            self.send_down(port, now, b"BM\n");
            self.driver_at = now + DRIVER_NS;
        }
    }

    /// Whether it can be so at `now`.
    pub(crate) fn is_sound(&self, port: &Port, now: SimTime, sensors: usize) -> bool {
        let Some(dialogue) = &port.dialogue else { return false };
        let is_known = |rate: Option<u8>| rate.is_none_or(|rate| usize::from(rate) < dialogue.cables.len());
        let rate = is_known(self.rate) && self.before.is_none_or(|(_, rate)| is_known(rate));
        let written: usize = self.written.iter().map(|(_, bytes)| bytes.len()).sum();
        rate && self.down.is_sound(self.cable(port), (Direction::Down, now), sensors)
            && self.device.is_sound(now.as_ns())
            && self.next(port) >= now
            && written <= port.link.laptop_buffer()
    }

    /// The cable at the rate that it has now.
    #[inline]
    pub(crate) fn cable<'a>(&self, port: &'a Port) -> &'a Link {
        Self::cable_at(port, self.rate)
    }

    #[inline]
    fn cable_at(port: &Port, rate: Option<u8>) -> &Link {
        // That of power-on is the usual one, and this is asked for each byte.
        let Some(rate) = rate else { return &port.link };
        let cable = port.dialogue.as_ref().and_then(|dialogue| dialogue.cables.get(usize::from(rate)));
        cable.unwrap_or(&port.link)
    }

    /// The rate of what is on the wire at `now`: behind an answer that changes it, the one before it.
    pub(crate) fn baud(&self, port: &Port, now: SimTime) -> Option<u32> {
        let before = self.before.filter(|(until, _)| now < *until);
        Self::cable_at(port, before.map_or(self.rate, |(_, rate)| rate)).baud()
    }

    /// When the device does something next.
    pub(crate) fn next(&self, port: &Port) -> SimTime {
        self.next_of_device(port).min(self.driver_at)
    }

    fn next_of_device(&self, port: &Port) -> SimTime {
        self.answer_at.unwrap_or_else(|| self.down.arrival(self.cable(port)).max(self.free_at))
    }

    /// Somebody writes to the port in the tick that is begun. What the driver's buffer has no room for is refused.
    pub(crate) fn write(&mut self, port: &Port, at: SimTime, bytes: &[u8]) {
        let held: usize = self.written.iter().map(|(_, bytes)| bytes.len()).sum();
        let room = port.link.laptop_buffer().saturating_sub(held);
        let taken = bytes.len().min(room);
        self.down.counters.refused_bytes += (bytes.len() - taken) as u64;
        if taken > 0 {
            self.written.push((at, bytes[..taken].to_vec()));
        }
    }

    /// Sends the written bytes on their way, in the order of their instants, none of which is before `from`.
    pub(crate) fn send_written(&mut self, port: &Port, from: SimTime) -> Vec<OnWire> {
        let mut written = core::mem::take(&mut self.written);
        written.sort_by_key(|(at, _)| *at);
        written.iter().filter_map(|(at, bytes)| self.send_down(port, (*at).max(from), bytes)).collect()
    }

    /// The bytes that the driver has sent before the run began, of which nothing has arrived.
    pub(crate) fn first_question(&self, port: &Port) -> Option<OnWire> {
        let bytes = self.down.under_way() as u32;
        (bytes > 0).then(|| OnWire { from: SimTime::ZERO, until: self.down.free_at(self.cable(port)), bytes })
    }

    fn send_down(&mut self, port: &Port, at: SimTime, bytes: &[u8]) -> Option<OnWire> {
        let cable = self.cable(port);
        let room = cable.laptop_buffer().saturating_sub(self.down.waiting(cable, at));
        let taken = bytes.len().min(room);
        self.down.counters.refused_bytes += (bytes.len() - taken) as u64;
        let from = self.down.free_at(cable).max(at);
        self.down.send(cable, at, &bytes[..taken]);
        let until = self.down.free_at(cable).max(from);
        (taken > 0).then_some(OnWire { from, until, bytes: taken as u32 })
    }

    /// Runs the next event, at `now`: the driver asks again, or the device takes a byte, or answers.
    pub(crate) fn run(
        &mut self,
        port: &Port,
        now: SimTime,
        up: &mut Line,
        newest: Option<(&[f64], SimTime)>,
    ) -> Said {
        if self.driver_at <= now {
            return self.ask_again(port, now);
        }
        let cable = self.cable(port);
        if self.answer_at.is_some() {
            return self.answer(port, now, up, newest);
        }
        self.down.overrun(cable, now);
        if let Some((_, byte)) = self.down.take(cable, now)
            && self.device.push(byte)
        {
            self.answer_at = Some(now + ANSWER_NS);
        }
        Said::Nothing
    }

    /// The driver has waited long enough.
    fn ask_again(&mut self, port: &Port, now: SimTime) -> Said {
        // The end of a line that was damaged comes first.
        let end = self.send_down(port, now, b"\n");
        let question = self.drive(port, now, false);
        let joined = |first: OnWire, second: OnWire| OnWire {
            from: first.from,
            until: second.until,
            bytes: first.bytes + second.bytes,
        };
        [end, question].into_iter().flatten().reduce(joined).map_or(Said::Nothing, Said::Down)
    }

    fn answer(
        &mut self,
        port: &Port,
        now: SimTime,
        up: &mut Line,
        newest: Option<(&[f64], SimTime)>,
    ) -> Said {
        let Some(dialogue) = &port.dialogue else { return Said::Nothing };
        let cable = self.cable(port);
        let rate: Rate = cable.baud().and_then(core::num::NonZeroU32::new);
        let newest = newest.map(|(ranges_m, begun)| Newest { begun_ns: begun.as_ns(), ranges_m });
        let mut bytes = Vec::new();
        let answer = self.device.answer(&dialogue.description, rate, now.as_ns(), newest, &mut bytes);
        let effect = match answer {
            Answer::Later => {
                self.answer_at = Some(SimTime::NEVER);
                return Said::Nothing;
            }
            Answer::Nothing => Effect::None,
            Answer::Written(effect) => effect,
        };
        let (from, until) = up.send_message(cable, now, &bytes, Message::default());
        self.answer_at = None;
        self.free_at = up.drained(cable).max(now);
        match effect {
            Effect::None => {}
            Effect::Rate(baud) => self.change_rate(port, up, RATES.iter().position(|&rate| rate == baud)),
            Effect::FirstRate => self.change_rate(port, up, None),
        }
        let bytes = bytes.len() as u32;
        if bytes > 0 { Said::Up(OnWire { from, until, bytes }) } else { Said::Nothing }
    }

    /// The bytes on the wire stay as they are.
    fn change_rate(&mut self, port: &Port, up: &mut Line, rate: Option<usize>) {
        self.before = Some((up.free_at(self.cable(port)), self.rate));
        self.rate = rate.map(|rate| rate as u8);
        up.begin_burst();
        self.down.begin_burst();
    }

    /// A scan is there. If the device sends it, the answer is from when until when it is on the wire, and how many bytes it
    /// has; `Missed` if the cable is still taken by the one before.
    pub(crate) fn scan(
        &mut self,
        port: &Port,
        now: SimTime,
        up: &mut Line,
        (values, begun): (&[f64], SimTime),
        message: Message,
    ) -> Fate {
        if self.answer_at == Some(SimTime::NEVER) {
            self.answer_at = Some(now);
        }
        let Some(dialogue) = &port.dialogue else { return Fate::Unwanted };
        if !self.device.wants_scan(begun.as_ns()) {
            return Fate::Unwanted;
        }
        if now < self.scan_until {
            return Fate::Missed;
        }
        let mut bytes = Vec::new();
        let scan = Newest { begun_ns: begun.as_ns(), ranges_m: values };
        self.device.send_scan(&dialogue.description, scan, &mut bytes);
        let (from, until) = up.send_message(self.cable(port), now, &bytes, message);
        self.scan_until = until;
        Fate::Sent(OnWire { from, until, bytes: bytes.len() as u32 })
    }

    /// A message that is no scan has come to the laptop at `now`: `is_start` if it says that scans will come.
    pub(crate) fn drive(&mut self, port: &Port, now: SimTime, is_start: bool) -> Option<OnWire> {
        if is_start {
            self.driver_at = SimTime::NEVER;
        }
        let Format::Scip(format) = port.format else { return None };
        if self.driver_at == SimTime::NEVER {
            return None;
        }
        self.driver_at = now + DRIVER_NS;
        self.send_down(port, now, &measure(&format))
    }
}

/// The fate of a scan.
pub(crate) enum Fate {
    /// Nobody has asked for it.
    Unwanted,
    Missed,
    Sent(OnWire),
}

/// The bytes that [`DialogueState::run`] has put on the cable.
pub(crate) enum Said {
    Nothing,
    /// An answer that is no scan.
    Up(OnWire),
    /// A question of the driver's.
    Down(OnWire),
}

/// Bytes on the wire, as far as can be told now.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OnWire {
    pub(crate) from: SimTime,
    pub(crate) until: SimTime,
    pub(crate) bytes: u32,
}

/// Asks for scans of this format without an end.
fn measure(format: &scip::Format) -> Vec<u8> {
    let letter = match format.characters {
        scip::Characters::Two => 'S',
        scip::Characters::Three => 'D',
    };
    let scip::Format { first_step, last_step, cluster, .. } = format;
    alloc::format!("M{letter}{first_step:04}{last_step:04}{cluster:02}000\n").into_bytes()
}

/// Whether this message, of status 99, is a scan that another program has asked for: its head is not what the driver asks for.
pub(crate) fn is_foreign(format: &Format, message: &[u8]) -> bool {
    let Format::Scip(format) = format else { return false };
    let own = measure(format);
    message.get(..HEAD) != own.get(..HEAD) || message.get(HEAD + 2) != Some(&b'\n')
}

/// Characters of a command before the number of scans.
const HEAD: usize = 13;

/// The time for which the driver waits before it asks again, in nanoseconds: a guess.
const DRIVER_NS: u64 = 1_000_000_000;

/// Whether this message says that scans will come which its sender has asked for.
pub(crate) fn is_start(message: &[u8]) -> bool {
    message.first() == Some(&b'M') && scip::status(message) == Some(*b"00")
}

/// Most bytes of a message of such a device: a scan with intensities, and a margin for any other.
pub(crate) fn longest(description: &Description) -> usize {
    let characters = 6 * (usize::from(description.end_step()) + 1);
    characters + 2 * characters.div_ceil(64) + 512
}

/// Of each port, if it is a dialogue; nothing if none is.
pub(crate) type Dialogues = Box<[Option<DialogueState>]>;
