//! Recordings and saved states: what operators do with runs that are files.

use std::io::BufReader;
use std::sync::Arc;

use baudbot_proto::v1;
use baudbot_recording::{RecordedRun, RecordingError, Replay, Watched, saved};
use baudbot_sim::World;
use tokio::sync::oneshot;
use tonic::Status;

use super::Control;
use crate::actor::NewWorld;
use crate::convert;
use crate::limits::{InForce, Payer};
use crate::message::{Message, RecordConfig, Request};
use crate::pace::Pace;
use crate::quote::brief;
use crate::recording::Folder;
use crate::registry::Registry;
use crate::report::Report;

impl Control {
    fn folder(&self) -> Result<&Folder, Status> {
        let none = || {
            Status::failed_precondition(
                "this server keeps no recordings; start it with --recordings FOLDER to allow them",
            )
        };
        self.recordings.as_ref().ok_or_else(none)
    }

    pub(super) async fn save(&self, request: v1::SaveWorldRequest) -> Result<v1::SaveWorldResponse, Status> {
        let v1::SaveWorldRequest { world: name, snapshot } = request;
        let Report { world, held, .. } = self.request(&name, Request::Save { snapshot }).await?;
        let work = move || {
            // Counted as long as the copy is there.
            let _held = held;
            let saved_mcap =
                saved::to_bytes(&name, &world).map_err(|error| Status::internal(error.to_string()))?;
            if saved_mcap.len() > MAX_SAVED {
                let text = format!(
                    "the state has {} bytes, a message has at most {MAX_SAVED}; record the world into a file instead",
                    saved_mcap.len()
                );
                return Err(Status::resource_exhausted(text));
            }
            Ok(v1::SaveWorldResponse { saved_mcap, tick: world.tick(), state_hash: world.hash() })
        };
        self.registry.limits().making().make(work).await?
    }

    pub(super) async fn record(
        &self,
        request: v1::StartRecordingRequest,
    ) -> Result<Option<v1::WorldStatus>, Status> {
        let v1::StartRecordingRequest { world, recording, look_hz } = request;
        if !(0.0..=MAX_LOOK_HZ).contains(&look_hz) {
            let text = format!("look_hz: must be from 0 to {MAX_LOOK_HZ}, is {look_hz}");
            return Err(Status::invalid_argument(text));
        }
        let folder = self.folder()?;
        self.registry.find("world", &world)?;
        let name = if recording.is_empty() { folder.free_name(&world) } else { recording };
        let config = RecordConfig { path: folder.file(&name)?, name, look_hz };
        self.status(&world, Request::Record(config)).await
    }

    pub(super) async fn list(&self) -> Result<v1::ListRecordingsResponse, Status> {
        let folder = self.folder()?.clone();
        let recordings = self.registry.limits().making().make(move || folder.list()).await??;
        Ok(v1::ListRecordingsResponse { recordings })
    }

    pub(super) async fn open(
        &self,
        request: v1::OpenRecordingRequest,
        payer: Option<Payer>,
    ) -> Result<v1::WorldStatus, Status> {
        let v1::OpenRecordingRequest { recording, world } = request;
        let folder = self.folder()?.clone();
        self.check_room(payer.as_ref())?;
        let limits = self.registry.limits();
        let opened = folder.open(&recording)?;
        let bytes = opened.metadata().map_or(0, |metadata| metadata.len());
        // The recording may unpack to more, but never to more than the free memory.
        let (most, file) = (at_most(limits.free_bytes()), format!("recording: `{recording}`"));
        let read = limits.read(bytes.saturating_mul(UNPACKED), move |_| {
            let opened = BufReader::with_capacity(1 << 20, opened);
            replay(RecordedRun::read_at_most(opened, most))
                .map_err(|problem| Status::failed_precondition(format!("{file} {problem}")))
        });
        let (replay, made) = read.await??;
        // A recording's name may have a dot, a world's may not.
        let name = if world.is_empty() { recording.replace('.', "-") } else { world };
        let new =
            NewWorld { replay: Some(replay), paused: true, ..NewWorld::new(name, made, Pace::REAL_TIME) };
        self.create(new, payer).await
    }

    pub(super) async fn describe(&self, world: &str) -> Result<v1::DescribeReplayResponse, Status> {
        let recorded = self.registry.find("world", world)?.ask(Message::DescribeReplay).await?;
        let live = || Status::failed_precondition(format!("world: `{}` is live, not a replay", brief(world)));
        Ok(convert::replay(&*recorded.ok_or_else(live)?))
    }

    pub(super) async fn fork(
        &self,
        request: v1::ForkReplayRequest,
    ) -> Result<Option<v1::WorldStatus>, Status> {
        let pace = convert::pace_from(request.pace)?.unwrap_or(Pace::REAL_TIME);
        self.status(&request.world, Request::Fork(pace)).await
    }
}

/// Ends a world's recording. Reports the world in the state that the file ends with, once that is closed.
pub(crate) async fn stop_recording(registry: &Registry, world: &str) -> Result<Report, Status> {
    let (closed, file) = oneshot::channel();
    let mut report = registry.find("world", world)?.request(Request::StopRecording(closed)).await?;
    report.end_recording(file).await?;
    Ok(report)
}

/// A world from the state in a response of SaveWorld, and the name that it had.
pub(super) fn from_saved(bytes: &[u8], limits: &InForce) -> Result<(String, World), Status> {
    let invalid = |problem: String| Status::invalid_argument(format!("saved_mcap: {problem}"));
    let most = MAX_STATE.min(at_most(limits.free_bytes()));
    let recorded = RecordedRun::read_at_most(bytes, most).map_err(|error| invalid(error.to_string()))?;
    if let Some(problem) = recorded.problem() {
        return Err(invalid(format!("is not a complete state: {problem}")));
    }
    if recorded.last_tick() != recorded.first_tick() {
        let ticks = recorded.last_tick() - recorded.first_tick();
        return Err(invalid(format!(
            "is a recording of {ticks} ticks, and not a single state; use OpenRecording"
        )));
    }
    let world = recorded.first_state().map_err(|error| invalid(error.to_string()))?;
    Ok((recorded.header().world.clone(), world))
}

/// Memory that it takes to read a saved state.
pub(super) fn saved_bytes(saved: &[u8], limits: &InForce) -> u64 {
    let usual = (saved.len() as u64).saturating_mul(UNPACKED);
    // The limit is what is left, for a file that unpacks to more.
    usual.min(MAX_STATE as u64).min(limits.free_bytes().max(saved.len() as u64))
}

fn at_most(bytes: u64) -> usize {
    usize::try_from(bytes).unwrap_or(usize::MAX)
}

/// The memory of a recording or a state while it is read, for each byte of the file.
const UNPACKED: u64 = 8;

/// A world that replays a recording, at its beginning.
fn replay(recorded: Result<RecordedRun, RecordingError>) -> Result<(Replay, World), RecordingError> {
    Replay::start_watching(Arc::new(recorded?), Watched { starts: true, ..Watched::default() })
}

/// Most frames a simulated second.
const MAX_LOOK_HZ: f64 = 1000.0;

/// Memory that a state from the network may take before it is read, at most.
const MAX_STATE: usize = 256 << 20;

/// Longest state that one message carries.
const MAX_SAVED: usize = 16 << 20;
