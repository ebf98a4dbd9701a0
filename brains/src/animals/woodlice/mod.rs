//! Wood lice: kinesis. Wahde 2016, §4.4.2.
//!
//! In the damp, which they favour, wood lice move very little; where it is dry they move more. They do not know
//! where it is damp, and they do not turn to it. Yet most of them are found there, simply because they leave it
//! slowly.
//!
//! The notes do not say in which way the activity depends on the humidity; here the speed changes in a straight line
//! between two humidities. Turning is at random and the same everywhere. Then lice are exactly as dense as they are
//! slow: with a density in proportion to 1/v(x) as many leave a place as come to it. The test compares with that.

pub(crate) mod brain;

pub use brain::{Parameters as BrainParameters, WoodlouseBrain};

use super::wheel_commands::Motion;
use crate::Chance;

/// The properties of a louse. The unit of humidity is that of the sensor; by default it is a part of 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// Humidity up to which it is as quick as it can be.
    pub dry: f64,
    /// Humidity from which it is as slow as it gets; above `dry`.
    pub damp: f64,
    /// Speed in the dry, in m/s.
    pub dry_speed_m_s: f64,
    /// Speed in the damp, in m/s.
    pub damp_speed_m_s: f64,
    /// Largest rate of turning, either way, in rad/s.
    pub turn_rad_s: f64,
    /// The rate at which it changes its rate of turning, per second.
    pub turn_hz: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        Self { dry: 0.2, damp: 0.8, dry_speed_m_s: 0.3, damp_speed_m_s: 0.03, turn_rad_s: 1.5, turn_hz: 1.0 }
    }
}

/// A louse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Woodlouse {
    parameters: Parameters,
    turn_rate_rad_s: f64,
}

impl Woodlouse {
    /// A louse that goes straight on at first.
    pub fn new(parameters: Parameters) -> Self {
        Self { parameters, turn_rate_rad_s: 0.0 }
    }

    /// The woodlouse's speed at a humidity, in m/s.
    pub fn speed_m_s(&self, humidity: f64) -> f64 {
        let p = self.parameters;
        // Never a division by 0: without a range it changes at a step.
        let range = (p.damp - p.dry).max(f64::MIN_POSITIVE);
        let part = ((humidity - p.dry) / range).clamp(0.0, 1.0);
        p.dry_speed_m_s + part * (p.damp_speed_m_s - p.dry_speed_m_s)
    }

    /// The woodlouse's motion for `dt_s` seconds.
    pub fn step(&mut self, humidity: f64, dt_s: f64, chance: &mut Chance) -> Motion {
        if chance.happens(self.parameters.turn_hz * dt_s) {
            self.turn_rate_rad_s = self.parameters.turn_rad_s * (2.0 * chance.uniform() - 1.0);
        }
        Motion { speed_m_s: self.speed_m_s(humidity), turn_rate_rad_s: self.turn_rate_rad_s }
    }
}

#[cfg(test)]
mod tests {
    use baudbot_geometry::math;

    use super::*;

    #[test]
    fn a_louse_is_quick_in_the_dry_and_slow_in_the_damp() {
        let louse = Woodlouse::new(Parameters::default());
        let speeds = [0.0, 0.2, 0.5, 0.8, 1.0].map(|humidity| louse.speed_m_s(humidity));
        let figures = [0.3, 0.3, 0.165, 0.03, 0.03];
        assert!(
            speeds.iter().zip(figures).all(|(speed, figure)| (speed - figure).abs() < 1e-12),
            "{speeds:?}"
        );
        let abrupt = Woodlouse::new(Parameters { dry: 0.5, damp: 0.5, ..Parameters::default() });
        let speeds = [0.4, 0.5, 0.6].map(|humidity| abrupt.speed_m_s(humidity));
        assert!(speeds[0] == 0.3 && speeds[1] == 0.3 && (speeds[2] - 0.03).abs() < 1e-12, "{speeds:?}");
    }

    /// Part of the time that lice spend in the damp half of a box whose walls reflect them.
    fn part_in_damp(parameters: Parameters) -> f64 {
        let mut chance = Chance::new(5, "lice");
        let (mut damp, mut all) = (0.0, 0.0);
        for _ in 0..40 {
            let mut louse = Woodlouse::new(parameters);
            let (mut x, mut heading) = (2.0 * chance.uniform() - 1.0, 7.0 * chance.uniform());
            for step in 0..20_000 {
                let motion = louse.step(f64::from(x > 0.0), 0.05, &mut chance);
                x += motion.speed_m_s * math::cos(heading) * 0.05;
                heading += motion.turn_rate_rad_s * 0.05;
                if x.abs() > 1.0 {
                    x = x.signum() * 2.0 - x;
                    heading = std::f64::consts::PI - heading;
                }
                // The start is forgotten by then.
                if step > 4000 {
                    damp += f64::from(x > 0.0);
                    all += 1.0;
                }
            }
        }
        damp / all
    }

    /// Kinesis (§4.4.2) gathers them in the damp.
    #[test]
    fn lice_are_as_dense_as_they_are_slow() {
        let slow = Parameters { damp_speed_m_s: 0.1, ..Parameters::default() };
        // Three times as slow, so three times as many.
        let part = part_in_damp(slow);
        assert!((part - 0.75).abs() < 0.03, "{part}");
        let same = Parameters { damp_speed_m_s: 0.3, ..Parameters::default() };
        let part = part_in_damp(same);
        assert!((part - 0.5).abs() < 0.03, "{part}");
    }
}
