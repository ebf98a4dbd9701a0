//! Recordings: replayed, and compared with each other.

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use baudbot_recording::{RecordedRun, RecordingError, Replay};
use baudbot_sim::World;
use pyo3::prelude::*;

use crate::errors::{apart, failed};

/// A replay: its last tick, the fingerprint of the world there, and in words where it began to differ from the recording.
type Replayed = (u64, String, Option<String>);

/// Simulates a recorded run again.
#[pyfunction]
pub(crate) fn replay(py: Python<'_>, path: PathBuf) -> PyResult<Replayed> {
    let (mut replay, mut world) = started(py, &path)?;
    loop {
        let more = apart(py, || advance(&mut replay, &mut world))?;
        py.check_signals()?;
        if !more.map_err(|error| failed(py, &of(&path, &error)))? {
            break;
        }
    }
    let difference = replay.difference().map(ToString::to_string);
    Ok((world.tick(), format!("{:016x}", world.hash()), difference))
}

/// The first tick after which the states of two recorded runs are not the same; None if they are the same as long as both last.
#[pyfunction]
pub(crate) fn compare(py: Python<'_>, one: PathBuf, other: PathBuf) -> PyResult<Option<u64>> {
    let mut runs = [started(py, &one)?, started(py, &other)?];
    loop {
        let step = || -> Result<Option<bool>, RecordingError> {
            for _ in 0..SLICE {
                let [first, second] = &mut runs;
                if first.1.hash() != second.1.hash() {
                    return Ok(Some(true));
                }
                if !(first.0.step(&mut first.1)? && second.0.step(&mut second.1)?) {
                    return Ok(Some(false));
                }
            }
            Ok(None)
        };
        let found = apart(py, step)?;
        py.check_signals()?;
        match found.map_err(|error| failed(py, &of(&one, &error)))? {
            Some(true) => return Ok(Some(runs[0].1.tick())),
            Some(false) => return Ok(None),
            None => {}
        }
    }
}

fn started(py: Python<'_>, path: &Path) -> PyResult<(Replay, World)> {
    let start = || -> Result<(Replay, World), String> {
        let file = File::open(path).map_err(|error| format!("{}: {error}", path.display()))?;
        let run = RecordedRun::read(BufReader::new(file)).map_err(|error| of(path, &error))?;
        Replay::start(Arc::new(run)).map_err(|error| of(path, &error))
    };
    apart(py, start)?.map_err(|text| failed(py, &text))
}

fn advance(replay: &mut Replay, world: &mut World) -> Result<bool, RecordingError> {
    for _ in 0..SLICE {
        if !replay.step(world)? {
            return Ok(false);
        }
    }
    Ok(true)
}

fn of(path: &Path, error: &RecordingError) -> String {
    format!("{}: {error}", path.display())
}

/// Ticks between two looks for a signal.
const SLICE: usize = 500;
