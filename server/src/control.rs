//! The operator's service.

use baudbot_proto::v1;
use baudbot_proto::v1::control_service_server::ControlService;
use baudbot_sim::scenario::ScenarioError;
use baudbot_sim::{Override, Scenario};
use tonic::{Code, Request, Response, Status};

use crate::convert;
use crate::letter::{Order, Report};
use crate::pace::Pace;
use crate::registry::{NewWorld, Registry};
use crate::words::brief;

pub(crate) struct Control {
    pub(crate) registry: Registry,
}

impl Control {
    async fn order(&self, world: &str, order: Order) -> Result<Report, Status> {
        self.registry.find("world", world)?.order(order).await
    }

    async fn status(&self, world: &str, order: Order) -> Result<Option<v1::WorldStatus>, Status> {
        Ok(Some(status_of(self.order(world, order).await?).await?.1))
    }
}

/// The status of a world, with the report that it is made of. Fingerprinting a large world takes a while, in
/// which others must not wait.
async fn status_of(report: Report) -> Result<(Report, v1::WorldStatus), Status> {
    let work = move || {
        let status = convert::status(&report);
        (report, status)
    };
    tokio::task::spawn_blocking(work).await.map_err(|error| Status::internal(error.to_string()))
}

/// Parses a scenario with its overrides; the error names the request's field, then the scenario's.
fn parse_scenario(toml: &str, overrides: &[String]) -> Result<Scenario, Status> {
    let invalid = |field: String, error: ScenarioError| {
        Status::invalid_argument(format!("{field}: {}", brief(&error.to_string())))
    };
    let mut changes = Vec::new();
    for (i, text) in overrides.iter().enumerate() {
        changes.push(Override::parse(text).map_err(|error| invalid(format!("overrides[{i}]"), error))?);
    }
    Scenario::parse_with(toml, &changes).map_err(|error| invalid("scenario_toml".into(), error))
}

#[tonic::async_trait]
impl ControlService for Control {
    async fn create_world(
        &self,
        request: Request<v1::CreateWorldRequest>,
    ) -> Result<Response<v1::CreateWorldResponse>, Status> {
        let request = request.into_inner();
        let (toml, overrides) = (request.scenario_toml, request.overrides);
        let parse = tokio::task::spawn_blocking(move || parse_scenario(&toml, &overrides));
        let scenario = parse.await.map_err(|error| Status::internal(error.to_string()))??;
        let name = if request.world.is_empty() { scenario.name().to_owned() } else { request.world };
        let pace = convert::pace_from(request.pace)?.unwrap_or(Pace::REAL_TIME);
        let new = NewWorld { name, scenario: scenario.into(), pace, paused: request.paused, on_tick: None };
        let report = self.registry.create(new)?.order(Order::Report).await?;
        let (_, status) = status_of(report).await?;
        Ok(Response::new(v1::CreateWorldResponse { status: Some(status) }))
    }

    async fn list_worlds(
        &self,
        _: Request<v1::ListWorldsRequest>,
    ) -> Result<Response<v1::ListWorldsResponse>, Status> {
        let mut worlds = Vec::new();
        for world in self.registry.all() {
            // A world that is deleted meanwhile is left out.
            if let Ok(report) = world.order(Order::Report).await {
                worlds.push(status_of(report).await?.1);
            }
        }
        Ok(Response::new(v1::ListWorldsResponse { worlds }))
    }

    async fn get_world(
        &self,
        request: Request<v1::GetWorldRequest>,
    ) -> Result<Response<v1::GetWorldResponse>, Status> {
        let status = self.status(&request.get_ref().world, Order::Report).await?;
        Ok(Response::new(v1::GetWorldResponse { status }))
    }

    async fn start_world(
        &self,
        request: Request<v1::StartWorldRequest>,
    ) -> Result<Response<v1::StartWorldResponse>, Status> {
        let status = self.status(&request.get_ref().world, Order::Start).await?;
        Ok(Response::new(v1::StartWorldResponse { status }))
    }

    async fn pause_world(
        &self,
        request: Request<v1::PauseWorldRequest>,
    ) -> Result<Response<v1::PauseWorldResponse>, Status> {
        let status = self.status(&request.get_ref().world, Order::Pause).await?;
        Ok(Response::new(v1::PauseWorldResponse { status }))
    }

    async fn step_world(
        &self,
        request: Request<v1::StepWorldRequest>,
    ) -> Result<Response<v1::StepWorldResponse>, Status> {
        let v1::StepWorldRequest { world, ticks } = request.get_ref();
        let status = self.status(world, Order::Step { ticks: *ticks }).await?;
        Ok(Response::new(v1::StepWorldResponse { status }))
    }

    async fn set_pace(
        &self,
        request: Request<v1::SetPaceRequest>,
    ) -> Result<Response<v1::SetPaceResponse>, Status> {
        let v1::SetPaceRequest { world, pace } = request.into_inner();
        let pace = convert::pace_from(pace)?.ok_or_else(|| Status::invalid_argument("pace: must be set"))?;
        let status = self.status(&world, Order::SetPace(pace)).await?;
        Ok(Response::new(v1::SetPaceResponse { status }))
    }

    async fn reset_world(
        &self,
        request: Request<v1::ResetWorldRequest>,
    ) -> Result<Response<v1::ResetWorldResponse>, Status> {
        let status = self.status(&request.get_ref().world, Order::Reset).await?;
        Ok(Response::new(v1::ResetWorldResponse { status }))
    }

    async fn snapshot_world(
        &self,
        request: Request<v1::SnapshotWorldRequest>,
    ) -> Result<Response<v1::SnapshotWorldResponse>, Status> {
        let report = self.order(&request.get_ref().world, Order::Snapshot).await?;
        let (report, status) = status_of(report).await?;
        let (snapshot, status) = (report.snapshot, Some(status));
        Ok(Response::new(v1::SnapshotWorldResponse { snapshot, status }))
    }

    async fn restore_world(
        &self,
        request: Request<v1::RestoreWorldRequest>,
    ) -> Result<Response<v1::RestoreWorldResponse>, Status> {
        let v1::RestoreWorldRequest { world, snapshot } = request.get_ref();
        let status = self.status(world, Order::Restore { snapshot: *snapshot }).await?;
        Ok(Response::new(v1::RestoreWorldResponse { status }))
    }

    async fn delete_world(
        &self,
        request: Request<v1::DeleteWorldRequest>,
    ) -> Result<Response<v1::DeleteWorldResponse>, Status> {
        let world = &request.get_ref().world;
        let status = self.status(world, Order::Delete).await;
        // A world that does not answer is forgotten all the same, so that its name is free again.
        if !matches!(&status, Err(status) if status.code() == Code::NotFound) {
            self.registry.remove(world);
        }
        let status = status?;
        Ok(Response::new(v1::DeleteWorldResponse { status }))
    }
}
