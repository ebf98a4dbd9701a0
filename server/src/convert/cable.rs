//! The bytes of a cable for watchers.

use baudbot_proto::v1;
use baudbot_wire::meaning::{Direction, Item};

/// An item of a cable, with so many of its bytes.
pub(crate) fn cable_item(item: &Item<'_>, most_bytes: usize) -> v1::CableItem {
    let Item { direction, from_ns, to_ns, bytes, text, is_understood: understood, age_ns } = *item;
    let direction = match direction {
        Direction::Up => v1::CableDirection::Up,
        Direction::Down => v1::CableDirection::Down,
    };
    let size = u32::try_from(bytes.len()).unwrap_or(u32::MAX);
    let data = bytes[..bytes.len().min(most_bytes)].to_vec();
    v1::CableItem {
        direction: direction.into(),
        from_ns,
        to_ns,
        data,
        size,
        text: text.to_owned(),
        understood,
        age_ns,
    }
}
