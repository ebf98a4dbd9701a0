//! The brains' service: a stream that is the laptop's end of one or more serial cables.

mod service;
mod steps;

use std::pin::Pin;
use std::time::Duration;

use baudbot_fields::printable::{Printable, is_printable};
use baudbot_proto::v1;
use baudbot_proto::v1::attach_request::Request as Content;
use tokio_stream::{Stream, StreamExt};
use tonic::{Code, Request, Response, Status, Streaming};
use tracing::Instrument;

use crate::access::{Caller, caller_of};
use crate::annotate::checked;
use crate::audit::call::{by, note_robots};
use crate::beliefs::Beliefs;
use crate::convert::{self, AttachResponse};
use crate::endpoint::Mode;
use crate::message::{Attach, Attached, Deliveries, Lease, Message, Recipient, WorldHandle};
use crate::registry::Registry;
use crate::sessions::RESERVED;
pub(crate) use service::BrainLinkServer;
pub(crate) use steps::{CheckedStep, Steps, next_request};

/// Turns that wait for a brain that does not read. Further ones are lost.
pub(crate) const TURNS_AHEAD: usize = 256;

/// Longest name that a brain may give itself.
const MAX_BRAIN_NAME: usize = 64;

pub(crate) struct BrainLink {
    pub(crate) registry: Registry,
    /// The time for which a stream may be open without a Hello.
    pub(crate) patience: Duration,
}

/// The stream of responses to a brain.
type Responses = Pin<Box<dyn Stream<Item = Result<AttachResponse, Status>> + Send>>;

impl BrainLink {
    async fn attach(
        &self,
        request: Request<Streaming<v1::AttachRequest>>,
    ) -> Result<Response<Responses>, Status> {
        let caller = caller_of(&request)?;
        let mut requests = request.into_inner();
        let patience = self.patience;
        let first = tokio::time::timeout(patience, requests.message());
        let late = |_| Status::deadline_exceeded(format!("request: no Hello has come within {patience:?}"));
        let hello = match first.await.map_err(late)??.and_then(|request| request.request) {
            Some(Content::Hello(hello)) => hello,
            Some(Content::Step(_) | Content::Annotate(_)) => {
                return Err(Status::failed_precondition("request: the first request must be a Hello"));
            }
            None => return Err(Status::invalid_argument("request: the first request must be a Hello")),
        };
        let mode = check(&hello)?;
        note_robots([&hello]);
        for robot in &hello.robots {
            caller.may_drive(&hello.world, robot)?;
        }
        let told = what_it_is_told(&caller, &hello);
        let world = self.registry.find("hello.world", &hello.world).map_err(&told)?;
        let (deliveries, stream) = Deliveries::new(TURNS_AHEAD + RESERVED);
        let span = tracing::info_span!(
            "brain",
            world = world.name(),
            brain = hello.brain,
            by = caller.name(),
            ?mode
        );
        let recipient = Recipient::Brain(deliveries.clone());
        let attached = take_robots(&world, hello, mode, recipient).instrument(span.clone()).await;
        let attached = attached.map_err(told)?;
        let welcome = convert::first_response(&attached);
        // The task lives as long as the brain stays.
        tokio::spawn(listen(requests, attached, mode, deliveries).instrument(span));
        let turns = stream.map(convert::delivery);
        Ok(Response::new(Box::pin(tokio_stream::once(Ok(welcome)).chain(turns))))
    }
}

/// The status for a caller that may not observe and names something that does not exist: only that it does not exist,
/// and not what does.
fn what_it_is_told(caller: &Caller, hello: &v1::Hello) -> impl Fn(Status) -> Status + use<> {
    let hidden = (!caller.may_observe()).then(|| {
        let robots = hello.robots.join(", ");
        let (robots, world) = (Printable(&robots).to_string(), Printable(&hello.world).to_string());
        format!("hello: there is no robot `{robots}` in a world `{world}`")
    });
    move |status| match &hidden {
        Some(text) if status.code() == Code::NotFound => Status::not_found(text.clone()),
        Some(_) | None => status,
    }
}

/// Takes the robots of a Hello that has been checked.
///
/// # Errors
/// Why they cannot be had, with the field of the Hello.
pub(crate) async fn take_robots(
    world: &WorldHandle,
    hello: v1::Hello,
    mode: Mode,
    recipient: Recipient,
) -> Result<Attached, Status> {
    let attach = Attach {
        robots: hello.robots,
        brain: hello.brain,
        mode,
        memory_bytes: hello.memory_bytes,
        thinks_as_scenario: hello.thinks_as_scenario,
        stop_when_gone: hello.stop_when_gone,
        by: by(),
        recipient,
        world: world.clone(),
    };
    world.ask(|reply| Message::Attach(attach, reply)).await?
}

/// Checks a Hello. Gives the mode that it asks for.
pub(crate) fn check(hello: &v1::Hello) -> Result<Mode, Status> {
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
    check_mode(hello)
}

fn check_mode(hello: &v1::Hello) -> Result<Mode, Status> {
    match v1::PortMode::try_from(hello.mode) {
        Ok(v1::PortMode::Unspecified | v1::PortMode::Messages) if hello.serial_port => {
            Err(Status::invalid_argument("hello.serial_port: needs RAW mode; a serial port passes bytes on"))
        }
        Ok(v1::PortMode::Unspecified | v1::PortMode::Messages) => Ok(Mode::Messages),
        Ok(v1::PortMode::Raw) if hello.stop_when_gone => {
            let text =
                "hello.stop_when_gone: needs MESSAGES mode; in RAW mode the server does not decode commands";
            Err(Status::invalid_argument(text))
        }
        Ok(v1::PortMode::Raw) if hello.serial_port => Ok(Mode::SerialPort),
        Ok(v1::PortMode::Raw) => Ok(Mode::Raw),
        Err(_) => {
            let text = format!("hello.mode: must be 0 to 2 (see PortMode), is {}", hello.mode);
            Err(Status::invalid_argument(text))
        }
    }
}

/// Takes a brain's requests until it is gone or one of them is invalid; then its robots are released.
async fn listen(
    requests: Streaming<v1::AttachRequest>,
    attached: Attached,
    mode: Mode,
    deliveries: Deliveries,
) {
    let steps = Steps::new(&attached, mode);
    let Attached { mut lease, robots, beliefs, .. } = attached;
    lease.why = "its stream ended".to_owned();
    let listener = Listener { steps, robots, beliefs };
    tokio::select! {
        // In the same order each time.
        biased;
        problem = listener.take_all(requests, &lease) => if let Err(status) = problem {
            lease.why = status.message().to_owned();
            deliveries.close(status);
        },
        // A message on a stream that the world has closed, or whose reader is gone, is of no use.
        () = deliveries.closed() => {}
    }
}

/// The receiver of the requests of one stream.
struct Listener {
    steps: Steps,
    /// Indices of the robots, in the order of the Hello.
    robots: Vec<usize>,
    beliefs: Beliefs,
}

impl Listener {
    /// Takes requests until the stream ends, or the world is over.
    ///
    /// # Errors
    /// If a request is invalid, with its field.
    async fn take_all(
        &self,
        mut requests: Streaming<v1::AttachRequest>,
        lease: &Lease,
    ) -> Result<(), Status> {
        while let Some(request) = next_request(&mut requests).await? {
            let step = match request.request {
                Some(Content::Annotate(annotate)) => {
                    let (robot, belief) = checked(annotate, &self.robots)?;
                    self.beliefs.publish(lease.session, robot, belief);
                    continue;
                }
                Some(Content::Step(step)) => self.steps.checked(step)?,
                Some(Content::Hello(_)) => {
                    let text = "hello: this stream is attached already; open another one";
                    return Err(Status::failed_precondition(text));
                }
                None => return Err(Status::invalid_argument("request: must be a Step or an Annotate")),
            };
            if !self.steps.send(lease, step) {
                break;
            }
        }
        Ok(())
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
        assert!(check(&hello("移动 µ: left=0.5")).is_ok());
        for hostile in ["\u{1b}[2J", "\u{9b}31m", "a\nb", "a\rb", "\u{202e}txt", "\u{2066}", "\u{7f}"] {
            let status = check(&hello(hostile)).unwrap_err();
            assert_eq!(status.code(), Code::InvalidArgument);
            assert!(status.message().chars().all(is_printable), "{status:?}");
        }
    }
}
