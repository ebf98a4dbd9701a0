//! Recordings that are replayed.

use baudbot_proto::v1;
use baudbot_recording::RecordedRun;

/// The description of a recording.
pub(crate) fn replay(recorded: &RecordedRun) -> v1::DescribeReplayResponse {
    let header = recorded.header();
    let events = recorded.events().iter().take(MAX_EVENTS);
    v1::DescribeReplayResponse {
        recorded_world: header.world.clone(),
        program_version: header.program_version.clone(),
        started_unix_ns: header.started_unix_ns,
        first_tick: recorded.first_tick(),
        last_tick: recorded.last_tick(),
        cut_off: recorded.problem().is_some(),
        events: events
            .map(|event| v1::ReplayEvent { tick: event.tick, kind: event.kind, text: event.text.clone() })
            .collect(),
    }
}

const MAX_EVENTS: usize = 10_000;
