//! An operator of a server.

use std::time::{Duration, Instant};

use baudbot_proto::v1;
use baudbot_proto::v1::control_service_client::ControlServiceClient;
use tokio::runtime::Runtime;
use tonic::Status;
use tonic::transport::{Channel, Endpoint};

type Answer<T> = Result<T, Status>;

pub(crate) struct Operator {
    runtime: Runtime,
    client: ControlServiceClient<Channel>,
}

/// Calls a method, and takes a field of its response.
macro_rules! call {
    ($self:ident, $method:ident, $request:expr, $field:ident) => {
        $self.runtime.block_on($self.client.$method($request)).map(|answer| answer.into_inner().$field)
    };
}

impl Operator {
    pub(crate) fn new(address: &str) -> Self {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        let channel = Endpoint::from_shared(address.to_owned()).unwrap();
        let client = ControlServiceClient::new(runtime.block_on(channel.connect()).unwrap());
        Self { runtime, client }
    }

    pub(crate) fn status(&mut self, world: &str) -> Answer<v1::WorldStatus> {
        call!(self, get_world, v1::GetWorldRequest { world: world.into() }, status).map(Option::unwrap)
    }

    pub(crate) fn worlds(&mut self) -> Vec<String> {
        let worlds = call!(self, list_worlds, v1::ListWorldsRequest {}, worlds).unwrap();
        worlds.into_iter().map(|status| status.world).collect()
    }

    pub(crate) fn create(
        &mut self,
        world: &str,
        toml: &str,
        (pace, paused): (v1::pace::Kind, bool),
        overrides: &[&str],
    ) -> Answer<v1::WorldStatus> {
        let request = v1::CreateWorldRequest {
            world: world.into(),
            scenario_toml: toml.into(),
            overrides: overrides.iter().map(|text| (*text).to_owned()).collect(),
            pace: Some(v1::Pace { kind: Some(pace) }),
            paused,
            ..Default::default()
        };
        call!(self, create_world, request, status).map(Option::unwrap)
    }

    pub(crate) fn start(&mut self, world: &str) -> Answer<v1::WorldStatus> {
        call!(self, start_world, v1::StartWorldRequest { world: world.into() }, status).map(Option::unwrap)
    }

    pub(crate) fn pause(&mut self, world: &str) -> Answer<v1::WorldStatus> {
        call!(self, pause_world, v1::PauseWorldRequest { world: world.into() }, status).map(Option::unwrap)
    }

    pub(crate) fn step(&mut self, world: &str, ticks: u64) -> Answer<v1::WorldStatus> {
        let request = v1::StepWorldRequest { world: world.into(), ticks };
        call!(self, step_world, request, status).map(Option::unwrap)
    }

    pub(crate) fn set_pace(&mut self, world: &str, kind: v1::pace::Kind) -> Answer<v1::WorldStatus> {
        let pace = Some(v1::Pace { kind: Some(kind) });
        call!(self, set_pace, v1::SetPaceRequest { world: world.into(), pace }, status).map(Option::unwrap)
    }

    pub(crate) fn put(
        &mut self,
        world: &str,
        (x_m, y_m, heading_rad): (f64, f64, f64),
    ) -> Answer<v1::WorldStatus> {
        let place = v1::PlaceRobot { robot: "robot".into(), x_m, y_m, heading_rad };
        let intervention = Some(v1::intervene_request::Intervention::PlaceRobot(place));
        let request = v1::InterveneRequest { world: world.into(), intervention };
        call!(self, intervene, request, status).map(Option::unwrap)
    }

    pub(crate) fn reset(&mut self, world: &str, seed: u64) -> Answer<v1::WorldStatus> {
        let request = v1::ResetWorldRequest { world: world.into(), seed: Some(seed), ..Default::default() };
        call!(self, reset_world, request, status).map(Option::unwrap)
    }

    pub(crate) fn snapshot(&mut self, world: &str) -> Answer<u64> {
        call!(self, snapshot_world, v1::SnapshotWorldRequest { world: world.into() }, snapshot)
    }

    pub(crate) fn restore(&mut self, world: &str, snapshot: u64) -> Answer<v1::WorldStatus> {
        let request = v1::RestoreWorldRequest { world: world.into(), snapshot };
        call!(self, restore_world, request, status).map(Option::unwrap)
    }

    pub(crate) fn save(&mut self, world: &str) -> Answer<Vec<u8>> {
        call!(self, save_world, v1::SaveWorldRequest { world: world.into(), snapshot: 0 }, saved_mcap)
    }

    pub(crate) fn delete(&mut self, world: &str) -> Answer<v1::WorldStatus> {
        call!(self, delete_world, v1::DeleteWorldRequest { world: world.into() }, status).map(Option::unwrap)
    }

    pub(crate) fn clone_world(&mut self, original: &str, world: &str) -> Answer<v1::WorldStatus> {
        let request =
            v1::CloneWorldRequest { original: original.into(), world: world.into(), ..Default::default() };
        call!(self, clone_world, request, status).map(Option::unwrap)
    }

    pub(crate) fn record(&mut self, world: &str, recording: &str) -> Answer<v1::WorldStatus> {
        let request = v1::StartRecordingRequest {
            world: world.into(),
            recording: recording.into(),
            ..Default::default()
        };
        call!(self, start_recording, request, status).map(Option::unwrap)
    }

    /// Waits until the status of a world is so.
    pub(crate) fn wait_until(
        &mut self,
        world: &str,
        is_so: impl Fn(&v1::WorldStatus) -> bool,
    ) -> v1::WorldStatus {
        let start = Instant::now();
        loop {
            let status = self.status(world).unwrap();
            if is_so(&status) {
                return status;
            }
            assert!(start.elapsed() < Duration::from_secs(60), "{status:?}");
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

/// Only the ticks that are asked for.
pub(crate) fn stepped() -> v1::pace::Kind {
    v1::pace::Kind::Stepped(v1::Stepped::default())
}

pub(crate) fn lockstep() -> v1::pace::Kind {
    v1::pace::Kind::Lockstep(v1::Lockstep::default())
}

pub(crate) fn real_time() -> v1::pace::Kind {
    v1::pace::Kind::RealTime(v1::RealTime::default())
}
