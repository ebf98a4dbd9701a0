//! One robot, in bytes.

use std::sync::Arc;
use std::time::Duration;

use baudbot_brain::{Body, RawTurn, Until};

use crate::error::Error;
use crate::protocol::Answer;
use crate::session::Session;

/// A robot that this program holds, reading and writing the bytes of its cable as from a serial port.
///
/// [`RawReadings`](crate::RawReadings) and [`RawCommands`](crate::RawCommands) turn bytes into turns and
/// signals into bytes.
#[derive(Debug)]
pub struct RawRobot {
    session: Session,
}

impl RawRobot {
    pub(crate) fn new(session: Session) -> Self {
        Self { session }
    }

    /// The robot's data sheet.
    pub fn body(&self) -> &Arc<Body> {
        // A Welcome has as many bodies as the Hello has robots, which was one.
        &self.session.welcome().bodies[0]
    }

    /// Length of the world's tick, in nanoseconds.
    pub fn step_ns(&self) -> u64 {
        self.session.welcome().step_ns
    }

    /// Whether the world waited for its brains when this one attached.
    pub fn lockstep(&self) -> bool {
        self.session.welcome().lockstep
    }

    /// Whether the server has closed the stream, so that no turn will come.
    pub fn is_closed(&self) -> bool {
        self.session.is_closed()
    }

    /// Waits for the next turn; as [`Robot::turn`](crate::Robot::turn).
    ///
    /// # Errors
    /// As [`Robot::turn`](crate::Robot::turn).
    pub async fn turn(&mut self) -> Result<Option<RawTurn>, Error> {
        loop {
            let Some((tick, mut parts)) = self.session.turn().await? else { return Ok(None) };
            if let Some(part) = parts.pop() {
                return Ok(Some(RawTurn { tick, at_ns: part.at_ns, bytes: part.bytes, ports: part.ports }));
            }
        }
    }

    /// Answers the turn with bytes for the microcontroller.
    ///
    /// # Errors
    /// As [`Robot::drive`](crate::Robot::drive).
    pub async fn write(&mut self, bytes: &[u8]) -> Result<(), Error> {
        self.answer(bytes, None, None).await
    }

    /// Answers the turn with bytes for the microcontroller, if any, and then waits until any byte has come, or until
    /// that instant: turns without are not given, and count as answered with nothing. In lockstep they do not even cross
    /// the network.
    ///
    /// # Errors
    /// As [`Robot::drive`](crate::Robot::drive).
    pub async fn write_and_wait(&mut self, bytes: &[u8], until: Until) -> Result<(), Error> {
        let until = Some(until);
        self.session.answer(&[(0, Answer::Write { bytes, thinking: None, operations: None, until })]).await
    }

    /// Answers the turn with bytes for the microcontroller after so much simulated time of thought.
    ///
    /// # Errors
    /// As [`Robot::drive`](crate::Robot::drive).
    pub async fn write_after(&mut self, thinking: Duration, bytes: &[u8]) -> Result<(), Error> {
        self.answer(bytes, Some(thinking), None).await
    }

    /// Answers the turn with bytes for the microcontroller after so many operations of that microcontroller, on
    /// which the brain runs.
    ///
    /// # Errors
    /// As [`Robot::drive`](crate::Robot::drive).
    pub async fn write_after_operations(&mut self, operations: u64, bytes: &[u8]) -> Result<(), Error> {
        self.answer(bytes, None, Some(operations)).await
    }

    /// Answers the turn with nothing.
    ///
    /// # Errors
    /// As [`Robot::drive`](crate::Robot::drive).
    pub async fn pass(&mut self) -> Result<(), Error> {
        self.answer(&[], None, None).await
    }

    async fn answer(
        &mut self,
        bytes: &[u8],
        thinking: Option<Duration>,
        operations: Option<u64>,
    ) -> Result<(), Error> {
        self.session.answer(&[(0, Answer::Write { bytes, thinking, operations, until: None })]).await
    }
}
