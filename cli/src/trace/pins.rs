//! The pins of a robot's chip in a trace: slices where a wire is high or pulses, where a character is on the cable
//! and of rounds of the main loop; the results of the ADC as a counter.

use std::io::{self, Write};

use baudbot_plot::timing::{printable, pulses_in_words, turns_in_words};
use baudbot_plot::trace::TraceWriter;
use baudbot_sim::chip::{Board, Level, Line, News, Scope, Shown, Stretch};
use baudbot_sim::model::RobotSpec;
use baudbot_sim::{RobotView, SimTime};

/// The pins of a robot.
pub(super) struct Pins {
    robot: usize,
    scope: Scope,
    /// The last entry of each signal, until what follows is known.
    last: Vec<Option<Shown>>,
    /// Events that are over before this are not written.
    from: SimTime,
    now_ns: u64,
}

impl Pins {
    /// The `Pins` of a robot with a program of its own.
    pub(super) fn new(robot: usize, spec: &RobotSpec, from: SimTime) -> Option<Self> {
        let scope = Scope::new(spec.chip.as_ref()?, FINEST_NS);
        let last = vec![None; scope.signals().len()];
        Some(Self { robot, scope, last, from, now_ns: 0 })
    }

    pub(super) const fn robot(&self) -> usize {
        self.robot
    }

    /// Writes the new events. The world must [keep the edges](baudbot_sim::World::keep_edges).
    pub(super) fn write<W: Write>(
        &mut self,
        out: &mut TraceWriter<W>,
        (view, now): (&RobotView<'_>, SimTime),
    ) -> io::Result<()> {
        let Some(board) = view.board().filter(|board| Board::edges(board).is_some()) else { return Ok(()) };
        self.now_ns = now.as_ns();
        let News { lost, shown } = self.scope.look(board, self.now_ns);
        if lost > 0 {
            out.lost(self.robot, lost)?;
        }
        shown.into_iter().try_for_each(|(signal, shown)| self.take(out, signal, shown))
    }

    /// Writes the remaining events, at the end.
    pub(super) fn finish<W: Write>(&mut self, out: &mut TraceWriter<W>) -> io::Result<()> {
        for (signal, shown) in self.scope.finish().shown {
            self.take(out, signal, shown)?;
        }
        for signal in 0..self.last.len() {
            if let Some(last) = self.last[signal].take() {
                self.put(out, signal, last, self.now_ns)?;
            }
        }
        Ok(())
    }

    fn take<W: Write>(&mut self, out: &mut TraceWriter<W>, signal: usize, shown: Shown) -> io::Result<()> {
        let Some(last) = self.last.get_mut(signal) else { return Ok(()) };
        if last.as_mut().is_some_and(|last| last.join(&shown)) {
            return Ok(());
        }
        match last.replace(shown) {
            Some(last) => self.put(out, signal, last, shown.at_ns()),
            None => Ok(()),
        }
    }

    /// Writes what is on a signal until the next is.
    fn put<W: Write>(
        &self,
        out: &mut TraceWriter<W>,
        signal: usize,
        shown: Shown,
        next_ns: u64,
    ) -> io::Result<()> {
        let is_adc = matches!(self.scope.signals()[signal].line, Line::Adc(_));
        let (end_ns, name) = match shown {
            Shown::Number { at_ns, number } if is_adc => {
                let at = SimTime::from_ns(at_ns);
                return if at < self.from {
                    Ok(())
                } else {
                    out.signal_value(self.robot, signal, at, number)
                };
            }
            Shown::Number { number, .. } => (next_ns, printable(number)),
            Shown::Stretch(Stretch::Pulses(pulses)) => (pulses.until_ns, pulses_in_words(&pulses)),
            Shown::Stretch(Stretch::Level { level: Level::High, .. }) => (next_ns, "high".to_owned()),
            Shown::Stretch(Stretch::Level { level: Level::Short, .. }) => {
                (next_ns, "driven against each other".to_owned())
            }
            Shown::Turns(turns) => (turns.until_ns, turns_in_words(&turns)),
            Shown::Stretch(Stretch::Level { level: Level::Low | Level::Open, .. }) | Shown::Over { .. } => {
                return Ok(());
            }
        };
        let (start, end) = (SimTime::from_ns(shown.at_ns()), SimTime::from_ns(end_ns));
        if end < self.from { Ok(()) } else { out.signal_slice(self.robot, signal, (start, end), &name) }
    }
}

/// Pulses with a shorter period, in nanoseconds, are one slice.
const FINEST_NS: u64 = 1_000_000;
