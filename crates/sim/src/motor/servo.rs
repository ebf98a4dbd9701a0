//! Servo for continuous rotation (§1.2.3): the width of a pulse (Fig. 1.15) says how fast it turns.
//!
//! A signal becomes a pulse width about 1.5 ms, and a measured curve turns that into a speed, which the
//! servo approaches with a first-order lag. A new width takes effect with the next pulse.
//!
//! Deviations. The servo turns the wheel at its speed whatever the load, and never stops for want of
//! pulses. The notes have no servos; figures are of the Parallax 900-00008 (its data sheet; "Robotics with
//! the Boe-Bot", p. 115 to 117, for the transfer curve). The one of the two wheels that is mounted the other
//! way round is taken care of by the robot's firmware: signal 1 is forwards on both.

use alloc::vec::Vec;
use core::f64::consts::TAU;

use baudbot_fields::number::{Between, Millis, NotNegative, Number, Thousandths, UpTo};
use baudbot_fields::{FieldError, Path};
use baudbot_geometry::math;
use serde::Deserialize;

use super::frame;
use crate::curve;
use crate::time::SimTime;

/// The width of a pulse, in µs: none is longer than a second.
type Width = Between<0, 1_000_000>;
/// Turns a minute.
type Rpm = Between<-1_000_000, 1_000_000>;

/// The model of a servo for continuous rotation. The defaults are the Parallax 900-00008.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Servo {
    /// Speed in turns per minute over the pulse width in µs: linear between the points, constant beyond the ends.
    /// Type: list of `[width, speed]`. Default: the Parallax's: ±48 turns per minute, flat beyond 1.4 and 1.6 ms.
    /// Range: 1 to 1000 points; widths 0 to 10^6, increasing; speeds −10^6 to 10^6.
    #[cfg_attr(
        feature = "schema",
        schemars(with = "curve::Points<Width, Rpm>", length(min = 1, max = 1000))
    )]
    #[serde(rename = "curve_us_rpm")]
    pub curve: Vec<(f64, f64)>,
    /// Pulse width at signal 0.
    #[serde(with = "Number::<Width>")]
    pub neutral_us: f64,
    /// Increase of the pulse width from signal 0 to signal 1.
    #[serde(with = "Number::<UpTo<1_000_000>>")]
    pub half_range_us: f64,
    /// Pulses this close to the servo's own neutral width stop it.
    #[serde(with = "Number::<Width>")]
    pub dead_band_us: f64,
    /// Offset of the servo's own neutral width, adjusted by a screw, from `neutral_us`; positive if it is wider.
    #[serde(with = "Number::<Between<-1_000_000, 1_000_000>>")]
    pub trim_us: f64,
    /// Time constant of the servo's speed.
    #[serde(rename = "lag_ms", with = "Number::<Thousandths<Between<0, 1_000_000>>>")]
    pub lag_s: f64,
    /// Period of the pulses. A command takes effect with the next pulse; with 0, immediately.
    #[serde(rename = "frame_ms", with = "Number::<Millis<Between<0, 1000>>>")]
    pub frame_ns: u64,
    /// Electrical power at standstill.
    #[serde(with = "Number::<NotNegative>")]
    pub idle_w: f64,
    /// Electrical power while turning.
    #[serde(with = "Number::<NotNegative>")]
    pub running_w: f64,
}

impl Default for Servo {
    /// Times and dead band are guesses; 15 mA standing still and up to 200 mA turning, at 6 V.
    fn default() -> Self {
        Self {
            curve: Self::parallax_curve(),
            neutral_us: 1500.0,
            half_range_us: 200.0,
            dead_band_us: 5.0,
            trim_us: 0.0,
            lag_s: 0.06,
            frame_ns: 20_000_000,
            idle_w: 0.09,
            running_w: 1.2,
        }
    }
}

impl Servo {
    /// The servo whose table stands at `path`, if its curve is one.
    ///
    /// # Errors
    /// Names the first point that is out of place.
    pub fn checked(self, path: &Path) -> Result<Self, FieldError> {
        let path = path.field("curve_us_rpm");
        curve::has_points(&path, &self.curve, 1)?;
        curve::check::<Width, Rpm>(&path, &self.curve, ["pulse_us", "rpm"])?;
        Ok(self)
    }

    /// The curve of the Parallax 900-00008. Its manual gives about 48 turns a minute at the ends, and
    /// little change beyond 1.4 and 1.6 ms; the points between are guesses of that shape, good to a few
    /// turns a minute.
    pub fn parallax_curve() -> Vec<(f64, f64)> {
        let half = PARALLAX.iter().map(|&(above, rpm)| (PARALLAX_NEUTRAL_US + above, rpm));
        let mirrored = PARALLAX.iter().skip(1).rev().map(|&(above, rpm)| (PARALLAX_NEUTRAL_US - above, -rpm));
        mirrored.chain(half).collect()
    }

    /// The speed that it goes for at this signal, in rad/s.
    pub fn target_rad_s(&self, signal: f64) -> f64 {
        let pulse = self.neutral_us + self.half_range_us * signal - self.trim_us;
        if (pulse - self.neutral_us).abs() <= self.dead_band_us {
            return 0.0;
        }
        self.rpm(pulse) * (TAU / 60.0)
    }

    /// The speed that is `dt_s` later, in rad/s: the exact solution of a first-order lag.
    pub fn approach(&self, speed_rad_s: f64, target_rad_s: f64, dt_s: f64) -> f64 {
        if self.lag_s <= 0.0 {
            return target_rad_s;
        }
        target_rad_s + (speed_rad_s - target_rad_s) * math::exp(-dt_s / self.lag_s)
    }

    /// When a command that comes at this instant takes effect: with the next pulse.
    pub fn takes_effect(&self, command: SimTime) -> SimTime {
        frame::takes_effect(command, self.frame_ns)
    }

    /// When the pulse began that is in force at `now`.
    pub fn frame_start(&self, now: SimTime) -> SimTime {
        frame::start(now, self.frame_ns)
    }

    /// Electrical power that it takes, in W. It does not depend on the load, which nobody knows here.
    pub fn power_w(&self, signal: f64, wheel_speed_rad_s: f64) -> f64 {
        let turns = self.target_rad_s(signal) != 0.0 || wheel_speed_rad_s.abs() > STANDSTILL;
        if turns { self.running_w } else { self.idle_w }
    }

    fn rpm(&self, pulse_us: f64) -> f64 {
        curve::value(&self.curve, pulse_us)
    }
}

/// Below this speed, in rad/s, a servo counts as standing still: its lag alone would never end.
const STANDSTILL: f64 = 1e-3;

const PARALLAX_NEUTRAL_US: f64 = 1500.0;

/// Half of the curve: µs above the neutral width, turns a minute.
const PARALLAX: [(f64, f64); 9] = [
    (0.0, 0.0),
    (10.0, 6.0),
    (20.0, 12.0),
    (40.0, 24.0),
    (60.0, 34.0),
    (80.0, 41.0),
    (100.0, 44.0),
    (150.0, 47.0),
    (200.0, 48.0),
];

#[cfg(test)]
mod tests {
    use core::f64::consts::TAU;

    use baudbot_geometry::math;

    use super::Servo;

    fn parallax() -> Servo {
        Servo {
            curve: Servo::parallax_curve(),
            neutral_us: 1500.0,
            half_range_us: 200.0,
            dead_band_us: 5.0,
            trim_us: 0.0,
            lag_s: 0.06,
            frame_ns: 20_000_000,
            idle_w: 0.09,
            running_w: 1.2,
        }
    }

    /// The Boe-Bot's servo for continuous rotation (§1.2.3) beside its measured curve.
    #[test]
    fn the_parallax_curve_is_a_hyperbolic_tangent_within_2_turns_a_minute() {
        let servo = parallax();
        for pulse in (1300..=1700).map(f64::from) {
            let analytic = 48.0 * math::tanh((pulse - 1500.0) / 69.0);
            let found = servo.rpm(pulse);
            assert!((found - analytic).abs() < 2.0, "{pulse}: {found} and {analytic}");
        }
    }

    #[test]
    fn the_curve_is_linear_between_its_points_and_held_beyond_its_ends() {
        let servo = parallax();
        assert_eq!(servo.curve.len(), 17);
        assert!(servo.curve.is_sorted_by(|a, b| a.0 < b.0), "{:?}", servo.curve);
        for (pulse, rpm) in
            [(1300.0, -48.0), (1440.0, -34.0), (1430.0, -37.5), (1550.0, 29.0), (1700.0, 48.0)]
        {
            assert_eq!(servo.rpm(pulse), rpm, "{pulse}");
        }
        assert_eq!([servo.rpm(0.0), servo.rpm(1e9)], [-48.0, 48.0]);
        let single = Servo { curve: [(1500.0, 7.0)].into(), ..servo };
        assert_eq!([single.rpm(0.0), single.rpm(1500.0), single.rpm(2000.0)], [7.0; 3]);
    }

    /// The pulses of Fig. 1.15.
    #[test]
    fn signals_become_pulses_with_a_dead_band_and_a_trim() {
        let servo = parallax();
        assert_eq!(servo.target_rad_s(1.0), 48.0 * TAU / 60.0);
        assert_eq!(servo.target_rad_s(-0.5), -44.0 * TAU / 60.0);
        // 5 µs are within the dead band, 6 are not.
        assert_eq!(servo.target_rad_s(0.025), 0.0);
        assert!((servo.target_rad_s(0.03) - 3.6 * TAU / 60.0).abs() < 1e-12);
        // A servo whose neutral width is 10 µs too high creeps backwards at signal 0.
        let trimmed = Servo { trim_us: 10.0, ..servo };
        assert_eq!(trimmed.target_rad_s(0.0), -6.0 * TAU / 60.0);
        assert_eq!(trimmed.target_rad_s(0.05), 0.0);
    }

    #[test]
    fn the_lag_is_exact_in_steps_of_any_length() {
        let servo = parallax();
        let at_once = servo.approach(1.0, 5.0, 0.06);
        assert!((at_once - (5.0 - 4.0 * math::exp(-1.0))).abs() < 1e-15, "{at_once}");
        let in_steps = (0..60).fold(1.0, |speed, _| servo.approach(speed, 5.0, 0.001));
        assert!((in_steps - at_once).abs() < 1e-12, "{in_steps} and {at_once}");
        assert_eq!(Servo { lag_s: 0.0, ..servo }.approach(1.0, 5.0, 0.001), 5.0);
    }

    #[test]
    fn it_takes_less_power_standing_still() {
        let servo = parallax();
        assert_eq!(
            [servo.power_w(0.0, 0.0), servo.power_w(0.0, 1.0), servo.power_w(1.0, 0.0)],
            [0.09, 1.2, 1.2]
        );
    }
}
