//! The bounds of commands in a stream of bytes, and their meaning.

use serde::{Deserialize, Serialize};

use super::Version;
use crate::buffer::Buffer;

/// Bytes of the longest command: a list of 255 packets.
pub const MAX_COMMAND: usize = 2 + 255;

/// Most notes of a song. A longer one is cut (a guess).
pub const MOST_NOTES: usize = 16;

/// Most bytes of a script (Create 1).
const MOST_SCRIPT: usize = 100;

/// The baud rates of command 129 (iRobot, Open Interface; the same of both robots).
pub const BAUDS: [u32; 12] =
    [300, 600, 1200, 2400, 4800, 9600, 14_400, 19_200, 28_800, 38_400, 57_600, 115_200];

/// A mode of the interface, by the commands that it obeys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Mode {
    /// The interface obeys nothing but Start and Reset.
    #[default]
    Off,
    /// Commands that move nothing.
    Passive,
    /// The mode Safe: all commands are obeyed, until a cliff, a dropped wheel or a charger ends it.
    Safe,
    /// The mode Full: all commands are obeyed.
    Full,
}

impl Mode {
    /// The number of the mode in packet 35.
    pub const fn number(self) -> u8 {
        match self {
            Self::Off => 0,
            Self::Passive => 1,
            Self::Safe => 2,
            Self::Full => 3,
        }
    }
}

/// Finds commands in a stream of bytes. Behind the end of a command it is as new.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Commands {
    version: Version,
    collected: Buffer<MAX_COMMAND>,
}

impl Commands {
    /// A reader of the commands of this robot that has seen nothing.
    pub const fn new(version: Version) -> Self {
        Self { version, collected: Buffer::new() }
    }

    /// Whether this reader may have become what `other` is: of the same robot, with less than a command collected.
    pub fn may_become(&self, other: &Self) -> bool {
        let collected = other.collected.used();
        self.version == other.version
            && (collected.is_empty() || collected.len() < len(self.version, collected))
    }

    /// Forgets the command that it is in.
    pub fn clear(&mut self) {
        self.collected.clear();
    }

    /// Takes the next byte from the wire. Gives the bytes of the command that the byte ends; one that is no opcode is given by
    /// itself.
    pub fn push(&mut self, byte: u8) -> Option<&[u8]> {
        self.collected.push(byte);
        let collected = self.collected.used();
        (collected.len() >= len(self.version, collected)).then(|| &*self.collected.drain())
    }
}

/// Bytes of the command that begins with these, as far as they determine it: 1 of what is no opcode.
fn len(version: Version, begun: &[u8]) -> usize {
    let counted = |at: usize, each: usize, most: usize| {
        let count = begun.get(at).map_or(0, |&count| usize::from(count).min(most));
        1 + at + each * count
    };
    let Some(&opcode) = begun.first() else { return 1 };
    match (version, opcode) {
        (_, 140) => counted(2, 2, MOST_NOTES),
        (_, 148 | 149) => counted(1, 1, usize::from(u8::MAX)),
        (_, 129 | 138 | 141 | 142 | 150) => 2,
        (_, 137 | 145) => 5,
        (_, 139 | 144) => 4,
        (Version::One, 136 | 147 | 151 | 155 | 158) => 2,
        (Version::One, 152) => counted(1, 1, MOST_SCRIPT),
        (Version::One, 156 | 157) => 3,
        (Version::Two, 146 | 163 | 164) => 5,
        (Version::Two, 162) => 3,
        (Version::Two, 165) => 2,
        (Version::Two, 167) => 16,
        (Version::Two, 168) => 4,
        (Version::One | Version::Two, _) => 1,
    }
}

/// A command, as the robot understands it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command<'a> {
    /// 128: the interface is on, in the mode Passive.
    Start,
    /// 7: as if the battery had been taken out (Create 2).
    Reset,
    /// 173: the interface is off (Create 2).
    Stop,
    /// 129: another baud rate, by its code, which is a place in [`BAUDS`].
    Baud(u8),
    /// 130 (Control) and 131: the mode Safe.
    Safe,
    /// 132: the mode Full.
    Full,
    /// 133 of a Create 2: switches it off, which leaves the mode Passive.
    Power,
    /// 134, 135, 136, 143: covers the floor, shows a demo, or seeks its dock, in the mode Passive. Has the opcode.
    Demo(u8),
    /// 137: speed of the centre and radius of the turn.
    Drive {
        /// The speed forwards, in mm/s.
        velocity_mm_s: i16,
        /// The radius to the left, in mm; see [`wheels_mm_s`](super::wheels_mm_s).
        radius_mm: i16,
    },
    /// 145: speeds of the wheels.
    DriveDirect {
        /// The speed forwards, in mm/s.
        right_mm_s: i16,
        /// The speed forwards, in mm/s.
        left_mm_s: i16,
    },
    /// 146: pulse widths of the wheels, −255 to 255 (Create 2).
    DrivePwm {
        /// The duty forwards, −255 to 255.
        right: i16,
        /// The duty forwards, −255 to 255.
        left: i16,
    },
    /// 138: bits of brushes, or of low side drivers (Create 1).
    Motors(u8),
    /// 144: pulse widths of brushes, or of low side drivers (Create 1).
    MotorsPwm([u8; 3]),
    /// 139: bits, colour from green (0) to red (255), brightness.
    Leds([u8; 3]),
    /// 162: LEDs of weekdays and of the clock (Create 2).
    ClockLeds([u8; 2]),
    /// 163: segments of the four digits (Create 2).
    Digits([u8; 4]),
    /// 164: characters of the four digits (Create 2).
    Characters([u8; 4]),
    /// 140: keeps a song.
    Song {
        /// The number of the song.
        number: u8,
        /// Number of a note and its duration in 1/64 s, for each.
        notes: &'a [u8],
    },
    /// 141: plays the song of this number.
    Play(u8),
    /// 142: asks for a packet or a group.
    Sensors(u8),
    /// 149: asks for packets and groups.
    QueryList(&'a [u8]),
    /// 148: asks for a stream of packets and groups; of none, for its end.
    Stream(&'a [u8]),
    /// 150: a stream that was asked for goes on, or pauses.
    Resume(bool),
    /// A command that has no effect here: digital outputs, the infra-red sender, scripts and waits of a Create 1, the
    /// schedule and the buttons of a Create 2. Has the opcode.
    Without(u8),
}

impl<'a> Command<'a> {
    /// The meaning of bytes that [`Commands`] found; `None` if they are no command of this robot's.
    pub fn parse(version: Version, bytes: &'a [u8]) -> Option<Self> {
        let (&opcode, data) = bytes.split_first()?;
        if bytes.len() != len(version, bytes) {
            return None;
        }
        Self::of_both(opcode, data).or_else(|| match version {
            Version::One => Self::of_the_first(opcode),
            Version::Two => Self::of_the_second(opcode, data),
        })
    }

    /// Commands that both robots have.
    fn of_both(opcode: u8, data: &'a [u8]) -> Option<Self> {
        Some(match (opcode, data) {
            (128, []) => Self::Start,
            (129, &[code]) => Self::Baud(code),
            (130 | 131, []) => Self::Safe,
            (132, []) => Self::Full,
            (134 | 135 | 143, []) => Self::Demo(opcode),
            (137, &[a, b, c, d]) => Self::Drive { velocity_mm_s: word(a, b), radius_mm: word(c, d) },
            (138, &[bits]) => Self::Motors(bits),
            (139, &[bits, color, intensity]) => Self::Leds([bits, color, intensity]),
            (140, [number, _, notes @ ..]) => Self::Song { number: *number, notes },
            (141, &[number]) => Self::Play(number),
            (142, &[id]) => Self::Sensors(id),
            (144, &[a, b, c]) => Self::MotorsPwm([a, b, c]),
            (145, &[a, b, c, d]) => Self::DriveDirect { right_mm_s: word(a, b), left_mm_s: word(c, d) },
            (148, [_, ids @ ..]) => Self::Stream(ids),
            (149, [_, ids @ ..]) => Self::QueryList(ids),
            (150, &[resumes]) => Self::Resume(resumes != 0),
            _ => return None,
        })
    }

    fn of_the_first(opcode: u8) -> Option<Self> {
        Some(match opcode {
            136 => Self::Demo(opcode),
            147 | 151..=158 => Self::Without(opcode),
            _ => return None,
        })
    }

    fn of_the_second(opcode: u8, data: &[u8]) -> Option<Self> {
        Some(match (opcode, data) {
            (7, []) => Self::Reset,
            (133, []) => Self::Power,
            (136, []) => Self::Demo(opcode),
            (146, &[a, b, c, d]) => Self::DrivePwm { right: word(a, b), left: word(c, d) },
            (162, &[days, clock]) => Self::ClockLeds([days, clock]),
            (163, &[a, b, c, d]) => Self::Digits([a, b, c, d]),
            (164, &[a, b, c, d]) => Self::Characters([a, b, c, d]),
            (165 | 167 | 168, _) => Self::Without(opcode),
            (173, []) => Self::Stop,
            _ => return None,
        })
    }

    /// The least mode in which it is obeyed.
    pub const fn least_mode(self) -> Mode {
        match self {
            Self::Start | Self::Reset => Mode::Off,
            Self::Stop | Self::Baud(_) | Self::Safe | Self::Full | Self::Power | Self::Demo(_) => {
                Mode::Passive
            }
            Self::Song { .. } | Self::Sensors(_) | Self::QueryList(_) => Mode::Passive,
            Self::Stream(_) | Self::Resume(_) | Self::Without(_) => Mode::Passive,
            Self::Drive { .. } | Self::DriveDirect { .. } | Self::DrivePwm { .. } => Mode::Safe,
            Self::Motors(_) | Self::MotorsPwm(_) | Self::Leds(_) | Self::Play(_) => Mode::Safe,
            Self::ClockLeds(_) | Self::Digits(_) | Self::Characters(_) => Mode::Safe,
        }
    }
}

/// A signed number of 16 bits, the high byte first.
const fn word(high: u8, low: u8) -> i16 {
    i16::from_be_bytes([high, low])
}
