//! Pairs of values, one for each wheel.

use serde::{Deserialize, Serialize};

/// A pair of values, one of each wheel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Wheels {
    /// The value of the left wheel.
    pub left: f64,
    /// The value of the right wheel.
    pub right: f64,
}
