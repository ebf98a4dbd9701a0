//! The encoding of one number on the wire.
//!
//! A microcontroller has no real numbers: its converter gives a level, its counter register wraps, its motor driver
//! takes a signed step. An [`Encoding`] says which of these a value is, and so how many bytes it costs and how much
//! of it is lost. All codes are sent least significant byte first.
//!
//! | encoding | bytes | code | value of a code |
//! |---|---|---|---|
//! | `Float64` | 8 | IEEE 754 binary64 | itself |
//! | `Level` | ⌈bits/8⌉ | 0 ..= 2^bits − 1 | min + code (max − min) / (2^bits − 1) |
//! | `Signed` | ⌈bits/8⌉ | ±(2^(bits−1) − 1) | code · limit / (2^(bits−1) − 1) |
//! | `Counter` | ⌈bits/8⌉ | integer modulo 2^bits | −2^(bits−1) ..= 2^(bits−1) − 1 |
//!
//! Signed codes narrower than their bytes are sign-extended into the unused bits, so that a program can read 12 bits
//! as an `int16_t`; a reader ignores those bits.

use serde::{Deserialize, Serialize};

use crate::error::LayoutError;

/// The encoding of one number on the wire.
///
/// Every method is total: a number of bits outside the permitted range counts as the nearest permitted one
/// ([`check`](Self::check) reports it). NaN becomes the code 0 of the integer encodings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Encoding {
    /// The number as it is, in 8 bytes. The only encoding that can carry NaN and the infinities.
    Float64,
    /// An analogue-to-digital converter: [min, max] in 2^bits levels, saturating at both ends. Level 0 is `min`,
    /// which may be above `max` for a converter that is wired the other way round.
    Level {
        /// Resolution, 1 to 32 bits.
        bits: u8,
        /// The value of level 0, in the unit of the sensor.
        min: f64,
        /// The value of the highest level, in the unit of the sensor.
        max: f64,
    },
    /// A signed command, saturating at ±limit. Unlike a `Level` from −limit to limit, whose number of levels is even,
    /// it has an exact zero: a command can stop a motor.
    Signed {
        /// Resolution, 2 to 32 bits, the sign included.
        bits: u8,
        /// The largest magnitude, in the unit of the signal.
        limit: f64,
    },
    /// A counter register: an integer that wraps modulo 2^bits. A fraction is cut off, as only whole counts occur.
    Counter {
        /// Width of the register, 8 to 32 bits.
        bits: u8,
    },
}

impl Encoding {
    /// Bytes on the wire, 1 to 8.
    #[expect(clippy::len_without_is_empty, reason = "an encoding is never empty")]
    pub const fn len(self) -> usize {
        match self {
            Self::Float64 => 8,
            Self::Level { .. } | Self::Signed { .. } | Self::Counter { .. } => {
                self.bits().div_ceil(8) as usize
            }
        }
    }

    /// Writes `value` to the front of `out` and returns the number of bytes written: [`len`](Self::len), or 0 if
    /// `out` is too short, which is left as it was then.
    pub fn put(self, value: f64, out: &mut [u8]) -> usize {
        let len = self.len();
        let bytes = match self {
            Self::Float64 => value.to_bits(),
            Self::Level { .. } | Self::Signed { .. } | Self::Counter { .. } => self.code(value),
        }
        .to_le_bytes();
        let Some(out) = out.get_mut(..len) else { return 0 };
        for (to, from) in out.iter_mut().zip(bytes) {
            *to = from;
        }
        len
    }

    /// The value at the front of `bytes`, or `None` if they are too few.
    ///
    /// `Float64` may give NaN or an infinity, as the other side sent it; the other encodings cannot, if they pass
    /// [`check`](Self::check).
    pub fn take(self, bytes: &[u8]) -> Option<f64> {
        let bytes = bytes.get(..self.len())?;
        let word = bytes.iter().rev().fold(0, |word, byte| word << 8 | u64::from(*byte));
        Some(match self {
            Self::Float64 => f64::from_bits(word),
            Self::Level { .. } => self.value(word.min(self.top()) as i64),
            // The code below −top is never sent by `put`; if it comes, it means −limit.
            Self::Signed { .. } => self.value(sign_extend(word, self.bits()).max(-(self.top() as i64))),
            Self::Counter { .. } => self.value(sign_extend(word, self.bits())),
        })
    }

    /// The least and the greatest code as numbers in a text: those of `Signed` and `Counter` with their sign. `None` of
    /// `Float64`, which has none.
    pub const fn numbers(self) -> Option<[i64; 2]> {
        let top = self.top() as i64;
        match self {
            Self::Float64 => None,
            Self::Level { .. } => Some([0, top]),
            Self::Signed { .. } => Some([-top, top]),
            Self::Counter { .. } => {
                let half = 1 << (self.bits() - 1);
                Some([-half, half - 1])
            }
        }
    }

    /// The code that stands for `value`, as a number in a text; `None` of `Float64`.
    pub fn number(self, value: f64) -> Option<i64> {
        match self {
            Self::Float64 => None,
            Self::Level { .. } | Self::Signed { .. } | Self::Counter { .. } => Some(self.code(value) as i64),
        }
    }

    /// The value of a code given as a number in a text; `None` if the encoding has no such code.
    pub fn value_of(self, number: i64) -> Option<f64> {
        let [least, greatest] = self.numbers()?;
        (least..=greatest).contains(&number).then(|| self.value(number))
    }

    /// The value that the other side decodes for `value`: `take` after `put`.
    #[inline]
    pub fn quantise(self, value: f64) -> f64 {
        // Of the numbers that are sent as they are there are many, in scans: these are not worth a call each.
        if matches!(self, Self::Float64) { value } else { self.nearest(value) }
    }

    /// [`quantise`](Self::quantise) of what is not sent as it is.
    fn nearest(self, value: f64) -> f64 {
        match self {
            Self::Float64 => value,
            Self::Level { .. } => self.value(self.code(value) as i64),
            Self::Signed { .. } | Self::Counter { .. } => {
                self.value(sign_extend(self.code(value), self.bits()))
            }
        }
    }

    /// The difference between neighbouring values, in the unit of the value; 0 for `Float64`.
    pub fn step(self) -> f64 {
        match self {
            Self::Float64 => 0.0,
            Self::Level { min, max, .. } => (max - min).abs() / self.top() as f64,
            Self::Signed { limit, .. } => limit.abs() / self.top() as f64,
            Self::Counter { .. } => 1.0,
        }
    }

    /// Whether the parameters are within the permitted ranges. Owners check once, when they are configured.
    ///
    /// # Errors
    /// Names the first parameter that is not.
    pub fn check(self) -> Result<(), LayoutError> {
        if let Self::Level { bits, .. } | Self::Signed { bits, .. } | Self::Counter { bits } = self
            && bits != self.bits()
        {
            return Err(LayoutError::Bits { nearest: self.bits(), found: bits });
        }
        match self {
            Self::Level { min, max, .. } if !((max - min) * self.top() as f64).is_finite() || min == max => {
                Err(LayoutError::Range { min, max })
            }
            Self::Signed { limit, .. } if !(limit * self.top() as f64).is_finite() || limit <= 0.0 => {
                Err(LayoutError::Range { min: -limit, max: limit })
            }
            Self::Float64 | Self::Level { .. } | Self::Signed { .. } | Self::Counter { .. } => Ok(()),
        }
    }

    /// The value of a code; 0 of `Float64`.
    fn value(self, number: i64) -> f64 {
        let (number, top) = (number as f64, self.top() as f64);
        match self {
            Self::Float64 => 0.0,
            Self::Level { min, max, .. } => min + number * (max - min) / top,
            Self::Signed { limit, .. } => number * limit / top,
            Self::Counter { .. } => number,
        }
    }

    /// The number of bits, as near to the given one as is permitted.
    const fn bits(self) -> u8 {
        let (bits, least) = match self {
            Self::Float64 => return 64,
            Self::Level { bits, .. } => (bits, 1),
            Self::Signed { bits, .. } => (bits, 2),
            Self::Counter { bits } => (bits, 8),
        };
        if bits < least {
            least
        } else if bits > 32 {
            32
        } else {
            bits
        }
    }

    /// The highest code of the codes that stand for a range.
    const fn top(self) -> u64 {
        match self {
            Self::Signed { .. } => (1 << (self.bits() - 1)) - 1,
            Self::Level { .. } => (1 << self.bits()) - 1,
            Self::Float64 | Self::Counter { .. } => 0,
        }
    }

    /// The integer that stands for `value`; only its low [`len`](Self::len) bytes are sent.
    fn code(self, value: f64) -> u64 {
        match self {
            Self::Float64 => 0,
            Self::Level { min, max, .. } => {
                let top = self.top() as f64;
                round((value - min) / (max - min) * top).clamp(0, self.top() as i64) as u64
            }
            Self::Signed { limit, .. } => {
                let top = self.top() as i64;
                round(value / limit * top as f64).clamp(-top, top) as u64
            }
            Self::Counter { .. } => sign_extend(value as i64 as u64, self.bits()) as u64,
        }
    }
}

/// The nearest integer, halves away from zero; NaN gives 0, and what is too big the biggest. Core has no
/// `f64::round`, and adding a half before cutting off rounds the number just below a half up.
pub(crate) fn round(value: f64) -> i64 {
    let whole = value as i64;
    let fraction = value - whole as f64;
    if fraction >= 0.5 {
        whole.saturating_add(1)
    } else if fraction <= -0.5 {
        whole.saturating_sub(1)
    } else {
        whole
    }
}

/// The low `bits` of `word` (1 to 64 of them) as a two's-complement number.
fn sign_extend(word: u64, bits: u8) -> i64 {
    let unused = 64 - u32::from(bits.clamp(1, 64));
    (word << unused) as i64 >> unused
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn level() -> impl Strategy<Value = Encoding> {
        (1..=32u8, -1e3..1e3, 0.1..1e3).prop_map(|(bits, min, span)| Encoding::Level {
            bits,
            min,
            max: min + span,
        })
    }

    fn signed() -> impl Strategy<Value = Encoding> {
        (2..=32u8, 0.1..1e3).prop_map(|(bits, limit)| Encoding::Signed { bits, limit })
    }

    fn any_encoding() -> impl Strategy<Value = Encoding> {
        prop_oneof![
            Just(Encoding::Float64),
            (any::<u8>(), any::<f64>(), any::<f64>()).prop_map(|(bits, min, max)| Encoding::Level {
                bits,
                min,
                max
            }),
            (any::<u8>(), any::<f64>()).prop_map(|(bits, limit)| Encoding::Signed { bits, limit }),
            any::<u8>().prop_map(|bits| Encoding::Counter { bits }),
        ]
    }

    #[test]
    fn a_text_has_the_codes_of_its_encoding_and_no_others() {
        assert_eq!(Encoding::Counter { bits: 8 }.numbers(), Some([-128, 127]));
        assert_eq!(Encoding::Counter { bits: 32 }.numbers(), Some([-(1 << 31), (1 << 31) - 1]));
        assert_eq!(Encoding::Signed { bits: 8, limit: 1.0 }.numbers(), Some([-127, 127]));
        assert_eq!(Encoding::Counter { bits: 8 }.value_of(128), None);
    }

    proptest! {
        #[test]
        fn every_value_crosses_in_len_bytes(encoding in any_encoding(), value in any::<f64>()) {
            let mut bytes = [0; 8];
            prop_assert_eq!(encoding.put(value, &mut bytes), encoding.len());
            prop_assert!(encoding.take(&bytes[..encoding.len()]).is_some());
            prop_assert!(encoding.take(&bytes[..encoding.len() - 1]).is_none());
            let mut short = [7; 7];
            let short = &mut short[..encoding.len() - 1];
            prop_assert_eq!(encoding.put(value, short), 0);
            prop_assert!(short.iter().all(|&byte| byte == 7));
        }

        #[test]
        fn float64_loses_nothing(value in any::<f64>()) {
            prop_assert_eq!(Encoding::Float64.quantise(value).to_bits(), value.to_bits());
        }

        #[test]
        fn inside_the_range_the_error_is_at_most_half_a_step(
            encoding in prop_oneof![level(), signed()], part in 0.0..=1.0,
        ) {
            let (min, max) = range(encoding);
            let value = min + part * (max - min);
            let error = (encoding.quantise(value) - value).abs();
            prop_assert!(error <= encoding.step() / 2.0 + 1e-12 * (max.abs() + min.abs()), "{error}");
        }

        #[test]
        fn outside_the_range_the_value_saturates(
            encoding in prop_oneof![level(), signed()], excess in 0.0..f64::MAX,
        ) {
            let (min, max) = range(encoding);
            let tolerance = 1e-12 * (max.abs() + min.abs());
            prop_assert!((encoding.quantise(max + excess) - max).abs() <= tolerance);
            prop_assert!((encoding.quantise(min - excess) - min).abs() <= tolerance);
        }

        #[test]
        fn a_quantised_value_is_kept(encoding in prop_oneof![level(), signed()], part in 0.0..=1.0) {
            let (min, max) = range(encoding);
            let once = encoding.quantise(min + part * (max - min));
            prop_assert_eq!(encoding.quantise(once), once);
        }

        #[test]
        fn a_counter_wraps(bits in 8..=32u8, count in any::<i32>(), turns in -5..5i64) {
            let encoding = Encoding::Counter { bits };
            let modulus = 1i64 << bits;
            let value = encoding.quantise((i64::from(count) + turns * modulus) as f64);
            prop_assert_eq!((value as i64 - i64::from(count)).rem_euclid(modulus), 0);
            prop_assert!((-modulus / 2..modulus / 2).contains(&(value as i64)));
        }

        #[test]
        fn differences_of_a_counter_survive_the_wrap(start in any::<i32>(), moved in -100..100i64) {
            let encoding = Encoding::Counter { bits: 8 };
            let before = encoding.quantise(f64::from(start));
            let after = encoding.quantise((i64::from(start) + moved) as f64);
            prop_assert_eq!(encoding.quantise(after - before), moved as f64);
        }

        #[test]
        fn a_number_in_a_text_means_what_its_bytes_mean(encoding in any_encoding(), value in any::<f64>()) {
            match encoding.number(value) {
                None => prop_assert_eq!(encoding, Encoding::Float64),
                Some(number) => {
                    let (read, taken) = (encoding.value_of(number).unwrap(), encoding.quantise(value));
                    prop_assert!(read == taken || (read.is_nan() && taken.is_nan()), "{read} {taken}");
                }
            }
        }

        #[test]
        fn a_number_that_no_code_is_has_no_value(encoding in any_encoding(), beyond in 1..i64::MAX / 2) {
            if let Some([least, greatest]) = encoding.numbers() {
                prop_assert_eq!(encoding.value_of(greatest + beyond), None);
                prop_assert_eq!(encoding.value_of(least - beyond), None);
                prop_assert!(encoding.value_of(least).is_some() && encoding.value_of(greatest).is_some());
            }
        }

        #[test]
        fn signed_zero_is_exact(bits in any::<u8>(), limit in 1e-3..1e6) {
            prop_assert_eq!(Encoding::Signed { bits, limit }.quantise(0.0), 0.0);
        }

        #[test]
        fn any_bytes_give_a_value_in_range(encoding in prop_oneof![level(), signed()], bytes: [u8; 4]) {
            let (min, max) = range(encoding);
            let value = encoding.take(&bytes).unwrap();
            let tolerance = 1e-12 * (max.abs() + min.abs());
            prop_assert!(min - tolerance <= value && value <= max + tolerance);
        }

        #[test]
        fn a_reversed_converter_mirrors(bits in 1..=16u8, part in 0.0..=1.0) {
            let forth = Encoding::Level { bits, min: 0.0, max: 1.0 }.quantise(part);
            let back = Encoding::Level { bits, min: 1.0, max: 0.0 }.quantise(part);
            // A tie goes up in one and down in the other.
            let step = Encoding::Level { bits, min: 0.0, max: 1.0 }.step();
            prop_assert!((forth - back).abs() <= step + 1e-12);
        }
    }

    #[test]
    fn the_ends_of_a_level_are_exact() {
        let byte = Encoding::Level { bits: 8, min: 0.0, max: 5.0 };
        assert_eq!((byte.quantise(0.0), byte.quantise(5.0)), (0.0, 5.0));
        assert_eq!(byte.step(), 5.0 / 255.0);
    }

    #[test]
    fn not_a_number_becomes_code_0() {
        assert_eq!(Encoding::Level { bits: 10, min: -2.0, max: 2.0 }.quantise(f64::NAN), -2.0);
        assert_eq!(Encoding::Signed { bits: 8, limit: 1.0 }.quantise(f64::NAN), 0.0);
        assert_eq!(Encoding::Counter { bits: 16 }.quantise(f64::NAN), 0.0);
    }

    #[test]
    fn narrow_signed_codes_fill_their_bytes_with_the_sign() {
        let mut bytes = [0; 2];
        Encoding::Signed { bits: 12, limit: 2047.0 }.put(-2.0, &mut bytes);
        assert_eq!(i16::from_le_bytes(bytes), -2);
        Encoding::Counter { bits: 12 }.put(-2.0, &mut bytes);
        assert_eq!(i16::from_le_bytes(bytes), -2);
    }

    #[test]
    fn the_lowest_signed_code_means_minus_limit() {
        assert_eq!(Encoding::Signed { bits: 8, limit: 1.0 }.take(&[0x80]), Some(-1.0));
    }

    #[test]
    fn halves_go_away_from_zero_and_nothing_below_a_half_goes_up() {
        assert_eq!((round(0.5), round(-0.5), round(1.49)), (1, -1, 1));
        assert_eq!(round(0.499_999_999_999_999_94), 0);
        assert_eq!((round(f64::INFINITY), round(f64::NEG_INFINITY)), (i64::MAX, i64::MIN));
    }

    #[test]
    fn bad_parameters_are_named() {
        assert_eq!(Encoding::Counter { bits: 16 }.check(), Ok(()));
        assert_eq!(Encoding::Counter { bits: 7 }.check(), Err(LayoutError::Bits { nearest: 8, found: 7 }));
        assert_eq!(
            Encoding::Level { bits: 8, min: 1.0, max: 1.0 }.check(),
            Err(LayoutError::Range { min: 1.0, max: 1.0 })
        );
        assert!(Encoding::Signed { bits: 8, limit: f64::NAN }.check().is_err());
    }

    fn range(encoding: Encoding) -> (f64, f64) {
        match encoding {
            Encoding::Level { min, max, .. } => (min, max),
            Encoding::Signed { limit, .. } => (-limit, limit),
            Encoding::Float64 | Encoding::Counter { .. } => unreachable!("only ranges are drawn"),
        }
    }
}
