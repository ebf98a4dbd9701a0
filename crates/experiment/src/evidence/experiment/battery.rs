//! A battery that is discharged at a constant current.

use baudbot_sim::battery::{Battery, BatteryState};
use serde::Deserialize;

use super::{ExperimentError, lab};

/// A full battery of a preset.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Discharge {
    /// The preset of the battery.
    pub preset: String,
    /// The battery's nominal capacity here, in mAh.
    pub capacity_mah: f64,
    /// Number of cells in series.
    pub cells: f64,
    /// The quantity that is compared.
    pub of: Quantity,
}

/// A quantity of a discharge that is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Quantity {
    /// The charge that it gave, in mAh.
    Charge,
    /// The mean voltage of a cell, in V.
    Voltage,
}

impl Discharge {
    /// The values of a discharge at so many amperes.
    pub(super) fn run(&self, current_a: f64) -> Result<Vec<f64>, ExperimentError> {
        let toml = format!(
            "[[robots]]\nname = \"robot\"\nbattery = {{ preset = \"{}\", capacity_mah = {:?} }}\n{}\n",
            self.preset,
            self.capacity_mah,
            lab::DISC
        );
        let world = lab::specimens(&toml, 1)?.next();
        let given = world.and_then(|world| {
            let (battery, full) = world.robot(0).battery()?;
            Some(self.discharge(battery, *full, current_a))
        });
        Ok(given.into_iter().collect())
    }

    fn discharge(&self, battery: &Battery, mut state: BatteryState, current_a: f64) -> f64 {
        let mut seconds = 0.0;
        while state.charge_c > 0.0 {
            let open_v = battery.open_circuit_v(state.charge_c / battery.capacity_c());
            let power_w = current_a * (open_v - current_a * battery.internal_resistance_ohm);
            if power_w <= 0.0 || state.draw(battery, power_w, STEP_S) <= 0.0 {
                break;
            }
            seconds += STEP_S;
        }
        match self.of {
            Quantity::Charge => current_a * seconds / 3.6,
            Quantity::Voltage => state.used_j / (current_a * seconds) / self.cells,
        }
    }
}

/// Length of a step, in seconds.
const STEP_S: f64 = 0.1;
