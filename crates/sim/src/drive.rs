//! Differential drive: kinematics (2.1)–(2.6), dynamics (2.26), (2.30)–(2.32), Euler steps (3.16)–(3.22) of
//! Wahde 2016.
//!
//! Deviations.
//! - (3.19) and (3.20) multiply by the heading before the step; ARSim's program uses the new one, and so do we.
//! - The notes use one R for the body's radius and for half the distance between the wheels. Here the
//!   half track is its own number, equal to the radius unless a scenario states otherwise.
//! - Servos and stepper motors turn their wheels at their own speed, whatever the body weighs: (2.5) and
//!   (2.6) in place of (2.31) and (2.32).
//! - ARSim feeds its motors wheel speeds computed with half the half track. `motor_track_factor` is that
//!   quirk: 0.5 in ARSim's preset, 1 (equations 2.2 and 2.3) everywhere else.
//! - The notes' wheels are those of the data sheet. A [`Deviation`] makes the robot go as other wheels lead it, as slip
//!   does; masses, torques and counts stay those of the data sheet.

use baudbot_geometry::{Pose, Twist, angle, math};
use serde::{Deserialize, Serialize};

pub use crate::wheels::Wheels;

use crate::motor::{DcMotor, Flow, Load, MotorNoise, Motors, Steps};
use crate::sound;

/// The model of a robot's body, wheels and motors.
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
    pub motor: Motors,
    /// The unevenness of the motors.
    pub motor_noise: MotorNoise,
    /// See the module's deviations.
    pub motor_track_factor: f64,
    /// The deviation of this specimen from its data sheet, if it has one.
    pub deviation: Option<Deviation>,
}

/// The deviation of one robot's wheels from the numbers above, which are those of its data sheet.
///
/// Borenstein & Feng 1996 (UMBmark) name the two systematic errors of odometry that matter: unequal wheel diameters
/// E_d = D_R / D_L, and an uncertain wheelbase E_b = b_actual / b_nominal. Third is the mean of both diameters, E_s.
/// Encoders, odometers and brains go on reckoning with the data sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviation {
    /// Diameter of each wheel, as a multiple of the data sheet's.
    pub wheels: Wheels,
    /// Half the distance between the points where the wheels touch the ground, in metres.
    pub half_track_m: f64,
}

impl Deviation {
    /// A `Deviation` with D_R / D_L = `wheel_ratio`, the mean of both diameters `wheel_scale` times the data sheet's,
    /// and this half track, in metres. Ratio and scale must be positive.
    pub fn new(wheel_ratio: f64, wheel_scale: f64, half_track_m: f64) -> Self {
        let left = 2.0 * wheel_scale / (wheel_ratio + 1.0);
        Self { wheels: Wheels { left, right: wheel_ratio * left }, half_track_m }
    }
}

/// Mass of one wheel and its moment of inertia about its axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wheel {
    /// In kg.
    pub mass_kg: f64,
    /// In kg m².
    pub inertia_kg_m2: f64,
}

/// A of (2.26), in 1/m: forward force per torque, the wheels' own inertia taken off. Without any it is (2.33).
pub fn forward_gain(mass_kg: f64, wheel_radius_m: f64, wheel: Wheel) -> f64 {
    let r = wheel_radius_m;
    let share = wheel.inertia_kg_m2 / (mass_kg * r * r) + wheel.mass_kg / mass_kg;
    1.0 / (r * (1.0 + 2.0 * share))
}

/// B of (2.30): turning torque per difference of wheel torques. Without the wheels' inertia it is (2.34).
pub fn turn_gain(inertia_kg_m2: f64, half_track_m: f64, wheel_radius_m: f64, wheel: Wheel) -> f64 {
    let (track, r) = (half_track_m, wheel_radius_m);
    let share = wheel.inertia_kg_m2 * track / (inertia_kg_m2 * r) + wheel.mass_kg * track * r / inertia_kg_m2;
    1.0 / (r / track + 2.0 * share)
}

/// The present motion of a robot.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Motion {
    /// Pose of the body's centre, world from robot.
    pub pose: Pose,
    /// Speed V along the heading, in m/s, as the wheels roll: on slippery ground the body has less.
    pub speed_m_s: f64,
    /// Turn rate, in rad/s, positive to the left, as the wheels roll.
    pub turn_rate_rad_s: f64,
    /// Wheel axis speeds as the last step left them, in rad/s: what the motors' back-EMF and friction see.
    pub wheel_speed_rad_s: Wheels,
    /// Way that each wheel has rolled since the start, in metres, backwards taken off.
    pub travel_m: Wheels,
    /// Acceleration along the heading in the last step, in m/s².
    pub acceleration_m_s2: f64,
    /// Steps of stepper motors, once they have run; other motors count none.
    pub steps: Option<Steps>,
}

impl Motion {
    /// The motion as the wheels roll.
    pub(crate) fn rolled(&self) -> Twist {
        Twist { forward: self.speed_m_s, turn: self.turn_rate_rad_s }
    }

    pub(crate) fn is_sound(&self) -> bool {
        let steps = self.steps.unwrap_or_default();
        let steps = [steps.left, steps.right].map(|steps| [steps.commanded_steps, steps.lost_steps]);
        sound::pose(&self.pose)
            && sound::numbers([self.speed_m_s, self.turn_rate_rad_s, self.acceleration_m_s2])
            && sound::wheels(&self.wheel_speed_rad_s)
            && sound::wheels(&self.travel_m)
            && sound::numbers(steps.concat())
    }
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
            acceleration_m_s2: 0.0,
            steps: None,
        };
        motion.wheel_speed_rad_s = self.wheel_speeds(&motion);
        motion
    }

    /// One Euler step of `dt` seconds under these motor signals: speeds from the motors, then
    /// (3.18)–(3.22). `grip` is how far each wheel carries the robot for each metre that it seems to roll, if that is not a
    /// metre: on slippery ground, or if the wheels are not those of the data sheet.
    pub fn step(&self, motion: &Motion, signals: Wheels, grip: Option<Wheels>, dt: f64) -> Motion {
        self.step_with(motion, signals, (None, grip), dt)
    }

    /// The same with DC motors behind bridges that leave each open for a share of the time, in which no current flows.
    pub fn step_behind_bridges(
        &self,
        motion: &Motion,
        signals: Wheels,
        (open, grip): (Wheels, Option<Wheels>),
        dt: f64,
    ) -> Motion {
        self.step_with(motion, signals, (Some(open), grip), dt)
    }

    #[inline(always)]
    fn step_with(
        &self,
        motion: &Motion,
        signals: Wheels,
        (open, grip): (Option<Wheels>, Option<Wheels>),
        dt: f64,
    ) -> Motion {
        let mut next = *motion;
        let wheels = motion.wheel_speed_rad_s;
        match &self.motor {
            Motors::Dc(motor) => {
                let [left_nm, right_nm] = match open {
                    None => [
                        motor.torque_nm(signals.left, wheels.left),
                        motor.torque_nm(signals.right, wheels.right),
                    ],
                    Some(open) => [
                        motor.torque_of_bridge_nm(signals.left, wheels.left, open.left),
                        motor.torque_of_bridge_nm(signals.right, wheels.right, open.right),
                    ],
                };
                self.push(&mut next, left_nm, right_nm, dt);
            }
            Motors::Velocity(motor) => {
                let torque = |signal, speed| motor.torque_nm(signal, self.wheel_radius_m * speed);
                let left_nm = torque(signals.left, wheels.left);
                self.push(&mut next, left_nm, torque(signals.right, wheels.right), dt);
            }
            Motors::Servo(servo) => {
                let speed = |signal, speed| servo.approach(speed, servo.target_rad_s(signal), dt);
                let left = speed(signals.left, wheels.left);
                self.roll(&mut next, Wheels { left, right: speed(signals.right, wheels.right) }, dt);
            }
            Motors::Stepper(stepper) => {
                let commanded = stepper.pulses(signals);
                let Steps { left, right } = next.steps.get_or_insert_default();
                let left = stepper.step(left, wheels.left, commanded.left, dt);
                let right = stepper.step(right, wheels.right, commanded.right, dt);
                self.roll(&mut next, Wheels { left, right }, dt);
            }
        }
        self.advance(&mut next, grip, dt);
        next
    }

    /// The same with DC motors whose windings have an inductance, and currents, in A: (1.1)–(1.7).
    pub(crate) fn step_with_windings(
        &self,
        motion: &Motion,
        (motor, signals): (&DcMotor, Wheels),
        (currents_a, grip): (&mut Wheels, Option<Wheels>),
        dt: f64,
    ) -> Motion {
        let voltages_v = [signals.left, signals.right].map(|signal| motor.voltage_v * signal);
        let flow = Flow {
            speeds: [motion.speed_m_s, motion.turn_rate_rad_s],
            currents_a: [currents_a.left, currents_a.right],
        };
        let Flow { speeds: [forward, turn], currents_a: [left, right] } =
            self.load(motion).advance(motor, voltages_v, flow, dt);
        *currents_a = Wheels { left, right };
        let mut next = *motion;
        next.acceleration_m_s2 = (forward - motion.speed_m_s) / dt;
        (next.speed_m_s, next.turn_rate_rad_s) = (forward, turn);
        self.advance(&mut next, grip, dt);
        next
    }

    /// The body as windings see it.
    fn load(&self, motion: &Motion) -> Load {
        let rolling = self.wheel_speeds(motion);
        let Wheels { left, right } = motion.wheel_speed_rad_s;
        Load {
            gains: [self.forward_gain / self.mass_kg, self.turn_gain / self.inertia_kg_m2],
            losses: [self.damping_n_s_m / self.mass_kg, self.turn_damping_nm_s / self.inertia_kg_m2],
            wheel_rates: [1.0, self.motor_track_factor * self.half_track_m]
                .map(|arm| arm / self.wheel_radius_m),
            slides_rad_s: [left - rolling.left, right - rolling.right],
        }
    }

    /// The fastest rate, in 1/s, at which anything changes in the equations of the motors' windings: 0 without an inductance.
    pub fn winding_rate_hz(&self) -> f64 {
        match &self.motor {
            Motors::Dc(motor) if motor.inductance_h > 0.0 => {
                self.load(&self.place(Pose::default(), 0.0, 0.0)).fastest_hz(motor)
            }
            Motors::Dc(_) | Motors::Velocity(_) | Motors::Servo(_) | Motors::Stepper(_) => 0.0,
        }
    }

    /// Torques on the wheels change the speeds: (2.31), (2.32), then (3.16), (3.17).
    fn push(&self, motion: &mut Motion, left_nm: f64, right_nm: f64, dt: f64) {
        let acceleration = (-self.damping_n_s_m * motion.speed_m_s
            + self.forward_gain * (left_nm + right_nm))
            / self.mass_kg;
        let turn_acceleration = (-self.turn_damping_nm_s * motion.turn_rate_rad_s
            + self.turn_gain * (right_nm - left_nm))
            / self.inertia_kg_m2;
        motion.acceleration_m_s2 = acceleration;
        motion.speed_m_s += acceleration * dt;
        motion.turn_rate_rad_s += turn_acceleration * dt;
    }

    /// Wheels that hold their speeds give the robot its own: (2.5), (2.6).
    fn roll(&self, motion: &mut Motion, wheels: Wheels, dt: f64) {
        let rims = [wheels.left, wheels.right].map(|speed| self.wheel_radius_m * speed);
        let body = Twist::of_wheels(rims, self.half_track_m);
        motion.acceleration_m_s2 = (body.forward - motion.speed_m_s) / dt;
        (motion.speed_m_s, motion.turn_rate_rad_s) = (body.forward, body.turn);
    }

    /// The pose follows the speeds: (3.18)–(3.22).
    fn advance(&self, motion: &mut Motion, grip: Option<Wheels>, dt: f64) {
        let rolled = motion.rolled();
        let moved = grip.map_or(rolled, |grip| self.carried(rolled, grip));
        motion.pose.heading = angle::wrap(motion.pose.heading + moved.turn * dt);
        let (sin, cos) = math::sin_cos(motion.pose.heading);
        motion.pose.position.x += moved.forward * cos * dt;
        motion.pose.position.y += moved.forward * sin * dt;
        motion.wheel_speed_rad_s = self.wheel_speeds(motion);
        let [left_m_s, right_m_s] = rolled.wheels(self.half_track_m);
        motion.travel_m.left += left_m_s * dt;
        motion.travel_m.right += right_m_s * dt;
    }

    /// The motion over ground of a body whose wheels roll as if it moved so, but carry it this far for each metre.
    pub(crate) fn carried(&self, rolled: Twist, grip: Wheels) -> Twist {
        let [left, right] = rolled.wheels(self.half_track_m);
        let half_track_m = self.deviation.map_or(self.half_track_m, |deviation| deviation.half_track_m);
        Twist::of_wheels([grip.left * left, grip.right * right], half_track_m)
    }

    /// The wheels roll with the speeds of the body after something else has changed these.
    pub(crate) fn roll_with(&self, motion: &mut Motion) {
        motion.wheel_speed_rad_s = self.wheel_speeds(motion);
    }

    /// The speed, in m/s, at which the wheels roll on the mean. It is the body's unless that slides along something.
    pub(crate) fn wheels_roll_at(&self, motion: &Motion) -> f64 {
        let Wheels { left, right } = motion.wheel_speed_rad_s;
        0.5 * (left + right) * self.wheel_radius_m
    }

    /// The body moves at a speed, in m/s, and its wheels roll at another.
    pub(crate) fn slip_with(&self, motion: &mut Motion, body_m_s: f64, wheels_m_s: f64) {
        motion.speed_m_s = wheels_m_s;
        self.roll_with(motion);
        motion.speed_m_s = body_m_s;
    }

    /// Electrical power that both motors take under these signals, in W.
    pub fn power_w(&self, motion: &Motion, signals: Wheels) -> f64 {
        let power = |signal, speed| self.motor.power_w(signal, speed, self.wheel_radius_m);
        let wheels = motion.wheel_speed_rad_s;
        power(signals.left, wheels.left) + power(signals.right, wheels.right)
    }

    /// The mass, in kg, that a force along the heading accelerates: that of the body, and what turning the wheels adds to it, so that a robot
    /// which is held pushes with the torques of its wheels over their radius.
    pub(crate) fn moved_mass_kg(&self) -> f64 {
        self.mass_kg / (self.forward_gain * self.wheel_radius_m)
    }

    /// Takes a robot's speed away; it goes on turning.
    pub fn halt(&self, motion: &mut Motion) {
        motion.speed_m_s = 0.0;
        motion.wheel_speed_rad_s = self.wheel_speeds(motion);
    }

    /// The margin of Euler steps of `dt` seconds before they blow up, forwards and in turning: each must stay below
    /// 2, and below 1 to approach the steady speed without swinging. The motor's back-EMF and viscous friction, or
    /// its regulator, damp the motion as α and β do. Motors that no torque slows are never far.
    pub fn stiffness(&self, dt: f64) -> [f64; 2] {
        let Some(slope_nm_s) = self.motor.slope_nm_s(self.wheel_radius_m) else { return [0.0; 2] };
        let slope = slope_nm_s / self.wheel_radius_m;
        let lever = self.motor_track_factor * self.half_track_m;
        [
            (self.damping_n_s_m + 2.0 * self.forward_gain * slope) * dt / self.mass_kg,
            (self.turn_damping_nm_s + 2.0 * self.turn_gain * slope * lever) * dt / self.inertia_kg_m2,
        ]
    }

    /// (2.2), (2.3) divided by the wheel's radius (2.1).
    fn wheel_speeds(&self, motion: &Motion) -> Wheels {
        let rims = motion.rolled().wheels(self.motor_track_factor * self.half_track_m);
        let [left, right] = rims.map(|speed| speed / self.wheel_radius_m);
        Wheels { left, right }
    }
}

#[cfg(test)]
mod tests {
    use super::{Deviation, Wheel, forward_gain, turn_gain};

    /// (2.33), (2.34).
    #[test]
    fn massless_wheels_give_the_simple_gains_of_2_33_and_2_34() {
        assert_eq!(forward_gain(3.0, 0.1, Wheel::default()), 10.0);
        assert_eq!(turn_gain(0.2, 0.2, 0.1, Wheel::default()), 2.0);
    }

    /// (2.26), (2.30).
    #[test]
    fn wheels_with_mass_lower_both_gains_as_2_26_and_2_30_say() {
        let wheel = Wheel { mass_kg: 0.3, inertia_kg_m2: 0.0015 };
        // I_w/(M r²) = 0.05, m/M = 0.1.
        assert!((forward_gain(3.0, 0.1, wheel) - 1.0 / (0.1 * 1.3)).abs() < 1e-12);
        // r/R = 0.5; I_w R/(I r) = 0.015; m R r / I = 0.03.
        assert!((turn_gain(0.2, 0.2, 0.1, wheel) - 1.0 / (0.5 + 2.0 * 0.045)).abs() < 1e-12);
    }

    #[test]
    fn diameters_have_the_ratio_and_the_mean_that_they_are_to_have() {
        let Deviation { wheels, half_track_m } = Deviation::new(1.02, 0.99, 0.2);
        assert!((wheels.right / wheels.left - 1.02).abs() < 1e-15, "{wheels:?}");
        assert!((0.5 * (wheels.left + wheels.right) - 0.99).abs() < 1e-15, "{wheels:?}");
        assert_eq!(half_track_m, 0.2);
    }
}
