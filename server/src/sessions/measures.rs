//! The measures of brains' pace: for monitoring and for operators.

use std::time::{Duration, Instant};

use super::Sessions;
use super::session::Session;
use super::slot::Slot;
use crate::measures::SlotMeasures;
use crate::report::SlotReport;

impl Sessions {
    /// The numbers of the robots' slots, in the order of the robots.
    pub(crate) fn measures(&self, now: Instant) -> impl Iterator<Item = SlotMeasures> {
        self.slots.iter().map(move |slot| {
            let mut measures = SlotMeasures {
                lost_deliveries: slot.lost_deliveries,
                lost_steps: self.lost_steps(slot),
                answering: slot.answering,
                ..SlotMeasures::default()
            };
            if let Some(session) = self.session_of(slot) {
                measures.attached = true;
                measures.answering.add(session.answering);
                measures.queued_turns = session.recipient.waiting();
                measures.open_turns = session.debt.count();
                let oldest = session.debt.oldest();
                measures.oldest_open =
                    oldest.map_or(Duration::ZERO, |turn| now.saturating_duration_since(turn.begun));
            }
            measures
        })
    }

    /// The reports of the robots' slots, in the order of the robots. `said` has the last beliefs of their brains.
    pub(crate) fn reports(&self, said: Vec<String>) -> Vec<SlotReport> {
        let slots = self.slots.iter().zip(said);
        slots
            .map(|(slot, said)| SlotReport {
                brain: self.session_of(slot).map(|session| session.brain.clone()),
                lost_deliveries: slot.lost_deliveries,
                lost_steps: self.lost_steps(slot),
                said,
                thought: slot.thought.clone(),
            })
            .collect()
    }

    fn session_of(&self, slot: &Slot) -> Option<&Session> {
        self.by_number.get(&slot.session()?)
    }
}
