//! DC motor with a gear box: Wahde 2016, Eqs. (1.8)–(1.10), §3.2.4. The dynamics of its winding, (1.1)–(1.7), are in
//! [`winding`](super::winding).
//!
//! Deviations. The gear box has an efficiency, as ARSim's has; the notes' ideal one has 1. Eq. (1.9) leaves
//! sgn(0) open: at standstill Coulomb friction opposes the torque and holds the motor up to its own size,
//! as in ARSim. The output torque is limited to ±τ_max, which §3.2.4 allows for.

use baudbot_fields::number::{NotNegative, Number, Positive, Share, UpTo};
use serde::Deserialize;

/// The model of a motor and its gear box. The defaults are ARSim's motor, made for a robot of a few kg.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DcMotor {
    /// Voltage at motor signal 1.
    #[serde(with = "Number::<Positive>")]
    pub voltage_v: f64,
    /// Torque constant c_t of Eq. (1.8), in N m / A.
    #[serde(with = "Number::<Positive>")]
    pub torque_constant_nm_a: f64,
    /// Back-EMF constant c_e of Eq. (1.8), in V s / rad.
    #[serde(with = "Number::<NotNegative>")]
    pub emf_constant_v_s: f64,
    /// Resistance R of Eq. (1.8).
    #[serde(with = "Number::<Positive>")]
    pub resistance_ohm: f64,
    /// Coulomb friction c_C of Eq. (1.9), at the motor's shaft.
    #[serde(with = "Number::<NotNegative>")]
    pub coulomb_friction_nm: f64,
    /// Viscous friction c_v of Eq. (1.9), at the motor's shaft.
    #[serde(with = "Number::<NotNegative>")]
    pub viscous_friction_nm_s: f64,
    /// Gear ratio G of Eq. (1.10): turns of the shaft per turn of the wheel.
    #[serde(with = "Number::<Positive>")]
    pub gear_ratio: f64,
    /// Fraction of the torque that the gear box transmits.
    #[serde(with = "Number::<UpTo<1>>")]
    pub gear_efficiency: f64,
    /// Inductance L of Eq. (1.1). With 0 the current follows the voltage at once, as in (1.8). Range: 0 for motors
    /// at the bridge of a chip.
    #[serde(with = "Number::<NotNegative>")]
    pub inductance_h: f64,
    /// Moment of inertia I of Eq. (1.5) of the rotor alone. With 0 it is neglected, as in (1.9).
    #[serde(with = "Number::<NotNegative>")]
    pub rotor_inertia_kg_m2: f64,
    /// Largest torque on the wheel.
    #[serde(with = "Number::<Positive>")]
    pub max_torque_nm: f64,
    /// ARSim's quirk: a command may exceed ±1. Without it such a command is rejected. Range: only without
    /// `signal_bits`.
    pub unlimited_signals: bool,
    /// Fraction of the half track from which the motor model computes the wheels' speeds; 0.5 is ARSim's quirk.
    #[serde(with = "Number::<Share>")]
    pub track_factor: f64,
}

impl Default for DcMotor {
    fn default() -> Self {
        Self {
            voltage_v: 12.0,
            torque_constant_nm_a: 0.0333,
            emf_constant_v_s: 0.0333,
            resistance_ohm: 0.62,
            coulomb_friction_nm: 0.008,
            viscous_friction_nm_s: 0.02,
            gear_ratio: 2.0,
            gear_efficiency: 1.0,
            inductance_h: 0.0,
            rotor_inertia_kg_m2: 0.0,
            max_torque_nm: 1.0,
            unlimited_signals: false,
            track_factor: 1.0,
        }
    }
}

impl DcMotor {
    /// Torque on the wheel, in N m, at motor signal `signal` (1 is full voltage forwards) and the wheel's
    /// speed in rad/s: (1.8), then friction (1.9), then gears (1.10), then the limit.
    pub fn torque_nm(&self, signal: f64, wheel_speed_rad_s: f64) -> f64 {
        let shaft_speed = self.gear_ratio * wheel_speed_rad_s;
        self.torque_of_voltage_nm(self.voltage_v * signal, self.emf_constant_v_s * shaft_speed, shaft_speed)
    }

    /// The same behind an H-bridge that leaves the motor open for a share of the time, in [0, 1], in which no current flows: the
    /// mean over that time.
    pub fn torque_of_bridge_nm(&self, signal: f64, wheel_speed_rad_s: f64, open: f64) -> f64 {
        let shaft_speed = self.gear_ratio * wheel_speed_rad_s;
        let back_emf = (1.0 - open) * self.emf_constant_v_s * shaft_speed;
        self.torque_of_voltage_nm(self.voltage_v * signal, back_emf, shaft_speed)
    }

    #[inline(always)]
    fn torque_of_voltage_nm(&self, voltage: f64, back_emf: f64, shaft_speed: f64) -> f64 {
        let generated = self.torque_constant_nm_a * (voltage - back_emf) / self.resistance_ohm;
        let shaft_torque = self.after_friction(generated, shaft_speed);
        let output = self.at_wheel_nm(shaft_torque);
        output.clamp(-self.max_torque_nm, self.max_torque_nm)
    }

    /// The torque on the wheel, in N m, of a torque on the shaft: (1.10).
    #[inline(always)]
    pub(super) fn at_wheel_nm(&self, shaft_nm: f64) -> f64 {
        self.gear_efficiency * self.gear_ratio * shaft_nm
    }

    /// The moment of inertia, in kg m², that the rotor adds to its wheel's: by (1.5) the gear gives the torque
    /// G (τ_g − τ_f − I dω/dt), and the shaft turns G times as fast as the wheel.
    pub fn inertia_at_wheel_kg_m2(&self) -> f64 {
        self.at_wheel_nm(self.gear_ratio * self.rotor_inertia_kg_m2)
    }

    /// The torque on the wheel that is lost for each rad/s of its speed, in N m s.
    pub(crate) fn slope_nm_s(&self) -> f64 {
        let back_emf = self.torque_constant_nm_a * self.emf_constant_v_s / self.resistance_ohm;
        let shaft = back_emf + self.viscous_friction_nm_s;
        self.gear_efficiency * self.gear_ratio * self.gear_ratio * shaft
    }

    /// Electrical power that it takes, in W: V i with the current i = (V − c_e ω) / R of (1.8). A current
    /// against the voltage brakes; it is burnt in the bridge and not given back, so it counts as 0.
    pub fn power_w(&self, signal: f64, wheel_speed_rad_s: f64) -> f64 {
        let voltage = self.voltage_v * signal;
        let back_emf = self.emf_constant_v_s * self.gear_ratio * wheel_speed_rad_s;
        (voltage * (voltage - back_emf) / self.resistance_ohm).max(0.0)
    }

    /// The same of a winding with an inductance, in which this current flows, in A.
    pub fn power_of_current_w(&self, signal: f64, current_a: f64) -> f64 {
        (self.voltage_v * signal * current_a).max(0.0)
    }

    /// (1.9), at the motor's shaft.
    fn after_friction(&self, generated: f64, shaft_speed: f64) -> f64 {
        if shaft_speed.abs() >= STANDSTILL {
            let coulomb = self.coulomb_friction_nm.copysign(shaft_speed);
            return generated - coulomb - self.viscous_friction_nm_s * shaft_speed;
        }
        if generated.abs() <= STANDSTILL {
            return generated;
        }
        (generated.abs() - self.coulomb_friction_nm).max(0.0).copysign(generated)
    }
}

/// Below this shaft speed (rad/s), or torque (N m), a motor counts as standing still, or unpowered; ARSim's
/// figure.
pub(super) const STANDSTILL: f64 = 1e-6;

#[cfg(test)]
mod tests {
    use super::DcMotor;

    fn arsim() -> DcMotor {
        DcMotor::default()
    }

    /// The friction of (1.9) and the limit of §3.2.4, in ARSim's numbers.
    #[test]
    fn dead_zone_and_torque_limit_at_standstill_are_arsims() {
        let motor = arsim();
        assert_eq!(motor.torque_nm(0.0124, 0.0), 0.0);
        assert!(motor.torque_nm(0.01242, 0.0) > 0.0);
        assert!(motor.torque_nm(0.787, 0.0) < 1.0);
        assert_eq!(motor.torque_nm(0.789, 0.0), 1.0);
        assert_eq!(motor.torque_nm(-0.789, 0.0), -1.0);
    }

    /// (1.8)–(1.10), term by term.
    #[test]
    fn a_turning_motor_loses_both_frictions_and_the_back_emf() {
        let motor = arsim();
        // Shaft at 10 rad/s, half voltage: (0.0333/0.62)(6 - 0.333) - 0.008 - 0.2, doubled by the gears.
        let expected = 2.0 * (0.0333 / 0.62 * (6.0 - 0.0333 * 10.0) - 0.008 - 0.2);
        assert!((motor.torque_nm(0.5, 5.0) - expected).abs() < 1e-15);
        assert!((motor.torque_nm(-0.5, -5.0) + expected).abs() < 1e-15);
    }

    #[test]
    fn power_is_voltage_times_current_and_braking_gives_none_back() {
        let motor = arsim();
        // Stalled at full voltage: 12² / 0.62.
        assert!((motor.power_w(1.0, 0.0) - 144.0 / 0.62).abs() < 1e-12);
        assert_eq!(motor.power_w(-1.0, 0.0), motor.power_w(1.0, 0.0));
        let turning = 12.0 * (12.0 - 0.0333 * 2.0 * 5.0) / 0.62;
        assert!((motor.power_w(1.0, 5.0) - turning).abs() < 1e-12);
        // Back EMF of 0.0333 · 2 · 100 = 6.66 V against 1.2 V.
        assert_eq!(motor.power_w(0.1, 100.0), 0.0);
        assert_eq!(motor.power_w(0.0, 100.0), 0.0);
    }
}
