//! The memory of a device, and the effect of commands on it.

use serde::{Deserialize, Serialize};

use super::command::{Command, Commands, Kind, MAX_LINE, Scans, Status, Steps};
use super::reply::{Reply, ScanLayout};
use super::{Description, Model, REBOOT_WITHIN_NS, Rate};
use crate::buffer::Buffer;

/// A device's side of the protocol. All its times are nanoseconds of one clock, which only goes on.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Device {
    commands: Commands,
    mode: Mode,
    /// The instant at which its own clock was 0.
    clock_zero_ns: u64,
    /// Since when the laser is lit, if it is.
    lit_ns: u64,
    /// The instant until which a second `RB` counts; 0 if there was no first.
    reboot_until_ns: u64,
}

#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
enum Mode {
    /// The laser is off.
    #[default]
    Standby,
    /// The laser is lit, and scans are sent when asked for.
    Lit,
    /// Scans are sent by themselves.
    Measuring(Measuring),
    /// Time mode.
    Adjusting,
    Asleep,
}

/// Scans that were asked for.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Measuring {
    scans: Scans,
    steps: Steps,
    /// Scans left out between two.
    interval: u8,
    /// Scans still to be left out before the next.
    skip: u8,
    /// Scans to be sent; 0 without an end.
    left: u8,
    /// The command, which is the head of each scan, but for the last two digits of its parameters.
    head: Buffer<MAX_LINE>,
}

/// The answer to a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// No command waits for an answer.
    Nothing,
    /// The answer comes with the next scan: to be asked again when there is one.
    Later,
    /// The answer was written.
    Written(Effect),
}

/// The effect behind an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// The command has no effect outside of the device.
    None,
    /// The cable has this rate behind the answer, in bits a second, one of [`RATES`](super::RATES).
    Rate(u32),
    /// The cable has the rate of power-on behind the answer.
    FirstRate,
}

/// The newest scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Newest<'a> {
    /// The instant at which it began, in nanoseconds.
    pub begun_ns: u64,
    /// Distances from [`Description::first_step`] on, in metres; negative where there was no measurement.
    pub ranges_m: &'a [f64],
}

impl Device {
    /// A device that was switched on at 0.
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes a byte. If it ends a command, that waits for its [`answer`](Self::answer), and no other byte may be given to the
    /// device before.
    pub fn push(&mut self, byte: u8) -> bool {
        self.commands.push(byte)
    }

    /// Whether the device could have come to this by `now_ns`.
    pub fn is_sound(&self, now_ns: u64) -> bool {
        let steps = match &self.mode {
            Mode::Measuring(measuring) => {
                measuring.steps.first <= measuring.steps.last
                    && measuring.steps.last <= 9999
                    && measuring.interval < 10
                    && measuring.skip < 10
                    && measuring.head.len() >= HEAD_END
            }
            Mode::Standby | Mode::Lit | Mode::Adjusting | Mode::Asleep => true,
        };
        steps && self.clock_zero_ns <= now_ns && self.lit_ns <= now_ns
    }

    /// Answers the command that has come.
    pub fn answer(
        &mut self,
        facts: &Description,
        rate: Rate,
        now_ns: u64,
        newest: Option<Newest<'_>>,
        out: &mut impl Extend<u8>,
    ) -> Answer {
        if self.commands.line().is_empty() {
            return Answer::Nothing;
        }
        let command = self.commands.parse(facts).and_then(|command| self.check(&command, facts, rate));
        let newest = newest.filter(|newest| newest.begun_ns >= self.lit_ns);
        let is_get = matches!(command, Ok(Command { kind: Kind::Get(_), .. }));
        if is_get && newest.is_none() {
            return Answer::Later;
        }
        let line = core::mem::take(&mut self.commands);
        let mut reply = Reply::new(out);
        reply.echo(line.line());
        let effect = match command {
            Ok(command) => self.obey(&command, (facts, rate, now_ns), newest, (line.line(), &mut reply)),
            Err(status) => {
                reply.status(status);
                Effect::None
            }
        };
        reply.end();
        Answer::Written(effect)
    }

    /// A scan that began at `begun_ns` is there: whether the device wants to send it. To be asked once a scan.
    pub fn wants_scan(&mut self, begun_ns: u64) -> bool {
        let Mode::Measuring(measuring) = &mut self.mode else { return false };
        if begun_ns < self.lit_ns {
            return false;
        }
        if measuring.skip > 0 {
            measuring.skip -= 1;
            return false;
        }
        true
    }

    /// Writes a scan that the device [wants to send](Self::wants_scan).
    pub fn send_scan(&mut self, facts: &Description, scan: Newest<'_>, out: &mut impl Extend<u8>) {
        let Mode::Measuring(measuring) = &mut self.mode else { return };
        let is_last = measuring.left == 1;
        measuring.left = measuring.left.saturating_sub(1);
        measuring.skip = measuring.interval;
        let mut reply = Reply::new(out);
        reply.echo_of_scan(measuring.head.used(), measuring.left);
        reply.status(*b"99");
        let layout = ScanLayout { scans: measuring.scans, steps: measuring.steps };
        let time_ms = clock_ms(scan.begun_ns, self.clock_zero_ns);
        reply.scan(facts, layout, time_ms, scan.ranges_m);
        reply.end();
        if is_last {
            self.mode = Mode::Lit;
        }
    }

    /// Whether it can be obeyed now.
    fn check(&self, command: &Command, facts: &Description, rate: Rate) -> Result<Command, Status> {
        let always = matches!(
            command.kind,
            Kind::Tm | Kind::Vv | Kind::Ii | Kind::Rs | Kind::Rt | Kind::Rb | Kind::St
        );
        let is_ust = facts.model == Model::Ust10lx;
        match (&self.mode, command.kind) {
            (Mode::Adjusting, _) if !always => Err(*b"0E"),
            (_, Kind::Get(_)) => match self.mode {
                Mode::Lit => Ok(*command),
                Mode::Measuring(_) if !is_ust => Ok(*command),
                Mode::Measuring(_) | Mode::Standby | Mode::Adjusting | Mode::Asleep => Err(*b"10"),
            },
            (Mode::Asleep, Kind::Bm | Kind::Measure(_)) => Err(*b"10"),
            (Mode::Lit | Mode::Measuring(_), Kind::Bm) => Err(*b"02"),
            (Mode::Adjusting, Kind::Tm) if command.number == 0 => Err(*b"02"),
            (Mode::Lit | Mode::Measuring(_), Kind::Tm) if command.number == 0 && is_ust => Err(*b"10"),
            (Mode::Adjusting, Kind::Tm) => Ok(*command),
            (_, Kind::Tm) if command.number == 1 => Err(*b"04"),
            (_, Kind::Tm) if command.number == 2 => Err(*b"03"),
            (_, Kind::Ss) if rate.is_some_and(|rate| rate.get() == command.number) => Err(*b"03"),
            _ => Ok(*command),
        }
    }

    fn obey<E: Extend<u8>>(
        &mut self,
        command: &Command,
        (facts, rate, now_ns): (&Description, Rate, u64),
        newest: Option<Newest<'_>>,
        (line, reply): (&[u8], &mut Reply<'_, E>),
    ) -> Effect {
        let mut effect = Effect::None;
        if command.kind != Kind::Rb {
            reply.status(*b"00");
        }
        match command.kind {
            Kind::Vv => reply.versions(facts),
            Kind::Pp => reply.parameters(facts),
            Kind::Ii => {
                let time_ms = clock_ms(now_ns, self.clock_zero_ns);
                reply.information(facts, rate, time_ms, self.is_lit());
            }
            Kind::Bm => self.light(now_ns),
            Kind::Qt => self.mode = Mode::Standby,
            Kind::Rs | Kind::Rt => {
                self.restart(now_ns);
                effect = if command.kind == Kind::Rs { Effect::FirstRate } else { Effect::None };
            }
            Kind::Rb => effect = self.reboot(now_ns, reply),
            Kind::Tm if command.number == 1 => reply.time(clock_ms(now_ns, self.clock_zero_ns)),
            Kind::Tm => self.mode = if command.number == 0 { Mode::Adjusting } else { Mode::Standby },
            Kind::Ss => effect = if rate.is_some() { Effect::Rate(command.number) } else { Effect::None },
            Kind::St => reply.state(self.state()),
            Kind::Sl => self.mode = Mode::Asleep,
            Kind::Get(scans) => {
                let Some(newest) = newest else { return effect };
                let time_ms = clock_ms(newest.begun_ns, self.clock_zero_ns);
                reply.scan(facts, ScanLayout { scans, steps: command.steps }, time_ms, newest.ranges_m);
            }
            Kind::Measure(scans) => self.measure(scans, command, line, now_ns),
        }
        effect
    }

    /// Lights the laser, if it is not lit. The mirror turns already.
    fn light(&mut self, now_ns: u64) {
        if !self.is_lit() {
            self.lit_ns = now_ns;
            self.mode = Mode::Lit;
        }
    }

    /// A measurement that is under way gives way to the new one: a guess.
    fn measure(&mut self, scans: Scans, command: &Command, line: &[u8], now_ns: u64) {
        self.light(now_ns);
        let mut head = Buffer::new();
        line.iter().for_each(|&byte| {
            head.push(byte);
        });
        self.mode = Mode::Measuring(Measuring {
            scans,
            steps: command.steps,
            interval: command.number as u8,
            skip: 0,
            left: command.scans,
            head,
        });
    }

    fn restart(&mut self, now_ns: u64) {
        self.mode = Mode::Standby;
        self.clock_zero_ns = now_ns;
        self.reboot_until_ns = 0;
    }

    fn reboot<E: Extend<u8>>(&mut self, now_ns: u64, reply: &mut Reply<'_, E>) -> Effect {
        if now_ns < self.reboot_until_ns {
            reply.status(*b"00");
            self.restart(now_ns);
            return Effect::FirstRate;
        }
        reply.status(*b"01");
        self.reboot_until_ns = now_ns.saturating_add(REBOOT_WITHIN_NS);
        Effect::None
    }

    const fn is_lit(&self) -> bool {
        match self.mode {
            Mode::Lit | Mode::Measuring(_) => true,
            Mode::Standby | Mode::Adjusting | Mode::Asleep => false,
        }
    }

    /// In the three digits of `%ST`.
    const fn state(&self) -> [u8; 3] {
        match self.mode {
            Mode::Standby => *b"000",
            Mode::Adjusting => *b"002",
            Mode::Lit => *b"003",
            Mode::Measuring(_) => *b"004",
            Mode::Asleep => *b"005",
        }
    }
}

/// The device's own clock in milliseconds, in its 24 bits.
const fn clock_ms(at_ns: u64, zero_ns: u64) -> u32 {
    ((at_ns.saturating_sub(zero_ns) / 1_000_000) & 0xff_ffff) as u32
}

/// Characters of `MD` and its parameters.
pub(super) const HEAD_END: usize = 15;
