//! A byte buffer of fixed capacity that is equal, and is saved, by its used bytes alone.
//!
//! Decoders are part of a simulated world's state. The world is hashed and saved, so leftovers of earlier frames
//! behind the used bytes must not count.

use core::fmt;

use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Up to `N` bytes. Invariant: `len <= N`.
#[derive(Clone)]
pub(crate) struct Buffer<const N: usize> {
    bytes: [u8; N],
    len: usize,
}

impl<const N: usize> Buffer<N> {
    pub(crate) const fn new() -> Self {
        Self { bytes: [0; N], len: 0 }
    }

    /// Appends `byte`; false if the buffer was full, and the byte is dropped.
    pub(crate) fn push(&mut self, byte: u8) -> bool {
        let Some(free) = self.bytes.get_mut(self.len) else { return false };
        *free = byte;
        self.len += 1;
        true
    }

    pub(crate) fn len(&self) -> usize {
        self.len
    }

    pub(crate) fn clear(&mut self) {
        self.len = 0;
    }

    /// Empties the buffer, lending what was in it until the next use.
    pub(crate) fn drain(&mut self) -> &mut [u8] {
        let len = core::mem::take(&mut self.len);
        self.bytes.get_mut(..len).unwrap_or_default()
    }

    /// The bytes that are in it.
    pub(crate) fn used(&self) -> &[u8] {
        self.bytes.get(..self.len).unwrap_or_default()
    }
}

impl<const N: usize> Default for Buffer<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize> PartialEq for Buffer<N> {
    fn eq(&self, other: &Self) -> bool {
        self.used() == other.used()
    }
}

impl<const N: usize> Eq for Buffer<N> {}

impl<const N: usize> fmt::Debug for Buffer<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:02x?}", self.used())
    }
}

impl<const N: usize> Serialize for Buffer<N> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_bytes(self.used())
    }
}

impl<'de, const N: usize> Deserialize<'de> for Buffer<N> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_bytes(BufferVisitor)
    }
}

struct BufferVisitor<const N: usize>;

impl<'de, const N: usize> Visitor<'de> for BufferVisitor<N> {
    type Value = Buffer<N>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "at most {N} bytes")
    }

    fn visit_bytes<E: Error>(self, bytes: &[u8]) -> Result<Self::Value, E> {
        let mut buffer = Buffer::new();
        if bytes.iter().all(|&byte| buffer.push(byte)) {
            Ok(buffer)
        } else {
            Err(E::invalid_length(bytes.len(), &self))
        }
    }

    /// Text formats have no bytes, only lists of numbers.
    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Self::Value, A::Error> {
        let mut buffer = Buffer::new();
        while let Some(byte) = list.next_element()? {
            if !buffer.push(byte) {
                return Err(A::Error::invalid_length(N + 1, &self));
            }
        }
        Ok(buffer)
    }
}
