//! Errors in a server's messages.

use baudbot_brain::LayoutError;
use thiserror::Error;

/// A server's breach of the contract.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Breach {
    /// Another message than the expected one.
    #[error("expected {expected}, got {found}")]
    Expected {
        /// The expected message.
        expected: &'static str,
        /// The message that came.
        found: &'static str,
    },
    /// A field that must be there is not.
    #[error("{message} without its `{field}`")]
    Missing {
        /// The message.
        message: &'static str,
        /// The field.
        field: &'static str,
    },
    /// A Welcome with other robots than those asked for.
    #[error("asked for robots {asked:?}, got {described:?}")]
    Robots {
        /// Names in the Hello.
        asked: Vec<String>,
        /// Names in the Welcome.
        described: Vec<String>,
    },
    /// A place beyond the end of a list.
    #[error("{what} {index}, but there are only {count}")]
    Index {
        /// The kind of the list's elements.
        what: &'static str,
        /// The place, from 0.
        index: u32,
        /// The length of the list.
        count: usize,
    },
    /// A reading that does not fit its sensor.
    #[error("{found} values from sensor `{sensor}`, which has {expected}")]
    Values {
        /// Name of the sensor.
        sensor: String,
        /// Values that the sensor has.
        expected: usize,
        /// Values that came.
        found: usize,
    },
    /// A number of bits that no encoding has.
    #[error("an encoding of {found} bits")]
    Bits {
        /// The number.
        found: u32,
    },
    /// A Create of a number that there is not.
    #[error("a Create of version {found}; there are 1 and 2")]
    Version {
        /// The number.
        found: u32,
    },
    /// Encodings that no cable can have.
    #[error("robot `{robot}`: {source}")]
    Layout {
        /// Name of the robot.
        robot: String,
        /// The problem.
        source: LayoutError,
    },
}

/// The item of a list at this place, and the place; `what` says what is in the list.
///
/// # Errors
/// If the list is not so long.
pub fn item<'a, T>(list: &'a [T], index: u32, what: &'static str) -> Result<(usize, &'a T), Breach> {
    let place = usize::try_from(index).unwrap_or(usize::MAX);
    list.get(place).map(|item| (place, item)).ok_or(Breach::Index { what, index, count: list.len() })
}
