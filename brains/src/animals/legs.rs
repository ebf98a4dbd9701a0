//! From an animal's motion to the wheels of a robot.

use baudbot_client::{Action, Body, Signals};

/// How an animal moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// Forwards, in m/s.
    pub speed_m_s: f64,
    /// To the left, in rad/s.
    pub turn_rate_rad_s: f64,
}

/// A robot's wheels as an animal's legs. A command is sent when it says something new, and again now and then, as
/// the cable may lose one; never before the last one is off the cable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Legs {
    half_track_m: f64,
    full_speed_m_s: f64,
    command_ns: u64,
    repeat_ns: u64,
    sent: Option<(u64, Signals)>,
}

impl Legs {
    /// Legs of a robot that does `full_speed_m_s` with the signal 1.
    pub(super) fn new(body: &Body, full_speed_m_s: f64) -> Self {
        let command_ns = body.command_ns();
        // A firmware that answers only when asked is asked by a command.
        let repeat_ns = if body.firmware.period_ns.is_some() { REPEAT_NS } else { 0 };
        Self { half_track_m: body.half_track_m, full_speed_m_s, command_ns, repeat_ns, sent: None }
    }

    /// Moves so: (2.2), (2.3), with signals in proportion to the wheels' speeds. If a wheel is too slow for that,
    /// the robot goes the same way more slowly.
    pub(super) fn walk(&mut self, motion: Motion, at_ns: u64) -> Action {
        let aside_m_s = self.half_track_m * motion.turn_rate_rad_s;
        let left = (motion.speed_m_s - aside_m_s) / self.full_speed_m_s;
        let right = (motion.speed_m_s + aside_m_s) / self.full_speed_m_s;
        let largest = left.abs().max(right.abs()).max(1.0);
        self.send(Signals { left: left / largest, right: right / largest }, at_ns)
    }

    /// Sends signals, if it is time to.
    pub(super) fn send(&mut self, signals: Signals, at_ns: u64) -> Action {
        if let Some((sent_ns, last)) = self.sent {
            let pause_ns =
                if last == signals { self.repeat_ns.max(self.command_ns) } else { self.command_ns };
            if at_ns.saturating_sub(sent_ns) < pause_ns {
                return Action::wait();
            }
        }
        self.sent = Some((at_ns, signals));
        Action::drive(signals.left, signals.right)
    }
}

const REPEAT_NS: u64 = 100_000_000;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_body::body;

    const MS: u64 = 1_000_000;

    #[test]
    fn wheels_turn_as_the_motion_says() {
        let mut legs = Legs::new(&body(&[]), 0.5);
        let arc = Motion { speed_m_s: 0.1, turn_rate_rad_s: 0.5 };
        // 0.2 m beside the centre the ground moves by 0.1 m/s more or less.
        assert_eq!(legs.walk(arc, 0), Action::drive(0.0, 0.4));
        let fast = Motion { speed_m_s: 1.0, turn_rate_rad_s: 5.0 };
        assert_eq!(legs.walk(fast, 100 * MS), Action::drive(0.0, 1.0), "no faster, and the same way");
    }

    #[test]
    fn nothing_is_said_twice_at_once_nor_before_the_last_word_is_out() {
        let mut legs = Legs::new(&body(&[]), 0.5);
        let (on, still) = (Signals { left: 0.2, right: 0.2 }, Signals::default());
        assert_eq!(legs.send(on, 0), Action::drive(0.2, 0.2));
        assert_eq!(legs.send(on, 50 * MS), Action::wait());
        assert_eq!(legs.send(on, 100 * MS), Action::drive(0.2, 0.2));
        assert_eq!(legs.send(still, 101 * MS), Action::wait(), "a command takes some milliseconds");
        assert_eq!(legs.send(still, 120 * MS), Action::drive(0.0, 0.0));
    }
}
