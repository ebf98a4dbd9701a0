//! Memory: the bytes of scenarios, states and snapshots. They are counted (`World::memory_bytes`) and not measured, so that what is too
//! much is refused before it is there.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError, Weak};

use baudbot_sim::Scenario;

/// The bytes that are held.
#[derive(Default)]
pub(super) struct Memory {
    held: AtomicU64,
    /// Scenarios that worlds share, by their addresses: they are counted once.
    scenarios: Mutex<HashMap<usize, Weak<ScenarioHeld>>>,
}

/// Bytes that are held until this is dropped.
pub(crate) struct Held {
    memory: Arc<Memory>,
    bytes: u64,
}

/// The bytes of a scenario, which are held as long as a world has it.
pub(crate) struct ScenarioHeld {
    scenario: Arc<Scenario>,
    held: Held,
}

impl Memory {
    /// Bytes that are held.
    pub(super) fn held(&self) -> u64 {
        self.held.load(Ordering::Relaxed)
    }

    /// Holds so many bytes more, unless that makes more than `most`.
    pub(super) fn hold(self: &Arc<Self>, bytes: u64, most: u64) -> Option<Held> {
        let more = |held: u64| held.checked_add(bytes).filter(|&sum| sum <= most);
        self.held.fetch_update(Ordering::Relaxed, Ordering::Relaxed, more).ok()?;
        Some(Held { memory: Arc::clone(self), bytes })
    }

    /// Holds the bytes of a scenario, unless another world holds them already.
    pub(super) fn hold_scenario(
        self: &Arc<Self>,
        scenario: &Arc<Scenario>,
        hold: impl FnOnce(u64) -> Result<Held, super::Exceeded>,
    ) -> Result<Arc<ScenarioHeld>, super::Exceeded> {
        let address = Arc::as_ptr(scenario).addr();
        if let Some(held) = self.scenarios().get(&address).and_then(Weak::upgrade) {
            return Ok(held);
        }
        // Two that do this at a time count it twice, and the first is found afterwards.
        let held = hold(scenario.memory_bytes() as u64)?;
        let held = Arc::new(ScenarioHeld { scenario: Arc::clone(scenario), held });
        self.scenarios().insert(address, Arc::downgrade(&held));
        Ok(held)
    }

    fn scenarios(&self) -> std::sync::MutexGuard<'_, HashMap<usize, Weak<ScenarioHeld>>> {
        self.scenarios.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Held {
    /// The number of bytes.
    pub(crate) fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Sets the number of bytes that are held, whatever the limit.
    pub(crate) fn set(&mut self, bytes: u64) {
        self.memory.held.fetch_add(bytes, Ordering::Relaxed);
        self.memory.held.fetch_sub(self.bytes, Ordering::Relaxed);
        self.bytes = bytes;
    }
}

impl Drop for Held {
    fn drop(&mut self) {
        self.memory.held.fetch_sub(self.bytes, Ordering::Relaxed);
    }
}

impl Drop for ScenarioHeld {
    fn drop(&mut self) {
        // The address is not another scenario's yet, as it is dropped after this; but it may have been counted again
        // meanwhile.
        let mut scenarios = self.held.memory.scenarios();
        let address = Arc::as_ptr(&self.scenario).addr();
        if scenarios.get(&address).is_some_and(|held| held.strong_count() == 0) {
            scenarios.remove(&address);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scenario_that_is_shared_is_counted_once_and_given_back_by_the_last() {
        let memory = Arc::new(Memory::default());
        let toml = include_str!("../../../catalogue/scenarios/wander.toml");
        let scenario = Arc::new(baudbot_scenario::parse(toml).unwrap());
        let hold =
            || memory.hold_scenario(&scenario, |bytes| Ok(memory.hold(bytes, u64::MAX).unwrap())).unwrap();
        let first = hold();
        let bytes = memory.held();
        assert!(bytes as usize > toml.len(), "{bytes}");
        let second = hold();
        assert_eq!(memory.held(), bytes);
        drop(first);
        assert_eq!(memory.held(), bytes);
        drop(second);
        assert_eq!((memory.held(), memory.scenarios().len()), (0, 0));
    }

    #[test]
    fn what_is_too_much_takes_nothing() {
        let memory = Arc::new(Memory::default());
        let mut first = memory.hold(60, 100).unwrap();
        assert!(memory.hold(41, 100).is_none() && memory.hold(u64::MAX, 100).is_none());
        assert_eq!(memory.held(), 60);
        first.set(10);
        let _second = memory.hold(90, 100).unwrap();
        drop(first);
        assert_eq!(memory.held(), 90);
    }
}
