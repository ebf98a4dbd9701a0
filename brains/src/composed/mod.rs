//! A brain of many processes: what it senses, which of them are active, and what those do.
//!
//! In each turn: readings become state variables ([`Senses`]); the method of decision chooses; cognitive processes do their
//! step, then the one motor behaviour does, or all that drive together. Motor behaviours are left before others are entered.

mod motivation;

use baudbot_brain::{Action, Belief, Body, Brain, Point, Signals, Turn};

use crate::decision::utility::{self, Utility};
use crate::decision::{Cooperative, Hydraulic, Layers, Machine, Tree};
use crate::estimate::Estimate;
use crate::internal::InternalState;
use crate::mapping::Occupancy;
use crate::odometry::OVERDUE_NS;
use crate::process::{Beliefs, CognitiveProcess, MotorBehavior, StepContext};
use crate::senses::Senses;
use crate::throttle::CommandThrottle;

/// A brain of processes.
pub struct Composed {
    pub(crate) senses: Senses,
    pub(crate) internal: InternalState,
    pub(crate) motors: Vec<Motor>,
    cognitives: Vec<Cognitive>,
    pub(crate) decision: Decision,
    /// The signals of the actuators besides the wheels, in the order of the body; empty if the brain uses none.
    outputs: Vec<Output>,
    /// The motor behaviour that is active, or has the greatest weight; `None` before the first turn.
    active: Option<usize>,
    /// Whether each motor behaviour drives.
    driving: Vec<bool>,
    beliefs: Beliefs,
    gammas: Vec<(String, f64)>,
    signals: Signals,
    throttle: CommandThrottle,
    /// Time that a command takes on the cable.
    command_ns: u64,
    stepped_ns: Option<u64>,
}

/// The signal of an actuator besides the wheels: u = b + Σ w z, within [-1, 1].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Output {
    /// b: the signal if all else is 0.
    pub bias: f64,
    /// w: one for each state variable, none for all 0.
    pub weights: Vec<f64>,
}

impl Output {
    /// The signal for these state variables. What is no number counts as 0.
    pub fn signal(&self, state: &[f64]) -> f64 {
        let sum: f64 = self.weights.iter().zip(state).map(|(weight, z)| weight * z).sum();
        let signal = self.bias + sum;
        if signal.is_nan() { 0.0 } else { signal.clamp(-1.0, 1.0) }
    }
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
    Utility {
        /// Another behaviour becomes active only if its utility is greater by more than this: the cost of changing (Section 7.2.1).
        change_cost: f64,
    },
    /// A finite-state machine chooses.
    Machine(Machine),
    /// Layers choose: the highest one all of whose conditions hold.
    Layers(Layers),
    /// A behaviour tree chooses.
    Tree(Tree),
    /// The energy of reservoirs chooses.
    Hydraulic(Hydraulic),
    /// All behaviours that have a weight drive together.
    Cooperative(Cooperative),
}

impl Decision {
    /// Lets the behaviour at this place drive alone, as it runs to its end. Energy flows meanwhile.
    fn stay(&mut self, place: usize, state: &[f64], dt_s: f64) {
        match self {
            Self::Hydraulic(hydraulic) => _ = hydraulic.step(state, dt_s),
            Self::Cooperative(cooperative) => cooperative.give_all_to(place),
            Self::Utility { .. } | Self::Machine(_) | Self::Layers(_) | Self::Tree(_) => {}
        }
    }

    /// Whether the behaviour at this place drives if that at another place is chosen.
    fn drives(&self, place: usize, chosen: usize) -> bool {
        match self {
            Self::Cooperative(cooperative) => cooperative.share(place) > 0.0,
            Self::Utility { .. }
            | Self::Machine(_)
            | Self::Layers(_)
            | Self::Tree(_)
            | Self::Hydraulic(_) => place == chosen,
        }
    }
}

impl Composed {
    /// A brain at its start. There must be a motor behaviour, and the decision must choose among these.
    pub fn new(
        body: &Body,
        senses: Senses,
        internal: InternalState,
        motors: Vec<Motor>,
        cognitives: Vec<Cognitive>,
        decision: Decision,
    ) -> Self {
        let driving = vec![false; motors.len()];
        Self {
            senses,
            internal,
            motors,
            cognitives,
            decision,
            outputs: Vec::new(),
            active: None,
            driving,
            beliefs: Beliefs::default(),
            gammas: Vec::new(),
            signals: Signals::default(),
            throttle: CommandThrottle::new(body),
            command_ns: body.command_ns(),
            stepped_ns: None,
        }
    }

    /// The same with signals for the actuators besides the wheels, one for each of the body's.
    #[must_use]
    pub fn with_outputs(mut self, outputs: Vec<Output>) -> Self {
        self.outputs = outputs;
        self
    }

    /// The name of the motor behaviour that is active, or has the greatest weight.
    pub fn active(&self) -> Option<&str> {
        Some(self.motors.get(self.active?)?.name.as_str())
    }

    /// The beliefs of the brain.
    pub fn beliefs(&self) -> &Beliefs {
        &self.beliefs
    }

    /// Names, utilities, and whether they are active: motor behaviours first, then cognitive processes.
    pub fn utilities(&self) -> impl Iterator<Item = (&str, f64, bool)> {
        let motors = self.motors.iter().zip(&self.driving);
        let motors = motors.map(|(motor, drives)| (motor.name.as_str(), motor.utility.value(), *drives));
        let cognitives = self.cognitives.iter();
        motors
            .chain(cognitives.map(|process| (process.name.as_str(), process.utility.value(), process.active)))
    }

    /// The motor behaviour that is to be active, after so many seconds with these state variables. Of utilities, another one must be
    /// greater by the cost of changing (§7.2.1).
    fn decide(&mut self, state: &[f64], dt_s: f64) -> usize {
        for motor in &mut self.motors {
            motor.utility.step(state, dt_s);
        }
        for process in &mut self.cognitives {
            process.utility.step(state, dt_s);
        }
        let mut driving = self.motors.iter().zip(&self.driving);
        let fixed = driving.position(|(motor, drives)| *drives && motor.behavior.is_fixed());
        if let Some(fixed) = fixed {
            self.decision.stay(fixed, state, dt_s);
            return fixed;
        }
        match &mut self.decision {
            Decision::Utility { change_cost } => {
                let value = |place: usize| self.motors[place].utility.value();
                let best = utility::greatest((0..self.motors.len()).map(value)).unwrap_or_default();
                let stays =
                    |active: &usize| *change_cost > 0.0 && value(best) <= value(*active) + *change_cost;
                self.active.filter(stays).unwrap_or(best)
            }
            Decision::Machine(machine) => machine.step(state),
            Decision::Layers(layers) => layers.step(state),
            Decision::Tree(tree) => tree.step(state),
            Decision::Hydraulic(hydraulic) => hydraulic.step(state, dt_s),
            Decision::Cooperative(cooperative) => {
                cooperative.step(self.motors.iter().map(|motor| motor.utility.value()))
            }
        }
    }

    /// Leaves the active behaviours and processes that are no longer chosen, and enters the chosen ones.
    fn activate(&mut self, chosen: usize, turn: &Turn, dt_s: f64, state: &[f64]) {
        let by_utility = matches!(self.decision, Decision::Utility { .. });
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
        self.active = Some(chosen);
        let drives = (0..self.motors.len()).map(|place| self.decision.drives(place, chosen));
        if drives.clone().eq(self.driving.iter().copied()) {
            return;
        }
        let drives: Vec<_> = drives.collect();
        let changes = self.driving.iter().zip(&drives);
        for (motor, _) in
            self.motors.iter_mut().zip(changes.clone()).filter(|(_, (old, new))| **old && !**new)
        {
            motor.behavior.leave(&mut context);
        }
        context.beliefs.intention.clear();
        context.beliefs.path.clear();
        for (motor, _) in self.motors.iter_mut().zip(changes).filter(|(_, (old, new))| !**old && **new) {
            motor.behavior.enter(&mut context);
        }
        self.driving = drives;
    }

    /// Lets those that are active do their step.
    fn act(&mut self, turn: &Turn, dt_s: f64, state: &[f64]) {
        let (beliefs, gammas) = (&mut self.beliefs, &mut self.gammas);
        beliefs.awaited = None;
        let mut context = StepContext { turn, dt_s, state, beliefs, gammas };
        for process in self.cognitives.iter_mut().filter(|process| process.active) {
            process.process.step(&mut context);
        }
        let driving =
            self.motors.iter_mut().zip(&self.driving).enumerate().filter(|(_, (_, drives))| **drives);
        for (place, (motor, _)) in driving {
            let signals = motor.behavior.step(&mut context);
            let by_pose = motor.behavior.goes_by_pose();
            let Some(signals) = allowed(signals, by_pose, &context, self.command_ns) else { continue };
            match &mut self.decision {
                Decision::Cooperative(cooperative) => cooperative.suggest(place, signals),
                Decision::Utility { .. }
                | Decision::Machine(_)
                | Decision::Layers(_)
                | Decision::Tree(_)
                | Decision::Hydraulic(_) => self.signals = signals,
            }
        }
        if let Decision::Cooperative(cooperative) = &self.decision {
            self.signals = cooperative.command();
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

/// The part of a behaviour's signals that the age of its odometry allows.
fn allowed(
    signals: Option<Signals>,
    goes_by_pose: bool,
    context: &StepContext<'_>,
    command_ns: u64,
) -> Option<Signals> {
    let beliefs = &context.beliefs;
    let odometry = beliefs.odometry.as_ref().filter(|_| goes_by_pose);
    let is_overdue = odometry.is_some_and(|odometry| odometry.is_overdue(context.turn.at_ns, OVERDUE_NS));
    if is_overdue || (goes_by_pose && beliefs.pose.is_none()) {
        return Some(Signals::default());
    }
    let haste = odometry.map_or(1.0, |odometry| odometry.haste(command_ns));
    signals.map(|signals| Signals { left: haste * signals.left, right: haste * signals.right })
}

impl Brain for Composed {
    fn step(&mut self, turn: &Turn) -> Action {
        let dt_s = self.stepped_ns.map_or(0.0, |before| turn.at_ns.saturating_sub(before) as f64 * 1e-9);
        self.stepped_ns = Some(turn.at_ns);
        let mut state = self.senses.take(turn).to_vec();
        self.internal.step(&state, &self.driving, dt_s);
        self.internal.extend(&mut state);
        if self.internal.dead().is_some() {
            self.signals = Signals::default();
            return self.throttle.send_with(turn, self.signals, &vec![0.0; self.outputs.len()]);
        }
        let chosen = self.decide(&state, dt_s);
        self.activate(chosen, turn, dt_s, &state);
        self.act(turn, dt_s, &state);
        self.hand_out_gammas();
        let others: Vec<_> = self.outputs.iter().map(|output| output.signal(&state)).collect();
        self.throttle.send_with(turn, self.signals, &others)
    }

    fn belief(&mut self) -> Option<Belief> {
        let awaited = self.beliefs.awaited.as_ref().map(ToString::to_string);
        let dead = self.internal.dead().map(|variable| format!("dead, by {variable}"));
        let state = match (self.active(), awaited.as_deref().unwrap_or(&self.beliefs.intention)) {
            (Some(active), "") => active.to_owned(),
            (Some(active), intention) => format!("{active}: {intention}"),
            (None, _) => String::new(),
        };
        let stands = self.active.is_some() && !self.driving.contains(&true);
        let state = dead.or_else(|| stands.then(|| "stands".to_owned())).unwrap_or(state);
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
            motivation: self.motivation(),
            ..Belief::default()
        })
    }
}

/// More points of a path make no visible difference.
const SHOWN_POINTS: usize = 1000;

#[cfg(test)]
mod tests;
