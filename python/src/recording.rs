//! Recordings: replayed, and compared with each other.

use std::fmt::Display;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use baudbot_recording::{RecordedRun, RecordingError, Replay};
use baudbot_sim::World;
use pyo3::prelude::*;

use crate::errors::{apart, failed};

/// A replay: its last tick, the fingerprint of the world there, in words where it began to differ from the recording, and what of that is
/// missing.
type Replayed = (u64, String, Option<String>, Option<String>);

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
    Ok((world.tick(), format!("{:016x}", world.hash()), difference, missing(&replay)))
}

/// A comparison: the first tick after which the states differ, the last one at which they were compared, and what is missing of either
/// recording.
type Compared = (Option<u64>, u64, [Option<String>; 2]);

/// Compares the states of two recorded runs, tick by tick, as long as both last.
#[pyfunction]
pub(crate) fn compare(py: Python<'_>, one: PathBuf, other: PathBuf) -> PyResult<Compared> {
    let mut runs = [started(py, &one)?, started(py, &other)?];
    let mut last_tick = runs[0].1.tick();
    loop {
        let compare = || -> Result<Option<Option<u64>>, RecordingError> {
            for _ in 0..SLICE {
                let [first, second] = &mut runs;
                if !meet(first, second)? {
                    return Ok(Some(None));
                }
                last_tick = first.1.tick();
                if first.1.hash() != second.1.hash() {
                    return Ok(Some(Some(last_tick)));
                }
                if !(first.0.step(&mut first.1)? && second.0.step(&mut second.1)?) {
                    return Ok(Some(None));
                }
            }
            Ok(None)
        };
        let found = apart(py, compare)?;
        py.check_signals()?;
        if let Some(difference) = found.map_err(|error| failed(py, &of(&one, &error)))? {
            return Ok((difference, last_tick, runs.map(|(replay, _)| missing(&replay))));
        }
    }
}

/// Takes the one that is behind to the tick of the other: a recording may begin later, or have a gap. Whether there is such a tick.
fn meet(first: &mut (Replay, World), second: &mut (Replay, World)) -> Result<bool, RecordingError> {
    while first.1.tick() != second.1.tick() {
        let (replay, world) = if first.1.tick() < second.1.tick() { &mut *first } else { &mut *second };
        if !replay.step(world)? {
            return Ok(false);
        }
    }
    Ok(true)
}

/// The parts that a recording lacks, in the words of the command.
fn missing(replay: &Replay) -> Option<String> {
    let recorded = replay.recorded();
    let problem = recorded.problem()?;
    Some(format!("{problem}; compared in {}", recorded.coverage(None)))
}

fn started(py: Python<'_>, path: &Path) -> PyResult<(Replay, World)> {
    let file = apart(py, || File::open(path))?.map_err(|error| failed(py, &of(path, &error)))?;
    let start = || Replay::start(Arc::new(RecordedRun::read(BufReader::new(file))?));
    apart(py, start)?.map_err(|error| failed(py, &of(path, &error)))
}

fn advance(replay: &mut Replay, world: &mut World) -> Result<bool, RecordingError> {
    for _ in 0..SLICE {
        if !replay.step(world)? {
            return Ok(false);
        }
    }
    Ok(true)
}

fn of(path: &Path, error: &impl Display) -> String {
    format!("{}: {error}", path.display())
}

/// Ticks between two looks for a signal.
const SLICE: usize = 500;
