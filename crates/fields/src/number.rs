//! Numbers of files that keep to a range. The range is part of a field's type: it is checked where the field is read, and the
//! JSON Schema has it from there.
//!
//! A field that is read only to be made into something else is a [`Number`]. A field of the world's own types is what it is there, and has
//! the rule as an attribute, `#[serde(with = "Number::<Positive>")]`.

use alloc::format;
use alloc::string::{String, ToString};
use core::fmt::{Debug, Display};
use core::marker::PhantomData;

use serde::de::{DeserializeOwned, Error};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// What a number may be, and what becomes of it.
pub trait Rule {
    /// As what it is written.
    type Written: Figure;
    /// What becomes of it.
    type Value: Copy + Debug;
    /// What is said first of a number that is out of range.
    const SIGN: Sign = Sign::Any;
    /// The least that it may be.
    const LEAST: f64 = f64::NEG_INFINITY;
    /// The most that it may be.
    const MOST: f64 = f64::INFINITY;

    /// What becomes of a number that is in range.
    fn value(written: Self::Written) -> Self::Value;

    /// The number of which this becomes.
    fn written(value: Self::Value) -> Self::Written;
}

/// How a number is written: with a fraction, or whole and not negative.
pub trait Figure: Copy + From<u32> + Display + DeserializeOwned + Serialize {
    /// Its type in a JSON Schema.
    const TYPE: &'static str;

    /// The number that is compared with a range.
    fn number(self) -> f64;
}

impl Figure for f64 {
    const TYPE: &'static str = "number";

    fn number(self) -> f64 {
        self
    }
}

impl Figure for u64 {
    const TYPE: &'static str = "integer";

    fn number(self) -> f64 {
        self as f64
    }
}

/// Which numbers there are at all, whatever the bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sign {
    /// All.
    Any,
    /// Those that are finite.
    Finite,
    /// Those above 0.
    Positive,
    /// 0 and those above it.
    NotNegative,
}

impl Sign {
    /// The rule that a number breaks, in words.
    fn broken_by(self, number: f64) -> Option<&'static str> {
        let (holds, words) = match self {
            Self::Any => return None,
            Self::Finite => (true, "must be a finite number"),
            Self::Positive => (number > 0.0, "must be positive"),
            Self::NotNegative => (number >= 0.0, "must not be negative"),
        };
        (!holds || !number.is_finite()).then_some(words)
    }
}

/// A number that a rule refuses.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{rule}, is {written}")]
pub struct OutOfRange {
    /// What the number must be.
    pub rule: String,
    /// The number as it is written.
    pub written: String,
}

/// What becomes of a number, if it keeps to a rule.
///
/// # Errors
/// Says what it must be.
pub fn checked<R: Rule>(written: R::Written) -> Result<R::Value, OutOfRange> {
    let number = written.number();
    let rule = match R::SIGN.broken_by(number) {
        Some(words) => words.to_string(),
        None if (R::LEAST..=R::MOST).contains(&number) => return Ok(R::value(written)),
        None if R::MOST == f64::INFINITY => format!("must be at least {}", R::LEAST),
        None => format!("must be between {} and {}", R::LEAST, R::MOST),
    };
    Err(OutOfRange { rule, written: written.to_string() })
}

/// A number that keeps to a rule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Number<R: Rule>(R::Value);

impl<R: Rule> Number<R> {
    /// What became of the number.
    pub fn get(self) -> R::Value {
        self.0
    }

    /// A whole number that is known when the program is compiled, such as a default.
    pub fn constant<const NUMBER: u32>() -> Self {
        const {
            let number = NUMBER as f64;
            let is_in_range = R::LEAST <= number && number <= R::MOST;
            assert!(is_in_range && (NUMBER > 0 || !matches!(R::SIGN, Sign::Positive)));
        }
        Self(R::value(NUMBER.into()))
    }

    /// Another number of the program's own.
    ///
    /// # Panics
    /// If it breaks the rule.
    pub fn of(written: R::Written) -> Self {
        Self(checked::<R>(written).expect("a number of the program's own keeps to its rule"))
    }

    /// Reads what becomes of a number, for the attribute `with` of a field that is this.
    ///
    /// # Errors
    /// Says which rule the number breaks.
    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<R::Value, D::Error> {
        checked::<R>(R::Written::deserialize(deserializer)?).map_err(D::Error::custom)
    }

    /// Writes such a field as it stands in a file, for the defaults of a JSON Schema.
    ///
    /// # Errors
    /// Those of the format.
    pub fn serialize<S: Serializer>(value: &R::Value, serializer: S) -> Result<S::Ok, S::Error> {
        R::written(*value).serialize(serializer)
    }
}

impl<R: Rule> Default for Number<R> {
    fn default() -> Self {
        Self::constant::<0>()
    }
}

impl<'de, R: Rule> Deserialize<'de> for Number<R> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Self::deserialize(deserializer).map(Self)
    }
}

impl<R: Rule> Serialize for Number<R> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Self::serialize(&self.0, serializer)
    }
}

/// Rules of numbers with a fraction: a name, what is said first of a number that is out of range, the least and the most.
#[macro_export]
macro_rules! rules {
    ($($(#[$doc:meta])* $name:ident $(<$($bound:ident),*>)?: $sign:ident, $least:expr, $most:expr;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $name$(<$(const $bound: i64),*>)?;

        impl$(<$(const $bound: i64),*>)? $crate::number::Rule for $name$(<$($bound),*>)? {
            type Written = f64;
            type Value = f64;
            const SIGN: $crate::number::Sign = $crate::number::Sign::$sign;
            const LEAST: f64 = $least;
            const MOST: f64 = $most;

            fn value(written: f64) -> f64 {
                written
            }

            fn written(value: f64) -> f64 {
                value
            }
        }
    )*};
}

/// A share of something.
pub type Share = Between<0, 1>;

rules! {
    /// A number above 0.
    Positive: Positive, 0.0, f64::INFINITY;
    /// A number of 0 or more.
    NotNegative: NotNegative, 0.0, f64::INFINITY;
    /// A number from `LEAST` to `MOST`.
    Between<LEAST, MOST>: Any, LEAST as f64, MOST as f64;
    /// A number above 0 and up to `MOST`.
    UpTo<MOST>: Positive, 0.0, MOST as f64;
    /// A coordinate in metres: no arena is a million metres wide.
    Coordinate: Finite, -1e6, 1e6;
    /// A length in metres.
    Length: Positive, 1e-6, 1e6;
    /// A standard deviation.
    Sigma: NotNegative, 0.0, 1e3;
    /// An angle of up to a turn, in radians, either way.
    Turn: Any, -core::f64::consts::TAU, core::f64::consts::TAU;
    /// An angle that is open, up to a whole turn, in radians.
    Opening: Any, 0.0, core::f64::consts::TAU;
    /// An angle that is open, up to half a turn, in radians.
    HalfOpening: Any, 0.0, core::f64::consts::PI;
}

/// A whole number from `LEAST` to `MOST`, which a `T` can be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Whole<const LEAST: u64, const MOST: u64, T = u64>(PhantomData<T>);

impl<const LEAST: u64, const MOST: u64, T> Rule for Whole<LEAST, MOST, T>
where
    T: Copy + Debug + TryFrom<u64, Error: Debug> + Into<u64>,
{
    type Written = u64;
    type Value = T;
    const LEAST: f64 = LEAST as f64;
    const MOST: f64 = if MOST == u64::MAX { f64::INFINITY } else { MOST as f64 };

    fn value(written: u64) -> T {
        T::try_from(written).expect("a type that has the range's numbers")
    }

    fn written(value: T) -> u64 {
        value.into()
    }
}

/// A time that is written in units of so many nanoseconds, and becomes whole nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Time<R, const UNIT_NS: u64>(PhantomData<R>);

/// A time that is written in seconds.
pub type Seconds<R> = Time<R, 1_000_000_000>;
/// A time that is written in milliseconds.
pub type Millis<R> = Time<R, 1_000_000>;
/// A time that is written in microseconds.
pub type Micros<R> = Time<R, 1_000>;

impl<R: Rule<Written = f64>, const UNIT_NS: u64> Rule for Time<R, UNIT_NS> {
    type Written = f64;
    type Value = u64;
    const SIGN: Sign = R::SIGN;
    const LEAST: f64 = R::LEAST;
    const MOST: f64 = R::MOST;

    fn value(written: f64) -> u64 {
        to_ns(written, UNIT_NS as f64)
    }

    fn written(value: u64) -> f64 {
        value as f64 / UNIT_NS as f64
    }
}

/// So many units in nanoseconds.
pub(crate) fn to_ns(value: f64, unit_ns: f64) -> u64 {
    (value * unit_ns + 0.5) as u64
}

/// A number that is written in thousandths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thousandths<R>(PhantomData<R>);

impl<R: Rule<Written = f64>> Rule for Thousandths<R> {
    type Written = f64;
    type Value = f64;
    const SIGN: Sign = R::SIGN;
    const LEAST: f64 = R::LEAST;
    const MOST: f64 = R::MOST;

    fn value(written: f64) -> f64 {
        written / 1e3
    }

    fn written(value: f64) -> f64 {
        value * 1e3
    }
}

#[cfg(feature = "schema")]
mod schema {
    use alloc::borrow::Cow;

    use schemars::{JsonSchema, Schema, SchemaGenerator};

    use super::{Figure, Number, Rule, Sign};

    /// That the bounds are a rule's, and not those of a type of Rust.
    const RULE: &str = "x-rule";

    impl<R: Rule> JsonSchema for Number<R> {
        fn schema_name() -> Cow<'static, str> {
            "Number".into()
        }

        fn inline_schema() -> bool {
            true
        }

        fn json_schema(_: &mut SchemaGenerator) -> Schema {
            let mut schema = Schema::default();
            schema.insert("type".into(), R::Written::TYPE.into());
            schema.insert(RULE.into(), true.into());
            let is_open = R::SIGN == Sign::Positive && R::LEAST == 0.0;
            let least = if is_open { "exclusiveMinimum" } else { "minimum" };
            for (keyword, bound) in [(least, R::LEAST), ("maximum", R::MOST)] {
                let is_whole = bound == bound as i64 as f64;
                if bound.is_finite() {
                    schema
                        .insert(keyword.into(), if is_whole { (bound as i64).into() } else { bound.into() });
                }
            }
            schema
        }
    }
}
