//! The sine and the cosine of [`libm`], with the same bits, as loops can be made vectors of: their branches are turned
//! into choices between numbers (FreeBSD's `s_sin.c`, `s_cos.c`, `e_rem_pio2.c`, `k_sin.c` and `k_cos.c`).

#![expect(clippy::excessive_precision, reason = "the digits are those of the functions' source")]

/// Whether an angle in (-2π, 2π) is so near to a multiple of a quarter turn, but for 0, that its sine and its cosine may
/// take more care: once in 100,000 times.
#[cfg(test)]
fn is_near_axis(angle: f64) -> bool {
    reduced(angle.abs()).is_near_axis
}

/// The sine and the cosine of an angle in (-2π, 2π), and whether it [is near an axis](is_near_axis): then they are not
/// right.
#[inline(always)]
pub(crate) fn sin_cos(angle: f64) -> (f64, f64, bool) {
    let of = reduced(angle.abs());
    let (y0, y1) = (of.y0, of.y1);
    // The remainder is exact below an eighth of a turn, for which the sine has a formula of its own.
    let sin_y = if of.is_one_or_more { sin_near_0(y0, y1) } else { sin_near_0_alone(y0) };
    let cos_y = cos_near_0(y0, y1);
    let (sin, cos) = if of.is_odd { (cos_y, sin_y) } else { (sin_y, cos_y) };
    let sin = if of.is_sin_negative { -sin } else { sin };
    let cos = if of.is_cos_negative { -cos } else { cos };
    (f64::from_bits(sin.to_bits() ^ (angle.to_bits() & SIGN)), cos, of.is_near_axis)
}

/// The sine and the cosine of an angle in [-π/4, π/4], but for -0.0 and what is too near to it for a cube.
#[inline(always)]
pub(crate) fn sin_cos_near_0(angle: f64) -> (f64, f64) {
    (sin_near_0_alone(angle), cos_near_0(angle, 0.0))
}

/// An angle as a number of quarters of a turn, of 0 to 4, and what is left of it.
struct Reduced {
    /// The remainder, in [-π/4, π/4], as a sum.
    y0: f64,
    y1: f64,
    /// The quarters' effect on the sine and the cosine.
    is_one_or_more: bool,
    is_odd: bool,
    is_sin_negative: bool,
    is_cos_negative: bool,
    is_near_axis: bool,
}

/// An angle in [0, 2π), without the quarters that are nearest to it.
#[inline(always)]
fn reduced(angle: f64) -> Reduced {
    /// The first 33 bits of π/2, and what is left of it.
    const PIO2_HI: f64 = 1.570_796_326_734_125_614_17e+00;
    const PIO2_LO: f64 = 6.077_100_506_506_192_249_32e-11;
    // Odd eighths of a turn, by the upper half of their bits: up to and with these it is the quarter before.
    let [one, two, three, four] =
        [0x3fe9_21fb, 0x4002_d97c, 0x400f_6a7a, 0x4015_fdbc].map(|high| angle >= from_high(high + 1));
    let number = |is_beyond: bool| if is_beyond { 1.0 } else { 0.0 };
    let quarter = number(one) + number(two) + number(three) + number(four);
    let rest = angle - quarter * PIO2_HI;
    let lacks = quarter * PIO2_LO;
    let y0 = rest - lacks;
    Reduced {
        y0,
        y1: (rest - y0) - lacks,
        is_one_or_more: one,
        is_odd: one ^ two ^ three ^ four,
        is_sin_negative: two ^ four,
        is_cos_negative: one ^ three,
        is_near_axis: one & (y0.abs() < NEAR_AXIS),
    }
}

/// The least positive number with this as the upper half of its bits.
#[inline(always)]
const fn from_high(high: u64) -> f64 {
    f64::from_bits(high << 32)
}

/// The cosine of x + y, a sum in [-π/4, π/4] with y much smaller than x.
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

/// The sine of x + y, a sum in [-π/4, π/4] with y much smaller than x.
#[inline(always)]
fn sin_near_0(x: f64, y: f64) -> f64 {
    let (z, v, r) = sine_series(x);
    x - ((z * (0.5 * y - v * r) - y) - v * S1)
}

/// The sine of x alone.
#[inline(always)]
fn sin_near_0_alone(x: f64) -> f64 {
    let (z, v, r) = sine_series(x);
    x + v * (S1 + z * r)
}

/// x², x³, and what sines are made of with these.
#[inline(always)]
fn sine_series(x: f64) -> (f64, f64, f64) {
    const S2: f64 = 8.333_333_333_322_489_461_24e-03;
    const S3: f64 = -1.984_126_982_985_794_931_34e-04;
    const S4: f64 = 2.755_731_370_707_006_767_89e-06;
    const S5: f64 = -2.505_076_025_340_686_341_95e-08;
    const S6: f64 = 1.589_690_995_211_550_102_21e-10;
    let z = x * x;
    let w = z * z;
    (z, z * x, S2 + z * (S3 + z * S4) + z * w * (S5 + z * S6))
}

const S1: f64 = -1.666_666_666_666_663_243_48e-01;

const SIGN: u64 = 1 << 63;

/// Nearer to a multiple of a quarter turn, `libm` takes more digits of it: there the angle's upper half is the axis's.
const NEAR_AXIS: f64 = 4e-6;

#[cfg(test)]
mod tests {
    use core::f64::consts::{FRAC_PI_4, TAU};

    use super::*;
    use crate::math;

    #[track_caller]
    fn assert_alike(angle: f64) {
        if angle.abs() < TAU && !is_near_axis(angle) {
            let (sin, cos) = math::sin_cos(angle);
            let bits = |sin: f64, cos: f64| [sin.to_bits(), cos.to_bits()];
            let found = sin_cos(angle);
            assert_eq!(bits(found.0, found.1), bits(sin, cos), "{angle}");
            if angle.abs() <= FRAC_PI_4 && (angle.abs() > 1e-100 || angle.to_bits() == 0) {
                let found = sin_cos_near_0(angle);
                assert_eq!(bits(found.0, found.1), bits(sin, cos), "{angle}");
            }
        }
    }

    #[test]
    fn bits_are_those_of_libm() {
        for i in 0..1_000_000_u64 {
            let spread = (i.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 11) as f64 / (1_u64 << 53) as f64;
            assert_alike((2.0 * spread - 1.0) * TAU);
        }
    }

    #[test]
    fn and_where_the_branches_are() {
        for eighth in 0..=8 {
            let bits = (f64::from(eighth) * TAU / 8.0).to_bits();
            for i in 0..4000_u64 {
                let angle = f64::from_bits(bits.saturating_add(i * i * i).saturating_sub(2000 * 2000 * 2000));
                assert_alike(angle);
                assert_alike(-angle);
            }
        }
        for tiny in [0.0, f64::MIN_POSITIVE, 1e-310, 1e-20, 1e-9, 1.05e-8, 1.06e-8] {
            assert_alike(tiny);
            assert_alike(-tiny);
        }
    }

    #[test]
    fn axes_take_more_care() {
        for quarter in 1..=4 {
            let angle = f64::from(quarter) * TAU / 4.0;
            assert!(is_near_axis(angle) && is_near_axis(-angle) && !is_near_axis(angle - 1e-5));
            // The first and the last number with its upper half, if that is for sure nearer than the next one's.
            let high = angle.to_bits() >> 32;
            assert!(is_near_axis(from_high(high)) && is_near_axis(from_high(high + 1).next_down()));
        }
    }
}
