//! Subsumption at its simplest: layers of behaviours, of which a higher one takes the motors from all below.
//!
//! Brooks's own method connects layers by suppressing and inhibiting wires between their parts. Here a layer is a whole
//! behaviour, and what it suppresses are the motors.

use super::condition::Condition;

/// Layers, the highest first.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    pub(crate) layers: Vec<(Vec<Condition>, usize)>,
    /// The behaviour that is active if no layer wants to be.
    pub(crate) base: usize,
}

impl Layers {
    /// Conditions of the layers, with the places of their behaviours, the highest first; and the behaviour of the lowest,
    /// which always wants to be active.
    pub fn new(layers: Vec<(Vec<Condition>, usize)>, base: usize) -> Self {
        Self { layers, base }
    }

    /// The highest layer all of whose conditions hold.
    pub fn step(&self, state: &[f64]) -> usize {
        let wants = |conditions: &[Condition]| conditions.iter().all(|condition| condition.holds(state));
        self.layers.iter().find(|(when, _)| wants(when)).map_or(self.base, |(_, behavior)| *behavior)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_highest_layer_that_wants_to_be_active_is() {
        let when = |text| vec![Condition::parse(text, &["near", "empty"]).unwrap()];
        let layers = Layers::new(vec![(when("near > 1"), 2), (when("empty > 1"), 1)], 0);
        assert_eq!(layers.step(&[2.0, 2.0]), 2);
        assert_eq!(layers.step(&[0.0, 2.0]), 1);
        assert_eq!(layers.step(&[0.0, 0.0]), 0);
    }
}
