//! The rings of timers, and the files that they make readable.

use std::path::Path;

use crate::kernel::Kernel;
use crate::os::proc::{self, mask};
use crate::os::trace;
use crate::task::Task;
use crate::timers::Owner;

impl Kernel {
    /// Files of ours are readable or not, before the kernel looks at them.
    pub(crate) fn show_flags(&mut self) {
        self.ports.iter_mut().for_each(|port| port.flag.show());
        for timer in &mut self.timers {
            if let Owner::File { flag, .. } = &mut timer.owner {
                flag.show();
            }
        }
    }

    /// Whether a descriptor of a task is a file of ours: what happens to it, the kernel does not know.
    pub(crate) fn is_ours(&self, task: usize, descriptor: i32) -> bool {
        let is_timer = |file: &Path| self.timers.iter().any(|timer| timer.rings(file).is_some());
        self.files.name(&self.tasks[task], descriptor).is_some_and(|file| is_timer(&file))
            || self.port(task, descriptor).is_some()
    }

    /// Timers that are due ring: their signals are sent, and their files can be read.
    pub(crate) fn ring(&mut self) {
        let Self { now_ns, tasks, timers, .. } = self;
        let due = timers.iter_mut().filter(|timer| timer.due_ns <= *now_ns);
        let mut has_rung = false;
        for timer in due {
            has_rung = true;
            let missed = (*now_ns - timer.due_ns).checked_div(timer.every_ns);
            match &mut timer.owner {
                Owner::Process(process) => {
                    if let Some(tid) = willing(tasks, *process, libc::SIGALRM) {
                        trace::signal(*process, tid, libc::SIGALRM);
                    }
                }
                Owner::Created { process, id, notice: Some(notice) } => {
                    let tid = notice.tid.or_else(|| willing(tasks, *process, notice.signal));
                    // One that has not been delivered yet stands for all.
                    let is_pending = |tid: i32| proc::signals(tid).pending & mask(notice.signal) != 0;
                    if let Some(tid) = tid.filter(|tid| !is_pending(*tid)) {
                        trace::signal_of_timer((*process, tid), notice.signal, (*id, notice.value));
                    }
                }
                Owner::Created { notice: None, .. } => {}
                // While its rings are not read, there is no second edge.
                Owner::File { flag, rings } => {
                    *rings += missed.unwrap_or(0) + 1;
                    flag.set(true);
                }
            }
            timer.due_ns = missed.map_or(u64::MAX, |missed| timer.due_ns + (missed + 1) * timer.every_ns);
        }
        self.has_signals |= has_rung;
    }
}

/// The first task of a process that does not block a signal, or else its first.
fn willing(tasks: &[Task], process: i32, signal: i32) -> Option<i32> {
    let own = || tasks.iter().filter(|task| task.process == process).map(|task| task.tid);
    own().find(|tid| proc::signals(*tid).blocked & mask(signal) == 0).or_else(|| own().next())
}
