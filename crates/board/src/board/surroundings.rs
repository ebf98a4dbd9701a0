//! The reports between the chip and its parts.

use alloc::sync::Arc;
use alloc::vec::Vec;

use baudbot_avr as avr;
use baudbot_avr::{AnalogInput, Direction, Drive, Pin, Port, Pwm, Round, usart};
use serde::{Deserialize, Serialize};

use super::analyser::Fitted;
use super::pins::{Pins, Sides};
use crate::clock::ChipClock;
use crate::parts::{Change, Instant, Part, Remark, Signal};
use crate::physics::{PartId, Physics};
use crate::sent::{Queue, Sent};
use crate::warning::{WarningKind, Warnings};
use crate::wiring::{Net, Placed, Wiring};

/// The board without its chip.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Surroundings {
    pub(crate) wiring: Arc<Wiring>,
    pub(crate) clock: ChipClock,
    pub(crate) parts: Vec<Part>,
    pub(crate) warnings: Warnings,
    pub(crate) sent: Queue,
    pins: Pins,
    supply_uv: u32,
    /// The part that was addressed on the I²C bus.
    addressed: Option<PartId>,
    #[serde(skip)]
    pub(super) analyser: Fitted,
}

impl Surroundings {
    pub(crate) fn new(wiring: Wiring, clock: ChipClock, supply_uv: u32) -> Self {
        let mut parts: Vec<Part> = wiring.parts().map(|(_, placed)| Part::new(placed.kind())).collect();
        let start = Instant { cycle: 0, clock: &clock };
        for (terminal, net) in wiring.wires() {
            let drive = match net {
                Net::Ground => Drive::Low,
                Net::Supply => Drive::High,
                Net::Pin(_) | Net::AnalogOnly(_) => continue,
            };
            if let Some(part) = parts.get_mut(terminal.part.index()) {
                part.hear(terminal.role, Signal::Steady(drive), start);
            }
        }
        Self {
            wiring: Arc::new(wiring),
            clock,
            parts,
            warnings: Warnings::default(),
            sent: Queue::default(),
            pins: Pins::new(),
            supply_uv,
            addressed: None,
            analyser: Fitted::default(),
        }
    }

    pub(crate) const fn supply_uv(&self) -> u32 {
        self.supply_uv
    }

    /// Whether a chip can have these surroundings at an instant.
    pub(crate) fn are_possible(&self, now: u64) -> bool {
        let now = Instant { cycle: now, clock: &self.clock };
        let fits = |(part, (_, placed)): (&Part, (PartId, &Placed))| part.is_possible(placed.kind(), now);
        let known = |part: PartId| part.index() < self.parts.len();
        self.parts.len() == self.wiring.parts().count()
            && self.parts.iter().zip(self.wiring.parts()).all(fits)
            && self.addressed.is_none_or(known)
            && self.pins.is_possible()
            && self.sent.is_possible()
            && self.warnings.list().iter().all(|warning| warning.part.is_none_or(known))
    }

    pub(crate) fn reaction_ns(&self) -> u64 {
        self.parts.iter().map(Part::reaction_ns).min().unwrap_or(u64::MAX)
    }

    pub(crate) fn begin<P: Physics>(&mut self, at_ns: u64, physics: &mut P) {
        for (id, part) in (0..).map(PartId).zip(&mut self.parts) {
            part.begin(id, at_ns, physics);
        }
    }

    pub(crate) fn prepare<P: Physics>(&mut self, until: u64, physics: &mut P) {
        let until = Instant { cycle: until, clock: &self.clock };
        for (id, part) in (0..).map(PartId).zip(&mut self.parts) {
            part.prepare(id, until, physics);
        }
    }

    pub(crate) fn changes(&self) -> impl Iterator<Item = (PartId, Change)> {
        let next =
            |(id, part): (u16, &Part)| part.next_change(&self.clock).map(|change| (PartId(id), change));
        (0..).zip(&self.parts).filter_map(next)
    }

    pub(super) const fn sides(&mut self, pin: Pin) -> Sides {
        *self.pins.of(pin)
    }

    /// The analyser notes what has happened up to a cycle.
    pub(crate) fn settle(&mut self, now: u64) {
        if let Some(analyser) = &mut self.analyser.0 {
            analyser.settle(now, &self.clock);
        }
    }

    pub(crate) fn change_taken(&mut self, part: PartId, pin: Option<Pin>, change: Change, now: u64) {
        if let Some(pin) = pin {
            self.pins.of(pin).part = change.external;
            if let Some(analyser) = &mut self.analyser.0 {
                analyser.part(pin, change.external, change.at.max(now));
            }
        }
        if let Some(part) = self.parts.get_mut(part.index()) {
            part.change_taken(&self.clock);
        }
    }

    pub(crate) fn next_event(&self) -> Option<u64> {
        self.parts.iter().filter_map(|part| part.next_event(&self.clock)).min()
    }

    pub(crate) fn finish(&mut self, now: u64) {
        for part in &mut self.parts {
            part.finish(now);
        }
    }

    fn tell(&mut self, pin: Pin, signal: Signal, at: u64) {
        let at = Instant { cycle: at, clock: &self.clock };
        for terminal in self.wiring.on(pin) {
            let Some(part) = self.parts.get_mut(terminal.part.index()) else { continue };
            let kind = match part.hear(terminal.role, signal, at) {
                None => continue,
                Some(Remark::ShortTrigger) => WarningKind::ShortTrigger,
                Some(Remark::WeakTrigger) => WarningKind::WeakTrigger,
                Some(Remark::OddServoPulse) => WarningKind::OddServoPulse,
            };
            self.warnings.add(kind, Some(pin), Some(terminal.part), at.ns(), 1);
        }
    }

    /// Warns of pins that a part has shorted. The chip itself reports only its own.
    pub(crate) fn look_for_shorts(&mut self, now: u64) {
        for pin in self.pins.new_shorts() {
            self.warn(avr::Warning::Contention { pin }, now);
        }
    }

    /// Warns of a pin that has become an output although a voltage is on it.
    fn look_for_voltage(&mut self, pin: Pin, at: u64) {
        let part = self.wiring.driver(pin);
        if let Some(Part::Voltage(_)) = part.and_then(|part| self.parts.get(part.index())) {
            self.warnings.add(WarningKind::AgainstVoltage, Some(pin), part, self.clock.ns(at), 1);
        }
    }

    /// The voltage of a digital signal, in microvolts.
    fn digital(&mut self, pin: Option<Pin>, at: u64) -> u32 {
        let level = pin.and_then(|pin| self.pins.of(pin).level());
        if level.is_none() {
            self.warnings.add(WarningKind::OpenAdcInput, pin, None, self.clock.ns(at), 1);
        }
        if level == Some(true) { self.supply_uv } else { 0 }
    }

    fn warn(&mut self, warning: avr::Warning, at: u64) {
        let (kind, pin) = match warning {
            avr::Warning::FloatingInput { pin } => (WarningKind::FloatingInput, Some(pin)),
            avr::Warning::Contention { pin } => {
                self.pins.note_short(pin);
                (WarningKind::Short, Some(pin))
            }
            avr::Warning::IllegalInstruction { .. } => (WarningKind::IllegalInstruction, None),
            avr::Warning::BeyondMemory { .. } => (WarningKind::BeyondMemory, None),
            avr::Warning::StackLow { .. } => (WarningKind::StackOverflow, None),
            avr::Warning::Unsupported(what) => (WarningKind::Unsupported(what), None),
            avr::Warning::Overrun => (WarningKind::Overrun, None),
        };
        let part = pin.and_then(|pin| self.wiring.driver(pin));
        let kind = match part.and_then(|part| self.parts.get(part.index())) {
            // The sensor has a resistor, and holds the wire only while its capacitor is charged.
            Some(Part::Reflectance(_)) => return,
            // An open switch holds the wire by a resistor only.
            Some(Part::Switch(switch))
                if kind == WarningKind::Short
                    && pin.is_some_and(|pin| self.pins.of(pin).part == switch.by_resistor()) =>
            {
                return;
            }
            // Between its pulses the sensor holds its wire weakly.
            Some(Part::Sonar(_)) if kind == WarningKind::FloatingInput => return,
            Some(Part::Voltage(_)) if kind == WarningKind::FloatingInput => WarningKind::DigitalReadOfVoltage,
            _ => kind,
        };
        self.warnings.add(kind, pin, part, self.clock.ns(at), 1);
    }
}

/// The surroundings and the world, as the chip sees them in a run.
pub(crate) struct View<'a, P> {
    pub(crate) around: &'a mut Surroundings,
    pub(crate) physics: &'a mut P,
}

impl<P: Physics> View<'_, P> {
    fn channel(&mut self, channel: u8, at: u64) -> u32 {
        let around = &mut *self.around;
        let source = around.wiring.voltage_on(channel);
        match source.map(|id| (id, around.parts.get(id.index()))) {
            Some((id, Some(Part::Voltage(voltage)))) => {
                let volts = self.physics.volts(id, around.clock.ns(at));
                voltage.microvolts(volts, around.supply_uv)
            }
            _ => around.digital(Pin::new(Port::C, channel).filter(|pin| pin.bit() < 6), at),
        }
    }

    /// 314 mV at 25 °C, 1 mV for each degree: data sheet, table *Temperature vs. Sensor Output Voltage*.
    fn temperature(&mut self, at: u64) -> u32 {
        let celsius = self.physics.celsius(self.around.clock.ns(at));
        libm::round(314_000.0 + (celsius - 25.0) * 1000.0) as u32
    }

    fn addressed(&mut self) -> Option<(PartId, &mut Part)> {
        let id = self.around.addressed?;
        self.around.parts.get_mut(id.index()).map(|part| (id, part))
    }
}

impl<P: Physics> avr::Board for View<'_, P> {
    fn pin_changed(&mut self, pin: Pin, drive: Drive, at: u64) {
        let before = core::mem::replace(&mut self.around.pins.of(pin).chip, drive);
        if drive.is_output() && !before.is_output() {
            self.around.look_for_voltage(pin, at);
        }
        if let Some(analyser) = &mut self.around.analyser.0 {
            analyser.chip(pin, drive, at);
        }
        self.around.tell(pin, Signal::Steady(drive), at);
    }

    fn pwm_changed(&mut self, pin: Pin, pwm: Option<Pwm>, at: u64) {
        // The steady level follows at the end of the signal.
        if let Some(pwm) = pwm {
            if let Some(analyser) = &mut self.around.analyser.0 {
                analyser.shape(pin, pwm, at);
            }
            self.around.tell(pin, Signal::Pwm(pwm), at);
        }
    }

    fn analog_microvolts(&mut self, input: AnalogInput, at: u64) -> u32 {
        match input {
            AnalogInput::Channel(channel) => self.channel(channel, at),
            AnalogInput::Temperature => self.temperature(at),
            AnalogInput::Positive => self.around.digital(Pin::new(Port::D, 6), at),
            AnalogInput::Negative => self.around.digital(Pin::new(Port::D, 7), at),
        }
    }

    fn converted(&mut self, channel: u8, result: u16, at: u64) {
        if let Some(analyser) = &mut self.around.analyser.0 {
            analyser.converted(channel, result, at);
        }
    }

    fn round_begins(&mut self, at: u64, last: Round) {
        if let Some(analyser) = &mut self.around.analyser.0 {
            analyser.round(at, last);
        }
    }

    fn character_sent(&mut self, sent: &usart::Sent) {
        if let Some(analyser) = &mut self.around.analyser.0 {
            analyser.sends(sent.frame, sent.start, sent.bit);
        }
        let clock = self.around.clock;
        let sent = Sent { frame: sent.frame, start_ns: clock.ns(sent.start), end_ns: clock.ns(sent.end()) };
        if !self.around.sent.push(sent) {
            self.around.warnings.add(WarningKind::SentLost, None, None, sent.start_ns, 1);
        }
    }

    fn twi_address(&mut self, address: u8, direction: Direction, at: u64) -> bool {
        self.around.addressed = self.around.wiring.at_bus_address(address);
        let acknowledged = self.addressed().is_some_and(|(_, part)| part.bus_address(direction, at));
        if !acknowledged {
            self.around.addressed = None;
        }
        acknowledged
    }

    fn twi_write(&mut self, byte: u8, at: u64) -> bool {
        let Some(id) = self.around.addressed else { return false };
        let at = Instant { cycle: at, clock: &self.around.clock };
        let part = self.around.parts.get_mut(id.index());
        part.is_some_and(|part| part.bus_write(id, byte, at, self.physics))
    }

    fn twi_read(&mut self, _last: bool, at: u64) -> u8 {
        self.addressed().map_or(0xFF, |(_, part)| part.bus_read(at))
    }

    fn twi_stop(&mut self, _at: u64) {
        self.around.addressed = None;
    }

    fn warn(&mut self, warning: avr::Warning, at: u64) {
        self.around.warn(warning, at);
    }
}
