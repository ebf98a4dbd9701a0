//! Dead time of motors: what they are driven with now is what the microcontroller drove them with a while ago.
//!
//! A delay line behind the microcontroller. Whatever it does to the motors passes through it: commands, the stop after
//! `timeout_ms` or at a missed deadline, and the profile of a move to a position. So a robot with a dead time T goes on
//! for T after its firmware has stopped it. The control cycle ends when a command is obeyed, before the line.
//!
//! Deviations. The notes have no dead time. Measured robots have 0.1 to 0.2 s of it: the cycle of their firmware and
//! their motor controllers, and play in their gears, which are not told apart here. It is the same for every command. A
//! change that is no command is noticed with the Euler step, and so comes up to one step later.

use alloc::collections::VecDeque;

use serde::{Deserialize, Serialize};

use crate::time::SimTime;
use crate::wheels::Wheels;

/// The motor signals that are under way from a microcontroller to its motors.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct DelayLine {
    /// When signals reach the motors, oldest first. There is at most one entry for each Euler step of a dead time.
    under_way: VecDeque<(SimTime, Wheels)>,
    /// Those that have reached them.
    arrived: Wheels,
    /// When the last command was obeyed that was put in.
    commanded_at: SimTime,
}

impl DelayLine {
    /// The motor signals in force.
    pub(crate) fn signals(&self) -> Wheels {
        self.arrived
    }

    /// Whether a line of this dead time can be in this state at `now`.
    pub(crate) fn is_sound(&self, dead_time_ns: u64, now: SimTime) -> bool {
        let times = self.under_way.iter().map(|(at, _)| *at);
        times.clone().is_sorted()
            && times.max().is_none_or(|last| last <= now + dead_time_ns)
            && self.under_way.iter().all(|(_, signals)| crate::sound::wheels(signals))
            && crate::sound::wheels(&self.arrived)
    }

    /// Takes in the signals that the microcontroller drives the motors with at `now`, and gives back those that reach
    /// the motors. `commanded_at` is when its last command was obeyed, and `since` when that one took effect.
    pub(crate) fn pass(
        &mut self,
        signals: Wheels,
        (commanded_at, since): (SimTime, SimTime),
        dead_time_ns: u64,
        now: SimTime,
    ) -> Wheels {
        let is_commanded = core::mem::replace(&mut self.commanded_at, commanded_at) != commanded_at;
        let (last, newest) = self.under_way.back().copied().unwrap_or((SimTime::ZERO, self.arrived));
        if signals != newest {
            let since = if is_commanded { since.min(now) } else { now };
            self.under_way.push_back((last.max(since + dead_time_ns), signals));
        }
        while let Some((_, signals)) = self.under_way.pop_front_if(|(at, _)| *at <= now) {
            self.arrived = signals;
        }
        self.arrived
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use super::DelayLine;
    use crate::time::SimTime;
    use crate::wheels::Wheels;

    const DEAD_NS: u64 = 95;

    /// Both motors.
    fn both(signal: f64) -> Wheels {
        Wheels { left: signal, right: signal }
    }

    fn at(ns: u64) -> SimTime {
        SimTime::from_ns(ns)
    }

    #[test]
    fn a_command_reaches_the_motors_in_the_first_step_that_is_a_dead_time_later() {
        let mut line = DelayLine::default();
        // Obeyed at 3, seen by the steps from 10 on: due at 98.
        let found: Vec<_> = (0..15)
            .map(|step| {
                let now = step * 10;
                let (signal, commanded) = if now < 10 { (0.0, 0) } else { (1.0, 3) };
                line.pass(both(signal), (at(commanded), at(commanded)), DEAD_NS, at(now)).left
            })
            .collect();
        assert_eq!(found.iter().position(|&signal| signal == 1.0), Some(10), "{found:?}");
    }

    #[test]
    fn what_the_firmware_does_by_itself_counts_from_the_step_in_which_it_is_seen() {
        let mut line = DelayLine::default();
        line.pass(both(1.0), (at(3), at(3)), DEAD_NS, at(10));
        line.pass(both(0.0), (at(3), at(3)), DEAD_NS, at(50));
        let found = [98, 99, 144, 145].map(|now| line.pass(both(0.0), (at(3), at(3)), DEAD_NS, at(now)).left);
        assert_eq!(found, [1.0, 1.0, 1.0, 0.0]);
    }

    #[test]
    fn nothing_overtakes_and_at_most_one_entry_a_step_is_under_way() {
        let mut line = DelayLine::default();
        for now in 0..1000 {
            let signal = f64::from(now as u32);
            let found = line.pass(both(signal), (at(now), at(now)), DEAD_NS, at(now)).left;
            assert_eq!(found, f64::from(now.saturating_sub(DEAD_NS) as u32));
            assert!(line.under_way.len() as u64 <= DEAD_NS, "{}", line.under_way.len());
            assert!(line.is_sound(DEAD_NS, at(now)));
        }
        assert!(!line.is_sound(DEAD_NS, at(900)));
        let mut turned = line.clone();
        turned.under_way.swap(0, 1);
        assert!(!turned.is_sound(DEAD_NS, at(999)));
        line.arrived.left = f64::NAN;
        assert!(!line.is_sound(DEAD_NS, at(999)));
    }
}
