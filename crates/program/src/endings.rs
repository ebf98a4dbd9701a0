//! The ends of threads and processes. A tracer has to see each thread off, or the system keeps its process.

use std::time::Duration;

use crate::cables::Cables;
use crate::error::Error;
use crate::os::proc;
use crate::os::trace::{self, Resume, Stop};
use crate::report::End;
use crate::schedule::{Next, Schedule};
use crate::task::Activity;

impl Schedule {
    /// A thread ends by the call at whose entry it stands; others of its process go on.
    pub(crate) fn end_thread(&mut self, place: usize) -> Result<Next, Error> {
        let task = &self.kernel.tasks[place];
        let (tid, process) = (task.tid, task.process);
        if tid == process {
            trace::resume(tid, Resume::Free, 0).map_err(|source| task.failure("letting it end", source))?;
            // The system tells the end of a first thread only once the others have ended.
            while proc::activity(tid).is_some_and(|(state, _)| state != 'Z' && state != 'X') {
                std::thread::sleep(Duration::from_micros(20));
            }
            self.kernel.tasks[place].activity = Activity::Ended;
        } else {
            while !matches!(self.step(place, Resume::Free)?, Stop::Exit(_) | Stop::Death(_)) {}
            self.kernel.tasks.remove(place);
        }
        self.kernel.files.forget_all();
        self.kernel.recheck_futexes();
        self.kernel.act();
        Ok(Next::Leave)
    }

    /// A process ends as one of its tasks goes on, by its call or by this signal.
    pub(crate) fn end_process(
        &mut self,
        place: usize,
        signal: i32,
        cables: &mut dyn Cables,
    ) -> Result<Next, Error> {
        let task = &self.kernel.tasks[place];
        trace::resume(task.tid, Resume::Free, signal)
            .map_err(|source| task.failure("letting it end", source))?;
        self.finish_process(task.process, None, cables)?;
        Ok(Next::Leave)
    }

    /// All threads of a process have ended or are about to; `told` is one whose end is known.
    pub(crate) fn finish_process(
        &mut self,
        process: i32,
        told: Option<(usize, Stop)>,
        cables: &mut dyn Cables,
    ) -> Result<(), Error> {
        let mut last = None;
        if let Some((place, stop)) = told {
            let task = self.kernel.tasks.remove(place);
            if task.tid == process {
                last = Some(stop);
            }
        }
        // The first thread is seen off last.
        while let Some(place) = self.kernel.tasks.iter().rposition(|task| task.process == process) {
            let stop = self.see_off(place)?;
            if self.kernel.tasks.remove(place).tid == process {
                last = Some(stop);
            }
        }
        if process == self.root {
            self.end = match last {
                Some(Stop::Death(signal)) => Some(End::Signal(signal)),
                Some(Stop::Exit(code)) => Some(End::Exit(code)),
                _ => Some(End::Signal(libc::SIGKILL)),
            };
        }
        self.kernel.timers.retain(|timer| !timer.is_of(process));
        self.kernel.has_signals = true;
        self.kernel.act();
        self.kernel.files.forget_all();
        self.kernel.recheck_futexes();
        self.kernel.close_ports(cables);
        self.take_memory_back(process)
    }

    /// Waits until a thread is no more.
    fn see_off(&mut self, place: usize) -> Result<Stop, Error> {
        loop {
            let stop = self.wait(place)?;
            if matches!(stop, Stop::Exit(_) | Stop::Death(_)) {
                return Ok(stop);
            }
            let task = &self.kernel.tasks[place];
            trace::resume(task.tid, Resume::Free, 0)
                .map_err(|source| task.failure("letting it end", source))?;
        }
    }

    /// The child that has borrowed its parent's memory runs another program, or is no more: the parent goes on.
    pub(crate) fn take_memory_back(&mut self, child: i32) -> Result<(), Error> {
        let lending = Activity::Lending { child };
        let Some(place) = self.kernel.tasks.iter().position(|task| task.activity == lending) else {
            return Ok(());
        };
        let stop = self.wait(place)?;
        let task = &mut self.kernel.tasks[place];
        task.activity = Activity::Running;
        if let Stop::Signal(signal) = stop {
            task.signal = signal;
        }
        Ok(())
    }

    /// Ends everything at once.
    pub(crate) fn kill(&mut self) {
        let mut processes: Vec<i32> = self.kernel.tasks.iter().map(|task| task.process).collect();
        processes.dedup();
        for process in processes {
            trace::signal(process, process, libc::SIGKILL);
        }
        while let Some(place) = self.kernel.tasks.len().checked_sub(1) {
            let tid = self.kernel.tasks[place].tid;
            while let Ok(stop) = trace::wait(tid) {
                if matches!(stop, Stop::Exit(_) | Stop::Death(_)) {
                    break;
                }
                let _ = trace::resume(tid, Resume::Free, 0);
            }
            self.kernel.tasks.remove(place);
        }
    }
}
