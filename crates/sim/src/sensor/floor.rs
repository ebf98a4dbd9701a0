//! Floor sensor: how bright the floor is under it.

use alloc::vec;
use alloc::vec::Vec;

use super::kind::{Built, Component, Effect, Fit, NoFields, Place, Sense, levels};
use super::style::{Style, Symbol};
use super::{Measurement, Mount};
use crate::random::Stream;
use baudbot_fields::{FieldError, Path};

/// The model of a floor sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct FloorSensor {
    /// The place.
    pub mount: Mount,
}

impl Sense for FloorSensor {
    const NAME: &str = "floor";
    const PLACE: Place = Place::Mounted;
    const STYLE: Style = Style { color: "#117733", symbol: Symbol::Square };
    type Sheet = NoFields;
    type Memory = ();

    fn new(_: NoFields, _: &Path, fit: Fit<'_>) -> Result<Built<Self>, FieldError> {
        Ok(Built::new(Self { mount: fit.mount }, levels(fit.bits, 1, 0.0, 1.0)))
    }

    fn components(&self) -> Vec<Component> {
        vec![Component::one("", "1")]
    }

    fn mount(&self) -> Option<&Mount> {
        Some(&self.mount)
    }

    /// Reflectance in [0, 1], 1 for white.
    fn read(&self, at: &Measurement<'_>, _: &mut (), _: &mut Stream, values: &mut [f64]) -> Effect {
        values[0] = at.scene.surroundings.floor_at(self.mount.world_from_sensor(at).position);
        Effect::NONE
    }

    fn bound(&self, values: &mut [f64]) {
        values[0] = values[0].clamp(0.0, 1.0);
    }
}
