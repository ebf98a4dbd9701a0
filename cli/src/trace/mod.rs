//! The timelines of a run as a trace that Perfetto opens, and what is on the pins of its chips.

mod pins;

use std::io::{self, BufWriter, Write};

use baudbot_plot::trace::TraceWriter;
use baudbot_sim::{SimTime, World};
use tokio::sync::oneshot;

use self::pins::Pins;

type Out = BufWriter<Box<dyn Write + Send>>;

/// A trace that is being written, on its world's thread.
pub(crate) struct Trace {
    world: String,
    /// Until the first tick.
    out: Option<Out>,
    writer: Option<TraceWriter<Out>>,
    /// The number of events of each robot that have been written or were lost.
    seen: Vec<u64>,
    /// The pins of robots with programs of their own.
    pins: Vec<Pins>,
    from: SimTime,
    /// The sender, taken when the first write fails; otherwise used when the trace is done.
    outcome: Option<oneshot::Sender<io::Result<()>>>,
}

impl Trace {
    /// A trace of a world of this name, and how it went: an error as soon as one occurs, or else the end, when the
    /// trace is dropped.
    pub(crate) fn new(
        out: Box<dyn Write + Send>,
        world: &str,
        robots: usize,
    ) -> (Self, oneshot::Receiver<io::Result<()>>) {
        let (outcome, receiver) = oneshot::channel();
        let out = Some(BufWriter::with_capacity(BUFFER, out));
        let (world, seen) = (world.to_owned(), vec![0; robots]);
        let from = SimTime::ZERO;
        (Self { world, out, writer: None, seen, pins: Vec::new(), from, outcome: Some(outcome) }, receiver)
    }

    /// Leaves out what was over before this.
    pub(crate) fn since(mut self, from: SimTime) -> Self {
        self.from = from;
        self
    }

    /// The events since the last call.
    pub(crate) fn write(&mut self, world: &World) {
        if self.outcome.is_some()
            && let Err(error) = self.events(world)
        {
            self.tell(Err(error));
        }
    }

    fn events(&mut self, world: &World) -> io::Result<()> {
        if let Some(out) = self.out.take() {
            let robots = &world.scenario().robots;
            self.writer = Some(TraceWriter::new(out, &self.world, robots)?);
            let pins = robots.iter().enumerate();
            self.pins = pins.filter_map(|(robot, spec)| Pins::new(robot, spec, self.from)).collect();
        }
        let Some(writer) = &mut self.writer else { return Ok(()) };
        for (i, (robot, seen)) in world.robots().zip(&mut self.seen).enumerate() {
            let timeline = robot.timeline();
            let (gone, events) = timeline.since(unseen(*seen, timeline.total()));
            if gone > 0 {
                writer.lost(i, gone)?;
            }
            for event in events.filter(|event| event.end >= self.from) {
                writer.event(i, event)?;
            }
            *seen = timeline.total();
        }
        for pins in &mut self.pins {
            pins.write(writer, (&world.robot(pins.robot()), world.time()))?;
        }
        Ok(())
    }

    fn finish(&mut self, mut writer: TraceWriter<Out>) -> io::Result<()> {
        self.pins.iter_mut().try_for_each(|pins| pins.finish(&mut writer))?;
        writer.finish()?.flush()
    }

    fn tell(&mut self, result: io::Result<()>) {
        if let Some(outcome) = self.outcome.take() {
            let _ = outcome.send(result);
        }
    }
}

impl Drop for Trace {
    fn drop(&mut self) {
        if self.outcome.is_some() {
            let done = self.writer.take().map_or(Ok(()), |writer| self.finish(writer));
            self.tell(done);
        }
    }
}

/// The first event that has not been seen, of a timeline of so many: all of one that is shorter than what was seen, as
/// its world was reset or restored.
pub(crate) fn unseen(seen: u64, total: u64) -> u64 {
    if seen > total { 0 } else { seen }
}

const BUFFER: usize = 1 << 16;

#[cfg(test)]
mod tests {
    use super::unseen;

    #[test]
    fn after_a_reset_nothing_has_been_seen() {
        assert_eq!([unseen(0, 5), unseen(5, 5), unseen(3, 5), unseen(5, 2)], [0, 5, 3, 0]);
    }
}
