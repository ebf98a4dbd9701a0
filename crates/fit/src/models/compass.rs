//! A compass beside true headings: iron, bias and noise.
//!
//! The reading is θ + hard sin(θ + p) + soft sin(2 θ + q) + o + noise, with the specimen's bias o; differences are
//! taken around the circle. A scenario has no field for the bias of one specimen, only for the spread of all; it is
//! reported besides.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use baudbot_geometry::angle;
use baudbot_sim::sensor::{Device, Sensor};
use baudbot_wire::Encoding;

use super::curve::LEAST_SPECIMENS;
use super::specimens::{Spread, specimen};
use super::{Case, chosen, merged};
use crate::estimate::{Estimate, Finding, Fitted, Outcome, Reason, Residuals, found};
use crate::fields::SensorField;
use crate::log::Quantity;
use crate::search::{EDGES, Search, Unknown};
use crate::statistics::Noise;

/// The numbers in the order of the search; the bias, which is no field, comes before them.
const FIELDS: [SensorField; 7] = [
    SensorField::HardIron,
    SensorField::HardIronPhase,
    SensorField::SoftIron,
    SensorField::SoftIronPhase,
    SensorField::Additive,
    SensorField::Uniform,
    SensorField::OffsetSpread,
];

/// All numbers of the model.
type Numbers = [f64; 8];

/// Fits the compass at a place among the robot's sensors.
pub(crate) fn fit(case: &Case<'_>, sensor: usize) -> Fitted {
    match Rows::new(case, sensor) {
        Ok(rows) => rows.fit(case),
        Err(reason) => Fitted::only(case.none(&reason)),
    }
}

struct Rows<'a> {
    sensor: &'a Sensor,
    /// The true heading, and reading less heading, by specimen.
    specimens: Vec<Vec<(f64, f64)>>,
    step: f64,
}

impl<'a> Rows<'a> {
    fn new(case: &Case<'a>, sensor: usize) -> Result<Self, Reason> {
        let sensor = &case.robot.model.sensors[sensor];
        let heading = case.column(Quantity::Heading)?;
        let missing =
            || Reason::Columns { needs: format!("column `{}`, the compass's reading", sensor.name) };
        let reading = case.log.reading(&sensor.name).ok_or_else(missing)?;
        let step = match sensor.encodings.first() {
            Some(Encoding::Level { bits, .. }) => TAU / (2.0_f64.powi(i32::from(*bits)) - 1.0),
            Some(Encoding::Float64 | Encoding::Signed { .. } | Encoding::Counter { .. }) | None => 0.0,
        };
        let mut rows = Self { sensor, specimens: Vec::new(), step };
        for row in fresh(case, &reading.values, sensor) {
            let specimen = case.log.labels.as_ref().map_or(0, |labels| labels.of_rows[row]);
            if rows.specimens.len() <= specimen {
                rows.specimens.resize(specimen + 1, Vec::new());
            }
            let truth = heading.values[row];
            if truth.is_finite() {
                rows.specimens[specimen].push((truth, angle::wrap(reading.values[row] - truth)));
            }
        }
        rows.specimens.retain(|rows| !rows.is_empty());
        let count = rows.specimens.iter().map(Vec::len).sum();
        if count < LEAST_ROWS {
            return Err(Reason::TooFew {
                what: "readings with a heading".into(),
                rows: count,
                least: LEAST_ROWS,
            });
        }
        Ok(rows)
    }

    fn cost(&self, numbers: Numbers) -> f64 {
        let [bias, hard, hard_phase, soft, soft_phase, sigma, half_width, spread] = numbers;
        let noise = Noise { sigma: sigma.max(1e-9), half_width, step: self.step };
        let weight = 1.0 / noise.variance();
        let expected =
            |theta: f64| bias + hard * (theta + hard_phase).sin() + soft * (2.0 * theta + soft_phase).sin();
        let several = self.specimens.len() > 1;
        let of_specimen = |rows: &Vec<(f64, f64)>| {
            let above: Vec<f64> =
                rows.iter().map(|(theta, error)| angle::wrap(error - expected(*theta))).collect();
            let own = if several {
                let spread = Spread { gain: 0.0, offset: spread };
                specimen(above.iter().map(|above| (0.0, *above, weight)), spread)
            } else {
                super::specimens::Specimen::default()
            };
            above.iter().map(|above| noise.cost(above - own.offset)).sum::<f64>() + own.cost
        };
        self.specimens.iter().map(of_specimen).sum()
    }

    fn fit(&self, case: &Case<'_>) -> Fitted {
        let fixed = self.preset();
        let free = self.free(case, &fixed);
        let all = |values: &[f64]| merged(fixed, &free, values);
        let cost = |values: &[f64]| self.cost(all(values));
        let start = self.start();
        let unknowns: Vec<_> = free.iter().map(|i| unknown(*i, start[*i])).collect();
        let search = Search { unknowns, cost: &cost };
        let mut best = search.best(&chosen(&free, &[start]));
        let names: Vec<_> = free.iter().map(|i| name(*i)).collect();
        let mut findings = case.findings(&FIELDS, |i| match free.iter().position(|free| *free == i + 1) {
            Some(place) => wrapped(FIELDS[i], found(&search, &mut best, (place, &names), 1.0)),
            None => Outcome::CannotTell(Reason::Specimens { there_are: self.specimens.len() }),
        });
        let outcome = found(&search, &mut best, (0, &names), 1.0);
        findings.push(Finding {
            path: format!("bias of {}, in rad", self.sensor.name),
            is_field: false,
            outcome,
        });
        Fitted { findings, residuals: vec![self.residuals(all(&best.values))], ..Fitted::default() }
    }

    fn preset(&self) -> Numbers {
        let noise = &self.sensor.noise;
        let ((hard, hard_phase), (soft, soft_phase)) = if let Device::Compass(compass) = &self.sensor.device {
            (compass.hard_iron_rad, compass.soft_iron_rad)
        } else {
            Default::default()
        };
        [0.0, hard, hard_phase, soft, soft_phase, noise.additive, noise.uniform, noise.offset_spread]
    }

    /// The bias and some noise always; iron and spread where they are wanted.
    fn free(&self, case: &Case<'_>, preset: &Numbers) -> Vec<usize> {
        let wanted = |i: usize| case.wanted_of(FIELDS[i - 1]);
        let mut free = vec![0];
        for size in [1, 3] {
            if wanted(size) || wanted(size + 1) {
                free.extend([size, size + 1]);
            }
        }
        let uniform_alone = preset[5] == 0.0 && preset[6] > 0.0 && !wanted(5);
        free.extend((5..7).filter(|i| wanted(*i) || (*i == 6 && uniform_alone)));
        if !free.contains(&5) && !free.contains(&6) {
            free.push(5);
        }
        if self.specimens.len() >= LEAST_SPECIMENS && (wanted(7) || preset[7] > 0.0) {
            free.push(7);
        }
        free
    }

    /// Numbers to begin with, by least squares.
    fn start(&self) -> Numbers {
        let rows = || self.specimens.iter().flatten();
        let count = rows().count() as f64;
        let circular = rows().fold((0.0, 0.0), |sum, (_, error)| (sum.0 + error.sin(), sum.1 + error.cos()));
        let bias = circular.0.atan2(circular.1);
        let mut normal = nalgebra::SMatrix::<f64, 5, 5>::identity() * 1e-9;
        let mut right = nalgebra::SVector::<f64, 5>::zeros();
        for (theta, error) in rows() {
            let (sin, cos) = theta.sin_cos();
            let (sin_2, cos_2) = (2.0 * theta).sin_cos();
            let x = nalgebra::SVector::<f64, 5>::from([1.0, sin, cos, sin_2, cos_2]);
            normal += x * x.transpose();
            right += x * angle::wrap(error - bias);
        }
        let found = normal.lu().solve(&right).unwrap_or_default();
        let [mean, a, b, c, d] = found.into();
        let squares = rows().map(|(theta, error)| {
            let (sin, cos) = theta.sin_cos();
            let (sin_2, cos_2) = (2.0 * theta).sin_cos();
            angle::wrap(error - bias - mean - a * sin - b * cos - c * sin_2 - d * cos_2).powi(2)
        });
        let sigma = (squares.sum::<f64>() / count).sqrt().max(1e-5);
        [bias + mean, a.hypot(b), b.atan2(a), c.hypot(d), d.atan2(c), sigma, 0.5 * sigma, 0.1]
    }

    fn residuals(&self, numbers: Numbers) -> Residuals {
        let [bias, hard, hard_phase, soft, soft_phase, ..] = numbers;
        let point = |(theta, error): &(f64, f64)| {
            let iron = hard * (theta + hard_phase).sin() + soft * (2.0 * theta + soft_phase).sin();
            (*theta, angle::wrap(error - bias - iron))
        };
        Residuals {
            title: format!("{}: reading less the model", self.sensor.name),
            x: "true heading in rad".into(),
            unit: "rad".into(),
            points: self.specimens.iter().flatten().map(point).collect(),
        }
    }
}

/// The rows at which a sensor has been read again: its value has changed, or its period has passed.
pub(super) fn fresh(case: &Case<'_>, values: &[f64], sensor: &Sensor) -> Vec<usize> {
    let period_s = sensor.schedule.period_ns() as f64 * 1e-9;
    let times = case.log.column(Quantity::Time).map(|column| column.values.as_slice());
    let mut rows: Vec<usize> = Vec::new();
    for (row, value) in values.iter().enumerate() {
        if value.is_nan() {
            continue;
        }
        let is_new = rows.last().is_none_or(|last| {
            let late = times.is_none_or(|times| times[row] - times[*last] >= 0.99 * period_s);
            late || values[*last] != *value
        });
        if is_new {
            rows.push(row);
        }
    }
    rows
}

fn unknown(i: usize, start: f64) -> Unknown {
    match i {
        0 => Unknown::linear(start - FRAC_PI_2, start + FRAC_PI_2),
        1 | 3 => Unknown::linear(0.0, 1.0),
        2 | 4 => Unknown::linear(start - PI, start + PI),
        6 => Unknown::log(1e-6, 1.0).rising(EDGES[1]),
        _ => Unknown::log(1e-6, 3.0),
    }
}

fn name(i: usize) -> String {
    i.checked_sub(1).map_or_else(|| "the compass's bias".into(), |i| format!("`{}`", FIELDS[i].name()))
}

/// A phase as one of a turn.
fn wrapped(field: SensorField, outcome: Outcome) -> Outcome {
    match (field, outcome) {
        (
            SensorField::HardIronPhase | SensorField::SoftIronPhase,
            Outcome::Estimate(Estimate { value, low, high, whole }),
        ) => {
            let shift = angle::wrap(value) - value;
            Outcome::Estimate(Estimate { value: value + shift, low: low + shift, high: high + shift, whole })
        }
        (_, outcome) => outcome,
    }
}

const LEAST_ROWS: usize = 20;
