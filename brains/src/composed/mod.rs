//! A brain of many processes: what it senses, which of them are active, and what those do.
//!
//! In each turn: readings become state variables ([`Senses`]); the method of decision chooses; cognitive processes do their
//! step, then the one motor behaviour does. A motor behaviour is left before another is entered.

use baudbot_brain::{Action, Belief, Body, Brain, Point, Signals, Turn};

use crate::decision::utility::{self, Utility};
use crate::decision::{Layers, Machine, Tree};
use crate::estimate::Estimate;
use crate::mapping::Occupancy;
use crate::odometry::OVERDUE_NS;
use crate::process::{Beliefs, CognitiveProcess, MotorBehavior, StepContext};
use crate::senses::Senses;
use crate::throttle::CommandThrottle;

/// A brain of processes.
pub struct Composed {
    senses: Senses,
    motors: Vec<Motor>,
    cognitives: Vec<Cognitive>,
    decision: Decision,
    /// The motor behaviour that is active; `None` before the first turn.
    active: Option<usize>,
    beliefs: Beliefs,
    gammas: Vec<(String, f64)>,
    signals: Signals,
    throttle: CommandThrottle,
    /// Time that a command takes on the cable.
    command_ns: u64,
    stepped_ns: Option<u64>,
}

/// A motor behaviour of a repertoire.
pub struct Motor {
    /// The behaviour's name in the repertoire.
    pub name: String,
    /// The behaviour itself.
    pub behavior: Box<dyn MotorBehavior>,
    /// The utility by which it is chosen, where utilities decide.
    pub utility: Utility,
}

/// A cognitive process of a repertoire.
pub struct Cognitive {
    /// The process's name in the repertoire.
    pub name: String,
    /// The process itself.
    pub process: Box<dyn CognitiveProcess>,
    /// The utility by which it is active, where utilities decide. Otherwise it always is.
    pub utility: Utility,
    /// Whether it is active.
    pub active: bool,
}

/// The choice of the active behaviour.
#[derive(Clone, Debug)]
pub enum Decision {
    /// The behaviour of the greatest utility is active.
    Utility,
    /// A finite-state machine chooses.
    Machine(Machine),
    /// Layers choose: the highest one all of whose conditions hold.
    Layers(Layers),
    /// A behaviour tree chooses.
    Tree(Tree),
}

impl Composed {
    /// A brain at its start. There must be a motor behaviour, and the decision must choose among these.
    pub fn new(
        body: &Body,
        senses: Senses,
        motors: Vec<Motor>,
        cognitives: Vec<Cognitive>,
        decision: Decision,
    ) -> Self {
        Self {
            senses,
            motors,
            cognitives,
            decision,
            active: None,
            beliefs: Beliefs::default(),
            gammas: Vec::new(),
            signals: Signals::default(),
            throttle: CommandThrottle::new(body),
            command_ns: body.command_ns(),
            stepped_ns: None,
        }
    }

    /// The name of the motor behaviour that is active.
    pub fn active(&self) -> Option<&str> {
        Some(self.motors.get(self.active?)?.name.as_str())
    }

    /// The beliefs of the brain.
    pub fn beliefs(&self) -> &Beliefs {
        &self.beliefs
    }

    /// Names, utilities, and whether they are active: motor behaviours first, then cognitive processes.
    pub fn utilities(&self) -> impl Iterator<Item = (&str, f64, bool)> {
        let motors = self.motors.iter().enumerate();
        let motors =
            motors.map(|(i, motor)| (motor.name.as_str(), motor.utility.value(), self.active == Some(i)));
        let cognitives = self.cognitives.iter();
        motors
            .chain(cognitives.map(|process| (process.name.as_str(), process.utility.value(), process.active)))
    }

    /// The motor behaviour that is to be active, after so many seconds with these state variables.
    fn decide(&mut self, state: &[f64], dt_s: f64) -> usize {
        for motor in &mut self.motors {
            motor.utility.step(state, dt_s);
        }
        for process in &mut self.cognitives {
            process.utility.step(state, dt_s);
        }
        match &mut self.decision {
            Decision::Utility => {
                let utilities = self.motors.iter().map(|motor| motor.utility.value());
                utility::greatest(utilities).unwrap_or_default()
            }
            Decision::Machine(machine) => machine.step(state),
            Decision::Layers(layers) => layers.step(state),
            Decision::Tree(tree) => tree.step(state),
        }
    }

    /// Leaves the active behaviours and processes that are no longer chosen, and enters the chosen ones.
    fn activate(&mut self, chosen: usize, turn: &Turn, dt_s: f64, state: &[f64]) {
        let by_utility = matches!(self.decision, Decision::Utility);
        let (beliefs, gammas) = (&mut self.beliefs, &mut self.gammas);
        let mut context = StepContext { turn, dt_s, state, beliefs, gammas };
        for process in &mut self.cognitives {
            let active = !by_utility || process.utility.value() > 0.0;
            match (process.active, active) {
                (true, false) => process.process.leave(&mut context),
                (false, true) => process.process.enter(&mut context),
                _ => {}
            }
            process.active = active;
        }
        if self.active == Some(chosen) {
            return;
        }
        if let Some(old) = self.active.and_then(|active| self.motors.get_mut(active)) {
            old.behavior.leave(&mut context);
        }
        context.beliefs.intention.clear();
        context.beliefs.path.clear();
        if let Some(new) = self.motors.get_mut(chosen) {
            new.behavior.enter(&mut context);
        }
        self.active = Some(chosen);
    }

    /// Lets those that are active do their step.
    fn act(&mut self, turn: &Turn, dt_s: f64, state: &[f64]) {
        let (beliefs, gammas) = (&mut self.beliefs, &mut self.gammas);
        beliefs.awaited = None;
        let mut context = StepContext { turn, dt_s, state, beliefs, gammas };
        for process in self.cognitives.iter_mut().filter(|process| process.active) {
            process.process.step(&mut context);
        }
        let Some(motor) = self.active.and_then(|active| self.motors.get_mut(active)) else { return };
        let signals = motor.behavior.step(&mut context);
        let goes_by_pose = motor.behavior.goes_by_pose();
        let odometry = self.beliefs.odometry.as_ref().filter(|_| goes_by_pose);
        let is_overdue = odometry.is_some_and(|odometry| odometry.is_overdue(turn.at_ns, OVERDUE_NS));
        if is_overdue || (goes_by_pose && self.beliefs.pose.is_none()) {
            self.signals = Signals::default();
        } else if let Some(signals) = signals {
            let haste = odometry.map_or(1.0, |odometry| odometry.haste(self.command_ns));
            self.signals = Signals { left: haste * signals.left, right: haste * signals.right };
        }
    }

    /// Gives processes the Γ that others set for them.
    fn hand_out_gammas(&mut self) {
        for (name, gamma) in self.gammas.drain(..) {
            let motors = self.motors.iter_mut().map(|motor| (&motor.name, &mut motor.utility));
            let cognitives = self.cognitives.iter_mut().map(|process| (&process.name, &mut process.utility));
            if let Some((_, utility)) = motors.chain(cognitives).find(|(whose, _)| **whose == name) {
                utility.set_gamma(gamma);
            }
        }
    }
}

impl Brain for Composed {
    fn step(&mut self, turn: &Turn) -> Action {
        let dt_s = self.stepped_ns.map_or(0.0, |before| turn.at_ns.saturating_sub(before) as f64 * 1e-9);
        self.stepped_ns = Some(turn.at_ns);
        let state = self.senses.take(turn).to_vec();
        let chosen = self.decide(&state, dt_s);
        self.activate(chosen, turn, dt_s, &state);
        self.act(turn, dt_s, &state);
        self.hand_out_gammas();
        self.throttle.send(turn, self.signals)
    }

    fn belief(&mut self) -> Option<Belief> {
        let awaited = self.beliefs.awaited.as_ref().map(ToString::to_string);
        let state = match (self.active(), awaited.as_deref().unwrap_or(&self.beliefs.intention)) {
            (Some(active), "") => active.to_owned(),
            (Some(active), intention) => format!("{active}: {intention}"),
            (None, _) => String::new(),
        };
        let utilities = self.utilities().map(|(name, value, active)| baudbot_brain::Utility {
            name: name.to_owned(),
            value,
            active,
        });
        let path =
            self.beliefs.path.iter().take(SHOWN_POINTS).map(|point| Point { x_m: point.x, y_m: point.y });
        Some(Belief {
            state,
            utilities: utilities.collect(),
            pose: self.beliefs.pose.as_ref().map(Estimate::shown),
            path: path.collect(),
            map: self.beliefs.grid.as_ref().map(Occupancy::shown),
            ..Belief::default()
        })
    }
}

/// More points of a path make no visible difference.
const SHOWN_POINTS: usize = 1000;

#[cfg(test)]
mod tests;
