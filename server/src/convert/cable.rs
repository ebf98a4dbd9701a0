//! The bytes of a cable for watchers.

use baudbot_proto::v1;
use baudbot_wire::meaning::Direction;
use bytes::Bytes;
use prost::Message as _;

use crate::frame::{CableItem, CableNews};

/// What came over a cable, in bytes.
pub(crate) fn cable_news(news: CableNews) -> Bytes {
    let CableNews { items, missed, has_restarted } = news;
    let items = items.into_iter().map(item).collect();
    let response = v1::WatchCableResponse { items, missed_items: missed, restarted: has_restarted };
    response.encode_to_vec().into()
}

fn item(item: CableItem) -> v1::CableItem {
    let CableItem { direction, from_ns, to_ns, bytes, size, text, is_understood, age_ns } = item;
    let direction = match direction {
        Direction::Up => v1::CableDirection::Up,
        Direction::Down => v1::CableDirection::Down,
    };
    let (size, understood) = (u32::try_from(size).unwrap_or(u32::MAX), is_understood);
    v1::CableItem { direction: direction.into(), from_ns, to_ns, data: bytes, size, text, understood, age_ns }
}
