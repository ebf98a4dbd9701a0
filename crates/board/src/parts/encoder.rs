//! An encoder of a wheel, with one channel or two in quadrature.
//!
//! A turn has a number of counts, which are the edges of all channels. Channel a leads while the angle grows.

use core::f64::consts::TAU;

use baudbot_avr::External;
use serde::{Deserialize, Serialize};

use super::Change;
use crate::clock::ChipClock;
use crate::physics::Wheel;
use crate::role::Role;

/// The number of an encoder's channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Channels {
    /// One: the direction is not seen.
    Single,
    /// Two, a quarter of a period apart.
    Quadrature,
}

/// An encoder with push-pull outputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Encoder {
    /// The encoder's channels.
    pub channels: Channels,
    /// Edges of all channels together in a turn of the wheel; at least 1 is assumed.
    pub counts_per_turn: u32,
}

/// An angle so close to an edge, in counts, does not decide on which side it is: a step may end where the next begins, but
/// for the rounding.
const SLACK_COUNTS: f64 = 1e-6;
/// The farthest that a wheel turns: from here on an `f64` does not hold each count.
const MOST_COUNTS: f64 = 9e15;
/// The fastest counts that the part can show, per second.
const FASTEST_COUNTS_PER_S: f64 = 1e6;
const NS_PER_S: f64 = 1e9;

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct State {
    encoder: Encoder,
    /// The angle at the step's start, in counts.
    start: f64,
    /// Counts per second.
    rate: f64,
    start_ns: u64,
    /// Counts up to the last edge; None before the first step.
    count: Option<i64>,
    /// The levels that the chip knows.
    levels: [Option<bool>; 2],
}

impl State {
    pub(crate) const fn new(encoder: Encoder) -> Self {
        Self { encoder, start: 0.0, rate: 0.0, start_ns: 0, count: None, levels: [None; 2] }
    }

    pub(crate) fn is_possible(&self, encoder: Encoder, now_ns: u64) -> bool {
        self.encoder == encoder
            && self.start.abs() <= MOST_COUNTS
            && self.rate.abs() <= FASTEST_COUNTS_PER_S
            && self.count.is_none_or(|count| count.unsigned_abs() <= 2 * MOST_COUNTS as u64)
            && self.start_ns <= now_ns
    }

    pub(crate) fn begin(&mut self, wheel: Wheel, at_ns: u64) {
        let counts = |radians: f64| {
            let counts = radians * f64::from(self.encoder.counts_per_turn.max(1)) / TAU;
            if counts.is_finite() { counts.clamp(-MOST_COUNTS, MOST_COUNTS) } else { 0.0 }
        };
        self.start = counts(wheel.angle_rad);
        self.rate = counts(wheel.rate_rad_s).clamp(-FASTEST_COUNTS_PER_S, FASTEST_COUNTS_PER_S);
        self.start_ns = at_ns;
        let stays = |count: &i64| {
            let into = self.start - *count as f64;
            (-SLACK_COUNTS..=1.0 + SLACK_COUNTS).contains(&into)
        };
        let count = self.count.filter(stays);
        self.count = Some(count.unwrap_or_else(|| libm::floor(self.start) as i64));
    }

    pub(crate) fn next_change(&self, clock: &ChipClock) -> Option<Change> {
        self.next(clock).map(|(change, _)| change)
    }

    pub(crate) fn change_taken(&mut self, clock: &ChipClock) {
        if let Some((change, count)) = self.next(clock) {
            self.count = Some(count);
            self.levels[usize::from(change.role == Role::B)] = Some(change.external == External::High);
        }
    }

    /// The next edge, and the count behind it. Levels that are not those of the count come first, at once.
    fn next(&self, clock: &ChipClock) -> Option<(Change, i64)> {
        let count = self.count?;
        if let Some(role) = self.wrong(count) {
            return Some((self.change(clock.cycle(self.start_ns), role, count), count));
        }
        if self.rate == 0.0 {
            return None;
        }
        let (edge, next) = if self.rate > 0.0 { (count + 1, count + 1) } else { (count, count - 1) };
        let seconds = ((edge as f64 - self.start) / self.rate).max(0.0);
        let at_ns = self.start_ns.saturating_add(libm::round(seconds * NS_PER_S) as u64);
        let role = self.wrong(next)?;
        Some((self.change(clock.cycle(at_ns), role, next), next))
    }

    fn change(&self, at: u64, role: Role, count: i64) -> Change {
        let external = if self.level(role, count) { External::High } else { External::Low };
        Change { at, role, external }
    }

    /// A channel whose level is not that of a count.
    fn wrong(&self, count: i64) -> Option<Role> {
        let channels = match self.encoder.channels {
            Channels::Single => &[Role::A][..],
            Channels::Quadrature => &[Role::A, Role::B],
        };
        let known = |role: Role| self.levels[usize::from(role == Role::B)];
        channels.iter().copied().find(|&role| known(role) != Some(self.level(role, count)))
    }

    fn level(&self, role: Role, count: i64) -> bool {
        match (self.encoder.channels, role) {
            (Channels::Single, _) => count & 1 == 1,
            (Channels::Quadrature, Role::B) => count & 2 != 0,
            (Channels::Quadrature, _) => (count + 1) & 2 != 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::*;

    const QUADRATURE: Encoder = Encoder { channels: Channels::Quadrature, counts_per_turn: 4 };

    /// Edges up to an instant, in microseconds.
    fn edges(state: &mut State, until_us: u64) -> Vec<(u64, Role, External)> {
        let clock = ChipClock::exact(1_000_000).unwrap();
        let mut edges = Vec::new();
        while let Some(change) = state.next_change(&clock).filter(|change| change.at <= until_us) {
            edges.push((change.at, change.role, change.external));
            state.change_taken(&clock);
        }
        edges
    }

    #[test]
    fn a_leads_b_forwards_and_b_leads_a_backwards() {
        use External::{High, Low};
        let mut state = State::new(QUADRATURE);
        state.begin(Wheel { angle_rad: 0.1, rate_rad_s: 0.0 }, 0);
        assert_eq!(edges(&mut state, 0), [(0, Role::A, Low), (0, Role::B, Low)]);
        state.begin(Wheel { angle_rad: TAU / 8.0, rate_rad_s: TAU }, 0);
        let forwards = edges(&mut state, 1_100_000);
        assert_eq!(
            forwards,
            [
                (125_000, Role::A, High),
                (375_000, Role::B, High),
                (625_000, Role::A, Low),
                (875_000, Role::B, Low)
            ]
        );
        state.begin(Wheel { angle_rad: TAU / 8.0 + 1.1 * TAU, rate_rad_s: -TAU }, 2_000_000_000);
        let first = edges(&mut state, 2_300_000);
        assert_eq!(first.iter().map(|edge| (edge.1, edge.2)).collect::<Vec<_>>(), [(Role::B, High)]);
    }

    #[test]
    fn a_turn_has_its_counts_however_it_is_divided_into_steps() {
        for steps in [1, 3, 7, 1000] {
            let encoder = Encoder { channels: Channels::Quadrature, counts_per_turn: 1200 };
            let mut state = State::new(encoder);
            let mut count = 0;
            state.begin(Wheel::default(), 0);
            edges(&mut state, 0);
            for step in 0..steps {
                let at = |step: u64| step * 1_000_000 / steps;
                let angle_rad = TAU * at(step) as f64 / 1e6 + 0.001;
                state.begin(Wheel { angle_rad, rate_rad_s: TAU }, at(step) * 1000);
                count += edges(&mut state, at(step + 1)).len();
            }
            assert_eq!(count, 1200, "{steps} steps");
        }
    }

    #[test]
    fn a_wheel_that_is_no_number_or_too_fast_ends() {
        for rate_rad_s in [f64::NAN, f64::INFINITY, 1e300, -1e300] {
            for angle_rad in [f64::NAN, 1e300, -1e300] {
                let mut state = State::new(QUADRATURE);
                state.begin(Wheel { angle_rad, rate_rad_s }, 0);
                assert!(edges(&mut state, 1000).len() <= 1003);
            }
        }
    }
}
