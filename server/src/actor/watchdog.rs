//! The watchdog: what becomes of brains that do not answer in time.

use tonic::Status;

use super::WorldActor;
use crate::clock;
use crate::log::event;
use crate::pace::WatchdogPolicy;

impl WorldActor {
    /// The watchdog acts on every brain that has not answered in time.
    pub(super) fn time_out(&mut self) {
        let Some(watchdog) = self.pacer.pace.watchdog() else { return };
        let timeout = watchdog.timeout;
        self.changes += 1;
        let now = clock::now();
        self.pacer.note_wait(now);
        self.pacer.wait_from(now);
        for number in self.sessions.owing().collect::<Vec<_>>() {
            self.pacer.statistics.watchdog_timeouts += 1;
            event!(self, warn, session = number, brain = self.sessions.name(number),
                timeout_s = timeout.as_secs_f64(), policy = ?watchdog.policy, "brain has not answered in time");
            match watchdog.policy {
                WatchdogPolicy::Wait => {}
                WatchdogPolicy::GoOn => {
                    let overtaken = self.sessions.give_up(number);
                    self.settle(&overtaken.steps);
                    self.deliver_deferred(number, overtaken.deferred);
                }
                WatchdogPolicy::Detach => {
                    let status = Status::deadline_exceeded(format!("no answer to a Turn within {timeout:?}"));
                    self.close(number, status);
                }
            }
        }
        self.handle_deferred_at_last();
    }
}
