//! Distance sensor with a voltage for its output, such as Sharp's GP2D12 (§1.2.2): the nearer, the higher,
//! but below some centimetres the voltage falls again, so that 3 cm can look like 8.
//!
//! The distance is that of the ray that comes back first. Such a sensor measures at its own pace and holds its
//! output in between: its scenario gives it an own clock.

use alloc::format;
use alloc::vec;
use alloc::vec::Vec;
use core::f64::consts::PI;

use baudbot_geometry::Fan;
use serde::Deserialize;

use super::kind::{Built, Component, Effect, Fit, Place, Sense, fan, levels};
use super::style::Style;
use super::{Measurement, Mount};
use crate::random::Stream;
use baudbot_fields::{FieldError, Path};

/// The model of a voltage sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct VoltageRanger {
    /// The place.
    pub mount: Mount,
    /// The rays over its narrow beam.
    pub fan: Fan,
    /// Farthest distance at which anything comes back, in metres.
    pub range_m: f64,
    /// Distance in metres, increasing, and voltage there; straight lines between, the ends beyond.
    pub curve: Vec<(f64, f64)>,
    /// Voltage when nothing comes back.
    pub idle_v: f64,
    /// No output is higher.
    pub supply_v: f64,
}

/// The fields of its table.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Sheet {
    /// Opening angle of its beam. Range: 0 to π.
    opening_rad: f64,
    /// Rays over it. The nearest counts. Range: 1 to 10,000.
    rays: u64,
    /// Beyond this nothing comes back. Range: 10^−6 to 10^6.
    range_m: f64,
    /// Straight lines in between, the ends beyond. Type: list of `[distance, voltage]`. Range: at least 2
    /// points; distances not negative, increasing; voltages not negative.
    curve_m_v: Vec<[f64; 2]>,
    /// Voltage when nothing comes back. Range: 0 to `supply_v`.
    idle_v: f64,
    /// No output is higher. Range: positive.
    supply_v: f64,
}

impl Sense for VoltageRanger {
    const NAME: &str = "ir-voltage";
    const PLACE: Place = Place::Mounted;
    const STYLE: Style = Style::dot("#ee8800");
    type Sheet = Sheet;
    type Memory = ();

    fn new(sheet: Sheet, path: &Path, fit: Fit<'_>) -> Result<Built<Self>, FieldError> {
        check_curve(&path.field("curve_m_v"), &sheet.curve_m_v)?;
        let supply_v = path.positive("supply_v", sheet.supply_v)?;
        let device = Self {
            mount: fit.mount,
            fan: fan(path, sheet.opening_rad, PI, sheet.rays)?,
            range_m: path.length("range_m", sheet.range_m)?,
            curve: sheet.curve_m_v.into_iter().map(|[d, v]| (d, v)).collect(),
            idle_v: path.within("idle_v", sheet.idle_v, 0.0, supply_v)?,
            supply_v,
        };
        Ok(Built::new(device, levels(path, fit.bits, 1, 0.0, supply_v)?))
    }

    fn components(&self) -> Vec<Component> {
        vec![Component::one("", "V")]
    }

    fn mount(&self) -> Option<&Mount> {
        Some(&self.mount)
    }

    fn range_m(&self) -> Option<f64> {
        Some(self.range_m)
    }

    fn fan(&self) -> Option<&Fan> {
        Some(&self.fan)
    }

    /// The voltage, in volts.
    fn read(&self, at: &Measurement<'_>, _: &mut (), _: &mut Stream, values: &mut [f64]) -> Effect {
        let pose = self.mount.world_from_sensor(at);
        let viewpoint = self.mount.look(at, &pose, self.range_m);
        let nearest = viewpoint.nearest(&pose, &self.fan);
        values[0] = nearest.map_or(self.idle_v, |distance_m| self.voltage_at(distance_m));
        Effect::NONE
    }

    fn bound(&self, values: &mut [f64]) {
        values[0] = values[0].clamp(0.0, self.supply_v);
    }
}

fn check_curve(at: &Path, curve: &[[f64; 2]]) -> Result<(), FieldError> {
    if curve.len() < 2 {
        return Err(at.error(format!("needs at least 2 pairs of distance and voltage, has {}", curve.len())));
    }
    for (i, pair) in curve.iter().enumerate() {
        at.index(i).not_negative("distance", pair[0])?;
        at.index(i).not_negative("voltage", pair[1])?;
        if i > 0 && pair[0] <= curve[i - 1][0] {
            let problem = format!("distances must increase, {} follows {}", pair[0], curve[i - 1][0]);
            return Err(at.index(i).error(problem));
        }
    }
    Ok(())
}

impl VoltageRanger {
    /// The curve at a distance in metres.
    pub fn voltage_at(&self, distance_m: f64) -> f64 {
        let after = self.curve.partition_point(|(d, _)| *d <= distance_m);
        if after == 0 {
            return self.curve[0].1;
        }
        let (d0, v0) = self.curve[after - 1];
        let Some(&(d1, v1)) = self.curve.get(after) else { return v0 };
        v0 + (distance_m - d0) / (d1 - d0) * (v1 - v0)
    }
}
