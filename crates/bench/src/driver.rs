//! The steering of a workload's robots in the same thread: cheap, but it reads every reading that comes and answers
//! each with a command, so that robots do avoid obstacles.

use baudbot_sim::Reading;
use baudbot_sim::model::RobotSpec;

/// A brain without memory: the signals of the wheels follow from the last readings (Braitenberg's vehicles).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Driver {
    /// The driver by eight infra-red sensors, in the order in which [`scenario`](crate::scenario) has them.
    Infrared,
    /// The driver by the distances of a laser.
    Laser,
    /// A program on the robot's own chip does.
    Chip,
}

impl Driver {
    /// The driver for this robot.
    pub fn for_robot(spec: &RobotSpec) -> Self {
        if spec.chip.is_some() {
            Self::Chip
        } else if spec.sensors.iter().any(|sensor| sensor.device.kind() == "laser") {
            Self::Laser
        } else {
            Self::Infrared
        }
    }

    /// Signals for the wheels, left and right.
    pub fn steer(self, readings: &[Reading]) -> [f64; 2] {
        match self {
            Self::Infrared => by_infrared(readings.iter().map(|reading| first(&reading.values))),
            Self::Chip => [0.0; 2],
            Self::Laser => readings.first().map_or([0.0; 2], |scan| by_laser(&scan.values)),
        }
    }
}

/// Signals for the wheels by the readings of infra-red sensors: what is near on a side makes the wheel of the other side
/// slower, or turn back.
pub fn by_infrared(readings: impl Iterator<Item = f64>) -> [f64; 2] {
    let mut signals = [CRUISE; 2];
    for (nearness, weights) in readings.zip(INFRARED_WEIGHTS) {
        signals[0] += weights[0] * nearness;
        signals[1] += weights[1] * nearness;
    }
    signals.map(|signal| signal.clamp(-1.0, 1.0))
}

fn first(values: &[f64]) -> f64 {
    values.first().copied().unwrap_or(0.0)
}

/// Away from the side on which less is free. Every eighth ray of the middle third on either side will do.
fn by_laser(distances: &[f64]) -> [f64; 2] {
    let nearest = |rays: &[f64]| {
        let mut nearest = LASER_FAR_M;
        for every_eighth in rays.chunks(8) {
            let distance = every_eighth[0];
            // Below 0 it has met nothing.
            if distance >= 0.0 && distance < nearest {
                nearest = distance;
            }
        }
        nearest
    };
    let middle = distances.len() / 2;
    let field = distances.len() / 3;
    let right = nearest(&distances[middle - field..middle]);
    let left = nearest(&distances[middle..middle + field]);
    let way = (right.min(left) - LASER_STOP_M) / (LASER_FAR_M - LASER_STOP_M);
    if way < 0.0 {
        // On the spot and always the same way: turning to the freer side would dither in a corner.
        return [0.3, -0.3];
    }
    let turn = (left - right) / LASER_FAR_M * 0.4;
    [(way * CRUISE - turn).clamp(-1.0, 1.0), (way * CRUISE + turn).clamp(-1.0, 1.0)]
}

/// The part of each sensor in the speeds of the left and the right wheel. Not the same on both sides: a robot that is
/// straight in front of a wall turns all the same.
const INFRARED_WEIGHTS: [[f64; 2]; 8] =
    [[-2.4, 1.2], [-1.8, 1.2], [-0.6, 0.6], [0.3, 0.3], [0.3, 0.3], [0.6, -0.6], [1.2, -1.8], [1.2, -2.0]];

/// Signal of both wheels where nothing is near.
const CRUISE: f64 = 0.6;

/// The distance beyond which objects do not matter, in metres.
const LASER_FAR_M: f64 = 1.5;

/// Nearer than this, a robot turns on the spot; its radius is 0.15 m.
const LASER_STOP_M: f64 = 0.3;
