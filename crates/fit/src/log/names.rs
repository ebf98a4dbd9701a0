//! The names of columns: a quantity and its unit.

use std::fmt;

use super::error::Problem;

/// The meaning of a column of numbers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Name {
    /// A quantity that every log may have.
    Of(Quantity, Unit),
    /// A sensor's reading, by the name that it has in the table of a run: `compass`, `odometer.x_m`.
    Reading(String),
}

/// A quantity that a log may have, whatever the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// The time of the row.
    Time,
    /// The instant at which an echo's first byte was sent.
    Sent,
    /// The instant at which the echo had come back.
    Received,
    /// The distance from a sensor to the object before it.
    Distance,
    /// A sensor's value.
    Value,
    /// The left motor's signal.
    CommandLeft,
    /// The right motor's signal.
    CommandRight,
    /// The forward speed that was commanded.
    CommandSpeed,
    /// The turn rate that was commanded.
    CommandTurnRate,
    /// True position.
    X,
    /// True position.
    Y,
    /// True heading.
    Heading,
    /// True forward speed.
    Speed,
    /// True turn rate.
    TurnRate,
}

/// The dimension of a quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names say it")]
pub enum Dimension {
    Time,
    Length,
    Angle,
    Speed,
    TurnRate,
    /// A sensor's value.
    Level,
    /// A motor's signal, −1 to 1; it has no unit.
    Signal,
}

/// A unit, and its form in a name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// The end of the column's name, without `_`; empty for signals.
    pub suffix: &'static str,
    /// The unit, in SI units.
    pub si: f64,
}

impl Eq for Unit {}

impl Quantity {
    /// All of them.
    pub const ALL: [Self; 14] = [
        Self::Time,
        Self::Sent,
        Self::Received,
        Self::Distance,
        Self::Value,
        Self::CommandLeft,
        Self::CommandRight,
        Self::CommandSpeed,
        Self::CommandTurnRate,
        Self::X,
        Self::Y,
        Self::Heading,
        Self::Speed,
        Self::TurnRate,
    ];

    /// The names that it has in logs, without unit; the first is ours.
    pub const fn stems(self) -> &'static [&'static str] {
        match self {
            Self::Time => &["time", "t"],
            Self::Sent => &["sent"],
            Self::Received => &["received"],
            Self::Distance => &["distance"],
            Self::Value => &["value"],
            Self::CommandLeft => &["command_left", "left_signal"],
            Self::CommandRight => &["command_right", "right_signal"],
            Self::CommandSpeed => &["command_v"],
            Self::CommandTurnRate => &["command_w"],
            Self::X => &["x"],
            Self::Y => &["y"],
            Self::Heading => &["heading"],
            Self::Speed => &["speed"],
            Self::TurnRate => &["turn_rate"],
        }
    }

    /// The dimension.
    pub const fn dimension(self) -> Dimension {
        match self {
            Self::Time | Self::Sent | Self::Received => Dimension::Time,
            Self::Distance | Self::X | Self::Y => Dimension::Length,
            Self::Value => Dimension::Level,
            Self::CommandLeft | Self::CommandRight => Dimension::Signal,
            Self::CommandSpeed | Self::Speed => Dimension::Speed,
            Self::CommandTurnRate | Self::TurnRate => Dimension::TurnRate,
            Self::Heading => Dimension::Angle,
        }
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.stems()[0])
    }
}

impl Dimension {
    /// The units that names may end in.
    pub const fn units(self) -> &'static [Unit] {
        const fn unit(suffix: &'static str, si: f64) -> Unit {
            Unit { suffix, si }
        }
        const DEGREE: f64 = std::f64::consts::PI / 180.0;
        match self {
            Self::Time => &const { [unit("s", 1.0), unit("ms", 1e-3), unit("us", 1e-6), unit("ns", 1e-9)] },
            Self::Length => &const { [unit("m", 1.0), unit("cm", 1e-2), unit("mm", 1e-3)] },
            Self::Angle => &const { [unit("rad", 1.0), unit("deg", DEGREE)] },
            Self::Speed => &const { [unit("m_s", 1.0), unit("cm_s", 1e-2), unit("mm_s", 1e-3)] },
            Self::TurnRate => &const { [unit("rad_s", 1.0), unit("deg_s", DEGREE)] },
            Self::Level => &const { [unit("raw", 1.0), unit("fraction", 1.0), unit("v", 1.0)] },
            Self::Signal => &const { [unit("", 1.0)] },
        }
    }

    /// The names that a quantity of it may have, in words.
    pub(super) fn example(self, quantity: Quantity) -> String {
        let stem = quantity.stems()[0];
        let names: Vec<_> = self.units().iter().map(|unit| format!("`{stem}_{}`", unit.suffix)).collect();
        match names.split_last() {
            Some((last, rest)) if !rest.is_empty() => format!("{} or {last}", rest.join(", ")),
            _ => names.concat(),
        }
    }
}

/// The meaning of a column's name; nothing if it is not understood.
///
/// # Errors
/// If it is a quantity without a unit, or with one that is not known.
pub(super) fn meaning(name: &str, readings: &[String]) -> Result<Option<Name>, Problem> {
    if readings.iter().any(|reading| reading == name) {
        return Ok(Some(Name::Reading(name.to_owned())));
    }
    for quantity in Quantity::ALL {
        for stem in quantity.stems() {
            let Some(rest) = name.strip_prefix(stem) else { continue };
            let dimension = quantity.dimension();
            let unit = match (rest, rest.strip_prefix('_')) {
                ("", _) => "",
                (_, Some(unit)) => unit,
                (_, None) => continue,
            };
            if let Some(unit) = dimension.units().iter().find(|known| known.suffix == unit) {
                return Ok(Some(Name::Of(quantity, *unit)));
            }
            if unit.is_empty() {
                return Err(Problem::NoUnit { quantity, dimension });
            }
            if UNKNOWN_UNITS.contains(&unit) {
                return Err(Problem::UnknownUnit { unit: unit.to_owned(), quantity, dimension });
            }
        }
    }
    Ok(None)
}

/// Units that people write and that are not known here; any other end of a name makes it another quantity.
const UNKNOWN_UNITS: [&str; 27] = [
    "sec", "secs", "second", "seconds", "msec", "usec", "min", "h", "inch", "inches", "in", "ft", "km",
    "km_h", "kmh", "m/s", "degrees", "degree", "radians", "adc", "counts", "count", "mv", "volt", "volts",
    "percent", "rpm",
];
