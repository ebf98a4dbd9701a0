//! The record of a logic analyser on the pins of a chip, as a VCD file (IEEE 1364, *Value change dump files*).
//!
//! [`signals`] has the signals and their names.

mod signals;

use std::io::{self, BufWriter, Write};

use baudbot_sim::chip::{Board, Edge};
use baudbot_sim::model::RobotSpec;
use baudbot_sim::{SimTime, World};
use tokio::sync::oneshot;
use vcd::{SimulationCommand, TimescaleUnit, Writer};

use crate::text::tell;
use crate::trace::unseen;
use signals::Signals;

type Out = BufWriter<Box<dyn Write + Send>>;

/// A file that is being written, on its world's thread.
pub(crate) struct Dump {
    robot: usize,
    name: String,
    /// Until the first tick.
    out: Option<Out>,
    body: Option<Body>,
    /// The number of edges that have been written or were lost.
    seen: u64,
    lost: u64,
    from_ns: u64,
    /// The sender, taken when the first write fails; otherwise used when the file is done.
    outcome: Option<oneshot::Sender<io::Result<()>>>,
}

/// The file behind its header.
struct Body {
    writer: Writer<Out>,
    signals: Signals,
    /// The instant that was written last.
    at_ns: Option<u64>,
    /// Up to when the run has been seen.
    end_ns: u64,
}

impl Dump {
    /// A file about this robot, and how it went: an error as soon as one occurs, or else the end, when the file is dropped.
    /// The world must [keep the edges](World::keep_edges).
    pub(crate) fn new(
        out: Box<dyn Write + Send>,
        (robot, spec): (usize, &RobotSpec),
        from: SimTime,
    ) -> (Self, oneshot::Receiver<io::Result<()>>) {
        let (outcome, receiver) = oneshot::channel();
        let (out, name) = (Some(BufWriter::with_capacity(BUFFER, out)), spec.name.clone());
        let (body, from_ns, outcome) = (None, from.as_ns(), Some(outcome));
        (Self { robot, name, out, body, seen: 0, lost: 0, from_ns, outcome }, receiver)
    }

    /// The edges since the last call.
    pub(crate) fn write(&mut self, world: &World) {
        if self.outcome.is_some()
            && let Err(error) = self.edges(world)
        {
            self.tell(Err(error));
        }
    }

    fn edges(&mut self, world: &World) -> io::Result<()> {
        let robot = world.robot(self.robot);
        let Some(edges) = robot.board().and_then(Board::edges) else { return Ok(()) };
        if let Some(out) = self.out.take() {
            self.body = Some(Body::new(out, robot.spec())?);
        }
        let Some(body) = &mut self.body else { return Ok(()) };
        let total = edges.total();
        let (lost, edges) = edges.since(unseen(self.seen, total));
        self.seen = total;
        self.lost += lost;
        if lost > 0 {
            body.forget(lost)?;
        }
        for edge in edges {
            body.edge(edge, self.from_ns)?;
        }
        body.begin(self.from_ns)?;
        body.end_ns = world.time().as_ns();
        Ok(())
    }

    fn tell(&mut self, result: io::Result<()>) {
        if let Some(outcome) = self.outcome.take() {
            let _ = outcome.send(result);
        }
    }
}

impl Drop for Dump {
    fn drop(&mut self) {
        if self.lost > 0 {
            tell!("note: {} edges on the pins of `{}` came too fast and are lost", self.lost, self.name);
        }
        if self.outcome.is_some() {
            let done = self.body.take().map_or(Ok(()), Body::finish);
            self.tell(done);
        }
    }
}

impl Body {
    fn new(out: Out, spec: &RobotSpec) -> io::Result<Self> {
        let mut writer = Writer::new(out);
        writer.version(concat!("baudbot ", env!("CARGO_PKG_VERSION")))?;
        writer.timescale(1, TimescaleUnit::NS)?;
        let signals = Signals::declare(&mut writer, spec)?;
        writer.enddefinitions()?;
        Ok(Self { writer, signals, at_ns: None, end_ns: 0 })
    }

    /// Writes all values as they are at an instant, once.
    fn begin(&mut self, from_ns: u64) -> io::Result<()> {
        if self.at_ns.is_some() {
            return Ok(());
        }
        self.stamp(from_ns)?;
        self.writer.begin(SimulationCommand::Dumpvars)?;
        self.signals.write_all(&mut self.writer)?;
        self.writer.end()
    }

    fn stamp(&mut self, at_ns: u64) -> io::Result<()> {
        if self.at_ns.is_none_or(|before| at_ns > before) {
            self.at_ns = Some(at_ns);
            self.writer.timestamp(at_ns)?;
        }
        Ok(())
    }

    fn edge(&mut self, edge: &Edge, from_ns: u64) -> io::Result<()> {
        let is_wanted = edge.at_ns > from_ns;
        if is_wanted {
            self.begin(from_ns)?;
        }
        let Some(change) = self.signals.take(&edge.seen).filter(|_| is_wanted) else { return Ok(()) };
        self.stamp(edge.at_ns)?;
        change.write(&mut self.writer)
    }

    /// Notes lost edges, after which nothing is known of the pins until they move again.
    fn forget(&mut self, lost: u64) -> io::Result<()> {
        self.signals.forget();
        if self.at_ns.is_none() {
            return Ok(());
        }
        self.writer.comment(&format!("{lost} edges are lost"))?;
        self.signals.write_all(&mut self.writer)
    }

    fn finish(mut self) -> io::Result<()> {
        self.stamp(self.end_ns)?;
        self.writer.flush()
    }
}

const BUFFER: usize = 1 << 16;
