//! Each workload runs in a process of its own, so that its peak of memory is its own. This is how the two talk: the
//! task is an argument, and what happens comes back on stdout, a line of JSON each.

use std::io::{self, BufRead, BufReader, Write};
use std::process::{Command, ExitCode, Stdio};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::catalogue::{self, Kind, Workload};
use crate::measure::Effort;
use crate::network::{self, Brains};
use crate::outcome::{Beside, Outcome};
use crate::process;

/// What a child process is to do.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Task {
    /// Measure the workload of this name, with so many threads that step the world.
    Workload { name: String, effort: Effort, threads: usize },
    /// Be the brains of the server at this address.
    Brains { address: String, what: Brains },
}

/// What a child process says.
#[derive(Debug, Serialize, Deserialize)]
enum Said<T> {
    Repeat(u32),
    Done(T),
    Failed(String),
}

/// Why a child process did not do its task.
#[derive(Debug, thiserror::Error)]
pub enum ChildError {
    /// It could not be started.
    #[error("cannot start a process for it")]
    Start(#[source] io::Error),
    /// It said that something is wrong.
    #[error("{0}")]
    Failed(String),
    /// It ended without a word.
    #[error("its process ended without an outcome ({0})")]
    Silent(String),
}

/// Measures a workload in a process that `command` begins; [`serve`] gets its last argument. `progress` hears the
/// number of each repeat before it begins, from 1.
///
/// # Errors
/// If it could not be measured.
pub fn measure(
    command: Command,
    workload: &Workload,
    effort: Effort,
    threads: usize,
    progress: impl FnMut(u32),
) -> Result<Outcome, ChildError> {
    let task = Task::Workload { name: workload.name.to_owned(), effort, threads };
    Child::start(command, &task)?.end(progress)
}

/// What a child process does with its last argument. `command` begins a process like itself.
pub fn serve(task: &str, command: Command) -> ExitCode {
    match serde_json::from_str::<Task>(task) {
        Ok(Task::Workload { name, effort, threads }) => tell(perform(&name, effort, threads, command)),
        Ok(Task::Brains { address, what }) => {
            tell(network::perform(&address, &what, |repeat| say(&Said::<()>::Repeat(repeat))))
        }
        Err(error) => tell::<()>(Err(format!("`{task}` is no task: {error}"))),
    }
}

/// A process that does a task. Dropped before its end, it is ended.
pub(crate) struct Child(std::process::Child);

impl Drop for Child {
    fn drop(&mut self) {
        // One that has ended, and was waited for, is left alone.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl Child {
    /// Starts it; the task becomes its last argument.
    pub(crate) fn start(mut command: Command, task: &Task) -> Result<Self, ChildError> {
        let task = serde_json::to_string(task).expect("a task has nothing that JSON does not know");
        let child = command.arg(task).stdin(Stdio::null()).stdout(Stdio::piped()).spawn();
        Ok(Self(child.map_err(ChildError::Start)?))
    }

    /// Waits for its end; what came of it.
    pub(crate) fn end<T: DeserializeOwned>(mut self, mut progress: impl FnMut(u32)) -> Result<T, ChildError> {
        let mut told = None;
        for line in self.0.stdout.take().map(BufReader::new).into_iter().flat_map(BufRead::lines) {
            match line.ok().and_then(|line| serde_json::from_str(&line).ok()) {
                Some(Said::Repeat(repeat)) => progress(repeat),
                Some(Said::Done(done)) => told = Some(Ok(done)),
                Some(Said::Failed(why)) => told = Some(Err(ChildError::Failed(why))),
                None => {}
            }
        }
        let status = self.0.wait().map_err(ChildError::Start)?;
        told.unwrap_or_else(|| Err(ChildError::Silent(status.to_string())))
    }
}

fn perform(name: &str, effort: Effort, threads: usize, command: Command) -> Result<Outcome, String> {
    let workload = catalogue::WORKLOADS.iter().find(|workload| workload.name == name);
    let workload = workload.ok_or_else(|| format!("there is no workload `{name}`"))?;
    let progress = |repeat| say(&Said::<()>::Repeat(repeat));
    let mut outcome = Outcome::new(workload.name, workload.unit, threads);
    match workload.kind {
        Kind::InProcess(world) => {
            let run = world.run(effort, threads, progress).map_err(|error| error.to_string())?;
            outcome.samples = run.samples;
            outcome.hash = Some(format!("{:016x}", run.hash));
            outcome.hash_ticks = Some(run.probe_ticks);
            outcome.peak_memory_bytes = process::peak_memory_bytes();
        }
        Kind::Network(network) => {
            let (found, notes) = network.run(effort, command, progress).map_err(|error| error.to_string())?;
            outcome.samples = found.samples;
            outcome.notes = notes;
            outcome.peak_memory_bytes = found.usage.and_then(|usage| usage.peak_memory_bytes);
            if !found.ping.is_empty() {
                let what = "a bare ping-pong of 64 bytes".to_owned();
                outcome.beside = Some(Beside { what, samples: found.ping });
            }
        }
    }
    Ok(outcome)
}

fn tell<T: Serialize>(result: Result<T, String>) -> ExitCode {
    let code = if result.is_ok() { ExitCode::SUCCESS } else { ExitCode::FAILURE };
    say(&result.map_or_else(Said::Failed, Said::Done));
    code
}

/// A parent that is gone hears nothing, and nothing is left to do.
fn say<T: Serialize>(said: &Said<T>) {
    let line = serde_json::to_string(said).expect("nothing that JSON does not know");
    let mut out = io::stdout().lock();
    if writeln!(out, "{line}").and_then(|()| out.flush()).is_err() {
        std::process::exit(1);
    }
}
