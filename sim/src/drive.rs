//! Differential drive: kinematics (2.1)–(2.6), dynamics (2.26), (2.30)–(2.32), Euler steps (3.16)–(3.22) of
//! Wahde 2016.
//!
//! Deviations.
//! - (3.19) and (3.20) multiply by the heading before the step; ARSim's program uses the new one, and so do we.
//! - The notes use one R for the body's radius and for half the distance between the wheels. Here the
//!   half track is its own number, equal to the radius unless a scenario says otherwise.
//! - ARSim feeds its motors wheel speeds computed with half the half track. `motor_track_factor` is that
//!   quirk: 0.5 in ARSim's preset, 1 (equations 2.2 and 2.3) everywhere else.

use baudbot_geometry::{Pose, angle, math};
use serde::{Deserialize, Serialize};

use crate::motor::Motor;

/// What a robot's body, wheels and motors are.
#[derive(Clone, Debug, PartialEq)]
pub struct Drive {
    /// Radius of the disc that the body is, in metres.
    pub radius_m: f64,
    /// Half the distance between the wheels, in metres.
    pub half_track_m: f64,
    /// Radius of each wheel r, in metres.
    pub wheel_radius_m: f64,
    /// Mass of the body M, in kg.
    pub mass_kg: f64,
    /// Moment of inertia of the body about the vertical axis, in kg m².
    pub inertia_kg_m2: f64,
    /// Damping of the forward motion α of (2.31), in N s / m.
    pub damping_n_s_m: f64,
    /// Damping of the turning motion β of (2.32), in N m s.
    pub turn_damping_nm_s: f64,
    /// A of (2.26), in 1/m.
    pub forward_gain: f64,
    /// B of (2.30), without unit.
    pub turn_gain: f64,
    /// The motor of each wheel; the two are alike.
    pub motor: Motor,
    /// See the module's deviations.
    pub motor_track_factor: f64,
}

/// Mass of one wheel and its moment of inertia about its axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wheel {
    /// In kg.
    pub mass_kg: f64,
    /// In kg m².
    pub inertia_kg_m2: f64,
}

/// A of (2.26), in 1/m: forward force per torque, the wheels' own inertia taken off.
pub fn forward_gain(mass_kg: f64, wheel_radius_m: f64, wheel: Wheel) -> f64 {
    let r = wheel_radius_m;
    let share = wheel.inertia_kg_m2 / (mass_kg * r * r) + wheel.mass_kg / mass_kg;
    1.0 / (r * (1.0 + 2.0 * share))
}

/// B of (2.30): turning torque per difference of wheel torques.
pub fn turn_gain(inertia_kg_m2: f64, half_track_m: f64, wheel_radius_m: f64, wheel: Wheel) -> f64 {
    let (track, r) = (half_track_m, wheel_radius_m);
    let share = wheel.inertia_kg_m2 * track / (inertia_kg_m2 * r) + wheel.mass_kg * track * r / inertia_kg_m2;
    1.0 / (r / track + 2.0 * share)
}

/// A pair of values, one of each wheel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Wheels {
    /// Of the left wheel.
    pub left: f64,
    /// Of the right wheel.
    pub right: f64,
}

/// How a robot moves now.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Motion {
    /// Pose of the body's centre, world from robot.
    pub pose: Pose,
    /// Speed V along the heading, in m/s.
    pub speed_m_s: f64,
    /// Turn rate, in rad/s, positive to the left.
    pub turn_rate_rad_s: f64,
    /// Wheel axis speeds as the last step left them, in rad/s: what the motors' back-EMF and friction see.
    pub wheel_speed_rad_s: Wheels,
    /// Way that each wheel has rolled since the start, in metres, backwards taken off.
    pub travel_m: Wheels,
}

impl Drive {
    /// A robot placed at `pose` with this speed and turn rate, its wheels rolling to match.
    pub fn place(&self, pose: Pose, speed_m_s: f64, turn_rate_rad_s: f64) -> Motion {
        let mut motion = Motion {
            pose,
            speed_m_s,
            turn_rate_rad_s,
            wheel_speed_rad_s: Wheels::default(),
            travel_m: Wheels::default(),
        };
        motion.wheel_speed_rad_s = self.wheel_speeds(&motion);
        motion
    }

    /// One Euler step of `dt` seconds under these motor signals: (2.31), (2.32), then (3.16)–(3.22).
    pub fn step(&self, motion: &Motion, signals: Wheels, dt: f64) -> Motion {
        let left_nm = self.motor.torque_nm(signals.left, motion.wheel_speed_rad_s.left);
        let right_nm = self.motor.torque_nm(signals.right, motion.wheel_speed_rad_s.right);
        let acceleration = (-self.damping_n_s_m * motion.speed_m_s
            + self.forward_gain * (left_nm + right_nm))
            / self.mass_kg;
        let turn_acceleration = (-self.turn_damping_nm_s * motion.turn_rate_rad_s
            + self.turn_gain * (right_nm - left_nm))
            / self.inertia_kg_m2;

        let speed = motion.speed_m_s + acceleration * dt;
        let turn_rate = motion.turn_rate_rad_s + turn_acceleration * dt;
        let heading = angle::wrap(motion.pose.heading + turn_rate * dt);
        let mut next = *motion;
        next.speed_m_s = speed;
        next.turn_rate_rad_s = turn_rate;
        next.pose.heading = heading;
        let (sin, cos) = math::sin_cos(heading);
        next.pose.position.x += speed * cos * dt;
        next.pose.position.y += speed * sin * dt;
        next.wheel_speed_rad_s = self.wheel_speeds(&next);
        next.travel_m.left += (speed - self.half_track_m * turn_rate) * dt;
        next.travel_m.right += (speed + self.half_track_m * turn_rate) * dt;
        next
    }

    /// Takes a robot's speed away; it goes on turning.
    pub fn halt(&self, motion: &mut Motion) {
        motion.speed_m_s = 0.0;
        motion.wheel_speed_rad_s = self.wheel_speeds(motion);
    }

    /// How far Euler steps of `dt` seconds are from blowing up, forwards and in turning: each must stay
    /// below 2, and below 1 to approach the steady speed without swinging. The motor's back-EMF and viscous
    /// friction damp the motion as α and β do.
    pub fn stiffness(&self, dt: f64) -> [f64; 2] {
        let slope = self.motor.slope_nm_s() / self.wheel_radius_m;
        let lever = self.motor_track_factor * self.half_track_m;
        [
            (self.damping_n_s_m + 2.0 * self.forward_gain * slope) * dt / self.mass_kg,
            (self.turn_damping_nm_s + 2.0 * self.turn_gain * slope * lever) * dt / self.inertia_kg_m2,
        ]
    }

    /// (2.2), (2.3) divided by the wheel's radius (2.1).
    fn wheel_speeds(&self, motion: &Motion) -> Wheels {
        let turning = self.motor_track_factor * self.half_track_m * motion.turn_rate_rad_s;
        Wheels {
            left: (motion.speed_m_s - turning) / self.wheel_radius_m,
            right: (motion.speed_m_s + turning) / self.wheel_radius_m,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Wheel, forward_gain, turn_gain};

    #[test]
    fn massless_wheels_give_the_simple_gains_of_2_33_and_2_34() {
        assert_eq!(forward_gain(3.0, 0.1, Wheel::default()), 10.0);
        assert_eq!(turn_gain(0.2, 0.2, 0.1, Wheel::default()), 2.0);
    }

    #[test]
    fn wheels_with_mass_lower_both_gains_as_2_26_and_2_30_say() {
        let wheel = Wheel { mass_kg: 0.3, inertia_kg_m2: 0.0015 };
        // I_w/(M r²) = 0.05, m/M = 0.1.
        assert!((forward_gain(3.0, 0.1, wheel) - 1.0 / (0.1 * 1.3)).abs() < 1e-12);
        // r/R = 0.5; I_w R/(I r) = 0.015; m R r / I = 0.03.
        assert!((turn_gain(0.2, 0.2, 0.1, wheel) - 1.0 / (0.5 + 2.0 * 0.045)).abs() < 1e-12);
    }
}
