//! IR sensors before a flat wall that they face: rows of distances and values, and the models of their curves: a formula, or a table,
//! of readings or of voltages.

mod formula;
mod table;

use baudbot_geometry::Fan;
use baudbot_sim::sensor::{Device, Infrared, InfraredModel, Sensor, VoltageRanger};
use baudbot_wire::Encoding;

use super::Case;
use crate::estimate::{Fitted, Reason, Remark, Residuals};
use crate::fields::Field;
use crate::log::{Column, Name, Quantity};

/// Fits the curves of the wanted sensors, which are specimens of one kind.
pub(crate) fn fit(case: &Case<'_>) -> Fitted {
    let fitted = Rows::new(case).and_then(|rows| match rows.ranger {
        Ranger::Reading(infrared) => match &infrared.model {
            InfraredModel::Phenomenological { c1_m2, c2 } => rows.fit_formula(case, *c1_m2, *c2),
            InfraredModel::Lookup(lookup) => rows.fit_table(case, &|d, angle| lookup.moments(d, angle)),
            InfraredModel::Ambient { .. } => Err(Reason::Columns { needs: "lit IR sensor".into() }),
        },
        Ranger::Voltage(ranger) => {
            let fitted = rows.fit_table(case, &|distance_m, _| (ranger.voltage_at(distance_m), 0.0));
            let curve = Remark::Curve { sensor: rows.sensor.name.clone(), points: rows.medians() };
            fitted.map(|fitted| Fitted { remarks: vec![curve], ..fitted })
        }
    });
    fitted.unwrap_or_else(|reason| Fitted::only(case.none(&reason)))
}

/// Whether two sensors are specimens of one kind, wherever they sit.
pub(crate) fn same_kind(one: &Sensor, other: &Sensor) -> bool {
    let of_reading = |ir: &Infrared| (ir.fan.clone(), ir.range_m, ir.model.clone(), ir.converter);
    let of_voltage = |ranger: &VoltageRanger| {
        (ranger.fan.clone(), ranger.range_m, ranger.curve.clone(), ranger.idle_v, ranger.supply_v)
    };
    let is_same = match (Ranger::of(one), Ranger::of(other)) {
        (Some(Ranger::Reading(a)), Some(Ranger::Reading(b))) => of_reading(a) == of_reading(b),
        (Some(Ranger::Voltage(a)), Some(Ranger::Voltage(b))) => of_voltage(a) == of_voltage(b),
        (Some(_) | None, Some(_) | None) => false,
    };
    is_same && one.encodings == other.encodings
}

/// A sensor that measures a distance by the light that comes back.
#[derive(Clone, Copy)]
enum Ranger<'a> {
    /// The values are fractions of full scale.
    Reading(&'a Infrared),
    /// The values are volts.
    Voltage(&'a VoltageRanger),
}

impl<'a> Ranger<'a> {
    fn of(sensor: &'a Sensor) -> Option<Self> {
        if let Device::Infrared(infrared) = &sensor.device {
            Some(Self::Reading(infrared))
        } else if let Device::VoltageRanger(ranger) = &sensor.device {
            Some(Self::Voltage(ranger))
        } else {
            None
        }
    }

    fn fan(self) -> &'a Fan {
        match self {
            Self::Reading(infrared) => &infrared.fan,
            Self::Voltage(ranger) => &ranger.fan,
        }
    }

    fn range_m(self) -> f64 {
        match self {
            Self::Reading(infrared) => infrared.range_m,
            Self::Voltage(ranger) => ranger.range_m,
        }
    }

    /// The largest value.
    fn top(self) -> f64 {
        match self {
            Self::Reading(_) => 1.0,
            Self::Voltage(ranger) => ranger.supply_v,
        }
    }

    fn unit(self) -> &'static str {
        match self {
            Self::Reading(_) => "share of full scale",
            Self::Voltage(_) => "V",
        }
    }
}

struct Rows<'a> {
    sensor: &'a Sensor,
    ranger: Ranger<'a>,
    /// The distances that there are.
    distances_m: Vec<f64>,
    /// The place of the distance, and the value, by specimen.
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
        let of = |sensor: &&'a Sensor| Some((*sensor, Ranger::of(sensor)?));
        let Some((sensor, ranger)) = wanted.first().and_then(of) else {
            return Err(Reason::Columns { needs: "IR sensor".into() });
        };
        let (distance, value) = (case.column(Quantity::Distance)?, case.column(Quantity::Value)?);
        let (full, mut step) = full_scale(case, value, (sensor, ranger))?;
        if let Ranger::Reading(infrared) = ranger {
            step = infrared.converter.map_or(step, |converter| step.max(converter.step()));
        }
        let of_sensor = |row: usize| {
            let labels = case.log.labels.as_ref()?;
            let word = &labels.words[labels.of_rows[row]];
            case.robot.model.sensors.iter().find(|sensor| sensor.name == *word).map(|sensor| &sensor.name)
        };
        let mut rows = Self { sensor, ranger, distances_m: Vec::new(), specimens: Vec::new(), step };
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
        let (margin, top) = (0.75 * self.step, self.ranger.top());
        let mut at_limit: Vec<bool> =
            self.distances_m.iter().map(|distance| *distance >= self.ranger.range_m()).collect();
        for &(place, value) in self.specimens.iter().flatten() {
            at_limit[place] |= value <= margin || value >= top - margin;
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

    /// The median of the values at each distance, by distance: the curve of the log.
    fn medians(&self) -> Vec<[f64; 2]> {
        let mut points: Vec<_> = (0..self.distances_m.len())
            .filter_map(|at| {
                let here = self.specimens.iter().flatten().filter(|(place, _)| *place == at);
                let mut values: Vec<f64> = here.map(|(_, value)| *value).collect();
                values.sort_by(f64::total_cmp);
                Some([self.distances_m[at], *values.get(values.len() / 2)?])
            })
            .collect();
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        points
    }

    fn residuals(&self, expected: &[f64]) -> Residuals {
        let point = |(at, value): &(usize, f64)| (self.distances_m[*at], value - expected[*at]);
        Residuals {
            title: format!("{}: value less the curve", self.sensor.name),
            x: "distance in m".into(),
            unit: self.ranger.unit().into(),
            points: self.specimens.iter().flatten().map(point).collect(),
        }
    }
}

/// The divisor of the log's values, and the step of the converter after that.
fn full_scale(
    case: &Case<'_>,
    value: &Column,
    (sensor, ranger): (&Sensor, Ranger<'_>),
) -> Result<(f64, f64), Reason> {
    let unit = match value.name {
        Name::Of(_, unit) => unit.suffix,
        Name::Reading(_) => "fraction",
    };
    let noted = case.log.note("full_scale").ok().flatten();
    let full = match (unit, noted, sensor.encodings.first()) {
        ("fraction", _, _) => return Ok((1.0 / ranger.top(), 0.0)),
        ("v", None, _) if matches!(ranger, Ranger::Voltage(_)) => return Ok((1.0, 0.0)),
        (_, Some(full), _) if full > 0.0 => full / ranger.top(),
        ("raw", _, Some(Encoding::Level { bits, max, .. })) => ((2.0_f64).powi(i32::from(*bits)) - 1.0) / max,
        _ => {
            let needs =
                format!("line `# full_scale: NUMBER` that gives the `{}` of full scale", value.header);
            return Err(Reason::Columns { needs });
        }
    };
    Ok((full, if unit == "raw" { 1.0 / full } else { 0.0 }))
}

/// The least number of rows for a fit.
const LEAST_ROWS: usize = 20;

/// The least number of specimens for a spread.
pub(crate) const LEAST_SPECIMENS: usize = 3;
