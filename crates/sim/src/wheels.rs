//! Pairs of values, one for each wheel.

use serde::{Deserialize, Serialize};

/// A pair of values, one of each wheel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Wheels {
    /// Of the left wheel.
    pub left: f64,
    /// Of the right wheel.
    pub right: f64,
}
