//! Looks at clocks that a task makes by our code in its own process: how many are left to it, and how many it has made. Each counts as
//! one that stops it does; a task for which the next one has a price stops.

use crate::error::Error;
use crate::kernel::{EPOCH_NS, Kernel, Page, UPTIME_NS};
use crate::os::{clocks, memory};

impl Kernel {
    /// Before a task goes on: the instant, and the looks that it may make unseen.
    ///
    /// # Errors
    ///
    /// If its memory cannot be written, so that it would see an instant that is over.
    pub(crate) fn write_page(&mut self, task: usize) -> Result<(), Error> {
        let caller = &self.tasks[task];
        let Some(place) = caller.page else { return Ok(()) };
        let looks = if caller.has_waited(self.now_ns) { 0 } else { caller.looks };
        let looks_left = i64::try_from(self.price.free_looks.saturating_sub(looks)).unwrap_or(i64::MAX);
        let page = Page { task: caller.number, now_ns: self.now_ns, looks_left };
        // Without looks it is not read, whatever the instant.
        let is_same =
            |old: Page| old == page || (old.task == page.task && old.looks_left == 0 && looks_left == 0);
        if !self.page.is_some_and(is_same) {
            let bytes = clocks::page(looks_left, EPOCH_NS + self.now_ns, UPTIME_NS + self.now_ns);
            self.page = Some(page);
            match memory::write(caller.tid, place, &bytes) {
                // A task that has been killed meanwhile has no memory.
                Err(error) if error.raw_os_error() == Some(libc::ESRCH) => self.page = None,
                other => other.map_err(|source| caller.failure("telling it the time", source))?,
            }
        }
        Ok(())
    }

    /// At its next stop: the looks that it has made since.
    pub(crate) fn count_looks(&mut self, task: usize) {
        let caller = &mut self.tasks[task];
        let (Some(place), Some(page)) = (caller.page, &mut self.page) else { return };
        if page.looks_left == 0 {
            return;
        }
        let Ok(looks_left) = caller.read_u64(place) else { return };
        let made = page.looks_left - looks_left.cast_signed();
        page.looks_left = looks_left.cast_signed();
        if made > 0 {
            caller.begin_call(self.now_ns);
            caller.looks += made.unsigned_abs();
        }
    }
}
