//! Normal deviates by Box and Muller's method, of whose two values one is taken: alone, and many at once.
//!
//! Many at once have the bits that they have alone, which are those of [`libm`]'s logarithm and cosine. The branches of
//! these are turned into choices between numbers, so that a compiler can make vectors of the loop: that is worth it for
//! a scan of hundreds of rays, each of which has its noise.

#![expect(clippy::excessive_precision, reason = "the digits are those of the functions' source")]

use core::f64::consts::TAU;

use crate::math;
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
            let angle = TAU * v;
            any_is_special |= is_near_axis(angle);
            *into *= cos(angle);
        }
        any_is_special
    }
}

/// Whether an angle is so near to a multiple of a quarter turn that its cosine takes more care: once in 200,000 times.
#[inline(always)]
fn is_near_axis(angle: f64) -> bool {
    let is_in = |high: u64| (angle >= from_high(high)) & (angle < from_high(high + 1));
    is_in(0x3ff9_21fb) | is_in(0x4009_21fb) | is_in(0x4012_d97c) | is_in(0x4019_21fb)
}

/// The least positive number with this as the upper half of its bits.
#[inline(always)]
const fn from_high(high: u64) -> f64 {
    f64::from_bits(high << 32)
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

/// The cosine of an angle in [0, 2π) that is not near an axis, operation for operation as in `libm` (FreeBSD's
/// `s_cos.c`, `e_rem_pio2.c`, `k_cos.c`, `k_sin.c`).
#[inline(always)]
fn cos(angle: f64) -> f64 {
    /// The first 33 bits of π/2, and what is left of it.
    const PIO2_HI: f64 = 1.570_796_326_734_125_614_17e+00;
    const PIO2_LO: f64 = 6.077_100_506_506_192_249_32e-11;
    // Odd eighths of a turn, by the upper half of their bits: up to and with these it is the quarter before.
    let is_beyond = |high: u64| if angle >= from_high(high + 1) { 1.0 } else { 0.0 };
    let quarter =
        is_beyond(0x3fe9_21fb) + is_beyond(0x4002_d97c) + is_beyond(0x400f_6a7a) + is_beyond(0x4015_fdbc);
    let rest = angle - quarter * PIO2_HI;
    let (y0, y1) = {
        let lacks = quarter * PIO2_LO;
        let y0 = rest - lacks;
        (y0, (rest - y0) - lacks)
    };
    let is_odd = (quarter == 1.0) | (quarter == 3.0);
    let is_negative = (quarter == 1.0) | (quarter == 2.0);
    let value = if is_odd { sin_near_0(y0, y1) } else { cos_near_0(y0, y1) };
    if is_negative { -value } else { value }
}

/// Of x + y, the cosine: in [-π/4, π/4], and y much smaller than x.
#[inline(always)]
fn cos_near_0(x: f64, y: f64) -> f64 {
    const C1: f64 = 4.166_666_666_666_660_190_37e-02;
    const C2: f64 = -1.388_888_888_887_410_957_49e-03;
    const C3: f64 = 2.480_158_728_947_672_941_78e-05;
    const C4: f64 = -2.755_731_435_139_066_330_35e-07;
    const C5: f64 = 2.087_572_321_298_174_827_90e-09;
    const C6: f64 = -1.135_964_755_778_819_482_65e-11;
    let z = x * x;
    let w = z * z;
    let r = z * (C1 + z * (C2 + z * C3)) + w * w * (C4 + z * (C5 + z * C6));
    let half = 0.5 * z;
    let w = 1.0 - half;
    w + (((1.0 - w) - half) + (z * r - x * y))
}

/// Of x + y, the sine: in [-π/4, π/4], and y much smaller than x.
#[inline(always)]
fn sin_near_0(x: f64, y: f64) -> f64 {
    const S1: f64 = -1.666_666_666_666_663_243_48e-01;
    const S2: f64 = 8.333_333_333_322_489_461_24e-03;
    const S3: f64 = -1.984_126_982_985_794_931_34e-04;
    const S4: f64 = 2.755_731_370_707_006_767_89e-06;
    const S5: f64 = -2.505_076_025_340_686_341_95e-08;
    const S6: f64 = 1.589_690_995_211_550_102_21e-10;
    let z = x * x;
    let w = z * z;
    let r = S2 + z * (S3 + z * S4) + z * w * (S5 + z * S6);
    let v = z * x;
    x - ((z * (0.5 * y - v * r) - y) - v * S1)
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
