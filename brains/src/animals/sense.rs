//! The stimuli of an animal, from a robot's sensors.

use baudbot_brain::{Body, SensorKind, Turn};
use baudbot_geometry::angle;

/// The stimuli on both sides.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sides {
    /// The value on the left.
    pub left: f64,
    /// The value on the right.
    pub right: f64,
}

/// All sensors of one kind that a robot has.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Sense {
    receptors: Vec<Receptor>,
    counts: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Receptor {
    sensor: usize,
    /// The receptor's place in metres or direction in radians, to the left if positive.
    aside: f64,
    felt: Option<Felt>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Felt {
    value: f64,
    at_ns: u64,
}

impl Sense {
    /// The sensors of the first of these kinds that the robot has; `None` if it has none of any.
    pub(super) fn new(body: &Body, kinds: &[SensorKind]) -> Option<Self> {
        let kind = kinds.iter().find(|kind| body.sensors.iter().any(|sensor| sensor.kind == **kind))?;
        let sensors = body.sensors.iter().enumerate().filter(|(_, sensor)| sensor.kind == *kind);
        let receptors = sensors.map(|(sensor, described)| {
            let mount = described.mount.unwrap_or_default();
            // The direction of a sensor is a better sign of its side than its place.
            let aside = if mount.heading_rad == 0.0 { mount.y_m } else { angle::wrap(mount.heading_rad) };
            Receptor { sensor, aside, felt: None }
        });
        Some(Self { receptors: receptors.collect(), counts: *kind == SensorKind::Photoresistor })
    }

    /// Takes in what is new. Whether anything is.
    pub(super) fn look(&mut self, turn: &Turn) -> bool {
        let mut news = false;
        for receptor in &mut self.receptors {
            let reading = turn.readings.get(receptor.sensor).and_then(Option::as_ref);
            let Some(reading) = reading.filter(|reading| reading.readable) else { continue };
            let Some(&value) = reading.values.first().filter(|value| value.is_finite()) else { continue };
            let value = if self.counts { brightness(value) } else { value };
            receptor.felt = Some(Felt { value, at_ns: turn.at_ns });
            news = true;
        }
        news
    }

    /// Whether a sensor has had no new reading for too long.
    pub(super) fn is_numb(&self, at_ns: u64) -> bool {
        let is_old = |felt: Felt| at_ns.saturating_sub(felt.at_ns) > STALE_NS;
        self.receptors.iter().any(|receptor| receptor.felt.is_none_or(is_old))
    }

    /// The mean of what all sensors feel.
    pub(super) fn mean(&self) -> f64 {
        self.mean_of(|_| true).unwrap_or(0.0)
    }

    /// The feeling on the left and on the right; `None` unless there are sensors on both sides.
    pub(super) fn sides(&self) -> Option<Sides> {
        Some(Sides { left: self.mean_of(|aside| aside > 0.0)?, right: self.mean_of(|aside| aside < 0.0)? })
    }

    fn mean_of(&self, which: impl Fn(f64) -> bool) -> Option<f64> {
        let some = self.receptors.iter().filter(|receptor| which(receptor.aside));
        let (count, sum) = some.fold((0.0, 0.0), |(count, sum), receptor| {
            (count + 1.0, sum + receptor.felt.map_or(0.0, |felt| felt.value))
        });
        (count > 0.0).then(|| sum / count)
    }
}

/// Light, from the counts of a photoresistor: few in bright light, and 0 where it was too dark to count. How it depends
/// on the illuminance, the data sheet does not state; it only grows with it.
fn brightness(counts: f64) -> f64 {
    if counts > 0.0 { 1000.0 / counts } else { 0.0 }
}

/// A photoresistor in the dark may take a quarter of a second, and a robot may read it after its others.
const STALE_NS: u64 = 1_000_000_000;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_body::{body, turn};

    #[test]
    fn sides_are_those_of_the_sensors_headings() {
        let body = body(&[("a", "light", 0.5), ("b", "light", -0.5), ("c", "light", 5.9), ("d", "ir", 0.0)]);
        let mut sense = Sense::new(&body, &[SensorKind::Field, SensorKind::Light]).unwrap();
        assert!(sense.is_numb(0));
        assert!(sense.look(&turn(&body, 5, &[Some(&[4.0]), Some(&[1.0]), Some(&[3.0]), Some(&[9.0])])));
        assert_eq!(sense.sides(), Some(Sides { left: 4.0, right: 2.0 }));
        assert_eq!(sense.mean(), 8.0 / 3.0);
        assert!(!sense.is_numb(STALE_NS) && sense.is_numb(STALE_NS + 6));
        assert!(!sense.look(&turn(&body, 6, &[None, None, None, Some(&[9.0])])), "no news of light");
        assert_eq!(Sense::new(&body, &[SensorKind::Field, SensorKind::Photoresistor]), None);
    }

    #[test]
    fn one_sensor_has_no_sides() {
        let body = body(&[("eye", "photoresistor", 0.0)]);
        let mut sense = Sense::new(&body, &[SensorKind::Light, SensorKind::Photoresistor]).unwrap();
        let mut see = |counts: f64| {
            sense.look(&turn(&body, 0, &[Some(&[counts])]));
            (sense.mean(), sense.sides())
        };
        assert_eq!([see(10.0), see(500.0), see(0.0)], [(100.0, None), (2.0, None), (0.0, None)]);
    }
}
