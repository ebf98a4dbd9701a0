//! A robot that flees the light as a larva does.
//!
//! With sensors on both sides it compares them. With one it swings its whole body, as it has no neck. Something
//! that touches it (a bumper or a whisker, if it has any) turns it about, as the dead end of a tunnel does a larva.

use std::f64::consts::PI;

use baudbot_brain::{Action, Body, Brain, SensorKind, Turn};

use super::{Larva, Parameters as LarvaParameters};
use crate::animals::sense::Sense;
use crate::animals::wheel_commands::{Motion, WheelCommands, full_speed};
use crate::chance::Chance;
use crate::parameter::Parameter;

/// The robot's parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// The parameters of the larva as a model, which the robot follows.
    pub larva: LarvaParameters,
    /// Speed of the robot with the signal 1, in m/s; that of ARSim's robot by default.
    pub full_speed_m_s: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        Self { larva: LarvaParameters::default(), full_speed_m_s: 0.785 }
    }
}

pub(crate) const PARAMETERS: &[Parameter<Parameters>] = &[
    Parameter {
        name: "crawl_m_s",
        meaning: "speed when it does not turn, in m/s",
        range: 0.0..=10.0,
        field: |p| &mut p.larva.crawl_m_s,
    },
    Parameter {
        name: "turn_rad_s",
        meaning: "maximum turn rate, in rad/s",
        range: 0.01..=100.0,
        field: |p| &mut p.larva.turn_rad_s,
    },
    Parameter {
        name: "least_contrast",
        meaning: "contrast of the sides up to which it does not turn",
        range: 0.0..=0.99,
        field: |p| &mut p.larva.least_contrast,
    },
    Parameter {
        name: "full_contrast",
        meaning: "contrast of the sides from which it turns at the maximum rate",
        range: 0.01..=1.0,
        field: |p| &mut p.larva.full_contrast,
    },
    Parameter {
        name: "fatigue_s",
        meaning: "time constant with which the reflex tires at the maximum rate, in seconds",
        range: 0.1..=1e9,
        field: |p| &mut p.larva.fatigue_s,
    },
    Parameter {
        name: "recovery_s",
        meaning: "time in which the tired reflex recovers, in seconds",
        range: 0.1..=1e9,
        field: |p| &mut p.larva.recovery_s,
    },
    Parameter {
        name: "swing_rad",
        meaning: "angle of its swing to either side with one eye, in radians",
        range: 0.0..=PI,
        field: |p| &mut p.larva.swing_rad,
    },
    Parameter {
        name: "swing_hz",
        meaning: "swings to and fro with one eye, per second",
        range: 0.01..=10.0,
        field: |p| &mut p.larva.swing_hz,
    },
    full_speed(|p| &mut p.full_speed_m_s),
];

/// A brain that turns from the brighter side, until it is tired of it.
#[derive(Clone, Debug, PartialEq)]
pub struct LarvaBrain {
    chance: Chance,
    eyes: Sense,
    touch: Option<Sense>,
    wheels: WheelCommands,
    larva: Larva,
    turn_rad_s: f64,
    /// The instant until which the larva turns about.
    about_until_ns: u64,
}

impl LarvaBrain {
    /// A brain at its start; it flees light, or else a field. `None` if the robot has a sensor for neither.
    pub fn new(parameters: Parameters, chance: Chance, body: &Body) -> Option<Self> {
        Some(Self {
            chance,
            eyes: Sense::new(body, &[SensorKind::Light, SensorKind::Photoresistor, SensorKind::Field])?,
            touch: Sense::new(body, &[SensorKind::Bumper, SensorKind::Whisker]),
            wheels: WheelCommands::new(body, parameters.full_speed_m_s),
            larva: Larva::new(parameters.larva),
            turn_rad_s: parameters.larva.turn_rad_s,
            about_until_ns: 0,
        })
    }

    /// Begins to turn about if something touches it.
    fn feel(&mut self, turn: &Turn) {
        let Some(touch) = &mut self.touch else { return };
        if touch.look(turn) && touch.mean() > 0.0 && turn.at_ns >= self.about_until_ns {
            // Half a turn, give or take a little.
            let seconds = (PI + self.chance.uniform() - 0.5) / self.turn_rad_s;
            self.about_until_ns = turn.at_ns.saturating_add((seconds * 1e9) as u64);
        }
    }

    /// The larva's motion, by its receptors.
    fn crawl(&mut self, dt_s: f64) -> Motion {
        if let Some(sides) = self.eyes.sides() {
            return self.larva.step(sides, dt_s);
        }
        let swing_rad_s = self.larva.swing.rate_rad_s();
        let motion = self.larva.step_swinging(self.eyes.mean(), dt_s);
        Motion { turn_rate_rad_s: motion.turn_rate_rad_s + swing_rad_s, ..motion }
    }
}

impl Brain for LarvaBrain {
    fn step(&mut self, turn: &Turn) -> Action {
        let dt_s = self.wheels.seconds_since_last(turn);
        self.eyes.look(turn);
        self.feel(turn);
        let motion = if self.eyes.is_numb(turn.at_ns) {
            Motion::default()
        } else if turn.at_ns < self.about_until_ns {
            Motion { speed_m_s: 0.0, turn_rate_rad_s: self.turn_rad_s }
        } else {
            self.crawl(dt_s)
        };
        self.wheels.walk(motion, turn)
    }
}

#[cfg(test)]
mod tests {
    use baudbot_geometry::{Point, Pose};

    use super::*;
    use crate::animals::test_dish::{Dish, FULL_SPEED_M_S};
    use crate::test_body::{body, turn};

    fn brain(body: &Body) -> LarvaBrain {
        let parameters = Parameters { full_speed_m_s: FULL_SPEED_M_S, ..Parameters::default() };
        LarvaBrain::new(parameters, Chance::new(1, "alice/larva"), body).unwrap()
    }

    /// The position after so long of a robot that started 2 m beside a lamp at the origin.
    fn flees(sensors: &[(&str, &str, f64)], heading: f64, light: impl Fn(f64) -> f64) -> Point {
        let body = body(sensors);
        let mut brain = brain(&body);
        let mut dish = Dish::new(body, 10.0, Pose::new(2.0, 0.0, heading));
        dish.run(&mut brain, 25.0, |pose, _| {
            let to_lamp = -pose.position.coords;
            let cos = to_lamp.dot(&pose.direction().vector()) / to_lamp.norm();
            light(cos.max(0.0) / to_lamp.norm_squared())
        });
        dish.pose.position
    }

    #[test]
    fn a_robot_flees_a_lamp() {
        for i in 0..8 {
            let heading = PI - 0.2 - 0.7 * f64::from(i);
            let two = flees(&[("left", "light", 0.6), ("right", "light", -0.6)], heading, |lux| 100.0 * lux);
            assert!(two.coords.norm() > 3.5, "{i}: {two}");
            let one = flees(&[("eye", "light", 0.0)], heading, |lux| 100.0 * lux);
            assert!(one.coords.norm() > 3.0, "{i}: {one}");
            let counts = |lux: f64| if lux > 0.0 { (300.0 / lux).round() } else { 0.0 };
            let eyes = [("left", "photoresistor", 0.6), ("right", "photoresistor", -0.6)];
            let two = flees(&eyes, heading, counts);
            assert!(two.coords.norm() > 3.5, "{i}: {two}");
        }
    }

    #[test]
    fn what_touches_it_turns_it_about() {
        let body = body(&[("left", "light", 0.6), ("right", "light", -0.6), ("bumper", "bumper", 0.0)]);
        let mut brain = brain(&body);
        let mut step = |ms: u64, touched: f64| {
            let readings: [Option<&[f64]>; 3] = [Some(&[0.0]), Some(&[0.0]), Some(&[touched])];
            brain.step(&turn(&body, ms * 1_000_000, &readings)).signals.unwrap()
        };
        let ahead = step(0, 0.0);
        assert!(ahead.left > 0.0 && ahead.left == ahead.right);
        let about = step(200, 1.0);
        assert!(about.left < 0.0 && about.left == -about.right);
        assert_eq!(step(2000, 0.0), about);
        // Half a turn at 1 rad/s takes 2.6 s to 3.6 s.
        assert_eq!(step(4000, 0.0), ahead);
    }

    #[test]
    fn a_robot_without_eyes_has_no_such_brain() {
        assert_eq!(LarvaBrain::new(Parameters::default(), Chance::new(1, "alice"), &body(&[])), None);
    }
}
