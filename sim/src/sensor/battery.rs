//! Battery gauge: the voltage at the terminals, and how much charge is left.

use super::Measurement;

/// A gauge on the robot's battery.
#[derive(Clone, Debug, PartialEq)]
pub struct BatteryGauge;

impl BatteryGauge {
    /// Voltage in volts, and the share of the capacity that is left. A robot with a gauge has a battery.
    pub(super) fn read(at: &Measurement<'_>) -> [f64; 2] {
        match (&at.robot.battery, at.battery) {
            (Some(battery), Some(state)) => [state.terminal_v(battery), state.share(battery)],
            _ => [0.0, 0.0],
        }
    }
}
