//! Fields and sounds: scent, temperature, or any scalar that fills the plane; and the loudness of what robots
//! say.

use alloc::format;
use alloc::string::String;
use alloc::vec;
use alloc::vec::Vec;

use serde::Deserialize;

use super::kind::{Built, Component, Effect, Fit, Place, Sense, levels, maximum};
use super::style::{Style, Symbol};
use super::{Measurement, Mount};
use crate::random::Stream;
use baudbot_fields::number::{Number, Positive};
use baudbot_fields::{FieldError, Path};

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
        values[0] = at.scene.surroundings.fields[self.field].at(pose.position);
        Effect::NONE
    }
}

/// The loudness: sounds fall off with the distance, and their loudness adds up. Walls do not muffle them.
#[derive(Clone, Debug, PartialEq)]
pub struct Microphone;

/// The fields of its table.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct MicrophoneSheet {
    /// Value of the largest code. Default: required with `bits`.
    max: Option<Number<Positive>>,
}

impl Sense for Microphone {
    const NAME: &str = "microphone";
    const PLACE: Place = Place::Inside;
    const STYLE: Style = Style { color: "#aa4499", symbol: Symbol::Ring };
    type Sheet = MicrophoneSheet;
    type Memory = ();

    fn new(sheet: MicrophoneSheet, path: &Path, fit: Fit<'_>) -> Result<Built<Self>, FieldError> {
        let encodings = levels(fit.bits, 1, 0.0, maximum(path, sheet.max, fit.bits)?);
        Ok(Built::new(Self, encodings))
    }

    fn components(&self) -> Vec<Component> {
        vec![Component::one("", "1")]
    }

    /// The sum of level / d over the other robots' sounds; 1 is a loudspeaker of level 1 at a metre.
    fn read(&self, at: &Measurement<'_>, _: &mut (), _: &mut Stream, values: &mut [f64]) -> Effect {
        let here = at.motion.pose.position;
        let others = at.scene.frozen.sounds.iter().filter(|sound| sound.robot != at.scene.own);
        values[0] = others.map(|sound| sound.level / (sound.from - here).norm().max(NEAREST_M)).sum();
        Effect::NONE
    }

    fn bound(&self, values: &mut [f64]) {
        values[0] = values[0].max(0.0);
    }
}

/// A loudspeaker is no point: nearer than this it gets no louder.
const NEAREST_M: f64 = 0.01;
