//! A description as it stands in the text.

use std::collections::BTreeMap;

use serde::Deserialize;
use toml::Table;

use super::DescriptionError;
use super::policy::RawPolicy;

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Raw {
    #[serde(default)]
    pub(super) description: String,
    #[serde(default)]
    pub(super) state_variables: BTreeMap<String, RawVariable>,
    #[serde(default)]
    pub(super) internal: BTreeMap<String, RawInternal>,
    #[serde(default)]
    pub(super) motor: BTreeMap<String, RawProcess>,
    #[serde(default)]
    pub(super) cognitive: BTreeMap<String, RawProcess>,
    #[serde(default)]
    pub(super) actuators: BTreeMap<String, RawOutput>,
    #[serde(default)]
    pub(super) decision: RawDecision,
    pub(super) policy: Option<RawPolicy>,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawVariable {
    pub(super) of: Vec<String>,
    pub(super) by: By,
    pub(super) weights: Option<Vec<f64>>,
    pub(super) network: Option<Vec<Vec<Vec<f64>>>>,
    pub(super) stale_s: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum By {
    Sum,
    Min,
    Max,
    Network,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct RawInternal {
    pub(super) initial: f64,
    pub(super) rate_hz: f64,
    pub(super) decay_s: Option<f64>,
    pub(super) release: BTreeMap<String, f64>,
    pub(super) during: BTreeMap<String, f64>,
    pub(super) gain: BTreeMap<String, f64>,
    pub(super) least: f64,
    pub(super) most: f64,
    pub(super) lethal_below: Option<f64>,
    pub(super) lethal_above: Option<f64>,
}

impl Default for RawInternal {
    fn default() -> Self {
        Self {
            initial: 0.0,
            rate_hz: 0.0,
            decay_s: None,
            release: BTreeMap::new(),
            during: BTreeMap::new(),
            gain: BTreeMap::new(),
            least: 0.0,
            most: 1.0,
            lethal_below: None,
            lethal_above: None,
        }
    }
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawReservoir {
    pub(super) behavior: String,
    pub(super) releaser: Option<String>,
    pub(super) fill_hz: f64,
    #[serde(default = "one")]
    pub(super) capacity: f64,
    #[serde(default = "one")]
    pub(super) outflow_hz: f64,
    pub(super) spring: f64,
    #[serde(default)]
    pub(super) energy: f64,
}

fn one() -> f64 {
    1.0
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawProcess {
    pub(super) kind: String,
    #[serde(default)]
    pub(super) parameters: Table,
    pub(super) utility: Option<RawUtility>,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawOutput {
    #[serde(default)]
    pub(super) bias: f64,
    #[serde(default)]
    pub(super) weights: BTreeMap<String, f64>,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct RawUtility {
    pub(super) tau_s: f64,
    pub(super) bias: f64,
    pub(super) slope: f64,
    pub(super) weights: BTreeMap<String, f64>,
    pub(super) gamma_tau_s: f64,
}

impl Default for RawUtility {
    fn default() -> Self {
        Self { tau_s: 0.1, bias: 0.0, slope: 1.0, weights: BTreeMap::new(), gamma_tau_s: 0.3 }
    }
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "method", rename_all = "lowercase", deny_unknown_fields)]
pub(super) enum RawDecision {
    Utility {
        #[serde(default)]
        change_cost: f64,
    },
    Machine {
        start: String,
        #[serde(default)]
        transitions: Vec<RawTransition>,
    },
    Layers {
        layers: Vec<RawLayer>,
        base: String,
    },
    Tree {
        start: String,
        root: RawNode,
    },
    Hydraulic {
        reservoirs: Vec<RawReservoir>,
        base: String,
    },
    Cooperative {
        #[serde(default)]
        weights: BTreeMap<String, f64>,
    },
}

impl Default for RawDecision {
    fn default() -> Self {
        Self::Utility { change_cost: 0.0 }
    }
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawTransition {
    pub(super) from: Option<String>,
    pub(super) to: String,
    pub(super) when: Vec<String>,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawLayer {
    pub(super) behavior: String,
    pub(super) when: Vec<String>,
}

/// A text is a behaviour's name, or a condition if there are spaces in it.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(
    untagged,
    expecting = "must be a behaviour, a condition, { select = […] }, { sequence = […] } or { invert = … }"
)]
pub(super) enum RawNode {
    Leaf(String),
    Select { select: Vec<Self> },
    Sequence { sequence: Vec<Self> },
    Invert { invert: Box<Self> },
}

impl Raw {
    /// The names of all that decisions are based on: the state variables, and behind them the internal ones.
    pub(super) fn variables(&self) -> impl Iterator<Item = &str> {
        self.state_variables.keys().chain(self.internal.keys()).map(String::as_str)
    }

    /// Checks the parts that need no robot.
    pub(super) fn check(&self) -> Result<(), DescriptionError> {
        if let Some(policy) = &self.policy {
            return policy.check(self);
        }
        if self.motor.is_empty() {
            return Err(DescriptionError::new(
                "motor",
                "has no behaviour; a brain needs one, such as [motor.stand]",
            ));
        }
        let processes = self.motor.len() + self.cognitive.len();
        if processes > MOST_PROCESSES {
            let problem =
                format!("has {processes} processes with `cognitive`; there may be {MOST_PROCESSES}");
            return Err(DescriptionError::new("motor", problem));
        }
        self.check_variables()?;
        for (table, processes) in [("motor", &self.motor), ("cognitive", &self.cognitive)] {
            for (name, process) in processes {
                if table == "cognitive" && self.motor.contains_key(name) {
                    let problem = "a motor behaviour has this name already";
                    return Err(DescriptionError::new(format!("cognitive.{name}"), problem));
                }
                process.utility(0.0).check(&format!("{table}.{name}.utility"), self)?;
            }
        }
        Ok(())
    }

    fn check_variables(&self) -> Result<(), DescriptionError> {
        let variables = self.variables().count();
        if variables > MOST_VARIABLES {
            let problem = format!("has {variables} variables with `internal`; there may be {MOST_VARIABLES}");
            return Err(DescriptionError::new("state_variables", problem));
        }
        for (name, variable) in &self.state_variables {
            variable.check(&format!("state_variables.{name}"))?;
        }
        for (name, variable) in &self.internal {
            if self.state_variables.contains_key(name) {
                let problem = "a state variable has this name already";
                return Err(DescriptionError::new(format!("internal.{name}"), problem));
            }
            variable.check(&format!("internal.{name}"))?;
        }
        Ok(())
    }
}

impl RawProcess {
    /// The utility of the process, or one of this bias if the description has none.
    pub(super) fn utility(&self, bias: f64) -> RawUtility {
        self.utility.clone().unwrap_or_else(|| RawUtility { bias, ..RawUtility::default() })
    }
}

impl RawVariable {
    fn check(&self, path: &str) -> Result<(), DescriptionError> {
        let problem =
            |field: &str, problem: &str| Err(DescriptionError::new(format!("{path}.{field}"), problem));
        if self.of.is_empty() {
            return problem("of", "names no sensor");
        }
        match (self.by, &self.weights, &self.network) {
            (By::Sum, None, _) => problem("weights", "a sum needs a weight for each value"),
            (By::Network, _, None) => {
                problem("network", "a network needs layers of neurons: [[[0.5, -0.5, 0.1]]]")
            }
            (by, Some(_), _) if by != By::Sum => problem("weights", "only a sum has weights"),
            (by, _, Some(_)) if by != By::Network => problem("network", "only by = \"network\" has one"),
            _ if self.stale_s.is_some_and(|stale_s| !(stale_s.is_finite() && stale_s > 0.0)) => {
                problem("stale_s", "must be positive")
            }
            _ => Ok(()),
        }
    }
}

impl RawInternal {
    fn check(&self, path: &str) -> Result<(), DescriptionError> {
        let problem =
            |field: &str, problem: String| Err(DescriptionError::new(format!("{path}.{field}"), problem));
        if self.least > self.most {
            return problem("most", format!("must be at least `least`, {}, is {}", self.least, self.most));
        }
        if !(self.least..=self.most).contains(&self.initial) {
            let (least, most, initial) = (self.least, self.most, self.initial);
            return problem(
                "initial",
                format!("must be from `least`, {least}, to `most`, {most}, is {initial}"),
            );
        }
        let (least, most, initial) = (self.least, self.most, self.initial);
        if let Some(below) = self.lethal_below.filter(|below| !(least..initial).contains(below)) {
            let bounds = format!("must be from `least`, {least}, to below `initial`, {initial}, is {below}");
            return problem("lethal_below", bounds);
        }
        if let Some(above) = self.lethal_above.filter(|above| !(*above > initial && *above <= most)) {
            let bounds =
                format!("must be above `initial`, {initial}, and at most `most`, {most}, is {above}");
            return problem("lethal_above", bounds);
        }
        match self.decay_s {
            Some(decay_s) if decay_s <= 0.0 => problem("decay_s", format!("must be positive, is {decay_s}")),
            Some(_) | None => Ok(()),
        }
    }
}

impl RawUtility {
    fn check(&self, path: &str, raw: &Raw) -> Result<(), DescriptionError> {
        let positive = [("tau_s", self.tau_s), ("slope", self.slope), ("gamma_tau_s", self.gamma_tau_s)];
        if let Some((field, value)) =
            positive.into_iter().find(|(_, value)| !(value.is_finite() && *value > 0.0))
        {
            return Err(DescriptionError::new(
                format!("{path}.{field}"),
                format!("must be positive, is {value}"),
            ));
        }
        if !self.bias.is_finite() {
            return Err(DescriptionError::new(
                format!("{path}.bias"),
                format!("must be finite, is {}", self.bias),
            ));
        }
        for (variable, weight) in &self.weights {
            let path = || format!("{path}.weights.{variable}");
            if !raw.variables().any(|known| known == variable) {
                let known: Vec<_> = raw.variables().collect();
                let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
                let problem = format!("there is no state variable `{variable}`; there are: {known}");
                return Err(DescriptionError::new(path(), problem));
            }
            if !weight.is_finite() {
                return Err(DescriptionError::new(path(), format!("must be finite, is {weight}")));
            }
        }
        Ok(())
    }
}

/// The limit of processes for which a brain publishes utilities.
const MOST_PROCESSES: usize = 256;
/// The limit of variables: the cost of a step grows with their square.
const MOST_VARIABLES: usize = 256;
