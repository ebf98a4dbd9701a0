//! Many environments, stepped on some threads while the interpreter is free.

use std::sync::Mutex;

use baudbot_run::learn::{self, Arrays, Autoreset, Reward, Rewards, Seeds, Tally};
use numpy::{PyReadonlyArray2, PyReadwriteArray1, PyReadwriteArray2};
use pyo3::prelude::*;

use crate::errors::{apart, apart_with, invalid, locked, of_learning};
use crate::task::{Task, reward};

/// Environments with one agent each. The arrays are the caller's; a row is an environment's.
#[pyclass(frozen, module = "baudbot._native")]
pub(crate) struct Fleet {
    fleet: Mutex<learn::Fleet>,
    reward: Reward,
    /// Environments, values, sensors, actions.
    shape: [usize; 4],
    max_age_s: f32,
}

/// Times, seeds and endings.
type Infos = (Vec<f64>, Vec<u64>, Vec<Option<String>>);

type Floats<'py> = PyReadwriteArray2<'py, f32>;
type Flags<'py> = PyReadwriteArray2<'py, i8>;

#[pymethods]
impl Fleet {
    #[new]
    #[expect(
        clippy::too_many_arguments,
        reason = "the interpreter is one of them, and a Python module passes the others"
    )]
    fn new(
        py: Python<'_>,
        task: &Task,
        count: usize,
        threads: usize,
        seed: u64,
        autoreset: &str,
        weights: Vec<(String, f64)>,
        max_age_s: f32,
    ) -> PyResult<Self> {
        let reward = reward(py, &weights)?;
        let autoreset = match autoreset {
            "next-step" => Autoreset::NextStep,
            "same-step" => Autoreset::SameStep,
            "never" => Autoreset::Never,
            other => {
                let problem =
                    format!("autoreset: there is no `{other}`; there are: next-step, same-step, never");
                return Err(invalid(py, &problem, Some("autoreset".to_owned())));
            }
        };
        let fleet = apart(py, || learn::Fleet::new(&task.0, count, threads, seed, autoreset))?;
        let fleet = fleet.map_err(|error| of_learning(py, &error))?;
        let layout = &task.0.layouts()[0];
        let shape = [count, layout.bounds.len(), layout.sensors.len(), layout.actions.len()];
        Ok(Self { fleet: Mutex::new(fleet), reward, shape, max_age_s })
    }

    /// Begins other runs, of environments that `which` is true of, and writes what all observe.
    #[pyo3(signature = (seeds, which, values, ages_s, readable))]
    fn reset(
        &self,
        py: Python<'_>,
        seeds: Option<Vec<Option<u64>>>,
        which: Option<Vec<bool>>,
        mut values: Floats<'_>,
        mut ages_s: Floats<'_>,
        mut readable: Flags<'_>,
    ) -> PyResult<()> {
        let arrays = self.arrays(py, &mut values, &mut ages_s, &mut readable)?;
        if which.as_ref().is_some_and(|which| which.len() != self.shape[0]) {
            return Err(invalid(
                py,
                "reset_mask: has not one element for each environment",
                Some("reset_mask".to_owned()),
            ));
        }
        let mut fleet = locked(py, &self.fleet)?;
        let fleet = &mut *fleet;
        let seeds = seeds.as_deref().map_or(Seeds::Next, Seeds::Each);
        apart(py, || fleet.reset(seeds, which.as_deref(), arrays))?
            .map_err(|error| of_learning(py, &error))?;
        limit(&mut ages_s, self.max_age_s);
        Ok(())
    }

    /// A step of each environment; whether a run ended. The last three arrays get what runs that ended observed last.
    #[expect(
        clippy::too_many_arguments,
        reason = "the interpreter is one of them, and a Python module passes the others"
    )]
    fn step(
        &self,
        py: Python<'_>,
        actions: PyReadonlyArray2<'_, f32>,
        observed: (Floats<'_>, Floats<'_>, Flags<'_>),
        rewards: PyReadwriteArray1<'_, f64>,
        over: (PyReadwriteArray1<'_, bool>, PyReadwriteArray1<'_, bool>),
        tallies: PyReadwriteArray2<'_, f64>,
        finals: (Floats<'_>, Floats<'_>, Flags<'_>),
    ) -> PyResult<bool> {
        let [count, .., signals] = self.shape;
        if actions.as_array().dim() != (count, signals) {
            let (rows, columns) = actions.as_array().dim();
            let problem = format!("actions: has shape ({rows}, {columns}), ({count}, {signals}) is needed");
            return Err(invalid(py, &problem, Some("actions".to_owned())));
        }
        let (
            (mut values, mut ages_s, mut readable),
            (mut rewards, (mut terminated, mut truncated), mut tallies),
        ) = (observed, (rewards, over, tallies));
        let (mut last_values, mut last_ages_s, mut last_readable) = finals;
        let arrays = self.arrays(py, &mut values, &mut ages_s, &mut readable)?;
        let last = self.arrays(py, &mut last_values, &mut last_ages_s, &mut last_readable)?;
        let whole = "must be a whole array";
        let out = Rewards {
            rewards: rewards.as_slice_mut()?,
            terminated: terminated.as_slice_mut()?,
            truncated: truncated.as_slice_mut()?,
            tallies: tallies.as_slice_mut()?,
            finals: Some(last),
        };
        let fits =
            out.rewards.len() == count && out.terminated.len() == count && out.truncated.len() == count;
        if !fits || out.tallies.len() != count * Tally::NAMES.len() {
            return Err(invalid(py, whole, None));
        }
        let actions = actions.as_slice()?;
        let mut fleet = locked(py, &self.fleet)?;
        let (fleet, reward) = (&mut *fleet, &self.reward);
        let has_ended = apart(py, || fleet.step(actions, reward, arrays, out))?
            .map_err(|error| of_learning(py, &error))?;
        limit(&mut ages_s, self.max_age_s);
        if has_ended {
            limit(&mut last_ages_s, self.max_age_s);
        }
        Ok(has_ended)
    }

    /// The fingerprints of all worlds in one.
    #[getter]
    fn hash(&self, py: Python<'_>) -> PyResult<String> {
        let mut fleet = locked(py, &self.fleet)?;
        let fleet = &mut *fleet;
        apart_with(py, fleet, |fleet| format!("{:016x}", fleet.hash()))
    }

    /// Of the runs of environments that `which` is true of, or of those before them: their times in seconds, their seeds, and why they
    /// ended, in words.
    fn infos(&self, py: Python<'_>, which: Vec<bool>, of_last: bool) -> PyResult<Infos> {
        let fleet = locked(py, &self.fleet)?;
        let places = (0..fleet.envs().len()).zip(which).filter(|(_, is_asked)| *is_asked);
        let infos: Vec<_> = places.map(|(place, _)| fleet.info(place, of_last)).collect();
        Ok((
            infos.iter().map(|info| info.time_ns as f64 / 1e9).collect(),
            infos.iter().map(|info| info.seed).collect(),
            infos.iter().map(|info| info.ending.as_ref().map(ToString::to_string)).collect(),
        ))
    }

    /// Nothing, unless another thread is in it.
    fn check_free(&self, py: Python<'_>) -> PyResult<()> {
        locked(py, &self.fleet).map(drop)
    }
}

impl Fleet {
    fn arrays<'a>(
        &self,
        py: Python<'_>,
        values: &'a mut Floats<'_>,
        ages_s: &'a mut Floats<'_>,
        readable: &'a mut Flags<'_>,
    ) -> PyResult<Arrays<'a>> {
        let [count, wide, sensors, _] = self.shape;
        let shapes = [values.as_array().dim(), ages_s.as_array().dim(), readable.as_array().dim()];
        if shapes != [(count, wide), (count, sensors), (count, sensors)] {
            return Err(invalid(
                py,
                "observations: the arrays have another shape than the environments' readings",
                None,
            ));
        }
        Ok(Arrays {
            values: values.as_slice_mut()?,
            ages_s: ages_s.as_slice_mut()?,
            readable: readable.as_slice_mut()?,
        })
    }
}

/// Ages above the limit, also those of what has never come, are given as it.
fn limit(ages_s: &mut Floats<'_>, max_age_s: f32) {
    ages_s.as_array_mut().iter_mut().for_each(|age_s| *age_s = age_s.min(max_age_s));
}
