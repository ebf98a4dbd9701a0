//! Gyroscope (§1.2.2): the turn rate.
//!
//! Deviation: the notes say that a gyroscope measures angular acceleration. A rate gyroscope measures
//! angular velocity.

use alloc::vec;
use alloc::vec::Vec;

use serde::Deserialize;

use super::Measurement;
use super::kind::{Built, Component, Effect, Fit, Place, Sense, levels};
use super::lowpass::{LowPass, time_constant_s};
use crate::random::Stream;
use baudbot_fields::number::{Number, Positive};
use baudbot_fields::{FieldError, Path};

/// The model of a gyroscope.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Gyroscope {
    /// Largest reading, in either direction.
    #[serde(with = "Number::<Positive>")]
    pub range_rad_s: f64,
    /// Bandwidth of the sensor, a first-order low-pass filter. Without it, readings follow immediately.
    pub bandwidth_hz: Option<Number<Positive>>,
}

impl Sense for Gyroscope {
    const NAME: &str = "gyroscope";
    const PLACE: Place = Place::Inside;
    type Sheet = Self;
    type Memory = LowPass;

    fn new(sheet: Self, _: &Path, fit: Fit<'_>) -> Result<Built<Self>, FieldError> {
        let encodings = levels(fit.bits, 1, -sheet.range_rad_s, sheet.range_rad_s);
        Ok(Built::new(sheet, encodings))
    }

    fn components(&self) -> Vec<Component> {
        vec![Component::one("", "rad/s")]
    }

    /// Turn rate in rad/s, positive to the left.
    fn read(&self, at: &Measurement<'_>, filter: &mut LowPass, _: &mut Stream, values: &mut [f64]) -> Effect {
        values[0] = filter.follow(at.over_ground().turn, time_constant_s(self.bandwidth_hz), at.now);
        Effect::NONE
    }

    fn bound(&self, values: &mut [f64]) {
        values[0] = values[0].clamp(-self.range_rad_s, self.range_rad_s);
    }
}
