//! An IR sensor before a flat wall that it faces: its curve, its noise, and the spread of its specimens.
//!
//! The value expected at the distance d is (3.12) of Wahde 2016 with (3.13) for each ray: the mean over the rays of
//! min(1, cos κ (c₁ cos² κ / d² + c₂)), and 0 of a ray that meets the wall beyond the range. A specimen makes of it
//! (S g + o) N(1, σₘ) + N(0, σₐ) + U(±w), rounded to the converter's steps.
//!
//! Rows at distances at which any value is at the end of the converter's range are left out: what a limit cut off tells
//! little, and would have to be integrated over.

use baudbot_sim::sensor::{Device, Infrared, InfraredModel, Sensor};
use baudbot_wire::Encoding;

use super::Case;
use super::specimens::{Spread, specimen};
use crate::estimate::{Finding, Fitted, Outcome, Reason, Residuals, found};
use crate::fields::{Field, SensorField};
use crate::log::{Column, Name, Quantity};
use crate::search::{EDGES, Search, Unknown};
use crate::statistics::Noise;

/// Fits the curves of the wanted sensors, which are taken as specimens of one kind.
pub(crate) fn fit(case: &Case<'_>) -> Fitted {
    match Rows::new(case) {
        Ok(rows) => rows.fit(case),
        Err(reason) => Fitted { findings: case.none(&reason), residuals: Vec::new() },
    }
}

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

struct Rows<'a> {
    sensor: &'a Sensor,
    infrared: &'a Infrared,
    /// The distances that there are.
    distances_m: Vec<f64>,
    /// By specimen: the place of the distance, and the value.
    specimens: Vec<Vec<(usize, f64)>>,
    /// The step of the converter.
    step: f64,
}

impl<'a> Rows<'a> {
    fn new(case: &Case<'a>) -> Result<Self, Reason> {
        let sensors: Vec<_> = case.robot.model.sensors.iter().enumerate().collect();
        let wanted =
            |i: usize| case.wanted.iter().any(|field| matches!(field, Field::Sensor(of, _) if *of == i));
        let wanted: Vec<&Sensor> =
            sensors.into_iter().filter(|(i, _)| wanted(*i)).map(|(_, sensor)| sensor).collect();
        let infrared = |sensor: &'a Sensor| {
            let Device::Infrared(infrared) = &sensor.device else { return None };
            Some((sensor, infrared))
        };
        let Some((sensor, infrared)) = wanted.first().and_then(|sensor| infrared(sensor)) else {
            return Err(Reason::Columns { needs: "IR sensor".into() });
        };
        let (distance, value) = (case.column(Quantity::Distance)?, case.column(Quantity::Value)?);
        let (full, step) = full_scale(case, value, sensor)?;
        let of_sensor = |row: usize| {
            let labels = case.log.labels.as_ref()?;
            let word = &labels.words[labels.of_rows[row]];
            case.robot.model.sensors.iter().find(|sensor| sensor.name == *word).map(|sensor| &sensor.name)
        };
        let mut rows = Self { sensor, infrared, distances_m: Vec::new(), specimens: Vec::new(), step };
        for row in 0..case.log.len() {
            let of_other =
                of_sensor(row).is_some_and(|name| !wanted.iter().any(|sensor| sensor.name == *name));
            let (distance, value) = (distance.values[row], value.values[row] / full);
            if !of_other && distance > 0.0 && value.is_finite() {
                let specimen = case.log.labels.as_ref().map_or(0, |labels| labels.of_rows[row]);
                rows.add(distance, value, specimen);
            }
        }
        rows.specimens.retain(|rows| !rows.is_empty());
        rows.leave_out_limits();
        rows.enough()?;
        Ok(rows)
    }

    fn add(&mut self, distance_m: f64, value: f64, specimen: usize) {
        let place = self.distances_m.iter().position(|known| *known == distance_m).unwrap_or_else(|| {
            self.distances_m.push(distance_m);
            self.distances_m.len() - 1
        });
        if self.specimens.len() <= specimen {
            self.specimens.resize(specimen + 1, Vec::new());
        }
        self.specimens[specimen].push((place, value));
    }

    fn leave_out_limits(&mut self) {
        let margin = 0.75 * self.step;
        let mut at_limit: Vec<bool> =
            self.distances_m.iter().map(|distance| *distance >= self.infrared.range_m).collect();
        for &(place, value) in self.specimens.iter().flatten() {
            at_limit[place] |= value <= margin || value >= 1.0 - margin;
        }
        for rows in &mut self.specimens {
            rows.retain(|(place, _)| !at_limit[*place]);
        }
        self.specimens.retain(|rows| !rows.is_empty());
    }

    fn enough(&self) -> Result<(), Reason> {
        let rows = self.specimens.iter().map(Vec::len).sum();
        if rows < LEAST_ROWS {
            let what = "rows within the sensor's range whose value is not at its limit".into();
            return Err(Reason::TooFew { what, rows, least: LEAST_ROWS });
        }
        Ok(())
    }

    /// The value that is expected at each distance.
    fn expected(&self, c1_m2: f64, c2: f64) -> Vec<f64> {
        let fan = &self.infrared.fan;
        let at = |distance_m: f64| {
            let ray = |i: usize| {
                let cos = fan.cos_kappa(i);
                let d = distance_m / cos;
                if cos <= 0.0 || d >= self.infrared.range_m {
                    0.0
                } else {
                    (cos * (c1_m2 / (d * d) + c2)).min(1.0)
                }
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

    fn fit(&self, case: &Case<'_>) -> Fitted {
        let fixed = self.preset();
        let free = self.free(case, &fixed);
        let all = |values: &[f64]| {
            let mut numbers = fixed;
            for (i, value) in free.iter().zip(values) {
                numbers[*i] = *value;
            }
            numbers
        };
        let cost = |values: &[f64]| self.cost(all(values));
        // Without normal noise the curve itself moves the edges of the uniform one.
        let has_edges = free.contains(&4)
            && !free.contains(&2)
            && !free.contains(&3)
            && fixed[2] == 0.0
            && fixed[3] == 0.0;
        let sharp = |unknown: Unknown| if has_edges { unknown.rising(EDGES[2]) } else { unknown };
        let unknowns: Vec<_> = free.iter().map(|i| sharp(self.unknown(*i))).collect();
        let search = Search { unknowns, cost: &cost };
        let starts = self.starts();
        let starts: Vec<Vec<f64>> =
            starts.iter().map(|start| free.iter().map(|i| start[*i]).collect()).collect();
        let mut best = search.best(&starts);
        let names: Vec<_> = free.iter().map(|i| format!("`{}`", FIELDS[*i].name())).collect();
        let outcomes = FIELDS.iter().enumerate().map(|(i, field)| {
            let place = free.iter().position(|free| *free == i);
            let outcome = |best: &mut _| match place {
                Some(place) => found(&search, best, (place, &names), 1.0),
                None => Outcome::CannotTell(Reason::Specimens { there_are: self.specimens.len() }),
            };
            (*field, case.wanted_of(*field).then(|| outcome(&mut best)))
        });
        let outcomes: Vec<_> = outcomes.collect();
        Fitted { findings: case.findings(&outcomes), residuals: vec![self.residuals(all(&best.values))] }
    }

    /// The numbers of the scenario.
    fn preset(&self) -> [f64; 7] {
        let (c1, c2) = match self.infrared.model {
            InfraredModel::Phenomenological { c1_m2, c2 } => (c1_m2, c2),
            InfraredModel::Lookup(_) | InfraredModel::Ambient { .. } => (0.0, 0.0),
        };
        let noise = &self.sensor.noise;
        // The curve of a specimen that is alone is its own.
        let (gain, offset) =
            if self.specimens.len() > 1 { (noise.gain_spread, noise.offset_spread) } else { (0.0, 0.0) };
        [c1, c2, noise.multiplicative, noise.additive, noise.uniform, gain, offset]
    }

    /// Which numbers are searched: the curve always, noise and spread where they are wanted, and some noise always.
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

    fn residuals(&self, numbers: [f64; 7]) -> Residuals {
        let expected = self.expected(numbers[0], numbers[1]);
        let point = |(at, value): &(usize, f64)| (self.distances_m[*at], value - expected[*at]);
        Residuals {
            title: format!("{}: value less the curve", self.sensor.name),
            x: "distance in m".into(),
            unit: "share of full scale".into(),
            points: self.specimens.iter().flatten().map(point).collect(),
        }
    }
}

impl Case<'_> {
    /// Whether the field is wanted of any sensor.
    pub(super) fn wanted_of(&self, field: SensorField) -> bool {
        self.wanted.iter().any(|wanted| matches!(wanted, Field::Sensor(_, of) if *of == field))
    }

    /// The findings of all sensors, which are specimens of one kind.
    pub(super) fn findings(&self, outcomes: &[(SensorField, Option<Outcome>)]) -> Vec<Finding> {
        let outcome = |field: &Field| match field {
            Field::Sensor(_, of) => outcomes.iter().find(|(field, _)| field == of)?.1.clone(),
            Field::Adapter(_) | Field::Motors(_) | Field::Body(_) => None,
        };
        self.wanted.iter().filter_map(|field| Some(self.finding(*field, outcome(field)?))).collect()
    }
}

/// The value that is full scale, and the step of the converter as a share of it.
fn full_scale(case: &Case<'_>, value: &Column, sensor: &Sensor) -> Result<(f64, f64), Reason> {
    let unit = match value.name {
        Name::Of(_, unit) => unit.suffix,
        Name::Reading(_) => "fraction",
    };
    let noted = case.log.note("full_scale").ok().flatten();
    let full = match (unit, noted, sensor.encodings.first()) {
        ("fraction", _, _) => return Ok((1.0, 0.0)),
        (_, Some(full), _) if full > 0.0 => full,
        ("raw", _, Some(Encoding::Level { bits, .. })) => (2.0_f64).powi(i32::from(*bits)) - 1.0,
        _ => {
            let needs =
                format!("line `# full_scale: NUMBER` that says which `{}` is full scale", value.header);
            return Err(Reason::Columns { needs });
        }
    };
    Ok((full, if unit == "raw" { 1.0 / full } else { 0.0 }))
}

/// Fewer rows tell nothing.
const LEAST_ROWS: usize = 20;

/// Fewer specimens tell no spread.
pub(super) const LEAST_SPECIMENS: usize = 3;
