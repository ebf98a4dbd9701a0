//! Numbers for monitoring, in Prometheus' text format.
//!
//! Nothing is counted for it: an answer has what the world counts anyway for `ControlService.GetWorld`, read at that moment
//! ([`measures`](crate::measures)). So a world that is not monitored does nothing for it, a number cannot differ from the
//! operator's, and the numbers of a deleted world are gone. A recorder of counters, such as that of the crate `metrics`, would
//! need an update for each change, or would have to be filled from the same numbers, and cleared for deleted worlds. Only the
//! model and the encoder of the crate `prometheus` are used ([`text`]).
//!
//! A world is asked by a message that copies numbers and nothing else, and that is handled even while the world is ahead of
//! its brains: monitoring that asks why a world stands must not wait for that. The text is made on a thread of its own.

mod families;
mod text;

use std::sync::Arc;
use std::time::Duration;

use tokio::sync::{Semaphore, oneshot};
use tokio::time::{Instant, timeout_at};

use crate::measures::{MAX_ROBOTS, Measures};
use crate::message::{Message, WorldHandle};
use crate::registry::Registry;

/// The time that worlds have to answer. A world within a long tick, or whose `OnTick` blocks, does not.
const PATIENCE: Duration = Duration::from_secs(1);

/// Answers that are made at a time: each takes memory and a processor.
const MAX_SCRAPES: usize = 2;

/// Type of the text.
pub(crate) const CONTENT_TYPE: &str = "text/plain; version=0.0.4; charset=utf-8";

/// Measures the worlds of a server. Clones share the limit of answers at a time.
#[derive(Clone)]
pub(crate) struct Metrics {
    registry: Registry,
    permits: Arc<Semaphore>,
}

/// A reason why there are no metrics.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Refused {
    #[error("{MAX_SCRAPES} others are being answered, which is the limit; ask again")]
    Busy,
    #[error("{0}")]
    Failed(tokio::task::JoinError),
}

/// A world that was asked.
struct World {
    name: String,
    /// `None` if it did not answer.
    measures: Option<Measures>,
    /// Statuses that were made of it.
    statuses: u64,
}

impl Metrics {
    pub(crate) fn new(registry: Registry) -> Self {
        Self { registry, permits: Arc::new(Semaphore::new(MAX_SCRAPES)) }
    }

    /// All metrics as they are now, after those who asked before.
    ///
    /// # Errors
    /// If too many ask.
    pub(crate) async fn text(&self) -> Result<String, Refused> {
        let permit = timeout_at(Instant::now() + PATIENCE, Arc::clone(&self.permits).acquire_owned()).await;
        let Ok(Ok(permit)) = permit else { return Err(Refused::Busy) };
        let worlds = self.ask().await;
        let limits = self.registry.limits().clone();
        let write = move || {
            // The permit is kept until the text is made, even if the client has gone.
            let _permit = permit;
            families::write(&worlds, &limits, MAX_ROBOTS)
        };
        tokio::task::spawn_blocking(write).await.map_err(Refused::Failed)
    }

    /// Asks all worlds at once.
    async fn ask(&self) -> Vec<World> {
        let ask = |world: WorldHandle| {
            let (reply, answer) = oneshot::channel();
            let _ = world.send(Message::Measure(reply));
            (world.name().to_owned(), world.answers().status.made(), answer)
        };
        let asked: Vec<_> = self.registry.all().into_iter().map(ask).collect();
        let deadline = Instant::now() + PATIENCE;
        let mut worlds = Vec::new();
        for (name, statuses, answer) in asked {
            let measures = timeout_at(deadline, answer).await.ok().and_then(Result::ok);
            worlds.push(World { name, measures, statuses });
        }
        worlds
    }
}

#[cfg(test)]
mod tests {
    use baudbot_sim::World;

    use super::*;
    use crate::actor::NewWorld;
    use crate::limits::{InForce, Limits};
    use crate::pace::{Lockstep, Pace};

    #[tokio::test]
    async fn there_is_an_end_to_the_robots_that_are_told_of_and_the_others_are_counted() {
        let registry = Registry::new(InForce::new(Limits::none()));
        let toml = include_str!("../../../catalogue/scenarios/wander.toml");
        for name in ["a", "b"] {
            let world = World::new(baudbot_scenario::parse(toml).unwrap().into());
            let pace = Pace::Lockstep(Lockstep::default());
            let new = NewWorld::new(name.to_owned(), world, pace);
            registry.create(NewWorld { paused: true, ..new }, None).unwrap();
        }
        let metrics = Metrics::new(registry);
        let text = families::write(&metrics.ask().await, metrics.registry.limits(), 1);
        for (world, left_out) in [("a", 0), ("b", 1)] {
            let line = format!("baudbot_world_robots_left_out{{world=\"{world}\"}} {left_out}\n");
            assert!(text.contains(&line), "{text}");
            let robot = format!("baudbot_brain_attached{{world=\"{world}\",robot=\"robot\"}} 0\n");
            assert_eq!(text.contains(&robot), left_out == 0, "{text}");
        }
    }

    #[tokio::test]
    async fn a_third_that_asks_at_a_time_is_sent_away() {
        let metrics = Metrics::new(Registry::new(InForce::new(Limits::none())));
        let first = Arc::clone(&metrics.permits).try_acquire_owned().unwrap();
        let _second = Arc::clone(&metrics.permits).try_acquire_owned().unwrap();
        assert!(metrics.text().await.unwrap_err().to_string().starts_with("2 others"));
        drop(first);
        assert!(metrics.text().await.unwrap().starts_with("# HELP baudbot_worlds "));
    }
}
