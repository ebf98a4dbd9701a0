//! Positional servo: the signal is an angle, which it turns to as fast as it can. For a turret; wheels
//! cannot use it.
//!
//! Deviations. It turns at its full rate or not at all: without load, and without the swing at the end. The
//! notes describe servos (Section 1.2.3, Figs. 1.14 and 1.15), and compute none. Data sheets give the rate as a time: 60° in
//! 0.24 s (Hitec HS-645MG), 0.19 s (HS-311) or 0.23 s (Futaba S3003), at 4.8 V.

use baudbot_fields::number::{Between, Millis, Number, Opening, Positive, Rule, Share};
use serde::Deserialize;

use super::frame;
use crate::time::SimTime;

baudbot_fields::rules! {
    /// An angle of up to a turn to the right, in radians.
    ToTheRight: Any, -core::f64::consts::TAU, 0.0;
}

/// The model of a positional servo.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PositionalServo {
    /// Limit to the right.
    #[serde(with = "Number::<ToTheRight>")]
    pub min_rad: f64,
    /// Limit to the left.
    #[serde(with = "Number::<Opening>")]
    pub max_rad: f64,
    /// Turn rate.
    #[serde(with = "Number::<Positive>")]
    pub rate_rad_s: f64,
    /// The turret does not move if the commanded angle is this close.
    #[serde(default, with = "Number::<Share>")]
    pub dead_band_rad: f64,
    /// Period of the pulses. A command takes effect with the next pulse; with 0, immediately.
    #[serde(rename = "frame_ms", default = "usual_frame_ns", with = "Number::<FrameMs>")]
    pub frame_ns: u64,
}

type FrameMs = Millis<Between<0, 1000>>;

/// That of servos for models.
fn usual_frame_ns() -> u64 {
    FrameMs::value(20.0)
}

impl PositionalServo {
    /// The angle that it goes for at this signal, in rad: ±1 is the end that is farther from 0, and the other end holds.
    pub fn target_rad(&self, signal: f64) -> f64 {
        let (min, max) = (self.min_rad, self.max_rad);
        (signal * max.max(-min)).max(min).min(max)
    }

    /// The angle that is `dt_s` later, in rad, on the way from `angle_rad` to `target_rad`.
    pub fn step(&self, angle_rad: f64, target_rad: f64, dt_s: f64) -> f64 {
        let way = target_rad - angle_rad;
        let reach = self.rate_rad_s * dt_s;
        if way.abs() <= self.dead_band_rad {
            angle_rad
        } else if way.abs() <= reach {
            target_rad
        } else {
            angle_rad + reach.copysign(way)
        }
    }

    /// When a command that comes at this instant takes effect: with the next pulse.
    pub fn takes_effect(&self, command: SimTime) -> SimTime {
        frame::takes_effect(command, self.frame_ns)
    }

    /// When the pulse began that is in force at `now`.
    pub fn frame_start(&self, now: SimTime) -> SimTime {
        frame::start(now, self.frame_ns)
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::FRAC_PI_3;

    use super::PositionalServo;

    fn hs311() -> PositionalServo {
        PositionalServo {
            min_rad: -1.0,
            max_rad: 1.5,
            rate_rad_s: FRAC_PI_3 / 0.19,
            dead_band_rad: 0.01,
            frame_ns: 20_000_000,
        }
    }

    #[test]
    fn a_turn_of_60_degrees_takes_as_long_as_the_data_sheet_says() {
        let servo = hs311();
        let angle = (0..189).fold(0.0, |angle, _| servo.step(angle, FRAC_PI_3, 0.001));
        assert!((angle - FRAC_PI_3 * 189.0 / 190.0).abs() < 1e-12, "{angle}");
        let angle = servo.step(servo.step(angle, FRAC_PI_3, 0.001), FRAC_PI_3, 0.001);
        assert!((angle - FRAC_PI_3).abs() <= servo.dead_band_rad, "{angle}");
        assert_eq!(servo.step(0.0, -0.3, 1.0), -0.3);
    }

    #[test]
    fn it_stays_within_its_range_and_its_dead_band() {
        let servo = hs311();
        assert_eq!(
            [1.0, 0.5, -0.5, -1.0, 9.0].map(|signal| servo.target_rad(signal)),
            [1.5, 0.75, -0.75, -1.0, 1.5]
        );
        let to_the_right = PositionalServo { max_rad: 0.0, ..hs311() };
        assert_eq!([1.0, -0.5, -1.0].map(|signal| to_the_right.target_rad(signal)), [0.0, -0.5, -1.0]);
        assert_eq!(servo.step(0.2, 0.21, 1.0), 0.2);
        assert_eq!(servo.step(0.2, 0.211, 1.0), 0.211);
    }
}
