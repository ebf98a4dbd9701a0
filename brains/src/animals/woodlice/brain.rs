//! A robot that gathers in the damp, or where else a field is strong, as wood lice do.

use baudbot_brain::{Action, Body, Brain, SensorKind, Turn};

use super::{Parameters as LouseParameters, Woodlouse};
use crate::animals::sense::Sense;
use crate::animals::wheel_commands::{Motion, WheelCommands, full_speed};
use crate::chance::Chance;
use crate::parameter::Parameter;

/// The robot's parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// The parameters of the louse as a model, which the robot follows.
    pub louse: LouseParameters,
    /// Speed of the robot with the signal 1, in m/s; that of ARSim's robot by default.
    pub full_speed_m_s: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        Self { louse: LouseParameters::default(), full_speed_m_s: 0.785 }
    }
}

pub(crate) const PARAMETERS: &[Parameter<Parameters>] = &[
    Parameter {
        name: "dry",
        meaning: "reading up to which it runs at its highest speed",
        range: -1e9..=1e9,
        field: |p| &mut p.louse.dry,
    },
    Parameter {
        name: "damp",
        meaning: "reading from which it runs at its lowest speed",
        range: -1e9..=1e9,
        field: |p| &mut p.louse.damp,
    },
    Parameter {
        name: "dry_speed_m_s",
        meaning: "speed in the dry, in m/s",
        range: 0.0..=10.0,
        field: |p| &mut p.louse.dry_speed_m_s,
    },
    Parameter {
        name: "damp_speed_m_s",
        meaning: "speed in the damp, in m/s",
        range: 0.0..=10.0,
        field: |p| &mut p.louse.damp_speed_m_s,
    },
    Parameter {
        name: "turn_rad_s",
        meaning: "maximum turn rate, in rad/s",
        range: 0.0..=100.0,
        field: |p| &mut p.louse.turn_rad_s,
    },
    Parameter {
        name: "turn_hz",
        meaning: "changes of the turn rate, per second",
        range: 0.0..=100.0,
        field: |p| &mut p.louse.turn_hz,
    },
    full_speed(|p| &mut p.full_speed_m_s),
];

/// A brain that wanders quickly in the dry and slowly in the damp.
#[derive(Clone, Debug, PartialEq)]
pub struct WoodlouseBrain {
    chance: Chance,
    sense: Sense,
    wheels: WheelCommands,
    louse: Woodlouse,
}

impl WoodlouseBrain {
    /// A brain at its start; it feels a field, or else light. `None` if the robot has a sensor for neither.
    pub fn new(parameters: Parameters, chance: Chance, body: &Body) -> Option<Self> {
        Some(Self {
            chance,
            sense: Sense::new(body, &[SensorKind::Field, SensorKind::Light, SensorKind::Photoresistor])?,
            wheels: WheelCommands::new(body, parameters.full_speed_m_s),
            louse: Woodlouse::new(parameters.louse),
        })
    }
}

impl Brain for WoodlouseBrain {
    fn step(&mut self, turn: &Turn) -> Action {
        self.sense.look(turn);
        let dt_s = self.wheels.seconds_since_last(turn);
        let motion = if self.sense.is_numb(turn.at_ns) {
            Motion::default()
        } else {
            self.louse.step(self.sense.mean(), dt_s, &mut self.chance)
        };
        self.wheels.walk(motion, turn)
    }
}

#[cfg(test)]
mod tests {
    use baudbot_geometry::Pose;

    use super::*;
    use crate::animals::test_dish::{Dish, FULL_SPEED_M_S};
    use crate::test_body::{body, turn};

    /// Part of the time that robots spend in a damp corner, a ninth of the room, once they have forgotten where
    /// they began.
    fn part_in_corner(louse: LouseParameters) -> f64 {
        let damp = |pose: &Pose| f64::from(pose.position.x > 0.5 && pose.position.y > 0.5);
        let (mut inside, mut all) = (0.0, 0.0);
        for seed in 0..40 {
            let body = body(&[("hygrometer", "field", 0.0)]);
            let parameters = Parameters { louse, full_speed_m_s: FULL_SPEED_M_S };
            let mut brain = WoodlouseBrain::new(parameters, Chance::new(seed, "alice/louse"), &body).unwrap();
            let mut dish = Dish::new(body, 1.5, Pose::new(-1.0, -1.0, seed as f64));
            dish.run(&mut brain, 180.0, |pose, _| damp(pose));
            for _ in 0..24 {
                dish.run(&mut brain, 5.0, |pose, _| damp(pose));
                inside += damp(&dish.pose);
                all += 1.0;
            }
        }
        inside / all
    }

    #[test]
    fn robots_are_found_in_the_damp_corner() {
        let (slow, same) = (
            part_in_corner(LouseParameters::default()),
            part_in_corner(LouseParameters { damp_speed_m_s: 0.3, ..LouseParameters::default() }),
        );
        assert!(slow > 0.35, "{slow}");
        assert!(same < 0.2, "{same}");
    }

    #[test]
    fn it_stands_still_until_it_feels_something() {
        let body = body(&[("hygrometer", "field", 0.0)]);
        let parameters = Parameters { full_speed_m_s: 0.6, ..Parameters::default() };
        let mut brain = WoodlouseBrain::new(parameters, Chance::new(1, "alice"), &body).unwrap();
        assert_eq!(brain.step(&turn(&body, 0, &[None])), Action::drive(0.0, 0.0));
        assert_eq!(brain.step(&turn(&body, 20_000_000, &[Some(&[0.0])])), Action::drive(0.5, 0.5));
    }
}
