//! In place of `optimizers` where they are not built in.

use super::course::Course;
use crate::error::Error;

/// Whether there are optimizers in this program.
pub(super) fn check() -> Result<(), Error> {
    Err(Error::Refused(WITHOUT.to_owned()))
}

impl Course {
    /// Nothing: [`check`] comes first.
    pub(super) fn generation(&self, _: &[Vec<f64>]) -> Result<Option<Vec<Vec<f64>>>, String> {
        Err(WITHOUT.to_owned())
    }
}

const WITHOUT: &str =
    "this program was built without optimizers; cargo build --release --features tune builds one with them";
