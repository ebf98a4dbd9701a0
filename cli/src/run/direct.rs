//! A run with the world and its brains on this thread.

use std::time::{Duration, Instant};

use baudbot_brains::catalogue;
use baudbot_client::{Client, Looks};
use baudbot_proto::v1;
use baudbot_run::in_process::{AnyBrain, drivers};
use baudbot_run::simulation::{self, Simulation, SimulationProblem, TickError};
use baudbot_run::{DrivenWorld, LockstepWorld, Refusal};
use baudbot_server::{DirectWorld, OnTick};
use indicatif::ProgressBar;
use tonic::Status;

use super::{Outside, Plan, progress};
use crate::error::{Refused, from_builder, from_server};

/// Lets brains drive their robots until the run is over, and returns the state of the world then.
pub(super) async fn run(
    plan: &Plan,
    on_tick: Option<OnTick>,
    outside: &mut Outside<'_>,
) -> anyhow::Result<v1::WorldStatus> {
    let world = plan.world(outside, on_tick).direct().map_err(from_builder)?;
    let driven = DrivenWorld { world, drivers: Vec::new() };
    let mut running = Running { plan, driven, programs: None, looks: Vec::new() };
    let bar = progress(plan.ticks(), outside.args.quiet);
    let run = match running.attach() {
        Ok(()) => running.until_over(outside, &bar).await,
        Err(error) => Err(error),
    };
    bar.finish_and_clear();
    // Whatever has happened, what was written is whole.
    let status = running.driven.world.close().await;
    outside.programs = running.programs.as_ref().map_or_else(Vec::new, Simulation::progress);
    run?;
    status.map_err(|status| from_server(&status))
}

struct Running<'a> {
    plan: &'a Plan,
    driven: DrivenWorld<DirectWorld, AnyBrain>,
    /// Programs in simulated time, if there are some.
    programs: Option<Simulation>,
    /// The instants at which the brain of each robot is asked for its beliefs.
    looks: Vec<Looks>,
}

impl Running<'_> {
    /// Makes the brains, as those are made that attach to a server.
    fn attach(&mut self) -> anyhow::Result<()> {
        let (specs, brains) = (&self.plan.scenario.robots, &self.plan.assigned.brains);
        let drivers = drivers(specs, brains, self.plan.seed);
        self.driven.drivers = drivers.map_err(|error| Refused::error(error.to_string()))?;
        self.looks = vec![Looks::every(self.plan.frame.unwrap_or(Client::LOOKS_EVERY)); specs.len()];
        for assignment in brains {
            let place = |name: &String| specs.iter().position(|spec| spec.name == *name);
            let robots: Vec<_> = assignment.robots.iter().filter_map(place).collect();
            self.driven.world.attach(&catalogue::shown_name(&assignment.brain), &robots);
        }
        let tasks = &self.plan.assigned.at_ports;
        for task in tasks {
            let place = specs.iter().position(|spec| spec.name == task.robot);
            self.driven.world.attach(&task.program.to_string(), &place.into_iter().collect::<Vec<_>>());
        }
        if !tasks.is_empty() {
            let started = Simulation::start(&mut self.driven.world, tasks, self.plan.seed);
            self.programs = Some(started.map_err(|error| match *error.problem {
                SimulationProblem::Port(_) => Refused::error(error.to_string()),
                SimulationProblem::Open(_)
                | SimulationProblem::Pipe(_)
                | SimulationProblem::Program(_)
                | SimulationProblem::Failed { .. } => error.into(),
            })?);
        }
        Ok(())
    }

    /// Makes ticks until the run has ended, a signal interrupts it or a file cannot be written.
    async fn until_over(&mut self, outside: &mut Outside<'_>, bar: &ProgressBar) -> anyhow::Result<()> {
        while self.slice()? {
            bar.set_position(self.driven.world.world().tick());
            tokio::select! {
                biased;
                () = outside.stop.wait() => {
                    outside.interrupted = true;
                    return Ok(());
                }
                error = outside.files.failure() => return Err(error),
                // The tasks that watch the files have their turn, too.
                () = tokio::task::yield_now() => {}
            }
        }
        Ok(())
    }

    /// Makes ticks for a while. Whether the run goes on.
    fn slice(&mut self) -> anyhow::Result<bool> {
        let Self { plan, driven, programs, looks } = self;
        let begun = Instant::now();
        while begun.elapsed() < SLICE {
            let goes_on = match programs {
                None => driven.advance(|driven| publish(driven, looks)),
                Some(programs) => match simulation::tick(driven, programs, |driven| publish(driven, looks)) {
                    Err(TickError::Program(error)) => return Err(error.into()),
                    Err(TickError::Brain(refusal)) => Err(refusal),
                    Ok(goes_on) => Ok(goes_on),
                },
            };
            let failed = |Refusal { robot, error, .. }: Refusal<Status>| {
                let asked = plan.assigned.brain_of(&robot).unwrap_or_default();
                from_server(&error).context(format!("brain `{asked}` failed"))
            };
            if !goes_on.map_err(failed)? {
                return Ok(false);
            }
        }
        Ok(true)
    }
}

/// Shows people what brains believe that have stepped in this tick, as often as people look.
fn publish(
    driven: &mut DrivenWorld<DirectWorld, AnyBrain>,
    looks: &mut [Looks],
) -> Result<(), Refusal<Status>> {
    for turn in driven.world.turns().to_vec() {
        if looks[turn.robot].is_due(turn.at.as_ns())
            && let Some(belief) = driven.belief(turn.robot)
        {
            let published = driven.world.publish(turn.robot, belief);
            let robot = || driven.world.world().robot(turn.robot).spec().name.clone();
            published.map_err(|error| Refusal { robot: robot(), turn, error })?;
        }
    }
    Ok(())
}

/// The longest time for which a signal, or a full disk, waits until it is noticed, if ticks are short.
const SLICE: Duration = Duration::from_millis(10);
