//! A toy world: cables with the arithmetic of UARTs, and simple machines at their far ends.

use std::collections::VecDeque;

use baudbot_program::{Cables, End, Error, LineSettings, ModemInputs, ModemOutputs, Parity, Session, State};

/// The time that a machine thinks, in nanoseconds.
pub(crate) const LATENCY_NS: u64 = 500_000;

/// The machine at the far end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Machine {
    /// It says nothing.
    Silent,
    /// It sends each byte back.
    Echo,
    /// It answers each line with `OK ` and the line.
    Lines,
    /// An iRobot Create, with 80 bytes for each query.
    Create,
    /// A servo of Dynamixel's protocol 1.
    Servo,
    /// It sends a line each 50 ms, 200 times.
    Stream,
}

/// Something that has happened at a port.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Event {
    /// The program has sent a byte: the instant is that of its end at the machine.
    Sent(u8),
    /// A byte has reached the program.
    Received(u8),
    /// The program has set its UART.
    Settings(LineSettings),
    /// The program has set its lines.
    Outputs(ModemOutputs),
    /// A break has begun or ended.
    Break(bool),
}

/// The world.
#[derive(Debug)]
pub(crate) struct Wire {
    now_ns: u64,
    cables: Vec<Cable>,
    /// Everything, with its instants and ports.
    pub(crate) log: Vec<(u64, usize, Event)>,
}

#[derive(Debug)]
struct Cable {
    machine: Machine,
    settings: LineSettings,
    inputs: ModemInputs,
    heard: Vec<u8>,
    sent_ns: u64,
    answered_ns: u64,
    to_machine: VecDeque<(u64, u8)>,
    to_program: VecDeque<(u64, u8)>,
}

impl Wire {
    /// A port for each machine.
    pub(crate) fn new(machines: &[Machine]) -> Self {
        let settings = LineSettings { baud: 9600, data_bits: 8, parity: Parity::None, stop_bits: 1 };
        let inputs = ModemInputs { cts: true, dsr: true, dcd: false, ri: false };
        let cable = |machine: &Machine| {
            let mut cable = Cable {
                machine: *machine,
                settings,
                inputs,
                heard: Vec::new(),
                sent_ns: 0,
                answered_ns: 0,
                to_machine: VecDeque::new(),
                to_program: VecDeque::new(),
            };
            if *machine == Machine::Stream {
                for line in 0..200 {
                    cable.answer(line * 50_000_000, format!("S{line:05}\n").as_bytes());
                }
            }
            cable
        };
        Self { now_ns: 0, cables: machines.iter().map(cable).collect(), log: Vec::new() }
    }

    /// The instant.
    pub(crate) fn now_ns(&self) -> u64 {
        self.now_ns
    }

    /// Runs a program to its end, or to an instant; none: it is there, or nothing can wake it any more.
    pub(crate) fn run(&mut self, session: &mut Session, limit_ns: u64) -> Result<Option<End>, Error> {
        loop {
            match session.run(self.now_ns, self)? {
                State::Ended(end) => return Ok(Some(end)),
                State::Waiting { until_ns } => {
                    if self.advance(until_ns.unwrap_or(u64::MAX).min(limit_ns)) >= limit_ns {
                        return Ok(None);
                    }
                }
            }
        }
    }

    /// Advances to an instant, or to the next one at which a byte reaches the program.
    fn advance(&mut self, to_ns: u64) -> u64 {
        loop {
            let next = |queue: &VecDeque<(u64, u8)>| queue.front().map_or(u64::MAX, |(at_ns, _)| *at_ns);
            let arrival = self.cables.iter().map(|cable| next(&cable.to_program)).min().unwrap_or(u64::MAX);
            let heard =
                self.cables.iter().enumerate().map(|(port, cable)| (next(&cable.to_machine), port)).min();
            match heard {
                Some((at_ns, port)) if at_ns <= arrival && at_ns <= to_ns => {
                    let (_, byte) = self.cables[port].to_machine.pop_front().expect("it has an instant");
                    self.log.push((at_ns, port, Event::Sent(byte)));
                    self.cables[port].hear(at_ns, byte);
                }
                _ => {
                    self.now_ns = self.now_ns.max(arrival.min(to_ns));
                    return self.now_ns;
                }
            }
        }
    }
}

impl Cable {
    fn hear(&mut self, at_ns: u64, byte: u8) {
        self.heard.push(byte);
        let at_ns = at_ns + LATENCY_NS;
        match self.machine {
            Machine::Silent | Machine::Stream => self.heard.clear(),
            Machine::Echo => self.answer(at_ns, &[byte]),
            Machine::Lines if byte == b'\n' => {
                let line = [b"OK ", &self.heard[..]].concat();
                self.heard.clear();
                self.answer(at_ns, &line);
            }
            Machine::Lines => {}
            Machine::Create => self.hear_create(at_ns),
            Machine::Servo => self.hear_servo(at_ns),
        }
    }

    fn hear_create(&mut self, at_ns: u64) {
        while let Some(first) = self.heard.first() {
            let length = match first {
                137 | 145 | 146 | 164 => 5,
                139 => 4,
                142 => 2,
                149 => self.heard.get(1).map_or(99, |count| 2 + usize::from(*count)),
                140 => self.heard.get(2).map_or(99, |count| 3 + 2 * usize::from(*count)),
                _ => 1,
            };
            if self.heard.len() < length {
                return;
            }
            if matches!(first, 142 | 149) {
                self.answer(at_ns, &std::array::from_fn::<u8, 80, _>(|byte| byte as u8));
            }
            self.heard.drain(..length);
        }
    }

    fn hear_servo(&mut self, at_ns: u64) {
        while self.heard.len() >= 4 && self.heard.len() >= 4 + usize::from(self.heard[3]) {
            let frame: Vec<u8> = self.heard.drain(..4 + usize::from(self.heard[3])).collect();
            let count = if frame[4] == 2 { frame[6] } else { 0 };
            let mut body = vec![frame[2], count + 2, 0];
            body.extend((0..count).map(|place| place * 7));
            let sum = body.iter().fold(0u8, |sum, byte| sum.wrapping_add(*byte));
            self.answer(at_ns, &[&[0xff, 0xff], &body[..], &[!sum]].concat());
        }
    }

    fn byte_ns(&self, count: u64) -> u64 {
        count * 10 * 1_000_000_000 / u64::from(self.settings.baud)
    }

    fn answer(&mut self, at_ns: u64, bytes: &[u8]) {
        let start_ns = at_ns.max(self.answered_ns);
        for (count, byte) in (1..).zip(bytes) {
            self.answered_ns = start_ns + self.byte_ns(count);
            self.to_program.push_back((self.answered_ns, *byte));
        }
    }
}

impl Cables for Wire {
    fn write(&mut self, port: usize, bytes: &[u8]) {
        let cable = &mut self.cables[port];
        let start_ns = self.now_ns.max(cable.sent_ns);
        for (count, byte) in (1..).zip(bytes) {
            cable.sent_ns = start_ns + cable.byte_ns(count);
            cable.to_machine.push_back((cable.sent_ns, *byte));
        }
    }

    fn take(&mut self, port: usize, into: &mut Vec<u8>) {
        while let Some((at_ns, byte)) = self.cables[port].to_program.front().copied() {
            if at_ns > self.now_ns {
                return;
            }
            self.cables[port].to_program.pop_front();
            self.log.push((at_ns, port, Event::Received(byte)));
            into.push(byte);
        }
    }

    fn sent_at_ns(&self, port: usize) -> u64 {
        self.cables[port].sent_ns
    }

    fn unsent(&self, port: usize) -> usize {
        self.cables[port].to_machine.iter().filter(|(at_ns, _)| *at_ns > self.now_ns).count()
    }

    fn configure(&mut self, port: usize, settings: LineSettings) {
        self.cables[port].settings = settings;
        self.log.push((self.now_ns, port, Event::Settings(settings)));
    }

    fn set_outputs(&mut self, port: usize, outputs: ModemOutputs) {
        self.log.push((self.now_ns, port, Event::Outputs(outputs)));
    }

    fn inputs(&self, port: usize) -> ModemInputs {
        self.cables[port].inputs
    }

    fn send_break(&mut self, port: usize, is_on: bool) {
        self.log.push((self.now_ns, port, Event::Break(is_on)));
    }

    fn discard_unsent(&mut self, port: usize) {
        let now_ns = self.now_ns;
        self.cables[port].to_machine.retain(|(at_ns, _)| *at_ns <= now_ns);
        self.cables[port].sent_ns = now_ns;
    }
}
