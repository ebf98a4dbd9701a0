//! A world that is stepped from Python.

use std::collections::BTreeMap;
use std::sync::Arc;

use baudbot_learn as learn;
use baudbot_learn::Reward;
use baudbot_plot::arena;
use baudbot_plot::quantity::duration;
use baudbot_plot::timing::{self, Diagram};
use baudbot_sim::World;
use numpy::{PyArray1, PyReadonlyArray1, PyReadwriteArray1, PyReadwriteArrayDyn};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::errors::{apart, at_once, failed, invalid, of_learning};
use crate::task::{Task, reward};

/// An environment.
#[pyclass(module = "baudbot._native")]
pub(crate) struct Env {
    env: learn::Env,
    reward: Reward,
    /// Ages above it are given as it.
    max_age_s: f64,
}

/// New arrays of readings, ages and readability, the reward, and whether the run was terminated or truncated.
type Cycle<'py> =
    (Bound<'py, PyArray1<f32>>, Bound<'py, PyArray1<f32>>, Bound<'py, PyArray1<i8>>, f64, bool, bool);

#[pymethods]
impl Env {
    #[new]
    fn new(
        py: Python<'_>,
        task: &Task,
        seed: u64,
        more: Vec<String>,
        weights: Vec<(String, f64)>,
        max_age_s: f64,
    ) -> PyResult<Self> {
        let reward = reward(py, &weights)?;
        let env = apart(py, || learn::Env::new(Arc::clone(&task.0), seed, &more))?;
        Ok(Self { env: env.map_err(|error| of_learning(py, &error))?, reward, max_age_s })
    }

    fn reset(&mut self, py: Python<'_>, seed: u64, more: Vec<String>) -> PyResult<()> {
        let env = &mut self.env;
        apart(py, || env.reset(seed, &more))?.map_err(|error| of_learning(py, &error))
    }

    /// A control cycle of the only agent.
    fn cycle<'py>(&mut self, py: Python<'py>, action: PyReadonlyArray1<'py, f32>) -> PyResult<Cycle<'py>> {
        let action = action.as_array();
        let env = &mut self.env;
        env.act(0, action.iter().map(|&signal| f64::from(signal)))
            .map_err(|error| of_learning(py, &error))?;
        let stepped = if env.world().robots().len() < FEW {
            at_once(py, || env.step())?
        } else {
            apart(py, || env.step())?
        };
        let (values, ages_s, readable) = self.observation(py);
        let reward = self.reward.of(&self.env.tally(0));
        Ok((values, ages_s, readable, reward, stepped.is_terminated, stepped.is_truncated))
    }

    /// What the only agent has at its laptop's end.
    fn observation<'py>(
        &self,
        py: Python<'py>,
    ) -> (Bound<'py, PyArray1<f32>>, Bound<'py, PyArray1<f32>>, Bound<'py, PyArray1<i8>>) {
        self.observation_of(py, 0)
    }

    /// The same of an agent.
    fn observation_of<'py>(
        &self,
        py: Python<'py>,
        agent: usize,
    ) -> (Bound<'py, PyArray1<f32>>, Bound<'py, PyArray1<f32>>, Bound<'py, PyArray1<i8>>) {
        let agent = &self.env.agents()[agent];
        let values = PyArray1::from_iter(py, agent.values().iter().map(|&value| value as f32));
        let ages_s = PyArray1::from_iter(py, agent.ages_s().map(|age_s| age_s.min(self.max_age_s) as f32));
        let readable = PyArray1::from_iter(py, agent.readable().iter().map(|&readable| i8::from(readable)));
        (values, ages_s, readable)
    }

    /// Tells an agent what to do in the next step.
    fn act(&mut self, py: Python<'_>, agent: usize, action: Vec<f64>) -> PyResult<()> {
        self.env.act(agent, action.into_iter()).map_err(|error| of_learning(py, &error))
    }

    /// A control cycle of all agents: whether the run was terminated or truncated.
    fn step(&mut self, py: Python<'_>) -> PyResult<(bool, bool)> {
        let env = &mut self.env;
        let stepped = apart(py, || env.step())?;
        Ok((stepped.is_terminated, stepped.is_truncated))
    }

    /// On to this instant, or to the end of the run. A signal, such as Ctrl-C, ends it between two ticks.
    fn run_until(&mut self, py: Python<'_>, ns: u64) -> PyResult<(bool, bool)> {
        let env = &mut self.env;
        let slice_ns = SLICE_TICKS * env.world().scenario().step_ns;
        loop {
            let until = env.world().time().as_ns().saturating_add(slice_ns).min(ns);
            let stepped = apart(py, || env.run_until(until))?;
            py.check_signals()?;
            if until >= ns || env.is_over() {
                return Ok((stepped.is_terminated, stepped.is_truncated));
            }
        }
    }

    /// Writes an agent's readings, their ages and whether they are new to these arrays.
    fn observe(
        &self,
        agent: usize,
        mut values: PyReadwriteArray1<'_, f64>,
        mut ages_s: PyReadwriteArray1<'_, f64>,
        mut readable: PyReadwriteArrayDyn<'_, bool>,
    ) {
        let agent = &self.env.agents()[agent];
        values.as_array_mut().iter_mut().zip(agent.values()).for_each(|(to, value)| *to = *value);
        ages_s.as_array_mut().iter_mut().zip(agent.ages_s()).for_each(|(to, age_s)| *to = age_s);
        readable.as_array_mut().iter_mut().zip(agent.readable()).for_each(|(to, readable)| *to = *readable);
    }

    /// The numbers of what happened in the last step, for the trainer of an agent.
    fn tally(&self, agent: usize) -> [f64; 8] {
        self.env.tally(agent).numbers()
    }

    /// What that is worth.
    fn reward(&self, agent: usize) -> f64 {
        self.reward.of(&self.env.tally(agent))
    }

    #[getter]
    fn hash(&self, py: Python<'_>) -> PyResult<String> {
        apart(py, || format!("{:016x}", self.env.world().hash()))
    }

    #[getter]
    fn time_ns(&self) -> u64 {
        self.env.world().time().as_ns()
    }

    #[getter]
    fn tick(&self) -> u64 {
        self.env.world().tick()
    }

    #[getter]
    fn seed(&self) -> u64 {
        self.env.world().scenario().seed
    }

    /// Why the run ended, in words.
    #[getter]
    fn ending(&self) -> Option<String> {
        self.env.world().ending().map(ToString::to_string)
    }

    /// The truth about a robot: where it is, its speed and turn rate, how far it has driven, and its collisions.
    fn truth(&self, robot: usize) -> [f64; 7] {
        let view = self.env.world().robot(robot);
        let (motion, counters) = (view.motion(), view.counters());
        let position = motion.pose.position;
        [
            position.x,
            position.y,
            motion.pose.heading,
            motion.speed_m_s,
            motion.turn_rate_rad_s,
            counters.distance_m,
            counters.collisions as f64,
        ]
    }

    /// A copy from which the run goes on.
    fn snapshot(&self, py: Python<'_>) -> PyResult<Self> {
        let env = apart(py, || self.env.snapshot())?.map_err(|error| of_learning(py, &error))?;
        Ok(Self { env, reward: self.reward, max_age_s: self.max_age_s })
    }

    /// Makes this what a copy was.
    fn restore(&mut self, py: Python<'_>, copy: &Self) -> PyResult<()> {
        if !Arc::ptr_eq(self.env.task(), copy.env.task()) {
            return Err(invalid(py, "snapshot: it is of another world", Some("snapshot".to_owned())));
        }
        self.env = apart(py, || copy.env.snapshot())?.map_err(|error| of_learning(py, &error))?;
        Ok(())
    }

    /// The world's state as bytes, as snapshots and recordings have it.
    fn save<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = apart(py, || self.env.world().save())?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// The world as it is now as a picture from above, in SVG.
    fn svg(&self, py: Python<'_>) -> PyResult<String> {
        apart(py, || picture(self.env.world(), self.env.task().label()))
    }

    /// From now on so many events of each robot are kept, for diagrams.
    fn keep_events(&mut self, events: usize) {
        self.env.world_mut().resize_timeline(events);
    }

    /// What happened when in a robot, as far as it is kept, up to now: a timing diagram in SVG.
    fn diagram(&self, py: Python<'_>, robot: usize, span_ns: u64) -> PyResult<String> {
        let world = self.env.world();
        let until_ns = world.time().as_ns();
        let from_ns = until_ns.saturating_sub(span_ns.max(1));
        let svg = apart(py, || diagram(world, self.env.task().label(), robot, from_ns, until_ns.max(1)))?;
        svg.ok_or_else(|| failed(py, "diagram: nothing has happened yet; step the world first"))
    }
}

/// A scenario whose robots start where they are now.
fn picture(world: &World, label: &str) -> String {
    let mut scenario = (**world.scenario()).clone();
    for (spec, view) in scenario.robots.iter_mut().zip(world.robots()) {
        spec.start.pose = view.motion().pose;
    }
    arena::draw(&scenario, label)
}

fn diagram(world: &World, label: &str, robot: usize, from_ns: u64, until_ns: u64) -> Option<String> {
    let view = world.robot(robot);
    let events: Vec<_> = view.timeline().events().copied().collect();
    if events.is_empty() {
        return None;
    }
    let spec = view.spec();
    let step_ns = world.scenario().step_ns;
    let picture = Diagram {
        title: format!("{} in {label}", spec.name),
        subtitle: format!(
            "What happened when, from the sensors to the brain and back. Δt = {}.",
            duration(step_ns as f64)
        ),
        ran: Vec::new(),
        lanes: timing::lanes(spec, &events, (from_ns, until_ns), None, &BTreeMap::new()),
        from_ns,
        until_ns,
        step_ns,
        marks: Vec::new(),
        late_from_ns: None,
    };
    Some(picture.draw())
}

/// A step of a world with fewer robots is so short that other threads of the interpreter can wait.
const FEW: usize = 8;

/// So many ticks are done between two looks for a signal.
const SLICE_TICKS: u64 = 200;
