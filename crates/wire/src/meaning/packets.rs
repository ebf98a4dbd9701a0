//! The names and values of a Create's packets.

use core::fmt::{self, Display, Write};

use super::Meaning;
use super::text::Text;
use crate::create::{Packet, Version, group};

/// Adds the packets of this number, whose values are at the front of `data`; gives what is behind them.
pub(super) fn add<'a>(meaning: &mut Meaning, version: Version, id: u8, data: &'a [u8]) -> &'a [u8] {
    let packets = group(version, id).unwrap_or_default();
    if packets.len() != 1 {
        meaning.add(format_args!("; group {id}"));
    }
    let mut rest = data;
    for packet in packets {
        let Some(bits) = packet.take(rest) else {
            meaning.is_understood = false;
            meaning.add(format_args!("; {} is cut off", Name(*packet)));
            return &[];
        };
        rest = rest.get(packet.size()..).unwrap_or_default();
        let value = if is_signed(*packet) { signed(*packet, bits) } else { i32::from(bits) };
        meaning.add(format_args!("; {} {value}", Name(*packet)));
    }
    rest
}

/// Whether the manual has a signed number for it.
const fn is_signed(packet: Packet) -> bool {
    matches!(
        packet,
        Packet::Distance
            | Packet::Angle
            | Packet::Current
            | Packet::Temperature
            | Packet::RequestedVelocity
            | Packet::RequestedRadius
            | Packet::RequestedRight
            | Packet::RequestedLeft
            | Packet::LeftMotorCurrent
            | Packet::RightMotorCurrent
            | Packet::MainBrushCurrent
            | Packet::SideBrushCurrent
    )
}

const fn signed(packet: Packet, bits: u16) -> i32 {
    if packet.size() == 1 { (bits as u8).cast_signed() as i32 } else { bits.cast_signed() as i32 }
}

/// The name of a packet, in small letters with spaces.
struct Name(Packet);

impl Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut name = Text::new();
        write!(name, "{:?}", self.0)?;
        for (i, character) in name.as_str().chars().enumerate() {
            if i > 0 && character.is_ascii_uppercase() {
                f.write_char(' ')?;
            }
            f.write_char(character.to_ascii_lowercase())?;
        }
        Ok(())
    }
}

/// The name of the packet or the group with a number.
pub(super) struct PacketName {
    pub(super) version: Version,
    pub(super) id: u8,
}

impl Display for PacketName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match group(self.version, self.id) {
            Some([packet]) => Name(*packet).fmt(f),
            Some(_) => write!(f, "group {}", self.id),
            None => write!(f, "packet {}, which this robot does not have", self.id),
        }
    }
}
