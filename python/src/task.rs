//! Tasks: scenarios with the robots that a program drives.

use std::sync::Arc;

use baudbot_import::source::Source;
use baudbot_run::learn::{self, Draw, LearnError, Request, Reward, Tally, Varied};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::{apart, invalid, of_learning};

/// A scenario with its agents.
#[pyclass(frozen, module = "baudbot._native")]
pub(crate) struct Task(pub(crate) Arc<learn::Task>);

/// A field that is varied: its path, how it is drawn, the two ends of its range, and what there is to choose from.
type Drawn = (String, String, f64, f64, Vec<String>);

/// A sensor: its name, its kind, the first of its values and the one behind the last.
type Sensor = (String, &'static str, usize, usize);

#[pymethods]
impl Task {
    /// `scenario` is a file or the name of a built-in scenario; or TOML, if it has a `label`.
    #[new]
    #[pyo3(signature = (scenario, *, label, overrides, brains, agents, randomize))]
    fn new(
        py: Python<'_>,
        scenario: String,
        label: Option<String>,
        overrides: Vec<String>,
        brains: Vec<String>,
        agents: Vec<String>,
        randomize: Vec<Drawn>,
    ) -> PyResult<Self> {
        let randomize = randomize.into_iter().map(|drawn| varied(py, drawn)).collect::<PyResult<_>>()?;
        let request = Request { overrides, brains, agents, randomize };
        let make = || -> Result<learn::Task, LearnError> {
            let source = match label {
                Some(label) => Source { label, ..Source::written(scenario)? },
                None => Source::find(&scenario)?,
            };
            learn::Task::new(source, request)
        };
        let task = apart(py, make)?.map_err(|error| of_learning(py, &error))?;
        Ok(Self(Arc::new(task)))
    }

    /// With this pickle makes another: it has the scenario's text in it.
    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<((String,), Bound<'py, PyDict>)> {
        let Request { overrides, brains, agents, randomize } = self.0.request();
        let named = PyDict::new(py);
        named.set_item("label", self.0.label())?;
        named.set_item("overrides", overrides)?;
        named.set_item("brains", brains)?;
        named.set_item("agents", agents)?;
        named.set_item("randomize", randomize.iter().map(drawn).collect::<Vec<_>>())?;
        Ok(((self.0.text().to_owned(),), named))
    }

    /// It never changes.
    fn __deepcopy__<'py>(slf: Bound<'py, Self>, _memo: &Bound<'py, PyAny>) -> Bound<'py, Self> {
        slf
    }

    /// The name of the scenario.
    #[getter]
    fn name(&self) -> String {
        let name = &self.0.base().name;
        if name.is_empty() { self.0.label().to_owned() } else { name.clone() }
    }

    #[getter]
    fn seed(&self) -> u64 {
        self.0.base().seed
    }

    #[getter]
    fn step_ns(&self) -> u64 {
        self.0.base().step_ns
    }

    /// The names of all robots.
    #[getter]
    fn robots(&self) -> Vec<String> {
        self.0.base().robots.iter().map(|spec| spec.name.clone()).collect()
    }

    /// The names of those that are driven from outside.
    #[getter]
    fn agents(&self) -> Vec<String> {
        self.0.layouts().iter().map(|layout| layout.robot.clone()).collect()
    }

    /// The sensors of an agent.
    fn sensors(&self, agent: usize) -> Vec<Sensor> {
        let parts = self.0.layouts()[agent].sensors.iter();
        parts.map(|part| (part.name.clone(), part.kind, part.values.start, part.values.end)).collect()
    }

    /// The names of an agent's values.
    fn columns(&self, agent: usize) -> Vec<String> {
        self.0.layouts()[agent].columns.clone()
    }

    /// The least and the greatest of each value of an agent's.
    fn bounds(&self, agent: usize) -> Vec<[f64; 2]> {
        self.0.layouts()[agent].bounds.clone()
    }

    /// The names of the numbers of an agent's actions.
    fn actions(&self, agent: usize) -> Vec<String> {
        self.0.layouts()[agent].actions.clone()
    }

    /// Checks that the scenario counts what a reward weighs.
    fn check_reward(&self, py: Python<'_>, weights: Vec<(String, f64)>) -> PyResult<()> {
        reward(py, &weights)?.check(self.0.base()).map_err(|error| of_learning(py, &error))
    }

    /// The budget of each robot, as JSON. What a program of the user's own costs is found by running it, and refused here.
    fn budget(&self, py: Python<'_>) -> PyResult<String> {
        let base = self.0.base();
        if let Some(spec) = base.robots.iter().find(|spec| spec.chip.is_some()) {
            let problem = format!(
                "robot `{}`: its microcontroller runs a program of its own, which the command `baudbot budget` measures in a run",
                spec.name
            );
            return Err(invalid(py, &problem, None));
        }
        let budget = apart(py, || baudbot_scenario::budget::Budget::of(base))?;
        serde_json::to_string(&budget).map_err(|error| invalid(py, &error.to_string(), None))
    }
}

fn varied(py: Python<'_>, (path, kind, low, high, choices): Drawn) -> PyResult<Varied> {
    let draw = match kind.as_str() {
        "uniform" => Draw::Uniform { low, high },
        "log-uniform" => Draw::LogUniform { low, high },
        "integer" => Draw::Integer { low: low as i64, high: high as i64 },
        "choice" => Draw::Choice(choices),
        other => {
            let problem = format!(
                "randomize.{path}: there is no `{other}`; there are: uniform, log-uniform, integer, choice"
            );
            return Err(invalid(py, &problem, Some(format!("randomize.{path}"))));
        }
    };
    Ok(Varied { path, draw })
}

/// The same the other way.
fn drawn(varied: &Varied) -> Drawn {
    let Varied { path, draw } = varied;
    let (kind, low, high, choices) = match draw {
        Draw::Uniform { low, high } => ("uniform", *low, *high, Vec::new()),
        Draw::LogUniform { low, high } => ("log-uniform", *low, *high, Vec::new()),
        Draw::Integer { low, high } => ("integer", *low as f64, *high as f64, Vec::new()),
        Draw::Choice(choices) => ("choice", 0.0, 0.0, choices.clone()),
    };
    (path.clone(), kind.to_owned(), low, high, choices)
}

/// Checks the weights of a reward; gives back the names of a tally's numbers.
#[pyfunction]
pub(crate) fn check_reward(py: Python<'_>, weights: Vec<(String, f64)>) -> PyResult<Vec<&'static str>> {
    reward(py, &weights).map(|_| Tally::NAMES.to_vec())
}

pub(crate) fn reward(py: Python<'_>, weights: &[(String, f64)]) -> PyResult<Reward> {
    Reward::new(weights.iter().map(|(name, weight)| (name.as_str(), *weight)))
        .map_err(|error| of_learning(py, &error))
}
