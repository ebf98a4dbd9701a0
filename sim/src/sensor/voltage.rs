//! Distance sensor with a voltage for its output, such as Sharp's GP2D12 (§1.2.2): the nearer, the higher,
//! but below some centimetres the voltage falls again, so that 3 cm can look like 20.
//!
//! The distance is that of the ray that comes back first. Such a sensor measures at its own pace and holds its
//! output in between: its scenario gives it an own clock.

use alloc::vec::Vec;

use baudbot_geometry::Fan;

use super::{Measurement, Mount};

/// What a voltage sensor is.
#[derive(Clone, Debug, PartialEq)]
pub struct VoltageRanger {
    /// Where it sits.
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

impl VoltageRanger {
    /// The voltage, in volts.
    pub(super) fn read(&self, at: &Measurement<'_>) -> f64 {
        let pose = self.mount.world_from_sensor(at);
        let eye = self.mount.look(at, &pose, self.range_m);
        let nearest = eye.nearest(&pose, &self.fan);
        nearest.map_or(self.idle_v, |distance_m| self.voltage_at(distance_m))
    }

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
