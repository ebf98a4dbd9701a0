//! What `--record` asks for.

use baudbot_server::WorldConfig;

use crate::args::RecordArgs;

/// Records a world, if that is asked for.
pub(crate) fn add(world: WorldConfig, args: &RecordArgs) -> WorldConfig {
    match &args.record {
        Some(path) => world.record(path.clone(), args.record_hz),
        None => world,
    }
}
