//! The commands of the Khepera other than `N` and `D`: each sets registers of the robot, or asks for some.
//!
//! The numbers of a line go into the registers of its command in order, and an answer tells registers in order. Nothing
//! here knows the effect of a register; the crate that has the robot binds them.
//!
//! Sources. The commands, their parameters and units are those of appendix A of K-Team's manual (version 5), as kMatlab
//! (K-Team, 1999) and RoadNarrows' Khepera package use them. The refusals are in a session of kMatlab's and in KiKS,
//! which plays the robot; the versions are in K-Team's FAQ of the Khepera II.

use super::{ANSWER_END, LineError};
use crate::error::WriteError;
use crate::lines::{Writer, field, number};

/// The answer to a line that begins with no command.
pub const NOT_FOUND: &[u8] = b"Command not found\r\n";

/// The answer to a line whose numbers are not those of its command, or that wants a part that the robot lacks.
pub const PROTOCOL_ERROR: &[u8] = b"z,Protocol error\r\n";

/// A wheel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names say it")]
pub enum Side {
    Left,
    Right,
}

/// A gain of a PID regulator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names say it")]
pub enum Gain {
    Proportional,
    Integral,
    Derivative,
}

/// A number on the robot that a command sets or asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Register {
    /// Gain of the speed regulator.
    SpeedGain(Gain),
    /// Gain of the position regulator.
    PositionGain(Gain),
    /// Position that a wheel is to reach, in pulses.
    Target(Side),
    /// Measured speed of a wheel, in pulses per 10 ms.
    Speed(Side),
    /// Position counter of a wheel, in pulses.
    Position(Side),
    /// The number of the analog input.
    InputNumber,
    /// The reading of the analog input, 10 bits.
    Input,
    /// Largest speed on the way to a target, in pulses per 10 ms.
    ProfileSpeed(Side),
    /// Acceleration on the way to a target, in 1/256 pulse per (10 ms)².
    ProfileAcceleration(Side),
    /// 1 if the wheel is where it should be, or as fast as it should be.
    Reached(Side),
    /// 0 if the position of the wheel is controlled, 1 if its speed is.
    Mode(Side),
    /// The error to the target in pulses, or to the speed in pulses per 10 ms.
    Error(Side),
    /// The number of the LED.
    LedNumber,
    /// The action: 0 off, 1 on, 2 the other.
    LedAction,
    /// Ambient light at the n-th infra-red sensor, 10 bits, lower where it is brighter.
    Ambient(u8),
    /// Share of the supply voltage on a motor, in 1/255, negative backwards.
    PulseWidth(Side),
    /// Address on the extension bus.
    BusAddress,
    /// The byte on the extension bus.
    BusByte,
    /// The turret.
    Turret,
}

impl Register {
    /// The least and the greatest number that a line may set it to.
    pub const fn range(self) -> [i64; 2] {
        match self {
            Self::SpeedGain(_) | Self::PositionGain(_) => [0, u16::MAX as i64],
            Self::Target(_) => [-FARTHEST, FARTHEST],
            Self::Speed(_) => [-127, 127],
            Self::Position(_) | Self::Error(_) => [i32::MIN as i64, i32::MAX as i64],
            Self::InputNumber => [0, 5],
            Self::Input | Self::Ambient(_) => [0, 1023],
            Self::ProfileSpeed(_) => [1, 127],
            Self::ProfileAcceleration(_) => [1, 255],
            Self::PulseWidth(_) => [-255, 255],
            Self::Reached(_) | Self::Mode(_) | Self::LedNumber => [0, 1],
            Self::LedAction => [0, 2],
            Self::BusAddress => [0, 63],
            Self::BusByte => [0, 255],
            Self::Turret => [0, 31],
        }
    }
}

/// A command, but for `N` and `D`, in the order of the alphabet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "what each sets and tells is in `registers`")]
pub enum Command {
    SpeedGains,
    Version,
    Move,
    Speed,
    PositionGains,
    SetPosition,
    Position,
    Input,
    Profile,
    Status,
    Led,
    Ambient,
    PulseWidth,
    ReadBus,
    Turret,
    WriteBus,
}

impl Command {
    /// All commands.
    pub const ALL: [Self; 16] = [
        Self::SpeedGains,
        Self::Version,
        Self::Move,
        Self::Speed,
        Self::PositionGains,
        Self::SetPosition,
        Self::Position,
        Self::Input,
        Self::Profile,
        Self::Status,
        Self::Led,
        Self::Ambient,
        Self::PulseWidth,
        Self::ReadBus,
        Self::Turret,
        Self::WriteBus,
    ];

    /// The command of a capital letter.
    pub fn of(letter: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|command| command.letter() == letter)
    }

    /// The capital letter that it begins with.
    pub const fn letter(self) -> u8 {
        match self {
            Self::SpeedGains => b'A',
            Self::Version => b'B',
            Self::Move => b'C',
            Self::Speed => b'E',
            Self::PositionGains => b'F',
            Self::SetPosition => b'G',
            Self::Position => b'H',
            Self::Input => b'I',
            Self::Profile => b'J',
            Self::Status => b'K',
            Self::Led => b'L',
            Self::Ambient => b'O',
            Self::PulseWidth => b'P',
            Self::ReadBus => b'R',
            Self::Turret => b'T',
            Self::WriteBus => b'W',
        }
    }

    /// The registers that a line sets, and those that its answer tells.
    pub const fn registers(self) -> (&'static [Register], &'static [Register]) {
        use Gain::{Derivative, Integral, Proportional};
        use Register as R;
        use Side::{Left, Right};
        match self {
            Self::SpeedGains => {
                (&[R::SpeedGain(Proportional), R::SpeedGain(Integral), R::SpeedGain(Derivative)], &[])
            }
            Self::Version => (&[], &[]),
            Self::Move => (&[R::Target(Left), R::Target(Right)], &[]),
            Self::Speed => (&[], &[R::Speed(Left), R::Speed(Right)]),
            Self::PositionGains => (
                &[R::PositionGain(Proportional), R::PositionGain(Integral), R::PositionGain(Derivative)],
                &[],
            ),
            Self::SetPosition => (&[R::Position(Left), R::Position(Right)], &[]),
            Self::Position => (&[], &[R::Position(Left), R::Position(Right)]),
            Self::Input => (&[R::InputNumber], &[R::Input]),
            Self::Profile => (&PROFILE, &[]),
            Self::Status => (&[], &STATUS),
            Self::Led => (&[R::LedNumber, R::LedAction], &[]),
            Self::Ambient => (&[], &AMBIENT),
            Self::PulseWidth => (&[R::PulseWidth(Left), R::PulseWidth(Right)], &[]),
            Self::ReadBus => (&[R::BusAddress], &[R::BusByte]),
            Self::Turret => (&[R::Turret], &[]),
            Self::WriteBus => (&[R::BusByte, R::BusAddress], &[]),
        }
    }

    /// Whether `text`, which stands behind the small letter of an answer, is what this command's answer has there.
    pub(super) fn check_answer(self, text: &[u8]) -> Result<(), LineError> {
        if self == Self::Version {
            return if text.starts_with(b",") {
                Ok(())
            } else {
                Err(LineError::Count { expected: 2, found: 0 })
            };
        }
        let (_, tells) = self.registers();
        let (mut rest, mut found) = (text, 0);
        while let Some((digits, behind)) = field(rest) {
            number(digits).ok_or(LineError::Number { index: found })?;
            (rest, found) = (behind, found + 1);
        }
        let fits = found == tells.len() || (self == Self::Ambient && (1..tells.len()).contains(&found));
        if fits && rest.is_empty() { Ok(()) } else { Err(LineError::Count { expected: tells.len(), found }) }
    }
}

/// A line that was understood: a command, and what it sets its registers to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Access {
    /// The command.
    pub command: Command,
    values: [i32; MOST_SET],
}

impl Access {
    /// The meaning of a line.
    ///
    /// # Errors
    /// An error if the line does not fit the command. Nothing of such a line should be used.
    pub fn parse(line: &[u8]) -> Result<Self, LineError> {
        let (&found, text) = line.split_first().ok_or(LineError::Empty)?;
        let command = Command::of(found).ok_or(LineError::Letter { found })?;
        let (sets, _) = command.registers();
        let (mut rest, mut values) = (text, [0; MOST_SET]);
        for (index, (register, value)) in sets.iter().zip(&mut values).enumerate() {
            let missing = LineError::Count { expected: sets.len(), found: index };
            let (digits, behind) = field(rest).ok_or(missing)?;
            let number = number(digits).ok_or(LineError::Number { index })?;
            let [least, greatest] = register.range();
            let fits = i32::try_from(number).ok().filter(|_| (least..=greatest).contains(&number));
            *value = fits.ok_or(LineError::Range { index })?;
            rest = behind;
        }
        // Behind a turret's number stands its own command, which is for the turret to read.
        if rest.is_empty() || command == Command::Turret {
            Ok(Self { command, values })
        } else {
            Err(LineError::Count { expected: sets.len(), found: sets.len() + 1 })
        }
    }

    /// The registers that are set, in order, and to what.
    pub fn settings(&self) -> impl Iterator<Item = (Register, i32)> {
        self.command.registers().0.iter().copied().zip(self.values)
    }
}

/// Writes the answer to a command to the front of `out`, and returns its length: 128 bytes are enough. A register that
/// `read` has not ends the line; if it is the first, the answer is [`PROTOCOL_ERROR`].
///
/// # Errors
/// If `out` is too short.
pub fn write_answer(
    command: Command,
    read: impl FnMut(Register) -> Option<i32>,
    out: &mut [u8],
) -> Result<usize, WriteError> {
    let (_, tells) = command.registers();
    let mut values = tells.iter().copied().map_while(read).peekable();
    let mut line = Writer { out, len: 0 };
    if values.peek().is_none() && !tells.is_empty() {
        return line.end(PROTOCOL_ERROR);
    }
    line.put(command.letter().to_ascii_lowercase());
    if command == Command::Version {
        VERSIONS.iter().for_each(|&byte| line.put(byte));
    }
    for value in values {
        line.put(b',');
        line.number(value.into());
    }
    line.end(&ANSWER_END)
}

/// Versions of BIOS and protocol.
const VERSIONS: &[u8] = b",5.02,5.01";

/// The farthest target, in pulses.
const FARTHEST: i64 = (1 << 23) - 2;

/// The most registers that a line sets.
const MOST_SET: usize = PROFILE.len();

const PROFILE: [Register; 4] = [
    Register::ProfileSpeed(Side::Left),
    Register::ProfileAcceleration(Side::Left),
    Register::ProfileSpeed(Side::Right),
    Register::ProfileAcceleration(Side::Right),
];

const STATUS: [Register; 6] = [
    Register::Reached(Side::Left),
    Register::Mode(Side::Left),
    Register::Error(Side::Left),
    Register::Reached(Side::Right),
    Register::Mode(Side::Right),
    Register::Error(Side::Right),
];

const AMBIENT: [Register; 8] = [
    Register::Ambient(0),
    Register::Ambient(1),
    Register::Ambient(2),
    Register::Ambient(3),
    Register::Ambient(4),
    Register::Ambient(5),
    Register::Ambient(6),
    Register::Ambient(7),
];
