//! Several robots of a world on one stream.

use std::sync::Arc;

use baudbot_brain::{Action, Belief, Body, Turn};

use crate::error::Error;
use crate::protocol::{Answer, Part};
use crate::session::Session;

/// Robots that this program holds together; a robot is known by its place in [`bodies`](Self::bodies).
#[derive(Debug)]
pub struct Fleet {
    session: Session,
}

impl Fleet {
    pub(crate) fn new(session: Session) -> Self {
        Self { session }
    }

    /// The interval at which their brains' beliefs are published.
    pub(crate) fn publishes_every_ns(&self) -> u64 {
        self.session.publishes_every_ns
    }

    /// The robots' data sheets, in the order in which they were asked for.
    pub fn bodies(&self) -> &[Arc<Body>] {
        &self.session.welcome().bodies
    }

    /// Length of the world's tick, in nanoseconds.
    pub fn step_ns(&self) -> u64 {
        self.session.welcome().step_ns
    }

    /// Whether the world waited for its brains when these attached.
    pub fn lockstep(&self) -> bool {
        self.session.welcome().lockstep
    }

    /// Whether the server has closed the stream, so that no turn will come.
    pub fn is_closed(&self) -> bool {
        self.session.is_closed()
    }

    /// Waits for the next tick in which any of the robots' brains can step, and gives the turns of those
    /// that can, each with its robot's place. Otherwise as [`Robot::turn`](crate::Robot::turn).
    ///
    /// # Errors
    /// As [`Robot::turn`](crate::Robot::turn).
    pub async fn turns(&mut self) -> Result<Option<Vec<(usize, Turn)>>, Error> {
        let Some((tick, parts)) = self.session.turn().await? else { return Ok(None) };
        let bodies = self.bodies();
        let turn = |part: Part| {
            let body = Arc::clone(&bodies[part.robot]);
            (part.robot, part.turn(tick, body))
        };
        Ok(Some(parts.into_iter().map(turn).collect()))
    }

    /// Answers all turns of the tick at once; a robot that is left out does nothing.
    ///
    /// # Errors
    /// As [`Robot::drive`](crate::Robot::drive).
    pub async fn act(&mut self, actions: &[(usize, Action)]) -> Result<(), Error> {
        let answers: Vec<_> = actions.iter().map(|(robot, action)| (*robot, Answer::Act(action))).collect();
        self.session.answer(&answers).await
    }

    /// Shows people what a robot's brain believes and does, as [`Robot::publish`](crate::Robot::publish).
    ///
    /// # Errors
    /// As [`Robot::publish`](crate::Robot::publish).
    pub async fn publish(&mut self, robot: usize, belief: Belief) -> Result<(), Error> {
        self.session.publish(robot, belief).await
    }
}
