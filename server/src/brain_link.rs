//! The brains' service: a stream that is the laptop's end of one or more serial cables.

use std::pin::Pin;
use std::sync::Arc;

use baudbot_proto::v1;
use baudbot_proto::v1::attach_request::Request as Content;
use baudbot_proto::v1::brain_link_service_server::BrainLinkService;
use baudbot_sim::printable::{Printable, is_printable};
use prost::Message as _;
use tokio::sync::{Semaphore, mpsc};
use tokio_stream::wrappers::ReceiverStream;
use tokio_stream::{Stream, StreamExt};
use tonic::{Request, Response, Status, Streaming};
use tracing::Instrument;

use crate::beliefs;
use crate::convert;
use crate::endpoint::{Endpoint, Write};
use crate::letter::{Attach, Attached, Delivery, Letter};
use crate::registry::Registry;
use crate::sessions::RESERVED;

/// Turns that wait for a brain that does not read before it loses some.
const TURNS_AHEAD: usize = 256;

/// Steps of one stream that the world takes in a tick; further ones wait in the network.
const STEPS_A_TICK: usize = 64;

/// Longest name that a brain may give itself.
const MAX_BRAIN_NAME: usize = 64;

pub(crate) struct BrainLink {
    pub(crate) registry: Registry,
}

#[tonic::async_trait]
impl BrainLinkService for BrainLink {
    type AttachStream = Pin<Box<dyn Stream<Item = Result<v1::AttachResponse, Status>> + Send>>;

    async fn attach(
        &self,
        request: Request<Streaming<v1::AttachRequest>>,
    ) -> Result<Response<Self::AttachStream>, Status> {
        let mut requests = request.into_inner();
        let hello = match requests.message().await?.and_then(|request| request.request) {
            Some(Content::Hello(hello)) => check(hello)?,
            Some(Content::Step(_) | Content::Annotate(_)) => {
                return Err(Status::failed_precondition("request: the first request must be a Hello"));
            }
            None => return Err(Status::invalid_argument("request: the first request must be a Hello")),
        };
        let world = self.registry.find("hello.world", &hello.world)?;
        let (deliveries, stream) = mpsc::channel(TURNS_AHEAD + RESERVED);
        let raw = hello.mode() == v1::PortMode::Raw;
        let span = tracing::info_span!("brain", world = world.name(), brain = hello.brain, raw);
        let attach = Attach {
            robots: hello.robots,
            brain: hello.brain,
            raw,
            memory_bytes: hello.memory_bytes,
            steady: hello.thinks_as_scenario,
            deliveries: deliveries.clone(),
            world: world.clone(),
        };
        let attached = world.ask(|reply| Letter::Attach(attach, reply)).instrument(span.clone()).await??;
        let welcome = convert::welcome(&attached);
        // As long as the brain stays.
        tokio::spawn(listen(requests, attached, raw, deliveries).instrument(span));
        let turns = ReceiverStream::new(stream).map(convert::delivery);
        Ok(Response::new(Box::pin(tokio_stream::once(Ok(welcome)).chain(turns))))
    }
}

fn check(hello: v1::Hello) -> Result<v1::Hello, Status> {
    if hello.robots.is_empty() {
        return Err(Status::invalid_argument("hello.robots: must name at least one robot"));
    }
    let length = hello.brain.chars().count();
    if length > MAX_BRAIN_NAME {
        let text = format!("hello.brain: has {length} characters, the limit is {MAX_BRAIN_NAME}");
        return Err(Status::invalid_argument(text));
    }
    if !hello.brain.chars().all(is_printable) {
        let name = Printable(&hello.brain);
        let text = format!("hello.brain: must be on one line and without control characters, is `{name}`");
        return Err(Status::invalid_argument(text));
    }
    Ok(hello)
}

/// Takes a brain's steps until it is gone or says something that makes no sense; then its robots are free.
async fn listen(
    mut requests: Streaming<v1::AttachRequest>,
    attached: Attached,
    raw: bool,
    deliveries: mpsc::Sender<Delivery>,
) {
    let Attached { mut lease, scenario, robots, beliefs, .. } = attached;
    lease.why = "its stream ended".to_owned();
    let endpoint = Endpoint::new(scenario, robots.clone(), raw);
    let publish = |annotate: v1::Annotate| {
        let (robot, belief) = checked(annotate, &robots)?;
        beliefs.publish(lease.session, robot, belief);
        Ok(())
    };
    let room = Arc::new(Semaphore::new(STEPS_A_TICK));
    let take_steps = async {
        while let Ok(Some(request)) = requests.message().await {
            let step = match request.request {
                Some(Content::Annotate(annotate)) => publish(annotate).map(|()| None),
                request => step_of(request, &endpoint).map(Some),
            };
            let (turn, writes) = match step {
                Ok(Some(step)) => step,
                Ok(None) => continue,
                Err(status) => {
                    lease.why = status.message().to_owned();
                    let _ = deliveries.try_send(Delivery::Close(status));
                    break;
                }
            };
            let Ok(permit) = Arc::clone(&room).acquire_owned().await else { break };
            let letter = Letter::Step { session: lease.session, turn, writes, permit };
            if lease.world.send(letter).is_err() {
                break;
            }
        }
    };
    // A stream that the world has closed, or whose reader is gone, has nothing more to say, even if it waits
    // for room in a world that stands.
    tokio::select! {
        () = take_steps => {}
        () = deliveries.closed() => {}
    }
}

/// What a brain publishes, and for which of the world's robots.
fn checked(annotate: v1::Annotate, robots: &[usize]) -> Result<(usize, v1::Belief), Status> {
    let slot = annotate.robot as usize;
    let Some(&robot) = robots.get(slot) else {
        let text = format!("annotate.robot: must be 0 to {}, is {slot}", robots.len() - 1);
        return Err(Status::invalid_argument(text));
    };
    let belief = annotate.belief.unwrap_or_default();
    let bytes = belief.encoded_len();
    if bytes > beliefs::MAX_BYTES {
        let text = format!("annotate.belief: has {bytes} bytes, the limit is {}", beliefs::MAX_BYTES);
        return Err(Status::invalid_argument(text));
    }
    check_lists(&belief)?;
    Ok((robot, belief))
}

/// Whether a page can show it: what is short on the wire may be long in memory.
fn check_lists(belief: &v1::Belief) -> Result<(), Status> {
    let too_many = |field: &str, n: usize, most: usize| {
        Status::invalid_argument(format!("annotate.belief.{field}: there are {n}, the limit is {most}"))
    };
    let lists = [("utilities", belief.utilities.len(), 256), ("path", belief.path.len(), 10_000)];
    if let Some((field, n, most)) = lists.into_iter().find(|(_, n, most)| n > most) {
        return Err(too_many(field, n, most));
    }
    let Some(map) = &belief.map else { return Ok(()) };
    let columns = map.columns as usize;
    let rows = map.cells.len().checked_div(columns).unwrap_or(0);
    if columns > MAX_MAP_SIDE || rows > MAX_MAP_SIDE || rows * columns != map.cells.len() {
        let cells = map.cells.len();
        let text = format!(
            "annotate.belief.map: {cells} cells in {columns} columns are no grid of at most {MAX_MAP_SIDE} a side"
        );
        return Err(Status::invalid_argument(text));
    }
    Ok(())
}

/// Most columns and rows of a map.
const MAX_MAP_SIDE: usize = 4096;

fn step_of(request: Option<Content>, endpoint: &Endpoint) -> Result<(u64, Vec<Write>), Status> {
    match request {
        Some(Content::Step(step)) => {
            let writes = convert::writes(step.robots);
            endpoint.check(&writes)?;
            Ok((step.turn, writes))
        }
        Some(Content::Hello(_)) => {
            Err(Status::failed_precondition("hello: this stream is attached already; open another one"))
        }
        Some(Content::Annotate(_)) | None => {
            Err(Status::invalid_argument("request: must be a Step or an Annotate"))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_brain_has_no_name_that_a_terminal_obeys() {
        let hello = |brain: &str| v1::Hello {
            brain: brain.to_owned(),
            robots: vec!["robot".to_owned()],
            ..Default::default()
        };
        assert!(check(hello("移动 µ: left=0.5")).is_ok());
        for hostile in ["\u{1b}[2J", "\u{9b}31m", "a\nb", "a\rb", "\u{202e}txt", "\u{2066}", "\u{7f}"] {
            let status = check(hello(hostile)).unwrap_err();
            assert_eq!(status.code(), tonic::Code::InvalidArgument);
            assert!(status.message().chars().all(is_printable), "{status:?}");
        }
    }
}
