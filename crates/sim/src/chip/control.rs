//! What a person operates on a robot's board: buttons, switches and potentiometers.

use alloc::string::String;
use alloc::vec::Vec;

use crate::time::SimTime;

/// A button, a switch or a potentiometer.
#[derive(Clone, Debug, PartialEq)]
pub struct Control {
    /// The name, such as `buttons.start`.
    pub name: String,
    /// What is done to it, in the order of the instants.
    pub operations: Vec<Operation>,
}

/// A control is brought to another position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Operation {
    /// The instant. It takes effect in the first tick that does not begin before.
    pub at: SimTime,
    /// The position: 0 of an open switch, 1 of a closed one; the share of a potentiometer's way.
    pub position: f64,
}

impl Control {
    /// Its position at an instant: at first 0.
    pub fn position(&self, now: SimTime) -> f64 {
        let done = self.operations.partition_point(|operation| operation.at <= now);
        done.checked_sub(1).map_or(0.0, |last| self.operations[last].position)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_control_stays_where_it_was_brought() {
        let at = SimTime::from_ns;
        let operations = [(10, 1.0), (20, 0.0), (20, 0.5)];
        let operations = operations.map(|(ns, position)| Operation { at: at(ns), position }).into();
        let control = Control { name: "potentiometers.speed".into(), operations };
        let positions = [0, 9, 10, 19, 20, 99].map(|ns| control.position(at(ns)));
        assert_eq!(positions, [0.0, 0.0, 1.0, 1.0, 0.5, 0.5]);
    }
}
