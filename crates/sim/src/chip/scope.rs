//! The record of a logic analyser on a chip's pins, signal by signal.

use alloc::vec::Vec;

use baudbot_board::{Board, Level, Net, RoundsOver, Seen};

use super::ChipSpec;
use super::pulses::{Condenser, Stretch};
use super::signals::{Line, Signal};
use super::turns::{Rounds, Turns};

/// Reads the [edges](Board::edges) of a board as they come, and returns what is on each of its signals.
#[derive(Clone, Debug)]
pub struct Scope {
    signals: Vec<Signal>,
    /// The condenser of each signal; that of no wire is idle.
    condensers: Vec<Condenser>,
    rounds: Rounds,
    /// The number of edges that have been read.
    seen: u64,
}

/// Something on a signal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shown {
    /// The level of a wire, or pulses on it.
    Stretch(Stretch),
    /// A number from an instant on: a result of the ADC, whose voltage is held then, or a character, which begins then.
    Number {
        /// In nanoseconds.
        at_ns: u64,
        /// The result, from 0 to 1023, or the character's data.
        number: u16,
    },
    /// Rounds of the main loop, which are over.
    Turns(Turns),
    /// The character is over.
    Over {
        /// In nanoseconds.
        at_ns: u64,
    },
}

/// The news of the signals.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct News {
    /// The number of edges that came too fast and are lost: nothing is known of a wire until it is shown again.
    pub lost: u64,
    /// Each with the place of its signal; of each signal in the order of time.
    pub shown: Vec<(usize, Shown)>,
}

impl Shown {
    /// The instant at which it begins, in nanoseconds.
    pub const fn at_ns(&self) -> u64 {
        match *self {
            Self::Stretch(stretch) => stretch.at_ns(),
            Self::Turns(Turns { from_ns, .. }) => from_ns,
            Self::Number { at_ns, .. } | Self::Over { at_ns } => at_ns,
        }
    }
}

impl Shown {
    /// Takes in what follows on this and goes on with it. Returns whether it has done so.
    pub fn join(&mut self, next: &Self) -> bool {
        match (self, next) {
            (Self::Stretch(Stretch::Pulses(last)), Self::Stretch(Stretch::Pulses(next))) => last.join(next),
            (Self::Turns(last), Self::Turns(next)) => last.join(next),
            (Self::Stretch(_) | Self::Turns(_) | Self::Number { .. } | Self::Over { .. }, _) => false,
        }
    }
}

impl Scope {
    /// A scope on the pins of such a chip. Pulses with a period below a limit, in nanoseconds, and rounds of the main
    /// loop that are shorter than that are summed up.
    pub fn new(chip: &ChipSpec, finest_ns: u64) -> Self {
        let signals = chip.signals();
        let condensers = signals.iter().map(|_| Condenser::new(finest_ns)).collect();
        Self { signals, condensers, rounds: Rounds::new(finest_ns), seen: 0 }
    }

    /// All signals; places are places among them.
    pub fn signals(&self) -> &[Signal] {
        &self.signals
    }

    /// The events since the last look; `now_ns` is the world's time. Pulses that go on are reported a little later.
    pub fn look(&mut self, board: &Board, now_ns: u64) -> News {
        let mut news = News::default();
        let Some(edges) = board.edges() else { return news };
        // Edges that are kept anew are counted from 0.
        let first = if edges.total() < self.seen { 0 } else { self.seen };
        let (lost, fresh) = edges.since(first);
        self.seen = edges.total();
        news.lost = lost;
        let fresh: Vec<_> = fresh.copied().collect();
        if lost > 0 {
            let has_moved = |net| fresh.iter().any(|edge| Line::of(edge.seen) == Some(Line::Wire(net)));
            let from_ns = fresh.first().map_or(now_ns, |edge| edge.at_ns);
            self.rounds.forget();
            self.begin_again(board, from_ns, has_moved, &mut news.shown);
        }
        for edge in &fresh {
            self.take(edge.at_ns, edge.seen, &mut news.shown);
        }
        self.each(&mut news.shown, |condenser, out| condenser.settle(now_ns, out));
        news
    }

    /// The remaining events, at the end.
    pub fn finish(&mut self) -> News {
        let mut news = News::default();
        self.each(&mut news.shown, Condenser::finish);
        news
    }

    /// Nothing is known of what was before an instant. A wire that has not moved since had its level then.
    fn begin_again(
        &mut self,
        board: &Board,
        from_ns: u64,
        has_moved: impl Fn(Net) -> bool,
        shown: &mut Vec<(usize, Shown)>,
    ) {
        self.each(&mut Vec::new(), Condenser::finish);
        for (pin, level) in board.levels().filter(|(pin, _)| !has_moved(Net::Pin(*pin))) {
            self.level(from_ns, Net::Pin(pin), level, shown);
        }
    }

    fn take(&mut self, at_ns: u64, seen: Seen, shown: &mut Vec<(usize, Shown)>) {
        let one = match seen {
            Seen::Level { pin, level, .. } => return self.level(at_ns, Net::Pin(pin), level, shown),
            Seen::Converted { result, .. } => Shown::Number { at_ns, number: result },
            Seen::Sends(Some(frame)) | Seen::Receives(Some(frame)) => {
                Shown::Number { at_ns, number: frame.data() }
            }
            Seen::Sends(None) | Seen::Receives(None) => Shown::Over { at_ns },
            Seen::Round(over) => return self.round(at_ns, &over, shown),
            Seen::Shape { .. } => return,
        };
        let line = Line::of(seen);
        let place = self.signals.iter().position(|signal| Some(signal.line) == line);
        shown.extend(place.map(|place| (place, one)));
    }

    fn round(&mut self, at_ns: u64, over: &RoundsOver, shown: &mut Vec<(usize, Shown)>) {
        let place = self.signals.iter().position(|signal| signal.line == Line::MainLoop);
        let Some(place) = place else { return };
        let mut out = Vec::new();
        self.rounds.take(at_ns, over, &mut out);
        for next in out {
            let next = Shown::Turns(next);
            let last = shown.iter_mut().rfind(|(signal, _)| *signal == place);
            if !last.is_some_and(|(_, last)| last.join(&next)) {
                shown.push((place, next));
            }
        }
    }

    fn level(&mut self, at_ns: u64, net: Net, level: Level, shown: &mut Vec<(usize, Shown)>) {
        let place = self.signals.iter().position(|signal| signal.line == Line::Wire(net));
        let Some(place) = place else { return };
        let mut out = Vec::new();
        self.condensers[place].take(at_ns, level, &mut out);
        shown.extend(out.into_iter().map(|stretch| (place, Shown::Stretch(stretch))));
    }

    fn each(
        &mut self,
        shown: &mut Vec<(usize, Shown)>,
        mut tell: impl FnMut(&mut Condenser, &mut Vec<Stretch>),
    ) {
        let mut out = Vec::new();
        for (place, condenser) in self.condensers.iter_mut().enumerate() {
            tell(condenser, &mut out);
            shown.extend(out.drain(..).map(|stretch| (place, Shown::Stretch(stretch))));
        }
    }
}
