//! Normal deviates by Box and Muller's method: one alone, or many for the values of a scan.
//!
//! Alone, one of the method's two values is taken. Many are made in [`Lanes`] side by side, with both values of each pair,
//! and without branches, so that a compiler can make vectors of the loops: that is worth it for a scan of hundreds of rays,
//! each of which has its noise. They have the bits of the generator and of [`libm`]'s functions one number at a time, on any
//! machine and with vectors of any width.

#![expect(clippy::excessive_precision, reason = "the digits are those of the functions' source")]

use core::f64::consts::{FRAC_PI_2, TAU};

use crate::math;
use crate::trigonometry::sin_cos_near_0;
use crate::vectors::{Work, with_vectors};

/// A normal deviate with mean 0 and standard deviation 1 from two uniform ones in [0, 1): √(−2 ln(1 − u)) cos(2π v).
#[must_use]
pub fn deviate(u: f64, v: f64) -> f64 {
    // 1 - u lies in (0, 1], so the logarithm is finite.
    let radius = math::sqrt(-2.0 * math::ln(1.0 - u));
    radius * math::cos(TAU * v)
}

/// Generators of random bits side by side: Blackman and Vigna's xoshiro256+, each with a state of its own. Its lowest bits,
/// which are not quite random, are not used.
#[derive(Clone, Debug)]
pub struct Lanes([[u64; LANES]; 4]);

impl Lanes {
    /// The number of lanes.
    pub const COUNT: usize = LANES;

    /// The four words of each lane's state. No lane may have zeros only.
    #[must_use]
    pub fn new(words: [[u64; LANES]; 4]) -> Self {
        Self(words)
    }

    /// Changes each value with a normal deviate of its own, which lies within ±8.5.
    pub fn each_normal(self, values: &mut [f64], change: impl Fn(f64, f64) -> f64) {
        with_vectors(Disturb { lanes: self, values, change });
    }

    /// 64 bits of each.
    #[inline(always)]
    fn next(&mut self) -> [u64; LANES] {
        let Self([a, b, c, d]) = self;
        let mut bits = [0; LANES];
        for i in 0..LANES {
            bits[i] = a[i].wrapping_add(d[i]);
            let shifted = b[i] << 17;
            c[i] ^= a[i];
            d[i] ^= b[i];
            b[i] ^= c[i];
            a[i] ^= d[i];
            c[i] ^= shifted;
            d[i] = d[i].rotate_left(45);
        }
        bits
    }

    /// Fills a list, lane after lane and round after round.
    #[inline(always)]
    fn fill(&mut self, into: &mut [[u64; LANES]]) {
        for into in into {
            *into = self.next();
        }
    }
}

struct Disturb<'a, F> {
    lanes: Lanes,
    values: &'a mut [f64],
    change: F,
}

impl<F: Fn(f64, f64) -> f64> Work for Disturb<'_, F> {
    type Output = ();

    #[inline(always)]
    fn work(self) {
        let Self { mut lanes, values, change } = self;
        let (mut lengths, mut angles) = ([[0; LANES]; ROUNDS], [[0; LANES]; ROUNDS]);
        let [mut radii, mut firsts, mut seconds] = [[0.0; PAIRS]; 3];
        for values in values.chunks_mut(2 * PAIRS) {
            // Of each pair the first value is for the first half, the second one for the second half.
            let pairs = values.len().div_ceil(2);
            let rounds = pairs.div_ceil(LANES);
            let (lengths, angles) = (&mut lengths[..rounds], &mut angles[..rounds]);
            lanes.fill(lengths);
            lanes.fill(angles);
            let (lengths, angles) = (lengths.as_flattened(), angles.as_flattened());
            // One loop for each function: shorter ones are better made vectors of.
            for (radius, bits) in radii.iter_mut().zip(lengths) {
                // In (0, 1].
                *radius = -2.0 * ln(2.0 - one_to_two(*bits));
            }
            for (radius, bits) in radii.iter_mut().zip(angles) {
                // A random sign is half a turn.
                *radius = f64::from_bits(math::sqrt(*radius).to_bits() ^ ((bits << 1) & SIGN));
            }
            for (((bits, radius), a), b) in angles.iter().zip(&radii).zip(&mut firsts).zip(&mut seconds) {
                // Within an eighth of a turn of an axis.
                let (sin, cos) = sin_cos_near_0(FRAC_PI_2 * (one_to_two(bits << 2) - 1.5));
                // The sign is a coin between the two.
                let is_other = bits.cast_signed() < 0;
                *a = radius * if is_other { sin } else { cos };
                *b = radius * if is_other { cos } else { sin };
            }
            let (first, second) = values.split_at_mut(pairs);
            for (value, deviate) in first.iter_mut().zip(&firsts) {
                *value = change(*value, *deviate);
            }
            for (value, deviate) in second.iter_mut().zip(&seconds) {
                *value = change(*value, *deviate);
            }
        }
    }
}

/// A number in [1, 2), of the upper 52 of these bits.
#[inline(always)]
fn one_to_two(bits: u64) -> f64 {
    f64::from_bits(0x3ff0_0000_0000_0000 | (bits >> 12))
}
/// The logarithm of a number in [2^-1022, 1], operation for operation as in `libm` (FreeBSD's `e_log.c`).
#[inline(always)]
fn ln(x: f64) -> f64 {
    const LN2_HI: f64 = 6.931_471_803_691_238_164_90e-01;
    const LN2_LO: f64 = 1.908_214_929_270_587_700_02e-10;
    const LG1: f64 = 6.666_666_666_666_735_130e-01;
    const LG2: f64 = 3.999_999_999_940_941_908e-01;
    const LG3: f64 = 2.857_142_874_366_239_149e-01;
    const LG4: f64 = 2.222_219_843_214_978_396e-01;
    const LG5: f64 = 1.818_357_216_161_805_012e-01;
    const LG6: f64 = 1.531_383_769_920_937_332e-01;
    const LG7: f64 = 1.479_819_860_511_658_591e-01;
    /// √½, by the upper half of its bits.
    const SQRT_HALF: u64 = 0x3fe6_a09e;
    let bits = x.to_bits();
    let high = (bits >> 32) + (0x3ff0_0000 - SQRT_HALF);
    // The exponent as a number: it is written into the digits of 2^52, which is then taken away.
    let k = f64::from_bits(0x4330_0000_0000_0000 | (high >> 20)) - (4_503_599_627_370_496.0 + 1023.0);
    let high = (high & 0x000f_ffff) + SQRT_HALF;
    // The rest is in [√½, √2].
    let f = f64::from_bits((high << 32) | (bits & 0xffff_ffff)) - 1.0;
    let half_square = 0.5 * f * f;
    let s = f / (2.0 + f);
    let z = s * s;
    let w = z * z;
    let t1 = w * (LG2 + w * (LG4 + w * LG6));
    let t2 = z * (LG1 + w * (LG3 + w * (LG5 + w * LG7)));
    let r = t2 + t1;
    s * (half_square + r) + k * LN2_LO - half_square + f + k * LN2_HI
}

const SIGN: u64 = 1 << 63;

/// The number of generators.
const LANES: usize = 8;

/// The number of pairs of deviates that are computed at once.
const PAIRS: usize = LANES * ROUNDS;

const ROUNDS: usize = 8;

#[cfg(test)]
mod tests {
    use alloc::vec;
    use alloc::vec::Vec;

    use super::*;

    /// One lane: the generator of its authors.
    struct Lane([u64; 4]);

    impl Lane {
        fn next(&mut self) -> u64 {
            let Self(s) = self;
            let bits = s[0].wrapping_add(s[3]);
            let shifted = s[1] << 17;
            s[2] ^= s[0];
            s[3] ^= s[1];
            s[1] ^= s[2];
            s[0] ^= s[3];
            s[2] ^= shifted;
            s[3] = s[3].rotate_left(45);
            bits
        }
    }

    /// The state of each lane, of words that differ all over.
    fn words(seed: u64) -> [[u64; LANES]; 4] {
        core::array::from_fn(|word| {
            core::array::from_fn(|lane| {
                let mut bits = (seed + (word * LANES + lane) as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
                bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
                bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
                bits ^ (bits >> 31)
            })
        })
    }

    fn many(seed: u64, n: usize) -> Vec<f64> {
        let mut values = vec![0.0; n];
        Lanes::new(words(seed)).each_normal(&mut values, |_, deviate| deviate);
        values
    }

    /// Lane by lane, deviate by deviate, with the functions of `libm`.
    fn one_by_one(seed: u64, n: usize) -> Vec<f64> {
        let words = words(seed);
        let mut lanes: Vec<_> = (0..LANES).map(|i| Lane(words.map(|word| word[i]))).collect();
        let mut values = Vec::new();
        while values.len() < n {
            let left = (n - values.len()).min(2 * PAIRS);
            let pairs = left.div_ceil(2);
            let mut list = || -> Vec<u64> {
                let rounds = pairs.div_ceil(LANES);
                (0..rounds * LANES).map(|i| lanes[i % LANES].next()).collect()
            };
            let (lengths, angles) = (list(), list());
            let unit = |bits: u64| (bits >> 12) as f64 / (1_u64 << 52) as f64;
            let pair = |i: usize| {
                let radius = math::sqrt(-2.0 * math::ln(1.0 - unit(lengths[i])));
                let radius = if angles[i] & (1 << 62) == 0 { radius } else { -radius };
                let (sin, cos) = math::sin_cos(FRAC_PI_2 * (unit(angles[i] << 2) - 0.5));
                if angles[i] < 1 << 63 { (radius * cos, radius * sin) } else { (radius * sin, radius * cos) }
            };
            values.extend((0..pairs).map(|i| pair(i).0));
            values.extend((0..left - pairs).map(|i| pair(i).1));
        }
        values
    }

    #[test]
    fn many_at_once_are_as_they_are_one_by_one() {
        let bits = |values: Vec<f64>| values.into_iter().map(f64::to_bits).collect::<Vec<_>>();
        for n in (0..300).chain([682, 683, 1024, 100_000]) {
            assert_eq!(bits(many(n as u64, n)), bits(one_by_one(n as u64, n)), "{n}");
        }
    }

    #[test]
    fn a_lane_is_the_generator_of_its_authors() {
        // The expected numbers are those of the reference implementation, from the state 1, 2, 3, 4.
        let expected = [
            5,
            211_106_232_532_999,
            211_106_635_186_183,
            9_223_759_065_350_669_058,
            9_250_833_439_874_351_877,
            13_862_484_359_527_728_515,
        ];
        let (mut lane, mut lanes) = (Lane([1, 2, 3, 4]), Lanes::new([1, 2, 3, 4].map(|word| [word; LANES])));
        for expected in expected {
            assert_eq!((lane.next(), lanes.next()), (expected, [expected; LANES]));
        }
    }

    #[test]
    fn logarithms_have_the_bits_of_libm() {
        let steps = (0..53_u32).flat_map(|i| (0..2000).map(move |j| (i, f64::from(j) / 2000.0)));
        for (i, within) in steps {
            let x = (1.0 - 0.5 * within) / (1_u64 << i) as f64;
            assert_eq!(ln(x).to_bits(), math::ln(x).to_bits(), "{x}");
        }
        // Arguments around the one that is halved.
        for i in 0..200_000_u64 {
            let x = f64::from_bits((0x3fe6_a09e_u64 << 32) - 100_000 + i);
            assert_eq!(ln(x).to_bits(), math::ln(x).to_bits(), "{x}");
        }
    }

    #[test]
    fn the_largest_deviate_is_less_than_8_5() {
        let least = 2.0 - one_to_two(u64::MAX);
        let most = math::sqrt(-2.0 * ln(least));
        assert!(least > 0.0 && most < 8.5, "{most}");
        assert_eq!(ln(2.0 - one_to_two(0)), 0.0);
    }
}
