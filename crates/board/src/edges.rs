//! The record of a logic analyser on the pins of a chip.

use alloc::collections::VecDeque;

use baudbot_avr::usart::Frame;
use baudbot_avr::{Pin, Pwm};

/// Something that a logic analyser would see, at its instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    /// In nanoseconds, from the origin that was given to [`keep_edges`](crate::Board::keep_edges).
    pub at_ns: u64,
    /// The record itself.
    pub seen: Seen,
}

/// A record of a logic analyser.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seen {
    /// A pin has this level from now on.
    Level {
        /// The pin.
        pin: Pin,
        /// The wire's level.
        level: Level,
        /// The cause of the change.
        by: By,
    },
    /// The ADC holds the voltage of a channel, and the conversion will have this result.
    Converted {
        /// The number of the ADC's channel, 0 to 7.
        channel: u8,
        /// The converter's result, 0 to 1023.
        result: u16,
    },
    /// A character begins at TXD; None: the last one is over.
    Sends(Option<Frame>),
    /// A character begins at RXD; None: the last one is over.
    Receives(Option<Frame>),
    /// A round of the program's main loop begins. While rounds take less than 1000 cycles together, none of their
    /// begins is reported.
    Round(RoundsOver),
    /// A signal that a timer makes on a pin, of which only the shape is simulated, has another shape.
    Shape {
        /// The pin.
        pin: Pin,
        /// The shape.
        shape: Pwm,
    },
}

/// Rounds of the program's main loop since the last reported begin of one. If that was of another loop, that one was
/// not the main loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RoundsOver {
    /// The word address of the loop's first instruction.
    pub head: u32,
    /// The number of short rounds before the last one.
    pub short: u32,
    /// The sum of their durations, in periods of the clock source.
    pub short_cycles: u32,
    /// The duration of the last one, in periods of the clock source.
    pub cycles: u64,
    /// The instant at which it began, in nanoseconds as the edge's.
    pub since_ns: u64,
}

/// The level of a wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// Ground.
    Low,
    /// The supply, also by a pull-up resistor.
    High,
    /// The wire is not driven, or has a voltage that is no digital signal.
    Open,
    /// The chip and a part drive it against each other.
    Short,
}

/// The cause of a change of a wire's level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum By {
    /// The chip. The first levels of all are counted as its own, too.
    Chip,
    /// A timer of the chip of which only the shape of the signal is simulated: the edge is drawn from that.
    Shape,
    /// A character at TXD or RXD, whose bits are drawn.
    Character,
    /// A part.
    Part,
}

/// The last edges of a board, the oldest first: [`ROOM`](Self::ROOM) of them at most.
#[derive(Clone, Debug, Default)]
pub struct Edges {
    kept: VecDeque<Edge>,
    total: u64,
}

impl Edges {
    /// The number of edges that are kept: a hundredth of a second of six outputs at 500 kHz.
    pub const ROOM: usize = 1 << 16;

    /// Notes an edge, in place of the oldest one if there is no room.
    pub(crate) fn push(&mut self, edge: Edge) {
        if self.kept.len() == Self::ROOM {
            self.kept.pop_front();
        }
        self.kept.push_back(edge);
        self.total += 1;
    }

    /// The number of all edges since they are kept.
    pub const fn total(&self) -> u64 {
        self.total
    }

    /// The edges of number `first` and later, numbered from 0 in the order of time, and how many of them are lost.
    pub fn since(&self, first: u64) -> (u64, impl Iterator<Item = &Edge>) {
        let oldest = self.total - self.kept.len() as u64;
        let seen = first.saturating_sub(oldest).min(self.kept.len() as u64);
        (oldest.saturating_sub(first), self.kept.range(seen as usize..))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_edges_are_kept_and_the_lost_ones_are_counted() {
        let mut edges = Edges::default();
        for at_ns in 0..Edges::ROOM as u64 + 10 {
            edges.push(Edge { at_ns, seen: Seen::Sends(None) });
        }
        let since = |first| {
            let (lost, mut kept) = edges.since(first);
            (lost, kept.next().map(|edge| edge.at_ns), kept.count())
        };
        assert_eq!(edges.total(), Edges::ROOM as u64 + 10);
        assert_eq!(since(0), (10, Some(10), Edges::ROOM - 1));
        assert_eq!(since(7), (3, Some(10), Edges::ROOM - 1));
        assert_eq!(since(12), (0, Some(12), Edges::ROOM - 3));
        assert_eq!([edges.total(), u64::MAX].map(since), [(0, None, 0); 2]);
    }
}
