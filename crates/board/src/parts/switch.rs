//! A switch to ground, or to the supply, whose contact bounces.
//!
//! The bounce is a pattern: an odd number of edges from the change on, the last of which leaves the new level. Where they
//! are follows from the seed and from how often the switch has changed.
//!
//! Source: J. Ganssle, *A Guide to Debouncing*: of 18 switches most bounced for less than 2 ms, on average for 1.6 ms.

use baudbot_avr::External;
use serde::{Deserialize, Serialize};

use super::Change;
use crate::clock::ChipClock;
use crate::role::Role;

/// The resistor that holds the wire of an open switch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Pull {
    /// A resistor on the board to the supply. Closed is low.
    External,
    /// The pull-up resistor of the pin, if the program switches it on; else the pin floats. Closed is low.
    Internal,
    /// A resistor on the board to ground; the switch is to the supply. Closed is high.
    Down,
}

/// A switch: a whisker, a bumper, a button, the output of a comparator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Switch {
    /// The resistor that holds it while it is open.
    pub pull: Pull,
    /// Its contact bounces for so long at most, in microseconds. 0: it does not.
    pub bounce_us: u32,
    /// The seed of the pattern of bounces.
    pub seed: u64,
}

/// Pairs of edges after the first one: 1 to this many.
const MOST_PAIRS: u64 = 4;

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct State {
    switch: Switch,
    pressed: Option<bool>,
    /// Changes up to now.
    changes: u64,
    changed_ns: u64,
    /// Edges of the last change that are still to come.
    left: u8,
    edges: u8,
}

impl State {
    pub(crate) const fn new(switch: Switch) -> Self {
        Self { switch, pressed: None, changes: 0, changed_ns: 0, left: 0, edges: 0 }
    }

    pub(crate) fn is_possible(&self, switch: Switch, now_ns: u64) -> bool {
        self.switch == switch
            && self.left <= self.edges
            && u64::from(self.edges) <= 1 + 2 * MOST_PAIRS
            && self.changes < u64::MAX / 2
            && self.changed_ns <= now_ns
    }

    /// The level of the wire that its resistor alone makes, and the chip may override.
    pub(crate) const fn by_resistor(&self) -> External {
        match self.switch.pull {
            Pull::External | Pull::Internal => External::High,
            Pull::Down => External::Low,
        }
    }

    pub(crate) fn begin(&mut self, pressed: bool, at_ns: u64) {
        if self.pressed == Some(pressed) {
            return;
        }
        let bounces = self.pressed.is_some() && self.switch.bounce_us > 0;
        self.changes += 1;
        self.edges = if bounces { 3 + 2 * (self.random(0) % MOST_PAIRS) as u8 } else { 1 };
        self.left = self.edges;
        self.changed_ns = at_ns;
        self.pressed = Some(pressed);
    }

    pub(crate) fn next_change(&self, clock: &ChipClock) -> Option<Change> {
        if self.left == 0 {
            return None;
        }
        // The last edge leaves the new level, the one before it the old one.
        let is_closed = (self.pressed == Some(true)) == (self.left % 2 == 1);
        let external = match (is_closed, self.switch.pull) {
            (true, Pull::External | Pull::Internal) | (false, Pull::Down) => External::Low,
            (false, Pull::External) | (true, Pull::Down) => External::High,
            (false, Pull::Internal) => External::Open,
        };
        let at = clock.cycle(self.changed_ns.saturating_add(self.edge_ns(self.edges - self.left)));
        Some(Change { at, role: Role::Signal, external })
    }

    pub(crate) fn change_taken(&mut self) {
        self.left = self.left.saturating_sub(1);
    }

    /// When an edge comes, counted from the change. Each has its own share of the bounce.
    fn edge_ns(&self, edge: u8) -> u64 {
        if edge == 0 {
            return 0;
        }
        let share = u64::from(self.switch.bounce_us) * 1000 / u64::from(self.edges);
        share * u64::from(edge) + self.random(edge) % share.max(1)
    }

    /// SplitMix64 of the seed, the change and the edge.
    fn random(&self, edge: u8) -> u64 {
        const GOLDEN: u64 = 0x9E37_79B9_7F4A_7C15;
        let place = (self.changes << 8 | u64::from(edge)).wrapping_mul(GOLDEN);
        let mut word = self.switch.seed.wrapping_add(place).wrapping_add(GOLDEN);
        word = (word ^ word >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        word = (word ^ word >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        word ^ word >> 31
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::*;

    fn edges(state: &mut State) -> Vec<(u64, External)> {
        let clock = ChipClock::exact(16_000_000).unwrap();
        let mut edges = Vec::new();
        while let Some(change) = state.next_change(&clock) {
            edges.push((change.at, change.external));
            state.change_taken();
        }
        edges
    }

    #[test]
    fn a_bounce_is_an_odd_number_of_alternating_edges_within_its_time() {
        for seed in 0..200 {
            let mut state = State::new(Switch { pull: Pull::External, bounce_us: 1000, seed });
            state.begin(false, 0);
            assert_eq!(edges(&mut state), [(0, External::High)]);
            for (pressed, at_ns, last) in
                [(true, 1_000_000, External::Low), (false, 5_000_000, External::High)]
            {
                state.begin(pressed, at_ns);
                let edges = edges(&mut state);
                let start = at_ns * 16 / 1000;
                assert!(edges.len() % 2 == 1 && edges.len() >= 3, "{edges:?}");
                assert_eq!((edges[0].0, edges.last().unwrap().1), (start, last));
                assert!(
                    edges.windows(2).all(|two| two[0].0 <= two[1].0 && two[0].1 != two[1].1),
                    "{edges:?}"
                );
                assert!(edges.last().unwrap().0 <= start + 16_000);
            }
        }
    }

    #[test]
    fn without_bounce_there_is_one_edge() {
        let mut state = State::new(Switch { pull: Pull::Internal, bounce_us: 0, seed: 1 });
        state.begin(false, 0);
        assert_eq!(edges(&mut state), [(0, External::Open)]);
        state.begin(true, 500);
        assert_eq!(edges(&mut state), [(8, External::Low)]);
        state.begin(true, 900);
        assert_eq!(edges(&mut state), []);
    }

    #[test]
    fn a_switch_to_the_supply_is_high_when_closed() {
        let mut state = State::new(Switch { pull: Pull::Down, bounce_us: 0, seed: 1 });
        state.begin(false, 0);
        assert_eq!(edges(&mut state), [(0, External::Low)]);
        state.begin(true, 500);
        assert_eq!(edges(&mut state), [(8, External::High)]);
    }

    #[test]
    fn other_seeds_bounce_in_another_way() {
        let pattern = |seed| {
            let mut state = State::new(Switch { pull: Pull::External, bounce_us: 1000, seed });
            state.begin(false, 0);
            edges(&mut state);
            state.begin(true, 0);
            edges(&mut state)
        };
        assert_eq!(pattern(1), pattern(1));
        assert_ne!(pattern(1), pattern(2));
    }
}
