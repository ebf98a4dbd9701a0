//! Fields and sounds: scent, temperature, or any scalar that fills the plane; and the loudness of what robots
//! say (Section 1.2.3).
//!
//! A microphone hears L = Σ g(f) h(θ) level / d over the sounds of others, of the frequency f at the distance d. An omnidirectional one has h = 1, a cardioid
//! h = (1 + cos θ) / 2 for a sound that comes at an angle of θ to its axis. With a band from f₁ to f₂ it passes
//!
//! g = 1 within the band, (f / f₁)² below it and (f₂ / f)² above
//!
//! which falls by 12 dB an octave, as behind a filter of second order on each side; without a band, and of sounds without a frequency, g is 1.
//!
//! Deviations. The notes name microphones and speakers and compute nothing. Loudnesses add up as numbers, whatever their phases. A tone has one frequency, the scenario's, and no
//! harmonics; a filter's corner is sharp, where a real one has lost 3 dB. Sound needs no time, and walls do not muffle it.

use alloc::format;
use alloc::string::String;
use alloc::vec;
use alloc::vec::Vec;

use serde::Deserialize;

use super::kind::{Built, Component, Effect, Fit, Place, Sense, levels, maximum};
use super::style::{Style, Symbol};
use super::{Measurement, Mount};
use crate::random::Stream;
use crate::scene::Sound;
use baudbot_fields::number::{Between, Number, Positive};
use baudbot_fields::{FieldError, Path};
use baudbot_geometry::math;

/// A sensor of one of the scenario's fields.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldSensor {
    /// The place and the direction.
    pub mount: Mount,
    /// The field, by its place in the surroundings.
    pub field: usize,
}

/// The fields of its table.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct FieldSheet {
    /// The field that the sensor measures. Range: name of one of the arena's fields.
    field: String,
    /// Value of the largest code. Default: required with `bits`.
    max: Option<Number<Positive>>,
}

impl Sense for FieldSensor {
    const NAME: &str = "field";
    const PLACE: Place = Place::Mounted;
    const STYLE: Style = Style::dot("#44aa99");
    type Sheet = FieldSheet;
    type Memory = ();

    fn new(sheet: FieldSheet, path: &Path, fit: Fit<'_>) -> Result<Built<Self>, FieldError> {
        let fields = &fit.surroundings.fields;
        let field = fields.iter().position(|field| field.name == sheet.field).ok_or_else(|| {
            let names: Vec<_> = fields.iter().map(|field| field.name.as_str()).collect();
            let problem = match names.join(", ") {
                none if none.is_empty() => {
                    format!("the arena has no field `{}`, it has none at all", sheet.field)
                }
                names => format!("the arena has no field `{}`; there are: {names}", sheet.field),
            };
            path.field("field").error(problem)
        })?;
        let encodings = levels(fit.bits, 1, 0.0, maximum(path, sheet.max, fit.bits)?);
        Ok(Built::new(Self { mount: fit.mount, field }, encodings))
    }

    fn components(&self) -> Vec<Component> {
        vec![Component::one("", "1")]
    }

    fn mount(&self) -> Option<&Mount> {
        Some(&self.mount)
    }

    /// The field's value, in its own unit.
    fn read(&self, at: &Measurement<'_>, _: &mut (), _: &mut Stream, values: &mut [f64]) -> Effect {
        let pose = self.mount.world_from_sensor(at);
        let field = &at.scene.surroundings.fields[self.field];
        let laid = field.trail.as_ref().zip(at.scene.trails.get(self.field));
        values[0] = field.at(pose.position) + laid.map_or(0.0, |(grid, cells)| grid.at(cells, pose.position));
        Effect::NONE
    }
}

/// The loudness: sounds fall off with the distance, and their loudness adds up. Walls do not muffle them.
#[derive(Clone, Debug, PartialEq)]
pub struct Microphone {
    /// Least and greatest frequency that it passes as they are, in hertz; all if there is none.
    pub band_hz: Option<[f64; 2]>,
    /// The axis of a cardioid, from the robot's heading, in radians; it hears all around alike if there is none.
    pub axis_rad: Option<f64>,
}

/// The fields of its table.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct MicrophoneSheet {
    /// Value of the largest code. Default: required with `bits`.
    max: Option<Number<Positive>>,
    /// Least and greatest frequency of a band-pass filter, beyond which it loses 12 dB an octave. Type: `[low, high]`. Default: all are heard. Range: each
    /// above 0; increasing.
    band_hz: Option<[Number<Positive>; 2]>,
    /// Direction from the robot's heading in which a cardioid microphone hears best; half from the sides, nothing from behind. Default: it hears all around alike.
    axis_rad: Option<Number<Between<-10, 10>>>,
}

impl Sense for Microphone {
    const NAME: &str = "microphone";
    const PLACE: Place = Place::Inside;
    const STYLE: Style = Style { color: "#aa4499", symbol: Symbol::Ring };
    type Sheet = MicrophoneSheet;
    type Memory = ();

    fn new(sheet: MicrophoneSheet, path: &Path, fit: Fit<'_>) -> Result<Built<Self>, FieldError> {
        let encodings = levels(fit.bits, 1, 0.0, maximum(path, sheet.max, fit.bits)?);
        let band_hz = sheet.band_hz.map(|band| band.map(Number::get));
        if let Some([low, high]) = band_hz
            && low >= high
        {
            return Err(path.field("band_hz").error(format!("must increase, is {low} to {high}")));
        }
        let axis_rad = sheet.axis_rad.map(Number::get);
        Ok(Built::new(Self { band_hz, axis_rad }, encodings))
    }

    fn components(&self) -> Vec<Component> {
        vec![Component::one("", "1")]
    }

    /// The sum of g level / d over the other robots' sounds; 1 is a loudspeaker of level 1 at a metre.
    fn read(&self, at: &Measurement<'_>, _: &mut (), _: &mut Stream, values: &mut [f64]) -> Effect {
        let here = at.motion.pose.position;
        let others = at.scene.frozen.sounds.iter().filter(|sound| sound.robot != at.scene.own);
        let loudness = |sound: &Sound| sound.level / (sound.from - here).norm().max(NEAREST_M);
        let gain = |sound: &Sound| match self.axis_rad {
            None => self.gain(sound.frequency_hz),
            Some(axis_rad) => {
                let from = math::atan2(sound.from.y - here.y, sound.from.x - here.x);
                let cosine = math::cos(from - at.motion.pose.heading - axis_rad);
                self.gain(sound.frequency_hz) * (1.0 + cosine) / 2.0
            }
        };
        values[0] = others.map(|sound| gain(sound) * loudness(sound)).sum();
        Effect::NONE
    }

    fn bound(&self, values: &mut [f64]) {
        values[0] = values[0].max(0.0);
    }
}

impl Microphone {
    /// The part of a sound of this frequency that it passes: tones (§1.2.3).
    fn gain(&self, frequency_hz: Option<f64>) -> f64 {
        let (Some([low, high]), Some(frequency_hz)) = (self.band_hz, frequency_hz) else { return 1.0 };
        let ratio = (frequency_hz / low).min(high / frequency_hz).min(1.0);
        ratio * ratio
    }
}

/// A loudspeaker is no point: nearer than this it gets no louder.
const NEAREST_M: f64 = 0.01;
