//! The things that the calls of a program act on: its tasks, its ports, and the time.

use std::path::PathBuf;

use crate::cables::Cables;
use crate::files::Files;
use crate::os::proc;
use crate::os::trace::Registers;
use crate::program::{Price, Program};
use crate::random::Random;
use crate::report::Report;
use crate::task::{Activity, Task};
use crate::timers::{Owner, Timer};
use crate::tty::Tty;

/// CLOCK_REALTIME at the beginning, in nanoseconds: 2023-11-14 22:13:20 UTC.
pub(crate) const EPOCH_NS: u64 = 1_700_000_000_000_000_000;
/// CLOCK_MONOTONIC at the beginning, in nanoseconds: a machine that has been up for a while.
pub(crate) const UPTIME_NS: u64 = 1_000_000_000_000;

/// Calls without a wait after which even those that are no looks are charged, so that no program holds up time for ever.
const FREE_CALLS: u64 = 100_000;

/// The tasks of a program, its ports, and the time.
#[derive(Debug)]
pub(crate) struct Kernel {
    /// The instant.
    pub(crate) now_ns: u64,
    /// In the order of creation.
    pub(crate) tasks: Vec<Task>,
    pub(crate) ports: Vec<Tty>,
    pub(crate) files: Files,
    pub(crate) random: Random,
    pub(crate) price: Price,
    /// Clocks are calls, although our vDSO could tell them.
    pub(crate) traps_clocks: bool,
    /// The page of the task that has run last.
    pub(crate) page: Option<Page>,
    pub(crate) report: Report,
    /// Counts what may end a wait.
    pub(crate) progress: u64,
    /// Counts what the kernel has done that may end a wait.
    pub(crate) done: u64,
    /// A program waits for ports by epoll.
    pub(crate) has_port_in_epoll: bool,
    /// The epoll that was empty last, by process and descriptor, and the count of what the kernel had done then.
    pub(crate) empty_epoll: Option<(i32, i32, u64)>,
    /// The program may have signals to deliver that were not looked at.
    pub(crate) has_signals: bool,
    /// Counts waits at futexes.
    pub(crate) order: u64,
    /// The program's own output and errors, as /proc shows their descriptors.
    pub(crate) outputs: Vec<PathBuf>,
    pub(crate) timers: Vec<Timer>,
    /// Counts timers that programs have created.
    pub(crate) timers_created: i32,
}

/// The page of clocks of the task that has run last.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Page {
    /// The task's number.
    pub(crate) task: u32,
    pub(crate) now_ns: u64,
    pub(crate) looks_left: i64,
}

impl Kernel {
    /// The beginning of a program, whose first process stands still.
    pub(crate) fn new(program: &Program, ports: Vec<Tty>, outputs: Vec<PathBuf>, root: i32) -> Self {
        let report = Report { has_random_addresses: proc::has_random_addresses(root), ..Report::default() };
        Self {
            now_ns: 0,
            tasks: Vec::new(),
            ports,
            files: Files::default(),
            random: Random::new(program.seed),
            price: program.price,
            traps_clocks: program.traps_clocks,
            page: None,
            report,
            progress: 0,
            done: 0,
            has_port_in_epoll: false,
            empty_epoll: None,
            has_signals: false,
            order: 0,
            outputs,
            timers: Vec::new(),
            timers_created: 0,
        }
    }

    /// The port that a descriptor of a task is.
    pub(crate) fn port(&self, task: usize, descriptor: i32) -> Option<usize> {
        let file = self.files.name(&self.tasks[task], descriptor)?;
        self.ports.iter().position(|port| *port.flag.name() == *file)
    }

    /// A task's call was a look, unless it has waited.
    pub(crate) fn charge(&mut self, task: usize) {
        if self.tasks[task].call.began_ns < self.now_ns {
            self.tasks[task].looks = 0;
        } else {
            self.look(task);
        }
    }

    /// A task has made a look: it pays for it, if it has made many.
    pub(crate) fn look(&mut self, task: usize) {
        self.tasks[task].looks += 1;
        if self.tasks[task].looks > self.price.free_looks {
            self.pay(task);
        }
    }

    /// A task has made a call that is no look.
    pub(crate) fn count_call(&mut self, task: usize) {
        let caller = &mut self.tasks[task];
        caller.calls += 1;
        if caller.calls > FREE_CALLS && caller.activity == Activity::Running {
            self.pay(task);
        }
    }

    fn pay(&mut self, task: usize) {
        let price_ns = self.price.look_ns.max(1);
        let payer = &mut self.tasks[task];
        payer.activity = Activity::Paying { until_ns: self.now_ns.saturating_add(price_ns) };
        payer.charged_ns += price_ns;
        self.report.charged += 1;
        self.report.charged_ns += price_ns;
    }

    /// The kernel has done something that may end a wait.
    pub(crate) fn act(&mut self) {
        self.progress += 1;
        self.done += 1;
    }

    /// A wait for what only the kernel can do.
    pub(crate) fn waiting(&self) -> Activity {
        Activity::Kernels { until_ns: None, seen: self.progress, done: Some(self.done) }
    }

    /// A new task.
    pub(crate) fn add_task(&mut self, tid: i32, scratch: u64, page: Option<u64>, registers: Registers) {
        let process = proc::process(tid).unwrap_or(tid);
        self.tasks.push(Task { page, ..Task::new(tid, process, self.report.tasks, scratch, registers) });
        self.report.tasks += 1;
        self.report.tasks_at_most = self.report.tasks_at_most.max(self.tasks.len());
        self.act();
    }

    /// All bytes that have come are given to the ports.
    pub(crate) fn take_bytes(&mut self, cables: &mut dyn Cables) {
        for (number, port) in self.ports.iter_mut().enumerate() {
            let mut bytes = Vec::new();
            cables.take(number, &mut bytes);
            if !bytes.is_empty() {
                self.progress += 1;
                let echo = port.receive(&bytes, self.now_ns);
                if !echo.is_empty() {
                    cables.write(number, &echo);
                }
            }
        }
    }

    /// Ports and timers that no process has open any more are closed.
    pub(crate) fn close_ports(&mut self, cables: &mut dyn Cables) {
        let is_file = |timer: &Timer| matches!(timer.owner, Owner::File { .. });
        if self.ports.iter().all(|port| !port.is_open) && !self.timers.iter().any(is_file) {
            return;
        }
        let mut files = Vec::new();
        let processes: std::collections::BTreeSet<i32> = self.tasks.iter().map(|task| task.process).collect();
        for process in processes {
            files.extend(proc::descriptors(process));
        }
        self.timers.retain(|timer| match &timer.owner {
            Owner::File { flag, .. } => files.iter().any(|file| file == flag.name()),
            Owner::Process(_) | Owner::Created { .. } => true,
        });
        for (number, port) in self.ports.iter_mut().enumerate() {
            if port.is_open && !files.iter().any(|file| file == port.flag.name()) {
                port.is_open = false;
                port.is_exclusive = false;
                port.input.clear();
                port.show();
                if port.termios.hangs_up() {
                    port.outputs = crate::cables::ModemOutputs::default();
                    cables.set_outputs(number, port.outputs);
                }
            }
        }
    }

    /// The instant at which a task goes on, or a timer rings.
    pub(crate) fn until_ns(&self) -> Option<u64> {
        let tasks = self.tasks.iter().filter_map(|task| task.activity.until_ns());
        let timers = self.timers.iter().map(|timer| timer.due_ns).filter(|due_ns| *due_ns < u64::MAX);
        tasks.chain(timers).min()
    }
}
