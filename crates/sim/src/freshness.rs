//! The age of a sensor's readings when its brain gets them.

use serde::{Deserialize, Serialize};

use crate::histogram::Histogram;
use crate::time::SimTime;

/// The age of one sensor's readings when the brain got them.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Freshness {
    /// Steps of the brain in which the sensor was readable.
    pub readable: u64,
    /// The true ages of those readings whose age is known: all but those of a bare message that bytes were lost
    /// around.
    pub ages: Histogram,
}

impl Freshness {
    /// The brain gets a new reading, which was truly sampled then if that is known.
    pub(crate) fn note(&mut self, at: SimTime, sampled_at: Option<SimTime>) {
        self.readable += 1;
        if let Some(sampled_at) = sampled_at {
            self.ages.note(at.since(sampled_at));
        }
    }
}
