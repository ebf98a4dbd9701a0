//! Normal deviates by Box and Muller's method, of whose two values one is taken: alone, and many at once.
//!
//! Many at once have the bits that they have alone, which are those of [`libm`]'s logarithm and cosine. The branches of
//! these are turned into choices between numbers, so that a compiler can make vectors of the loop: that is worth it for
//! a scan of hundreds of rays, each of which has its noise.

#![expect(clippy::excessive_precision, reason = "the digits are those of the functions' source")]

use core::f64::consts::TAU;

use crate::math;
use crate::trigonometry::{cos, is_near_axis};
use crate::vectors::{Work, with_vectors};

/// From two uniform deviates in [0, 1) a normal one with mean 0 and standard deviation 1: √(−2 ln(1 − u)) cos(2π v).
#[must_use]
pub fn deviate(u: f64, v: f64) -> f64 {
    // 1 - u lies in (0, 1], so the logarithm is finite.
    let radius = math::sqrt(-2.0 * math::ln(1.0 - u));
    radius * math::cos(TAU * v)
}

/// [`deviate`] of each pair of two lists, into a third one.
///
/// # Panics
///
/// If the lists have different lengths.
pub fn deviates(us: &[f64], vs: &[f64], into: &mut [f64]) {
    assert!(us.len() == into.len() && vs.len() == into.len(), "deviates come from pairs");
    let any_is_special = with_vectors(Fill { us, vs, into: &mut *into });
    if any_is_special {
        let pairs = us.iter().zip(vs).zip(into);
        let special = pairs.filter(|((_, v), _)| is_near_axis(TAU * *v));
        special.for_each(|((&u, &v), into)| *into = deviate(u, v));
    }
}

/// [`deviates`] but for angles near an axis.
struct Fill<'a> {
    us: &'a [f64],
    vs: &'a [f64],
    into: &'a mut [f64],
}

impl Work for Fill<'_> {
    /// Whether there are any of these.
    type Output = bool;

    #[inline(always)]
    fn work(self) -> bool {
        let Self { us, vs, into } = self;
        let mut any_is_special = false;
        // One loop for each function: shorter ones are better made vectors of.
        for (u, into) in us.iter().zip(into.iter_mut()) {
            *into = -2.0 * ln(1.0 - u);
        }
        for into in into.iter_mut() {
            *into = math::sqrt(*into);
        }
        for (v, into) in vs.iter().zip(into.iter_mut()) {
            let (cos, is_near_axis) = cos(TAU * v);
            any_is_special |= is_near_axis;
            *into *= cos;
        }
        any_is_special
    }
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

#[cfg(test)]
mod tests {
    use alloc::vec;
    use alloc::vec::Vec;
    use core::f64::consts::FRAC_1_SQRT_2;

    use super::*;

    #[track_caller]
    fn assert_alike(us: &[f64], vs: &[f64]) {
        let mut found = vec![0.0; us.len()];
        deviates(us, vs, &mut found);
        for ((&u, &v), found) in us.iter().zip(vs).zip(found) {
            assert_eq!(found.to_bits(), deviate(u, v).to_bits(), "{u} {v}");
        }
    }

    /// 53 bits that differ all over from one number to the next.
    fn uniform(i: u64) -> f64 {
        let mut bits = i.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        bits = (bits ^ (bits >> 31)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        ((bits ^ (bits >> 29)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    #[test]
    fn many_at_once_are_as_they_are_alone() {
        for part in 0..200_u64 {
            let us: Vec<_> = (0..5000).map(|i| uniform(10_000 * part + i)).collect();
            let vs: Vec<_> = (0..5000).map(|i| uniform(10_000 * part + i + 5000)).collect();
            assert_alike(&us, &vs);
        }
    }

    #[test]
    fn and_where_the_branches_are() {
        let smallest = 1.0 / (1_u64 << 53) as f64;
        let around = |angle: f64| {
            let bits = (angle / TAU).to_bits();
            (0..4000_u64).map(move |i| f64::from_bits(bits + i * i * i - 2000 * 2000 * 2000))
        };
        let eighths = (1..8).flat_map(|i| around(f64::from(i) * TAU / 8.0));
        let steps = (0..2000).map(|i| f64::from(i) * smallest);
        let vs: Vec<_> =
            eighths.chain(steps.clone()).chain(steps.map(|step| 1.0 - smallest - step)).collect();
        let us: Vec<_> = vs.iter().rev().copied().collect();
        assert!(vs.iter().any(|v| is_near_axis(TAU * v)));
        assert_alike(&us, &vs);
        // Powers of two, and where the logarithm's argument is halved.
        let us: Vec<_> = (1..=53)
            .flat_map(|i| {
                [1.0, FRAC_1_SQRT_2 * (1.0 - 1e-7), FRAC_1_SQRT_2 * (1.0 + 1e-7), 1.5]
                    .map(|f| 1.0 - f / (1_u64 << i) as f64)
            })
            .collect();
        assert_alike(&us, &vs[..us.len()]);
    }
}
