//! A state by value: a recording of one state and nothing else.

use std::io::Cursor;

use baudbot_sim::World;

use crate::digest::Digests;
use crate::error::WriteError;
use crate::writer::{self, Writer};
use baudbot_proto::v1;

/// A world's state as a file. [`RecordedRun`](crate::RecordedRun) reads it.
///
/// # Errors
/// If it could not be compressed.
pub fn to_bytes(name: &str, world: &World) -> Result<Vec<u8>, WriteError> {
    let header = writer::header(name, world.origin(), None);
    let mut writer = Writer::new(Cursor::new(Vec::new()), &header)?;
    writer.state(&state(world))?;
    writer.mark(&Digests::default().last_mark(world))?;
    Ok(writer.finish()?.into_inner())
}

/// A world's state as it is recorded.
pub fn state(world: &World) -> v1::RecordedState {
    v1::RecordedState { tick: world.tick(), state: world.save(), state_hash: world.hash() }
}
