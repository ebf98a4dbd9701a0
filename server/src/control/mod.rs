//! The operator's service.

mod budget_queue;
mod create;
mod limits;
mod list;
mod recordings;
mod reset;
mod service;
mod status;

use baudbot_proto::v1;
use baudbot_proto::v1::control_service_server::ControlService;
use baudbot_scenario::budget::{Allowance, RobotBudget};
use baudbot_sim::Scenario;
use baudbot_sim::model::RobotSpec;
use tonic::{Code, Request, Response, Status};
use tracing::Instrument;

use crate::access::caller_of;
use crate::convert;
use crate::in_bytes::decoded;
use crate::limits::{Cancelled, InForce, Limit};
use crate::message::{Message, Request as Asked};
use crate::quote::brief;
use crate::recording::Folder;
use crate::registry::Registry;
use crate::report::Report;

use budget_queue::BUDGETS;
use create::{parse_scenario, parsing_bytes, payer};
pub(crate) use recordings::stop_recording;
pub(crate) use reset::scenario_of_reset;
pub(crate) use service::ControlServer;
pub(crate) use status::Told;

/// The implementation of the operator's service.
pub(crate) struct Control {
    pub(crate) registry: Registry,
    /// The folder of recordings; `None` if the server keeps none.
    pub(crate) recordings: Option<Folder>,
    pub(crate) told: Told,
}

impl Control {
    async fn request(&self, world: &str, request: Asked) -> Result<Report, Status> {
        let span = tracing::info_span!("order", world = brief(world), order = request.name());
        async { self.registry.find("world", world)?.request(request).await }.instrument(span).await
    }

    async fn reset(&self, request: v1::ResetWorldRequest) -> Result<v1::WorldStatus, Status> {
        let span = tracing::info_span!("order", world = brief(&request.world), order = "reset");
        // The scenario is that of this world, and not of another that has got its name meanwhile.
        let reset = async {
            let world = self.registry.find("world", &request.world)?;
            let (scenario, _held) = scenario_of_reset(&world, request).await?;
            world.request(Asked::Reset(scenario)).await
        };
        let status = status_of(reset.instrument(span).await?, self.registry.limits()).await?.1;
        self.told.note(&status);
        Ok(status)
    }

    async fn status(&self, world: &str, request: Asked) -> Result<Option<v1::WorldStatus>, Status> {
        let status = status_of(self.request(world, request).await?, self.registry.limits()).await?.1;
        self.told.note(&status);
        Ok(Some(status))
    }
}

/// The status of a world, with the report that it is made of. Fingerprinting a large world takes a while, in which other
/// calls must not wait.
pub(crate) async fn status_of(report: Report, limits: &InForce) -> Result<(Report, v1::WorldStatus), Status> {
    let work = move || {
        let status = convert::status(&report);
        (report, status)
    };
    limits.making().make(work).await
}

/// Most robots whose budget one call asks for: each takes a while.
const MAX_BUDGETS: usize = 256;

/// The robots of these names; all if there are none.
fn chosen<'a>(scenario: &'a Scenario, names: &[String]) -> Result<Vec<&'a RobotSpec>, Status> {
    let robots = &scenario.robots;
    if let Some(name) = names.iter().find(|name| robots.iter().all(|robot| robot.name != **name)) {
        return Err(Status::not_found(format!("robots: there is no robot `{}`", brief(name))));
    }
    let wanted = |robot: &&RobotSpec| names.is_empty() || names.contains(&robot.name);
    let chosen: Vec<_> = robots.iter().filter(wanted).collect();
    if chosen.len() > MAX_BUDGETS {
        let there = chosen.len();
        return Err(Status::invalid_argument(format!(
            "robots: name at most {MAX_BUDGETS}, these are {there}"
        )));
    }
    Ok(chosen)
}

/// The budgets of the robots of these names, all within one allowance.
fn budgets(scenario: &Scenario, names: &[String]) -> Result<Response<v1::GetBudgetResponse>, Status> {
    let mut allowance = Allowance::of_a_call();
    let chosen = chosen(scenario, names)?;
    let has_model = chosen.iter().any(|robot| robot.chip.is_none());
    if let Some(robot) = chosen.iter().find(|robot| robot.chip.is_some() && !(has_model && names.is_empty()))
    {
        return Err(Status::failed_precondition(format!(
            "robots: the microcontroller of `{0}` runs a program of its own, whose budget is measured in a run, which a server \
             does not do on request: baudbot budget SCENARIO --robot {0}",
            robot.name
        )));
    }
    let robots = chosen.into_iter().filter(|robot| robot.chip.is_none());
    let budgets: Vec<_> = robots.map(|spec| RobotBudget::within(scenario, spec, &mut allowance)).collect();
    let robots = budgets.into_iter().map(convert::robot_budget).collect();
    Ok(Response::new(v1::GetBudgetResponse { robots }))
}

/// The header of a response with something that its caller should know.
const NOTE: &str = "baudbot-note";

#[tonic::async_trait]
impl ControlService for Control {
    async fn create_world(
        &self,
        request: Request<v1::CreateWorldRequest>,
    ) -> Result<Response<v1::CreateWorldResponse>, Status> {
        let status = Some(self.create_for(payer(&request), request.into_inner()).await?);
        Ok(Response::new(v1::CreateWorldResponse { status }))
    }

    async fn list_worlds(
        &self,
        _: Request<v1::ListWorldsRequest>,
    ) -> Result<Response<v1::ListWorldsResponse>, Status> {
        Ok(Response::new(decoded(self.list_in_bytes().await?)?))
    }

    async fn get_world(
        &self,
        request: Request<v1::GetWorldRequest>,
    ) -> Result<Response<v1::GetWorldResponse>, Status> {
        Ok(Response::new(decoded(self.world_in_bytes(&request.get_ref().world).await?)?))
    }

    async fn start_world(
        &self,
        request: Request<v1::StartWorldRequest>,
    ) -> Result<Response<v1::StartWorldResponse>, Status> {
        let status = self.status(&request.get_ref().world, Asked::Start).await?;
        Ok(Response::new(v1::StartWorldResponse { status }))
    }

    async fn pause_world(
        &self,
        request: Request<v1::PauseWorldRequest>,
    ) -> Result<Response<v1::PauseWorldResponse>, Status> {
        let status = self.status(&request.get_ref().world, Asked::Pause).await?;
        Ok(Response::new(v1::PauseWorldResponse { status }))
    }

    async fn step_world(
        &self,
        request: Request<v1::StepWorldRequest>,
    ) -> Result<Response<v1::StepWorldResponse>, Status> {
        let v1::StepWorldRequest { world, ticks } = request.get_ref();
        let status = self.status(world, Asked::Step { ticks: *ticks }).await?;
        Ok(Response::new(v1::StepWorldResponse { status }))
    }

    async fn set_pace(
        &self,
        request: Request<v1::SetPaceRequest>,
    ) -> Result<Response<v1::SetPaceResponse>, Status> {
        let v1::SetPaceRequest { world, pace } = request.into_inner();
        let pace = convert::pace_from(pace)?.ok_or_else(|| Status::invalid_argument("pace: must be set"))?;
        let status = self.status(&world, Asked::SetPace(pace)).await?;
        Ok(Response::new(v1::SetPaceResponse { status }))
    }

    async fn reset_world(
        &self,
        request: Request<v1::ResetWorldRequest>,
    ) -> Result<Response<v1::ResetWorldResponse>, Status> {
        let status = Some(self.reset(request.into_inner()).await?);
        Ok(Response::new(v1::ResetWorldResponse { status }))
    }

    async fn snapshot_world(
        &self,
        request: Request<v1::SnapshotWorldRequest>,
    ) -> Result<Response<v1::SnapshotWorldResponse>, Status> {
        let report = self.request(&request.get_ref().world, Asked::Snapshot).await?;
        let (report, status) = status_of(report, self.registry.limits()).await?;
        let (snapshot, status) = (report.snapshot, Some(status));
        let mut response = Response::new(v1::SnapshotWorldResponse { snapshot, status });
        let most = self.registry.limits().value(Limit::SnapshotsPerWorld).max(1);
        if let Some(gone) = snapshot.checked_sub(most).filter(|&gone| gone > 0) {
            let option = Limit::SnapshotsPerWorld.info().option;
            let note = format!("snapshot {gone} has gone, as a world keeps {most} ({option})");
            if let Ok(note) = note.parse() {
                response.metadata_mut().insert(NOTE, note);
            }
        }
        Ok(response)
    }

    async fn restore_world(
        &self,
        request: Request<v1::RestoreWorldRequest>,
    ) -> Result<Response<v1::RestoreWorldResponse>, Status> {
        let v1::RestoreWorldRequest { world, snapshot } = request.get_ref();
        let status = self.status(world, Asked::Restore { snapshot: *snapshot }).await?;
        Ok(Response::new(v1::RestoreWorldResponse { status }))
    }

    async fn delete_world(
        &self,
        request: Request<v1::DeleteWorldRequest>,
    ) -> Result<Response<v1::DeleteWorldResponse>, Status> {
        let world = &request.get_ref().world;
        let status = self.status(world, Asked::Delete).await;
        // A world that does not answer is forgotten all the same, so that its name is free again.
        if !matches!(&status, Err(status) if status.code() == Code::NotFound) {
            self.registry.remove(world);
            self.told.forget(world);
        }
        let status = status?;
        Ok(Response::new(v1::DeleteWorldResponse { status }))
    }

    async fn intervene(
        &self,
        request: Request<v1::InterveneRequest>,
    ) -> Result<Response<v1::InterveneResponse>, Status> {
        let v1::InterveneRequest { world, intervention } = request.into_inner();
        let status = self.status(&world, convert::intervention(intervention)?).await?;
        Ok(Response::new(v1::InterveneResponse { status }))
    }

    async fn save_world(
        &self,
        request: Request<v1::SaveWorldRequest>,
    ) -> Result<Response<v1::SaveWorldResponse>, Status> {
        Ok(Response::new(self.save(request.into_inner()).await?))
    }

    async fn clone_world(
        &self,
        request: Request<v1::CloneWorldRequest>,
    ) -> Result<Response<v1::CloneWorldResponse>, Status> {
        let status = Some(self.clone_for(payer(&request), request.into_inner()).await?);
        Ok(Response::new(v1::CloneWorldResponse { status }))
    }

    async fn start_recording(
        &self,
        request: Request<v1::StartRecordingRequest>,
    ) -> Result<Response<v1::StartRecordingResponse>, Status> {
        let status = self.record(request.into_inner()).await?;
        Ok(Response::new(v1::StartRecordingResponse { status }))
    }

    async fn stop_recording(
        &self,
        request: Request<v1::StopRecordingRequest>,
    ) -> Result<Response<v1::StopRecordingResponse>, Status> {
        let recording = stop_recording(&self.registry, &request.get_ref().world).await?.beside.recording;
        Ok(Response::new(v1::StopRecordingResponse { recording }))
    }

    async fn list_recordings(
        &self,
        _: Request<v1::ListRecordingsRequest>,
    ) -> Result<Response<v1::ListRecordingsResponse>, Status> {
        Ok(Response::new(self.list().await?))
    }

    async fn open_recording(
        &self,
        request: Request<v1::OpenRecordingRequest>,
    ) -> Result<Response<v1::OpenRecordingResponse>, Status> {
        let payer = payer(&request);
        let status = Some(self.open(request.into_inner(), payer).await?);
        Ok(Response::new(v1::OpenRecordingResponse { status }))
    }

    async fn describe_replay(
        &self,
        request: Request<v1::DescribeReplayRequest>,
    ) -> Result<Response<v1::DescribeReplayResponse>, Status> {
        Ok(Response::new(self.describe(&request.get_ref().world).await?))
    }

    async fn seek_replay(
        &self,
        request: Request<v1::SeekReplayRequest>,
    ) -> Result<Response<v1::SeekReplayResponse>, Status> {
        let v1::SeekReplayRequest { world, tick } = request.get_ref();
        let status = self.status(world, Asked::Seek { tick: *tick }).await?;
        Ok(Response::new(v1::SeekReplayResponse { status }))
    }

    async fn fork_replay(
        &self,
        request: Request<v1::ForkReplayRequest>,
    ) -> Result<Response<v1::ForkReplayResponse>, Status> {
        let status = self.fork(request.into_inner()).await?;
        Ok(Response::new(v1::ForkReplayResponse { status }))
    }

    async fn get_limits(
        &self,
        request: Request<v1::GetLimitsRequest>,
    ) -> Result<Response<v1::GetLimitsResponse>, Status> {
        Ok(Response::new(limits::response(self.registry.limits(), payer(&request).as_ref())))
    }

    async fn get_budget(
        &self,
        request: Request<v1::GetBudgetRequest>,
    ) -> Result<Response<v1::GetBudgetResponse>, Status> {
        use v1::get_budget_request::Scenario as Given;
        let caller = caller_of(&request)?;
        let v1::GetBudgetRequest { scenario, overrides, robots } = request.into_inner();
        let (world, toml) = match scenario {
            None => return Err(Status::invalid_argument("scenario: must be set")),
            Some(Given::World(_)) if !overrides.is_empty() => {
                return Err(Status::invalid_argument("overrides: apply to a scenario_toml, not to a world"));
            }
            Some(Given::World(world)) => {
                let world = self.registry.find("world", &world)?;
                (Some(world.ask(Message::Describe).await?), String::new())
            }
            Some(Given::ScenarioToml(toml)) => (None, toml),
        };
        let place = BUDGETS.place(&caller).await?;
        let bytes = parsing_bytes(&toml);
        let work = move |cancelled: &Cancelled| {
            // The place is kept until the work is done, even if the client has gone.
            let _place = place;
            let scenario = match world {
                Some(scenario) => scenario,
                None => parse_scenario(&toml, &overrides, cancelled)?.into(),
            };
            budgets(&scenario, &robots)
        };
        self.registry.limits().read(bytes, work).await?
    }
}
