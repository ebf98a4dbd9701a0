//! Messages to a world, and its answers. Requests have the world's types, which `convert` makes of the contract's. Answers may have
//! those of the contract, so that nothing is copied twice.

mod attach;
mod handle;
mod request;
mod truth;

use std::sync::Arc;

use baudbot_recording::RecordedRun;
use baudbot_sim::Scenario;
use baudbot_sim::cable::Cable;
use tokio::sync::{OwnedSemaphorePermit, oneshot};
use tonic::Status;

use crate::endpoint::Write;
use crate::limits::Outbox;
use crate::measures::Measures;
use crate::report::{CoverageReport, Report, Standing, Version};
pub(crate) use attach::{Attach, Attached, Deliveries, Delivery, Lease, Recipient, Told};
pub(crate) use handle::WorldHandle;
pub(crate) use request::{RecordConfig, Request};
pub(crate) use truth::Truth;

/// The channel for the answer to a request.
pub(crate) type Reply<T> = oneshot::Sender<Result<T, Status>>;

/// A message to a world.
pub(crate) enum Message {
    /// The request of an operator.
    Request(Request, Reply<Report>),
    /// The holder of a token is going to request something.
    Order(Order),
    Describe(oneshot::Sender<Arc<Scenario>>),
    /// Asks which recording is being replayed, if any is.
    DescribeReplay(oneshot::Sender<Option<Arc<RecordedRun>>>),
    Measure(oneshot::Sender<Measures>),
    Cover(oneshot::Sender<CoverageReport>),
    /// Asks how the world stands, unless it stands as it did at this version.
    Stand(Option<Version>, oneshot::Sender<Standing>),
    Watch(Watch),
    WatchCable(WatchCable),
    Attach(Attach, Reply<Attached>),
    Step(Step),
    Detach {
        session: u64,
        /// The reason for the log.
        why: String,
    },
    /// The server stops.
    Stop,
}

/// A request, for a recording: who makes it, and what it is.
pub(crate) struct Order {
    /// The name of the token.
    pub(crate) by: String,
    /// The request in words.
    pub(crate) what: &'static str,
}

/// A message of a brain: the answer to a Turn, or something it was not asked for.
pub(crate) struct Step {
    pub(crate) session: u64,
    /// The number of the Turn that it answers; 0 for none.
    pub(crate) turn: u64,
    pub(crate) writes: Vec<Write>,
    /// Given back when the message is handled: it bounds how many Steps of a stream wait for that.
    pub(crate) permit: OwnedSemaphorePermit,
}

/// An observer that wants to see the world.
pub(crate) struct Watch {
    pub(crate) every_ticks: u64,
    /// The robots of which it wants details.
    pub(crate) details: Vec<usize>,
    /// Whether details have the signals of the pins of their chips; pulses with a shorter period, in nanoseconds, are
    /// summed up.
    pub(crate) pins_finest_ns: Option<u64>,
    pub(crate) frames: Outbox,
}

/// The request of an observer of a cable's bytes.
pub(crate) struct WatchCable {
    pub(crate) robot: usize,
    pub(crate) cable: Cable,
    pub(crate) news: Outbox,
}
