//! Loops in which a brain drives its robot, or brains a fleet, until the run is over.

use std::time::Duration;

use baudbot_brain::Brain;

use crate::error::Error;
use crate::fleet::Fleet;
use crate::protocol::nanoseconds;
use crate::robot::Robot;

/// The course of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Summary {
    /// Turns that the brain, or all brains of a fleet together, had.
    pub turns: u64,
    /// Tick of the last of them.
    pub last_tick: u64,
}

/// Lets `brain` drive `robot` until the run is over or the server closes the stream. If the world is reset meanwhile, the same brain goes
/// on with what it knows; [`EachRun`](crate::EachRun) makes a new one.
///
/// # Errors
/// See [`Robot::turn`].
pub async fn run(robot: &mut Robot, brain: &mut (impl Brain + ?Sized)) -> Result<Summary, Error> {
    let (mut summary, mut looks) = (Summary::default(), Looks::every_ns(robot.publishes_every_ns()));
    while let Some(turn) = robot.turn().await? {
        summary.turns += 1;
        summary.last_tick = turn.tick;
        let action = brain.step(&turn);
        let is_due = looks.is_due(turn.at_ns);
        // In a world that waits for its brains, a belief that is published before the answer is there at the next tick,
        // on any machine. By the wall clock no command waits for what people see. The Welcome states once which of the
        // two holds; a pace that is changed later makes a belief late at worst.
        if is_due && robot.lockstep() {
            publish(robot, brain).await?;
        }
        robot.act(action).await?;
        if is_due && !robot.lockstep() {
            publish(robot, brain).await?;
        }
    }
    Ok(summary)
}

async fn publish(robot: &mut Robot, brain: &mut (impl Brain + ?Sized)) -> Result<(), Error> {
    let Some(belief) = brain.belief() else { return Ok(()) };
    robot.publish(belief).await
}

/// Lets each of `brains` drive the robot of `fleet` that stands in the same place, until the run is over or
/// the server closes the stream. All answers to a tick go in one message.
///
/// # Errors
/// [`Error::Brains`] if there are not as many brains as robots, otherwise as [`Fleet::turns`].
pub async fn run_fleet<B: Brain>(fleet: &mut Fleet, brains: &mut [B]) -> Result<Summary, Error> {
    if brains.len() != fleet.bodies().len() {
        return Err(Error::Brains { robots: fleet.bodies().len(), brains: brains.len() });
    }
    let mut summary = Summary::default();
    let mut looks: Vec<_> = brains.iter().map(|_| Looks::every_ns(fleet.publishes_every_ns())).collect();
    while let Some(turns) = fleet.turns().await? {
        let mut actions = Vec::with_capacity(turns.len());
        for (robot, turn) in &turns {
            summary.turns += 1;
            summary.last_tick = turn.tick;
            if let Some(brain) = brains.get_mut(*robot) {
                actions.push((*robot, brain.step(turn)));
            }
        }
        let due: Vec<_> = turns
            .iter()
            .filter(|(robot, turn)| looks[*robot].is_due(turn.at_ns))
            .map(|(robot, _)| *robot)
            .collect();
        // The beliefs are published as for one robot.
        if fleet.lockstep() {
            publish_all(fleet, brains, &due).await?;
        }
        fleet.act(&actions).await?;
        if !fleet.lockstep() {
            publish_all(fleet, brains, &due).await?;
        }
    }
    Ok(summary)
}

async fn publish_all<B: Brain>(fleet: &mut Fleet, brains: &mut [B], due: &[usize]) -> Result<(), Error> {
    for &robot in due {
        if let Some(belief) = brains[robot].belief() {
            fleet.publish(robot, belief).await?;
        }
    }
    Ok(())
}

/// The instants at which a brain is asked for its beliefs, for people: at a step, and at most once in each interval of
/// simulated time.
#[derive(Clone, Debug)]
pub struct Looks {
    every_ns: u64,
    next_ns: u64,
}

impl Looks {
    /// The looks at such intervals.
    pub fn every(every: Duration) -> Self {
        Self::every_ns(nanoseconds(every))
    }

    fn every_ns(every_ns: u64) -> Self {
        Self { every_ns, next_ns: 0 }
    }

    /// Whether they look at a step at this instant of simulated time, in nanoseconds.
    pub fn is_due(&mut self, at_ns: u64) -> bool {
        // A world that was reset begins at 0 again.
        let is_due = at_ns >= self.next_ns || self.next_ns - at_ns > self.every_ns;
        if is_due {
            self.next_ns = at_ns.saturating_add(self.every_ns);
        }
        is_due
    }
}
