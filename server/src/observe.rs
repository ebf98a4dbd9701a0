//! The observers' service.

use std::pin::Pin;

use baudbot_proto::v1;
use baudbot_proto::v1::observe_service_server::ObserveService;
use baudbot_sim::Scenario;
use baudbot_sim::cable::Cable;
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;
use tokio_stream::{Stream, StreamExt};
use tonic::{Request, Response, Status};

use crate::cables::WatchCable;
use crate::convert;
use crate::message::{Message, Watch};
use crate::observers::MAX_DETAILS;
use crate::quote::brief;
use crate::registry::Registry;
use crate::system::blocking;

/// Frames that wait for an observer that does not read. Further ones are missed.
const FRAMES_AHEAD: usize = 8;

/// News that wait for a watcher of a cable that does not read. What comes then waits, and some of it is missed.
const NEWS_AHEAD: usize = 8;

/// Frames a simulated second for an observer that asks for no rate.
const DEFAULT_RATE_HZ: u64 = 20;

/// Pulses with a shorter period are told together to an observer that does not say which, in nanoseconds.
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
        let world = self.registry.find("world", &request.get_ref().world)?;
        let scenario = world.ask(Message::Describe).await?;
        Ok(Response::new(convert::world_description(&scenario)))
    }

    async fn get_coverage(
        &self,
        request: Request<v1::GetCoverageRequest>,
    ) -> Result<Response<v1::GetCoverageResponse>, Status> {
        let world = self.registry.find("world", &request.get_ref().world)?;
        let report = world.ask(Message::Cover).await?;
        // This takes a while for millions of cells.
        let coverage = blocking(move || convert::coverage(&report)).await?;
        let none = || {
            let text = "does not measure coverage; set metrics.cell_m in its scenario";
            Status::failed_precondition(format!("world: `{}` {text}", world.name()))
        };
        Ok(Response::new(coverage.ok_or_else(none)?))
    }

    type WatchStream = Pin<Box<dyn Stream<Item = Result<v1::WatchResponse, Status>> + Send>>;

    async fn watch(&self, request: Request<v1::WatchRequest>) -> Result<Response<Self::WatchStream>, Status> {
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
        let (frames, stream) = mpsc::channel(FRAMES_AHEAD);
        world.send(Message::Watch(Watch { every_ticks, details, pins_finest_ns, frames }))?;
        let stream = ReceiverStream::new(stream).map(|frame| Ok(convert::frame(frame)));
        Ok(Response::new(Box::pin(stream)))
    }

    type WatchCableStream = Pin<Box<dyn Stream<Item = Result<v1::WatchCableResponse, Status>> + Send>>;

    async fn watch_cable(
        &self,
        request: Request<v1::WatchCableRequest>,
    ) -> Result<Response<Self::WatchCableStream>, Status> {
        let v1::WatchCableRequest { world, robot, sensor } = request.into_inner();
        let world = self.registry.find("world", &world)?;
        let scenario = world.ask(Message::Describe).await?;
        let (robot, cable) = cable(&scenario, &robot, &sensor)?;
        let (news, stream) = mpsc::channel(NEWS_AHEAD);
        world.send(Message::WatchCable(WatchCable { robot, cable, news }))?;
        let stream = ReceiverStream::new(stream).map(|news| Ok(convert::cable_news(news)));
        Ok(Response::new(Box::pin(stream)))
    }
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
