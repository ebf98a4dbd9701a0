//! Runs on all cores: threads that take the next run from a queue until it is empty, or they are stopped.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError, mpsc};
use std::thread;
use std::time::{Duration, Instant};

use crate::error::Error;
use crate::experiment::Experiment;
use crate::local_runner;
use crate::private_server::PrivateServer;
use crate::remote::{Host, Remote};
use crate::run_record::{Row, Task};

/// The place in which runs are done.
#[derive(Clone, Debug, PartialEq)]
pub enum Place {
    /// In this process.
    Here,
    /// On the server at this address: `HOST:PORT` or `unix:/PATH`.
    Server(String),
}

/// The workers that do the runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Workers {
    /// The place.
    pub place: Place,
    /// The number of simultaneous runs; at least 1.
    pub jobs: usize,
    /// The name of worlds on a server, before the number of the run. No other client may use it, as worlds of this name
    /// are deleted: see [`unique_name`](crate::unique_name).
    pub name: String,
}

impl Workers {
    /// Does the tasks and hands out each row as it comes, with the wall-clock time that it took. Runs that have begun
    /// when `stop` is set are done to their end.
    pub(crate) fn work(
        &self,
        experiment: &Experiment,
        tasks: impl Iterator<Item = Task> + Send,
        stop: &AtomicBool,
        mut each: impl FnMut(Row, Duration) -> Result<(), Error>,
    ) -> Result<(), Error> {
        self.refuse_unseen(experiment)?;
        // A program attaches to a server, and to a private one if the user names none.
        let private = match self.place {
            Place::Here if experiment.has_programs() => Some(PrivateServer::start([])?),
            Place::Here | Place::Server(_) => None,
        };
        let host = private.as_ref().map(Host::Private).or(match &self.place {
            Place::Here => None,
            Place::Server(address) => Some(Host::Address(address)),
        });
        let (queue, halt) = (Mutex::new(tasks), AtomicBool::new(false));
        let is_over = || stop.load(Ordering::Relaxed) || halt.load(Ordering::Relaxed);
        let next = || {
            // A queue is never left in an invalid state.
            let mut queue = queue.lock().unwrap_or_else(PoisonError::into_inner);
            if is_over() { None } else { queue.next() }
        };
        let (send, receive) = mpsc::sync_channel(2 * self.jobs);
        thread::scope(|scope| {
            for _ in 0..self.jobs.max(1) {
                let (send, next) = (send.clone(), &next);
                scope.spawn(move || self.work_alone(experiment, host, next, &send));
            }
            drop(send);
            let (mut outcome, mut is_kept) = (Ok(()), true);
            for answer in receive {
                let done = answer.and_then(|(row, took)| match is_kept {
                    true => each(row, took).inspect_err(|_| is_kept = false),
                    false => Ok(()),
                });
                if done.is_err() {
                    halt.store(true, Ordering::Relaxed);
                }
                outcome = outcome.and(done);
            }
            outcome
        })
    }

    /// Runs that are to be seen at each tick cannot be on a server elsewhere.
    fn refuse_unseen(&self, experiment: &Experiment) -> Result<(), Error> {
        match &self.place {
            Place::Server(address) if experiment.is_observed() => Err(Error::Refused(format!(
                "requirements, and figures of nearness in conditions, charts and goals, need runs that are seen at each tick, which \
                 the server at {address} does not show; leave out --connect"
            ))),
            Place::Here | Place::Server(_) => Ok(()),
        }
    }

    /// One thread's work.
    fn work_alone(
        &self,
        experiment: &Experiment,
        host: Option<Host<'_>>,
        next: &impl Fn() -> Option<Task>,
        send: &Answers,
    ) {
        let mut remote = None;
        if let Some(host) = host {
            match Remote::connect(host, &self.name) {
                Ok(connected) => remote = Some(connected),
                Err(error) => return drop(send.send(Err(error))),
            }
        }
        while let Some(task) = next() {
            let start = Instant::now();
            let row = match &remote {
                None => Ok(local_runner::run(experiment, &task)),
                Some(remote) => remote.run(experiment, &task),
            };
            let failed = row.is_err();
            if send.send(row.map(|row| (row, start.elapsed()))).is_err() || failed {
                return;
            }
        }
        if let Some(Err(error)) = remote.map(|remote| remote.check_last(experiment)) {
            let _ = send.send(Err(error));
        }
    }
}

type Answers = mpsc::SyncSender<Result<(Row, Duration), Error>>;
