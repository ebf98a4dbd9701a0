//! Errors of descriptions and of writing. The errors of reading are beside their readers.

use thiserror::Error;

/// A buffer is too short for what should go into it, or a payload is longer than a frame may carry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("{needed} bytes are needed, but there is room for {room}")]
pub struct NoRoom {
    /// Bytes to be stored.
    pub needed: usize,
    /// Bytes that can be stored.
    pub room: usize,
}

/// A message could not be written. The buffer's contents are unspecified then.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum WriteError {
    /// The buffer is too short.
    #[error(transparent)]
    NoRoom(#[from] NoRoom),
    /// There are not as many values as the layout says.
    #[error("the layout has {expected} values here, but {found} were given")]
    Count {
        /// Values in the layout.
        expected: usize,
        /// Values given. Of too many, one is counted.
        found: usize,
    },
    /// A text cannot say the value, as its encoding has no codes.
    #[error("value {index} has no code that a text can have")]
    NoCode {
        /// The index of the value, counted from 0.
        index: usize,
    },
}

/// A [`Layout`](crate::Layout) or an [`Encoding`](crate::Encoding) cannot be used as it is.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum LayoutError {
    /// The counts of components do not add up to the number of encodings.
    #[error("the sensors have {counted} components in all, but there are {encodings} encodings")]
    Counts {
        /// Sum of the counts.
        counted: usize,
        /// Number of encodings.
        encodings: usize,
    },
    /// A number of bits that the encoding cannot have.
    #[error("{found} bits are not possible here; the nearest that are is {nearest}")]
    Bits {
        /// The nearest permitted number of bits.
        nearest: u8,
        /// The number of bits given.
        found: u8,
    },
    /// A range that is empty, not finite, or too large to compute with.
    #[error("the range from {min} to {max} is empty, not finite or too large")]
    Range {
        /// The lower end.
        min: f64,
        /// The upper end.
        max: f64,
    },
    /// The longest message does not fit in a frame.
    #[error(transparent)]
    NoRoom(#[from] NoRoom),
    /// A protocol of texts has an encoding without codes.
    #[error("a text has whole numbers, but there is a value without a number of bits")]
    NoCode,
    /// A robot whose messages have the position counters of its two wheels has others.
    #[error(
        "the protocol sends the counters of 2 wheels, which are one sensor's, but there are {found} counters"
    )]
    Positions {
        /// Number of counters in the layout.
        found: usize,
    },
    /// A protocol for two motors has more or fewer.
    #[error("the protocol has signals for 2 motors, but there are {found}")]
    Motors {
        /// Number of signals in the layout.
        found: usize,
    },
}
