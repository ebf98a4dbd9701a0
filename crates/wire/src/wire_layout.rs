//! The owner of what a [`Layout`] borrows.

use alloc::vec::Vec;

use crate::codec::Terms;
use crate::encoding::Encoding;
use crate::layout::Layout;
use crate::protocol::{Agreement, Protocol};

/// The agreement of the two ends of a cable: how the values of each sensor and each motor cross the wire.
#[derive(Clone, Debug, PartialEq)]
pub struct WireLayout {
    protocol: Protocol,
    ages: bool,
    components: Vec<Encoding>,
    counts: Vec<u8>,
    motors: Vec<Encoding>,
    places: Vec<Option<u8>>,
}

impl WireLayout {
    /// The components of these sensors, each with its name, and signals for two motors and the other actuators. Of a sensor of
    /// which the protocol has a part only, it has nothing.
    pub fn new<'a>(
        protocol: Protocol,
        sensors: impl Iterator<Item = (&'a str, &'a [Encoding])>,
        motors: Vec<Encoding>,
    ) -> Self {
        let (mut components, mut counts, mut places) = (Vec::new(), Vec::new(), Vec::new());
        for (name, encodings) in sensors {
            let own = |i| protocol.place(name, i);
            let is_whole = (0..encodings.len()).all(|i| own(i).is_some());
            places.extend((0..encodings.len()).map(|i| own(i).filter(|_| is_whole)));
            components.extend_from_slice(encodings);
            counts.push(u8::try_from(encodings.len()).unwrap_or(u8::MAX));
        }
        if places.iter().all(Option::is_none) {
            places.clear();
        }
        components.shrink_to_fit();
        counts.shrink_to_fit();
        places.shrink_to_fit();
        let ages = protocol == Protocol::Framed { ages: true };
        Self { protocol, ages, components, counts, motors, places }
    }

    /// The layout.
    #[inline]
    pub fn borrow(&self) -> Layout<'_> {
        let Self { components, counts, motors, ages, .. } = self;
        Layout { components, counts, motors, ages: *ages }
    }

    /// The protocol and its terms, which write and read messages.
    #[inline]
    pub fn agreement(&self) -> Agreement<'_> {
        Agreement { protocol: self.protocol, terms: Terms { layout: self.borrow(), places: &self.places } }
    }

    /// The bytes that it has on the heap.
    pub fn heap_bytes(&self) -> usize {
        (self.components.capacity() + self.motors.capacity()) * size_of::<Encoding>()
            + self.counts.capacity()
            + self.places.capacity() * size_of::<Option<u8>>()
    }
}
