//! A robot that answers what troubles it as Stentor does.
//!
//! The readings of its sensors are X, so the world takes the place of (7.14) and (7.15) of the model: X stays high while
//! the robot stays, and falls when it drives off. It feeds by standing still, turns away on the spot, drives backwards slowly
//! for the reversal of its cilia, stands still when it contracts, and detaches by driving off.
//!
//! With `water` = 1 the model's own water, (7.14) and (7.15), troubles it in place of its sensors, so that a run has the course of
//! Fig. 7.4 in the utilities that the brain publishes.
//!
//! Deviations: steps longer than a twentieth of a second are divided, as Euler's method asks for. The notes do not say which
//! way it turns: with sensors on both sides it is from the one that feels more, otherwise to a side drawn at random.

use baudbot_brain::{Action, Belief, Body, Brain, SensorKind, Turn, Utility};

use super::{Behaviour, Parameters as CellParameters, Stentor, Water};
use crate::animals::sense::{Sense, Sides};
use crate::animals::wheel_commands::{Motion, WheelCommands, full_speed};
use crate::chance::Chance;
use crate::parameter::Parameter;

/// The robot's parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// The parameters of the cell as a model, which the robot follows.
    pub cell: CellParameters,
    /// Whether the model's water troubles it (from 0.5 on), and not the world.
    pub water: f64,
    /// The constants of that water.
    pub model: Water,
    /// X for each unit of what the sensors feel. The model's constants suit an X up to 1 or so.
    pub sensitivity: f64,
    /// The rate of turning away, in rad/s.
    pub turn_rad_s: f64,
    /// The speed backwards, in m/s.
    pub reverse_m_s: f64,
    /// The speed at which it swims off, in m/s.
    pub detach_m_s: f64,
    /// Speed of the robot with the signal 1, in m/s; that of ARSim's robot by default.
    pub full_speed_m_s: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            cell: CellParameters::default(),
            water: 0.0,
            model: Water::default(),
            sensitivity: 1.0,
            turn_rad_s: 0.6,
            reverse_m_s: 0.1,
            detach_m_s: 0.3,
            full_speed_m_s: 0.785,
        }
    }
}

pub(crate) const PARAMETERS: &[Parameter<Parameters>] = &[
    Parameter {
        name: "feeding",
        meaning: "utility of feeding, C",
        range: 1e-6..=1e6,
        field: |p| &mut p.cell.feeding,
    },
    Parameter {
        name: "turn_gain_hz",
        meaning: "gain of the utility of turning away, b2 of (7.12), per second",
        range: 0.0..=1e3,
        field: |p| &mut p.cell.gain_hz[0],
    },
    Parameter {
        name: "reverse_gain_hz",
        meaning: "gain of the utility of reversing, b3 of (7.12), per second",
        range: 0.0..=1e3,
        field: |p| &mut p.cell.gain_hz[1],
    },
    Parameter {
        name: "contract_gain_hz",
        meaning: "gain of the utility of contracting, b4 of (7.12), per second",
        range: 0.0..=1e3,
        field: |p| &mut p.cell.gain_hz[2],
    },
    Parameter {
        name: "detach_gain_hz",
        meaning: "gain of the utility of detaching, b5 of (7.12), per second",
        range: 0.0..=1e3,
        field: |p| &mut p.cell.gain_hz[3],
    },
    Parameter {
        name: "turn_decay_hz",
        meaning: "decay rate of the utility of turning away, a2 of (7.12), per second",
        range: 0.0..=MOST_DECAY_HZ,
        field: |p| &mut p.cell.decay_hz[0],
    },
    Parameter {
        name: "reverse_decay_hz",
        meaning: "decay rate of the utility of reversing, a3 of (7.12), per second",
        range: 0.0..=MOST_DECAY_HZ,
        field: |p| &mut p.cell.decay_hz[1],
    },
    Parameter {
        name: "contract_decay_hz",
        meaning: "decay rate of the utility of contracting, a4 of (7.12), per second",
        range: 0.0..=MOST_DECAY_HZ,
        field: |p| &mut p.cell.decay_hz[2],
    },
    Parameter {
        name: "detach_decay_hz",
        meaning: "decay rate of the utility of detaching, a5 of (7.12), per second",
        range: 0.0..=MOST_DECAY_HZ,
        field: |p| &mut p.cell.decay_hz[3],
    },
    Parameter {
        name: "water",
        meaning: "1: the model's water troubles it, (7.14) and (7.15), and not its sensors",
        range: 0.0..=1.0,
        field: |p| &mut p.water,
    },
    Parameter {
        name: "concentration",
        meaning: "X of the model's water at first",
        range: 0.0..=1e6,
        field: |p| &mut p.model.concentration,
    },
    Parameter {
        name: "feeding_decay_hz",
        meaning: "loss of X while it feeds, k1 of (7.14), per second",
        range: 0.0..=MOST_DECAY_HZ,
        field: |p| &mut p.model.feeding_decay_hz,
    },
    Parameter {
        name: "feeding_inflow_hz",
        meaning: "inflow of X while it feeds, X1 of (7.14), per second",
        range: 0.0..=1e6,
        field: |p| &mut p.model.feeding_inflow_hz,
    },
    Parameter {
        name: "avoiding_decay_hz",
        meaning: "loss of X while it avoids, k2 of (7.15), per second",
        range: 0.0..=MOST_DECAY_HZ,
        field: |p| &mut p.model.avoiding_decay_hz,
    },
    Parameter {
        name: "avoiding_inflow_hz",
        meaning: "inflow of X while it avoids, X2 of (7.15), per second",
        range: 0.0..=1e6,
        field: |p| &mut p.model.avoiding_inflow_hz,
    },
    Parameter {
        name: "sensitivity",
        meaning: "X per unit of the sensors' readings",
        range: 0.0..=1e9,
        field: |p| &mut p.sensitivity,
    },
    Parameter {
        name: "turn_rad_s",
        meaning: "turn rate when turning away, in rad/s",
        range: 0.0..=100.0,
        field: |p| &mut p.turn_rad_s,
    },
    Parameter {
        name: "reverse_m_s",
        meaning: "speed when reversing, in m/s",
        range: 0.0..=10.0,
        field: |p| &mut p.reverse_m_s,
    },
    Parameter {
        name: "detach_m_s",
        meaning: "speed when driving off, in m/s",
        range: 0.0..=10.0,
        field: |p| &mut p.detach_m_s,
    },
    full_speed(|p| &mut p.full_speed_m_s),
];

/// A brain of five behaviours, the strongest of which it takes only when the others do not help.
#[derive(Clone, Debug, PartialEq)]
pub struct StentorBrain {
    parameters: Parameters,
    chance: Chance,
    trouble: Trouble,
    wheels: WheelCommands,
    cell: Stentor,
    behaviour: Behaviour,
    /// The rate of turning, in rad/s; to the left if positive.
    turn_rad_s: f64,
}

/// The origin of X.
#[derive(Clone, Debug, PartialEq)]
enum Trouble {
    /// The sensors of the robot.
    World(Sense),
    /// The water of the model.
    Model(Water),
}

impl Trouble {
    /// The sides that feel it, if there are any.
    fn sides(&self) -> Option<Sides> {
        match self {
            Self::World(sense) => sense.sides(),
            Self::Model(_) => None,
        }
    }
}

impl StentorBrain {
    /// A brain at its start. What troubles it is a field, or else light, or else what touches it or is near. `None` if the
    /// robot senses none of these, and the model's water is not to trouble it.
    pub fn new(parameters: Parameters, chance: Chance, body: &Body) -> Option<Self> {
        let trouble = match parameters.water >= 0.5 {
            true => Trouble::Model(parameters.model),
            false => Trouble::World(Sense::new(body, &FELT)?),
        };
        Some(Self {
            parameters,
            chance,
            trouble,
            wheels: WheelCommands::new(body, parameters.full_speed_m_s),
            cell: Stentor::new(parameters.cell),
            behaviour: Behaviour::Feed,
            turn_rad_s: parameters.turn_rad_s,
        })
    }

    /// Goes on with the model for so long.
    fn feel(&mut self, dt_s: f64) {
        let before = self.behaviour;
        // A pause of more than a minute has forgotten all before it.
        let steps = (dt_s.min(60.0) / LONGEST_STEP_S).ceil().max(1.0);
        let step_s = dt_s.min(60.0) / steps;
        for _ in 0..steps as u32 {
            match &mut self.trouble {
                Trouble::World(sense) => {
                    let concentration = self.parameters.sensitivity * sense.mean().max(0.0);
                    self.behaviour = self.cell.step(concentration, step_s);
                }
                Trouble::Model(water) => {
                    self.behaviour = self.cell.step(water.concentration, step_s);
                    water.step(self.behaviour, step_s);
                }
            }
        }
        if self.behaviour == Behaviour::TurnAway && before != Behaviour::TurnAway {
            self.turn_rad_s = self.away() * self.parameters.turn_rad_s;
        }
    }

    /// 1 for a turn to the left, −1 for one to the right.
    fn away(&mut self) -> f64 {
        match self.trouble.sides() {
            Some(sides) if sides.left > sides.right => -1.0,
            Some(sides) if sides.left < sides.right => 1.0,
            _ if self.chance.happens(0.5) => 1.0,
            _ => -1.0,
        }
    }

    fn motion(&self) -> Motion {
        let still = Motion::default();
        match self.behaviour {
            Behaviour::Feed | Behaviour::Contract => still,
            Behaviour::TurnAway => Motion { turn_rate_rad_s: self.turn_rad_s, ..still },
            Behaviour::ReverseCilia => Motion { speed_m_s: -self.parameters.reverse_m_s, ..still },
            Behaviour::Detach => Motion { speed_m_s: self.parameters.detach_m_s, ..still },
        }
    }
}

impl Brain for StentorBrain {
    fn step(&mut self, turn: &Turn) -> Action {
        let dt_s = self.wheels.seconds_since_last(turn);
        if let Trouble::World(sense) = &mut self.trouble {
            sense.look(turn);
            if sense.is_numb(turn.at_ns) {
                return self.wheels.walk(Motion::default(), turn);
            }
        }
        self.feel(dt_s);
        self.wheels.walk(self.motion(), turn)
    }

    fn belief(&mut self) -> Option<Belief> {
        let utilities = NAMES.iter().zip(self.cell.utilities()).map(|(&(behaviour, name), value)| Utility {
            name: name.to_owned(),
            value,
            active: behaviour == self.behaviour,
        });
        let utilities: Vec<_> = utilities.collect();
        let state = utilities.iter().find(|utility| utility.active).map(|utility| utility.name.clone());
        Some(Belief { state: state.unwrap_or_default(), utilities, ..Belief::default() })
    }
}

/// Sensors that may touch it, in order of their likeness to a particle.
const FELT: [SensorKind; 5] = [
    SensorKind::Field,
    SensorKind::Light,
    SensorKind::Photoresistor,
    SensorKind::Bumper,
    SensorKind::Infrared,
];

/// The words for observers.
const NAMES: [(Behaviour, &str); 5] = [
    (Behaviour::Feed, "feed"),
    (Behaviour::TurnAway, "turn_away"),
    (Behaviour::ReverseCilia, "reverse"),
    (Behaviour::Contract, "contract"),
    (Behaviour::Detach, "detach"),
];

/// A fifth of the least time constant that a Stentor has by default.
const LONGEST_STEP_S: f64 = 0.05;
/// Euler's method does not overshoot in such a step.
const MOST_DECAY_HZ: f64 = 1.0 / LONGEST_STEP_S;

#[cfg(test)]
mod tests {
    use baudbot_geometry::{Pose, math};

    use super::*;
    use crate::animals::test_dish::{Dish, FULL_SPEED_M_S};
    use crate::test_body::{body, turn};

    fn brain(body: &Body) -> StentorBrain {
        let parameters = Parameters { full_speed_m_s: FULL_SPEED_M_S, ..Parameters::default() };
        StentorBrain::new(parameters, Chance::new(1, "alice/stentor"), body).unwrap()
    }

    /// The behaviours in turn for so many seconds, from the middle of something noxious, and the last distance from it.
    fn escapes(seconds: f64, strength: f64) -> (Vec<Behaviour>, f64) {
        let body = body(&[("skin", "field", 0.0)]);
        let mut brain = brain(&body);
        let mut dish = Dish::new(body, 50.0, Pose::new(0.1, 0.0, 1.0));
        let mut behaviours = vec![Behaviour::Feed];
        for _ in 0..(seconds / 0.02) as u32 {
            dish.run(&mut brain, 0.021, |pose, _| {
                strength * math::exp(-0.5 * pose.position.coords.norm_squared())
            });
            if behaviours.last() != Some(&brain.behaviour) {
                behaviours.push(brain.behaviour);
            }
        }
        (behaviours, dish.pose.position.coords.norm())
    }

    #[test]
    fn it_tries_what_costs_little_before_it_drives_off() {
        use Behaviour::*;
        let (behaviours, distance_m) = escapes(60.0, 0.5);
        assert_eq!(behaviours[..5], [Feed, TurnAway, ReverseCilia, Contract, Detach]);
        assert_eq!(behaviours.last(), Some(&Feed), "it feeds again where it is clean: {behaviours:?}");
        // There X is 0.1352, and less: 0.8 a5 / b5.
        assert!(distance_m > math::sqrt(2.0 * (0.5_f64 / 0.1352).ln()), "{distance_m}");
        let (behaviours, distance_m) = escapes(60.0, 0.13);
        assert_eq!((behaviours.as_slice(), distance_m < 0.11), (&[Feed][..], true), "too weak to trouble it");
    }

    /// Figure 7.4 by a brain of the catalogue, in turns of 10 ms; the times are those of the model itself.
    #[test]
    fn the_model_s_water_gives_figure_7_4_to_a_robot_without_senses() {
        use Behaviour::*;
        let body = body(&[]);
        let parameters = Parameters { water: 1.0, ..Parameters::default() };
        let mut brain = StentorBrain::new(parameters, Chance::new(1, "alice/stentor"), &body).unwrap();
        let mut begun = vec![];
        for step in 0..700 {
            brain.step(&turn(&body, step * 10_000_000, &[]));
            if begun.last().is_none_or(|(behaviour, _)| *behaviour != brain.behaviour) {
                begun.push((brain.behaviour, 0.01 * step as f64));
            }
        }
        let figures = [(Feed, 0.0), (TurnAway, 0.37), (ReverseCilia, 1.71), (Contract, 3.35), (Detach, 5.13)];
        for ((behaviour, at_s), (wanted, figure_s)) in begun.iter().zip(figures) {
            assert!(*behaviour == wanted && (at_s - figure_s).abs() < 0.025, "{begun:?}");
        }
        assert!(begun.len() > figures.len(), "{begun:?}");
    }

    #[test]
    fn it_turns_away_from_the_side_that_feels_more() {
        let body = body(&[("left", "field", 0.5), ("right", "field", -0.5)]);
        for (left, right, sign) in [(0.6, 0.3, -1.0), (0.3, 0.6, 1.0)] {
            let mut brain = brain(&body);
            let turns: Vec<_> = (0..60)
                .map(|step| {
                    brain.step(&turn(&body, step * 20_000_000, &[Some(&[left]), Some(&[right])]));
                    brain.motion().turn_rate_rad_s
                })
                .collect();
            assert!(turns.iter().any(|turn| turn * sign > 0.0), "{turns:?}");
            assert!(turns.iter().all(|turn| turn * sign >= 0.0), "{turns:?}");
        }
    }

    #[test]
    fn a_pause_makes_no_difference_that_is_seen() {
        let body = body(&[("skin", "field", 0.0)]);
        let after = |step_ns: u64| {
            let mut brain = brain(&body);
            for step in 0..=800_000_000 / step_ns {
                brain.step(&turn(&body, step * step_ns, &[Some(&[0.5])]));
            }
            brain.cell.utilities()
        };
        let (often, seldom) = (after(10_000_000), after(400_000_000));
        for (a, b) in often.into_iter().zip(seldom) {
            assert!((a - b).abs() < 0.05, "{often:?} {seldom:?}");
        }
    }

    #[test]
    fn what_it_believes_has_the_five_utilities_and_one_is_active() {
        let body = body(&[("skin", "bumper", 0.0)]);
        let mut brain = brain(&body);
        assert_eq!(brain.step(&turn(&body, 0, &[None])), Action::drive(0.0, 0.0), "it feels nothing yet");
        for step in 1..100 {
            brain.step(&turn(&body, step * 20_000_000, &[Some(&[1.0])]));
        }
        let belief = brain.belief().unwrap();
        assert_eq!(belief.utilities.len(), 5);
        let active: Vec<_> = belief.utilities.iter().filter(|utility| utility.active).collect();
        assert!(matches!(active.as_slice(), [one] if one.name == belief.state), "{belief:?}");
        assert_eq!(
            StentorBrain::new(Parameters::default(), Chance::new(1, ""), &crate::test_body::body(&[])),
            None
        );
    }
}
