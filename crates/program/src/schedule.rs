//! The order of things: one task runs at a time, until it waits.

use crate::cables::Cables;
use crate::calls::{self, Outcome};
use crate::error::Error;
use crate::image;
use crate::kernel::Kernel;
use crate::os::trace::{self, Resume, Stop};
use crate::report::End;
use crate::task::{Activity, After};
use crate::timers::Owner;
use crate::watch::{Trip, Watch};

/// A program's tasks, and whose turn it is.
#[derive(Debug)]
pub(crate) struct Schedule {
    pub(crate) kernel: Kernel,
    pub(crate) watch: Watch,
    /// The first process: the program is over when it is.
    pub(crate) root: i32,
    pub(crate) end: Option<End>,
    /// The number of the task that has run last.
    pub(crate) turn: u32,
}

/// The way a task goes on after a stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Next {
    Resume(Resume),
    /// It does not: it waits, pays, is no more, or lets others run.
    Leave,
}

/// An `Ours` that is looked at only when it is due has seen this.
const ONLY_WHEN_DUE: u64 = u64::MAX;

/// Calls by which nothing happens for others that wait, but for those that they wake themselves.
const INERT: [i64; 7] = [
    libc::SYS_nanosleep,
    libc::SYS_clock_nanosleep,
    libc::SYS_futex,
    libc::SYS_select,
    libc::SYS_pselect6,
    libc::SYS_poll,
    libc::SYS_ppoll,
];

impl Schedule {
    /// Runs all tasks until each of them waits.
    pub(crate) fn run(&mut self, now_ns: u64, cables: &mut dyn Cables) -> Result<(), Error> {
        let kernel = &mut self.kernel;
        kernel.now_ns = kernel.now_ns.max(now_ns);
        kernel.take_bytes(cables);
        kernel.ring();
        self.wake_due()?;
        while self.end.is_none() {
            if std::mem::take(&mut self.kernel.has_signals) {
                self.interrupt_waits()?;
            }
            let Some(number) = self.next() else { return Ok(()) };
            self.turn = number;
            if !self.waits_again(number) {
                self.run_task(number, cables)?;
            }
        }
        Ok(())
    }

    fn wake_due(&mut self) -> Result<(), Error> {
        let now_ns = self.kernel.now_ns;
        for task in &mut self.kernel.tasks {
            if task.activity.until_ns().is_none_or(|until_ns| until_ns > now_ns) {
                continue;
            }
            if matches!(task.activity, Activity::Paying { .. }) {
                task.activity = Activity::Running;
            } else if matches!(task.activity, Activity::Futex { .. }) {
                task.finish(-i64::from(libc::ETIMEDOUT))?;
            } else if matches!(task.activity, Activity::Signal { .. }) {
                task.finish(-i64::from(libc::EAGAIN))?;
            }
        }
        Ok(())
    }

    /// The number of the next task that can run: those that can for certain first, in turn, then those that may.
    fn next(&self) -> Option<u32> {
        let (now_ns, progress) = (self.kernel.now_ns, self.kernel.progress);
        let is_due = |until_ns: Option<u64>| until_ns.is_some_and(|until_ns| until_ns <= now_ns);
        let may_run = |activity: Activity| {
            let (Activity::Ours { until_ns, seen } | Activity::Kernels { until_ns, seen, .. }) = activity
            else {
                return false;
            };
            is_due(until_ns) || (seen != ONLY_WHEN_DUE && seen != progress)
        };
        let tasks = || self.kernel.tasks.iter();
        let running = || tasks().filter(|task| task.activity == Activity::Running);
        let task = running().find(|task| task.number > self.turn).or_else(|| running().next());
        task.or_else(|| tasks().find(|task| may_run(task.activity))).map(|task| task.number)
    }

    /// The place of a task among all.
    fn place(&self, number: u32) -> Option<usize> {
        self.kernel.tasks.iter().position(|task| task.number == number)
    }

    /// Whether a call that the kernel would make again would wait again: nothing has happened that it could know. The task is then as after
    /// that, without its two stops.
    fn waits_again(&mut self, number: u32) -> bool {
        let Kernel { now_ns, progress, done, ref mut tasks, .. } = self.kernel;
        let Some(task) = tasks.iter_mut().find(|task| task.number == number) else { return false };
        let Activity::Kernels { until_ns, seen, done: Some(known) } = &mut task.activity else {
            return false;
        };
        if *known != done || until_ns.is_some_and(|until_ns| until_ns <= now_ns) {
            return false;
        }
        *seen = progress;
        task.begin_call(now_ns);
        task.waits_since_ns = Some(now_ns);
        true
    }

    /// Runs a task until it waits, or lets others run.
    fn run_task(&mut self, number: u32, cables: &mut dyn Cables) -> Result<(), Error> {
        let Some(place) = self.place(number) else { return Ok(()) };
        let mut how = Resume::Free;
        let activity = std::mem::replace(&mut self.kernel.tasks[place].activity, Activity::Running);
        if matches!(activity, Activity::Ours { .. }) {
            let outcome = calls::enter(&mut self.kernel, place, cables)?;
            match self.apply(place, outcome, cables)? {
                Next::Resume(next) => how = next,
                Next::Leave => return Ok(()),
            }
        }
        loop {
            let Some(place) = self.place(number) else { return Ok(()) };
            let stop = self.step(place, how)?;
            match self.handle(place, stop, cables)? {
                Next::Resume(next) => how = next,
                Next::Leave => break,
            }
        }
        if let Some(place) = self.place(number) {
            let task = &mut self.kernel.tasks[place];
            if !matches!(task.activity, Activity::Running | Activity::Paying { .. }) {
                task.waits_since_ns.get_or_insert(self.kernel.now_ns);
            }
        }
        Ok(())
    }

    /// Lets a task go on to its next stop.
    pub(crate) fn step(&mut self, place: usize, how: Resume) -> Result<Stop, Error> {
        if how == Resume::Free {
            self.kernel.write_page(place)?;
        }
        let task = &mut self.kernel.tasks[place];
        let signal = std::mem::take(&mut task.signal);
        trace::resume(task.tid, how, signal).map_err(|source| task.failure("letting it go on", source))?;
        let stop = self.wait(place)?;
        match stop {
            // Its memory is another, or no more.
            Stop::Exec | Stop::Exit(_) | Stop::Death(_) => self.kernel.page = None,
            Stop::Return => {}
            Stop::Entry | Stop::Birth(_) | Stop::BorrowingBirth(_) | Stop::MemoryBack | Stop::Signal(_) => {
                self.kernel.count_looks(place);
            }
        }
        Ok(stop)
    }

    /// Waits for a task's next stop.
    pub(crate) fn wait(&mut self, place: usize) -> Result<Stop, Error> {
        let task = &self.kernel.tasks[place];
        self.watch.begin(task);
        let stop = trace::wait(task.tid);
        self.watch.end();
        self.kernel.report.stops += 1;
        let stop = stop.map_err(|source| task.failure("waiting for it", source))?;
        match self.watch.trip() {
            Some(Trip::Computing(computing)) => Err(Error::Spinner { program: task.program(), computing }),
            Some(Trip::Call(call, wall)) => Err(Error::Hang { program: task.program(), call, wall }),
            None => Ok(stop),
        }
    }

    fn handle(&mut self, place: usize, stop: Stop, cables: &mut dyn Cables) -> Result<Next, Error> {
        match stop {
            Stop::Entry => {
                self.enter(place)?;
                let outcome = calls::enter(&mut self.kernel, place, cables)?;
                self.apply(place, outcome, cables)
            }
            Stop::Return => self.leave(place, cables),
            Stop::Birth(child) => {
                self.add(place, child)?;
                Ok(Next::Resume(Resume::Free))
            }
            Stop::BorrowingBirth(child) => {
                self.add(place, child)?;
                let parent = &mut self.kernel.tasks[place];
                parent.activity = Activity::Lending { child };
                trace::resume(parent.tid, Resume::Free, 0)
                    .map_err(|source| parent.failure("vfork", source))?;
                Ok(Next::Leave)
            }
            Stop::MemoryBack => Ok(Next::Resume(Resume::Free)),
            Stop::Exec => self.begin_image(place, cables),
            Stop::Signal(signal) => self.deliver(place, signal, cables),
            Stop::Exit(_) | Stop::Death(_) => {
                self.finish_process(self.kernel.tasks[place].process, Some((place, stop)), cables)?;
                Ok(Next::Leave)
            }
        }
    }

    /// A task stands at the entry of a call.
    fn enter(&mut self, place: usize) -> Result<(), Error> {
        let now_ns = self.kernel.now_ns;
        let task = &mut self.kernel.tasks[place];
        let entry =
            trace::registers(task.tid).map_err(|source| task.failure("reading its registers", source))?;
        task.begin_call(now_ns);
        task.call.entry = entry;
        if task.call.again.is_none() {
            task.call.began_ns = now_ns;
            task.call.done = 0;
        }
        Ok(())
    }

    /// A task stands at the return of a call.
    fn leave(&mut self, place: usize, cables: &mut dyn Cables) -> Result<Next, Error> {
        let Some(after) = self.kernel.tasks[place].after.take() else {
            return Ok(Next::Resume(Resume::Free));
        };
        if let After::Signals { killed } = &after {
            self.kernel.has_signals = true;
            for process in killed {
                self.finish_process(*process, None, cables)?;
            }
            return Ok(Next::Resume(Resume::Free));
        }
        // A look changes nothing for others.
        let is_look = matches!(after, After::Multiplex { .. });
        calls::leave(&mut self.kernel, place, after, cables)?;
        let next = self.next_of(place);
        if next != Next::Leave {
            self.kernel.progress += 1;
            self.kernel.done += u64::from(!is_look);
        }
        Ok(next)
    }

    /// Counts what the outcome of a call may change for others.
    fn note(&mut self, place: usize, outcome: &Outcome) {
        let (is_inert, is_ours) = match outcome {
            Outcome::Answer(_) | Outcome::Moved(_) => (false, true),
            Outcome::Native | Outcome::ThreadEnd | Outcome::ProcessEnd => (false, false),
            Outcome::Look(_)
            | Outcome::Nothing
            | Outcome::Wait(_)
            | Outcome::Yield
            | Outcome::Observed(_) => (true, false),
        };
        let kernel = &mut self.kernel;
        if !is_inert && !INERT.contains(&kernel.tasks[place].number_of_call()) {
            kernel.progress += 1;
            kernel.done += u64::from(!is_ours);
        }
    }

    /// Applies the outcome of a call to its task.
    fn apply(&mut self, place: usize, outcome: Outcome, cables: &mut dyn Cables) -> Result<Next, Error> {
        self.note(place, &outcome);
        let kernel = &mut self.kernel;
        let task = &mut kernel.tasks[place];
        match outcome {
            Outcome::Answer(value) => {
                task.finish(value)?;
                kernel.count_call(place);
            }
            Outcome::Moved(value) => {
                task.looks = 0;
                task.finish(value)?;
                kernel.count_call(place);
            }
            Outcome::Look(value) => {
                task.finish(value)?;
                kernel.charge(place);
            }
            Outcome::Nothing => self.answer_nothing(place)?,
            Outcome::Yield => {
                task.finish(0)?;
                kernel.charge(place);
                return Ok(Next::Leave);
            }
            Outcome::Native => {
                task.complete();
                task.forget_looks_of_readers();
                kernel.count_call(place);
            }
            Outcome::Observed(after) => {
                task.after = Some(after);
                return Ok(Next::Resume(Resume::ToReturn));
            }
            Outcome::Wait(activity) => task.activity = activity,
            Outcome::ThreadEnd => return self.end_thread(place),
            Outcome::ProcessEnd => return self.end_process(place, 0, cables),
        }
        Ok(self.next_of(place))
    }

    /// A call of the kernel's is answered as it would be, which others notice as they would.
    fn answer_nothing(&mut self, place: usize) -> Result<(), Error> {
        self.kernel.tasks[place].finish(0)?;
        self.kernel.charge(place);
        self.kernel.progress += u64::from(self.next_of(place) != Next::Leave);
        Ok(())
    }

    /// Whether a task goes on, by what it does.
    pub(crate) fn next_of(&self, place: usize) -> Next {
        match self.kernel.tasks[place].activity == Activity::Running {
            true => Next::Resume(Resume::Free),
            false => Next::Leave,
        }
    }

    /// A task has a child, which stops by itself.
    fn add(&mut self, place: usize, child: i32) -> Result<(), Error> {
        let parent = &self.kernel.tasks[place];
        let failed = |source| parent.failure("following its child", source);
        trace::wait(child).map_err(failed)?;
        let registers = trace::registers(child).map_err(failed)?;
        let (scratch, page) = (parent.scratch, parent.page);
        self.kernel.add_task(child, scratch, page, registers);
        Ok(())
    }

    /// A task runs another program from here on.
    fn begin_image(&mut self, place: usize, cables: &mut dyn Cables) -> Result<Next, Error> {
        let kernel = &mut self.kernel;
        let task = &kernel.tasks[place];
        let failed =
            |source| Error::Tracer { program: "exec".to_owned(), step: "reading its registers", source };
        let registers = trace::registers(task.tid).map_err(failed)?;
        image::prepare(kernel, place, registers)?;
        let task = &mut kernel.tasks[place];
        task.complete();
        let tid = task.tid;
        kernel.files.forget_all();
        // Those of setitimer stay.
        let process = kernel.tasks[place].process;
        kernel.timers.retain(
            |timer| !matches!(timer.owner, Owner::Created { process: owner, .. } if owner == process),
        );
        kernel.close_ports(cables);
        self.take_memory_back(tid)?;
        Ok(Next::Resume(Resume::Free))
    }
}
