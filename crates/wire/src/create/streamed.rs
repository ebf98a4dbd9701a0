//! The dialogue of brains of messages with a Create: a stream of the packets with their sensors.

use super::signals::bits;
use super::{MOST_STREAMED, Payload, Signal, Version};
use crate::buffer::Buffer;
use crate::codec::{Notice, Sink, Terms};
use crate::error::LayoutError;

/// The packets with the components of a layout, each once, in the order in which they are first met.
pub(crate) fn streamed(terms: &Terms<'_>) -> Buffer<MOST_STREAMED> {
    let mut ids = Buffer::new();
    for signal in terms.places.iter().filter_map(|place| Signal::at((*place)?)) {
        let id = signal.packet.id();
        if !ids.used().contains(&id) {
            ids.push(id);
        }
    }
    ids
}

/// Writes the bytes that come before all else, and returns how many they are: Start, Full, and the stream that a
/// program wants. The robot stands then. `None` if `out` is too short.
pub(crate) fn write_opening(terms: &Terms<'_>, out: &mut [u8]) -> Option<usize> {
    let ids = streamed(terms);
    let ids = ids.used();
    let (head, list) = out.get_mut(..4 + ids.len())?.split_at_mut(4);
    head.copy_from_slice(&[128, 132, 148, ids.len() as u8]);
    list.copy_from_slice(ids);
    Some(4 + ids.len())
}

/// Whether a robot can be driven by this layout. Owners check once, when they are configured.
///
/// # Errors
/// Names the first thing that is wrong.
pub(crate) fn check(terms: &Terms<'_>) -> Result<(), LayoutError> {
    let layout = terms.layout;
    if layout.motors.len() != 2 {
        return Err(LayoutError::Motors { found: layout.motors.len() });
    }
    for (encoding, place) in layout.components.iter().zip(terms.places) {
        let Some(signal) = place.and_then(Signal::at) else { continue };
        let found = bits(*encoding).ok_or(LayoutError::NoCode)?;
        if found != signal.bits {
            return Err(LayoutError::Bits { nearest: signal.bits, found });
        }
    }
    Ok(())
}

/// Reads a message of the stream, and gives its readings to `sink`. A sensor that is not told has no reading; another stream than
/// that of the layout has none at all.
pub(crate) fn read(version: Version, terms: &Terms<'_>, bytes: &[u8], sink: &mut impl Sink) -> Notice {
    let payload = Payload { version, bytes };
    let mut rest = terms.places;
    for (sensor, components) in terms.layout.sensors().enumerate() {
        let (places, behind) = rest.split_at(components.len().min(rest.len()));
        rest = behind;
        let values = || {
            let told = components.iter().zip(places);
            told.map(|(to, place)| payload.value(Signal::at((*place)?)?, *to))
        };
        if !components.is_empty() && values().all(|value| value.is_some()) {
            sink.take(sensor, None, values().flatten());
        }
    }
    Notice::Readings
}
