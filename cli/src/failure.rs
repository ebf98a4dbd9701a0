//! The end of a command that has failed: a line on stderr, and an exit code.

use std::process::ExitCode;

use crate::error::{self, ReaderGone, Refused};
use crate::text::tell;

/// Prints the error, unless it is that the reader of an output has gone, and gives the exit code.
pub(crate) fn told(error: &anyhow::Error) -> ExitCode {
    if !error.is::<ReaderGone>() {
        tell!("error: {}", error::text(error));
    }
    exit_code(error)
}

/// The exit code of an error. For [`ReaderGone`] it is that of a program which the signal SIGPIPE has ended.
fn exit_code(error: &anyhow::Error) -> ExitCode {
    ExitCode::from(if error.is::<Refused>() {
        2
    } else if error.is::<ReaderGone>() {
        141
    } else {
        1
    })
}
