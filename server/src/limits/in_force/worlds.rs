//! The limits of worlds, and of what is in them: their places, their memory, and the load that they are.

use std::sync::Arc;
use std::time::Instant;

use baudbot_sim::Scenario;
use tonic::Status;

use super::{InForce, Place};
use crate::clock;
use crate::limits::memory::{Held, ScenarioHeld};
use crate::limits::parsing::{Cancelled, Waiter};
use crate::limits::{Exceeded, Limit, SOON};
use crate::system::blocking;

impl InForce {
    /// The place of a world with so many robots.
    ///
    /// # Errors
    /// If there are too many worlds, or robots.
    pub(crate) fn world(&self, robots: usize) -> Result<(Place, Place), Exceeded> {
        self.check_robots(robots)?;
        let (world, most) = (self.one(Limit::Worlds, "worlds")?, self.value(Limit::Robots));
        let robots = self.place(Limit::Robots, robots).ok_or_else(|| {
            let what = format!("with {robots} more robots the server would have more than {most}");
            self.refuse(Limit::Robots, what, None)
        })?;
        Ok((world, robots))
    }

    /// Checks the number of robots of a world.
    ///
    /// # Errors
    /// If there are too many.
    pub(crate) fn check_robots(&self, robots: usize) -> Result<(), Exceeded> {
        self.check(Limit::RobotsPerWorld, robots, |robots| format!("the world would have {robots} robots"))
    }

    /// Checks the number of things of one request, which are in these words.
    ///
    /// # Errors
    /// If there are too many.
    pub(crate) fn check(
        &self,
        limit: Limit,
        count: usize,
        words: impl FnOnce(usize) -> String,
    ) -> Result<(), Exceeded> {
        let most = self.count(limit);
        if count <= most {
            return Ok(());
        }
        Err(self.refuse(limit, format!("{}, more than {most}", words(count)), None))
    }

    /// The place of another snapshot.
    ///
    /// # Errors
    /// If there are too many.
    pub(crate) fn snapshot(&self) -> Result<Place, Exceeded> {
        let most = self.value(Limit::Snapshots);
        self.place(Limit::Snapshots, 1)
            .ok_or_else(|| self.refuse(Limit::Snapshots, format!("the server has {most} snapshots"), None))
    }

    /// Memory that is not held.
    pub(crate) fn free_bytes(&self) -> u64 {
        self.value(Limit::Memory).saturating_sub(self.0.memory.held())
    }

    /// Memory for something.
    ///
    /// # Errors
    /// If there is not so much.
    pub(crate) fn hold(&self, bytes: u64) -> Result<Held, Exceeded> {
        let most = self.value(Limit::Memory);
        self.0.memory.hold(bytes, most).ok_or_else(|| {
            let free = self.free_bytes();
            let what = format!(
                "this takes {} MB, and {} MB are free of the server's {} MB",
                in_mb(bytes),
                in_mb(free),
                in_mb(most)
            );
            self.refuse(Limit::Memory, what, None)
        })
    }

    /// Memory for a scenario that exists, unless another world has it, too.
    ///
    /// # Errors
    /// If there is not so much.
    pub(crate) fn hold_scenario(&self, scenario: &Arc<Scenario>) -> Result<Arc<ScenarioHeld>, Exceeded> {
        self.0.memory.hold_scenario(scenario, |bytes| self.hold(bytes))
    }

    /// A world that follows the wall clock has let time go that it could have kept.
    pub(crate) fn note_lag(&self, now: Instant) {
        self.0.overload.note(now);
    }

    /// Notes a lag that a world has skipped. If a message about all worlds is due: the number of such lags since the
    /// last one.
    pub(crate) fn lag_in_all(&self, now: Instant) -> Option<u64> {
        self.0.lags.note(now)
    }

    /// Checks that another world may run by its own pace.
    ///
    /// # Errors
    /// If those that are there lag already.
    pub(crate) fn check_load(&self) -> Result<(), Exceeded> {
        let after = self.value(Limit::OverloadAfter);
        let seconds = self.0.overload.seconds(clock::now());
        if after == 0 || seconds < after {
            return Ok(());
        }
        let what = format!("worlds in real time have lagged for {seconds} s, {after} s or more");
        Err(self.refuse(Limit::OverloadAfter, what, None))
    }

    /// Memory that is there already, and is counted whatever the limit.
    pub(crate) fn count_memory(&self, bytes: u64) -> Option<Held> {
        let mut held = self.0.memory.hold(0, u64::MAX)?;
        held.set(bytes);
        Some(held)
    }

    /// Reads something, when it is its turn, with memory for the time that it takes. Work is not begun if its client
    /// has gone.
    ///
    /// # Errors
    /// If too many wait, or there is not so much memory; or if the work panics.
    pub(crate) async fn read<T: Send + 'static>(
        &self,
        bytes: u64,
        work: impl FnOnce(&Cancelled) -> T + Send + 'static,
    ) -> Result<T, Status> {
        // The request itself is in memory while it waits.
        let held = self.hold(bytes)?;
        let most = self.count(Limit::Waiting);
        let Some(permit) = self.0.parsing.turn(most).await else {
            let what = format!("{most} requests wait to be parsed");
            return Err(self.refuse(Limit::Waiting, what, Some(SOON)).into());
        };
        let waiter = Waiter(Cancelled::default());
        let cancelled = waiter.0.clone();
        let work = move || {
            // The permit is kept until the work is done, even if the client has gone.
            let _kept = (permit, held);
            work(&cancelled)
        };
        let done = blocking(work).await;
        drop(waiter);
        done
    }
}

/// Megabytes, rounded up where less than one would be nothing.
fn in_mb(bytes: u64) -> String {
    let mb = bytes as f64 / 1e6;
    if mb < 100.0 { format!("{mb:.1}") } else { format!("{mb:.0}") }
}
