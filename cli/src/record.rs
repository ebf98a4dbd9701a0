//! The options of `--record`.

use std::time::Duration;

use baudbot_client::Client;
use baudbot_server::WorldConfig;

use crate::args::RecordArgs;

/// Records a world, if that is asked for.
pub(crate) fn add(world: WorldConfig, args: &RecordArgs) -> WorldConfig {
    match &args.record {
        Some(path) => world.record(path.clone(), args.record_hz),
        None => world,
    }
}

/// The length of a frame of the recording, if it has more frames than brains publish for people. A frame has whole
/// steps, as the recorder rounds them.
pub(crate) fn short_frame(args: &RecordArgs, step_ns: u64) -> Option<Duration> {
    args.record.as_ref().filter(|_| args.record_hz > 0.0)?;
    let steps = (1e9 / args.record_hz / step_ns as f64).round().max(1.0) as u64;
    Some(Duration::from_nanos(steps.saturating_mul(step_ns))).filter(|frame| *frame < Client::LOOKS_EVERY)
}

/// A client whose brains publish as often as there are frames.
pub(crate) fn publishing(client: Client, frame: Option<Duration>) -> Client {
    match frame {
        Some(frame) => client.publishes_every(frame),
        None => client,
    }
}
