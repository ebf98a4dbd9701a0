//! The status of worlds: made once for all who ask.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use baudbot_proto::v1;
use bytes::Bytes;
use prost::Message as _;
use prost::encoding::encode_varint;
use tonic::Status;
use tracing::Instrument;

use super::Control;
use crate::answers::{Last, Made};
use crate::convert;
use crate::limits::Parts;
use crate::message::{Message, WorldHandle};
use crate::quote::brief;
use crate::report::{Standing, Version};

/// The last status of each world, in bytes.
#[derive(Default)]
pub(crate) struct Told(Mutex<BTreeMap<String, Parts>>);

impl Told {
    /// Notes the last status of a world.
    pub(super) fn note(&self, status: &v1::WorldStatus) {
        self.note_bytes(&status.world, Parts(vec![status.encode_to_vec().into()]));
    }

    pub(super) fn note_bytes(&self, world: &str, status: Parts) {
        let mut told = self.lock();
        match told.get_mut(world) {
            Some(last) => *last = status,
            None => drop(told.insert(world.to_owned(), status)),
        }
    }

    pub(super) fn forget(&self, world: &str) {
        self.lock().remove(world);
    }

    pub(super) fn last(&self, world: &str) -> Option<Parts> {
        self.lock().get(world).cloned()
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<String, Parts>> {
        // The map is consistent between any two of its changes, so a panic elsewhere does not spoil it.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Control {
    /// The response to a GetWorld.
    pub(super) async fn world_in_bytes(&self, name: &str) -> Result<Parts, Status> {
        let span = tracing::info_span!("order", world = brief(name), order = "report");
        let told = async {
            let world = self.registry.find("world", name)?;
            let status = status_in_bytes(&world).await?;
            self.told.note_bytes(world.name(), status.clone());
            Ok(field_1(status))
        };
        told.instrument(span).await
    }
}

/// The status of a world, in the bytes of a `WorldStatus`. It is made once for all who ask while the one before is
/// made, and not again while nothing has changed.
pub(super) async fn status_in_bytes(world: &WorldHandle) -> Result<Parts, Status> {
    let answer = world.answers().status.get(async |last: Option<&Last<Version>>| {
        let known = last.map(|last| last.key.clone());
        let Standing { version, running, report } = world.ask(|reply| Message::Stand(known, reply)).await?;
        let running_wall_ns = convert::nanos(running);
        // The last one counts of a field that comes twice.
        let tail = v1::WorldStatus { running_wall_ns, ..Default::default() }.encode_to_vec().into();
        let Some(report) = report else { return Ok(Made::Same { tail }) };
        let make = move || Bytes::from(convert::status(&report).encode_to_vec());
        let bytes = world.limits().making().make(make).await?;
        Ok(Made::New(Last { key: version, bytes, tail }))
    });
    let answer = answer.await?;
    let Last { bytes, tail, .. } = &*answer;
    Ok(Parts(vec![bytes.clone(), tail.clone()]))
}

/// A message that is field 1 of another.
pub(super) fn field_1(message: Parts) -> Parts {
    const KEY: u8 = 1 << 3 | 2;
    let mut head = vec![KEY];
    encode_varint(message.len() as u64, &mut head);
    Parts(std::iter::once(head.into()).chain(message.0).collect())
}
