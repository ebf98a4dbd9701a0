//! The packets of sensor data, which are the registers that a program can ask for.

use core::ops::RangeInclusive;

use super::Version;

macro_rules! packets {
    ($($(#[$doc:meta])* $name:ident = $id:literal, $len:literal;)*) => {
        /// A packet: one value, in one or two bytes, the high byte first.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[repr(u8)]
        pub enum Packet {
            $($(#[$doc])* $name = $id,)*
        }

        impl Packet {
            /// All of them, in the order of their numbers.
            pub const ALL: &'static [Self] = &[$(Self::$name),*];

            /// Bytes of its value.
            pub const fn size(self) -> usize {
                match self {
                    $(Self::$name => $len,)*
                }
            }
        }
    };
}

packets! {
    /// Bits: 0 right bumper, 1 left bumper, 2 right wheel dropped, 3 left wheel dropped, 4 caster dropped (Create 1).
    BumpsWheelDrops = 7, 1;
    /// 1 if there is a wall at the right.
    Wall = 8, 1;
    /// 1 if there is a cliff.
    CliffLeft = 9, 1;
    /// 1 if there is a cliff.
    CliffFrontLeft = 10, 1;
    /// 1 if there is a cliff.
    CliffFrontRight = 11, 1;
    /// 1 if there is a cliff.
    CliffRight = 12, 1;
    /// 1 if a virtual wall is seen.
    VirtualWall = 13, 1;
    /// Bits of motors that take too much current.
    Overcurrents = 14, 1;
    /// The amount of dirt on the acoustic sensor; 0 of a Create 1.
    Dirt = 15, 1;
    /// An unused byte, always 0.
    Unused16 = 16, 1;
    /// The character that the receiver on top sees.
    InfraredOmni = 17, 1;
    /// Bits of buttons that are pressed.
    Buttons = 18, 1;
    /// Signed: the way since it was last sent, in mm.
    Distance = 19, 2;
    /// Signed: the turn since it was last sent, in degrees, counter-clockwise.
    Angle = 20, 2;
    /// 0 not charging, 1 reconditioning, 2 full charging, 3 trickle charging, 4 waiting, 5 fault.
    ChargingState = 21, 1;
    /// The voltage of the battery, in mV.
    Voltage = 22, 2;
    /// Signed: the current into the battery, in mA.
    Current = 23, 2;
    /// Signed: the temperature of the battery, in °C.
    Temperature = 24, 1;
    /// The charge of the battery, in mAh.
    Charge = 25, 2;
    /// The charge of the battery when it is full, in mAh.
    Capacity = 26, 2;
    /// Strength of the wall sensor's signal.
    WallSignal = 27, 2;
    /// Strength of the signal, 0 to 4095.
    CliffLeftSignal = 28, 2;
    /// Strength of the signal, 0 to 4095.
    CliffFrontLeftSignal = 29, 2;
    /// Strength of the signal, 0 to 4095.
    CliffFrontRightSignal = 30, 2;
    /// Strength of the signal, 0 to 4095.
    CliffRightSignal = 31, 2;
    /// Bits at the plug in the cargo bay (Create 1).
    CargoBayInputs = 32, 1;
    /// Voltage at the plug in the cargo bay, 0 to 1023 (Create 1).
    CargoBayVoltage = 33, 2;
    /// Bits: 0 charger at the plug, 1 home base.
    ChargingSources = 34, 1;
    /// The [`Mode`](super::Mode).
    OiMode = 35, 1;
    /// The number of the last song.
    SongNumber = 36, 1;
    /// 1 while a song is played.
    SongPlaying = 37, 1;
    /// The number of packets in the stream.
    StreamPackets = 38, 1;
    /// Signed: the speed of the last [`Drive`](super::Command::Drive), in mm/s.
    RequestedVelocity = 39, 2;
    /// Signed: the radius of the last [`Drive`](super::Command::Drive), in mm.
    RequestedRadius = 40, 2;
    /// Signed: the right speed of the last [`DriveDirect`](super::Command::DriveDirect), in mm/s.
    RequestedRight = 41, 2;
    /// Signed: the left speed of the last [`DriveDirect`](super::Command::DriveDirect), in mm/s.
    RequestedLeft = 42, 2;
    /// Counts of the left wheel, modulo 2^16.
    EncoderLeft = 43, 2;
    /// Counts of the right wheel, modulo 2^16.
    EncoderRight = 44, 2;
    /// Bits of the light bumpers that see something: 0 left, 1 front left, 2 center left, 3 center right, 4 front right, 5 right.
    LightBumper = 45, 1;
    /// Strength of the signal, 0 to 4095.
    LightLeftSignal = 46, 2;
    /// Strength of the signal, 0 to 4095.
    LightFrontLeftSignal = 47, 2;
    /// Strength of the signal, 0 to 4095.
    LightCenterLeftSignal = 48, 2;
    /// Strength of the signal, 0 to 4095.
    LightCenterRightSignal = 49, 2;
    /// Strength of the signal, 0 to 4095.
    LightFrontRightSignal = 50, 2;
    /// Strength of the signal, 0 to 4095.
    LightRightSignal = 51, 2;
    /// The character that the left receiver sees.
    InfraredLeft = 52, 1;
    /// The character that the right receiver sees.
    InfraredRight = 53, 1;
    /// Signed: the current of the left wheel's motor, in mA.
    LeftMotorCurrent = 54, 2;
    /// Signed: the current of the right wheel's motor, in mA.
    RightMotorCurrent = 55, 2;
    /// Signed: the current of the main brush's motor, in mA.
    MainBrushCurrent = 56, 2;
    /// Signed: the current of the side brush's motor, in mA.
    SideBrushCurrent = 57, 2;
    /// Bits: 0 the caster's wheel is seen turning, 1 its sensor is dirty.
    Stasis = 58, 1;
}

impl Packet {
    /// The packet of this number, if this robot has it.
    pub fn of(version: Version, id: u8) -> Option<Self> {
        let [packet] = group(version, id)? else { return None };
        Some(*packet)
    }

    /// The number of the packet.
    pub const fn id(self) -> u8 {
        self as u8
    }

    /// Writes its value to the front of `out`, of which as many bits count as it has; returns how many bytes that were,
    /// 0 if `out` is too short.
    pub fn put(self, value: i32, out: &mut [u8]) -> usize {
        let bytes = (value as u16).to_be_bytes();
        let bytes = &bytes[bytes.len() - self.size()..];
        let Some(out) = out.get_mut(..bytes.len()) else { return 0 };
        out.copy_from_slice(bytes);
        bytes.len()
    }

    /// The bits of its value at the front of `bytes`; `None` if they are too few.
    pub fn take(self, bytes: &[u8]) -> Option<u16> {
        Some(bytes.get(..self.size())?.iter().fold(0, |word, byte| word << 8 | u16::from(*byte)))
    }
}

/// The packets that this number stands for: one, or those of a group in order. `None` of a number that the robot has not.
pub fn group(version: Version, id: u8) -> Option<&'static [Packet]> {
    let ids: RangeInclusive<u8> = match id {
        0 => 7..=26,
        1 => 7..=16,
        2 => 17..=20,
        3 => 21..=26,
        4 => 27..=34,
        5 => 35..=42,
        6 => 7..=42,
        7..=42 => id..=id,
        _ => match (version, id) {
            (Version::Two, 43..=58) => id..=id,
            (Version::Two, 100) => 7..=58,
            (Version::Two, 101) => 43..=58,
            (Version::Two, 106) => 46..=51,
            (Version::Two, 107) => 54..=58,
            (Version::One | Version::Two, _) => return None,
        },
    };
    let first = usize::from(*ids.start() - 7);
    Packet::ALL.get(first..=usize::from(*ids.end() - 7))
}

/// Bytes of the data of these packets and groups, one behind the other; those that the robot has not are none.
pub fn listed_len(version: Version, ids: &[u8]) -> usize {
    let packets = ids.iter().filter_map(|&id| group(version, id)).flatten();
    packets.map(|packet| packet.size()).sum()
}
