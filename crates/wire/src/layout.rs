//! The agreement that both ends of the cable share: what is sent, in which order, in how many bytes.
//!
//! Nothing of it crosses the wire. A frame says only which sensors it holds; how many numbers each of them has, and
//! how they are encoded, both ends know beforehand, as on a real robot.

use crate::encoding::Encoding;
use crate::error::{LayoutError, NoRoom};
use crate::frame::MAX_PAYLOAD;

/// The layout of the messages of one cable.
///
/// Flat, so that an owner with two vectors lends it at no cost. If the counts do not add up to the components (see
/// [`check`](Self::check)), the components that are lacking are not sent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout<'a> {
    /// The encodings of all sensors' components, sensor by sensor.
    pub components: &'a [Encoding],
    /// The number of `components` of each sensor, in the same order.
    pub counts: &'a [u8],
    /// The encodings of the motor signals.
    pub motors: &'a [Encoding],
    /// Whether a readings message has the age of each reading, at one byte each.
    pub ages: bool,
}

impl<'a> Layout<'a> {
    /// Number of sensors.
    pub const fn sensor_count(&self) -> usize {
        self.counts.len()
    }

    /// The components of each sensor, in order.
    pub fn sensors(&self) -> Sensors<'a> {
        Sensors { components: self.components, counts: self.counts.iter() }
    }

    /// Bytes of the mask that says which sensors are in a readings message.
    pub const fn mask_len(&self) -> usize {
        self.counts.len().div_ceil(8)
    }

    /// Bytes of a readings message that holds all sensors; none is longer.
    pub fn readings_len_max(&self) -> usize {
        self.readings_len(|_| true)
    }

    /// Bytes of a readings message that holds these sensors.
    pub fn readings_len(&self, is_fresh: impl Fn(usize) -> bool) -> usize {
        let fresh = self.sensors().enumerate().filter(|(sensor, _)| is_fresh(*sensor));
        let entries: usize = fresh.map(|(_, components)| self.entry_len(components)).sum();
        READINGS_HEADER_LEN + self.mask_len() + entries
    }

    /// Bytes of a command message.
    pub fn command_len(&self) -> usize {
        COMMAND_HEADER_LEN + self.bare_command_len()
    }

    /// Bytes of all readings in the bare format.
    pub fn bare_readings_len(&self) -> usize {
        total_len(self.components)
    }

    /// Bytes of a command in the bare format.
    pub fn bare_command_len(&self) -> usize {
        total_len(self.motors)
    }

    /// Whether the layout can be used. Owners check once, when they are configured; after that, writing to a buffer
    /// of [`MAX_PAYLOAD`] bytes cannot run out of room.
    ///
    /// # Errors
    /// Names the first thing that is wrong.
    pub fn check(&self) -> Result<(), LayoutError> {
        let counted = self.counts.iter().map(|&count| usize::from(count)).sum();
        if counted != self.components.len() {
            return Err(LayoutError::Counts { counted, encodings: self.components.len() });
        }
        self.components.iter().chain(self.motors).try_for_each(|encoding| encoding.check())?;
        let needed = self.readings_len_max().max(self.command_len());
        if needed > MAX_PAYLOAD {
            return Err(NoRoom { needed, room: MAX_PAYLOAD }.into());
        }
        Ok(())
    }

    /// Bytes of one sensor's entry in a readings message.
    pub(crate) fn entry_len(&self, components: &[Encoding]) -> usize {
        usize::from(self.ages) + total_len(components)
    }
}

/// Iterates over the components of each sensor; see [`Layout::sensors`].
#[derive(Clone, Debug)]
pub struct Sensors<'a> {
    components: &'a [Encoding],
    counts: core::slice::Iter<'a, u8>,
}

impl<'a> Iterator for Sensors<'a> {
    type Item = &'a [Encoding];

    fn next(&mut self) -> Option<Self::Item> {
        let count = usize::from(*self.counts.next()?).min(self.components.len());
        let (sensor, rest) = self.components.split_at_checked(count)?;
        self.components = rest;
        Some(sensor)
    }
}

/// Bytes of values encoded one after the other.
pub(crate) fn total_len(encodings: &[Encoding]) -> usize {
    encodings.iter().map(|encoding| encoding.len()).sum()
}

/// Kind, sequence number, two bytes of time.
pub(crate) const READINGS_HEADER_LEN: usize = 4;

/// The bytes of the head: kind, sequence number.
pub(crate) const COMMAND_HEADER_LEN: usize = 2;

#[cfg(test)]
mod tests {
    use super::*;

    const BYTE: Encoding = Encoding::Level { bits: 8, min: 0.0, max: 1.0 };

    #[test]
    fn lengths_add_up() {
        let layout = Layout {
            components: &[BYTE, Encoding::Counter { bits: 16 }, Encoding::Counter { bits: 16 }],
            counts: &[1, 2],
            motors: &[Encoding::Float64, BYTE],
            ages: true,
        };
        assert_eq!(layout.check(), Ok(()));
        assert_eq!(layout.readings_len_max(), 4 + 1 + (1 + 1) + (1 + 4));
        assert_eq!(layout.readings_len(|sensor| sensor == 1), 4 + 1 + (1 + 4));
        assert_eq!(layout.command_len(), 2 + 9);
        assert_eq!((layout.bare_readings_len(), layout.bare_command_len()), (5, 9));
    }

    #[test]
    fn an_inconsistent_layout_is_named_and_still_harmless() {
        let layout = Layout { components: &[BYTE; 3], counts: &[2, 2, 1], motors: &[], ages: false };
        assert_eq!(layout.check(), Err(LayoutError::Counts { counted: 5, encodings: 3 }));
        assert!(layout.sensors().map(<[Encoding]>::len).eq([2, 1, 0]));
    }

    #[test]
    fn a_message_must_fit_in_a_frame() {
        let layout = Layout { components: &[], counts: &[], motors: &[Encoding::Float64; 64], ages: false };
        assert_eq!(layout.check(), Err(NoRoom { needed: 514, room: 512 }.into()));
    }
}
