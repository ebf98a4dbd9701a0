//! The conversion of an animal's motion to the wheels of a robot.

use baudbot_brain::{Action, Body, Signals, Turn};
use baudbot_geometry::Twist;

use crate::parameter::Parameter;
use crate::throttle::CommandThrottle;

/// The motion of an animal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// The speed forwards, in m/s.
    pub speed_m_s: f64,
    /// The rate of turning to the left, in rad/s.
    pub turn_rate_rad_s: f64,
}

/// The parameter for the robot's speed, which is not in its data sheet.
pub(super) const fn full_speed<P>(field: fn(&mut P) -> &mut f64) -> Parameter<P> {
    let meaning = "speed of the robot with the signal 1, in m/s";
    Parameter { name: "full_speed_m_s", meaning, range: 0.01..=100.0, field }
}

/// Wheel commands for an animal's gait.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct WheelCommands {
    half_track_m: f64,
    full_speed_m_s: f64,
    throttle: CommandThrottle,
    stepped_ns: u64,
}

impl WheelCommands {
    /// Commands for the wheels of a robot that does `full_speed_m_s` with the signal 1.
    pub(super) fn new(body: &Body, full_speed_m_s: f64) -> Self {
        Self {
            half_track_m: body.half_track_m,
            full_speed_m_s,
            throttle: CommandThrottle::new(body),
            stepped_ns: 0,
        }
    }

    /// Seconds since the step before; in the first one since the start of the run.
    pub(super) fn seconds_since_last(&mut self, turn: &Turn) -> f64 {
        let before_ns = std::mem::replace(&mut self.stepped_ns, turn.at_ns);
        turn.at_ns.saturating_sub(before_ns) as f64 * 1e-9
    }

    /// Moves so: (2.2), (2.3), with signals in proportion to the wheels' speeds. If a wheel is too slow for that,
    /// the robot goes the same way more slowly.
    pub(super) fn walk(&mut self, motion: Motion, turn: &Turn) -> Action {
        let body = Twist { forward: motion.speed_m_s, turn: motion.turn_rate_rad_s };
        let [left, right] = body.wheels(self.half_track_m).map(|speed_m_s| speed_m_s / self.full_speed_m_s);
        let largest = left.abs().max(right.abs()).max(1.0);
        self.send(Signals { left: left / largest, right: right / largest }, turn)
    }

    /// Sends signals, if it is time to.
    pub(super) fn send(&mut self, signals: Signals, turn: &Turn) -> Action {
        self.throttle.send(turn, signals)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_body::{body, turn};

    #[test]
    fn wheels_turn_as_the_motion_says() {
        let body = body(&[]);
        let mut wheels = WheelCommands::new(&body, 0.5);
        let arc = Motion { speed_m_s: 0.1, turn_rate_rad_s: 0.5 };
        // 0.2 m beside the centre the ground moves by 0.1 m/s more or less.
        assert_eq!(wheels.walk(arc, &turn(&body, 0, &[])), Action::drive(0.0, 0.4));
        let fast = Motion { speed_m_s: 1.0, turn_rate_rad_s: 5.0 };
        let later = turn(&body, 100_000_000, &[]);
        assert_eq!(wheels.walk(fast, &later), Action::drive(0.0, 1.0), "no faster, and the same way");
    }
}
