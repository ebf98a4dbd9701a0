//! Runs on all cores: threads that take the next run from a queue until it is empty, or they are stopped.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError, mpsc};
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

/// The workers that do the runs. What they need for programs is kept from one batch of runs to the next, until they are dropped: a
/// server, connections to it, and processes that do many runs.
pub struct Workers {
    place: Place,
    jobs: usize,
    /// The name of worlds on a server, before the number of the run.
    name: String,
    /// The time by the wall clock in which a program has to answer.
    brain_timeout: Duration,
    /// Connections that no run uses now, with their processes.
    idle: Mutex<Vec<Remote>>,
    /// The server for programs, if the user names none. It is dropped after `idle`, whose connections are to it.
    private: Mutex<Option<PrivateServer>>,
}

impl Workers {
    /// Workers for so many simultaneous runs, at least 1. No other client may use the name, as worlds of this name are deleted: see
    /// [`unique_name`](crate::unique_name). A run whose program does not answer for `brain_timeout` is given up.
    pub fn new(place: Place, jobs: usize, name: String, brain_timeout: Duration) -> Self {
        Self {
            place,
            jobs: jobs.max(1),
            name,
            brain_timeout,
            idle: Mutex::default(),
            private: Mutex::default(),
        }
    }

    pub(crate) fn jobs(&self) -> usize {
        self.jobs
    }

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
        let (queue, halt) = (Mutex::new(tasks), AtomicBool::new(false));
        let is_over = || stop.load(Ordering::Relaxed) || halt.load(Ordering::Relaxed);
        let next = || {
            // A queue is never left in an invalid state.
            let mut queue = queue.lock().unwrap_or_else(PoisonError::into_inner);
            if is_over() { None } else { queue.next() }
        };
        let (send, receive) = mpsc::sync_channel(2 * self.jobs);
        thread::scope(|scope| {
            for _ in 0..self.jobs {
                let (send, next) = (send.clone(), &next);
                scope.spawn(move || self.work_alone(experiment, next, &send));
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
    fn work_alone(&self, experiment: &Experiment, next: &impl Fn() -> Option<Task>, send: &Answers) {
        while let Some(task) = next() {
            let start = Instant::now();
            let row = self.run(experiment, &task);
            let failed = row.is_err();
            if send.send(row.map(|row| (row, start.elapsed()))).is_err() || failed {
                return;
            }
        }
    }

    /// Does a run.
    ///
    /// # Errors
    /// If a server has failed, or a process that has done other runs does not do this one as a new one does it.
    pub(crate) fn run(&self, experiment: &Experiment, task: &Task) -> Result<Row, Error> {
        let Some(remote) = self.remote(experiment)? else { return Ok(local_runner::run(experiment, task)) };
        let row = remote.run(experiment, task)?;
        self.idle().push(remote);
        Ok(row)
    }

    /// There are no more runs of this experiment.
    ///
    /// # Errors
    /// If a process has gathered something in its runs that shows in the last.
    pub(crate) fn finish(&self, experiment: &Experiment) -> Result<(), Error> {
        self.idle().iter().try_for_each(|remote| remote.check_last(experiment))
    }

    /// A connection to the server that runs are on; `None` if they need none.
    fn remote(&self, experiment: &Experiment) -> Result<Option<Remote>, Error> {
        // A program attaches to a server, and to a private one if the user names none.
        if self.place == Place::Here && !experiment.has_programs() {
            return Ok(None);
        }
        if let Some(remote) = self.idle().pop() {
            return Ok(Some(remote));
        }
        let mut private = self.private.lock().unwrap_or_else(PoisonError::into_inner);
        let host = match &self.place {
            Place::Server(address) => Host::Address(address),
            Place::Here => Host::Private(match &mut *private {
                Some(server) => server,
                none => none.insert(PrivateServer::start([])?),
            }),
        };
        Remote::connect(host, &self.name, Some(self.brain_timeout)).map(Some)
    }

    fn idle(&self) -> MutexGuard<'_, Vec<Remote>> {
        self.idle.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The time by the wall clock in which a program has to answer, unless the user says another.
pub const BRAIN_TIMEOUT: Duration = Duration::from_secs(60);

type Answers = mpsc::SyncSender<Result<(Row, Duration), Error>>;
