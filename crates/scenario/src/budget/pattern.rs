//! The sensors that are new in each message of a stream, and the time for which their samples wait for it.
//!
//! The microcontroller serves what fell due first, so as long as nothing is late by a whole period, its order is that
//! in which things fall due, however late they are: which sample is in which message follows from the schedules
//! alone, over one common period of them all.

use alloc::vec::Vec;

use super::plan::{Plan, Range};
use baudbot_sim::firmware::Mode;
use baudbot_sim::schedule::Schedule;

/// The parts of a stream's messages.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Pattern {
    /// Sum of the times of all reads that are new in a message, in nanoseconds.
    pub(super) reads_ns: Range,
    /// Bytes of a message on the wire.
    pub(super) bytes: Range,
    /// Mean of the longest, in bytes.
    pub(super) mean_bytes: f64,
    /// The slot of each sensor.
    pub(super) slots: Vec<Slot>,
}

/// A sensor's part in them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Slot {
    /// The time from the instant at which a read falls due to that at which the message does that it is in, in
    /// nanoseconds.
    pub(super) wait_ns: Range,
    /// Bytes of the messages that it is in.
    pub(super) bytes: Range,
}

/// Messages that are examined; schedules with a longer common period are not.
const MOST_MESSAGES: u128 = 2048;

impl Pattern {
    /// A `Pattern` of a stream, if its schedules come round soon enough. It holds as long as nothing is late by a
    /// period.
    pub(super) fn of(plan: &Plan<'_>) -> Option<Self> {
        let Mode::Stream(frame) = plan.spec.firmware.mode else { return None };
        let mut pattern = Tally::new(plan.on_wire().len());
        for k in 0..messages(plan, &frame)? {
            let due = frame.phase_ns() + k * frame.period_ns();
            let waits: Vec<_> = plan.on_wire().iter().map(|s| wait_ns(&s.schedule, due)).collect();
            let is_new = |wait: Option<u64>| wait.is_some_and(|wait| k == 0 || wait < frame.period_ns());
            let bytes = plan.readings_bytes(|i| is_new(waits[i]));
            let news = plan.on_wire().iter().zip(&waits).filter(|(_, wait)| is_new(**wait));
            let reads = news.map(|(sensor, _)| plan.read_ns(sensor));
            let reads = reads.fold(Range::default(), |sum, read| Range {
                least: sum.least + read.least,
                most: sum.most + read.most,
            });
            pattern.note(bytes, reads);
            for (i, wait) in waits.iter().enumerate() {
                if let Some(wait) = wait.filter(|_| is_new(*wait) || plan.repeats()) {
                    pattern.slot(i, wait, bytes);
                }
            }
        }
        pattern.done()
    }

    /// The pattern of a robot of which only this is known: each sensor may be in a message or not.
    pub(super) fn unknown(plan: &Plan<'_>) -> Self {
        let all = plan.readings_bytes(|_| true);
        let reads = plan.on_wire().iter().map(|sensor| plan.read_ns(sensor).most);
        let slot = |i: usize| Slot {
            wait_ns: Range { least: 0, most: u64::MAX },
            bytes: Range { least: plan.readings_bytes(|j| j == i).least, most: all.most },
        };
        let bytes = Range { least: plan.readings_bytes(|_| false).least, most: all.most };
        Self {
            reads_ns: Range { least: 0, most: reads.sum() },
            bytes,
            mean_bytes: bytes.middle() as f64,
            slots: (0..plan.on_wire().len()).map(slot).collect(),
        }
    }
}

/// The time between a sensor's last due instant before `due` and that, if there is one.
fn wait_ns(schedule: &Schedule, due: u64) -> Option<u64> {
    due.checked_sub(schedule.phase_ns()).map(|since| since % schedule.period_ns())
}

/// The number of messages until all has been seen.
fn messages(plan: &Plan<'_>, frame: &Schedule) -> Option<u64> {
    let period = u128::from(frame.period_ns());
    let sensors = || plan.on_wire().iter().map(|sensor| &sensor.schedule);
    let common = sensors().try_fold(period, |common, schedule| {
        let next = u128::from(schedule.period_ns());
        Some(common / gcd(common, next) * next).filter(|common| common / period <= MOST_MESSAGES)
    })?;
    let begun = sensors().map(|schedule| schedule.phase_ns().saturating_sub(frame.phase_ns())).max();
    let before = u128::from(begun.unwrap_or(0)).div_ceil(period);
    let all = common / period + before + 1;
    (all <= 2 * MOST_MESSAGES).then_some(all as u64)
}

pub(super) fn gcd(mut a: u128, mut b: u128) -> u128 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

/// The messages that have been seen so far.
struct Tally {
    reads_ns: Option<Range>,
    bytes: Option<Range>,
    sum: u64,
    messages: u64,
    slots: Vec<Option<Slot>>,
}

impl Tally {
    fn new(sensors: usize) -> Self {
        Self { reads_ns: None, bytes: None, sum: 0, messages: 0, slots: alloc::vec![None; sensors] }
    }

    fn note(&mut self, bytes: Range, reads_ns: Range) {
        self.bytes = Some(hull(self.bytes, bytes));
        self.reads_ns = Some(hull(self.reads_ns, reads_ns));
        self.sum += bytes.most;
        self.messages += 1;
    }

    fn slot(&mut self, i: usize, wait: u64, bytes: Range) {
        let before = self.slots[i];
        let wait_ns = hull(before.map(|slot| slot.wait_ns), Range { least: wait, most: wait });
        self.slots[i] = Some(Slot { wait_ns, bytes: hull(before.map(|slot| slot.bytes), bytes) });
    }

    fn done(self) -> Option<Pattern> {
        Some(Pattern {
            reads_ns: self.reads_ns?,
            bytes: self.bytes?,
            mean_bytes: self.sum as f64 / self.messages as f64,
            slots: self.slots.into_iter().map(Option::unwrap_or_default).collect(),
        })
    }
}

fn hull(a: Option<Range>, b: Range) -> Range {
    a.map_or(b, |a| Range { least: a.least.min(b.least), most: a.most.max(b.most) })
}
