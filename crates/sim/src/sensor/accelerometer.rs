//! Accelerometer: the acceleration of the body along its heading and to its left (§1.2.2, Fig. 1.10).
//!
//! The mass on a spring feels the change of speed V̇ along the heading, and to the side V φ̇, since the body
//! drives along a curve. It sits in the robot's centre; the floor is level, so there is no gravity in it.
//! Collisions, which take a robot's speed away at once, are not felt.

use alloc::vec;
use alloc::vec::Vec;

use serde::Deserialize;

use super::Measurement;
use super::kind::{Built, Component, Effect, Fit, Place, Sense, levels};
use super::lowpass::{LowPass, time_constant_s};
use crate::random::Stream;
use baudbot_fields::number::{Number, Positive};
use baudbot_fields::{FieldError, Path};

/// The model of an accelerometer.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Accelerometer {
    /// Largest reading, in either direction.
    #[serde(with = "Number::<Positive>")]
    pub range_m_s2: f64,
    /// Bandwidth of the sensor, a first-order low-pass filter. Without it, readings follow immediately.
    pub bandwidth_hz: Option<Number<Positive>>,
}

impl Sense for Accelerometer {
    const NAME: &str = "accelerometer";
    const PLACE: Place = Place::Inside;
    type Sheet = Self;
    type Memory = [LowPass; 2];

    fn new(sheet: Self, _: &Path, fit: Fit<'_>) -> Result<Built<Self>, FieldError> {
        let encodings = levels(fit.bits, 2, -sheet.range_m_s2, sheet.range_m_s2);
        Ok(Built::new(sheet, encodings))
    }

    fn components(&self) -> Vec<Component> {
        vec![Component::one("forward_m_s2", "m/s^2"), Component::one("left_m_s2", "m/s^2")]
    }

    /// Forwards and to the left, in m/s².
    fn read(
        &self,
        at: &Measurement<'_>,
        filters: &mut [LowPass; 2],
        _: &mut Stream,
        values: &mut [f64],
    ) -> Effect {
        let motion = at.motion;
        let body = at.over_ground();
        let felt = [motion.acceleration_m_s2, body.forward * body.turn];
        let time_constant = time_constant_s(self.bandwidth_hz);
        for ((reading, filter), felt) in values.iter_mut().zip(filters).zip(felt) {
            *reading = filter.follow(felt, time_constant, at.now);
        }
        Effect::NONE
    }

    fn bound(&self, values: &mut [f64]) {
        values.iter_mut().for_each(|value| *value = value.clamp(-self.range_m_s2, self.range_m_s2));
    }
}
