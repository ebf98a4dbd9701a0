//! The time for which a line is known ahead of the bytes that are sent on it.

use super::{Line, Link};
use crate::time::SimTime;

impl Line {
    /// The instant at which the first byte is at the end of the line that is handed over at `at`, or later. `None`
    /// where that is unknown, or what is handed over then could matter before it arrives: where the line takes no time;
    /// where others share the wire, or what is under way waits in an adapter; and while anything is still under way, as
    /// the room that it leaves is looked at when more is sent.
    pub(crate) fn reach(&self, link: &Link, at: SimTime) -> Option<SimTime> {
        match link {
            Link::Ideal | Link::Onboard => None,
            Link::Uart(_) | Link::Usb(_) if self.transport_path.is_some() || !self.in_flight.is_empty() => {
                None
            }
            Link::Uart(_) | Link::Usb(_) => {
                let mut transmission = self.transmission;
                Some(transmission.put(link, at))
            }
        }
    }
}
