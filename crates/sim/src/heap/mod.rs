//! Memory: how many bytes a value has on the heap, counted by a walk of its serialisation.
//!
//! The state of a world is of many types, and all of it is serialised ([`hash`](crate::hash)). A walk of that meets each part with
//! its type, so that the part's size is known; what is larger than the place that it has in its owner is behind a pointer. So a field
//! that is added is counted by itself.
//!
//! # Deviations
//!
//! Counted is what was asked for, not what an allocator takes for it; a list has the room of its elements, as a clone of it has.
//! What is not serialised is left out, such as tapes of cables for those who watch, and the lists that a tick uses again.
//! A test compares with what an allocator is asked for (`crates/sim/tests/memory.rs`).

mod walk;

use alloc::vec::Vec;

pub(crate) use walk::of;

/// The bytes that a list has for its elements.
pub(crate) fn elements<T>(list: &Vec<T>) -> usize {
    list.capacity() * size_of::<T>()
}

/// The bytes that a list has for its elements, and what each of them has on the heap.
pub(crate) fn list<T>(list: &Vec<T>, of: impl Fn(&T) -> usize) -> usize {
    elements(list) + list.iter().map(of).sum::<usize>()
}

/// The name under which something is serialised that has no memory of its own.
pub(crate) const NO_MEMORY: &str = baudbot_avr::NO_MEMORY;

/// The head of a shared value: two counters.
pub(crate) const SHARED: usize = 2 * size_of::<usize>();
