//! The noise of an IR sensor that has a table of samples, or of voltages, and the spread of its specimens about that table.
//!
//! The table itself stays as it is. A specimen's mean reading at the distance d is S(d) g + o + δ: S is the mean of the
//! samples, g ~ N(1, σ_g) and o ~ N(0, σ_o) are the specimen's own, and δ ~ N(0, τ) is what neither tells, as of a wall
//! of another colour than the table's. So a sensor whose curve is not that of the table has no more noise for that:
//! noise is determined by readings at one distance alone, whose unknown mean is integrated over.

use super::super::specimens::{Spread, specimen};
use super::super::{Case, chosen, merged};
use super::{LEAST_SPECIMENS, Rows};
use crate::estimate::{Fitted, Outcome, Reason, found};
use crate::fields::SensorField;
use crate::search::{Search, Unknown};
use crate::statistics::Noise;

/// The numbers that are fitted, in the order of the search; τ is behind them.
const FIELDS: [SensorField; 5] = [
    SensorField::Multiplicative,
    SensorField::Additive,
    SensorField::Uniform,
    SensorField::GainSpread,
    SensorField::OffsetSpread,
];

/// The place of τ.
const DEVIATION: usize = FIELDS.len();

/// The spread of the specimens where these are too few for a fit: each has a curve of its own.
const OWN: Spread = Spread { gain: 1.0, offset: 0.3 };

/// The readings of one specimen at one distance.
struct Group {
    /// Mean and variance of the table's samples there.
    table: (f64, f64),
    mean: f64,
    least: f64,
    greatest: f64,
    /// The different readings, and how many of each there are.
    readings: Vec<(f64, f64)>,
    /// The number of readings.
    count: f64,
}

impl Group {
    fn new(mut values: Vec<f64>, table: (f64, f64)) -> Self {
        values.sort_by(f64::total_cmp);
        let mut readings: Vec<(f64, f64)> = Vec::new();
        for value in &values {
            match readings.last_mut().filter(|(last, _)| last == value) {
                Some((_, count)) => *count += 1.0,
                None => readings.push((*value, 1.0)),
            }
        }
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        Self { table, mean, least: values[0], greatest: values[values.len() - 1], readings, count }
    }

    /// −log of the likelihood of the readings, integrated over their unknown mean.
    fn cost(&self, noise: &Noise) -> f64 {
        if self.count < 2.0 {
            return 0.0;
        }
        let at = |mean: f64| -> f64 {
            self.readings.iter().map(|(value, count)| count * noise.cost(value - mean)).sum()
        };
        let sigma = (noise.variance() / self.count).sqrt();
        if noise.half_width < 0.3 * noise.sigma && noise.step < noise.sigma {
            // The integral of a normal distribution.
            return at(self.mean) - (sigma * (2.0 * std::f64::consts::PI).sqrt()).ln();
        }
        // Means that are within reach of all readings.
        let reach = noise.half_width + 0.5 * noise.step + 6.0 * noise.sigma;
        let about = (8.0 * sigma).max(0.6 * noise.step);
        let low = (self.greatest - reach).max(self.mean - about);
        let high = (self.least + reach).min(self.mean + about);
        if low >= high {
            return at(self.mean);
        }
        let width = (high - low) / f64::from(PIECES);
        let costs: Vec<f64> = (0..PIECES).map(|i| at(low + (f64::from(i) + 0.5) * width)).collect();
        let best = costs.iter().copied().fold(f64::INFINITY, f64::min);
        best - (costs.iter().map(|cost| (best - cost).exp()).sum::<f64>() * width).ln()
    }
}

/// Into so many pieces the range of an unknown mean is divided.
const PIECES: i32 = 16;

/// The least number of readings that repeat another one for a fit of the noise.
const LEAST_REPEATS: usize = 10;

impl Rows<'_> {
    /// Fits noise and spread about the table.
    /// Mean and variance of the table at a distance and an angle of incidence are given.
    pub(super) fn fit_table(
        &self,
        case: &Case<'_>,
        moments: &dyn Fn(f64, f64) -> (f64, f64),
    ) -> Result<Fitted, Reason> {
        let table = self.moments(moments);
        let specimens: Vec<Vec<Group>> = self.specimens.iter().map(|rows| groups(rows, &table)).collect();
        let fixed = self.fixed();
        let free = self.free_of_table(case, &fixed);
        let cost = |values: &[f64]| cost(&specimens, merged(fixed, &free, values), self.step);
        let unknowns = free.iter().map(|i| unknown(*i)).collect();
        let search = Search { unknowns, cost: &cost };
        let mut best = search.best(&chosen(&free, &starts(&specimens)));
        let name = |i: &usize| match FIELDS.get(*i) {
            Some(field) => format!("`{}`", field.name()),
            None => "a curve that is not the table's".to_owned(),
        };
        let names: Vec<_> = free.iter().map(name).collect();
        let repeats = specimens.iter().flatten().map(|group| group.count as usize - 1).sum();
        let findings = case.findings(&FIELDS, |i| match free.iter().position(|free| *free == i) {
            Some(_) if i < 3 && repeats < LEAST_REPEATS => {
                let what = "readings besides the first of a sensor at a distance".into();
                Outcome::CannotTell(Reason::TooFew { what, rows: repeats, least: LEAST_REPEATS })
            }
            Some(place) => found(&search, &mut best, (place, &names), 1.0),
            None => Outcome::CannotTell(Reason::Specimens { there_are: self.specimens.len() }),
        });
        let means: Vec<f64> = table.iter().map(|(mean, _)| *mean).collect();
        Ok(Fitted { findings, residuals: vec![self.residuals(&means)], ..Fitted::default() })
    }

    /// Mean and variance of the table's samples at each distance.
    fn moments(&self, moments: &dyn Fn(f64, f64) -> (f64, f64)) -> Vec<(f64, f64)> {
        let fan = self.ranger.fan();
        // The ray that comes back first is that which is straightest; the wall's normal is the sensor's axis.
        let nearest = (0..fan.len()).max_by(|a, b| fan.cos_kappa(*a).total_cmp(&fan.cos_kappa(*b)));
        let cos = fan.cos_kappa(nearest.unwrap_or_default());
        self.distances_m.iter().map(|distance_m| moments(distance_m / cos, cos.acos())).collect()
    }

    /// The numbers of the scenario.
    fn fixed(&self) -> [f64; 6] {
        let noise = &self.sensor.noise;
        let spread = if self.specimens.len() < LEAST_SPECIMENS {
            OWN
        } else {
            Spread { gain: noise.gain_spread, offset: noise.offset_spread }
        };
        [noise.multiplicative, noise.additive, noise.uniform, spread.gain, spread.offset, 0.0]
    }

    /// The numbers to search: noise where it is wanted, and some noise always; the spread of specimens that are enough.
    fn free_of_table(&self, case: &Case<'_>, fixed: &[f64; 6]) -> Vec<usize> {
        let is_wanted = |i: &usize| case.wanted_of(FIELDS[*i]);
        let mut free: Vec<usize> = (0..3).filter(is_wanted).collect();
        if free.is_empty() {
            free.extend((0..3).filter(|i| fixed[*i] > 0.0));
        }
        if free.is_empty() {
            free.push(1);
        }
        if self.specimens.len() >= LEAST_SPECIMENS {
            free.extend((3..5).filter(|i| is_wanted(i) || fixed[*i] > 0.0));
        }
        free.push(DEVIATION);
        free
    }
}

fn groups(rows: &[(usize, f64)], table: &[(f64, f64)]) -> Vec<Group> {
    let mut values = vec![Vec::new(); table.len()];
    for (place, value) in rows {
        values[*place].push(*value);
    }
    let groups = values.into_iter().zip(table).filter(|(values, _)| !values.is_empty());
    groups.map(|(values, table)| Group::new(values, *table)).collect()
}

/// −log L of the numbers in the order of [`FIELDS`], with τ behind them.
fn cost(specimens: &[Vec<Group>], numbers: [f64; 6], step: f64) -> f64 {
    let [multiplicative, additive, half_width, gain, offset, deviation] = numbers;
    let noise = |group: &Group| {
        let variance = (multiplicative * group.mean).powi(2) + additive * additive + group.table.1;
        Noise { sigma: variance.sqrt().max(1e-9), half_width, step }
    };
    let of_specimen = |groups: &Vec<Group>| {
        let weight = |group: &Group| 1.0 / (noise(group).variance() / group.count + deviation * deviation);
        let rows = || groups.iter().map(|group| (group.table.0, group.mean - group.table.0, weight(group)));
        let specimen = specimen(rows(), Spread { gain, offset });
        let between = rows().map(|(expected, above, weight)| {
            let rest = above - expected * specimen.gain - specimen.offset;
            0.5 * (rest * rest * weight - weight.ln())
        });
        let within = groups.iter().map(|group| group.cost(&noise(group)));
        between.sum::<f64>() + within.sum::<f64>() + specimen.cost
    };
    specimens.iter().map(of_specimen).sum()
}

fn unknown(i: usize) -> Unknown {
    match i {
        0 | 1 => Unknown::log(1e-6, 1.0),
        2 => Unknown::log(1e-6, 0.5),
        DEVIATION => Unknown::log(1e-6, 1.0),
        _ => Unknown::log(1e-5, 2.0),
    }
}

/// Numbers to begin with, by what the readings at one distance differ.
fn starts(specimens: &[Vec<Group>]) -> Vec<[f64; 6]> {
    let groups = || specimens.iter().flatten();
    let squares = |group: &Group| -> f64 {
        group.readings.iter().map(|(value, count)| count * (value - group.mean).powi(2)).sum()
    };
    let count: f64 = groups().map(|group| group.count).sum();
    let sigma = (groups().map(squares).sum::<f64>() / count).sqrt().max(1e-5);
    let most = groups().map(|group| 0.5 * (group.greatest - group.least)).fold(1e-5, f64::max);
    let start = |noise: f64, width: f64, deviation: f64| [noise, noise, width, 0.1, 0.02, deviation];
    vec![
        start(0.3 * sigma, 1.2 * most, 1e-3),
        start(sigma, 0.3 * most, 1e-2),
        start(1.5 * sigma, 2.0 * most, 1e-5),
    ]
}
