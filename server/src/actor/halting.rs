//! Replies to those who have made the world stand: it stands by then.

use std::time::{Duration, Instant};

use super::{Phase, WorldActor};
use crate::clock;
use crate::message::Reply;
use crate::report::Report;

/// The callers that have made the world stand, and get an answer when it does.
#[derive(Default)]
pub(super) struct Halts {
    replies: Vec<Reply<Report>>,
    /// The instant at which they get their answer in any case.
    until: Option<Instant>,
}

/// The time for which they wait for a brain that keeps the tick open.
const PATIENCE: Duration = Duration::from_secs(1);

impl Halts {
    /// The instant at which there is something to be done, if it is before `until`.
    pub(super) fn until(&self, until: Option<Instant>) -> Option<Instant> {
        self.until.into_iter().chain(until).min()
    }

    /// Whether they have waited for long enough.
    pub(super) fn are_late(&self, now: Instant) -> bool {
        self.until.is_some_and(|until| now >= until)
    }
}

impl WorldActor {
    /// Replies when the world stands, if it is to: at the end of the tick that has begun, so that nothing happens after the reply.
    pub(super) fn halted(&mut self, reply: Reply<Report>) {
        self.halts.replies.push(reply);
        self.halts.until.get_or_insert_with(|| clock::now() + PATIENCE);
        self.answer_halts();
    }

    /// Replies to those who have made the world stand, once it does or goes on again. A brain that has left the tick unanswered may never
    /// come back, and is no reason to wait.
    pub(super) fn answer_halts(&mut self) {
        let is_moving = self.phase != Phase::Between && !self.sessions.is_any_left_open();
        if is_moving && (self.pacer.paused || self.is_out_of_credit()) {
            return;
        }
        if self.stepper.credits == 0 {
            self.answer_stepper();
        }
        self.answer_halts_at_last();
    }

    /// Replies to them, however the world is.
    pub(super) fn answer_halts_at_last(&mut self) {
        self.halts.until = None;
        let replies = std::mem::take(&mut self.halts.replies);
        if replies.is_empty() {
            return;
        }
        self.keep_now();
        for reply in replies {
            drop(reply.send(Ok(self.report(0))));
        }
    }
}
