//! Acts of a program, and a wiring's faults, that are hardly meant.

use alloc::format;
use alloc::string::{String, ToString};

use arrayvec::ArrayVec;
use baudbot_avr::{Pin, Unsupported};
use serde::{Deserialize, Serialize};

use crate::physics::PartId;
use crate::role::Role;
use crate::wiring::{Net, Terminal, Wiring};

/// Warnings that differ.
const ROOM: usize = 48;

/// A suspicious act or wiring.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum WarningKind {
    /// An input is read that nothing drives and that has no pull-up.
    FloatingInput,
    /// The voltage of an analog part is read as a digital input, which sees nothing of it.
    DigitalReadOfVoltage,
    /// The chip drives a pin against a part: a short circuit.
    Short,
    /// The ADC measures a pin on which there is no voltage and no digital signal.
    OpenAdcInput,
    /// A trigger pulse is too short for the sensor, which does nothing.
    ShortTrigger,
    /// A pulse for a servo is not between 500 µs and 2500 µs; the servo ignores it.
    OddServoPulse,
    /// A character came while the receiver was off.
    ReceiverOff,
    /// A character came while the receiver's buffer was full.
    Overrun,
    /// Characters were sent and not taken from the board; they are lost.
    SentLost,
    /// Characters are sent at another rate than the other end reads, so that it cannot read them.
    OtherRate,
    /// A word that is no instruction was executed.
    IllegalInstruction,
    /// Data beyond the memory were read or written.
    BeyondMemory,
    /// The stack has grown into the variables.
    StackOverflow,
    /// `BREAK` was executed, for which only a debugger stops.
    Break,
    /// The watchdog has reset the chip.
    WatchdogReset,
    /// The program switched something on that is not simulated.
    Unsupported(Unsupported),
    /// The chip drives a pin on which the voltage of an analog part is.
    AgainstVoltage,
    /// A trigger pulse is shorter than the sensor's data sheet promises to be enough; the sensor obeys it.
    WeakTrigger,
}

impl core::fmt::Display for WarningKind {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::FloatingInput => "an input is read that nothing drives and that has no pull-up",
            Self::DigitalReadOfVoltage => "a voltage is read as a digital input, which cannot measure it",
            Self::Short => "an output drives against another one: a short circuit",
            Self::OpenAdcInput => "the ADC measures a pin that is not connected",
            Self::ShortTrigger => "a trigger pulse is too short for the sensor, which ignores it",
            Self::OddServoPulse => "a pulse is not between 500 and 2500 µs, and the servo ignores it",
            Self::ReceiverOff => "a character came while the UART's receiver was off",
            Self::Overrun => "a character came while the receiver's buffer was full, and was lost",
            Self::SentLost => "characters were sent faster than they could be taken, and were lost",
            Self::OtherRate => "characters are sent at a baud rate at which the laptop's end does not read",
            Self::IllegalInstruction => "a word was executed that is not an instruction",
            Self::BeyondMemory => "data beyond the memory were read or written",
            Self::StackOverflow => "the stack has grown into the variables",
            Self::Break => "BREAK was executed, for which only a debugger stops",
            Self::WatchdogReset => "the watchdog has reset the chip",
            Self::AgainstVoltage => "an output drives against a voltage",
            Self::WeakTrigger => {
                "a trigger pulse is shorter than the data sheet requires; the sensor accepts it, as real ones do"
            }
            Self::Unsupported(what) => return write!(f, "the program uses a feature that is not simulated: {what}"),
        })
    }
}

/// Something suspicious, and how often it happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Warning {
    /// The kind of warning.
    pub kind: WarningKind,
    /// The pin of the warning.
    pub pin: Option<Pin>,
    /// The part of the warning.
    pub part: Option<PartId>,
    /// The instant at which it happened first.
    pub first_ns: u64,
    /// The number of times. Floating inputs are reported once for each pin until a reset.
    pub count: u64,
}

impl Warning {
    /// The pin as it is printed on an Arduino; empty if there is none.
    pub fn printed_pin(&self) -> String {
        self.pin.map(|pin| Net::Pin(pin).printed()).unwrap_or_default()
    }

    /// The warning in words for people who wired the board and wrote the program.
    pub fn explain(&self, wiring: &Wiring) -> String {
        let Some(terminal) = self.terminal(wiring) else { return self.kind.to_string() };
        let name = wiring.name(terminal.part);
        let name =
            name.strip_prefix("sensors.").map_or_else(|| name.to_string(), |name| format!("the {name}"));
        let of_one = wiring.terminal_name(terminal) == wiring.name(terminal.part);
        let wired = if of_one { name } else { format!("{name}'s {}", terminal.role) };
        if self.kind != WarningKind::Short {
            return format!("wired to {wired}: {}", self.kind);
        }
        let question =
            if terminal.role == Role::Echo { "; are trigger and echo swapped?" } else { ": a short circuit" };
        format!("wired to {wired}, which drives it, and the sketch drives it too{question}")
    }

    /// The terminal that it is about.
    fn terminal(&self, wiring: &Wiring) -> Option<Terminal> {
        let (pin, part) = (self.pin?, self.part?);
        wiring.on(pin).find(|terminal| terminal.part == part)
    }
}

/// A bounded list of warnings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Warnings {
    list: ArrayVec<Warning, ROOM>,
}

impl Warnings {
    pub(crate) fn add(
        &mut self,
        kind: WarningKind,
        pin: Option<Pin>,
        part: Option<PartId>,
        at_ns: u64,
        count: u64,
    ) {
        let same = |known: &&mut Warning| (known.kind, known.pin, known.part) == (kind, pin, part);
        if let Some(known) = self.list.iter_mut().find(same) {
            known.count = known.count.saturating_add(count);
        } else {
            // Warnings of more kinds than there is room for are dropped.
            let _ = self.list.try_push(Warning { kind, pin, part, first_ns: at_ns, count });
        }
    }

    pub(crate) fn list(&self) -> &[Warning] {
        &self.list
    }
}
