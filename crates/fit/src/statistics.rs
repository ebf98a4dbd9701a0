//! Densities that several models share.

use libm::erf;

/// The noise on a reading: normal and uniform.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Noise {
    /// Standard deviation of the normal part.
    pub(crate) sigma: f64,
    /// Half the width of the uniform part.
    pub(crate) half_width: f64,
    /// The step of the converter, 0 if it has none.
    pub(crate) step: f64,
}

impl Noise {
    /// The variance, the converter's included.
    pub(crate) fn variance(&self) -> f64 {
        let Self { sigma, half_width, step } = self;
        sigma * sigma + half_width * half_width / 3.0 + step * step / 12.0
    }

    /// −log of the likelihood of a difference from the mean.
    pub(crate) fn cost(&self, difference: f64) -> f64 {
        let likelihood = if self.step > 0.0 {
            let half = 0.5 * self.step;
            (self.distribution(difference + half) - self.distribution(difference - half)) / self.step
        } else if self.half_width > NEGLIGIBLE * self.sigma {
            let (w, s) = (self.half_width, self.sigma.max(1e-12));
            0.5 * (cumulative((difference + w) / s) - cumulative((difference - w) / s)) / w
        } else {
            density(difference / self.sigma) / self.sigma
        };
        -(likelihood + LEAST).ln()
    }

    /// The probability of a smaller difference.
    pub(crate) fn distribution(&self, x: f64) -> f64 {
        let (w, s) = (self.half_width, self.sigma.max(1e-12));
        if w < NEGLIGIBLE * s {
            return cumulative(x / s);
        }
        let part = |x: f64| x * cumulative(x / s) + s * density(x / s);
        ((part(x + w) - part(x - w)) / (2.0 * w)).clamp(0.0, 1.0)
    }
}

/// A uniform part that is narrower than this share of the normal one does not matter.
const NEGLIGIBLE: f64 = 1e-3;

/// A smaller likelihood counts as this one.
const LEAST: f64 = 1e-12;

/// The normal distribution's function.
pub(crate) fn cumulative(x: f64) -> f64 {
    0.5 * (1.0 + erf(x * std::f64::consts::FRAC_1_SQRT_2))
}

fn density(x: f64) -> f64 {
    (-0.5 * x * x).exp() / (2.0 * std::f64::consts::PI).sqrt()
}

/// −log L of differences that are a random walk and white noise, apart from a constant: innovations of a Kalman filter.
pub(crate) struct Walk {
    /// Half the sum of logarithms of the innovations' relative variances.
    log_half: f64,
    /// The sum of squares of innovations over their relative variances.
    squares: f64,
    /// The number of innovations.
    count: usize,
}

impl Walk {
    /// The walk of some differences, segment by segment, by the variances of the walk's steps before each difference and that
    /// of the noise.
    pub(crate) fn new<'a>(segments: impl Iterator<Item = (&'a [f64], &'a [f64])>, noise: f64) -> Self {
        let mut sum = Self { log_half: 0.0, squares: 0.0, count: 0 };
        for (differences, steps) in segments {
            let Some((&first, rest)) = differences.split_first() else { continue };
            // The constant is unknown: the first difference determines it, with the noise's variance.
            let (mut level, mut variance) = (first, noise);
            for (&difference, &step) in rest.iter().zip(&steps[1..]) {
                variance += step;
                let total = variance + noise;
                let innovation = difference - level;
                sum.log_half += 0.5 * total.ln();
                sum.squares += innovation * innovation / total;
                sum.count += 1;
                let gain = variance / total;
                level += gain * innovation;
                variance *= 1.0 - gain;
            }
        }
        sum
    }

    /// −log L if the variances are as given.
    pub(crate) fn cost(&self) -> f64 {
        self.log_half + 0.5 * self.squares
    }

    /// −log L at the most likely scale of the variances.
    pub(crate) fn scaled_cost(&self) -> f64 {
        let n = self.count as f64;
        self.log_half + 0.5 * n * ((self.squares / n).max(1e-300)).ln()
    }
}

/// −log L of differences that are correlated with those before them, at the most likely size and correlation.
pub(crate) fn autoregressive<'a>(segments: impl Iterator<Item = &'a [f64]>) -> f64 {
    let (mut own, mut next, mut product, mut count) = (0.0, 0.0, 0.0, 0.0);
    for differences in segments {
        for pair in differences.windows(2) {
            own += pair[0] * pair[0];
            next += pair[1] * pair[1];
            product += pair[0] * pair[1];
            count += 1.0;
        }
    }
    let correlation = if own > 0.0 { (product / own).clamp(0.0, 0.999) } else { 0.0 };
    let squares = next - 2.0 * correlation * product + correlation * correlation * own;
    0.5 * count * ((squares / count).max(LEAST_VARIANCE)).ln()
}

/// Speeds agree no better than to a nanometre a second.
const LEAST_VARIANCE: f64 = 1e-18;

/// Angles made continuous: neighbours differ by less than half a turn.
pub(crate) fn unwrapped(angles: &[f64]) -> Vec<f64> {
    let mut turns = 0.0;
    let mut last = angles.first().copied().unwrap_or_default();
    let step = |angle: &f64| {
        turns -= ((angle - last) / std::f64::consts::TAU).round();
        last = *angle;
        angle + turns * std::f64::consts::TAU
    };
    angles.iter().map(step).collect()
}

/// The greatest common step of some stamps, in their unit: the largest round number, of 1 / 10 / 100 and the parts of it that
/// clocks have, of which all are multiples. Stamps that are multiples of nothing have that of their floating point.
pub(crate) fn common_step(stamps: &[f64]) -> f64 {
    let stride = stamps.len().div_ceil(MOST_STAMPS).max(1);
    let first = stamps.first().copied().unwrap_or_default();
    let ways: Vec<f64> = stamps.iter().step_by(stride).map(|stamp| stamp - first).collect();
    let rounding = 4.0 * f64::EPSILON * stamps.iter().fold(0.0, |most: f64, stamp| most.max(stamp.abs()));
    let divides = |step: f64| {
        let off = |way: &f64| (way - (way / step).round() * step).abs();
        ways.iter().all(|way| off(way) < (1e-3 * step).max(rounding))
    };
    for power in 0..9 {
        for part in PARTS {
            let step = part * 0.1 / 10.0_f64.powi(power);
            if step < 20.0 * rounding {
                return rounding;
            }
            if divides(step) {
                return step;
            }
        }
    }
    rounding
}

const MOST_STAMPS: usize = 4000;

/// Of microcontrollers and operating systems: 4 and 8 us of timers, 15.625 ms of a tick in 64 of a second.
const PARTS: [f64; 8] = [1.0, 0.8, 0.5, 0.4, 0.25, 0.2, 0.15625, 0.125];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_of_stamps_are_found() {
        for (step, epoch) in
            [(1e-3, 0.0), (1e-6, 0.0), (4e-6, 0.0), (15.625e-3, 0.0), (1e-3, 1.7e9), (1e-4, 1.7e9)]
        {
            let stamps: Vec<f64> = (0..500).map(|i| epoch + f64::from(i * i % 7919) * step).collect();
            let found = common_step(&stamps);
            assert!((found / step - 1.0).abs() < 1e-9, "{step} {epoch}: {found}");
        }
        let any: Vec<f64> = (0..500).map(|i| f64::from(i).sqrt()).collect();
        assert!(common_step(&any) < 1e-9);
    }

    #[test]
    fn densities_integrate_to_1() {
        for (sigma, half_width, step) in
            [(0.1, 0.0, 0.0), (0.1, 0.3, 0.0), (0.01, 0.3, 0.0), (0.1, 0.3, 0.05), (0.01, 0.0, 0.05)]
        {
            let noise = Noise { sigma, half_width, step };
            let d = if step > 0.0 { step } else { 1e-3 };
            let sum: f64 = (-2000..2000).map(|i| (-noise.cost(f64::from(i) * d)).exp() * d).sum();
            assert!((sum - 1.0).abs() < 1e-3, "{noise:?}: {sum}");
        }
    }
}
