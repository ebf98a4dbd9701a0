//! IR sensors before a flat wall that they face: rows of distances and values, and the two models of their curves.

mod formula;
mod table;

use baudbot_sim::sensor::{Device, Infrared, InfraredModel, Sensor};
use baudbot_wire::Encoding;

use super::Case;
use crate::estimate::{Fitted, Reason, Residuals};
use crate::fields::Field;
use crate::log::{Column, Name, Quantity};

/// Fits the curves of the wanted sensors, which are specimens of one kind.
pub(crate) fn fit(case: &Case<'_>) -> Fitted {
    let fitted = Rows::new(case).and_then(|rows| match &rows.infrared.model {
        InfraredModel::Phenomenological { c1_m2, c2 } => rows.fit_formula(case, *c1_m2, *c2),
        InfraredModel::Lookup(lookup) => rows.fit_table(case, lookup),
        InfraredModel::Ambient { .. } => Err(Reason::Columns { needs: "lit IR sensor".into() }),
    });
    fitted.unwrap_or_else(|reason| Fitted::only(case.none(&reason)))
}

/// Whether two sensors are specimens of one kind, wherever they sit.
pub(crate) fn same_kind(one: &Sensor, other: &Sensor) -> bool {
    let (Device::Infrared(a), Device::Infrared(b)) = (&one.device, &other.device) else { return false };
    let curve = |ir: &Infrared| (ir.fan.clone(), ir.range_m, ir.model.clone(), ir.converter);
    curve(a) == curve(b) && one.encodings == other.encodings
}

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
        let is_wanted =
            |i: usize| case.wanted.iter().any(|field| matches!(field, Field::Sensor(of, _) if *of == i));
        let wanted: Vec<&Sensor> =
            sensors.into_iter().filter(|(i, _)| is_wanted(*i)).map(|(_, sensor)| sensor).collect();
        let infrared = |sensor: &'a Sensor| {
            let Device::Infrared(infrared) = &sensor.device else { return None };
            Some((sensor, infrared))
        };
        let Some((sensor, infrared)) = wanted.first().and_then(|sensor| infrared(sensor)) else {
            return Err(Reason::Columns { needs: "IR sensor".into() });
        };
        let (distance, value) = (case.column(Quantity::Distance)?, case.column(Quantity::Value)?);
        let (full, step) = full_scale(case, value, sensor)?;
        let step = infrared.converter.map_or(step, |converter| step.max(converter.step()));
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

    fn residuals(&self, expected: &[f64]) -> Residuals {
        let point = |(at, value): &(usize, f64)| (self.distances_m[*at], value - expected[*at]);
        Residuals {
            title: format!("{}: value less the curve", self.sensor.name),
            x: "distance in m".into(),
            unit: "share of full scale".into(),
            points: self.specimens.iter().flatten().map(point).collect(),
        }
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
        ("raw", _, Some(Encoding::Level { bits, max, .. })) => ((2.0_f64).powi(i32::from(*bits)) - 1.0) / max,
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
pub(crate) const LEAST_SPECIMENS: usize = 3;
