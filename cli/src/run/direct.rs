//! A run with the world and its brains on this thread.

use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::Context;
use baudbot_brains::catalogue;
use baudbot_client::{Body, Brain, Client, Looks};
use baudbot_proto::v1;
use baudbot_server::{DirectWorld, OnTick};
use baudbot_sim::Turn;
use indicatif::ProgressBar;

use super::{Outside, Plan, progress};
use crate::error::{Refused, from_builder, from_server};

/// Lets brains drive their robots until the run is over, and says how the world then is.
pub(super) async fn run(
    plan: &Plan,
    on_tick: Option<OnTick>,
    outside: &mut Outside<'_>,
) -> anyhow::Result<v1::WorldStatus> {
    let world = plan.world(outside, on_tick).direct().map_err(from_builder)?;
    let mut running = Running { world, drivers: Vec::new() };
    let bar = progress(plan.ticks(), outside.args.quiet);
    let run = match running.attach(plan) {
        Ok(()) => running.until_over(outside, &bar).await,
        Err(error) => Err(error),
    };
    bar.finish_and_clear();
    // Whatever has happened, what was written is whole.
    let status = running.world.close().await;
    run?;
    status.map_err(|status| from_server(&status))
}

struct Running {
    world: DirectWorld,
    /// One for each robot; `None` if it has no brain.
    drivers: Vec<Option<Driver>>,
}

struct Driver {
    /// The brain as it was asked for.
    asked: Arc<str>,
    body: Arc<Body>,
    brain: Box<dyn Brain + Send>,
    looks: Looks,
}

impl Running {
    /// Makes the brains, as those are made that attach to a server.
    fn attach(&mut self, plan: &Plan) -> anyhow::Result<()> {
        let specs = &plan.scenario.robots;
        let every = plan.frame.unwrap_or(Client::LOOKS_EVERY);
        self.drivers.resize_with(specs.len(), || None);
        for assignment in &plan.assigned.brains {
            let place = |name: &String| specs.iter().position(|spec| spec.name == *name);
            let robots: Vec<_> = assignment.robots.iter().filter_map(place).collect();
            let asked: Arc<str> = assignment.brain.as_str().into();
            for &robot in &robots {
                let body = Arc::new(Body::from(&specs[robot]));
                let brain = catalogue::brain(&asked, plan.seed, &body);
                let brain = brain.map_err(|error| Refused::error(error.to_string()))?;
                let (asked, looks) = (Arc::clone(&asked), Looks::every(every));
                self.drivers[robot] = Some(Driver { asked, body, brain, looks });
            }
            self.world.attach(&catalogue::shown_name(&assignment.brain), &robots);
        }
        Ok(())
    }

    /// Makes ticks until the run has ended, somebody interrupts it or a file cannot be written.
    async fn until_over(&mut self, outside: &mut Outside<'_>, bar: &ProgressBar) -> anyhow::Result<()> {
        while self.slice()? {
            bar.set_position(self.world.world().tick());
            tokio::select! {
                biased;
                () = outside.stop.wait() => {
                    outside.interrupted = true;
                    return Ok(());
                }
                error = outside.files.failure() => return Err(error),
                // Whoever watches the files has its turn, too.
                () = tokio::task::yield_now() => {}
            }
        }
        Ok(())
    }

    /// Makes ticks for a while. Whether the run goes on.
    fn slice(&mut self) -> anyhow::Result<bool> {
        let begun = Instant::now();
        while begun.elapsed() < SLICE {
            for turn in self.world.begin() {
                self.step(turn)?;
            }
            if !self.world.finish() {
                return Ok(false);
            }
        }
        Ok(true)
    }

    fn step(&mut self, turn: Turn) -> anyhow::Result<()> {
        let Some(driver) = &mut self.drivers[turn.robot] else { return Ok(()) };
        let Driver { asked, body, brain, looks } = driver;
        let action = brain.step(&self.world.world().turn_of(turn, body));
        let failed = || format!("brain `{asked}` failed");
        if looks.is_due(turn.at.as_ns())
            && let Some(belief) = brain.belief()
        {
            let published = self.world.publish(turn.robot, belief);
            published.map_err(|status| from_server(&status)).with_context(failed)?;
        }
        self.world.act(turn, action).map_err(|status| from_server(&status)).with_context(failed)
    }
}

/// The longest time for which a signal, or a full disk, waits until it is noticed, if ticks are short.
const SLICE: Duration = Duration::from_millis(10);
