//! Each workload runs in a process of its own, so that its peak of memory is its own. This is how the two talk: the
//! task is an argument, and what happens comes back on stdout, a line of JSON each.

use std::io::{self, BufRead, BufReader, Write};
use std::process::{Command, ExitCode, Stdio};

use serde::{Deserialize, Serialize};

use crate::catalogue::{self, Kind, Workload};
use crate::in_process::Unfit;
use crate::measure::Effort;
use crate::outcome::Outcome;
use crate::process;

/// What a child process is to do.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Task {
    /// Name of the workload.
    pub workload: String,
    /// How long to measure.
    pub effort: Effort,
    /// Threads that step the world.
    pub threads: usize,
}

/// What a child process says.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Said {
    Repeat(u32),
    Outcome(Box<Outcome>),
    Failed(String),
}

/// Why a workload has no outcome.
#[derive(Debug, thiserror::Error)]
pub enum ChildError {
    /// No process could be started.
    #[error("cannot start a process for it")]
    Start(#[source] io::Error),
    /// It said that something is wrong.
    #[error("{0}")]
    Failed(String),
    /// It ended without an outcome.
    #[error("its process ended without an outcome ({0})")]
    Silent(String),
}

/// Runs a task in a process that `command` begins; the task becomes its last argument. `progress` hears the number of
/// each repeat before it begins, from 1.
///
/// # Errors
/// If there is no outcome.
pub fn run(mut command: Command, task: &Task, mut progress: impl FnMut(u32)) -> Result<Outcome, ChildError> {
    let task = serde_json::to_string(task).expect("a task has nothing that JSON does not know");
    let child = command.arg(task).stdin(Stdio::null()).stdout(Stdio::piped()).spawn();
    let mut child = child.map_err(ChildError::Start)?;
    let mut told = None;
    for line in child.stdout.take().map(BufReader::new).into_iter().flat_map(BufRead::lines) {
        match line.ok().and_then(|line| serde_json::from_str(&line).ok()) {
            Some(Said::Repeat(repeat)) => progress(repeat),
            Some(Said::Outcome(outcome)) => told = Some(Ok(*outcome)),
            Some(Said::Failed(why)) => told = Some(Err(ChildError::Failed(why))),
            None => {}
        }
    }
    let status = child.wait().map_err(ChildError::Start)?;
    told.unwrap_or_else(|| Err(ChildError::Silent(status.to_string())))
}

/// What the child process does with its last argument.
pub fn serve(task: &str) -> ExitCode {
    let outcome = match serde_json::from_str::<Task>(task) {
        Ok(task) => perform(&task),
        Err(error) => Err(format!("`{task}` is no task: {error}")),
    };
    let failed = outcome.is_err();
    say(&outcome.map_or_else(Said::Failed, |outcome| Said::Outcome(Box::new(outcome))));
    if failed { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}

fn perform(task: &Task) -> Result<Outcome, String> {
    let chosen =
        catalogue::select(std::slice::from_ref(&task.workload)).map_err(|error| error.to_string())?;
    let exact = chosen.iter().find(|workload| workload.name == task.workload);
    let workload = exact.ok_or_else(|| format!("`{}` names several workloads", task.workload))?;
    measure(workload, task).map_err(|error| error.to_string())
}

fn measure(workload: &Workload, task: &Task) -> Result<Outcome, Unfit> {
    let mut outcome = Outcome {
        workload: workload.name.to_owned(),
        unit: workload.unit.to_owned(),
        samples: Vec::new(),
        peak_memory_bytes: None,
        threads: task.threads,
        hash: None,
        hash_ticks: None,
        notes: Vec::new(),
    };
    match workload.kind {
        Kind::InProcess(world) => {
            let run = world.run(task.effort, task.threads, |repeat| say(&Said::Repeat(repeat)))?;
            outcome.samples = run.samples;
            outcome.hash = Some(format!("{:016x}", run.hash));
            outcome.hash_ticks = Some(run.probe_ticks);
        }
    }
    outcome.peak_memory_bytes = process::peak_memory_bytes();
    Ok(outcome)
}

/// A parent that is gone hears nothing, and nothing is left to do.
fn say(said: &Said) {
    let line = serde_json::to_string(said).expect("nothing that JSON does not know");
    let mut out = io::stdout().lock();
    if writeln!(out, "{line}").and_then(|()| out.flush()).is_err() {
        std::process::exit(1);
    }
}
