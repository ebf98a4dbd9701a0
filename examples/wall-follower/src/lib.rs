//! A brain that follows the wall on its right.

use baudbot_client::{Action, Brain, Turn};

/// Follows the wall on its right.
#[derive(Clone, Debug)]
pub struct Follow {
    /// Signal of the wheels when driving straight, 0 to 1.
    pub speed: f64,
    /// The gain on an error in the nearness of the wall.
    pub gain: f64,
    /// The nearness of the wall that it keeps: 0 is out of range, 1 is very near.
    pub wanted: f64,
}

impl Default for Follow {
    fn default() -> Self {
        Self { speed: 0.4, gain: 1.0, wanted: 0.3 }
    }
}

impl Brain for Follow {
    fn step(&mut self, turn: &Turn) -> Action {
        let nearness = |sensors: [&str; 2], unread: f64| {
            sensors.map(|sensor| turn.value(sensor).unwrap_or(unread)).into_iter().fold(0.0, f64::max)
        };
        let action = if nearness(["ir_front", "ir_front_left"], 1.0) > self.wanted {
            Action::drive(-0.5 * self.speed, 0.5 * self.speed) // a corner: to the left, on the spot
        } else {
            let error = nearness(["ir_right", "ir_front_right"], 0.0) - self.wanted;
            let turning = self.gain * self.speed * error; // too near: to the left
            Action::drive(self.speed - turning, self.speed + turning)
        };
        // The next step is when readings have arrived, or after 0.1 s: the cable may have lost the command.
        action.until_message_or(turn.at_ns + 100_000_000)
    }
}
