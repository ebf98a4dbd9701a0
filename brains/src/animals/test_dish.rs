//! A dish to put robots into that do as animals do: no dynamics, no delays, and walls that hold.

use baudbot_brain::{Body, Brain, Sensor, Signals};
use baudbot_geometry::{Point, Pose, Twist, Vector};

use crate::test_body::turn;

/// A robot in a square dish about the origin.
pub(super) struct Dish {
    pub(super) body: Body,
    pub(super) half_side_m: f64,
    pub(super) pose: Pose,
    signals: Signals,
    at_ns: u64,
}

impl Dish {
    pub(super) fn new(body: Body, half_side_m: f64, pose: Pose) -> Self {
        Self { body, half_side_m, pose, signals: Signals::default(), at_ns: 0 }
    }

    /// Runs for `seconds` in steps of 20 ms, in each of which all sensors have a new reading by their places and
    /// directions.
    pub(super) fn run(&mut self, brain: &mut impl Brain, seconds: f64, read: impl Fn(&Pose, &Sensor) -> f64) {
        for _ in 0..(seconds / STEP_S) as u32 {
            let readings = self.body.sensors.iter().map(|sensor| {
                let mount = sensor.mount.unwrap();
                let robot_from_sensor = Pose::new(mount.x_m, mount.y_m, mount.heading_rad);
                [read(&self.pose.compose(&robot_from_sensor), sensor)]
            });
            let readings: Vec<_> = readings.collect();
            let readings: Vec<_> = readings.iter().map(|reading| Some(&reading[..])).collect();
            let action = brain.step(&turn(&self.body, self.at_ns, &readings));
            self.signals = action.signals.unwrap_or(self.signals);
            self.roll();
            self.at_ns += (STEP_S * 1e9) as u64;
        }
    }

    fn roll(&mut self) {
        let wheels = [self.signals.left, self.signals.right].map(|signal| signal * FULL_SPEED_M_S);
        let Twist { forward, turn } = Twist::of_wheels(wheels, self.body.half_track_m);
        let displacement = Vector::new(forward * STEP_S, 0.0);
        let Pose { position, heading } =
            self.pose.compose(&Pose { position: Point::from(displacement), heading: turn * STEP_S });
        let held = |m: f64| m.clamp(-self.half_side_m, self.half_side_m);
        self.pose = Pose::new(held(position.x), held(position.y), heading);
    }
}

/// The speed of ARSim's robot with the signal 1.
pub(super) const FULL_SPEED_M_S: f64 = 0.785;

const STEP_S: f64 = 0.02;
