//! The motivational state, with its lethal boundaries, that a brain of processes publishes: Wahde 2016, §4.4.4 and Fig. 7.2.
//!
//! The physiological state is a point in the space of the internal variables; with what the brain senses, the perceptual state, it is a
//! point in the motivational space. There the tendency to a behaviour is c (Σ w z + b), the argument of (8.4) without Γ, and its isoclines
//! are where that is constant.
//!
//! A brain without internal variables and reservoirs publishes none of it.

use baudbot_brain::{Motivation, StateVariable, Tendency};

use super::{Composed, Decision, Motor};
use crate::decision::Hydraulic;

impl Composed {
    /// The motivational state now; `None` if nothing of it is internal, or a number of it ran over.
    pub(super) fn motivation(&self) -> Option<Motivation> {
        let (hydraulic, follows_utilities) = match &self.decision {
            Decision::Hydraulic(hydraulic) => (Some(hydraulic), false),
            Decision::Utility { .. } | Decision::Cooperative(_) => (None, true),
            Decision::Machine(_) | Decision::Layers(_) | Decision::Tree(_) => (None, false),
        };
        if self.internal.values().is_empty() && hydraulic.is_none() {
            return None;
        }
        let tendencies = if follows_utilities { self.tendencies() } else { Vec::new() };
        let variables = self.variables(hydraulic);
        // A number that ran over has no place in a space, and the server takes none.
        variables
            .iter()
            .all(|variable| variable.value.is_finite())
            .then_some(Motivation { variables, tendencies })
    }

    /// What is sensed, what is internal, and the energies of reservoirs.
    fn variables(&self, hydraulic: Option<&Hydraulic>) -> Vec<StateVariable> {
        let mut values = self.senses.values().to_vec();
        self.internal.extend(&mut values);
        let sensed = self.senses.names().map(|name| variable(name.to_owned(), false, [None; 2]));
        let internal = self.internal.variables.iter();
        let internal = internal.map(|own| variable(own.name.clone(), true, own.lethal));
        let mut variables: Vec<_> = sensed.chain(internal).collect();
        for (variable, value) in variables.iter_mut().zip(values) {
            variable.value = value;
        }
        for reservoir in hydraulic.into_iter().flat_map(|hydraulic| &hydraulic.reservoirs) {
            let name = format!("energy of {}", self.motors[reservoir.behavior].name);
            variables.push(StateVariable { value: reservoir.energy, ..variable(name, true, [None; 2]) });
        }
        variables
    }

    /// The tendencies to the motor behaviours.
    fn tendencies(&self) -> Vec<Tendency> {
        let count = self.senses.values().len() + self.internal.values().len();
        let tendency = |motor: &Motor| {
            let function = motor.utility.function();
            let mut weights: Vec<_> = function.weights.iter().map(|weight| function.slope * weight).collect();
            weights.resize(if weights.is_empty() { 0 } else { count }, 0.0);
            Tendency { name: motor.name.clone(), bias: function.slope * function.bias, weights }
        };
        self.motors.iter().map(tendency).collect()
    }
}

fn variable(name: String, internal: bool, lethal: [Option<f64>; 2]) -> StateVariable {
    StateVariable { name, value: 0.0, internal, lethal }
}
