//! The curve of an IR sensor by its formula, its noise, and the spread of its specimens.
//!
//! The value expected at the distance d is (3.12) of Wahde 2016 with (3.13) for each ray: the mean over the rays of
//! min(1, cos κ (c₁ cos² κ / d² + c₂)), and 0 of a ray that meets the wall beyond the range. A specimen makes of it
//! (S g + o) N(1, σₘ) + N(0, σₐ) + U(±w), rounded to the converter's steps.
//!
//! Rows at distances at which any value is at the end of the converter's range are left out: what a limit cut off tells
//! little, and would have to be integrated over.

use super::super::specimens::{Spread, specimen};
use super::super::{Case, chosen, merged};
use super::{LEAST_SPECIMENS, Rows};
use crate::estimate::{Fitted, Outcome, Reason, found};
use crate::fields::SensorField;
use crate::search::{EDGES, Search, Unknown};
use crate::statistics::Noise;

/// The numbers that a curve has, in the order of the search.
const FIELDS: [SensorField; 7] = [
    SensorField::C1,
    SensorField::C2,
    SensorField::Multiplicative,
    SensorField::Additive,
    SensorField::Uniform,
    SensorField::GainSpread,
    SensorField::OffsetSpread,
];

impl Rows<'_> {
    /// The value that is expected at each distance.
    fn expected(&self, c1_m2: f64, c2: f64) -> Vec<f64> {
        let (fan, range_m) = (self.ranger.fan(), self.ranger.range_m());
        let at = |distance_m: f64| {
            let ray = |i: usize| {
                let cos = fan.cos_kappa(i);
                let d = distance_m / cos;
                if cos <= 0.0 || d >= range_m { 0.0 } else { (cos * (c1_m2 / (d * d) + c2)).min(1.0) }
            };
            (0..fan.len()).map(ray).sum::<f64>() / fan.len() as f64
        };
        self.distances_m.iter().map(|distance| at(*distance)).collect()
    }

    /// −log L of the numbers in the order of [`FIELDS`].
    fn cost(&self, numbers: [f64; 7]) -> f64 {
        let [c1_m2, c2, multiplicative, additive, half_width, gain, offset] = numbers;
        let expected = self.expected(c1_m2, c2);
        // Edges that are a little blurred can be found.
        let blur = (0.3 * self.step).max(0.02 * half_width).max(1e-9);
        let noise = |mean: f64| Noise {
            sigma: ((multiplicative * mean).powi(2) + additive * additive).sqrt().max(blur),
            half_width,
            step: self.step,
        };
        let weights: Vec<f64> = expected.iter().map(|mean| 1.0 / noise(*mean).variance()).collect();
        let spread = Spread { gain, offset };
        let of_specimen = |rows: &Vec<(usize, f64)>| {
            let known = rows.iter().map(|(at, value)| (expected[*at], value - expected[*at], weights[*at]));
            let specimen = specimen(known, spread);
            let each = rows.iter().map(|(at, value)| {
                let mean = expected[*at] * (1.0 + specimen.gain) + specimen.offset;
                noise(mean).cost(value - mean)
            });
            each.sum::<f64>() + specimen.cost
        };
        self.specimens.iter().map(of_specimen).sum()
    }

    /// Fits the numbers of the formula, whose values in the scenario are `c1_m2` and `c2`.
    pub(super) fn fit_formula(&self, case: &Case<'_>, c1_m2: f64, c2: f64) -> Result<Fitted, Reason> {
        let fixed = self.preset(c1_m2, c2);
        let free = self.free(case, &fixed);
        let all = |values: &[f64]| merged(fixed, &free, values);
        let cost = |values: &[f64]| self.cost(all(values));
        // The curve itself moves the edges of the uniform noise if there is no normal noise.
        let has_edges = free.contains(&4)
            && !free.contains(&2)
            && !free.contains(&3)
            && fixed[2] == 0.0
            && fixed[3] == 0.0;
        let sharp = |unknown: Unknown| if has_edges { unknown.rising(EDGES[2]) } else { unknown };
        let unknowns: Vec<_> = free.iter().map(|i| sharp(self.unknown(*i))).collect();
        let search = Search { unknowns, cost: &cost };
        let mut best = search.best(&chosen(&free, &self.starts()));
        let names: Vec<_> = free.iter().map(|i| format!("`{}`", FIELDS[*i].name())).collect();
        let findings = case.findings(&FIELDS, |i| match free.iter().position(|free| *free == i) {
            Some(place) => found(&search, &mut best, (place, &names), 1.0),
            None => Outcome::CannotTell(Reason::Specimens { there_are: self.specimens.len() }),
        });
        let [c1_m2, c2, ..] = all(&best.values);
        let residuals = self.residuals(&self.expected(c1_m2, c2));
        Ok(Fitted { findings, residuals: vec![residuals], ..Fitted::default() })
    }

    /// The numbers of the scenario.
    fn preset(&self, c1_m2: f64, c2: f64) -> [f64; 7] {
        let noise = &self.sensor.noise;
        // The curve of a specimen that is alone is its own.
        let (gain, offset) =
            if self.specimens.len() > 1 { (noise.gain_spread, noise.offset_spread) } else { (0.0, 0.0) };
        [c1_m2, c2, noise.multiplicative, noise.additive, noise.uniform, gain, offset]
    }

    /// The numbers to search: the curve always, noise and spread where they are wanted, and some noise always.
    fn free(&self, case: &Case<'_>, preset: &[f64; 7]) -> Vec<usize> {
        let wanted = |i: &usize| case.wanted_of(FIELDS[*i]);
        let mut free: Vec<usize> = (0..2).collect();
        free.extend((2..5).filter(wanted));
        if free.len() == 2 {
            let noisy = (2..5).filter(|i| preset[*i] > 0.0);
            free.extend(noisy);
            if free.len() == 2 {
                free.push(3);
            }
        }
        if self.specimens.len() >= LEAST_SPECIMENS {
            free.extend((5..7).filter(|i| wanted(i) || preset[*i] > 0.0));
        }
        free
    }

    fn unknown(&self, i: usize) -> Unknown {
        match i {
            0 => Unknown::positive(1e-8, 1e2),
            1 => Unknown::linear(0.0, 2.0),
            2 | 3 => Unknown::log(1e-6, 1.0),
            4 => Unknown::log(1e-6, 0.5).rising(EDGES[0]),
            _ => Unknown::log(1e-5, 2.0),
        }
    }

    /// Numbers to begin with: the curve by least squares, and noise by what that leaves.
    fn starts(&self) -> Vec<[f64; 7]> {
        // Far from full scale the curve is linear in both numbers.
        let (near, level) = (self.expected(1e-9, 0.0), self.expected(0.0, 1e-3));
        let mut normal = nalgebra::Matrix2::<f64>::identity() * 1e-12;
        let mut right = nalgebra::Vector2::<f64>::zeros();
        let rows = || self.specimens.iter().flatten();
        for (at, value) in rows() {
            let x = nalgebra::Vector2::new(near[*at] * 1e9, level[*at] * 1e3);
            normal += x * x.transpose();
            right += x * *value;
        }
        let [mut c1, c2] = normal.lu().solve(&right).unwrap_or_default().into();
        let c2 = c2.clamp(0.0, 1.0);
        c1 = c1.max(1e-7);
        let expected = self.expected(c1, c2);
        let rest = || rows().map(|(at, value)| (value - expected[*at]).abs());
        let most = rest().fold(1e-5, f64::max);
        let sigma = (rest().map(|rest| rest * rest).sum::<f64>() / rows().count() as f64).sqrt().max(1e-5);
        let start = |noise: f64, width: f64| [c1, c2, noise, noise, width, 0.1, 0.02];
        vec![start(0.3 * sigma, 1.2 * most), start(sigma, 0.3 * most), start(1.5 * sigma, 2.0 * most)]
    }
}
