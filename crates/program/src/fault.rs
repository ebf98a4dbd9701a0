//! The reasons why a call is not done: an errno that the program gets, or an end of the session.

use crate::error::Error;

/// The reason why a call is not done.
#[derive(Debug)]
pub(crate) enum Fault {
    /// The program gets this errno.
    Errno(i32),
    /// The session ends.
    Session(Error),
}

impl From<Error> for Fault {
    fn from(error: Error) -> Self {
        Self::Session(error)
    }
}
