//! Distance sensor with a voltage for its output, such as Sharp's GP2D12 (§1.2.2): the nearer, the higher,
//! but below some centimetres the voltage falls again, so that 3 cm can look like 8.
//!
//! The distance is that of the ray that comes back first. Such a sensor measures at its own pace and holds its
//! output in between: its scenario gives it an own clock.

use alloc::format;
use alloc::vec;
use alloc::vec::Vec;

use baudbot_geometry::Fan;
use serde::Deserialize;

use super::kind::{Built, Component, Effect, Fit, Place, Rays, Sense, levels};
use super::style::Style;
use super::{Measurement, Mount};
use crate::curve;
use crate::random::Stream;
use baudbot_fields::number::{HalfOpening, Length, NotNegative, Number, Positive};
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
    /// Supply voltage, which limits the output.
    pub supply_v: f64,
}

/// The fields of its table.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Sheet {
    /// Opening angle of the beam.
    opening_rad: Number<HalfOpening>,
    /// Number of rays over the beam; the nearest hit counts.
    rays: Rays,
    /// Distance beyond which nothing comes back.
    range_m: Number<Length>,
    /// Voltage over distance: linear between the points, constant beyond the ends. Type: list of `[distance,
    /// voltage]`. Range: at least 2 points; distances not negative, increasing; voltages not negative.
    #[cfg_attr(
        feature = "schema",
        schemars(with = "curve::Points<NotNegative, NotNegative>", length(min = 2))
    )]
    curve_m_v: Vec<(f64, f64)>,
    /// Voltage when nothing comes back. Range: to `supply_v`.
    idle_v: Number<NotNegative>,
    /// Supply voltage, which limits the output.
    supply_v: Number<Positive>,
}

impl Sense for VoltageRanger {
    const NAME: &str = "ir-voltage";
    const PLACE: Place = Place::Mounted;
    const TILTS: bool = true;
    const STYLE: Style = Style::dot("#ee8800");
    type Sheet = Sheet;
    type Memory = ();

    fn new(sheet: Sheet, path: &Path, fit: Fit<'_>) -> Result<Built<Self>, FieldError> {
        let at = path.field("curve_m_v");
        if sheet.curve_m_v.len() < 2 {
            let points = sheet.curve_m_v.len();
            return Err(at.error(format!("needs at least 2 pairs of distance and voltage, has {points}")));
        }
        curve::check::<NotNegative, NotNegative>(&at, &sheet.curve_m_v, ["distance", "voltage"])?;
        let supply_v = sheet.supply_v.get();
        let device = Self {
            mount: fit.mount,
            fan: Fan::new(sheet.opening_rad.get(), sheet.rays.get().into()),
            range_m: sheet.range_m.get(),
            curve: sheet.curve_m_v,
            idle_v: path.within("idle_v", sheet.idle_v.get(), 0.0, supply_v)?,
            supply_v,
        };
        Ok(Built::new(device, levels(fit.bits, 1, 0.0, supply_v)))
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
