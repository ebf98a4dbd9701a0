//! The actor as the runner of its mailbox: what is done on a thread of the pool, and what inline, by a caller.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

use tonic::Status;

use super::{Next, WorldActor};
use crate::clock;
use crate::mailbox::Runner;
use crate::message::{Message, Request};
use crate::pace::Pace;
use crate::pool::{Place, Then};
use crate::report::Activity;

/// Messages that are handled at a time, so that a flood of them does not hold up the clock.
const MAX_MESSAGES_AT_ONCE: usize = 100;

/// The longest time for which a caller runs a world before the pool takes over. Other connections wait meanwhile.
const MAX_INLINE: Duration = Duration::from_micros(500);

/// The same in rounds: more than fit into that time, unless the clock stands.
const MOST_INLINE: usize = 1000;

/// Ticks that take less are run inline; of several worlds on a server, those that take their share of it. All callers from the
/// network are on one thread, and long ticks are better done on several.
const QUICK: Duration = Duration::from_micros(500);

/// A tick that takes less is not worth waking a thread so that the world goes ahead of its brains.
const WORTH_GOING_AHEAD: Duration = Duration::from_micros(20);

/// Ticks that take longer are not for threads that other worlds wait for.
const LONG: Duration = Duration::from_millis(10);

/// The figures that decide on which thread the world runs.
pub(super) struct Schedule {
    /// The duration of a tick, averaged over the last ones and without the wait for brains; `None` before the first.
    tick_takes: Option<Duration>,
    /// The duration of the present tick's beginning.
    begin_took: Duration,
    /// The instant at which the pool runs the world without a message.
    alarm: Option<Instant>,
    /// A message that was left to a thread of the world's own, since it may wait for a disk.
    slow: Option<Message>,
    /// The number of worlds on this server.
    neighbours: Arc<AtomicU32>,
}

impl Schedule {
    pub(super) fn new(neighbours: Arc<AtomicU32>) -> Self {
        Self { tick_takes: None, begin_took: Duration::ZERO, alarm: None, slow: None, neighbours }
    }

    /// A tick has begun, which took so long.
    pub(super) fn note_begin(&mut self, took: Duration) {
        self.begin_took = took;
    }

    /// The tick has ended, which took so long.
    pub(super) fn note_finish(&mut self, took: Duration) {
        let took = self.begin_took + took;
        self.tick_takes = Some(self.tick_takes.map_or(took, |takes| (takes * 7 + took) / 8));
    }

    /// The duration of a tick; `None` before the first.
    pub(super) fn tick_takes(&self) -> Option<Duration> {
        self.tick_takes
    }

    /// Whether a tick takes less than waking a thread for it would cost all worlds of the server.
    fn is_quick(&self) -> bool {
        let limit = QUICK / self.neighbours.load(Ordering::Relaxed).max(1);
        self.tick_takes.is_some_and(|takes| takes < limit)
    }

    fn is_long(&self) -> bool {
        self.tick_takes > Some(LONG)
    }

    /// There is nothing to do before this instant. Returns the instruction to the pool.
    fn wait(&mut self, until: Option<Instant>) -> Then {
        let is_known = until.is_none_or(|until| self.alarm.is_some_and(|alarm| alarm <= until));
        if is_known {
            return Then::Wait(None);
        }
        self.alarm = until;
        Then::Wait(until)
    }
}

impl Runner<Message> for WorldActor {
    fn run(&mut self, place: Place, take: &mut dyn FnMut() -> Option<Message>) -> Then {
        // The pool has forgotten the alarm by running the world.
        self.schedule.alarm = None;
        let is_handled = self.handle_all(place, take);
        if !is_handled || (place != Place::Own && self.may_block()) {
            return Then::RunApart;
        }
        if let Some(why) = self.over.take() {
            self.end_recording();
            self.close_state();
            self.sessions.close_all(&why);
            return Then::Over;
        }
        let now = clock::now();
        if self.state.until(None).is_some_and(|retry| now >= retry) {
            self.keep_now();
        }
        if self.halts.are_late(now) {
            self.answer_halts_at_last();
        }
        self.pacer.running.set(self.activity() == Activity::Running, now);
        let next = self.next(now);
        if let Next::Wait(until) = next {
            return self.wait(until);
        }
        if place == Place::Shared && self.schedule.is_long() {
            return Then::RunLong;
        }
        self.do_next(next, now);
        if place == Place::Long && self.schedule.is_long() {
            return Then::RunLong;
        }
        // The pool owes a world that lags no more than to one that is due now.
        Then::Run(matches!(self.pacer.pace, Pace::Timed(_)).then_some(now))
    }

    fn run_inline(&mut self, take: &mut dyn FnMut() -> Option<Message>) -> Then {
        let (mut begun, mut rounds) = (None, 0);
        loop {
            if !self.handle_all(Place::Shared, take) || self.over.is_some() {
                return Then::Run(None);
            }
            let now = clock::now();
            rounds += 1;
            let is_patient = rounds < MOST_INLINE && now - *begun.get_or_insert(now) < MAX_INLINE;
            self.pacer.running.set(self.activity() == Activity::Running, now);
            if let Some(then) = self.run_quick(now, is_patient) {
                return then;
            }
        }
    }

    fn close(&mut self) {
        // A world that ends as it should has closed all streams already.
        let text = format!("world `{}` has ended with a panic; the server's log has details", self.name);
        self.sessions.close_all(&Status::internal(text));
    }
}

impl WorldActor {
    /// Handles messages, and waits for the disk if it has to; `false` if something may block, and this is not the place for it.
    fn handle_all(&mut self, place: Place, take: &mut dyn FnMut() -> Option<Message>) -> bool {
        if place == Place::Own {
            self.recording.wait_for_disk();
            if let Some(message) = self.schedule.slow.take() {
                self.handle(message);
            }
        }
        if self.schedule.slow.is_some() {
            return false;
        }
        for _ in 0..MAX_MESSAGES_AT_ONCE {
            match take() {
                // A thread that others wait for waits for no disk, and for no long state to be read.
                Some(message) if place != Place::Own && self.is_slow(&message) => {
                    self.schedule.slow = Some(message);
                    return false;
                }
                Some(message) => self.handle(message),
                None => break,
            }
        }
        true
    }

    /// Whether the next thing may wait for a disk.
    fn may_block(&self) -> bool {
        self.recording.is_stuck() || (self.over.is_some() && (self.recording.is_on() || self.state.is_kept()))
    }

    /// Nothing is to be done before this instant, but for what could not be written.
    fn wait(&mut self, until: Option<Instant>) -> Then {
        let until = self.halts.until(self.state.until(until));
        self.schedule.wait(until)
    }

    fn do_next(&mut self, next: Next, now: Instant) {
        match next {
            Next::Begin => self.begin(now),
            Next::Finish => self.finish_with(now, &[]),
            Next::FinishAhead(_) => self.finish_ahead(now),
            Next::End => self.end(),
            Next::TimeOut => self.time_out(),
            Next::Replay => self.replay(now),
            Next::Wait(_) => {}
        }
    }

    /// Does one thing, if it does not take long; otherwise returns the instruction to the pool.
    fn run_quick(&mut self, now: Instant, is_patient: bool) -> Option<Then> {
        let is_timed = matches!(self.pacer.pace, Pace::Timed(_));
        match self.next(now) {
            Next::Wait(until) => return Some(self.wait(until)),
            Next::Begin if self.is_quick() && is_patient => self.begin(now),
            Next::Finish if self.is_quick() => self.finish_with(now, &[]),
            // The Turn has to go out first, and if ticks are short the answer is here before one could be done.
            Next::FinishAhead(until) if self.schedule.tick_takes < Some(WORTH_GOING_AHEAD) => {
                return Some(self.schedule.wait(Some(until)));
            }
            Next::Begin | Next::Finish | Next::FinishAhead(_) | Next::End | Next::TimeOut | Next::Replay => {
                return Some(Then::Run(is_timed.then_some(now)));
            }
        }
        None
    }

    /// Whether a tick may be run inline. [`OnTick`](super::OnTick) may take any time, and so may a disk.
    fn is_quick(&self) -> bool {
        let waits = self.pacer.pace.watchdog().is_some();
        waits && self.on_tick.is_none() && !self.recording.is_stuck() && self.schedule.is_quick()
    }

    /// Whether the work of a message may take long.
    fn is_slow(&self, message: &Message) -> bool {
        let Message::Request(request, _) = message else { return false };
        match request {
            Request::Record(_) | Request::StopRecording(_) | Request::Seek { .. } => true,
            Request::Reset(_) | Request::Restore { .. } | Request::Delete => {
                self.recording.is_on() || self.state.needs_disk()
            }
            Request::Snapshot | Request::Fork(_) => self.state.needs_disk(),
            Request::Report
            | Request::Start
            | Request::Pause
            | Request::Step { .. }
            | Request::SetPace(_)
            | Request::Save { .. }
            | Request::Intervene(_)
            | Request::DetachBrain { .. } => false,
        }
    }
}
