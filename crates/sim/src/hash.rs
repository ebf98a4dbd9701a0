//! A 64-bit fingerprint of any serialisable value.
//!
//! The value is written in postcard's binary form straight into an FNV-1a hash. Since the fingerprint
//! follows the serialisation, a field that is part of a snapshot is part of the hash, and none can be
//! forgotten.

use postcard::ser_flavors::Flavor;
use serde::Serialize;

use crate::random::{FNV_OFFSET, fnv1a_step};

/// The fingerprint of `value`: equal for equal bits of state, on every machine.
pub(crate) fn of(value: &impl Serialize) -> u64 {
    // The sink takes every byte, so an error could only come from a type that postcard cannot write
    // (a sequence of unknown length); the state has none, and the tests serialise all of it.
    postcard::serialize_with_flavor(value, Fnv(FNV_OFFSET)).expect("the state's types serialise")
}

struct Fnv(u64);

impl Flavor for Fnv {
    type Output = u64;

    fn try_push(&mut self, byte: u8) -> postcard::Result<()> {
        self.0 = fnv1a_step(self.0, byte);
        Ok(())
    }

    fn finalize(self) -> postcard::Result<u64> {
        Ok(self.0)
    }
}
