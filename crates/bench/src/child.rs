//! A process that does a task: the task is its last argument, and what happens comes back on stdout, a line of JSON each.

use std::error::Error;
use std::io::{self, BufRead, BufReader, Write};
use std::path::PathBuf;
use std::process::{Command, ExitCode, Stdio};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::measure::Effort;

/// The task of a child process.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Task {
    /// Measure the workload of this name.
    Workload { name: String, effort: Effort, means: Means },
    /// Be the brains of the server at this address.
    Brains { address: String, what: Brains },
}

/// The means by which workloads are measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Means {
    /// Threads that step a world, if it has no server.
    pub threads: usize,
    /// The program `baudbot`, for workloads that run it.
    pub program: PathBuf,
}

/// The task of the process with the brains.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Brains {
    /// Drive these robots in lockstep and measure the ticks a second; beside it, a ping-pong at the other address.
    Lockstep { robots: Vec<String>, streams: Streams, ping: Option<String>, lookahead: bool, effort: Effort },
    /// Drive these robots, as many on each stream, until the server ends.
    RealTime { robots: Vec<String>, streams: usize },
}

/// The connections of the brains.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Streams {
    /// Each has a connection.
    Connections,
    /// Each has a stream, all on one connection.
    OneConnection,
    /// One stream for all.
    OneStream,
}

/// The message of a child process.
#[derive(Debug, Serialize, Deserialize)]
enum Said<T> {
    Repeat(u32),
    Done(T),
    Failed(String),
}

/// The reason why a child process did not do its task.
#[derive(Debug, thiserror::Error)]
pub enum ChildError {
    /// The process could not be started.
    #[error("cannot start a process for it")]
    Start(#[source] io::Error),
    /// The process reported an error.
    #[error("{0}")]
    Failed(String),
    /// The process ended without a message.
    #[error("its process ended without an outcome ({0})")]
    Silent(String),
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

    /// Waits for the end of the process; its result.
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

/// Sends the result of the task.
pub(crate) fn tell<T: Serialize>(result: Result<T, impl Error>) -> ExitCode {
    let code = if result.is_ok() { ExitCode::SUCCESS } else { ExitCode::FAILURE };
    say(&result.map_or_else(|error| Said::Failed(error.to_string()), Said::Done));
    code
}

/// Sends that a repeat begins.
pub(crate) fn tell_repeat(repeat: u32) {
    say(&Said::<()>::Repeat(repeat));
}

/// A parent that is gone reads nothing, and there is nothing left to do.
fn say<T: Serialize>(said: &Said<T>) {
    let line = serde_json::to_string(said).expect("nothing that JSON does not know");
    let mut out = io::stdout().lock();
    if writeln!(out, "{line}").and_then(|()| out.flush()).is_err() {
        std::process::exit(1);
    }
}
