//! How brains keep up, for monitoring.

use std::time::{Duration, Instant};

use super::Sessions;

/// How a brain program answered its Turns in lockstep.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Answering {
    pub(crate) answers: u64,
    /// Wall-clock time from the beginnings of the ticks to the answers, summed up.
    pub(crate) took: Duration,
}

impl Answering {
    pub(super) fn note(&mut self, took: Duration) {
        self.add(Self { answers: 1, took });
    }

    pub(super) fn add(&mut self, other: Self) {
        self.answers += other.answers;
        self.took += other.took;
    }
}

/// How it stands with a robot's brain. A program that holds several robots answers for all of them at once.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SeatMeasures {
    pub(crate) attached: bool,
    pub(crate) lost_deliveries: u64,
    pub(crate) lost_steps: u64,
    /// Turns that wait until it reads.
    pub(crate) queued_turns: usize,
    /// Turns that it has not answered, in lockstep.
    pub(crate) open_turns: usize,
    /// Since the oldest of these.
    pub(crate) oldest_open: Duration,
    pub(crate) answering: Answering,
}

impl Sessions {
    /// How it stands with the brains of the robots, in their order.
    pub(crate) fn measures(&self, now: Instant) -> impl Iterator<Item = SeatMeasures> {
        self.seats.iter().map(move |seat| {
            let mut measures = SeatMeasures {
                lost_deliveries: seat.lost_deliveries,
                lost_steps: self.lost_steps(seat),
                answering: seat.answering,
                ..SeatMeasures::default()
            };
            if let Some(session) = seat.session.and_then(|number| self.by_number.get(&number)) {
                measures.attached = true;
                measures.answering.add(session.answering);
                measures.queued_turns = session.deliveries.max_capacity() - session.deliveries.capacity();
                measures.open_turns = session.open.len();
                let oldest = session.open.front();
                measures.oldest_open =
                    oldest.map_or(Duration::ZERO, |(_, begun)| now.saturating_duration_since(*begun));
            }
            measures
        })
    }
}
