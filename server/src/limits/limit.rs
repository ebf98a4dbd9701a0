//! The names of limits, and the words of refusals.

use std::fmt;
use std::time::Duration;

use tonic::metadata::MetadataValue;
use tonic::{Code, Status};

/// The limits of a server.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Limit {
    Connections,
    ConnectionsPerAddress,
    ConnectionsPerToken,
    StreamsPerConnection,
    StreamsPerCaller,
    Requests,
    Worlds,
    WorldsPerCaller,
    Robots,
    RobotsPerWorld,
    Snapshots,
    SnapshotsPerWorld,
    Memory,
    Waiting,
    Overload,
    UnreadPerStream,
    UnreadPerCaller,
    Unread,
}

impl Limit {
    /// All of them, in their order.
    pub(crate) const ALL: [Self; 18] = [
        Self::Connections,
        Self::ConnectionsPerAddress,
        Self::ConnectionsPerToken,
        Self::StreamsPerConnection,
        Self::StreamsPerCaller,
        Self::Requests,
        Self::Worlds,
        Self::WorldsPerCaller,
        Self::Robots,
        Self::RobotsPerWorld,
        Self::Snapshots,
        Self::SnapshotsPerWorld,
        Self::Memory,
        Self::Waiting,
        Self::Overload,
        Self::UnreadPerStream,
        Self::UnreadPerCaller,
        Self::Unread,
    ];

    /// Its name in metrics, the option that changes it, and what a client can do instead.
    const fn words(self) -> (&'static str, &'static str, &'static str) {
        match self {
            Self::Connections => ("connections", "--max-connections", "close one"),
            Self::ConnectionsPerAddress => {
                ("connections_per_address", "--max-connections-per-address", "close one")
            }
            Self::ConnectionsPerToken => {
                ("connections_per_token", "--max-connections-per-token", "close one")
            }
            Self::StreamsPerConnection => {
                ("streams_per_connection", "--max-streams-per-connection", "end one, or connect again")
            }
            Self::StreamsPerCaller => ("streams_per_caller", "--max-streams-per-caller", "end one"),
            Self::Requests => ("requests_per_s", "--max-requests-per-s", "try again later"),
            Self::Worlds => ("worlds", "--max-worlds", "delete one"),
            Self::WorldsPerCaller => ("worlds_per_caller", "--max-worlds-per-caller", "delete one"),
            Self::Robots => ("robots", "--max-robots", "delete a world"),
            Self::RobotsPerWorld => ("robots_per_world", "--max-robots-per-world", "make several worlds"),
            Self::Snapshots => ("snapshots", "--max-snapshots", "delete a world that has some"),
            Self::SnapshotsPerWorld => {
                ("snapshots_per_world", "--max-snapshots-per-world", "the oldest has gone")
            }
            Self::Memory => ("memory_bytes", "--max-memory", "delete a world"),
            Self::Waiting => ("waiting", "--max-waiting", "try again in a second"),
            Self::Overload => ("overload_after_s", "--overload-after", "pause a world, or try again later"),
            Self::UnreadPerStream => ("unread_bytes_per_stream", "--max-unread-per-stream", READ),
            Self::UnreadPerCaller => ("unread_bytes_per_caller", "--max-unread-per-caller", READ),
            Self::Unread => ("unread_bytes", "--max-unread", READ),
        }
    }

    /// Its name in metrics.
    pub(crate) const fn name(self) -> &'static str {
        self.words().0
    }

    /// The option that changes it.
    pub(crate) const fn option(self) -> &'static str {
        self.words().1
    }
}

/// The advice to a client for which too much waits.
const READ: &str = "read what you ask for";

/// A limit is reached.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) struct Exceeded {
    pub(crate) limit: Limit,
    /// The excess: the account, the number and the thing.
    pub(crate) what: String,
    /// When it is worth trying again, if that is known.
    pub(crate) retry_after: Option<Duration>,
}

impl fmt::Display for Exceeded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (_, option, remedy) = self.limit.words();
        write!(f, "{}, which is its limit; ", self.what)?;
        match self.retry_after {
            Some(after) => write!(f, "try again in {} ms", after.as_micros().div_ceil(1000))?,
            None => f.write_str(remedy)?,
        }
        write!(f, ", or start it with a larger {option}")
    }
}

impl From<Exceeded> for Status {
    fn from(exceeded: Exceeded) -> Self {
        // A client of a full server may try another one, or come back.
        let is_full = exceeded.limit == Limit::Connections;
        let code = if is_full { Code::Unavailable } else { Code::ResourceExhausted };
        let mut status = Self::new(code, exceeded.to_string());
        if let Some(after) = exceeded.retry_after {
            let ms = u64::try_from(after.as_micros().div_ceil(1000)).unwrap_or(u64::MAX);
            status.metadata_mut().insert(PUSHBACK, MetadataValue::from(ms));
        }
        status
    }
}

/// The trailer by which gRPC says when to try again, in milliseconds.
pub(crate) const PUSHBACK: &str = "grpc-retry-pushback-ms";

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn each_limit_has_a_name_and_an_option_of_its_own_and_a_place() {
        let names: BTreeSet<_> = Limit::ALL.iter().map(|limit| limit.name()).collect();
        let options: BTreeSet<_> = Limit::ALL.iter().map(|limit| limit.option()).collect();
        assert_eq!((names.len(), options.len()), (Limit::ALL.len(), Limit::ALL.len()));
        assert!(Limit::ALL.iter().enumerate().all(|(place, limit)| *limit as usize == place));
    }

    #[test]
    fn a_refusal_says_when_to_try_again() {
        let what = "the token `alice` has made 3 requests in a second".to_owned();
        let retry_after = Some(Duration::from_micros(12_345));
        let status = Status::from(Exceeded { limit: Limit::Requests, what, retry_after });
        let text = "the token `alice` has made 3 requests in a second, which is its limit; try again in 13 ms, or start it \
                    with a larger --max-requests-per-s";
        assert_eq!((status.code(), status.message()), (Code::ResourceExhausted, text));
        assert_eq!(status.metadata().get(PUSHBACK).unwrap(), "13");
    }
}
