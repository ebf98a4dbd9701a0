//! A brain, and what runs one.

use std::time::Duration;

use baudbot_proto::v1::Belief;

use crate::error::Error;
use crate::fleet::Fleet;
use crate::robot::Robot;
use crate::turn::{Signals, Turn, Until};

/// Turns what has arrived into what is done. A brain has no clock and does no input or output: whatever it
/// knows it has from its turns, so the same turns give the same actions, and a test can make them up.
pub trait Brain {
    /// One step. It is called once a turn, in order.
    fn step(&mut self, turn: &Turn) -> Action;

    /// What it believes and does, for people who look. [`run`] and [`run_fleet`] ask for it some 20 times a simulated second,
    /// or [as often as is wanted](crate::Client::publishes_every), and [publish](Robot::publish) it. `None`: nothing.
    fn belief(&mut self) -> Option<Belief> {
        None
    }
}

impl<B: Brain + ?Sized> Brain for Box<B> {
    fn step(&mut self, turn: &Turn) -> Action {
        (**self).step(turn)
    }

    fn belief(&mut self) -> Option<Belief> {
        (**self).belief()
    }
}

/// What a brain does in a step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Action {
    /// Signals for the motors; `None` leaves those in force.
    pub signals: Option<Signals>,
    /// Signals for the other actuators, all of them, in the order of [`Body::actuators`](crate::Body::actuators);
    /// empty sends again what was sent last. A command has the signals of all motors and actuators, so these
    /// count only beside [`signals`](Self::signals).
    pub others: Vec<f64>,
    /// How long the brain says it thought, in simulated time; `None`: what the scenario says.
    pub thinking: Option<Duration>,
    /// Instead of `thinking`, on a robot that is onboard: how many operations its program did.
    pub operations: Option<u64>,
    /// Asks a firmware that answers only when asked. Signals ask too (where they do not on the wire, a poll is sent
    /// behind them), so this counts only without them.
    pub poll: bool,
    /// The brain now waits for news; `None`: it wants each of its turns.
    pub until: Option<Until>,
}

impl Action {
    /// Sends signals.
    pub const fn drive(left: f64, right: f64) -> Self {
        let mut action = Self::wait();
        action.signals = Some(Signals { left, right });
        action
    }

    /// Sends nothing.
    pub const fn wait() -> Self {
        Self { signals: None, others: Vec::new(), thinking: None, operations: None, poll: false, until: None }
    }

    /// Asks for readings.
    pub const fn poll() -> Self {
        let mut action = Self::wait();
        action.poll = true;
        action
    }

    /// The same after so much simulated time of thought.
    #[must_use]
    pub const fn after(mut self, thinking: Duration) -> Self {
        self.thinking = Some(thinking);
        self
    }

    /// The same, and then waits until something new has come: turns without news are not given to the brain. Each
    /// counts as [`wait`](Self::wait). In lockstep they do not even cross the network, so that a brain which acts on
    /// news alone loses no time with the others.
    #[must_use]
    pub const fn until_message(mut self) -> Self {
        self.until = Some(Until { at_latest_ns: None });
        self
    }

    /// As [`until_message`](Self::until_message), but the first turn at this instant of simulated time, or after it, is
    /// given to the brain in any case.
    #[must_use]
    pub const fn until_message_or(mut self, at_latest_ns: u64) -> Self {
        self.until = Some(Until { at_latest_ns: Some(at_latest_ns) });
        self
    }

    /// The same after so many operations of the microcontroller that the brain runs on.
    #[must_use]
    pub const fn operations(mut self, operations: u64) -> Self {
        self.operations = Some(operations);
        self
    }

    /// The same with signals for the actuators besides the wheels, all of them, in the order of
    /// [`Body::actuators`](crate::Body::actuators).
    #[must_use]
    pub fn with_others(mut self, others: Vec<f64>) -> Self {
        self.others = others;
        self
    }
}

/// How a run went.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Summary {
    /// Turns that the brain, or all brains of a fleet together, had.
    pub turns: u64,
    /// Tick of the last of them.
    pub last_tick: u64,
}

/// Lets `brain` drive `robot` until the run is over or the server closes the stream.
///
/// # Errors
/// See [`Robot::turn`].
pub async fn run(robot: &mut Robot, brain: &mut (impl Brain + ?Sized)) -> Result<Summary, Error> {
    let (mut summary, mut looks) = (Summary::default(), Looks::every(robot.publishes_every_ns()));
    while let Some(turn) = robot.turn().await? {
        summary.turns += 1;
        summary.last_tick = turn.tick;
        let action = brain.step(&turn);
        let is_due = looks.is_due(turn.at_ns);
        // Where the world waits for its brains, what is said before the answer is there at the next tick, on any machine.
        // By the wall clock no command waits for what people see. Which it is the Welcome says, once; a pace that is changed
        // later makes a belief late at worst.
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
    let mut looks: Vec<_> = brains.iter().map(|_| Looks::every(fleet.publishes_every_ns())).collect();
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
        // As for one robot.
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

/// When people look.
struct Looks {
    every_ns: u64,
    next_ns: u64,
}

impl Looks {
    fn every(every_ns: u64) -> Self {
        Self { every_ns, next_ns: 0 }
    }

    fn is_due(&mut self, at_ns: u64) -> bool {
        // A world that was reset begins at 0 again.
        let is_due = at_ns >= self.next_ns || self.next_ns - at_ns > self.every_ns;
        if is_due {
            self.next_ns = at_ns.saturating_add(self.every_ns);
        }
        is_due
    }
}
