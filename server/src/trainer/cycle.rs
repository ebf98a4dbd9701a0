//! A request of a trainer: what is done in which worlds, and how they stand afterwards.

use std::collections::BTreeSet;

use baudbot_proto::v1;
use baudbot_proto::v1::train_request::Request as Content;
use baudbot_proto::v1::world_action;
use futures_util::{StreamExt, stream};
use tonic::Status;

use super::within;
use super::world::{Trained, reset};
use crate::brain_link::CheckedStep;

/// Scenarios of resets that are parsed at a time; each takes a processor.
const RESETS_AT_A_TIME: usize = 2;

/// The act in a world of this place.
pub(super) struct Act {
    place: usize,
    what: What,
}

enum What {
    Step(CheckedStep),
    Reset(v1::ResetWorldRequest),
}

/// The acts of a request, and the places of its worlds, in their order.
///
/// # Errors
/// If it is invalid, with its field.
pub(super) fn checked(
    request: v1::TrainRequest,
    worlds: &[Trained],
) -> Result<(Vec<Act>, Vec<usize>), Status> {
    let cycle = match request.request {
        Some(Content::Cycle(cycle)) => cycle,
        Some(Content::Open(_)) => {
            return Err(Status::failed_precondition("open: this stream is open already; open another one"));
        }
        None => return Err(Status::invalid_argument("request: must be a `cycle`")),
    };
    let (mut actions, mut seen) = (Vec::with_capacity(cycle.worlds.len()), BTreeSet::new());
    for (i, v1::WorldAction { world, action }) in cycle.worlds.into_iter().enumerate() {
        let place = world as usize;
        let wrong = |text: String| Err(Status::invalid_argument(format!("worlds[{i}].{text}")));
        let Some(trained) = worlds.get(place) else {
            return wrong(format!("world: is {world}, but this stream has {} worlds", worlds.len()));
        };
        if !seen.insert(place) {
            return wrong(format!("world: {world} is named twice"));
        }
        let what = match action {
            Some(world_action::Action::Step(step)) => {
                let checked = trained.check(step).map_err(|status| within(&format!("worlds[{i}]"), &status));
                What::Step(checked?)
            }
            Some(world_action::Action::Reset(request)) if request.world.is_empty() => What::Reset(request),
            Some(world_action::Action::Reset(_)) => {
                return wrong("reset.world: must be empty, since `world` names the world".to_owned());
            }
            None => return wrong("action: must be a Step or a reset".to_owned()),
        };
        actions.push(Act { place, what });
    }
    let order = actions.iter().map(|action| action.place).collect();
    Ok((actions, order))
}

/// Does it, and waits until the worlds in these places have their next Turns or have ended.
pub(super) async fn act(worlds: &mut [Trained], actions: Vec<Act>, order: &[usize]) -> v1::TrainResponse {
    let mut resets = Vec::new();
    for Act { place, what } in actions {
        match what {
            What::Step(step) => worlds[place].step(step),
            What::Reset(request) => resets.push((place, worlds[place].handle().clone(), request)),
        }
    }
    let resets = resets.into_iter().map(|(place, world, request)| async move {
        let done = reset(&world, request).await;
        (place, done)
    });
    let resets: Vec<_> = stream::iter(resets).buffered(RESETS_AT_A_TIME).collect().await;
    for (place, done) in resets {
        worlds[place].note_reset(done);
    }
    let mut results = Vec::with_capacity(order.len());
    for &place in order {
        results.push(worlds[place].result().await);
    }
    v1::TrainResponse { worlds: results }
}
