//! The construction of a brain for a robot from its description.

use std::collections::BTreeMap;

use baudbot_brain::Body;

use super::DescriptionError;
use super::raw::{
    By, Raw, RawDecision, RawInternal, RawNode, RawProcess, RawReservoir, RawUtility, RawVariable,
};
use crate::composed::{Cognitive, Composed, Decision, Motor, Output};
use crate::decision::{
    Condition, Cooperative, Hydraulic, Layers, Machine, Node, Reservoir, Transition, Tree, Utility,
    UtilityFunction, Weight,
};
use crate::internal::{InternalState, InternalVariable};
use crate::registry::{BuildContext, Registry, Unmade};
use crate::senses::{Mapping, Network, Senses, Source, StateVariable};

type Result<T> = std::result::Result<T, DescriptionError>;

pub(super) fn brain(raw: &Raw, seed: u64, body: &Body, registry: &Registry) -> Result<Composed> {
    let variables = raw.state_variables.iter().map(|(name, variable)| state_variable(name, variable, body));
    let senses = Senses::new(variables.collect::<Result<_>>()?, body);
    let (mut motors, mut cognitives) = (Vec::new(), Vec::new());
    let names: Vec<_> = raw.motor.keys().map(String::as_str).collect();
    let by_utility = matches!(raw.decision, RawDecision::Utility { .. });
    let context = |name| BuildContext { name, body, seed, motors: &names, by_utility };
    for (name, process) in &raw.motor {
        let made = registry.motors.make(&process.kind, process.parameters.clone(), context(name.as_str()));
        let behavior = made.map_err(|unmade| problem("motor", name, process, unmade))?;
        motors.push(Motor { name: name.clone(), behavior, utility: utility(&process.utility(0.0), raw) });
    }
    // Odometry first: the others want to know where the robot is now.
    let mut ordered: Vec<_> = raw.cognitive.iter().collect();
    ordered.sort_by_key(|(_, process)| process.kind != "odometry");
    for (name, process) in ordered {
        let made =
            registry.cognitives.make(&process.kind, process.parameters.clone(), context(name.as_str()));
        let made = made.map_err(|unmade| problem("cognitive", name, process, unmade))?;
        let utility = utility(&process.utility(ALWAYS), raw);
        cognitives.push(Cognitive { name: name.clone(), process: made, utility, active: false });
    }
    let names = Names::of(raw);
    let internal = raw.internal.iter().map(|(name, variable)| names.internal(name, variable));
    let internal = InternalState::new(internal.collect::<Result<_>>()?);
    let outputs = names.outputs(raw, body)?;
    Ok(Composed::new(body, senses, internal, motors, cognitives, names.decision(raw)?).with_outputs(outputs))
}

fn problem(table: &str, name: &str, process: &RawProcess, unmade: Unmade) -> DescriptionError {
    match unmade {
        Unmade::Kind(known) => DescriptionError::new(
            format!("{table}.{name}.kind"),
            format!("there is no kind `{}`; there are: {}", process.kind, known.join(", ")),
        ),
        Unmade::Parameters(problem) => {
            let error = DescriptionError::new(format!("{table}.{name}.parameters"), problem.to_string());
            error.because(problem.cause())
        }
    }
}

fn state_variable(name: &str, raw: &RawVariable, body: &Body) -> Result<StateVariable> {
    let path = |field: &str| format!("state_variables.{name}.{field}");
    let parse = |(i, text): (usize, &String)| {
        Source::parse(text, body)
            .map_err(|error| DescriptionError::new(path(&format!("of[{i}]")), error.to_string()))
    };
    let sources = raw.of.iter().enumerate().map(parse).collect::<Result<Vec<_>>>()?;
    let values = sources.iter().map(Source::count).sum::<usize>();
    let mapping = match raw.by {
        By::Min => Mapping::Min,
        By::Max => Mapping::Max,
        By::Sum => {
            let weights = raw.weights.clone().unwrap_or_default();
            if weights.len() != values {
                let problem = format!("there are {}, and the values are {values}", weights.len());
                return Err(DescriptionError::new(path("weights"), problem));
            }
            Mapping::Sum(weights)
        }
        By::Network => {
            let network = Network { layers: raw.network.clone().unwrap_or_default() };
            if let Some(problem) = network.problem(values) {
                return Err(DescriptionError::new(format!("state_variables.{name}"), problem));
            }
            Mapping::Network(network)
        }
    };
    Ok(StateVariable { name: name.to_owned(), sources, mapping, stale_s: raw.stale_s })
}

fn utility(raw: &RawUtility, all: &Raw) -> Utility {
    let weight = |variable: &str| raw.weights.get(variable).copied().unwrap_or(0.0);
    Utility::new(UtilityFunction {
        tau_s: raw.tau_s,
        bias: raw.bias,
        slope: raw.slope,
        weights: all.variables().map(weight).collect(),
        gamma_tau_s: raw.gamma_tau_s,
    })
}

fn not_negative(path: &str, value: f64) -> Result<f64> {
    if (0.0..=MOST).contains(&value) {
        return Ok(value);
    }
    Err(DescriptionError::new(path, format!("must be from 0 to {MOST}, is {value}")))
}

/// The largest weight, rate and energy: sums and products of them stay finite.
const MOST: f64 = 1e6;

/// The names that a decision may use, in order.
struct Names<'a> {
    /// State variables first, then internal ones.
    variables: Vec<&'a str>,
    /// The number of the former.
    sensed: usize,
    behaviors: Vec<&'a str>,
}

impl<'a> Names<'a> {
    fn of(raw: &'a Raw) -> Self {
        let behaviors = raw.motor.keys().map(String::as_str).collect();
        Self { variables: raw.variables().collect(), sensed: raw.state_variables.len(), behaviors }
    }

    /// A number for each of these names, 0 for those that the table lacks.
    fn numbers(path: &str, known: &[&str], table: &BTreeMap<String, f64>) -> Result<Vec<f64>> {
        if let Some(name) = table.keys().find(|name| !known.contains(&name.as_str())) {
            let there = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
            let problem = format!("there is no `{name}`; there are: {there}");
            return Err(DescriptionError::new(format!("{path}.{name}"), problem));
        }
        Ok(known.iter().map(|name| table.get(*name).copied().unwrap_or(0.0)).collect())
    }

    /// The signals of all actuators of the body, none if the description names none.
    fn outputs(&self, raw: &Raw, body: &Body) -> Result<Vec<Output>> {
        let mut outputs =
            vec![Output::default(); if raw.actuators.is_empty() { 0 } else { body.actuators.len() }];
        for (name, output) in &raw.actuators {
            let path = format!("actuators.{name}");
            let place = body.actuator_index(name).ok_or_else(|| {
                let known: Vec<_> = body.actuators.iter().map(|actuator| actuator.name.as_str()).collect();
                let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
                DescriptionError::new(
                    path.clone(),
                    format!("the robot has no actuator `{name}`; there are: {known}"),
                )
            })?;
            let weights = Self::numbers(&format!("{path}.weights"), &self.variables, &output.weights)?;
            outputs[place] = Output { bias: output.bias, weights };
        }
        Ok(outputs)
    }

    fn internal(&self, name: &str, raw: &RawInternal) -> Result<InternalVariable> {
        let path = |field: &str| format!("internal.{name}.{field}");
        let sensed = &self.variables[..self.sensed];
        Ok(InternalVariable {
            name: name.to_owned(),
            initial: raw.initial,
            rate_hz: raw.rate_hz,
            decay_s: raw.decay_s,
            release: Self::numbers(&path("release"), sensed, &raw.release)?,
            during: Self::numbers(&path("during"), &self.behaviors, &raw.during)?,
            gain: Self::numbers(&path("gain"), sensed, &raw.gain)?,
            range: [raw.least, raw.most],
            lethal: [raw.lethal_below, raw.lethal_above],
        })
    }

    fn hydraulic(&self, reservoirs: &[RawReservoir], base: &str) -> Result<Decision> {
        let reservoir = |(i, raw): (usize, &RawReservoir)| {
            let path = |field: &str| format!("decision.reservoirs[{i}].{field}");
            let releaser =
                raw.releaser.as_ref().map(|name| self.variable(&path("releaser"), name)).transpose()?;
            let capacity = not_negative(&path("capacity"), raw.capacity)?;
            Ok(Reservoir {
                behavior: self.behavior(&path("behavior"), &raw.behavior)?,
                releaser,
                fill_hz: not_negative(&path("fill_hz"), raw.fill_hz)?,
                capacity,
                outflow_hz: not_negative(&path("outflow_hz"), raw.outflow_hz)?,
                spring: not_negative(&path("spring"), raw.spring)?,
                energy: not_negative(&path("energy"), raw.energy)?.min(capacity),
            })
        };
        if reservoirs.len() > self.behaviors.len() {
            let problem = format!("there are {}, and {} behaviours", reservoirs.len(), self.behaviors.len());
            return Err(DescriptionError::new("decision.reservoirs", problem));
        }
        let reservoirs = reservoirs.iter().enumerate().map(reservoir).collect::<Result<_>>()?;
        Ok(Decision::Hydraulic(Hydraulic::new(reservoirs, self.behavior("decision.base", base)?)))
    }

    fn variable(&self, path: &str, name: &str) -> Result<usize> {
        self.variables.iter().position(|variable| *variable == name).ok_or_else(|| {
            let known = if self.variables.is_empty() { "none".to_owned() } else { self.variables.join(", ") };
            DescriptionError::new(path, format!("there is no state variable `{name}`; there are: {known}"))
        })
    }

    fn behavior(&self, path: &str, name: &str) -> Result<usize> {
        self.behaviors.iter().position(|behavior| *behavior == name).ok_or_else(|| {
            let problem =
                format!("there is no motor behaviour `{name}`; there are: {}", self.behaviors.join(", "));
            DescriptionError::new(path, problem)
        })
    }

    fn conditions(&self, path: &str, texts: &[String]) -> Result<Vec<Condition>> {
        let parse = |(i, text): (usize, &String)| {
            Condition::parse(text, &self.variables)
                .map_err(|error| DescriptionError::new(format!("{path}[{i}]"), error.to_string()))
        };
        texts.iter().enumerate().map(parse).collect()
    }

    fn decision(&self, raw: &Raw) -> Result<Decision> {
        Ok(match &raw.decision {
            RawDecision::Utility { change_cost } => {
                Decision::Utility { change_cost: not_negative("decision.change_cost", *change_cost)? }
            }
            RawDecision::Machine { start, transitions } => {
                let transition = |(i, raw): (usize, &super::raw::RawTransition)| {
                    let path = |field: &str| format!("decision.transitions[{i}].{field}");
                    let from =
                        raw.from.as_ref().map(|from| self.behavior(&path("from"), from)).transpose()?;
                    let (to, when) =
                        (self.behavior(&path("to"), &raw.to)?, self.conditions(&path("when"), &raw.when)?);
                    Ok(Transition { from, to, when })
                };
                let transitions = transitions.iter().enumerate().map(transition).collect::<Result<_>>()?;
                Decision::Machine(Machine::new(self.behavior("decision.start", start)?, transitions))
            }
            RawDecision::Layers { layers, base } => {
                let layer = |(i, raw): (usize, &super::raw::RawLayer)| {
                    let path = |field: &str| format!("decision.layers[{i}].{field}");
                    let when = self.conditions(&path("when"), &raw.when)?;
                    Ok((when, self.behavior(&path("behavior"), &raw.behavior)?))
                };
                let layers = layers.iter().enumerate().map(layer).collect::<Result<_>>()?;
                Decision::Layers(Layers::new(layers, self.behavior("decision.base", base)?))
            }
            RawDecision::Tree { start, root } => {
                let start = self.behavior("decision.start", start)?;
                Decision::Tree(Tree::new(&self.node("decision.root", root)?, start))
            }
            RawDecision::Hydraulic { reservoirs, base } => self.hydraulic(reservoirs, base)?,
            RawDecision::Cooperative { weights } => self.cooperative(raw, weights)?,
        })
    }

    /// A behaviour without a weight has the weight 1, and one without a utility has always its weight.
    fn cooperative(&self, raw: &Raw, weights: &BTreeMap<String, f64>) -> Result<Decision> {
        Self::numbers("decision.weights", &self.behaviors, weights)?;
        let weight = |(name, process): (&String, &RawProcess)| {
            let weight = weights.get(name).copied().unwrap_or(1.0);
            let weight = not_negative(&format!("decision.weights.{name}"), weight)?;
            Ok(if process.utility.is_some() { Weight::Utility(weight) } else { Weight::Constant(weight) })
        };
        Ok(Decision::Cooperative(Cooperative::new(raw.motor.iter().map(weight).collect::<Result<_>>()?)))
    }

    fn node(&self, path: &str, raw: &RawNode) -> Result<Node> {
        let all = |name: &str, nodes: &[RawNode]| {
            let node = |(i, node): (usize, &RawNode)| self.node(&format!("{path}.{name}[{i}]"), node);
            nodes.iter().enumerate().map(node).collect::<Result<Vec<_>>>()
        };
        Ok(match raw {
            RawNode::Leaf(text) if text.contains(char::is_whitespace) => {
                let condition = Condition::parse(text, &self.variables);
                Node::Condition(condition.map_err(|error| DescriptionError::new(path, error.to_string()))?)
            }
            RawNode::Leaf(name) => Node::Behavior(self.behavior(path, name)?),
            RawNode::Select { select } => Node::Select(all("select", select)?),
            RawNode::Sequence { sequence } => Node::Sequence(all("sequence", sequence)?),
            RawNode::Invert { invert } => {
                Node::Invert(Box::new(self.node(&format!("{path}.invert"), invert)?))
            }
        })
    }
}

/// Bias of a cognitive process without a `utility`: it is always active.
const ALWAYS: f64 = 1.0;
