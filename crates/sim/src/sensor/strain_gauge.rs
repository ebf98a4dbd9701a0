//! Strain gauge: the force on a bar along the robot's rim, which bends what the bar is fixed to (Section 1.2.2).
//!
//! What stands in the robot's way takes from it the impulse J = M' (V − V'), of the speed V that the motors had given it and V' that is left,
//! with the mass M' = M / (A r) that the torques of the wheels accelerate (2.26). Over the time T since the last read the force is
//!
//! F = Σ J / T
//!
//! and for a robot that a wall holds this is (τ_L + τ_R) / r. A low-pass filter of first order with the time constant 1 / (2π f) follows; a bridge
//! of gauges tells F U / F_max, in mV a volt of its supply.
//!
//! Deviations. The notes name the sensor and say no more. The world knows impulses, and no forces: a stop from full speed is a peak as high as the
//! time T and the filter let it be. The force is that along the robot's heading: a bar feels all of it if anything is within its travel, and nothing of
//! what it touches with its side. Only who drives against something feels it; a robot that another one runs into does not. Servos and stepper motors have
//! no torque here: they push with the mass times the rate at which their own lag or acceleration lets them gain speed. A run that ends with a collision
//! ends before it is felt.

use alloc::vec;
use alloc::vec::Vec;

use baudbot_geometry::{Fan, math};
use serde::{Deserialize, Serialize};

use super::kind::{Built, Component, Effect, Fit, Place, Rays, Sense, levels};
use super::lowpass::{LowPass, time_constant_s};
use super::style::{Style, Symbol};
use super::touch::travel_m;
use super::{Measurement, Mount};
use crate::random::Stream;
use crate::time::{SECOND_NS, SimTime};
use baudbot_fields::number::{Length, Number, Opening, Positive};
use baudbot_fields::{FieldError, Path};

/// The model of a bar on strain gauges.
#[derive(Clone, Debug, PartialEq)]
pub struct StrainGauge {
    /// In the robot's centre, looking at the middle of the bar.
    pub mount: Mount,
    /// Directions in which the bar is touched.
    pub fan: Fan,
    /// The travel of the bar, in metres.
    pub travel_m: f64,
    /// The largest force that it can tell, in N.
    pub range_n: f64,
    /// The reading at that force, in mV/V, if it is the bridge's; else readings are in N.
    pub bridge_mv_v: Option<f64>,
    /// The time constant of its filter, in seconds.
    pub time_constant_s: f64,
}

/// The impulse up to the tick of the last read, and what was made of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Load {
    impulse_n_s: f64,
    at: SimTime,
    force_n: f64,
    filter: LowPass,
}

impl Load {
    pub(super) fn is_sound(&self) -> bool {
        crate::sound::numbers([self.impulse_n_s, self.force_n]) && self.filter.is_sound()
    }
}

/// The fields of its table.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Sheet {
    /// Angle of the rim that the bar covers, centred on its bearing.
    opening_rad: Number<Opening>,
    /// Number of directions, from the robot's centre, in which the bar feels.
    #[serde(default = "Rays::constant::<9>")]
    rays: Rays,
    /// Distance from the rim within which something presses the bar, as that of a [bumper](#kind--bumper-a-bar-on-the-rim).
    #[serde(default = "travel_m")]
    travel_m: Number<Length>,
    /// Largest force that it can tell.
    range_n: Number<Positive>,
    /// Output of the bridge at that force, in mV for each volt of its supply. With it readings are in mV/V. Default: none; readings are in N.
    bridge_mv_v: Option<Number<Positive>>,
    /// Bandwidth of the amplifier, a first-order low-pass filter. Without it, readings follow immediately.
    bandwidth_hz: Option<Number<Positive>>,
}

impl Sense for StrainGauge {
    const NAME: &str = "strain-gauge";
    const PLACE: Place = Place::Rim;
    const STYLE: Style = Style { color: "#aa3377", symbol: Symbol::Arc };
    type Sheet = Sheet;
    type Memory = Load;

    fn new(sheet: Sheet, _: &Path, fit: Fit<'_>) -> Result<Built<Self>, FieldError> {
        let device = Self {
            mount: fit.mount,
            fan: Fan::new(sheet.opening_rad.get(), sheet.rays.get().into()),
            travel_m: sheet.travel_m.get(),
            range_n: sheet.range_n.get(),
            bridge_mv_v: sheet.bridge_mv_v.map(Number::get),
            time_constant_s: time_constant_s(sheet.bandwidth_hz),
        };
        let encodings = levels(fit.bits, 1, 0.0, device.full_scale());
        Ok(Built::new(device, encodings))
    }

    fn components(&self) -> Vec<Component> {
        vec![Component::one("", if self.bridge_mv_v.is_some() { "mV/V" } else { "N" })]
    }

    fn mount(&self) -> Option<&Mount> {
        Some(&self.mount)
    }

    fn fan(&self) -> Option<&Fan> {
        Some(&self.fan)
    }

    /// The force, in N, or the output of the bridge, in mV/V.
    fn read(&self, at: &Measurement<'_>, load: &mut Load, _: &mut Stream, values: &mut [f64]) -> Effect {
        // The scene is that of the tick's start, and so are the impulses.
        let seconds = at.tick_start.since(load.at) as f64 / SECOND_NS as f64;
        if seconds > 0.0 {
            let [front_n_s, back_n_s] = at.impulses_n_s;
            let impulse_n_s = if math::cos(self.mount.pose.heading) >= 0.0 { front_n_s } else { back_n_s };
            let all_n = (impulse_n_s - load.impulse_n_s) / seconds;
            load.force_n = if all_n > 0.0 && self.is_touched(at) { all_n } else { 0.0 };
            (load.impulse_n_s, load.at) = (impulse_n_s, at.tick_start);
        }
        let force_n = load.filter.follow(load.force_n, self.time_constant_s, at.now);
        values[0] = force_n * self.full_scale() / self.range_n;
        Effect::NONE
    }

    fn bound(&self, values: &mut [f64]) {
        values[0] = values[0].clamp(0.0, self.full_scale());
    }
}

impl StrainGauge {
    /// The largest reading.
    fn full_scale(&self) -> f64 {
        self.bridge_mv_v.unwrap_or(self.range_n)
    }

    fn is_touched(&self, at: &Measurement<'_>) -> bool {
        let pose = self.mount.world_from_sensor(at);
        let viewpoint = self.mount.look(at, &pose, at.drive.radius_m + self.travel_m);
        viewpoint.nearest(&pose, &self.fan).is_some()
    }
}
