//! The sensory preprocessing system of Wahde 2016, Section 8.2.1: from the readings of all sensors to a few **state
//! variables** z, by which a brain decides: weighted sums (8.1), minima (8.2), maxima (8.3), and small neural networks.

use baudbot_brain::{Body, SensorKind, Turn};

pub use crate::network::Network;

/// The sources and mappings that make state variables of readings.
#[derive(Clone, Debug, PartialEq)]
pub struct Senses {
    pub(crate) variables: Vec<StateVariable>,
    values: Vec<f64>,
    /// The instants at which each sensor's last new reading came.
    news_ns: Vec<Option<u64>>,
}

/// One state variable.
#[derive(Clone, Debug, PartialEq)]
pub struct StateVariable {
    /// The variable's name.
    pub name: String,
    /// The readings that it is made of.
    pub sources: Vec<Source>,
    /// The function of the readings.
    pub mapping: Mapping,
    /// A reading that is not renewed for longer than this, in seconds, counts as 0, as one does that never came.
    pub stale_s: Option<f64>,
}

/// A value of a reading, or several.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// The sensor's place in [`Body::sensors`].
    pub sensor: usize,
    /// The range of its values.
    pub values: std::ops::Range<usize>,
}

/// The function from values to one number.
#[derive(Clone, Debug, PartialEq)]
pub enum Mapping {
    /// Eq. (8.1): the weighted sum. As many weights as values.
    Sum(Vec<f64>),
    /// The minimum, Eq. (8.2).
    Min,
    /// The maximum, Eq. (8.3).
    Max,
    /// A neural network, whose last layer has one neuron.
    Network(Network),
}

/// A reason why something cannot be a source of a body's.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SourceError {
    /// There is no such sensor.
    #[error("there is no sensor `{name}`; there are: {}", known.join(", "))]
    Sensor {
        /// The name given.
        name: String,
        /// The sensors that exist.
        known: Vec<String>,
    },
    /// The sensor has no such part.
    #[error("sensor `{sensor}` has no part `{part}`; it has: {}", known.join(", "))]
    Part {
        /// The sensor's name.
        sensor: String,
        /// The part given.
        part: String,
        /// The parts of the sensor, by name or by number.
        known: Vec<String>,
    },
}

impl Source {
    /// The source of a text: `SENSOR` is all its values, `SENSOR.PART` those of one component, `SENSOR.3` its fourth
    /// value.
    ///
    /// # Errors
    /// If the body has no such sensor, or the sensor no such part.
    pub fn parse(text: &str, body: &Body) -> Result<Self, SourceError> {
        // Sensors' names have no dots.
        let (name, part) = text.split_once('.').map_or((text, None), |(name, part)| (name, Some(part)));
        let Some(sensor) = body.sensor_index(name) else {
            let known = body.sensors.iter().map(|sensor| sensor.name.clone()).collect();
            return Err(SourceError::Sensor { name: name.to_owned(), known });
        };
        let described = &body.sensors[sensor];
        let all = described.values();
        let Some(part) = part else { return Ok(Self { sensor, values: 0..all }) };
        if let Some(place) = part.parse().ok().filter(|&place: &usize| place < all) {
            return Ok(Self { sensor, values: place..place + 1 });
        }
        let mut begin = 0;
        for component in &described.components {
            if component.name == part {
                return Ok(Self { sensor, values: begin..begin + component.count });
            }
            begin += component.count;
        }
        let names = described.components.iter().map(|component| component.name.clone());
        let known = names
            .filter(|name| !name.is_empty())
            .chain([format!("0 to {}", all.saturating_sub(1))])
            .collect();
        Err(SourceError::Part { sensor: name.to_owned(), part: part.to_owned(), known })
    }

    /// The first of the source's values in the sensor's last reading; `None` if there is none yet.
    pub fn first(&self, turn: &Turn) -> Option<f64> {
        turn.readings.get(self.sensor)?.as_ref()?.values.get(self.values.start).copied()
    }

    /// The number of values.
    pub fn count(&self) -> usize {
        self.values.len()
    }
}

impl Senses {
    /// None of it is known yet: all state variables are what they are of zeros.
    pub fn new(variables: Vec<StateVariable>, body: &Body) -> Self {
        let values = vec![0.0; variables.len()];
        Self { variables, values, news_ns: vec![None; body.sensors.len()] }
    }

    /// Names, in the order of the values.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.variables.iter().map(|variable| variable.name.as_str())
    }

    /// The state variables as they are.
    pub(crate) fn values(&self) -> &[f64] {
        &self.values
    }

    /// Takes in what has come, and returns the state variables.
    pub fn take(&mut self, turn: &Turn) -> &[f64] {
        for (news_ns, reading) in self.news_ns.iter_mut().zip(&turn.readings) {
            if reading.as_ref().is_some_and(|reading| reading.readable) {
                *news_ns = Some(turn.at_ns);
            }
        }
        for (variable, value) in self.variables.iter().zip(&mut self.values) {
            let inputs = variable.sources.iter().flat_map(|source| {
                let is_there = is_fresh(self.news_ns.get(source.sensor), turn.at_ns, variable.stale_s);
                readings(source, turn, is_there)
            });
            *value = variable.mapping.apply(inputs);
        }
        &self.values
    }
}

fn is_fresh(news_ns: Option<&Option<u64>>, at_ns: u64, stale_s: Option<f64>) -> bool {
    let Some(&Some(news_ns)) = news_ns else { return false };
    stale_s.is_none_or(|stale_s| at_ns.saturating_sub(news_ns) as f64 * 1e-9 <= stale_s)
}

/// A source's values; zeros if they are not there. A ray of a laser that met nothing is as long as the laser can see.
fn readings<'a>(source: &'a Source, turn: &'a Turn, is_there: bool) -> impl Iterator<Item = f64> + 'a {
    let reading = turn.readings.get(source.sensor).and_then(Option::as_ref).filter(|_| is_there);
    let sensor = turn.body.sensors.get(source.sensor);
    let beyond = sensor.filter(|sensor| sensor.kind == SensorKind::Laser).and_then(|sensor| sensor.range_m);
    source.values.clone().map(move |place| {
        let value = reading.and_then(|reading| reading.values.get(place)).copied().unwrap_or(0.0);
        beyond.filter(|_| value < 0.0).unwrap_or(value)
    })
}

impl Mapping {
    fn apply(&self, inputs: impl Iterator<Item = f64>) -> f64 {
        match self {
            Self::Sum(weights) => weights.iter().zip(inputs).map(|(weight, input)| weight * input).sum(),
            Self::Min => inputs.reduce(f64::min).unwrap_or(0.0),
            Self::Max => inputs.reduce(f64::max).unwrap_or(0.0),
            Self::Network(network) => network.answer(inputs.collect()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_body::{body, turn};

    fn variable(mapping: Mapping, sources: &[&str], body: &Body) -> StateVariable {
        let sources = sources.iter().map(|source| Source::parse(source, body).unwrap()).collect();
        StateVariable { name: "z".to_owned(), sources, mapping, stale_s: None }
    }

    fn value(mapping: Mapping, readings: [f64; 3]) -> f64 {
        let body = body(&[("left", "ir", 0.7), ("front", "ir", 0.0), ("right", "ir", -0.7)]);
        let mut senses = Senses::new(vec![variable(mapping, &["left", "front", "right"], &body)], &body);
        let readings = readings.map(|reading| [reading]);
        senses.take(&turn(&body, 0, &readings.each_ref().map(|reading| Some(reading.as_slice()))))[0]
    }

    /// (8.1)–(8.3).
    #[test]
    fn sums_minima_and_maxima() {
        let readings = [0.2, 0.5, 0.1];
        assert!((value(Mapping::Sum(vec![1.0, 2.0, -3.0]), readings) - 0.9).abs() < 1e-12);
        assert_eq!(value(Mapping::Min, readings), 0.1);
        assert_eq!(value(Mapping::Max, readings), 0.5);
    }

    #[test]
    fn what_never_came_and_what_is_not_renewed_counts_as_zero() {
        let body = body(&[("front", "ir", 0.0)]);
        let mut stale = variable(Mapping::Max, &["front"], &body);
        stale.stale_s = Some(0.1);
        let mut senses = Senses::new(vec![stale, variable(Mapping::Max, &["front"], &body)], &body);
        assert_eq!(senses.take(&turn(&body, 0, &[None])), [0.0, 0.0]);
        assert_eq!(senses.take(&turn(&body, 10_000_000, &[Some(&[0.4])])), [0.4, 0.4]);
        let mut old = turn(&body, 110_000_000, &[Some(&[0.4])]);
        old.readings[0].as_mut().unwrap().readable = false;
        assert_eq!(senses.take(&old), [0.4, 0.4]);
        old.at_ns += 1_000_000;
        assert_eq!(senses.take(&old), [0.0, 0.4]);
    }

    #[test]
    fn a_ray_that_met_nothing_is_as_long_as_the_laser_sees() {
        let body = body(&[("laser", "laser", 0.0)]);
        let mut senses = Senses::new(vec![variable(Mapping::Min, &["laser"], &body)], &body);
        assert_eq!(senses.take(&turn(&body, 0, &[Some(&[-1.0; 3])])), [1.0]);
    }

    #[test]
    fn sources_are_named_by_sensor_component_or_place() {
        let mut body = body(&[("odometer", "odometer", 0.0)]);
        for (component, name) in body.sensors[0].components.iter_mut().zip(["x_m", "y_m", "heading_rad"]) {
            component.name = name.to_owned();
        }
        let values = |text| Source::parse(text, &body).map(|source| source.values);
        assert_eq!(values("odometer"), Ok(0..3));
        assert_eq!(values("odometer.y_m"), Ok(1..2));
        assert_eq!(values("odometer.2"), Ok(2..3));
        let problem = |text| values(text).unwrap_err().to_string();
        assert_eq!(problem("compass"), "there is no sensor `compass`; there are: odometer");
        assert_eq!(
            problem("odometer.3"),
            "sensor `odometer` has no part `3`; it has: x_m, y_m, heading_rad, 0 to 2"
        );
    }
}
