//! Each workload runs in a process of its own, so that its peak of memory is its own.

use std::process::{Command, ExitCode};

use crate::catalogue::{self, Kind, Workload};
use crate::child::{Child, ChildError, Means, Task, tell, tell_repeat};
use crate::gallery::GalleryError;
use crate::in_process::{Run, Unfit};
use crate::measure::Effort;
use crate::network::{self, Found, NetworkError};
use crate::outcome::Outcome;
use crate::process;

/// Measures a workload in a process that `command` begins; [`serve`] gets its last argument. `progress` gets the number
/// of each repeat before it begins, from 1.
///
/// # Errors
/// If it could not be measured.
pub fn measure(
    command: Command,
    workload: &Workload,
    effort: Effort,
    means: Means,
    progress: impl FnMut(u32),
) -> Result<Outcome, ChildError> {
    let task = Task::Workload { name: workload.name.to_owned(), effort, means };
    Child::start(command, &task)?.end(progress)
}

/// Does the task of a child process, its last argument. `command` begins a process like itself.
pub fn serve(task: &str, command: Command) -> ExitCode {
    match serde_json::from_str::<Task>(task) {
        Ok(Task::Workload { name, effort, means }) => tell(perform(&name, effort, &means, command)),
        Ok(Task::Brains { address, what }) => tell(network::perform(&address, &what, tell_repeat)),
        Err(error) => tell::<()>(Err(WorkError::NoTask { task: task.to_owned(), error })),
    }
}

/// A reason why a child process did not do its task.
#[derive(Debug, thiserror::Error)]
enum WorkError {
    #[error("`{task}` is no task: {error}")]
    NoTask { task: String, error: serde_json::Error },
    #[error("there is no workload `{0}`")]
    NoWorkload(String),
    #[error(transparent)]
    Unfit(#[from] Unfit),
    #[error(transparent)]
    Gallery(#[from] GalleryError),
    #[error(transparent)]
    Network(#[from] NetworkError),
}

fn perform(name: &str, effort: Effort, means: &Means, command: Command) -> Result<Outcome, WorkError> {
    let workload = catalogue::WORKLOADS.iter().find(|workload| workload.name == name);
    let workload = workload.ok_or_else(|| WorkError::NoWorkload(name.to_owned()))?;
    let mut outcome = Outcome::new(workload.name, workload.unit, means.threads);
    match workload.kind {
        Kind::InProcess(world) => note(&mut outcome, world.run(effort, means.threads, tell_repeat)?),
        Kind::Learner(learner) => note(&mut outcome, learner.run(effort, tell_repeat)?),
        Kind::Gallery(gallery) => gallery.run(&means.program, &mut outcome, effort, tell_repeat)?,
        Kind::Network(network) => note_found(&mut outcome, network.run(effort, command, tell_repeat)?),
        Kind::Worlds(worlds) => note_found(&mut outcome, worlds.run(effort, tell_repeat)?),
    }
    Ok(outcome)
}

/// Puts the result of a run in this process into the outcome.
fn note(outcome: &mut Outcome, run: Run) {
    outcome.samples = run.samples;
    outcome.hash = Some(format!("{:016x}", run.hash));
    outcome.hash_ticks = Some(run.probe_ticks);
    outcome.peak_memory_bytes = process::peak_memory_bytes();
    outcome.beside = run.beside;
    outcome.notes = run.notes;
}

/// Puts the result of a run with a server into the outcome.
fn note_found(outcome: &mut Outcome, (found, notes): (Found, Vec<String>)) {
    outcome.samples = found.samples;
    outcome.notes = notes;
    outcome.peak_memory_bytes = found.usage.and_then(|usage| usage.peak_memory_bytes);
    outcome.beside = found.beside;
}
