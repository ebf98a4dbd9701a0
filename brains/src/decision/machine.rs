//! A finite-state machine: which behaviour is active depends on which was, and on conditions.

use super::condition::Condition;

/// Behaviours by their places, and the ways from one to another.
#[derive(Clone, Debug, PartialEq)]
pub struct Machine {
    pub(crate) active: usize,
    pub(crate) transitions: Vec<Transition>,
}

/// A way from a behaviour to another.
#[derive(Clone, Debug, PartialEq)]
pub struct Transition {
    /// The state that the transition leaves; `None`: any state.
    pub from: Option<usize>,
    /// The state that the transition enters.
    pub to: usize,
    /// All of these must hold.
    pub when: Vec<Condition>,
}

impl Machine {
    /// Begins with this behaviour.
    pub fn new(start: usize, transitions: Vec<Transition>) -> Self {
        Self { active: start, transitions }
    }

    /// One transition at most: the first whose conditions hold. Returns which behaviour is active then.
    pub fn step(&mut self, state: &[f64]) -> usize {
        let possible = self.transitions.iter().find(|transition| {
            transition.from.is_none_or(|from| from == self.active)
                && transition.to != self.active
                && transition.when.iter().all(|condition| condition.holds(state))
        });
        if let Some(transition) = possible {
            self.active = transition.to;
        }
        self.active
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_transition_that_holds_is_made_and_one_a_step() {
        let when = |text| vec![Condition::parse(text, &["z"]).unwrap()];
        let mut machine = Machine::new(
            0,
            vec![
                Transition { from: Some(0), to: 1, when: when("z > 1") },
                Transition { from: Some(1), to: 2, when: when("z > 1") },
                Transition { from: None, to: 0, when: when("z < 0") },
            ],
        );
        let course: Vec<_> = [0.5, 2.0, 2.0, 2.0, 0.5, -1.0].iter().map(|&z| machine.step(&[z])).collect();
        assert_eq!(course, [0, 1, 2, 2, 2, 0]);
    }
}
