//! The bytes of chips on their UARTs, one by one as they come to the laptop's end of the cable.
//!
//! A [`Transcript`] writes all of it; [`tails`] keep its end for the summary.

pub(crate) mod tails;

use std::io::{self, Write};

use baudbot_sim::link::{Cable, Tape};
use baudbot_sim::{SimTime, World};
use baudbot_wire::meaning::Direction;
use tokio::sync::oneshot;

use crate::text::tell;
use crate::trace::unseen;

/// Bytes of a tick that are kept until they are written.
pub(crate) const MOST_BYTES: usize = 1 << 16;

/// The bytes that have come over a robot's cable to the laptop since the last look.
#[derive(Default)]
struct Listener {
    seen: u64,
    bytes: Vec<u8>,
}

impl Listener {
    /// Takes the bytes that came after an instant into its list. How many bytes there were that are no longer kept.
    fn look(&mut self, world: &World, robot: usize, from: SimTime) -> u64 {
        self.bytes.clear();
        let Some(tape) = world.robot(robot).tape(Cable::Robot, Direction::Up) else { return 0 };
        let total = tape.total();
        let (lost, taped) = Tape::since(tape, unseen(self.seen, total));
        self.seen = total;
        self.bytes.extend(taped.filter(|taped| taped.at > from).map(|taped| taped.byte));
        lost
    }
}

/// A file that is being written, on its world's thread. The world must [keep the bytes](World::keep_tape).
pub(crate) struct Transcript {
    robot: usize,
    name: String,
    from: SimTime,
    out: Box<dyn Write + Send>,
    listener: Listener,
    lost: u64,
    /// The sender, taken when the first write fails; otherwise used when the file is done.
    outcome: Option<oneshot::Sender<io::Result<()>>>,
}

impl Transcript {
    /// A file for what a robot's chip sends after an instant, and how it went: an error as soon as one occurs, or else the end,
    /// when the file is dropped.
    pub(crate) fn new(
        out: Box<dyn Write + Send>,
        (robot, name): (usize, &str),
        from: SimTime,
    ) -> (Self, oneshot::Receiver<io::Result<()>>) {
        let (outcome, receiver) = oneshot::channel();
        let (name, listener, outcome) = (name.to_owned(), Listener::default(), Some(outcome));
        (Self { robot, name, from, out, listener, lost: 0, outcome }, receiver)
    }

    /// Writes what has come since the last call.
    pub(crate) fn write(&mut self, world: &World) {
        self.lost += self.listener.look(world, self.robot, self.from);
        if self.outcome.is_some()
            && !self.listener.bytes.is_empty()
            && let Err(error) = self.out.write_all(&self.listener.bytes)
        {
            self.tell(Err(error));
        }
    }

    fn tell(&mut self, result: io::Result<()>) {
        if let Some(outcome) = self.outcome.take() {
            let _ = outcome.send(result);
        }
    }
}

impl Drop for Transcript {
    fn drop(&mut self) {
        if self.lost > 0 {
            tell!(
                "note: {} bytes of `{}` arrived too fast and are missing in its file",
                self.lost,
                self.name
            );
        }
        // A program that has sent nothing leaves an empty file.
        let done = self.out.write(&[]).and_then(|_| self.out.flush());
        self.tell(done);
    }
}
