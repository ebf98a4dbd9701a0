//! A robot's part of a substep: its motors and the other actuators move it as if it were alone, and what it then runs into is felt.

use super::Robot;
use crate::actuator::ActuatorKind;
use crate::drive::{Drive, Wheels};
use crate::model::RobotSpec;
use crate::motor::Motors;
use crate::scenario::Scenario;
use crate::time::{SECOND_NS, SimTime};

impl Robot {
    /// A substep of the motors and the other actuators, as if the robot were alone.
    pub(crate) fn drive(&mut self, spec: &RobotSpec, scenario: &Scenario, now: SimTime, dt: f64) {
        self.take_up(spec, now, dt);
        let given = match &self.parts.delay_line {
            None => self.signals,
            Some(_) => self.delay(spec, now),
        };
        let powered = match (&spec.battery, &self.parts.battery) {
            (Some(battery), Some(state)) => !state.is_empty(battery),
            _ => true,
        };
        let signals = if powered { self.motor_noise.apply(given) } else { Wheels::default() };
        let signals = self.under_load(spec, signals);
        let grip = scenario.surroundings.grip_of(&spec.drive, &self.motion);
        self.motion = match (&self.parts.chip, &mut self.parts.currents_a, &spec.drive.motor) {
            (Some(chip), _, _) => {
                spec.drive.step_behind_bridges(&self.motion, signals, (chip.given().open, grip), dt)
            }
            (None, Some(currents_a), Motors::Dc(motor)) => {
                spec.drive.step_with_windings(&self.motion, (motor, signals), (currents_a, grip), dt)
            }
            (None, _, _) => spec.drive.step(&self.motion, signals, grip, dt),
        };
        for (actuator, state) in spec.actuators.iter().zip(&mut self.actuators) {
            if let ActuatorKind::Turret(servo) = &actuator.kind {
                // A pulse begins in the first substep of each frame.
                if now.since(servo.frame_start(now)) < (dt * SECOND_NS as f64 + 0.5) as u64 {
                    state.pulse = state.signal;
                }
                state.angle_rad = servo.step(state.angle_rad, servo.target_rad(state.pulse), dt);
            }
        }
        if self.parts.battery.is_some() {
            self.feed(spec, scenario, powered.then_some(signals), dt);
        }
    }

    /// The battery gives what the motors take at these signals, if it still gives anything, and takes what a charger gives.
    fn feed(&mut self, spec: &RobotSpec, scenario: &Scenario, signals: Option<Wheels>, dt: f64) {
        if let (Some(battery), Some(state)) = (&spec.battery, &mut self.parts.battery) {
            let charger_w = scenario.surroundings.charger_at(self.motion.pose.position);
            let motors_w = match (signals, &self.parts.currents_a, &spec.drive.motor) {
                (None, _, _) => 0.0,
                (Some(signals), Some(currents_a), Motors::Dc(motor)) => {
                    motor.power_of_current_w(signals.left, currents_a.left)
                        + motor.power_of_current_w(signals.right, currents_a.right)
                }
                (Some(signals), _, _) => spec.drive.power_w(&self.motion, signals),
            };
            state.draw(battery, battery.idle_w + motors_w, dt);
            if charger_w > 0.0 {
                let drawn_a = state.current_a;
                state.charge(battery, charger_w, dt);
                state.current_a += drawn_a;
            }
        }
    }

    /// A DC motor gets what the battery still gives.
    fn under_load(&self, spec: &RobotSpec, signals: Wheels) -> Wheels {
        let (Some(battery), Some(state), Motors::Dc(_)) =
            (&spec.battery, &self.parts.battery, &spec.drive.motor)
        else {
            return signals;
        };
        let share = state.terminal_v(battery) / battery.nominal_v;
        Wheels { left: share * signals.left, right: share * signals.right }
    }

    /// The speed, if the robot feels what changes it.
    pub(crate) fn felt_speed_m_s(&self) -> Option<f64> {
        self.parts.impulses_n_s.map(|_| self.motion.speed_m_s)
    }

    /// What stood in its way took a part of the speed that its motors had given it.
    pub(crate) fn feel(&mut self, drive: &Drive, driven_m_s: Option<f64>) {
        let (Some([front, back]), Some(driven_m_s)) = (&mut self.parts.impulses_n_s, driven_m_s) else {
            return;
        };
        let impulse = drive.moved_mass_kg() * (driven_m_s - self.motion.speed_m_s);
        *front += impulse.max(0.0);
        *back += (-impulse).max(0.0);
    }
}
