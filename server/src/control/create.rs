//! Worlds that clients create: from a scenario, a saved state, or another world.

use baudbot_proto::v1;
use baudbot_scenario::{Override, ScenarioError};
use baudbot_sim::{Scenario, World};
use tonic::{Request, Status};

use super::{Control, recordings, status_of};
use crate::actor::NewWorld;
use crate::convert;
use crate::limits::{Cancelled, InForce, Limit, Payer};
use crate::message::Request as Asked;
use crate::pace::Pace;
use crate::quote::cut;

impl Control {
    /// Creates a world for a client.
    pub(super) async fn create_for(
        &self,
        payer: Option<Payer>,
        request: v1::CreateWorldRequest,
    ) -> Result<v1::WorldStatus, Status> {
        let (pace, paused) = (convert::pace_from(request.pace)?.unwrap_or(Pace::REAL_TIME), request.paused);
        self.check_room(payer.as_ref())?;
        let limits = self.registry.limits().clone();
        if !paused && pace.lockstep().is_none() {
            limits.check_load()?;
        }
        let bytes =
            parsing_bytes(&request.scenario_toml) + recordings::saved_bytes(&request.saved_mcap, &limits);
        let own = limits.clone();
        let read = limits.read(bytes, move |cancelled| new_world(request, &own, cancelled));
        let (name, world) = read.await??;
        let new = NewWorld { paused, ..NewWorld::new(name, world, pace) };
        self.create(new, payer).await
    }

    /// Creates a world for a client that is a copy of another.
    pub(super) async fn clone_for(
        &self,
        payer: Option<Payer>,
        request: v1::CloneWorldRequest,
    ) -> Result<v1::WorldStatus, Status> {
        let v1::CloneWorldRequest { original, world: name, pace } = request;
        let pace = convert::pace_from(pace)?;
        let world = self.registry.find("original", &original)?;
        self.check_room(payer.as_ref())?;
        drop(world.room_for_copy()?);
        let state = world.request(Asked::Save { snapshot: 0 }).await?;
        let name = if name.is_empty() { self.registry.free_name(&original) } else { name };
        let new = NewWorld { paused: true, ..NewWorld::new(name, state.world, pace.unwrap_or(state.pace)) };
        self.create(new, payer).await
    }

    /// Makes a world for a client.
    pub(super) async fn create(
        &self,
        new: NewWorld,
        payer: Option<Payer>,
    ) -> Result<v1::WorldStatus, Status> {
        let (registry, limits) = (self.registry.clone(), self.registry.limits());
        // The count of the memory of a large world takes a while.
        let world = limits.making().make(move || registry.create(new, payer.as_ref())).await??;
        let status = status_of(world.request(Asked::Report).await?, self.registry.limits()).await?.1;
        self.told.note(&status);
        Ok(status)
    }

    /// Checks that there is room for another world, before anything is done for it.
    pub(super) fn check_room(&self, payer: Option<&Payer>) -> Result<(), Status> {
        let limits = self.registry.limits();
        limits.world(0)?;
        if let Some(Payer(tally)) = payer {
            limits.take(Limit::WorldsPerCaller, tally, "worlds")?;
        }
        Ok(())
    }
}

/// The payer for which a request is counted.
pub(super) fn payer<T>(request: &Request<T>) -> Option<Payer> {
    request.extensions().get().cloned()
}

/// The world of a request, from its scenario or from a saved state, and a name for it.
fn new_world(
    request: v1::CreateWorldRequest,
    limits: &InForce,
    cancelled: &Cancelled,
) -> Result<(String, World), Status> {
    let v1::CreateWorldRequest { world: name, scenario_toml, overrides, saved_mcap, .. } = request;
    let (own, world) = if saved_mcap.is_empty() {
        let scenario = parse_scenario(&scenario_toml, &overrides, cancelled)?;
        // A world of too many robots is not even made.
        limits.check_robots(scenario.robots.len())?;
        (scenario.name.clone(), World::new(scenario.into()))
    } else if scenario_toml.is_empty() && overrides.is_empty() {
        recordings::from_saved(&saved_mcap, limits)?
    } else {
        let text = "saved_mcap: has a scenario of its own; leave scenario_toml and overrides empty";
        return Err(Status::invalid_argument(text));
    };
    Ok((if name.is_empty() { own } else { name }, world))
}

/// Memory that it takes to parse a scenario, for each byte of its text: a text of numbers takes most.
const PARSED_BYTES: u64 = 48;

/// Memory that it takes to parse this text.
pub(super) fn parsing_bytes(toml: &str) -> u64 {
    toml.len() as u64 * PARSED_BYTES
}

/// Parses a scenario with its overrides. An error names the request's field, then the scenario's.
pub(super) fn parse_scenario(
    toml: &str,
    overrides: &[String],
    cancelled: &Cancelled,
) -> Result<Scenario, Status> {
    let changes = parse_overrides(overrides)?;
    let parsed = baudbot_scenario::parse_while(toml, &changes, &|| !cancelled.is_so());
    parsed.map_err(|error| scenario_error("scenario_toml", &error))?.ok_or_else(gone)
}

/// The status of a call whose client has gone.
pub(super) fn gone() -> Status {
    Status::cancelled("the client has gone")
}

pub(super) fn parse_overrides(texts: &[String]) -> Result<Vec<Override>, Status> {
    let parse = |(i, text): (usize, &String)| {
        Override::parse(text).map_err(|error| scenario_error(&format!("overrides[{i}]"), &error))
    };
    texts.iter().enumerate().map(parse).collect()
}

/// The status for a scenario that is invalid because of this field of the request.
pub(super) fn scenario_error(field: &str, error: &ScenarioError) -> Status {
    Status::invalid_argument(format!("{field}: {}", cut(&error.to_string())))
}
