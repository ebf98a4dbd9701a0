//! A world that is stepped from Python.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use baudbot_plot::arena;
use baudbot_plot::timing::{self, Diagram};
use baudbot_run::learn;
use baudbot_run::learn::{Agent, Reward};
use baudbot_sim::World;
use numpy::{PyArray1, PyReadonlyArray1, PyReadwriteArray1};
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use smallvec::SmallVec;

use crate::errors::{apart, apart_with, at_once, failed, invalid, locked, of_learning};
use crate::task::{Task, reward};

/// An environment.
#[pyclass(frozen, module = "baudbot._native")]
pub(crate) struct Env {
    env: Mutex<learn::Env>,
    task: Py<Task>,
    reward: Reward,
    /// Ages above it are given as it.
    max_age_s: f64,
}

/// From what it is made: a task, a seed, changes of fields, weights and the greatest age.
type Made = (Py<Task>, u64, Vec<String>, Vec<(String, f64)>, f64);

/// New arrays of readings, ages and readability.
type Observation<'py> = (Bound<'py, PyArray1<f32>>, Bound<'py, PyArray1<f32>>, Bound<'py, PyArray1<i8>>);

/// An observation, the reward, and whether the run was terminated or truncated.
type Cycle<'py> =
    (Bound<'py, PyArray1<f32>>, Bound<'py, PyArray1<f32>>, Bound<'py, PyArray1<i8>>, f64, bool, bool);

/// An observation as a mapping, the reward, whether the run was terminated or truncated, and an empty mapping.
type Step<'py> = (Bound<'py, PyDict>, f64, bool, bool, Bound<'py, PyDict>);

#[pymethods]
impl Env {
    #[new]
    fn new(
        py: Python<'_>,
        task: Py<Task>,
        seed: u64,
        more: Vec<String>,
        weights: Vec<(String, f64)>,
        max_age_s: f64,
    ) -> PyResult<Self> {
        let reward = reward(py, &weights)?;
        let env = apart(py, || learn::Env::new(Arc::clone(&task.get().0), seed, &more))?;
        Ok(Self { env: Mutex::new(env.map_err(|error| of_learning(py, &error))?), task, reward, max_age_s })
    }

    /// With this and the state pickle makes another.
    fn __getnewargs__(&self, py: Python<'_>) -> PyResult<Made> {
        let weights = self.reward.weights().map(|(name, weight)| (name.to_owned(), weight)).collect();
        Ok((self.task.clone_ref(py), self.seed(py)?, Vec::new(), weights, self.max_age_s))
    }

    fn __getstate__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let env = &mut *locked(py, &self.env)?;
        let state = apart_with(py, env, |env| env.save())?.map_err(|error| of_learning(py, &error))?;
        Ok(PyBytes::new(py, &state))
    }

    fn __setstate__(&self, py: Python<'_>, state: &[u8]) -> PyResult<()> {
        let env = &mut *locked(py, &self.env)?;
        let task = Arc::clone(env.task());
        *env = apart(py, || learn::Env::load(task, state))?.map_err(|error| of_learning(py, &error))?;
        Ok(())
    }

    fn __copy__(&self, py: Python<'_>) -> PyResult<Self> {
        self.snapshot(py)
    }

    fn __deepcopy__(&self, py: Python<'_>, _memo: &Bound<'_, PyAny>) -> PyResult<Self> {
        self.snapshot(py)
    }

    /// Nothing, unless another thread is in it.
    fn check_free(&self, py: Python<'_>) -> PyResult<()> {
        locked(py, &self.env).map(drop)
    }

    fn reset(&self, py: Python<'_>, seed: u64, more: Vec<String>) -> PyResult<()> {
        let env = &mut *locked(py, &self.env)?;
        apart(py, || env.reset(seed, &more))?.map_err(|error| of_learning(py, &error))
    }

    /// A control cycle of the only agent.
    fn cycle<'py>(&self, py: Python<'py>, action: PyReadonlyArray1<'py, f32>) -> PyResult<Cycle<'py>> {
        let env = &mut *locked(py, &self.env)?;
        let action = action.as_array();
        env.act(0, action.iter().map(|&signal| f64::from(signal)))
            .map_err(|error| of_learning(py, &error))?;
        let stepped = if env.world().robots().len() < CROWD {
            at_once(py, || env.step())?
        } else {
            apart(py, || env.step())?
        };
        let (values, ages_s, readable) = self.observed(py, env, 0)?;
        let reward = self.reward.of(env.tally(0));
        Ok((values, ages_s, readable, reward, stepped.is_terminated, stepped.is_truncated))
    }

    /// The same, as Gymnasium wants it: an observation as a mapping, the reward, whether the run was terminated or truncated, and
    /// an empty mapping. An action that is no array of such numbers is a TypeError.
    fn gymnasium_step<'py>(
        &self,
        py: Python<'py>,
        action: PyReadonlyArray1<'py, f32>,
        with_ages: bool,
    ) -> PyResult<Step<'py>> {
        let (values, ages_s, readable, reward, is_terminated, is_truncated) = self.cycle(py, action)?;
        let observation = PyDict::new(py);
        observation.set_item(intern!(py, "readings"), values)?;
        if with_ages {
            observation.set_item(intern!(py, "ages_s"), ages_s)?;
            observation.set_item(intern!(py, "readable"), readable)?;
        }
        Ok((observation, reward, is_terminated, is_truncated, PyDict::new(py)))
    }

    /// New arrays of what an agent has at its laptop's end.
    fn observation<'py>(&self, py: Python<'py>, agent: usize) -> PyResult<Observation<'py>> {
        self.observed(py, &*locked(py, &self.env)?, agent)
    }

    /// Tells an agent what to do in the next step.
    fn act(&self, py: Python<'_>, agent: usize, action: Vec<f64>) -> PyResult<()> {
        let env = &mut *locked(py, &self.env)?;
        of(py, env, agent)?;
        env.act(agent, action.into_iter()).map_err(|error| of_learning(py, &error))
    }

    /// A control cycle of all agents: whether the run was terminated or truncated.
    fn step(&self, py: Python<'_>) -> PyResult<(bool, bool)> {
        let env = &mut *locked(py, &self.env)?;
        let stepped = apart(py, || env.step())?;
        Ok((stepped.is_terminated, stepped.is_truncated))
    }

    /// On to this instant, or to the end of the run. A signal, such as Ctrl-C, ends it between two ticks.
    fn run_until(&self, py: Python<'_>, ns: u64) -> PyResult<(bool, bool)> {
        let env = &mut *locked(py, &self.env)?;
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
        py: Python<'_>,
        agent: usize,
        mut values: PyReadwriteArray1<'_, f64>,
        mut ages_s: PyReadwriteArray1<'_, f64>,
        mut readable: PyReadwriteArray1<'_, bool>,
    ) -> PyResult<()> {
        let env = locked(py, &self.env)?;
        let agent = of(py, &env, agent)?;
        values.as_array_mut().iter_mut().zip(agent.values()).for_each(|(to, value)| *to = *value);
        ages_s.as_array_mut().iter_mut().zip(agent.ages_s()).for_each(|(to, age_s)| *to = age_s);
        readable.as_array_mut().iter_mut().zip(agent.readable()).for_each(|(to, readable)| *to = *readable);
        Ok(())
    }

    /// The numbers of what happened in the last step, for the trainer of an agent.
    fn tally(&self, py: Python<'_>, agent: usize) -> PyResult<[f64; 8]> {
        let env = locked(py, &self.env)?;
        of(py, &env, agent).map(|_| env.tally(agent).numbers())
    }

    /// The reward of that state.
    fn reward(&self, py: Python<'_>, agent: usize) -> PyResult<f64> {
        let env = locked(py, &self.env)?;
        of(py, &env, agent).map(|_| self.reward.of(env.tally(agent)))
    }

    #[getter]
    fn hash(&self, py: Python<'_>) -> PyResult<String> {
        let env = &mut *locked(py, &self.env)?;
        apart_with(py, env, |env| format!("{:016x}", env.world().hash()))
    }

    #[getter]
    fn time_ns(&self, py: Python<'_>) -> PyResult<u64> {
        Ok(locked(py, &self.env)?.world().time().as_ns())
    }

    #[getter]
    fn tick(&self, py: Python<'_>) -> PyResult<u64> {
        Ok(locked(py, &self.env)?.world().tick())
    }

    #[getter]
    fn seed(&self, py: Python<'_>) -> PyResult<u64> {
        Ok(locked(py, &self.env)?.world().scenario().seed)
    }

    /// The reason for the end of the run, in words.
    #[getter]
    fn ending(&self, py: Python<'_>) -> PyResult<Option<String>> {
        Ok(locked(py, &self.env)?.world().ending().map(ToString::to_string))
    }

    /// The truth about a robot: where it is, its speed and turn rate, how far it has driven, and its collisions.
    fn truth(&self, py: Python<'_>, robot: usize) -> PyResult<[f64; 7]> {
        let env = locked(py, &self.env)?;
        let view = env.world().robots().nth(robot).ok_or_else(|| failed(py, "there is no such robot"))?;
        let (motion, counters) = (view.motion(), view.counters());
        let position = motion.pose.position;
        Ok([
            position.x,
            position.y,
            motion.pose.heading,
            motion.speed_m_s,
            motion.turn_rate_rad_s,
            counters.distance_m,
            counters.collisions as f64,
        ])
    }

    /// A copy from which the run goes on.
    fn snapshot(&self, py: Python<'_>) -> PyResult<Self> {
        let env = &mut *locked(py, &self.env)?;
        let copy = apart_with(py, env, |env| env.snapshot())?.map_err(|error| of_learning(py, &error))?;
        let task = self.task.clone_ref(py);
        Ok(Self { env: Mutex::new(copy), task, reward: self.reward, max_age_s: self.max_age_s })
    }

    /// Makes this what a copy was.
    fn restore(&self, py: Python<'_>, copy: &Self) -> PyResult<()> {
        let env = &mut *locked(py, &self.env)?;
        let copy = &mut *locked(py, &copy.env)?;
        if !Arc::ptr_eq(env.task(), copy.task()) {
            return Err(invalid(py, "snapshot: it is of another world", Some("snapshot".to_owned())));
        }
        *env = apart_with(py, copy, |copy| copy.snapshot())?.map_err(|error| of_learning(py, &error))?;
        Ok(())
    }

    /// The world as it is now as a picture from above, in SVG.
    fn svg(&self, py: Python<'_>) -> PyResult<String> {
        let env = &mut *locked(py, &self.env)?;
        apart_with(py, env, |env| picture(env.world(), env.task().label()))
    }

    /// From now on so many events of each robot are kept, for diagrams.
    fn keep_events(&self, py: Python<'_>, events: usize) -> PyResult<()> {
        locked(py, &self.env)?.world_mut().resize_timeline(events);
        Ok(())
    }

    /// The timing diagram of a robot in SVG, up to now, as far as its events are kept.
    fn diagram(&self, py: Python<'_>, robot: usize, span_ns: u64) -> PyResult<String> {
        let env = &mut *locked(py, &self.env)?;
        let until_ns = env.world().time().as_ns();
        let from_ns = until_ns.saturating_sub(span_ns.max(1));
        let draw =
            |env: &mut learn::Env| diagram(env.world(), env.task().label(), robot, from_ns, until_ns.max(1));
        apart_with(py, env, draw)?.ok_or_else(|| {
            failed(
                py,
                "diagram: nothing has happened that was kept; call keep_events() and step the world first",
            )
        })
    }
}

impl Env {
    fn observed<'py>(&self, py: Python<'py>, env: &learn::Env, agent: usize) -> PyResult<Observation<'py>> {
        let agent = of(py, env, agent)?;
        // An array of NumPy's own is made faster than one that keeps a vector.
        let values: SmallVec<[f32; FEW]> = agent.values().iter().map(|&value| value as f32).collect();
        let ages_s: SmallVec<[f32; FEW]> =
            agent.ages_s().map(|age_s| age_s.min(self.max_age_s) as f32).collect();
        let readable: SmallVec<[i8; FEW]> =
            agent.readable().iter().map(|&readable| i8::from(readable)).collect();
        let (values, ages_s) = (PyArray1::from_slice(py, &values), PyArray1::from_slice(py, &ages_s));
        let readable = PyArray1::from_slice(py, &readable);
        Ok((values, ages_s, readable))
    }
}

fn of<'a>(py: Python<'_>, env: &'a learn::Env, agent: usize) -> PyResult<&'a Agent> {
    env.agents().get(agent).ok_or_else(|| failed(py, "there is no such agent"))
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
    let span = (from_ns, until_ns);
    let lanes = timing::lanes(spec, &events, span, None, &BTreeMap::new());
    Some(Diagram::of_run(&spec.name, label, lanes, span, world.scenario().step_ns).draw())
}

/// So few readings need no memory of their own.
const FEW: usize = 8;

/// A step of a world with fewer robots is so short that other threads of the interpreter can wait.
const CROWD: usize = 8;

/// So many ticks are done between two looks for a signal.
const SLICE_TICKS: u64 = 200;
