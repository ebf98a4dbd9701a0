//! The provocations: what happens to a brain in a run.

use std::fmt;
use std::time::Duration;

use baudbot_proto::{REASON, RESTART};
use tonic::metadata::{MetadataMap, MetadataValue};
use tonic::{Code, Status};

/// What happens to a brain in a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Provocation {
    /// Nothing: ten seconds in lockstep.
    Plain,
    /// The same once more.
    Again,
    /// A second robot, whose brain thinks for longer, so that Turns often omit it.
    TwoRobots,
    /// The data sheet has its sensors in the opposite order.
    Reversed,
    /// There are a sensor of an unknown kind with a cable of its own, and responses of an unknown kind.
    Unknown,
    /// No reading arrives in the first Turns.
    NoReading,
    /// No reading of the first sensor ever arrives.
    MissingSensor,
    /// All sensors say −1.
    NoEcho,
    /// The world is reset.
    Reset,
    /// The run is over, and then the world is reset.
    End,
    /// The world is paused for a while.
    Pause,
    /// The stream is lost.
    Cut,
    /// The server comes a second after the brain.
    Late,
    /// The server refuses the brain.
    Refused(Code),
    /// The world is deleted.
    Deleted,
    /// An operator asks the brain to restart.
    Restart,
    /// Turns come in bursts, in a world that does not wait for the brain.
    Burst,
    /// Bytes of a cable come one Turn later, cut anywhere.
    Split,
}

/// The refusals after which a program has nothing to wait for.
pub(crate) const REFUSALS: [Code; 7] = [
    Code::Unauthenticated,
    Code::PermissionDenied,
    Code::NotFound,
    Code::AlreadyExists,
    Code::InvalidArgument,
    Code::FailedPrecondition,
    Code::ResourceExhausted,
];

/// The words with which a server of the kit refuses.
pub(crate) const REFUSED: &str = "refused on purpose by `baudbot conform`";

/// The number of answered Turns after which a thing happens.
pub(crate) const AFTER: usize = 25;

impl Provocation {
    /// All of them, in the order in which they are tried.
    pub fn all() -> impl Iterator<Item = Self> {
        use Provocation::{
            Again, Burst, Cut, Deleted, End, Late, MissingSensor, NoEcho, NoReading, Pause, Plain, Reset,
            Restart, Reversed, Split, TwoRobots, Unknown,
        };
        let others = [
            Plain,
            Again,
            TwoRobots,
            Reversed,
            Unknown,
            NoReading,
            MissingSensor,
            NoEcho,
            Reset,
            End,
            Pause,
            Cut,
            Late,
            Deleted,
            Restart,
            Burst,
            Split,
        ];
        others.into_iter().chain(REFUSALS.map(Self::Refused))
    }

    /// The time for which the server is not there when the brain begins.
    pub(crate) fn server_comes_after(self) -> Option<Duration> {
        (self == Self::Late).then_some(Duration::from_secs(1))
    }

    /// The error with which each stream is answered.
    pub(crate) fn refusal(self) -> Option<Status> {
        if let Self::Refused(code) = self { Some(Status::new(code, REFUSED)) } else { None }
    }

    /// The error with which the first stream ends in the middle.
    pub(crate) fn broken_off(self) -> Option<Status> {
        if self == Self::Cut {
            return Some(Status::unavailable("the connection was cut on purpose by `baudbot conform`"));
        }
        if self != Self::Restart {
            return None;
        }
        let mut trailers = MetadataMap::new();
        trailers.insert(REASON, MetadataValue::from_static(RESTART));
        let words = "an operator asks the brain to restart";
        Some(Status::with_metadata(Code::Aborted, words, trailers))
    }

    /// Whether a brain may come back in it.
    pub(crate) fn has_two_streams(self) -> bool {
        matches!(self, Self::Cut | Self::Restart)
    }

    /// Whether the brain has a second robot.
    pub(crate) fn has_two_robots(self) -> bool {
        self == Self::TwoRobots
    }

    /// Whether the world goes by the wall clock.
    pub(crate) fn is_timed(self) -> bool {
        self == Self::Burst
    }
}

impl fmt::Display for Provocation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Plain => "ten seconds in lockstep",
            Self::Again => "the same once more",
            Self::TwoRobots => "two robots on one stream",
            Self::Reversed => "sensors in the opposite order",
            Self::Unknown => "kinds that the contract does not have yet",
            Self::NoReading => "no readings at first",
            Self::MissingSensor => "a sensor without readings",
            Self::NoEcho => "readings of -1",
            Self::Reset => "a reset",
            Self::End => "the end of the run",
            Self::Pause => "a pause",
            Self::Cut => "a lost connection",
            Self::Late => "a server that comes later",
            Self::Refused(code) => return write!(f, "a refusal: {}", name(*code)),
            Self::Deleted => "a world that is deleted",
            Self::Restart => "a request to restart",
            Self::Burst => "Turns in bursts",
            Self::Split => "bytes that are split anywhere",
        })
    }
}

/// A code of gRPC's as the contract writes it.
pub(crate) fn name(code: Code) -> &'static str {
    match code {
        Code::Ok => "OK",
        Code::Cancelled => "CANCELLED",
        Code::Unknown => "UNKNOWN",
        Code::InvalidArgument => "INVALID_ARGUMENT",
        Code::DeadlineExceeded => "DEADLINE_EXCEEDED",
        Code::NotFound => "NOT_FOUND",
        Code::AlreadyExists => "ALREADY_EXISTS",
        Code::PermissionDenied => "PERMISSION_DENIED",
        Code::ResourceExhausted => "RESOURCE_EXHAUSTED",
        Code::FailedPrecondition => "FAILED_PRECONDITION",
        Code::Aborted => "ABORTED",
        Code::OutOfRange => "OUT_OF_RANGE",
        Code::Unimplemented => "UNIMPLEMENTED",
        Code::Internal => "INTERNAL",
        Code::Unavailable => "UNAVAILABLE",
        Code::DataLoss => "DATA_LOSS",
        Code::Unauthenticated => "UNAUTHENTICATED",
    }
}
