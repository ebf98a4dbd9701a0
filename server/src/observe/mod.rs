//! The observers' service.

mod service;

use std::pin::Pin;
use std::sync::{Arc, Weak};

use baudbot_proto::v1;
use baudbot_proto::v1::observe_service_server::ObserveService;
use baudbot_sim::Scenario;
use baudbot_sim::cable::Cable;
use bytes::Bytes;
use prost::Message as _;
use tokio_stream::{Stream, StreamExt};
use tonic::{Request, Response, Status};

use crate::answers::{Last, Made};
use crate::convert;
use crate::in_bytes::decoded;
use crate::limits::{Account, InForce, Inbox, Parts, Payer, Tally};
use crate::message::{Message, Watch, WatchCable};
use crate::observers::MAX_DETAILS;
use crate::quote::brief;
use crate::registry::Registry;
pub(crate) use service::ObserveServer;

/// Frames that wait for an observer that does not read. Further ones are missed.
const FRAMES_AHEAD: usize = 8;

/// News that wait for a watcher of a cable that does not read. What comes then waits, and some of it is missed.
const NEWS_AHEAD: usize = 8;

/// Frames a simulated second for an observer that asks for no rate.
const DEFAULT_RATE_HZ: u64 = 20;

/// The period below which pulses are summed up by default, in nanoseconds.
const DEFAULT_FINEST_NS: u64 = 100_000;

pub(crate) struct Observe {
    pub(crate) registry: Registry,
}

#[tonic::async_trait]
impl ObserveService for Observe {
    async fn describe_world(
        &self,
        request: Request<v1::DescribeWorldRequest>,
    ) -> Result<Response<v1::DescribeWorldResponse>, Status> {
        Ok(Response::new(decoded(self.description_in_bytes(&request.get_ref().world).await?)?))
    }

    async fn get_coverage(
        &self,
        request: Request<v1::GetCoverageRequest>,
    ) -> Result<Response<v1::GetCoverageResponse>, Status> {
        Ok(Response::new(decoded(self.coverage_in_bytes(&request.get_ref().world).await?)?))
    }

    type WatchStream = Pin<Box<dyn Stream<Item = Result<v1::WatchResponse, Status>> + Send>>;

    async fn watch(&self, request: Request<v1::WatchRequest>) -> Result<Response<Self::WatchStream>, Status> {
        let frames = self.frames(request).await?.map(|frame| frame.and_then(decoded));
        Ok(Response::new(Box::pin(frames)))
    }

    type WatchCableStream = Pin<Box<dyn Stream<Item = Result<v1::WatchCableResponse, Status>> + Send>>;

    async fn watch_cable(
        &self,
        request: Request<v1::WatchCableRequest>,
    ) -> Result<Response<Self::WatchCableStream>, Status> {
        let news = self.news(request).await?.map(|news| news.and_then(decoded));
        Ok(Response::new(Box::pin(news)))
    }
}

impl Observe {
    /// The response to a DescribeWorld: made once, until the scenario is another.
    async fn description_in_bytes(&self, world: &str) -> Result<Parts, Status> {
        let world = self.registry.find("world", world)?;
        let answer = world.answers().description.get(async |last: Option<&Last<Weak<Scenario>>>| {
            let scenario = world.ask(Message::Describe).await?;
            let key = Arc::downgrade(&scenario);
            if last.is_some_and(|last| last.key.ptr_eq(&key)) {
                return Ok(Made::Same { tail: Bytes::new() });
            }
            let make = move || Bytes::from(convert::world_description(&scenario).encode_to_vec());
            let bytes = world.limits().making().make(make).await?;
            Ok(Made::New(Last { key, bytes, tail: Bytes::new() }))
        });
        Ok(Parts(vec![answer.await?.bytes.clone()]))
    }

    /// The response to a GetCoverage: made once for those who ask meanwhile, and once a tick.
    async fn coverage_in_bytes(&self, world: &str) -> Result<Parts, Status> {
        let world = self.registry.find("world", world)?;
        let answer = world.answers().coverage.get(async |last: Option<&Last<(u64, u64)>>| {
            let report = world.ask(Message::Cover).await?;
            let key = (report.era, report.tick);
            if last.is_some_and(|last| last.key == key) {
                return Ok(Made::Same { tail: Bytes::new() });
            }
            // This takes a while for millions of cells.
            let make =
                move || convert::coverage(&report).map(|coverage| Bytes::from(coverage.encode_to_vec()));
            let bytes = world.limits().making().make(make).await?;
            let none = || {
                let text = "does not measure coverage; set metrics.cell_m in its scenario";
                Status::failed_precondition(format!("world: `{}` {text}", world.name()))
            };
            Ok(Made::New(Last { key, bytes: bytes.ok_or_else(none)?, tail: Bytes::new() }))
        });
        Ok(Parts(vec![answer.await?.bytes.clone()]))
    }

    /// The frames of a Watch.
    async fn frames(&self, request: Request<v1::WatchRequest>) -> Result<Inbox, Status> {
        let payer = payer(&request, self.registry.limits());
        let v1::WatchRequest { world, every_ticks, details, pins, pins_finest_ns } = request.into_inner();
        let world = self.registry.find("world", &world)?;
        let scenario = world.ask(Message::Describe).await?;
        let every_ticks = match every_ticks {
            0 => 1_000_000_000 / DEFAULT_RATE_HZ / scenario.step_ns,
            ticks => ticks,
        };
        let details = detailed(&scenario, &details)?;
        let finest_ns = if pins_finest_ns == 0 { DEFAULT_FINEST_NS } else { pins_finest_ns };
        let pins_finest_ns = pins.then_some(finest_ns);
        let what = format!("Watch of `{}`", world.name());
        let (frames, stream) = self.registry.limits().outbox(&payer, &what, FRAMES_AHEAD);
        world.send(Message::Watch(Watch { every_ticks, details, pins_finest_ns, frames }))?;
        Ok(stream)
    }

    /// The news of a WatchCable.
    async fn news(&self, request: Request<v1::WatchCableRequest>) -> Result<Inbox, Status> {
        let payer = payer(&request, self.registry.limits());
        let v1::WatchCableRequest { world, robot, sensor } = request.into_inner();
        let world = self.registry.find("world", &world)?;
        let scenario = world.ask(Message::Describe).await?;
        let (robot, cable) = cable(&scenario, &robot, &sensor)?;
        let what = format!("WatchCable of `{}`", world.name());
        let (news, stream) = self.registry.limits().outbox(&payer, &what, NEWS_AHEAD);
        world.send(Message::WatchCable(WatchCable { robot, cable, news }))?;
        Ok(stream)
    }
}

/// The tally for which messages that wait for the client of a request are counted.
fn payer<T>(request: &Request<T>, limits: &InForce) -> Arc<Tally> {
    let payer = request.extensions().get().map(|Payer(tally)| Arc::clone(tally));
    payer.unwrap_or_else(|| limits.tally(&Account::Process))
}

/// The cable of this robot and sensor.
fn cable(scenario: &Scenario, robot: &str, sensor: &str) -> Result<(usize, Cable), Status> {
    let robots = &scenario.robots;
    let place = match (robot, robots.len()) {
        ("", 1) => Some(0),
        _ => robots.iter().position(|spec| spec.name == robot),
    };
    let unknown = || {
        let names: Vec<_> = robots.iter().take(20).map(|spec| &*spec.name).collect();
        let problem = if robot.is_empty() {
            "say which".into()
        } else {
            format!("there is no robot `{}`", brief(robot))
        };
        Status::not_found(format!("robot: {problem}; there are: {}", names.join(", ")))
    };
    let place = place.ok_or_else(unknown)?;
    let spec = &robots[place];
    let found = match sensor {
        "" => Cable::Robot,
        name => {
            let found = spec.sensors.iter().position(|sensor| sensor.name == name);
            let text = || format!("sensor: `{}` has no sensor `{}`", spec.name, brief(name));
            Cable::Sensor(found.ok_or_else(|| Status::not_found(text()))?)
        }
    };
    if Cable::all(spec).any(|cable| cable == found) {
        return Ok((place, found));
    }
    let text = match found {
        Cable::Robot => format!("robot: the brain of `{}` is on board, and there is no cable", spec.name),
        Cable::Sensor(_) => format!("sensor: `{}` has no cable of its own", brief(sensor)),
    };
    Err(Status::failed_precondition(text))
}

/// The robots of these names.
fn detailed(scenario: &Scenario, names: &[String]) -> Result<Vec<usize>, Status> {
    if names.len() > MAX_DETAILS {
        let text = format!("details: there are {}, the limit is {MAX_DETAILS}", names.len());
        return Err(Status::invalid_argument(text));
    }
    let robots = &scenario.robots;
    let place = |(i, name): (usize, &String)| {
        let found = robots.iter().position(|spec| spec.name == *name);
        found.ok_or_else(|| Status::not_found(format!("details[{i}]: there is no robot `{}`", brief(name))))
    };
    names.iter().enumerate().map(place).collect()
}
