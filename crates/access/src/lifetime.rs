//! A period of validity in the form `30d`.

use std::fmt;
use std::str::FromStr;
use std::time::{Duration, SystemTime};

use baudbot_fields::printable::Printable;

use crate::pattern::brief;

/// A time for which a token or a certificate is valid: minutes, hours, days or weeks, from a minute to 100 years.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Lifetime(Duration);

/// A text that is not a lifetime.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BadLifetime {
    /// The text is not a number with a unit.
    #[error("`{}` is not a time; write a whole number with a unit: 90m, 12h, 30d or 8w", Printable(brief(.0)))]
    Form(String),
    /// The lifetime is too short or too long.
    #[error("`{}` must be from 1m to {LONGEST_DAYS}d", Printable(brief(.0)))]
    Range(String),
}

/// The days of a hundred years.
const LONGEST_DAYS: u64 = 36_525;
const DAY_S: u64 = 24 * 60 * 60;
const UNITS: [(char, u64); 4] = [('w', 7 * DAY_S), ('d', DAY_S), ('h', 60 * 60), ('m', 60)];

impl Lifetime {
    /// The lifetime of a number of days, from 1 to 36,525; what is outside becomes the nearest of these.
    pub const fn days(days: u32) -> Self {
        let days = days as u64;
        let days = if days < 1 {
            1
        } else if days > LONGEST_DAYS {
            LONGEST_DAYS
        } else {
            days
        };
        Self(Duration::from_secs(days * DAY_S))
    }

    /// The period.
    pub fn duration(self) -> Duration {
        self.0
    }

    /// The instant at which something ends that begins then; `None` if the clock does not go so far.
    pub fn after(self, begin: SystemTime) -> Option<SystemTime> {
        begin.checked_add(self.0)
    }
}

impl FromStr for Lifetime {
    type Err = BadLifetime;

    fn from_str(text: &str) -> Result<Self, BadLifetime> {
        let form = || BadLifetime::Form(text.to_owned());
        let range = || BadLifetime::Range(text.to_owned());
        let unit = text.chars().next_back().ok_or_else(form)?;
        let (_, seconds) = UNITS.iter().find(|(name, _)| *name == unit).ok_or_else(form)?;
        let number = &text[..text.len() - 1];
        if number.is_empty() || !number.bytes().all(|byte| byte.is_ascii_digit()) {
            return Err(form());
        }
        let number: u64 = number.parse().map_err(|_| range())?;
        let whole = number.checked_mul(*seconds).filter(|whole| (60..=LONGEST_DAYS * DAY_S).contains(whole));
        whole.map(|whole| Self(Duration::from_secs(whole))).ok_or_else(range)
    }
}

impl fmt::Display for Lifetime {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let seconds = self.0.as_secs();
        // Days are what people count in; weeks are only read.
        let units = UNITS.iter().filter(|(name, _)| *name != 'w');
        let (name, unit) =
            units.into_iter().find(|(_, unit)| seconds.is_multiple_of(*unit)).unwrap_or(&('m', 60));
        write!(f, "{}{name}", seconds / unit)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn a_lifetime_is_a_number_with_a_unit() {
        let seconds = |text: &str| text.parse::<Lifetime>().unwrap().duration().as_secs();
        assert_eq!(["90m", "12h", "30d", "8w"].map(seconds), [5400, 43_200, 30 * DAY_S, 56 * DAY_S]);
        let bad = |text: &str| text.parse::<Lifetime>().unwrap_err();
        for text in ["", "d", "30", "30 d", "-1d", "+1d", "1.5h", "30D", "30s", "٣d", "30dµ"] {
            assert_eq!(bad(text), BadLifetime::Form(text.to_owned()));
        }
        for text in ["0d", "36526d", "99999999999999999999d", "9999999999999999999w"] {
            assert_eq!(bad(text), BadLifetime::Range(text.to_owned()));
        }
        assert_eq!(
            bad("30").to_string(),
            "`30` is not a time; write a whole number with a unit: 90m, 12h, 30d or 8w"
        );
        assert_eq!(bad("0d").to_string(), "`0d` must be from 1m to 36525d");
    }

    #[test]
    fn days_stay_within_their_range() {
        assert_eq!(
            [0, 1, 30, u32::MAX].map(|days| Lifetime::days(days).to_string()),
            ["1d", "1d", "30d", "36525d"]
        );
    }

    proptest! {
        #[test]
        fn what_is_printed_is_read_again(number in 1..2000_u64, unit in "[mhdw]") {
            let lifetime: Lifetime = format!("{number}{unit}").parse().unwrap();
            prop_assert_eq!(lifetime.to_string().parse::<Lifetime>().unwrap(), lifetime);
        }

        #[test]
        fn no_text_makes_the_parser_panic(text in ".*", near in "[0-9]{0,25}[mhdwµ]") {
            let _ = (text.parse::<Lifetime>(), near.parse::<Lifetime>());
        }
    }
}
