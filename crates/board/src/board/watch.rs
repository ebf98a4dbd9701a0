//! A logic analyser is fitted to a board, and read.

use alloc::boxed::Box;
use alloc::vec::Vec;

use baudbot_avr::{Pin, Port, Rounds};

use super::Board;
use super::analyser::{Analyser, Wire, Yields};
use super::surroundings::Surroundings;
use crate::edges::{Edges, Level};
use crate::parts::Part;

impl Board {
    /// Keeps the edges on the pins from now on, with instants that are counted from where the board's start is at
    /// `origin_ns`; None keeps nothing, and forgets what was kept. Another origin holds for what comes.
    ///
    /// It begins with the levels of all pins. Nothing else changes by it: it is not in what is saved, and boards with and
    /// without it are equal and go on alike. A board that is loaded keeps nothing.
    ///
    /// A timer's signal that is simulated by its shape has edges with the right distances but not the timer's phase:
    /// they are drawn as if a period began when the timer took the pin. The wires of the I²C bus and of SPI do not
    /// move. With edges, [rounds](Self::keep_rounds) are kept.
    pub fn keep_edges(&mut self, origin_ns: Option<u64>) {
        let Some(origin_ns) = origin_ns else {
            self.around.analyser.0 = None;
            return;
        };
        if let Some(analyser) = &mut self.around.analyser.0 {
            analyser.origin_ns = origin_ns;
            return;
        }
        if !self.chip.watches_rounds() {
            self.keep_rounds(true);
        }
        let wires = self.wires();
        let analyser = Analyser::new(wires, origin_ns, self.chip.now(), &self.around.clock);
        self.around.analyser.0 = Some(Box::new(analyser));
    }

    /// The edges that are [kept](Self::keep_edges).
    pub fn edges(&self) -> Option<&Edges> {
        self.around.analyser.0.as_deref().map(Analyser::edges)
    }

    /// Counts the rounds of the program's main loop by [`Chip::watch_rounds`](baudbot_avr::Chip::watch_rounds) from now
    /// on, or no longer does, and forgets them. Nothing else changes by it: they are not in what is saved, and a board
    /// that is loaded counts none.
    pub fn keep_rounds(&mut self, keep: bool) {
        self.chip.watch_rounds(keep);
    }

    /// The rounds that were [counted](Self::keep_rounds), in cycles of the clock source; None if there were none.
    pub fn rounds(&self) -> Option<&Rounds> {
        self.chip.rounds()
    }

    /// The share of the time in which the processor slept, since rounds are [counted](Self::keep_rounds); None if they are not.
    pub fn share_asleep(&self) -> Option<f64> {
        self.chip.share_asleep()
    }

    /// The levels of all pins as they were noted last, if edges are [kept](Self::keep_edges).
    pub fn levels(&self) -> impl Iterator<Item = (Pin, Level)> {
        self.around.analyser.0.iter().flat_map(|analyser| analyser.levels())
    }

    fn wires(&mut self) -> Vec<Wire> {
        let pins = Port::ALL.into_iter().flat_map(|port| (0..8).filter_map(move |bit| Pin::new(port, bit)));
        let around = &mut self.around;
        let chip = &self.chip;
        pins.map(|pin| {
            let (sides, yields) = (around.sides(pin), around.yields(pin));
            Wire { pin, sides, yields, shape: chip.pwm(pin), level: None }
        })
        .collect()
    }
}

impl Surroundings {
    /// Whether what drives a pin yields to the chip.
    fn yields(&self, pin: Pin) -> Yields {
        match self.wiring.driver(pin).and_then(|part| self.parts.get(part.index())) {
            Some(Part::Reflectance(_)) => Yields::Always,
            Some(Part::Switch(switch)) => Yields::At(switch.by_resistor()),
            Some(
                Part::Voltage(_)
                | Part::Encoder(_)
                | Part::Sonar(_)
                | Part::Bridge(_)
                | Part::Shield(_)
                | Part::Servo(_)
                | Part::Led(_)
                | Part::Piezo(_)
                | Part::Compass(_)
                | Part::RangeFinder(_),
            )
            | None => Yields::Never,
        }
    }
}
