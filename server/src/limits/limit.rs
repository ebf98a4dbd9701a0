//! All limits as one table, and the words of refusals.

use std::fmt;
use std::time::Duration;

use tonic::metadata::MetadataValue;
use tonic::{Code, Status};

/// Makes [`Limit`] and [`LIMITS`] of the lines of the table, so that the two agree.
macro_rules! limits {
    ($($limit:ident: $name:literal, $option:literal, $unit:expr, $usual:expr, $counted:expr, $words:literal, $remedy:literal;)*) => {
        /// A limit of a server.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Limit {
            $(#[doc = $words] $limit,)*
        }

        /// All limits, in their order.
        pub const LIMITS: [LimitInfo; [$(Limit::$limit),*].len()] = [$(LimitInfo {
            limit: Limit::$limit,
            name: $name,
            option: $option,
            unit: $unit,
            usual: $usual,
            counted: $counted,
            help: $words,
            remedy: $remedy,
        }),*];
    };
}

// The name in metrics, the option, the unit, the usual value, the place of its count, what it limits, and the advice to whom it refuses.
limits! {
    Connections: "connections", "--max-connections", ONE_OR_MORE, Usual::Files, Counted::InServer,
        "Maximum number of connections at a time, including pages\n\nAt the limit, a new connection replaces one that has made no request \
        yet or presented no token; if there is none, the new one is refused. At least 32 of the open files that the program may have \
        (`ulimit -Hn`) are reserved for other uses.", "close one";
    ConnectionsPerAddress: "connections_per_address", "--max-connections-per-address", ONE_OR_MORE, Usual::HalfOfConnections,
        Counted::ByCaller, "Maximum number of connections from one address, or from one user over Unix sockets", "close one";
    ConnectionsPerToken: "connections_per_token", "--max-connections-per-token", ONE_OR_MORE, Usual::ForOthers(256),
        Counted::ByCaller, "Maximum number of connections with one token", "close one";
    StreamsPerConnection: "streams_per_connection", "--max-streams-per-connection", ONE_OR_MORE, Usual::Number(4096),
        Counted::Elsewhere, "Maximum number of open calls of one connection", "end one, or connect again";
    StreamsPerCaller: "streams_per_caller", "--max-streams-per-caller", ONE_OR_MORE, Usual::ForOthers(1024), Counted::ByCaller,
        "Maximum number of open calls of one caller, which is a token or an address", "end one";
    RequestsPerS: "requests_per_s", "--max-requests-per-s", Unit::Things(1, 1_000_000), Usual::ForOthers(2000), Counted::Elsewhere,
        "Maximum number of calls per second that one caller begins; messages in an open stream do not count", "try again later";
    Worlds: "worlds", "--max-worlds", ONE_OR_MORE, Usual::Number(crate::MAX_WORLDS as u64), Counted::InServer,
        "Maximum number of worlds", "delete one";
    WorldsPerCaller: "worlds_per_caller", "--max-worlds-per-caller", NONE_OR_MORE, Usual::ForOthers(512), Counted::ByCaller,
        "Maximum number of worlds that one caller has created", "delete one";
    Robots: "robots", "--max-robots", NONE_OR_MORE, Usual::Number(1_000_000), Counted::InServer,
        "Maximum number of robots in all worlds", "delete a world";
    RobotsPerWorld: "robots_per_world", "--max-robots-per-world", NONE_OR_MORE, Usual::Number(10_000), Counted::Elsewhere,
        "Maximum number of robots in one world", "make several worlds";
    WorldsPerTrainer: "worlds_per_trainer", "--max-worlds-per-trainer", ONE_OR_MORE, Usual::Number(1024), Counted::Elsewhere,
        "Maximum number of worlds that one stream of a trainer opens", "open several streams";
    Snapshots: "snapshots", "--max-snapshots", NONE_OR_MORE, Usual::Number(65_536), Counted::InServer,
        "Maximum number of snapshots of all worlds", "delete a world that has some";
    SnapshotsPerWorld: "snapshots_per_world", "--max-snapshots-per-world", ONE_OR_MORE, Usual::Number(64), Counted::Elsewhere,
        "Maximum number of snapshots of one world; further ones replace the oldest", "the oldest has gone";
    Memory: "memory_bytes", "--max-memory", Unit::Bytes, Usual::HalfOfMemory, Counted::Memory,
        "Maximum memory for scenarios, states and snapshots, such as 500M, 8G or 25%", "delete a world";
    Parsing: "parsing", "--max-parsing", ONE_OR_MORE, Usual::Processors, Counted::Parsing,
        "Maximum number of scenarios, states and recordings parsed at a time", "wait";
    Waiting: "waiting", "--max-waiting", NONE_OR_MORE, Usual::Number(256), Counted::Waiting,
        "Maximum number of requests that wait for parsing", "try again in a second";
    OverloadAfter: "overload_after_s", "--overload-after", Unit::Seconds(0, 3600), Usual::Number(3), Counted::Lag,
        "Refuse to start worlds once worlds in real time have lagged for this many seconds; 0 disables this\n\nA world lags if it skips \
        time because it is behind the wall clock by more than its pace allows. Worlds in lockstep are always started.",
        "pause a world, or try again later";
    Unread: "unread_bytes", "--max-unread", Unit::Bytes, Usual::Number(128 << 20), Counted::Unread,
        "Maximum amount of data that waits for clients to read it\n\nBeyond this, the slowest stream of the caller with the most unread data \
        ends.", "read what you ask for";
    UnreadPerCaller: "unread_bytes_per_caller", "--max-unread-per-caller", Unit::Bytes, Usual::ForOthers(64 << 20),
        Counted::UnreadByCaller, "Maximum amount of data that waits for one caller, whose slowest stream then ends", "read what you ask for";
    UnreadPerStream: "unread_bytes_per_stream", "--max-unread-per-stream", Unit::Bytes, Usual::Number(16 << 20), Counted::Elsewhere,
        "Maximum amount of data that waits for one stream of an observer, which then misses frames", "read what you ask for";
}

const ONE_OR_MORE: Unit = Unit::Things(1, u32::MAX);
const NONE_OR_MORE: Unit = Unit::Things(0, u32::MAX);

/// The description of a limit.
#[derive(Clone, Copy, Debug)]
pub struct LimitInfo {
    /// The limit.
    pub limit: Limit,
    /// The name of the limit in metrics.
    pub name: &'static str,
    /// The option that changes it.
    pub option: &'static str,
    /// The unit of its value, with the least and the most that can be given.
    pub unit: Unit,
    /// The limit's default.
    pub usual: Usual,
    /// The thing that it limits, in words. Further paragraphs have more about it.
    pub help: &'static str,
    /// The advice to a client that is refused.
    remedy: &'static str,
    /// The place that counts how much of it is used.
    pub(super) counted: Counted,
}

/// The unit of a value, with the least and the most that can be given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "they say it themselves")]
pub enum Unit {
    Things(u32, u32),
    Seconds(u32, u32),
    Bytes,
}

/// The value of a limit where none is given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Usual {
    /// The default holds for all callers.
    Number(u64),
    /// The default holds for others than the user who runs the server.
    ForOthers(u64),
    /// The default follows from the number of files that the process may have open.
    Files,
    /// Half of all connections, for others than the user who runs the server.
    HalfOfConnections,
    /// Half of the machine's, or of its container's. The rest is for connections, for what ticks need meanwhile, and for lists of
    /// worlds that run, which have room for more than is in them.
    HalfOfMemory,
    /// One for each processor.
    Processors,
}

/// The place that counts how much of a limit is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Counted {
    /// The limit counts for the server, as [places](super::Place).
    InServer,
    /// The limit counts for each caller or address, as what it has [taken](super::Taken).
    ByCaller,
    /// The limit counts beside its object, such as one connection.
    Elsewhere,
    Memory,
    Parsing,
    Waiting,
    Lag,
    Unread,
    UnreadByCaller,
}

impl Usual {
    /// Whether it holds for others than the user who runs the server.
    pub(super) const fn is_for_others(self) -> bool {
        match self {
            Self::ForOthers(_) | Self::HalfOfConnections => true,
            Self::Number(_) | Self::Files | Self::HalfOfMemory | Self::Processors => false,
        }
    }
}

impl Limit {
    /// The description of the limit.
    pub const fn info(self) -> &'static LimitInfo {
        &LIMITS[self as usize]
    }
}

impl LimitInfo {
    /// The limit's default, in words.
    pub fn usual_words(&self) -> String {
        let amount = |n: u64| if self.unit == Unit::Bytes { format!("{}M", n >> 20) } else { n.to_string() };
        match self.usual {
            Usual::Number(n) => amount(n),
            Usual::ForOthers(n) => format!("{}; unlimited for your own programs", amount(n)),
            Usual::Files => "three quarters of the limit of open files, at most 16384".to_owned(),
            Usual::HalfOfConnections => "half of --max-connections; for this machine, all".to_owned(),
            Usual::HalfOfMemory => "50% of the memory of the machine or its container".to_owned(),
            Usual::Processors => "one for each processor".to_owned(),
        }
    }
}

/// A limit is reached.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) struct Exceeded {
    pub(crate) limit: Limit,
    /// The excess: the account, the number and the thing.
    pub(crate) what: String,
    /// The time after which another attempt may succeed, if it is known.
    pub(crate) retry_after: Option<Duration>,
}

impl fmt::Display for Exceeded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let LimitInfo { option, remedy, .. } = self.limit.info();
        write!(f, "{}, which is its limit; ", self.what)?;
        match self.retry_after {
            Some(after) => write!(f, "try again in {} ms", after.as_micros().div_ceil(1000))?,
            None => f.write_str(remedy)?,
        }
        write!(f, ", or start the server with a larger {option}")
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

/// The trailer of gRPC for the time until another attempt, in milliseconds.
pub(crate) const PUSHBACK: &str = "grpc-retry-pushback-ms";

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn each_limit_has_a_name_and_an_option_of_its_own() {
        let names: BTreeSet<_> = LIMITS.iter().map(|info| info.name).collect();
        let options: BTreeSet<_> = LIMITS.iter().map(|info| info.option).collect();
        assert_eq!((names.len(), options.len()), (LIMITS.len(), LIMITS.len()));
    }

    #[test]
    fn a_refusal_says_when_to_try_again() {
        let what = "the token `alice` has made 3 requests in a second".to_owned();
        let retry_after = Some(Duration::from_micros(12_345));
        let status = Status::from(Exceeded { limit: Limit::RequestsPerS, what, retry_after });
        let text = "the token `alice` has made 3 requests in a second, which is its limit; try again in 13 ms, or start \
                    the server with a larger --max-requests-per-s";
        assert_eq!((status.code(), status.message()), (Code::ResourceExhausted, text));
        assert_eq!(status.metadata().get(PUSHBACK).unwrap(), "13");
    }
}
