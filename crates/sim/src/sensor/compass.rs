//! Compass (§1.2.2): the heading with additive Gaussian noise, as ARSim's, turned by iron nearby.
//!
//! ```text
//! φ_m = φ + h₁ sin(φ + ψ₁) + h₂ sin(2φ + ψ₂) − ω t
//! ```
//!
//! ω is 0 for a needle. A compass that goes by the sun, as that of the desert ant does (Wahde 2016, Section 4.4.4), has the rate of the sun's azimuth,
//! and the heading is counted from where the sun was at the start.
//!
//! Deviations: the notes give neither errors nor a rate. The azimuth changes evenly, as it nearly does at a pole.

use alloc::vec;
use alloc::vec::Vec;
use core::f64::consts::PI;

use baudbot_geometry::{angle, math};
use serde::Deserialize;

use super::Measurement;
use super::kind::{Built, Component, Effect, Fit, Place, Sense, levels};
use crate::random::Stream;
use baudbot_fields::number::{Number, Sigma, Turn};
use baudbot_fields::{FieldError, Path};

/// The model of a compass.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Compass {
    /// Error of a magnetised body: size and phase of a sine of the heading, in radians.
    pub hard_iron_rad: (f64, f64),
    /// Error of an iron body: size and phase of a sine of twice the heading, in radians.
    pub soft_iron_rad: (f64, f64),
    /// ω: the rate of the sun's azimuth, by which it goes, in rad/s counter-clockwise; 0 for a needle.
    pub sun_rad_s: f64,
}

/// The fields of its table.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Sheet {
    /// Short for `noise.additive`.
    sigma_rad: Number<Sigma>,
    /// Amplitude of the heading error from magnetised parts of the robot.
    hard_iron_rad: Number<Turn>,
    /// Phase of that error: it is `hard_iron_rad` · sin(heading + phase).
    hard_iron_phase_rad: Number<Turn>,
    /// Amplitude of the heading error from iron parts of the robot.
    soft_iron_rad: Number<Turn>,
    /// Phase of that error: it is `soft_iron_rad` · sin(2 · heading + phase).
    soft_iron_phase_rad: Number<Turn>,
    /// Rate of the sun's azimuth, counter-clockwise, of a compass that goes by the sun: the reading is less by the change since the start.
    sun_rad_s: Number<Turn>,
}

impl Sense for Compass {
    const NAME: &str = "compass";
    const PLACE: Place = Place::Inside;
    type Sheet = Sheet;
    type Memory = ();

    fn new(sheet: Sheet, _: &Path, fit: Fit<'_>) -> Result<Built<Self>, FieldError> {
        let device = Self {
            hard_iron_rad: (sheet.hard_iron_rad.get(), sheet.hard_iron_phase_rad.get()),
            soft_iron_rad: (sheet.soft_iron_rad.get(), sheet.soft_iron_phase_rad.get()),
            sun_rad_s: sheet.sun_rad_s.get(),
        };
        Ok(Built { additive: sheet.sigma_rad.get(), ..Built::new(device, levels(fit.bits, 1, -PI, PI)) })
    }

    fn components(&self) -> Vec<Component> {
        vec![Component::one("", "rad")]
    }

    /// Heading in radians, counter-clockwise from the x axis, before noise.
    fn read(&self, at: &Measurement<'_>, _: &mut (), _: &mut Stream, values: &mut [f64]) -> Effect {
        let heading = at.motion.pose.heading;
        let mut reading = heading;
        for ((size, phase), turns) in [(self.hard_iron_rad, 1.0), (self.soft_iron_rad, 2.0)] {
            if size != 0.0 {
                reading += size * math::sin(turns * heading + phase);
            }
        }
        if !at.scene.surroundings.zones.is_empty() {
            reading += at.scene.surroundings.compass_offset_at(at.motion.pose.position);
        }
        if self.sun_rad_s != 0.0 {
            reading -= self.sun_rad_s * at.now.as_seconds();
        }
        values[0] = reading;
        Effect::NONE
    }

    fn bound(&self, values: &mut [f64]) {
        values[0] = angle::wrap(values[0]);
    }
}
