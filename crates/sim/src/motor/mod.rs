//! The motors of the wheels: one file a kind of motor, and their common parts.
//!
//! DC and velocity-regulated motors give a torque, which (2.31) and (2.32) turn into motion. Servos and
//! steppers hold their speed themselves; from them the wheels' speeds are taken as they are, and the body
//! has to follow.

mod dc;
mod delay;
mod frame;
mod noise;
mod positional;
mod servo;
mod stepper;
mod velocity;
mod winding;

pub use dc::DcMotor;
pub(crate) use delay::DelayLine;
pub use noise::MotorNoise;
pub(crate) use noise::NoiseState;
pub use positional::PositionalServo;
pub use servo::Servo;
pub use stepper::{Stepper, StepperState, Steps};
pub use velocity::VelocityMotor;
pub(crate) use winding::{Flow, Load};

use crate::time::SimTime;

/// The two motors of a robot, which are alike.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs, reason = "each variant is its payload's documentation")]
pub enum Motors {
    Dc(DcMotor),
    Velocity(VelocityMotor),
    Servo(Servo),
    Stepper(Stepper),
}

impl Motors {
    /// The name of this kind in scenarios.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Dc(_) => "dc",
            Self::Velocity(_) => "velocity",
            Self::Servo(_) => "servo",
            Self::Stepper(_) => "stepper",
        }
    }

    /// Whether currents in windings are a part of the robot's state.
    pub(crate) fn has_windings(&self) -> bool {
        matches!(self, Self::Dc(motor) if motor.inductance_h > 0.0)
    }

    /// Electrical power that one motor takes, in W, at this signal, speed of its wheel and radius of its
    /// wheel.
    pub fn power_w(&self, signal: f64, wheel_speed_rad_s: f64, wheel_radius_m: f64) -> f64 {
        match self {
            Self::Dc(motor) => motor.power_w(signal, wheel_speed_rad_s),
            Self::Velocity(motor) => {
                motor.power_w(signal, wheel_radius_m * wheel_speed_rad_s, wheel_radius_m)
            }
            Self::Servo(servo) => servo.power_w(signal, wheel_speed_rad_s),
            Self::Stepper(stepper) => stepper.power_w(signal),
        }
    }

    /// The torque on the wheel that is lost for each rad/s of its speed, in N m s: the quantity by which Euler steps
    /// can blow up. `None` for motors whose speed no torque changes.
    pub(crate) fn slope_nm_s(&self, wheel_radius_m: f64) -> Option<f64> {
        match self {
            // The equations of windings are solved exactly.
            Self::Dc(motor) if motor.inductance_h > 0.0 => None,
            Self::Dc(motor) => Some(motor.slope_nm_s()),
            Self::Velocity(motor) => Some(motor.slope_nm_s(wheel_radius_m)),
            Self::Servo(_) | Self::Stepper(_) => None,
        }
    }

    /// When a command that is obeyed at this instant moves the motors: a servo with its next pulse, all others at once.
    pub fn takes_effect(&self, command: SimTime) -> SimTime {
        match self {
            Self::Servo(servo) => servo.takes_effect(command),
            Self::Dc(_) | Self::Velocity(_) | Self::Stepper(_) => command,
        }
    }

    /// The instant up to which commands count at `now`. A servo obeys those that had come when its present
    /// pulse began, all others obey at once.
    pub(crate) fn obeys_until(&self, now: SimTime) -> SimTime {
        match self {
            Self::Servo(servo) => servo.frame_start(now),
            Self::Dc(_) | Self::Velocity(_) | Self::Stepper(_) => now,
        }
    }
}
