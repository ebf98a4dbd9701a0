//! The writing of commands by a brain: the assumption of a budget, with which a run compares it.

use core::fmt;
use core::num::NonZeroU64;
use core::str::FromStr;

/// The rule for when a brain writes commands to its robot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Writes {
    /// One command in answer to each message, and nothing else. A firmware that sends nothing until it is asked is
    /// asked once, first.
    #[default]
    OnMessage,
    /// One command in a turn at most, whether or not a message has come, and none before the last one is off the cable.
    WhenFree,
    /// One command in a turn at most, whether or not a message has come.
    EveryTick,
    /// Up to so many commands a second, whether or not a message has come.
    AtMost(Frequency),
}

/// The highest rate of an event. A period of less than a tick means several times in a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Frequency(NonZeroU64);

impl Frequency {
    /// A frequency of so many times a second; `None` unless that is from 0.001 to a million.
    pub fn new(per_s: f64) -> Option<Self> {
        let is_known = (LEAST_PER_S..=MOST_PER_S).contains(&per_s);
        NonZeroU64::new((SECOND_NS / per_s) as u64).filter(|_| is_known).map(Self)
    }

    /// The time between two, in nanoseconds.
    pub const fn period_ns(self) -> u64 {
        self.0.get()
    }
}

impl Writes {
    /// The most commands that it writes in a turn, if a tick is so long.
    pub const fn in_a_turn(self, step_ns: u64) -> u64 {
        match self {
            Self::OnMessage | Self::WhenFree | Self::EveryTick => 1,
            Self::AtMost(frequency) => step_ns.div_ceil(frequency.period_ns()),
        }
    }

    /// In words: "a brain that …".
    pub fn phrase(self) -> impl fmt::Display {
        Phrase(self)
    }
}

/// A text that is none of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoWrites;

impl fmt::Display for NoWrites {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(
            "must be \"on-message\", \"when-free\", \"every-tick\", or up to so many commands a second, from 0.001 to 1000000, \
             as in \"10-per-s\"",
        )
    }
}

impl core::error::Error for NoWrites {}

impl FromStr for Writes {
    type Err = NoWrites;

    fn from_str(text: &str) -> Result<Self, NoWrites> {
        match text {
            "on-message" => Ok(Self::OnMessage),
            "when-free" => Ok(Self::WhenFree),
            "every-tick" => Ok(Self::EveryTick),
            other => {
                let per_s = other.strip_suffix(PER_S).and_then(|number| number.parse().ok());
                per_s.and_then(Frequency::new).map(Self::AtMost).ok_or(NoWrites)
            }
        }
    }
}

impl fmt::Display for Writes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::OnMessage => f.write_str("on-message"),
            Self::WhenFree => f.write_str("when-free"),
            Self::EveryTick => f.write_str("every-tick"),
            Self::AtMost(frequency) => write!(f, "{frequency}{PER_S}"),
        }
    }
}

impl fmt::Display for Frequency {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // A period of whole nanoseconds is not exact to more digits.
        let per_s = SECOND_NS / self.period_ns() as f64;
        let millionths = (per_s * 1e6) as u64;
        let rounded = millionths as f64 / 1e6;
        let near = (rounded * 1e3 + 0.5) as u64 as f64 / 1e3;
        let is_round = (near - per_s).abs() <= per_s * per_s / SECOND_NS;
        write!(f, "{}", if is_round { near } else { rounded })
    }
}

struct Phrase(Writes);

impl fmt::Display for Phrase {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Writes::OnMessage => f.write_str("answers each message once and writes nothing else"),
            Writes::WhenFree => {
                f.write_str("writes at most once a tick, and not before its last command is off the cable")
            }
            Writes::EveryTick => f.write_str("writes at most once a tick, whether or not a message has come"),
            Writes::AtMost(frequency) => {
                write!(f, "writes up to {frequency} commands a second, whether or not a message has come")
            }
        }
    }
}

impl serde::Serialize for Writes {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// The unit behind the number.
const PER_S: &str = "-per-s";

const LEAST_PER_S: f64 = 1e-3;
const MOST_PER_S: f64 = 1e6;
const SECOND_NS: f64 = 1e9;

#[cfg(test)]
mod tests {
    extern crate std;

    use std::string::ToString;

    use super::*;

    #[test]
    fn each_is_read_as_it_is_written() {
        for text in [
            "on-message",
            "when-free",
            "every-tick",
            "10-per-s",
            "0.5-per-s",
            "3-per-s",
            "200-per-s",
            "333.3-per-s",
        ] {
            assert_eq!(text.parse::<Writes>().map(|writes| writes.to_string()), Ok(text.to_string()));
        }
        for text in [
            "",
            "always",
            "10",
            "0-per-s",
            "-1-per-s",
            "NaN-per-s",
            "inf-per-s",
            "2000000-per-s",
            "ten-per-s",
        ] {
            assert_eq!(text.parse::<Writes>(), Err(NoWrites), "{text}");
        }
    }

    #[test]
    fn more_than_one_a_tick_are_several_in_a_turn() {
        let in_a_turn = |text: &str| text.parse::<Writes>().unwrap().in_a_turn(10_000_000);
        assert_eq!(
            ["every-tick", "10-per-s", "100-per-s", "150-per-s", "200-per-s"].map(in_a_turn),
            [1, 1, 1, 2, 2]
        );
    }
}
