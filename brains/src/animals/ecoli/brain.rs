//! A robot that seeks a scent, or light, as *E. coli* does.
//!
//! Deviations from the bacterium: a robot takes time to turn, so it tumbles by turning on the spot for a time drawn
//! at random; and each tumble is followed by a run that lasts a while even if it gets worse. Without it a robot
//! whose memory has settled would turn on the spot for ever, as U is 0 where X does not change.

use baudbot_brain::{Action, Body, Brain, SensorKind, Signals, Turn};

use super::{Behaviour, EColi, Parameters as CellParameters};
use crate::animals::sense::Sense;
use crate::animals::wheel_commands::WheelCommands;
use crate::chance::Chance;
use crate::parameter::{Parameter, SIGNAL};

/// The robot's parameters. By default it is as quick as a robot that wanders, and remembers for a second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// Signal of both motors on a run.
    pub forward: f64,
    /// Size of the motors' signals in a tumble.
    pub turn: f64,
    /// a of (4.1), per second.
    pub decay_hz: f64,
    /// b of (4.1), per second.
    pub gain_hz: f64,
    /// T, in the sensor's unit.
    pub threshold: f64,
    /// Shortest run, in seconds.
    pub run_s: f64,
    /// Longest tumble, in seconds; each lasts a part of it, drawn at random.
    pub tumble_s: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        let CellParameters { decay_hz, gain_hz, threshold } = CellParameters::default();
        Self { forward: 0.5, turn: 0.7, decay_hz, gain_hz, threshold, run_s: 0.5, tumble_s: 1.5 }
    }
}

pub(crate) const PARAMETERS: &[Parameter<Parameters>] = &[
    Parameter {
        name: "forward",
        meaning: "signal of both motors on a run",
        range: SIGNAL,
        field: |p| &mut p.forward,
    },
    Parameter {
        name: "turn",
        meaning: "magnitude of the motors' signals in a tumble",
        range: SIGNAL,
        field: |p| &mut p.turn,
    },
    Parameter {
        name: "decay_hz",
        meaning: "decay rate of the memory, a of (4.1), per second",
        range: 1e-3..=1e3,
        field: |p| &mut p.decay_hz,
    },
    Parameter {
        name: "gain_hz",
        meaning: "gain of the memory, b of (4.1), per second",
        range: 0.0..=1e3,
        field: |p| &mut p.gain_hz,
    },
    Parameter {
        name: "threshold",
        meaning: "improvement above which a run goes on, in the sensor's unit",
        range: -1e9..=1e9,
        field: |p| &mut p.threshold,
    },
    Parameter {
        name: "run_s",
        meaning: "shortest run, in seconds",
        range: 0.0..=60.0,
        field: |p| &mut p.run_s,
    },
    Parameter {
        name: "tumble_s",
        meaning: "longest tumble, in seconds",
        range: 0.0..=60.0,
        field: |p| &mut p.tumble_s,
    },
];

/// A brain that runs on while it gets better, and else takes a new direction at random.
#[derive(Clone, Debug, PartialEq)]
pub struct EColiBrain {
    parameters: Parameters,
    chance: Chance,
    sense: Sense,
    wheels: WheelCommands,
    cell: Option<EColi>,
    felt_ns: u64,
    wanted: Behaviour,
    state: State,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    Run { at_least_until_ns: u64 },
    Tumble { until_ns: u64, signals: Signals },
}

impl EColiBrain {
    /// A brain at its start; it feels a field, or else light. `None` if the robot has a sensor for neither.
    pub fn new(parameters: Parameters, chance: Chance, body: &Body) -> Option<Self> {
        Some(Self {
            parameters,
            chance,
            sense: Sense::new(body, &[SensorKind::Field, SensorKind::Light, SensorKind::Photoresistor])?,
            wheels: WheelCommands::new(body, 1.0),
            cell: None,
            felt_ns: 0,
            wanted: Behaviour::Swim,
            // This state is over at once, so that it begins with a run.
            state: State::Tumble { until_ns: 0, signals: Signals::default() },
        })
    }

    /// Feels what is new, and remembers it for as long as the last feeling is ago.
    fn feel(&mut self, at_ns: u64) {
        let Parameters { decay_hz, gain_hz, threshold, .. } = self.parameters;
        let fresh = EColi::new(CellParameters { decay_hz, gain_hz, threshold }, self.sense.mean());
        let cell = self.cell.get_or_insert(fresh);
        // The memory has settled after a longer pause than that.
        let dt_s = (at_ns.saturating_sub(self.felt_ns) as f64 * 1e-9).min(1.0 / decay_hz);
        self.wanted = cell.step(self.sense.mean(), dt_s);
        self.felt_ns = at_ns;
    }

    fn decide(&mut self, at_ns: u64) {
        let p = self.parameters;
        let later_ns = |seconds: f64| at_ns.saturating_add((seconds * 1e9) as u64);
        match self.state {
            State::Run { at_least_until_ns }
                if self.wanted == Behaviour::Tumble && at_ns >= at_least_until_ns =>
            {
                let until_ns = later_ns(p.tumble_s * self.chance.uniform());
                let left = if self.chance.happens(0.5) { p.turn } else { -p.turn };
                self.state = State::Tumble { until_ns, signals: Signals { left, right: -left } };
            }
            State::Tumble { until_ns, .. } if at_ns >= until_ns => {
                self.state = State::Run { at_least_until_ns: later_ns(p.run_s) };
            }
            State::Run { .. } | State::Tumble { .. } => {}
        }
    }
}

impl Brain for EColiBrain {
    fn step(&mut self, turn: &Turn) -> Action {
        if self.sense.look(turn) {
            self.feel(turn.at_ns);
        }
        if self.sense.is_numb(turn.at_ns) {
            return self.wheels.send(Signals::default(), turn);
        }
        self.decide(turn.at_ns);
        let signals = match self.state {
            State::Run { .. } => Signals { left: self.parameters.forward, right: self.parameters.forward },
            State::Tumble { signals, .. } => signals,
        };
        self.wheels.send(signals, turn)
    }
}

#[cfg(test)]
mod tests {
    use baudbot_geometry::{Pose, math};

    use super::*;
    use crate::animals::test_dish::Dish;
    use crate::test_body::{body, turn};

    fn scent(pose: &Pose) -> f64 {
        math::exp(-0.5 * pose.position.coords.norm_squared() / (1.2 * 1.2))
    }

    /// Mean distance from the source, over the last minute of two, of twenty robots that start 2.8 m from it.
    fn mean_distance(parameters: Parameters) -> f64 {
        let robots = (0..20).map(|seed| {
            let body = body(&[("nose", "field", 0.0)]);
            let mut brain = EColiBrain::new(parameters, Chance::new(seed, "alice/ecoli"), &body).unwrap();
            let mut dish = Dish::new(body, 2.5, Pose::new(2.0, -2.0, seed as f64));
            dish.run(&mut brain, 60.0, |pose, _| scent(pose));
            let seconds = (0..60).map(|_| {
                dish.run(&mut brain, 1.0, |pose, _| scent(pose));
                dish.pose.position.coords.norm()
            });
            seconds.sum::<f64>() / 60.0
        });
        robots.sum::<f64>() / 20.0
    }

    #[test]
    fn robots_gather_where_the_scent_is() {
        let (seeking, aimless) = (
            mean_distance(Parameters::default()),
            mean_distance(Parameters { threshold: 1e9, ..Parameters::default() }),
        );
        assert!(seeking < 0.8, "{seeking}");
        assert!(aimless > 1.5, "{aimless}");
    }

    #[test]
    fn it_stands_still_while_it_feels_nothing() {
        let body = body(&[("eye", "light", 0.0)]);
        let mut brain = EColiBrain::new(Parameters::default(), Chance::new(1, "alice"), &body).unwrap();
        assert_eq!(brain.step(&turn(&body, 0, &[None])), Action::drive(0.0, 0.0));
        assert_eq!(brain.step(&turn(&body, 20_000_000, &[Some(&[5.0])])), Action::drive(0.5, 0.5));
        assert_eq!(brain.step(&turn(&body, 1_100_000_000, &[None])), Action::drive(0.0, 0.0));
    }

    #[test]
    fn a_robot_with_nothing_to_feel_with_has_no_such_brain() {
        let body = body(&[("ir", "ir", 0.0)]);
        assert_eq!(EColiBrain::new(Parameters::default(), Chance::new(1, "alice"), &body), None);
    }
}
