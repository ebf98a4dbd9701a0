//! The place of a point of a comparison.

use std::fmt;

use serde::Deserialize;

/// The varied quantity, at one point.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(untagged)]
pub enum At {
    /// A number, in the unit of the comparison's `x`.
    Number(f64),
    /// A name.
    Name(String),
}

impl fmt::Display for At {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => write!(f, "{number}"),
            Self::Name(name) => f.write_str(name),
        }
    }
}
