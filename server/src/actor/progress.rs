//! The progress of a world, for the program that its server is part of.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use baudbot_sim::World;
use tokio::sync::Notify;

/// The progress of a world. Unlike [`OnTick`](super::OnTick) it lets callers run short ticks inline, and the world go
/// ahead of its brains.
#[derive(Debug, Default)]
pub struct Progress {
    tick: AtomicU64,
    ended: Notify,
}

impl Progress {
    /// The tick that has begun last.
    pub fn tick(&self) -> u64 {
        self.tick.load(Ordering::Relaxed)
    }

    /// Waits until the run has ended, or the world is over, as when an operator deletes it.
    pub async fn ended(&self) {
        self.ended.notified().await;
    }
}

/// The world's end of a [`Progress`]. It is dropped with the world.
pub(super) struct Telling(Arc<Progress>);

impl Telling {
    pub(super) fn new(progress: Arc<Progress>) -> Self {
        Self(progress)
    }

    /// A tick has begun, or the run has ended.
    pub(super) fn tell(&self, world: &World) {
        self.0.tick.store(world.tick(), Ordering::Relaxed);
        if world.ending().is_some() {
            self.0.ended.notify_one();
        }
    }
}

impl Drop for Telling {
    fn drop(&mut self) {
        self.0.ended.notify_one();
    }
}
