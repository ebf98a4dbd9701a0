//! Errors as this program prints them, in one line. `failure` prints them.

use std::error::Error;
use std::fmt;
use std::io;
use std::os::unix::fs::FileTypeExt;

use baudbot_fields::printable::Printable;
use baudbot_server::{Address, ServerError};
use tonic::Code;

/// The command asks for something that cannot be: a scenario or an argument has to be changed. Exit code 2,
/// as for options that do not exist; anything that goes wrong later is exit code 1.
#[derive(Debug)]
pub(crate) struct Refused(String);

impl Refused {
    pub(crate) fn error(text: impl Into<String>) -> anyhow::Error {
        Self(text.into()).into()
    }
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl Error for Refused {}

/// The reader of an output has closed it, as `head` does after its last line. That is no error to report.
#[derive(Debug)]
pub(crate) struct ReaderGone;

impl fmt::Display for ReaderGone {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the reader of the output has closed it")
    }
}

impl Error for ReaderGone {}

/// The error that an output, such as stdout, could not be written.
pub(crate) fn from_output(error: io::Error, name: &str) -> anyhow::Error {
    if error.kind() == io::ErrorKind::BrokenPipe {
        return ReaderGone.into();
    }
    anyhow::Error::from(error).context(format!("cannot write {name}"))
}

/// The error with its causes. A cause that is in the text before it already is left out.
pub(crate) fn text(error: &anyhow::Error) -> String {
    let mut text = error.to_string();
    for cause in error.chain().skip(1).map(ToString::to_string) {
        if !text.contains(&cause) {
            text = format!("{text}: {cause}");
        }
    }
    text.trim_end().to_owned()
}

/// The error of a server that did not start: the command asks for something impossible, or something went wrong.
pub(crate) fn from_builder(error: ServerError) -> anyhow::Error {
    let refused = match &error {
        ServerError::NotLoopback { .. } | ServerError::TrainerNotLocal { .. } | ServerError::Tokens(_) => {
            true
        }
        ServerError::World(status) => matches!(status.code(), Code::AlreadyExists | Code::InvalidArgument),
        ServerError::Bind { .. }
        | ServerError::LocalToken(_)
        | ServerError::NoTrainers
        | ServerError::Reflection(_)
        | ServerError::Pipe(_) => false,
    };
    if let ServerError::Bind { source, address } = &error
        && source.kind() == io::ErrorKind::AddrInUse
    {
        if let Address::Unix(path) = address
            && path.symlink_metadata().is_ok_and(|metadata| !metadata.file_type().is_socket())
        {
            return anyhow::anyhow!(
                "{error}: there is a file that is not a socket; move it away, or choose another path"
            );
        }
        let remedy = "another program listens there, perhaps another baudbot server; end it, or choose another address with \
                      --listen or --viewer (127.0.0.1:0 picks a free one)";
        return anyhow::anyhow!("{error}: {remedy}");
    }
    if refused { Refused::error(error.to_string()) } else { error.into() }
}

/// The error of a server's refusal, in its own words, or of a missing answer.
pub(crate) fn from_server(status: &tonic::Status) -> anyhow::Error {
    // A status that the server sent has no cause here; one that stands for a broken connection has.
    match status.source() {
        Some(_) => anyhow::anyhow!("the connection to the server is lost ({})", Printable(status.message())),
        None if status.code() == Code::Unimplemented && status.message().is_empty() => anyhow::anyhow!(
            "the server does not offer this call at this address: a run's address for brains serves only brains, and older servers offer \
             fewer calls"
        ),
        None => anyhow::anyhow!("the server says: {}", Printable(status.message())),
    }
}

#[cfg(test)]
mod tests {
    use anyhow::anyhow;

    use super::text;

    #[test]
    fn causes_are_told_once() {
        let error = anyhow!("refused").context("cannot listen: refused").context("no server");
        assert_eq!(text(&error), "no server: cannot listen: refused");
    }
}
