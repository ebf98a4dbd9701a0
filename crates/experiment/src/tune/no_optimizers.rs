//! In place of `optimizers` where they are not built in.

use super::course::Course;
use crate::error::Error;

/// Whether there are optimizers in this program.
pub(crate) fn check() -> Result<(), Error> {
    let problem = "this program was built without optimizers; cargo build --release --features tune builds one with them, and the \
                   random search of `baudbot worst` needs none: [worst] method = \"random\"";
    Err(Error::Refused(problem.to_owned()))
}

impl Course {
    /// Nothing: [`check`] comes first.
    pub(crate) fn generation(&self, _: &[Vec<f64>]) -> Result<Option<Vec<Vec<f64>>>, Error> {
        check().map(|()| None)
    }
}
