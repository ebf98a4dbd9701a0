//! A ledger of scores, so that an optimizer can be asked for its next candidates: it is run from its beginning, and gets the
//! scores that were found before.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The costs that are known, in the order in which the optimizer asks for them, and the points for which it asked beyond those.
#[derive(Clone, Debug)]
pub(super) struct Ledger(Arc<Mutex<Pages>>);

#[derive(Debug)]
struct Pages {
    known: Vec<f64>,
    read: usize,
    asked: Vec<Vec<f64>>,
}

impl Ledger {
    /// A `Ledger` with the costs of all earlier generations.
    pub(super) fn new(past: &[Vec<f64>]) -> Self {
        let known = past.concat();
        Self(Arc::new(Mutex::new(Pages { known, read: 0, asked: Vec::new() })))
    }

    /// The cost of the next point. The cost of a new one is unknown, and the number for it does not matter: the
    /// optimizer is run no further than the end of that generation.
    pub(super) fn cost(&self, point: &[f64]) -> f64 {
        let mut pages = self.pages();
        let place = pages.read;
        pages.read += 1;
        if let Some(cost) = pages.known.get(place) {
            return *cost;
        }
        pages.asked.push(point.to_vec());
        0.0
    }

    /// The points that were new.
    pub(super) fn into_asked(self) -> Vec<Vec<f64>> {
        std::mem::take(&mut self.pages().asked)
    }

    fn pages(&self) -> MutexGuard<'_, Pages> {
        // The ledger is never left in an invalid state.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
