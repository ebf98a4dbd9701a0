//! The construction of a brain for a robot from its description.

use baudbot_brain::Body;

use super::DescriptionError;
use super::raw::{By, Raw, RawDecision, RawNode, RawProcess, RawUtility, RawVariable};
use crate::composed::{Cognitive, Composed, Decision, Motor};
use crate::decision::{Condition, Layers, Machine, Node, Transition, Tree, Utility, UtilityFunction};
use crate::registry::{BuildContext, Registry, Unmade};
use crate::senses::{Mapping, Network, Senses, Source, StateVariable};

type Result<T> = std::result::Result<T, DescriptionError>;

pub(super) fn brain(raw: &Raw, seed: u64, body: &Body, registry: &Registry) -> Result<Composed> {
    let variables = raw.state_variables.iter().map(|(name, variable)| state_variable(name, variable, body));
    let senses = Senses::new(variables.collect::<Result<_>>()?, body);
    let (mut motors, mut cognitives) = (Vec::new(), Vec::new());
    let names: Vec<_> = raw.motor.keys().map(String::as_str).collect();
    let by_utility = raw.decision == RawDecision::Utility;
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
    let decision = Names::of(raw).decision(&raw.decision)?;
    Ok(Composed::new(body, senses, motors, cognitives, decision))
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
    let weight = |variable: &String| raw.weights.get(variable).copied().unwrap_or(0.0);
    Utility::new(UtilityFunction {
        tau_s: raw.tau_s,
        bias: raw.bias,
        slope: raw.slope,
        weights: all.state_variables.keys().map(weight).collect(),
        gamma_tau_s: raw.gamma_tau_s,
    })
}

/// The names that a decision may use, in order.
struct Names<'a> {
    variables: Vec<&'a str>,
    behaviors: Vec<&'a str>,
}

impl<'a> Names<'a> {
    fn of(raw: &'a Raw) -> Self {
        let variables = raw.state_variables.keys().map(String::as_str).collect();
        Self { variables, behaviors: raw.motor.keys().map(String::as_str).collect() }
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

    fn decision(&self, raw: &RawDecision) -> Result<Decision> {
        Ok(match raw {
            RawDecision::Utility => Decision::Utility,
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
        })
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
