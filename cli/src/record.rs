//! What `--record` asks for.

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

/// How long a frame of the recording is, if it has more frames than brains publish for people.
pub(crate) fn short_frame(args: &RecordArgs) -> Option<Duration> {
    let is_short = args.record.is_some() && args.record_hz > PEOPLE_HZ;
    is_short.then(|| Duration::from_secs_f64(1.0 / args.record_hz))
}

/// A client whose brains publish as often as there are frames.
pub(crate) fn publishing(client: Client, frame: Option<Duration>) -> Client {
    match frame {
        Some(frame) => client.publishes_every(frame),
        None => client,
    }
}

/// So often brains publish unless told otherwise.
const PEOPLE_HZ: f64 = 20.0;
