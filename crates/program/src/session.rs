//! A session: a program that runs in simulated time.

use std::rc::Rc;

use crate::cables::Cables;
use crate::calls;
use crate::error::Error;
use crate::image;
use crate::kernel::Kernel;
use crate::launch;
use crate::os::affinity::{self, Pin};
use crate::os::{spawn, trace};
use crate::program::Program;
use crate::report::{End, Report, Wait};
use crate::schedule::Schedule;
use crate::task::Activity;
use crate::tty::Tty;
use crate::watch::Watch;

/// A program that runs in simulated time. It belongs to the thread that has started it, which may have several.
#[derive(Debug)]
pub struct Session {
    schedule: Schedule,
    is_broken: bool,
    /// Kept for its end. It also ties the session to its thread, as ptrace does.
    _pin: Option<Rc<Pin>>,
}

/// The state of a program at an instant, after all that it could do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// All its tasks wait.
    Waiting {
        /// For this instant at the latest, in nanoseconds; none: only bytes or lines can wake one, or nothing.
        until_ns: Option<u64>,
    },
    /// It is over.
    Ended(End),
}

impl Session {
    /// Starts a program. Nothing of it runs before the first [`run`](Self::run).
    ///
    /// # Errors
    ///
    /// If there is no such program, or the system does not allow to trace it.
    pub fn start(program: &Program) -> Result<Self, Error> {
        let mut ports = Vec::new();
        for port in &program.ports {
            if !port.path.starts_with('/') {
                let problem = "is the path of a port, which must be absolute, such as /dev/ttyUSB0";
                return Err(Error::Text { text: port.path.clone(), problem });
            }
            ports.push(Tty::new(&port.path).map_err(|source| start_error(program, source))?);
        }
        let (launch, outputs) = launch::launch(program, &calls::shown())?;
        let pin = if program.is_unpinned { None } else { affinity::pin() };
        let root = spawn::spawn(&launch).map_err(|source| start_error(program, source))?;
        let kernel = Kernel::new(program, ports, outputs, root);
        let watch = Watch::new(program.patience);
        let mut session = Self {
            schedule: Schedule { kernel, watch, root, end: None, turn: 0 },
            is_broken: false,
            _pin: pin,
        };
        let registers = trace::registers(root).map_err(|source| start_error(program, source))?;
        let kernel = &mut session.schedule.kernel;
        kernel.add_task(root, 0, None, registers);
        image::prepare(kernel, 0, registers)?;
        Ok(session)
    }

    /// Runs its tasks, one at a time and in a fixed order, until all of them wait for time, bytes or each other. Time does not run
    /// backwards: an earlier instant than before counts as that.
    ///
    /// # Errors
    ///
    /// If the program does what has no simulated time. It is ended then.
    pub fn run(&mut self, now_ns: u64, cables: &mut dyn Cables) -> Result<State, Error> {
        if let Some(end) = self.schedule.end {
            return Ok(State::Ended(end));
        }
        if self.is_broken {
            return Err(Error::Over);
        }
        if let Err(error) = self.schedule.run(now_ns, cables) {
            self.is_broken = true;
            self.schedule.kill();
            return Err(error);
        }
        if let Some(end) = self.schedule.end {
            // The processes that it has left behind go, too.
            self.schedule.kill();
            return Ok(State::Ended(end));
        }
        Ok(State::Waiting { until_ns: self.schedule.kernel.until_ns() })
    }

    /// The deeds of the program up to now.
    pub fn report(&self) -> Report {
        self.schedule.kernel.report
    }

    /// The waits of its tasks: the text of a message about a deadlock.
    pub fn waits(&self) -> Vec<Wait> {
        let waiting = self.schedule.kernel.tasks.iter().filter(|task| task.activity != Activity::Ended);
        waiting
            .map(|task| Wait {
                program: task.program(),
                task: task.number,
                call: crate::names::call(task.number_of_call()),
                until_ns: task.activity.until_ns(),
            })
            .collect()
    }

    /// Sends a signal to the program's first process, such as SIGINT: it acts on it in the next run.
    pub fn interrupt(&mut self, signal: i32) {
        if self.schedule.end.is_none() && !self.is_broken {
            trace::signal(self.schedule.root, self.schedule.root, signal);
            self.schedule.kernel.has_signals = true;
        }
    }

    /// Ends the program and all that it has started.
    pub fn kill(&mut self) {
        self.schedule.kill();
        self.schedule.end.get_or_insert(End::Signal(libc::SIGKILL));
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        self.schedule.kill();
    }
}

fn start_error(program: &Program, source: std::io::Error) -> Error {
    Error::Start { program: launch::name(program), source }
}
