//! Faults: what goes wrong on a robot for a while, by script or by chance.
//!
//! A fault that comes by chance comes once in each span of `every_ns`, at an instant that is drawn evenly within it. So
//! whether it is in force follows from the instant alone: a fault has no state, adding one changes no other part's
//! chance, and a run that is restored has the same ones again.

use alloc::string::String;
use core::fmt;

use crate::random;
use crate::time::SimTime;

/// A fault of a robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// The kind of the fault.
    pub kind: FaultKind,
    /// The times at which the fault is in force.
    pub when: When,
}

/// A kind of fault.
#[derive(Clone, Debug, PartialEq)]
pub enum FaultKind {
    /// The cable to the laptop is out: bytes that would arrive are lost, both ways.
    Cable,
    /// Bytes on the cable arrive with a wrong bit.
    ByteErrors {
        /// Probability for each byte, in [0, 1].
        rate: f64,
    },
    /// The brain stalls: it takes no step. What it wrote before still travels.
    Brain,
    /// A sensor sticks: it gives its last value again and again, as if it were new.
    Sensor {
        /// The place of the sensor in [`RobotModel::sensors`](crate::model::RobotModel::sensors).
        sensor: usize,
        /// The name of the sensor.
        name: String,
    },
    /// The signal of a sensor is lost: it gives zeros, as if these were new.
    LostSignal {
        /// The sensor's place in [`RobotModel::sensors`](crate::model::RobotModel::sensors).
        sensor: usize,
        /// The sensor's name.
        name: String,
    },
}

/// The effect of a fault on a sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FaultEffect {
    /// The sensor gives its last value.
    Sticks,
    /// The sensor gives zeros.
    Lost,
}

impl fmt::Display for FaultKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Cable => f.write_str("cable out"),
            Self::ByteErrors { .. } => f.write_str("byte errors"),
            Self::Brain => f.write_str("brain stalls"),
            Self::Sensor { name, .. } => write!(f, "{name} sticks"),
            Self::LostSignal { name, .. } => write!(f, "signal of {name} lost"),
        }
    }
}

/// The times at which a fault is in force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum When {
    /// The fault is in force once.
    Once {
        /// The instant from which on it is in force.
        from: SimTime,
        /// The instant until just before which it is in force.
        until: SimTime,
    },
    /// The fault is in force once in each span of time, at random.
    Each {
        /// Length of the spans, in nanoseconds; at least 1.
        every_ns: u64,
        /// The duration after that, in nanoseconds; not longer than a span.
        for_ns: u64,
        /// The key from which the instants are drawn.
        key: u64,
    },
}

impl When {
    /// Whether it is in force at this instant, and if so until when.
    pub fn until(&self, at: SimTime) -> Option<SimTime> {
        let within = |(from, until): (SimTime, SimTime)| (from <= at && at < until).then_some(until);
        match *self {
            Self::Once { from, until } => within((from, until)),
            Self::Each { every_ns, for_ns, key } => {
                let span = at.as_ns() / every_ns;
                // The fault of the span before may reach into this one, and then into this one's own.
                let before = span.checked_sub(1).and_then(|span| within(drawn(span, every_ns, for_ns, key)));
                within(drawn(span, every_ns, for_ns, key)).max(before)
            }
        }
    }

    /// The first time that it comes into force within [`from`, `until`), from when until when.
    pub fn begins_within(&self, from: SimTime, until: SimTime) -> Option<(SimTime, SimTime)> {
        let begins =
            |(begin, end): (SimTime, SimTime)| (from <= begin && begin < until).then_some((begin, end));
        match *self {
            Self::Once { from, until } => begins((from, until)),
            Self::Each { every_ns, for_ns, key } => {
                let spans = from.as_ns() / every_ns..=until.as_ns() / every_ns;
                spans.into_iter().find_map(|span| begins(drawn(span, every_ns, for_ns, key)))
            }
        }
    }
}

/// The beginning and the end of the fault that came in this span.
fn drawn(span: u64, every_ns: u64, for_ns: u64, key: u64) -> (SimTime, SimTime) {
    let share = random::spread(key.wrapping_add(span));
    let offset_ns = ((u128::from(share) * u128::from(every_ns)) >> 64) as u64;
    let from = SimTime::from_ns(span.saturating_mul(every_ns)) + offset_ns;
    (from, from + for_ns)
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn at(ns: u64) -> SimTime {
        SimTime::from_ns(ns)
    }

    #[test]
    fn a_scripted_fault_is_in_force_from_its_first_instant_to_just_before_its_end() {
        let when = When::Once { from: at(10), until: at(20) };
        let found = [9, 10, 19, 20].map(|ns| when.until(at(ns)));
        assert_eq!(found, [None, Some(at(20)), Some(at(20)), None]);
        assert_eq!(when.begins_within(at(5), at(10)), None);
        assert_eq!(when.begins_within(at(10), at(11)), Some((at(10), at(20))));
    }

    #[test]
    fn a_fault_by_chance_comes_once_a_span_and_evenly_within_it() {
        let when = When::Each { every_ns: 1000, for_ns: 10, key: 7 };
        let mut offsets = [0_u32; 10];
        for span in 0..10_000 {
            let (from, until) = when.begins_within(at(span * 1000), at((span + 1) * 1000)).unwrap();
            assert_eq!(until.since(from), 10);
            assert_eq!(when.begins_within(from + 1, at((span + 1) * 1000)), None);
            assert!(when.until(from).is_some() && when.until(from + 9).is_some());
            offsets[(from.as_ns() % 1000 / 100) as usize] += 1;
        }
        assert!(offsets.iter().all(|n| (850..1150).contains(n)), "{offsets:?}");
    }

    #[test]
    fn a_fault_that_lasts_into_the_next_span_is_in_force_there() {
        let when = When::Each { every_ns: 100, for_ns: 100, key: 3 };
        for span in 0..100 {
            let (from, until) = when.begins_within(at(span * 100), at(span * 100 + 100)).unwrap();
            for ns in from.as_ns()..until.as_ns() {
                assert!(when.until(at(ns)).is_some(), "{ns}");
            }
        }
    }

    #[test]
    fn seeds_draw_different_instants() {
        let first = |key| When::Each { every_ns: 1 << 40, for_ns: 1, key }.begins_within(at(0), at(1 << 40));
        assert_ne!(first(1), first(2));
    }
}
