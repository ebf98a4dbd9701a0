//! Battery gauge: the voltage at the terminals, and how much charge is left.

use alloc::vec;
use alloc::vec::Vec;

use super::Measurement;
use super::kind::{Built, Component, Effect, Fit, NoFields, Place, Sense, level};
use crate::random::Stream;
use baudbot_fields::{FieldError, Path};

/// A gauge on the robot's battery.
#[derive(Clone, Debug, PartialEq)]
pub struct BatteryGauge;

impl Sense for BatteryGauge {
    const NAME: &str = "battery";
    const PLACE: Place = Place::Inside;
    type Sheet = NoFields;
    type Memory = ();

    fn new(_: NoFields, path: &Path, fit: Fit<'_>) -> Result<Built<Self>, FieldError> {
        let battery = fit.battery.ok_or_else(|| path.error("the robot has no `battery` to gauge"))?;
        let voltage = level(fit.bits, 0.0, 2.0 * battery.nominal_v);
        Ok(Built::new(Self, vec![voltage, level(fit.bits, 0.0, 1.0)]))
    }

    fn components(&self) -> Vec<Component> {
        vec![Component::one("voltage_v", "V"), Component::one("charge", "1")]
    }

    /// Voltage in volts, and the share of the capacity that is left. A robot with a gauge has a battery.
    fn read(&self, at: &Measurement<'_>, _: &mut (), _: &mut Stream, values: &mut [f64]) -> Effect {
        if let Some((battery, state)) = at.battery {
            values.copy_from_slice(&[state.terminal_v(battery), state.share(battery)]);
        }
        Effect::NONE
    }

    fn bound(&self, values: &mut [f64]) {
        values[0] = values[0].max(0.0);
        values[1] = values[1].clamp(0.0, 1.0);
    }
}
