//! Errors between a brain and its server.

use std::error::Error as StdError;
#[cfg(feature = "network")]
use std::io;

use baudbot_fields::printable::Printable;
use baudbot_proto::convert::Breach;
use baudbot_proto::{REASON, RESTART};
use thiserror::Error;
#[cfg(feature = "network")]
use tokio_rustls::rustls;
use tonic::Code;

/// The reason why a brain cannot continue.
#[derive(Debug, Error)]
pub enum Error {
    /// The address is none.
    #[error("`{address}` is not a server address; write HOST:PORT, https://HOST:PORT or unix:/PATH")]
    Address {
        /// The address as it was given.
        address: String,
    },
    /// No server answers.
    #[error("no server answers at {address} ({cause}); is `baudbot serve` running there?")]
    Connect {
        /// The address as it was given.
        address: String,
        /// The network's message.
        cause: String,
    },
    /// There is a token for this server, which would go to another machine without TLS.
    #[error(
        "no token is sent to {authority} without TLS, as that is another machine: write https://{authority}, or, if the server is behind a proxy, the proxy's https:// address"
    )]
    Unprotected {
        /// `HOST:PORT`.
        authority: String,
    },
    /// The server's certificate is not one that this program trusts.
    #[error("the certificate of the server at {address} {problem}")]
    ServerCertificate {
        /// The address as it was given.
        address: String,
        /// The problem, as the end of a sentence.
        problem: String,
    },
    /// The server asks for a client certificate, and does not accept what it was shown.
    #[error("the server at {address} {problem}")]
    ClientCertificate {
        /// The address as it was given.
        address: String,
        /// The demand, as the end of a sentence.
        problem: String,
    },
    /// A token, a certificate or a key is unsound.
    #[error("{place}: {problem}")]
    Credentials {
        /// The file or the variable.
        place: String,
        /// The fault in it.
        problem: String,
    },
    /// The server refused, or ended the stream with an error.
    #[error("the server says: {message} ({code:?})")]
    Status {
        /// The kind of error; the contract lists them.
        code: Code,
        /// The server's words. They may quote other users' text, so control characters in them are escaped.
        message: String,
    },
    /// The operator wants the brain to start over. A program that can makes its brain afresh and attaches it to the same
    /// robots, which are free by now; one that cannot ends, as one that was thrown off ([`Status`](Self::Status) with
    /// [`Code::Aborted`]) does.
    #[error("the operator asked this brain to restart, which its program does not support")]
    Restart,
    /// The connection broke.
    #[error("the connection to the server is lost ({message})")]
    Lost {
        /// The network's message.
        message: String,
    },
    /// The server does not keep to the contract.
    #[error("the server breaks the contract `baudbot.v1`: {0}")]
    Protocol(#[from] Breach),
    /// A fleet was given too many or too few brains.
    #[error("{brains} brains for {robots} robots; a fleet needs one each")]
    Brains {
        /// Robots of the fleet.
        robots: usize,
        /// Brains given.
        brains: usize,
    },
}

/// The remedy for a connection to the wrong one of a server's listeners.
const OTHER_ADDRESS: &str = "this address is not for brains; connect to that of `baudbot serve --listen`, and not to that of `--trainer`";

impl From<tonic::Status> for Error {
    fn from(status: tonic::Status) -> Self {
        // A status of the transport's own has its cause as source; one that the server sent has none.
        if let Some(source) = status.source() {
            return Self::Lost { message: Printable(root(source)).to_string() };
        }
        if status.metadata().get(REASON).is_some_and(|reason| reason == RESTART) {
            return Self::Restart;
        }
        let words = match (status.code(), status.message()) {
            // A server answers so for a service that it does not have.
            (Code::Unimplemented, "") => OTHER_ADDRESS,
            (_, words) => words,
        };
        Self::Status { code: status.code(), message: Printable(words).to_string() }
    }
}

impl Error {
    /// Whether the same may go well a while later: the server is not there, the connection broke, or another program has the
    /// robot, which may be this one's own connection before the server has noticed that it is lost. What a server refuses, or
    /// ends, for any other reason it would refuse again.
    pub fn may_pass(&self) -> bool {
        match self {
            Self::Connect { .. } | Self::Lost { .. } => true,
            Self::Status { code, .. } => matches!(code, Code::Unavailable | Code::AlreadyExists),
            Self::Address { .. }
            | Self::Unprotected { .. }
            | Self::ServerCertificate { .. }
            | Self::ClientCertificate { .. }
            | Self::Credentials { .. }
            | Self::Restart
            | Self::Protocol(_)
            | Self::Brains { .. } => false,
        }
    }

    /// Whether another connection has the robot.
    #[cfg(feature = "network")]
    pub(crate) fn is_held(&self) -> bool {
        matches!(self, Self::Status { code: Code::AlreadyExists, .. })
    }
}

/// The error of TLS in a connection's error, if it is one.
#[cfg(feature = "network")]
pub(crate) fn tls_error(error: &io::Error) -> Option<&rustls::Error> {
    error.get_ref().and_then(|inner| inner.downcast_ref())
}

/// The innermost error has the cause ("connection refused"); those around it have only the place.
pub(crate) fn root<'a>(error: &'a (dyn StdError + 'static)) -> &'a (dyn StdError + 'static) {
    let mut error = error;
    while let Some(source) = error.source() {
        error = source;
    }
    error
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_others_that_a_server_passes_on_are_shown_and_not_obeyed() {
        let held = "held by `\u{1b}]0;pwned\u{7}\u{9b}2J\u{202e}µ\n`";
        let text = Error::from(tonic::Status::already_exists(held)).to_string();
        let expected = r"the server says: held by `\u{1b}]0;pwned\u{7}\u{9b}2J\u{202e}µ\n` (AlreadyExists)";
        assert_eq!(text, expected);
    }

    #[test]
    fn a_brain_at_the_address_for_trainers_is_told_where_to_connect() {
        let text = Error::from(tonic::Status::unimplemented("")).to_string();
        assert!(text.contains("connect to that of `baudbot serve --listen`"), "{text}");
        let text = Error::from(tonic::Status::unimplemented("no such thing")).to_string();
        assert_eq!(text, "the server says: no such thing (Unimplemented)");
    }
}
